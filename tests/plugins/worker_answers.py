"""What a worker of tests answers: see `tests/unit/test_worker.py`."""

from __future__ import annotations

import json
import os
import resource
import stat
import struct
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from scenecc.worker_process import Answer, Message


def _pipe() -> int:
    """The pipe of answers: the only one besides standard input."""
    pipes = [number for number in range(3, 20) if _is_pipe(number)]
    (pipe,) = pipes
    return pipe


def _is_pipe(number: int) -> bool:
    try:
        return stat.S_ISFIFO(os.fstat(number).st_mode)
    except OSError:
        return False


def _send(data: bytes) -> NoReturn:
    """Sends bytes in place of an answer, and dies."""
    os.write(_pipe(), data)
    os._exit(1)


def _message(header: object) -> bytes:
    text = json.dumps(header).encode()
    return struct.pack("<I", len(text)) + text


def _drip(seconds: float) -> None:
    """Sends an answer slowly, byte by byte."""
    for byte in _message({"sizes": []}):
        os.write(_pipe(), bytes([byte]))
        time.sleep(seconds)


def _open(path: str) -> dict[str, Any]:
    try:
        return {"content": Path(path).read_text()}
    except OSError as error:
        return {"error": error.strerror}


def _print(words: str) -> None:
    print(words)
    os.write(1, words.encode())
    sys.stdout.flush()


def _count(file: str) -> NoReturn:
    """Adds a line to a file, and dies."""
    with Path(file).open("a") as stream:
        stream.write("asked\n")
    os._exit(1)


_ACTIONS: dict[str, Callable[[Any], dict[str, Any] | None]] = {
    "echo": lambda value: {"echo": value},
    "pid": lambda _: {"pid": os.getpid()},
    "limits": lambda _: {"core": resource.getrlimit(resource.RLIMIT_CORE)[0]},
    "sleep": lambda seconds: time.sleep(seconds),  # noqa: PLW0108
    "exit": lambda status: os._exit(status),  # noqa: PLW0108
    "abort": lambda _: os.abort(),
    "raise": lambda words: {"never": {}[words]},
    "allocate": lambda size: {"size": len(bytearray(size))},
    "send": lambda text: _send(bytes.fromhex(text)),
    "send header": lambda header: _send(_message(header)),
    "drip": _drip,
    "open": _open,
    "print": _print,
    "count": _count,
}


def prepare() -> Answer:
    """What answers a request: the header has one action with its argument. The parts come back."""

    def answer(header: dict[str, Any], parts: list[bytes]) -> Message:
        (name,) = header.keys() - {"sizes"}
        return _ACTIONS[name](header[name]) or {}, parts

    return answer
