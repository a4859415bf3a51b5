"""Worker processes in which libraries read untrusted files, with limits of memory and time.

A worker lives as long as this process, because importing a library takes longer than reading most files. It is killed
when a request takes too long, and restarted for the next one.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import selectors
import subprocess
import sys
import threading
import time
from typing import Any

from scenecc import worker_process

MAX_ANSWER = 2**30
"""Maximum size of an answer [bytes]."""


class WorkerError(Exception):
    """The process ended, or was killed because a request took too long. The message says which."""


class Worker:
    """A process that answers requests.

    Args:
        module: module whose `prepare` returns the function that answers; see `scenecc.worker_process`.
        memory: limit of the process's address space [bytes].
        seconds: time limit of one request.
        name: name of the library, for messages.
        opens_files: whether the library may open files; otherwise the request carries all data.
    """

    def __init__(self, module: str, *, memory: int, seconds: float, name: str, opens_files: bool = False) -> None:
        self._arguments = {"module": module, "memory": memory, "opens_files": opens_files}
        self._seconds = seconds
        self._name = name
        self._process: subprocess.Popen[bytes] | None = None
        self._inherited: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        atexit.register(self.stop)
        os.register_at_fork(after_in_child=self._forget)

    def ask(self, header: dict[str, Any], parts: list[bytes]) -> worker_process.Message:
        """Returns the answer to a request. Raises WorkerError."""
        with self._lock:
            return self._ask(header, parts)

    def _ask(self, header: dict[str, Any], parts: list[bytes]) -> worker_process.Message:
        fresh = self._process is None or self._process.poll() is not None
        if fresh:
            self.stop()
            self._start()
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        # A separate thread writes, because the process may end before it has read everything.
        writer = threading.Thread(target=_send, args=(process.stdin, header, parts), daemon=True)
        writer.start()
        try:
            stream = _TimedStream(process.stdout.fileno(), self._name, self._seconds)
            answer = worker_process.read_message(stream)  # pyright: ignore[reportArgumentType] - it reads, which is enough
        except (LookupError, OSError, RecursionError, TypeError, ValueError) as error:
            # A malicious file may have overwritten the process's memory.
            self.stop()
            raise WorkerError(f"the answer of {self._name} cannot be read") from error
        except BaseException:
            self.stop()
            raise
        if answer is None:
            self.stop()
            if not fresh:
                # The process ends with the thread that started it, which may be another one.
                return self._ask(header, parts)
            raise WorkerError(f"{self._name} ended: the file needs too much memory, or crashes the library")
        return answer

    def _start(self) -> None:
        arguments = json.dumps(self._arguments | {"parent": os.getpid(), "path": sys.path})
        # Isolated, with this process's path: nothing is imported from the current folder that this process would not
        # import.
        command = [sys.executable, "-I", worker_process.__file__, arguments]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(  # noqa: S603 - a constant command
            command, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, start_new_session=True
        )

    def stop(self) -> None:
        """Ends the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def _forget(self) -> None:
        """Drops the process without ending it, because it belongs to the process that this one was forked from."""
        if self._process is not None:
            self._process.returncode = 0
        # Keep it: closing its pipe would send what another thread has begun to write.
        self._inherited, self._process, self._lock = self._process, None, threading.Lock()


def _send(stream: Any, header: dict[str, Any], parts: list[bytes]) -> None:
    # If the process has ended, the reader of its answer also finds that.
    with contextlib.suppress(OSError):
        worker_process.write_message(stream, header, parts)


class _TimedStream:
    """Reads a pipe with a time limit."""

    def __init__(self, pipe: int, name: str, seconds: float) -> None:
        self._pipe = pipe
        self._name = name
        self._seconds = seconds
        self._deadline = time.monotonic() + seconds
        self._left = MAX_ANSWER

    def read(self, size: int) -> bytes:
        """Reads `size` bytes, fewer at the end of the stream. Raises WorkerError."""
        parts: list[bytes] = []
        self._left -= size
        if self._left < 0:
            raise WorkerError(f"the answer of {self._name} has more than {MAX_ANSWER} bytes")
        with selectors.DefaultSelector() as selector:
            selector.register(self._pipe, selectors.EVENT_READ)
            while size:
                left = self._deadline - time.monotonic()
                if left <= 0 or not selector.select(left):
                    raise WorkerError(f"{self._name} took more than {self._seconds:g} s")
                part = os.read(self._pipe, min(size, 2**20))
                if not part:
                    break
                parts.append(part)
                size -= len(part)
        return b"".join(parts)
