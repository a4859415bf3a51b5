"""Where something in a scene came from, and where that is in a text."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

from scenecc.diagnostics.frozen import frozen

PathKey = str | int
"""One step into a document: a mapping's key or a sequence's index."""

Path = tuple[PathKey, ...]

At = Literal["value", "key"]
"""Which half of a mapping's entry is meant. A sequence's item has only a value."""


@frozen
class Origin:
    """The node of a document that asked for something.

    Cheap to make (a valid file makes thousands and prints none): a line is looked up only when a
    diagnostic is printed.

    Attributes:
        file: name of the document as shown to people; None for a dict.
        path: keys and indices from the document's root.
        copy: which copy of a repeated node ("i=1, j=-1"); empty for a node written once.
        parent: the node that brought this document in (a `use`, an item of `include`, a robot's file); None for the
            top document.
        location: where it is, where that is known already: in a text that is no scene file.
    """

    file: str | None
    path: Path = ()
    copy: str = ""
    parent: Origin | None = None
    location: Location | None = None

    def child(self, *keys: PathKey) -> Origin:
        """The origin of a node below this one."""
        return Origin(self.file, self.path + keys, self.copy, self.parent, self.location)

    def into(self, location: Location, *path: PathKey) -> Origin:
        """The origin of a line in another text, which this node names. `path`: what stands there."""
        return Origin(location.file, path, "", self, location)


@frozen
class Location:
    """A place in a text. Lines and columns count from 1; columns count characters.

    Attributes:
        file: name of the document as shown to people.
        line: 1-based line; None where the document has no text (a dict).
        column: 1-based column of the first character.
        end_column: column after the last character to underline, on the same line.
        text: the whole line, without its line break.
    """

    file: str | None
    line: int | None = None
    column: int | None = None
    end_column: int | None = None
    text: str | None = None


Locator = Callable[[Origin, At], Location]
"""Finds an origin in its text. Total: what cannot be found gives a location without a line."""


Tracer = Callable[[Origin], Origin]
"""Turns an origin in an expanded document into the one as written. Total."""


def as_written(origin: Origin) -> Origin:
    """The tracer of documents that are compiled as they are written."""
    return origin


def nowhere(origin: Origin, at: At) -> Location:
    """The locator of documents that have no text."""
    del at
    return Location(origin.file)


_QUOTED = frozenset(". []\"'\n\t")


def dotted(path: Path) -> str:
    """A path as people write it: `entities.cube.shapes[0].half_size[1]`.

    Keys that would read as something else (dots, brackets, blanks) are quoted:
    `entities["a.b"]`.
    """
    out: list[str] = []
    for key in path:
        if isinstance(key, int):
            out.append(f"[{key}]")
        elif key and _QUOTED.isdisjoint(key):
            out.append(f".{key}" if out else key)
        else:
            out.append('["' + key.replace("\\", "\\\\").replace('"', '\\"') + '"]')
    return "".join(out)


Span = tuple[int, int]
"""The first character and the one after the last, in the value of a scalar."""

_BEFORE = re.compile(r"(?:[&!]\S*\s+)*")
"""An anchor and a tag, in front of the scalar itself."""

_CHARACTER = {
    '"': re.compile(r"\\x..|\\u.{4}|\\U.{8}|\\.|[^\"\\]"),
    "'": re.compile(r"''|[^']"),
    "": re.compile(r"."),
}
"""What stands for one character: in double quotes, in single quotes, and in plain text."""


def within(location: Location, span: Span) -> Location:
    """The place of a part of a scalar; the scalar's own where the part does not begin on its first line.

    Args:
        location: of the scalar.
        span: the part.
    """
    if location.column is None or location.text is None:
        return location
    start = location.column - 1
    end = len(location.text) if location.end_column is None else location.end_column - 1
    match = _BEFORE.match(location.text, start, end)
    start = match.end() if match else start
    first = location.text[start : start + 1]
    if first in {"|", ">"}:
        return location
    style = first if first in {'"', "'"} else ""
    columns = [found.start() for found in _CHARACTER[style].finditer(location.text, start + len(style), end)]
    if span[0] >= len(columns):
        return location
    last = columns[min(span[1], len(columns)) - 1] + 1 if span[1] > span[0] else columns[span[0]] + 1
    return replace(location, column=columns[span[0]] + 1, end_column=last + 1)
