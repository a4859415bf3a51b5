"""The process behind a `scenecc.worker.Worker`: it reads requests on standard input and answers on standard output.

It has limits of memory and time. A module that reads untrusted files has a function `prepare`, which imports its
library and returns the function that answers a request.
"""

from __future__ import annotations

import importlib
import json
import os
import resource
import struct
import sys
from collections.abc import Callable
from typing import Any, BinaryIO

Message = tuple[dict[str, Any], list[bytes]]
"""A header of plain data, and byte strings."""

Answer = Callable[[dict[str, Any], list[bytes]], Message]
"""Answers one request."""


def read_message(stream: BinaryIO) -> Message | None:
    """Reads a header and the byte strings that follow it; None at the end of the stream."""
    prefix = stream.read(4)
    if len(prefix) < 4:
        return None
    (length,) = struct.unpack("<I", prefix)
    text = stream.read(length)
    if len(text) < length:
        return None
    header = json.loads(text)
    parts = [stream.read(size) for size in header["sizes"]]
    # The writer may end in the middle.
    return (header, parts) if [len(part) for part in parts] == header["sizes"] else None


def write_message(stream: BinaryIO, header: dict[str, Any], parts: list[bytes]) -> None:
    """Writes a message for `read_message`."""
    text = json.dumps({**header, "sizes": [len(part) for part in parts]}).encode()
    stream.write(struct.pack("<I", len(text)) + text)
    stream.writelines(parts)
    stream.flush()


def main() -> None:
    """Answers requests until the stream ends."""
    arguments = json.loads(sys.argv[1])
    sys.path[:] = arguments["path"]
    from scenecc.interrupt import exit_with_parent  # noqa: PLC0415 - found on that path

    exit_with_parent(arguments["parent"])
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answers = os.fdopen(os.dup(1), "wb")
    # Output of a library must not get into the answers.
    os.dup2(2, 1)
    answer: Answer = importlib.import_module(arguments["module"]).prepare()
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    memory = arguments["memory"] if most == resource.RLIM_INFINITY else min(arguments["memory"], most)
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    if not arguments["opens_files"]:
        # The kernel refuses to open any file that the library tries to open itself.
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0))
    while (request := read_message(sys.stdin.buffer)) is not None:
        write_message(answers, *answer(*request))


if __name__ == "__main__":
    main()
