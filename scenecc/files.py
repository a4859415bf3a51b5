"""Reads only regular files, for names from untrusted text, and writes files completely or not at all."""

from __future__ import annotations

import errno
import os
import stat
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, BinaryIO, Final

from scenecc.interrupt import interrupts_wait, undoing

PACK_SUFFIX: Final = ".scn"
"""Suffix of a pack, which holds a scene and all files that it uses; see `scenecc.source.pack`."""

ARCHIVE: Final = b"PK"
"""The first bytes of a pack, as of every ZIP archive."""

PACKS: Final = "packs"
"""The `cache_folder` for the contents of packs."""


def replace_all(files: Mapping[Path, bytes], folders: Sequence[Path] = ()) -> None:
    """Makes folders and writes files, all or none, even if a signal ends the process.

    Writes each to a temporary file beside its target, then renames them in reverse order, so that referenced files
    exist before the file that refers to them.

    Raises:
        OSError: a file cannot be written; all files then are unchanged.
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
                if error.filename is not None:  # the error names the temporary file, which the user does not know
                    raise OSError(error.errno, error.strerror, str(path)) from None
                raise
            if path.is_file():
                part.chmod(stat.S_IMODE(path.stat().st_mode))
        with interrupts_wait():
            _put_in_place(parts)
            undo.pop_all()


def replace_unchanged(path: str | os.PathLike[str], before: bytes, after: bytes) -> None:
    """Replaces the content of a file, through links, if it still is `before`.

    Raises:
        ChangedError: it is not.
        OSError: the file cannot be written. It is then unchanged.
    """
    target = Path(os.path.realpath(path))
    if not os.access(target, os.W_OK):  # checked because a writable folder would allow replacing the file
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), os.fspath(path))
    with open_regular(target) as file:
        if file.read(len(before) + 1) != before:
            raise ChangedError(errno.ESTALE, "it has changed meanwhile", os.fspath(path))
    replace_all({target: after})


def replace_set(target: Path, files: Mapping[str, bytes], *, folder: bool) -> list[Path]:
    """Writes a file and those beside it, all or none. Returns their paths.

    Args:
        target: path of the first of `files`, whatever its name there; or the folder for all of them.
        files: content by path relative to the folder of the file.
        folder: whether `target` is a folder.

    Raises:
        OSError: a file cannot be written; all files then are unchanged.
    """
    top, names = Path(os.path.realpath(target)), list(files)
    paths = [top / name for name in names] if folder else [top, *(top.parent / name for name in names[1:])]
    for path in paths:
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise OSError(errno.EINVAL, "it is a device or a pipe, and this needs files beside it", str(path))
    folders = {top} if folder else set[Path]()
    below = {each for path in paths for each in path.parents if each.is_relative_to(top if folder else top.parent)}
    missing = [each for each in sorted(folders | below) if not each.exists()]
    replace_all(dict(zip(paths, files.values(), strict=True)), missing)
    return paths


def _write(part: Path, data: bytes) -> None:
    """Writes a new file. It has no name until it is complete, so a killed process leaves nothing behind."""
    part.unlink(missing_ok=True)  # left by a killed process, on a file system without unnamed files
    named = False
    try:
        handle = os.open(part.parent, os.O_TMPFILE | os.O_WRONLY, 0o666)
    except OSError:  # some file systems do not support unnamed files
        handle, named = os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666), True
    with os.fdopen(handle, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(handle)
        if not named:
            # With a folder descriptor, Python makes the system follow the link.
            os.link(f"/proc/self/fd/{handle}", part, src_dir_fd=handle)


def _put_in_place(parts: dict[Path, Path]) -> None:
    """Renames each temporary file to its target. Old targets are kept until the first file, which comes last, is in
    place.
    """
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
    with suppress(OSError):  # other processes may have written into it
        folder.rmdir()


def cache_folder(kind: str) -> Path:
    """Returns the folder for cached files of a kind: under `$XDG_CACHE_HOME`, or else `~/.cache`."""
    base = os.environ.get("XDG_CACHE_HOME")
    try:
        folder = Path(base) if base else Path.home() / ".cache"
    except RuntimeError:  # the user has no home, so nothing can be cached
        folder = Path(os.devnull)
    return folder / "scenecc" / kind


def keep_file(kind: str, content: bytes, suffix: str) -> Path:
    """Returns a file of the cache folder that holds `content`. Its stem is the SHA-256 of the content.

    Raises:
        OSError: it cannot be written.
    """
    from hashlib import sha256  # noqa: PLC0415 - few commands cache anything

    folder = cache_folder(kind)
    file = folder / f"{sha256(content).hexdigest()}{suffix}"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        replace_all({file: content})
    return file


MOST_RESULTS: Final = 50_000
"""Maximum number of files in a folder of results. Beyond it, half of them are removed."""

MOST_RESULT_BYTES: Final = 4 * 2**30
"""Maximum bytes in a folder of results. Beyond it, half of its files are removed."""

_pruned: set[Path] = set()
"""Folders that this process has checked."""


def keep_result(file: Path, content: bytes) -> None:
    """Writes a file of the cache folder. If that fails, nothing is cached."""
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        if file.parent not in _pruned:
            _pruned.add(file.parent)
            _prune(file.parent)
        replace_all({file: _checksum(content) + content})


def _prune(folder: Path) -> None:
    """Removes the older half of the results, if there are too many or they are too large."""
    with os.scandir(folder) as entries:
        files = sorted(((one.stat(), one.path) for one in entries), key=lambda one: one[0].st_mtime_ns)
    if len(files) > MOST_RESULTS or sum(status.st_size for status, _ in files) > MOST_RESULT_BYTES:
        for _, path in files[: len(files) // 2]:
            with suppress(OSError):  # another process may remove them too
                os.unlink(path)  # noqa: PTH108 - a directory entry's name


def read_result(file: Path) -> bytes | None:
    """Returns what `keep_result` wrote; None if it wrote nothing, or the file is damaged."""
    try:
        checksum, end, content = file.read_bytes().partition(b"\n")
    except OSError:
        return None
    return content if checksum + end == _checksum(content) else None


def _checksum(content: bytes) -> bytes:
    from hashlib import sha256  # noqa: PLC0415 - few commands cache anything

    return sha256(content).hexdigest().encode() + b"\n"


State = tuple[int, int, int, int, int]
"""Device, inode, size, and times of the last change of content and metadata [ns]. Any change to a file changes it.
"""


class NotAFileError(OSError):
    """A path leads to a pipe, a socket or a device."""


class ChangedError(OSError):
    """A file has changed since it was checked."""


def open_regular(path: str | os.PathLike[str]) -> BinaryIO:
    """Opens a regular file for reading. Never blocks, even for a named pipe.

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
    raise NotAFileError(errno.EINVAL, "it is a pipe or a device, not a file", os.fspath(path))


class TooLongError(OSError):
    """A file is larger than allowed."""


def read_at_most(path: str | os.PathLike[str], limit: int) -> bytes:
    """Returns the content of a regular file.

    Raises:
        OSError: it cannot be read.
        TooLongError: it has more than `limit` bytes.
    """
    with open_regular(path) as file:
        data = file.read(limit + 1)
    if len(data) > limit:
        raise TooLongError(errno.EFBIG, f"it has more than {limit} bytes", os.fspath(path))
    return data


def read_checked(path: str | os.PathLike[str], digest: str | None) -> bytes:
    """Returns the content of a file.

    Args:
        path: path of the file.
        digest: SHA-256 of its content when it was checked; None: it was not checked.

    Raises:
        OSError: it cannot be read.
        ChangedError: its content has changed.
    """
    from hashlib import sha256  # noqa: PLC0415 - few commands compare hashes

    with open_regular(path) as file:
        data = file.read()
    if digest is not None and sha256(data).hexdigest() != digest:
        raise ChangedError(errno.ESTALE, "it changed while the scene was built", os.fspath(path))
    return data


def unique_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Returns an object of a JSON file, as `object_pairs_hook` of `json`. Raises ValueError if a key occurs twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a key occurs twice")
    return found


def state_of(status: os.stat_result) -> State:
    """Returns the state of a file from its `stat` result."""
    return (status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)


def state_now(path: str | os.PathLike[str]) -> State | None:
    """Returns the state of a file; None if it does not exist."""
    try:
        return state_of(os.stat(path))  # noqa: PTH116 - text or a Path
    except OSError:
        return None
