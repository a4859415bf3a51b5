"""The client of the process in which MuJoCo compiles models.

One process serves this one for as long as it lives: importing MuJoCo takes longer than compiling most robots. It is
killed when a model takes too long, and started again for the next.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib.metadata
import json
import os
import re
import selectors
import subprocess
import sys
import threading
import time
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenecc.extras import install_hint
from scenecc.robots.mujoco import worker
from scenecc.robots.mujoco.model import CompiledModel

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.mjcf_files import MjcfReport
    from scenecc.robots.mujoco.source import MujocoSource

OLDEST, BEYOND = (3, 5), (5, 0)
"""Versions of MuJoCo with which this is tested: from, and below."""

INSTALL_HINT = install_hint("mjcf")

_MEMORY = 4 * 2**30
"""Address space of the process [bytes]."""

_MOST_ANSWERED = 2**30
"""The largest compiled model that is taken [bytes]."""

_SECONDS = 60.0
"""Longest time for one model."""

MAX_NUMBER = 1e12
"""The largest number of a model: so the product of three is one of single precision."""

_MOST_KEPT = 8
"""Compiled models that are kept: a scene is often validated and then built."""

_MOST_KEPT_BYTES = 2**28
"""All of them together, but for the last [bytes]."""

_LINE = re.compile(r"line (\d+)")


class _Died(Exception):
    """The process ended, or was killed because the model took too long. Its text says which."""


class _Compiler:
    """A running process."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._inherited: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._kept: dict[bytes, tuple[dict[str, Any], list[bytes]]] = {}

    def compile(self, xml: bytes, assets: dict[str, bytes]) -> tuple[dict[str, Any], list[bytes]]:
        """The answer of `worker.compile_model`. Raises _Died."""
        key = _digest(xml, assets)
        with self._lock:
            if key not in self._kept:
                answer = self._ask(xml, assets)
                while self._kept and (len(self._kept) >= _MOST_KEPT or self._kept_bytes() > _MOST_KEPT_BYTES):
                    del self._kept[next(iter(self._kept))]
                self._kept[key] = answer
            return self._kept[key]

    def _kept_bytes(self) -> int:
        return sum(len(part) for _, parts in self._kept.values() for part in parts)

    def _ask(self, xml: bytes, assets: dict[str, bytes]) -> tuple[dict[str, Any], list[bytes]]:
        fresh = self._process is None or self._process.poll() is not None
        if fresh:
            self.stop()
            self._start()
        process = self._process
        assert process is not None
        assert process.stdin is not None
        assert process.stdout is not None
        # A writer of its own: the process may end before it has read everything.
        writer = threading.Thread(target=_send, args=(process.stdin, xml, assets), daemon=True)
        writer.start()
        try:
            stream = _TimedStream(process.stdout.fileno(), time.monotonic() + _SECONDS)
            answer = worker.read_message(stream)  # pyright: ignore[reportArgumentType] - it reads, which is enough
        except BaseException:
            self.stop()
            raise
        if answer is None:
            self.stop()
            if not fresh:
                # It ends with the thread that started it, which may be another one.
                return self._ask(xml, assets)
            raise _Died("MuJoCo's compiler ended: the model needs too much memory, or crashes it")
        return answer

    def _start(self) -> None:
        arguments = json.dumps({"parent": os.getpid(), "memory": _MEMORY, "path": sys.path})
        # Isolated, with this process's path: nothing of the current folder is imported that this one would not import.
        command = [sys.executable, "-I", worker.__file__, arguments]
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

    def forget(self) -> None:
        """Leaves the process to the one that this one was forked from."""
        if self._process is not None:
            self._process.returncode = 0
        # Kept, for closing its pipe would send what another thread has begun to write.
        self._inherited, self._process, self._lock = self._process, None, threading.Lock()


def _send(stream: Any, xml: bytes, assets: dict[str, bytes]) -> None:
    # Where the process has ended, the reader of its answer finds it too.
    with contextlib.suppress(OSError):
        worker.write_message(stream, {"names": list(assets)}, [xml, *assets.values()])


class _TimedStream:
    """Reads a pipe until a deadline."""

    def __init__(self, pipe: int, deadline: float) -> None:
        self._pipe = pipe
        self._deadline = deadline
        self._left = _MOST_ANSWERED

    def read(self, size: int) -> bytes:
        """So many bytes, fewer at the end of the stream. Raises _Died."""
        parts: list[bytes] = []
        self._left -= size
        if self._left < 0:
            raise _Died(f"the compiled model has more than {_MOST_ANSWERED} bytes")
        with selectors.DefaultSelector() as selector:
            selector.register(self._pipe, selectors.EVENT_READ)
            while size:
                left = self._deadline - time.monotonic()
                if left <= 0 or not selector.select(left):
                    raise _Died(f"MuJoCo's compiler takes more than {_SECONDS:g} s")
                part = os.read(self._pipe, min(size, 2**20))
                if not part:
                    break
                parts.append(part)
                size -= len(part)
        return b"".join(parts)


_COMPILER = _Compiler()
atexit.register(_COMPILER.stop)
os.register_at_fork(after_in_child=_COMPILER.forget)


def _digest(xml: bytes, assets: dict[str, bytes]) -> bytes:
    import hashlib  # noqa: PLC0415 - loaded where there is a model

    state = hashlib.sha256(f"{mujoco_version()} {len(xml)} ".encode() + xml)
    for name, data in assets.items():
        state.update(f" {name} {len(data)} ".encode() + data)
    return state.digest()


@lru_cache
def mujoco_version() -> str | None:
    """The version of MuJoCo that is installed; None: there is none."""
    # A folder `mujoco` beside a script can be imported too, and has no version.
    try:
        return importlib.metadata.version("mujoco")
    except importlib.metadata.PackageNotFoundError:
        return None


def check_mujoco(report: MjcfReport, location: Location) -> bool:
    """Whether MuJoCo can be used; otherwise that is an error (SC457)."""
    version = mujoco_version()
    if version is None:
        report.error("SC457", "an MJCF is read by MuJoCo, which is not installed", location, INSTALL_HINT)
        return False
    numbers = tuple(int(part) for part in re.findall(r"\d+", version)[:2])
    if not OLDEST <= numbers < BEYOND:
        wanted = f"from {'.'.join(map(str, OLDEST))} and below {'.'.join(map(str, BEYOND))}"
        report.error("SC457", f"MuJoCo {version} is installed, and {wanted} is needed", location, INSTALL_HINT)
        return False
    return True


def compile_source(source: MujocoSource, report: MjcfReport) -> CompiledModel | None:
    """The compiled model; None after an error: SC458 (it takes too much), SC481 (MuJoCo refuses it)."""
    root = source.elements[0].location
    try:
        header, parts = _COMPILER.compile(source.text.encode(), source.assets)
    except _Died as died:
        report.error("SC458", str(died), root)
        return None
    if "error" in header:
        message = str(header["error"])
        found = _LINE.search(message)
        element = source.element(int(found[1])) if found else None
        report.error("SC481", _readable(message, source), element.location if element else root)
        return None
    model = CompiledModel.of(header, parts, source)
    return model if _is_bounded(model, report) else None


def _is_bounded(model: CompiledModel, report: MjcfReport) -> bool:
    """Whether the engine holds all numbers, also the products of three; otherwise that is an error (SC481)."""
    import numpy as np  # noqa: PLC0415 - loaded where there is a model

    for name, array in model.arrays.items():
        kind, _, rest = name.partition("_")
        if array.dtype.kind != "f" or not array.size:
            continue
        # A range may be without an end.
        wrong = np.isnan(array) if rest.endswith("range") else ~(np.abs(array) <= MAX_NUMBER)
        if wrong.any():
            row = int(np.argwhere(wrong)[0][0])
            kind = {"cam": "camera"}.get(kind, kind)
            place = model.location(kind, row) if kind in worker.NAMED else model.source.elements[0].location
            number = float(array[wrong][0])
            report.error("SC481", f"`{name}` becomes {number:g}, and the most that is built is {MAX_NUMBER:g}", place)
            return False
    return True


def _readable(message: str, source: MujocoSource) -> str:
    """MuJoCo's message in one line, with the files' own names and without the lines of the text that it got."""
    for name, file in source.files.items():
        message = message.replace(name, Path(file.uri).name)
    lines = [line.strip() for line in message.splitlines() if line.strip()]
    words = _LINE.sub("", " ".join(line for line in lines if not line.startswith("Element name"))).strip(" ,'")
    return f"MuJoCo refuses the file: {words.removeprefix('XML Error:').removeprefix('Error:').strip()}"
