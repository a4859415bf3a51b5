"""Reading files whose names come from others, only if they are regular; writing files whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import BinaryIO, Final

from scenecc.interrupt import interrupts_wait, undoing

PACK_SUFFIX: Final = ".scn"
"""Of a file that holds a scene with all that it uses; see `scenecc.source.pack`."""

ARCHIVE: Final = b"PK"
"""What it begins with, as every ZIP archive does."""

PACKS: Final = "packs"
"""The kind of `cache_folder` into which packs are read."""


def replace_all(files: Mapping[Path, bytes], folders: Sequence[Path] = ()) -> None:
    """Makes folders and writes files: all of them or none, also where a signal ends the process.

    Each goes to a file beside it first; these take their places in the end, the last first, so that what refers to
    others may stand before them.

    Raises:
        OSError: one cannot be written; all are as they were then.
    """
    parts: dict[Path, Path] = {}
    with undoing() as undo:
        for folder in folders:
            with interrupts_wait():
                folder.mkdir()
                undo.callback(_remove, folder)
        for path, data in files.items():
            parts[path] = part = path.with_name(f".{path.name}.{threading.get_native_id()}.part")
            undo.callback(part.unlink, missing_ok=True)
            try:
                _write(part, data)
            except OSError as error:
                if error.filename is not None:  # of the part, which nobody has named
                    raise OSError(error.errno, error.strerror, str(path)) from None
                raise
            if path.is_file():
                part.chmod(stat.S_IMODE(path.stat().st_mode))
        with interrupts_wait():
            _put_in_place(parts)
            undo.pop_all()


def replace_set(target: Path, files: Mapping[str, bytes], *, folder: bool) -> list[Path]:
    """Writes a file and those that lie beside it, all or none. Returns their paths.

    Args:
        target: the file that takes the first of `files`, whatever that is called; or the folder for all of them.
        files: by their paths from the folder in which the file lies.
        folder: whether `target` is a folder.

    Raises:
        OSError: one cannot be written; then everything is as it was.
    """
    top, names = Path(os.path.realpath(target)), list(files)
    paths = [top / name for name in names] if folder else [top, *(top.parent / name for name in names[1:])]
    folders = {top} if folder else set[Path]()
    below = {each for path in paths for each in path.parents if each.is_relative_to(top if folder else top.parent)}
    missing = [each for each in sorted(folders | below) if not each.exists()]
    replace_all(dict(zip(paths, files.values(), strict=True)), missing)
    return paths


def _write(part: Path, data: bytes) -> None:
    """Writes a new file. It has no name until it is whole: of a process that is killed, nothing is left."""
    part.unlink(missing_ok=True)  # of a process that was killed, on a file system of the second kind
    named = False
    try:
        handle = os.open(part.parent, os.O_TMPFILE | os.O_WRONLY, 0o666)
    except OSError:  # some file systems know no such files
        handle, named = os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666), True
    with os.fdopen(handle, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(handle)
        if not named:
            # With a folder, Python has the system follow the link there.
            os.link(f"/proc/self/fd/{handle}", part, src_dir_fd=handle)


def _put_in_place(parts: dict[Path, Path]) -> None:
    """Gives each part its name. What has the name is kept until the first, which comes last, has taken its place."""
    first, kept = next(iter(parts)), list[Path]()
    with ExitStack() as undo:
        for path in reversed(parts):
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
            if not os.path.lexists(path):
                undo.callback(path.unlink)
            elif path != first:
                kept.append(parts[path].with_suffix(".old"))
                path.replace(kept[-1])
                undo.callback(kept[-1].replace, path)
            parts[path].replace(path)
        undo.pop_all()
    for old in kept:
        with suppress(OSError):
            old.unlink()


def _remove(folder: Path) -> None:
    with suppress(OSError):  # others write into it by now
        folder.rmdir()


def cache_folder(kind: str) -> Path:
    """Where files of a kind are kept that are made of others: under `$XDG_CACHE_HOME`, or `~/.cache` without it."""
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        folder = Path(base) if base else Path.home() / ".cache"
    except RuntimeError:  # a user without a home: nothing can be kept
        folder = Path(os.devnull)
    return folder / "scenecc" / kind


def keep_file(kind: str, content: bytes, suffix: str) -> Path:
    """A file of the cache folder that holds `content`; its stem is the SHA-256 of that.

    Raises:
        OSError: it cannot be written.
    """
    from hashlib import sha256  # noqa: PLC0415 - few commands keep anything

    folder = cache_folder(kind)
    file = folder / f"{sha256(content).hexdigest()}{suffix}"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        replace_all({file: content})
    return file


MOST_RESULTS: Final = 50_000
"""Files in a folder of results. With more, half of them are removed."""

MOST_RESULT_BYTES: Final = 4 * 2**30
"""Bytes in a folder of results. With more, half of its files are removed."""

_pruned: set[Path] = set()
"""Folders that this process has looked through."""


def keep_result(file: Path, content: bytes) -> None:
    """Writes a file of the cache folder. Where it cannot be written, it is left out: it is made again the next time."""
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.parent not in _pruned:
            _pruned.add(file.parent)
            _prune(file.parent)
        replace_all({file: _checksum(content) + content})


def _prune(folder: Path) -> None:
    """Removes the half of the results that were written first, where there are very many or they are very large."""
    with os.scandir(folder) as entries:
        files = sorted(((one.stat(), one.path) for one in entries), key=lambda one: one[0].st_mtime_ns)
    if len(files) > MOST_RESULTS or sum(status.st_size for status, _ in files) > MOST_RESULT_BYTES:
        for _, path in files[: len(files) // 2]:
            with suppress(OSError):  # another process removes them too
                os.unlink(path)  # noqa: PTH108 - the name of an entry


def read_result(file: Path) -> bytes | None:
    """What `keep_result` wrote; None: it wrote nothing, or the file is damaged."""
    try:
        checksum, end, content = file.read_bytes().partition(b"\n")
    except OSError:
        return None
    return content if checksum + end == _checksum(content) else None


def _checksum(content: bytes) -> bytes:
    from hashlib import sha256  # noqa: PLC0415 - few commands keep anything

    return sha256(content).hexdigest().encode() + b"\n"


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
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(handle, "rb")
    os.close(handle)
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), os.fspath(path))
    raise NotAFileError(errno.EINVAL, "this is a pipe or a device, not a file", os.fspath(path))


class TooLongError(OSError):
    """A file has more bytes than it may have."""


def read_at_most(path: str | os.PathLike[str], limit: int) -> bytes:
    """The content of a regular file.

    Raises:
        OSError: it cannot be read; `TooLongError`: it has more than `limit` bytes.
    """
    with open_regular(path) as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise TooLongError(errno.EFBIG, f"it has more than {limit} bytes", os.fspath(path))
    return data


def read_checked(path: str | os.PathLike[str], digest: str | None) -> bytes:
    """The content of a file.

    Args:
        path: of the file.
        digest: SHA-256 of what it held when it was checked; None: it was not.

    Raises:
        OSError: it cannot be read; `ChangedError`: it holds something else now.
    """
    from hashlib import sha256  # noqa: PLC0415 - few commands read what was checked

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
