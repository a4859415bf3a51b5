"""XML of robots as a tree whose every element and attribute knows its place in the text. For URDF, SRDF and MJCF.

A file may come from a stranger: nothing is fetched, no entity is declared, and size, depth and counts are bounded.
Names are taken as written, prefixes with them; a default namespace means nothing.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pyexpat import ExpatError, ParserCreate
from typing import TYPE_CHECKING

from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.frozen import frozen
from scenecc.source.text import TextLines

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Location
    from scenecc.robots.findings import Findings

_PIECE = 2**20
"""How much is given to the parser at once: what a handler raises is heeded at the end of a piece, and a token that
spans pieces is looked at once a piece [bytes]."""

_TAG = re.compile(rb"<[^\s/>]+")
_ATTRIBUTE = re.compile(rb"\s*([^\s=/>]+)\s*=\s*(\"[^\"]*\"|'[^']*')")


@frozen
class XmlBounds:
    """How much XML is read. The defaults are a hundred times what the largest robots have.

    Attributes:
        size: of the text [bytes].
        depth: elements inside one another.
        elements: in all.
        equals: signs `=` in the text, which are no fewer than the attributes.
    """

    size: int = 16 * 2**20
    depth: int = 100
    elements: int = 100_000
    equals: int = 200_000


@dataclass(frozen=True, slots=True)
class _Text:
    """A text as read and its lines."""

    data: bytes
    lines: TextLines


@dataclass(frozen=True, slots=True, eq=False)
class Element:
    """An element.

    Attributes:
        tag: its name as written.
        attributes: name → value, in order.
        children: the elements right inside, in order.
        line, column: 0-based place of its `<`, in characters.
        characters: pieces of the text right inside.
    """

    tag: str
    attributes: dict[str, str] = field(repr=False)
    line: int
    column: int
    _offset: int = field(repr=False)
    _text: _Text = field(repr=False)
    children: list[Element] = field(default_factory=list["Element"], repr=False)
    characters: list[str] = field(default_factory=list[str], repr=False)

    @property
    def text(self) -> str:
        """The text right inside, without blanks at its ends."""
        return "".join(self.characters).strip()

    @property
    def location(self) -> Location:
        """The place of its start tag's name, `<` with it."""
        return self._text.lines.location(self.line, self.column, self.column + 1 + len(self.tag))

    def at(self, attribute: str) -> Location:
        """The place of an attribute's value; the element's own where it has no such attribute."""
        wanted = attribute.encode()
        data = self._text.data
        found = _TAG.match(data, self._offset)
        while found is not None:
            found = _ATTRIBUTE.match(data, found.end())
            if found is not None and found[1] == wanted:
                return self._place(found.start(2) + 1, found.end(2) - 1)
        return self.location

    def find(self, tag: str) -> Element | None:
        """The first child of some name."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        """The children of some name."""
        return (child for child in self.children if child.tag == tag)

    def _place(self, start: int, end: int) -> Location:
        """The place of some bytes of the start tag, up to the end of the line on which they begin."""
        before = _unified(self._text.data[self._offset : start].decode())
        inside = _unified(self._text.data[start:end].decode())
        line = before.count("\n")
        column = len(before) - (before.rfind("\n") + 1) + (0 if line else self.column)
        length = len(inside.split("\n", 1)[0])
        return self._text.lines.location(self.line + line, column, column + length)


class _Refused(Exception):
    """Stops the parser; what is wrong has been reported."""


class _Builder:
    """Makes the tree from the parser's events."""

    def __init__(self, text: _Text, findings: Findings, bounds: XmlBounds) -> None:
        self.root: Element | None = None
        self._text = text
        self._findings = findings
        self._bounds = bounds
        self._open: list[Element] = []
        self._count = 0
        parser = ParserCreate("utf-8")
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._data
        parser.StartDoctypeDeclHandler = self._doctype
        self.parser = parser

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        parser = self.parser
        element = Element(
            tag,
            attributes,
            parser.CurrentLineNumber - 1,
            parser.CurrentColumnNumber,
            parser.CurrentByteIndex,
            self._text,
        )
        self._count += 1
        if self._count > self._bounds.elements:
            self._refuse_size(element, f"it has more than {self._bounds.elements} elements")
        if len(self._open) >= self._bounds.depth:
            self._refuse_size(element, f"more than {self._bounds.depth} elements stand inside one another")
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()

    def _data(self, text: str) -> None:
        if not text.isspace():
            self._open[-1].characters.append(text)

    def _doctype(self, *_: object) -> None:
        # The parser is at its name or its end.
        start = self._text.data.rfind(b"<!DOCTYPE", 0, self.parser.CurrentByteIndex + 9)
        line, column = self._text.lines.position(len(self._text.data[:start].decode()))
        self._findings.report(
            "SC451",
            "a document type is not read: it may declare entities and name files",
            self._text.lines.location(line, column, column + 9),
            hint="take the <!DOCTYPE …> away, and write out the entities that it declares",
        )
        raise _Refused

    def _refuse_size(self, element: Element, what: str) -> None:
        self._findings.report("SC452", f"the file is too large: {what}", element.location)
        raise _Refused


def parse_xml(data: bytes, file: str, findings: Findings, bounds: XmlBounds | None = None) -> Element | None:
    """The root element of a document; None, reported, where it is none or goes beyond the bounds.

    Args:
        data: UTF-8, with or without a byte order mark; what it declares of its encoding is not heeded.
        file: its name as shown to people.
        findings: where faults are reported: SC450 (no XML), SC451 (a document type), SC452 (beyond the bounds).
        bounds: None: those of `XmlBounds`.
    """
    bounds = XmlBounds() if bounds is None else bounds
    data = data.removeprefix(b"\xef\xbb\xbf")
    if len(data) > bounds.size:
        findings.report("SC452", f"the file is too large: it has more than {bounds.size} bytes", findings.top(file))
        return None
    try:
        text = _Text(data, TextLines(file, data.decode()))
    except UnicodeDecodeError as error:
        _not_text(error, file, findings)
        return None
    if data.count(b"=") > bounds.equals:
        findings.report("SC452", f"the file is too large: more than {bounds.equals} attributes", findings.top(file))
        return None
    builder = _Builder(text, findings, bounds)
    try:
        with collector_paused():
            for start in range(0, len(data) + 1, _PIECE):
                builder.parser.Parse(data[start : start + _PIECE], start + _PIECE > len(data))
    except _Refused:
        return None
    except ExpatError as error:
        message = str(error).rsplit(": line", 1)[0]
        place = text.lines.location(error.lineno - 1, error.offset, error.offset + 1)
        findings.report("SC450", f"this is not well-formed XML: {message}", place)
        return None
    return builder.root


def _not_text(error: UnicodeDecodeError, file: str, findings: Findings) -> None:
    before = error.object[: error.start].decode()
    lines = TextLines(file, before + error.object[error.start : error.start + 200].decode(errors="replace"))
    line, column = lines.position(len(before))
    findings.report(
        "SC450",
        f"this is not UTF-8 text: byte {error.start} (0x{error.object[error.start]:02X}) belongs to no character",
        lines.location(line, column, column + 1),
        hint="save the file in that encoding",
    )


def _unified(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n")
