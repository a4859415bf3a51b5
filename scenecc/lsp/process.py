"""The client of the compile process: one request at a time; a newer request can abort a stale one."""

from __future__ import annotations

import asyncio
import os
import pickle
import sys
import time
from contextlib import suppress
from typing import Any

from scenecc.lsp import worker


class WorkerStopped(Exception):
    """The process ended before it answered: it was stopped, or `crashed`."""

    def __init__(self, *, crashed: bool) -> None:
        super().__init__("the process that compiles scenes ended")
        self.crashed = crashed


class FaultError(Exception):
    """A request failed because of a bug in scenecc. The message is the traceback."""


class AnalysisProcess:
    """A process, started by the first request, and again after a stop."""

    def __init__(self) -> None:
        self._process: asyncio.subprocess.Process | None = None
        self._lock = asyncio.Lock()
        self._since: float | None = None
        self._stopped = False

    async def ask(self, request: Any) -> Any:
        """Returns the answer to a request of `scenecc.lsp.worker`, after all earlier ones.

        Raises:
            WorkerStopped: there is no answer.
            FaultError: scenecc has a bug.
        """
        await self._lock.acquire()
        # A request whose caller is cancelled goes on: its late answer would be taken for that to the next request.
        task = asyncio.create_task(self._exchange_once(request))
        task.add_done_callback(lambda ended: ended.cancelled() or ended.exception())
        answer = await asyncio.shield(task)
        if isinstance(answer, worker.Fault):
            raise FaultError(answer.report)
        return answer

    async def _exchange_once(self, request: Any) -> Any:
        """Returns the answer to a request, and then lets the next one start."""
        is_new = self._process is None
        try:
            return await self._answer(request)
        except WorkerStopped as end:
            if is_new or not end.crashed:
                raise
            # It may have crashed earlier.
            return await self._answer(request)
        finally:
            self._lock.release()

    async def _answer(self, request: Any) -> Any:
        process = await self._start()
        self._since = time.monotonic()
        try:
            return await _exchange(process, worker.encode_message(request))
        except (OSError, asyncio.IncompleteReadError):
            await self._end(process)
            raise WorkerStopped(crashed=not self._stopped) from None
        finally:
            self._since = None

    def stop_older(self, seconds: float) -> None:
        """Stops the process if its current request has taken longer than that."""
        if self._since is not None and time.monotonic() - self._since > seconds:
            self.stop()

    def stop(self) -> None:
        """Stops the process at once."""
        self._stopped = True
        if self._process is not None:
            with suppress(ProcessLookupError):
                self._process.kill()

    async def _start(self) -> asyncio.subprocess.Process:
        if self._process is None or self._process.returncode is not None:
            pipe = asyncio.subprocess.PIPE
            # With this process's path: nothing is imported from the current folder that this process would not import.
            start = f"import sys; sys.path[:] = {sys.path!r}; from scenecc.lsp.worker import main; main()"
            self._process = await asyncio.create_subprocess_exec(
                sys.executable, "-I", "-c", start, str(os.getpid()),
                stdin=pipe, stdout=pipe, stderr=asyncio.subprocess.DEVNULL, start_new_session=True,
            )  # fmt: skip
        self._stopped = False
        return self._process

    async def _end(self, process: asyncio.subprocess.Process) -> None:
        with suppress(ProcessLookupError):
            process.kill()
        await process.wait()
        self._process = None


async def _exchange(process: asyncio.subprocess.Process, data: bytes) -> Any:
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(data)
    await process.stdin.drain()
    header = await process.stdout.readexactly(worker.HEADER_BYTES)
    body = await process.stdout.readexactly(worker.decode_length(header))
    return await asyncio.to_thread(pickle.loads, body)
