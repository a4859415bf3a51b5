"""Opening of files whose names come from others: of a scene, an asset, a plan."""

from __future__ import annotations

import errno
import os
import stat
from hashlib import sha256
from typing import BinaryIO

State = tuple[int, int, int, int, int]
"""Device, inode, size, and when its content and anything about it last changed [ns]: tells that a file changed."""


class NotAFileError(OSError):
    """What a name leads to is a pipe, a socket or a device."""


class ChangedError(OSError):
    """A file does not hold what it held when it was checked."""


def open_regular(path: str | os.PathLike[str]) -> BinaryIO:
    """A regular file, open for reading. Never waits, as a named pipe would make it wait for someone to write.

    Raises:
        OSError: it cannot be opened, or is a folder (`IsADirectoryError`), or a pipe, a socket or a device
            (`NotAFileError`).
    """
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(handle, "rb")
    os.close(handle)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    raise NotAFileError(errno.EINVAL, "this is a pipe or a device, not a file", os.fspath(path))


def read_checked(path: str | os.PathLike[str], digest: str | None) -> bytes:
    """The content of a file.

    Args:
        path: of the file.
        digest: SHA-256 of what it held when it was checked; None: it was not.

    Raises:
        OSError: it cannot be read; `ChangedError`: it holds something else now.
    """
    with open_regular(path) as file:
        data = file.read()
    if digest is not None and sha256(data).hexdigest() != digest:
        raise ChangedError(errno.ESTALE, "it changed while the scene was built", os.fspath(path))
    return data


def state_of(status: os.stat_result) -> State:
    """The state that a file is in."""
    return (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)


def state_now(path: str | os.PathLike[str]) -> State | None:
    """The state that a file is in; None where it is gone."""
    try:
        return state_of(os.stat(path))  # noqa: PTH116 - a path of either kind
    except OSError:
        return None
