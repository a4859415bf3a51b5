"""How the files that a scene names are written.

Which of them are there and may be read is `scenecc.source.paths`' business.
"""

from __future__ import annotations

import os
import re
from typing import NamedTuple

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]*)://")


class Refusal(NamedTuple):
    """Why a file cannot be used: a code of band 4, a message and what to do."""

    code: str
    message: str
    hint: str | None = None


def malformed(uri: str) -> Refusal | None:
    """Why a text can name no file here, whatever its scheme."""
    if not uri.strip():
        return Refusal("SC403", "the path is empty", "name a file")
    if any(ord(c) < 32 or c == "\x7f" for c in uri):
        return Refusal("SC403", f"the path {shown(uri)!r} holds a control character")
    try:
        os.fsencode(uri)
    except UnicodeEncodeError:
        return Refusal("SC403", f"the path {shown(uri)!r} cannot be a file name")
    if "\\" in uri:
        return Refusal("SC403", f"the path `{shown(uri)}` holds a backslash", "write `/` between folders")
    if uri.startswith("~"):
        return Refusal(
            "SC403", f"`~` is not expanded in `{shown(uri)}`", "write a path relative to the scene, or use asset://"
        )
    return None


def foreign_scheme(uri: str, known: tuple[str, ...]) -> Refusal | None:
    """Why a uri's scheme is not read. `known`: those that are."""
    match = _SCHEME.match(uri)
    if match is None or match[1] in known:
        return None
    hints = {
        "http": "download the file and name it by its path",
        "https": "download the file and name it by its path",
        "file": "write the path alone, without file://",
        "package": "write pkg://PACKAGE/PATH for a Python package, or asset://PATH and --asset-root for a ROS one",
        "model": "write asset://PATH and give the model folder with --asset-root",
    }
    fallback = (
        "name a path relative to the scene, pkg://PACKAGE/PATH or asset://PATH" if known else "name a relative path"
    )
    hint = hints.get(match[1].lower(), fallback) if known else fallback
    if match[1].lower() in known:
        hint = f"write {match[1].lower()}://"
    return Refusal("SC403", f"`{match[1]}://` is not read, in `{shown(uri)}`", hint)


def inner_malformed(uri: str, inner: str) -> Refusal | None:
    """Why what follows a package or `asset://` names no file."""
    if not inner or inner.startswith("/"):
        return Refusal("SC403", f"`{shown(uri)}` names no file", "write pkg://PACKAGE/PATH or asset://PATH")
    return None


def shown(uri: str) -> str:
    """A uri as a message has it: of a long one the ends."""
    return uri if len(uri) <= 200 else uri[:120] + "…" + uri[-60:]
