"""Common parts of the formats: options, safe text for a terminal, and file names relative to a root."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Protocol
from urllib.parse import quote

from scenecc.diagnostics.diagnostic import STAGES
from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic


@frozen
class Style:
    """How diagnostics are rendered.

    Attributes:
        color: whether the text format uses terminal colours; the others never do.
        root: folder to which the file names of `github`, `gitlab`, `junit` and `sarif` are relative; None: the working
            directory.
        width: terminal cells of a source line before the text format cuts it around the caret.
        files: checked files, with or without findings; only `junit` names them.
        corrections: corrected findings; only `json` lists them. None: no correction was requested.
        simulated: scenes, seeds and seconds simulated of each file; only `json` lists them. None: as for `render`.
        strict: checked files whose warnings count as errors; only `junit` tells them apart.
    """

    color: bool = False
    root: PurePath | None = None
    width: int = 110
    files: tuple[str, ...] = ()
    corrections: tuple[Diagnostic, ...] | None = None
    simulated: Mapping[str, Mapping[str, object] | None] | None = None
    strict: frozenset[str] = frozenset()


def unchecked(diagnostics: Sequence[Diagnostic], style: Style) -> dict[str, list[str]]:
    """Returns what was not checked of each file, because of its errors: file → stages, the first one first."""
    missing: dict[str, list[str]] = {}
    last = [] if style.simulated is None else ["simulation"]
    for one in diagnostics:
        if one.severity == "error" and one.stage:
            later = [*STAGES[STAGES.index(one.stage) + 1 :], *last]
            file = checked_file(one, style.files)
            missing[file] = min(later, missing.get(file, later), key=len)
    return {file: stages for file, stages in missing.items() if stages}


def unchecked_text(missing: Mapping[str, Sequence[str]]) -> str:
    """Returns the result of `unchecked` as one line; "" if everything was checked."""
    files: dict[str, list[str]] = {}
    for file, stages in missing.items():
        files.setdefault(", ".join(stages), []).append(visible(file))
    words = list(files)
    if len(missing) > 1:
        words = [f"{text} of {_enumerated(names)}" for text, names in files.items()]
    return f"not checked because of these errors: {'; '.join(words)}" if words else ""


def _enumerated(names: Sequence[str]) -> str:
    others = len(names) - _NAMED
    return ", ".join(names) if others <= 1 else f"{', '.join(names[:_NAMED])} and {others} other files"


_NAMED = 3
"""Maximum number of files that `unchecked_text` names, for the same stages."""


def checked_file(diagnostic: Diagnostic, files: Collection[str]) -> str:
    """Returns which of the checked files a finding concerns: its own, or one that uses or includes that."""
    if diagnostic.place in files:
        return diagnostic.place
    users = (other.location.file for other in reversed(diagnostic.related))
    return next((file for file in users if file is not None and file in files), diagnostic.place)


_KEPT = "\u200c\u200d"
"""The joiners: invisible, but Persian words and emoji families need them."""

_HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Unicode categories that control a terminal, are invisible, reorder or break a line, or cannot be encoded."""


class HasIsatty(Protocol):
    """The part of a text stream that decides about colour."""

    def isatty(self) -> bool:
        """Returns whether it is a terminal."""
        ...


def wants_color(stream: HasIsatty, environ: Mapping[str, str] | None = None) -> bool:
    """Returns whether to colour output to `stream`.

    `NO_COLOR`, then `FORCE_COLOR` decide if they are set and not empty; otherwise a terminal that is not `TERM=dumb`
    gets colours. `environ`: None: the process's own.
    """
    env = os.environ if environ is None else environ
    if env.get("NO_COLOR"):
        return False
    if env.get("FORCE_COLOR"):
        return True
    return env.get("TERM") != "dumb" and stream.isatty()


def visible(text: str) -> str:
    """Returns the text with control, bidirectional, invisible and unencodable characters spelled out.

    A scene file is untrusted, and its lines are printed: an escape sequence must be visible and have no effect. C0
    controls become their pictures (ESC is ␛), others `<U+202E>`.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(map(_visible, text))


def _visible(char: str) -> str:
    if char in _KEPT or unicodedata.category(char) not in _HIDDEN:
        return char
    if char == "\x7f":
        return "\u2421"
    return chr(0x2400 + ord(char)) if char < "\x20" else f"<U+{ord(char):04X}>"


def encodable(text: str) -> str:
    """Returns the text with lone surrogates, which no encoding supports, as U+FFFD."""
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")


def relative_file(file: str, root: PurePath | None) -> tuple[str, bool]:
    """Returns the name of `file` with forward slashes, and whether it is relative to `root`.

    Purely lexical, because the name may be any text (`<stdin>`). A file outside the root keeps its absolute name.
    `root`: None: the working directory.
    """
    base = PurePath(Path.cwd()) if root is None else root
    path = PurePath(os.path.normpath(base / file))
    if path.is_relative_to(base):
        return path.relative_to(base).as_posix(), True
    return path.as_posix(), not path.is_absolute()


def uri(file: str, root: PurePath | None) -> tuple[str, bool]:
    """Returns the file as a percent-encoded URI reference, and whether it is relative to `root`."""
    name, relative = relative_file(file, root)
    try:
        data = name.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        data = name.encode("utf-8", "replace")
    return (quote(data) if relative else "file://" + quote(data if name.startswith("/") else b"/" + data)), relative
