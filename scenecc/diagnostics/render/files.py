"""File names for formats that a repository reads: relative to a root, with forward slashes."""

from __future__ import annotations

import os
from pathlib import Path, PurePath
from urllib.parse import quote


def relative_file(file: str, root: PurePath | None) -> tuple[str, bool]:
    """The name of `file` with forward slashes, and whether it is relative to `root`.

    Purely lexical, since the name may be of no file (`<stdin>`) or hold anything at all. A file
    outside of the root keeps its absolute name. `root`: None is the working directory.
    """
    base = PurePath(Path.cwd()) if root is None else root
    path = PurePath(os.path.normpath(base / file))
    if path.is_relative_to(base):
        return path.relative_to(base).as_posix(), True
    return path.as_posix(), not path.is_absolute()


def uri(file: str, root: PurePath | None) -> tuple[str, bool]:
    """The file as a URI reference, percent-encoded, and whether it is relative to `root`."""
    name, relative = relative_file(file, root)
    try:
        data = name.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        data = name.encode("utf-8", "replace")
    return (quote(data) if relative else "file://" + quote(data if name.startswith("/") else b"/" + data)), relative
