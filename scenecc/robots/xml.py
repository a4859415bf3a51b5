"""XML parser for URDF, SRDF and MJCF: a tree with source positions, and readers for attribute values.

Files are untrusted: nothing is fetched, entities are refused, and size, depth and counts are bounded. Namespaces are
not resolved; prefixes stay in names.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from importlib import import_module
from pyexpat import ExpatError, ParserCreate, errors
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.collector import collector_paused
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut
from scenecc.plan.properties import FLOAT32_MAX
from scenecc.source.comments import find_xml_silencings
from scenecc.source.text import TextLines

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from scenecc.diagnostics.diagnostic import Location
    from scenecc.geometry.rotations import Vec3
    from scenecc.robots.files import FileReport


_PARSE_SIZE = 2**20
"""Chunk size for the parser [bytes]. A handler's exception takes effect at the end of a chunk, and a token is rescanned
for each chunk that it spans.
"""

_TAG_PATTERN = re.compile(rb"<[^\s/>]+")

_ATTRIBUTE_PATTERN = re.compile(rb"\s*([^\s=/>]+)\s*=\s*(\"[^\"]*\"|'[^']*')")


@frozen
class XmlBounds:
    """Limits of an XML text. The defaults are a hundred times what the largest robots need.

    Attributes:
        size: length of the text [bytes].
        depth: nesting depth.
        elements: number of elements.
        equals: number of `=` characters, an upper bound for the attributes.
    """

    size: int = 16 * 2**20
    depth: int = 100
    elements: int = 100_000
    equals: int = 200_000


@dataclass(frozen=True, slots=True)
class _XmlText:
    """An XML text and its line index."""

    data: bytes
    lines: TextLines


@dataclass(frozen=True, slots=True, eq=False)
class SourceElement:
    """An XML element.

    Attributes:
        tag: its name as written.
        attributes: name → value, in order.
        children: direct children, in order.
        line, column: 0-based position of its `<`, in characters.
        characters: pieces of its own text.
    """

    tag: str
    attributes: dict[str, str] = field(repr=False)
    line: int
    column: int
    _offset: int = field(repr=False)
    _text: _XmlText = field(repr=False)
    children: list[SourceElement] = field(default_factory=list["SourceElement"], repr=False)
    characters: list[str] = field(default_factory=list[str], repr=False)

    @property
    def text(self) -> str:
        """The element's own text, stripped."""
        return "".join(self.characters).strip()

    @property
    def location(self) -> Location:
        """The location of `<` and the tag name."""
        return self._text.lines.location(self.line, self.column, self.column + 1 + len(self.tag))

    def at(self, attribute: str) -> Location:
        """Returns the location of an attribute's value; the element's own if it has no such attribute."""
        wanted = attribute.encode()
        data = self._text.data
        found = _TAG_PATTERN.match(data, self._offset)
        while found is not None:
            found = _ATTRIBUTE_PATTERN.match(data, found.end())
            if found is not None and found[1] == wanted:
                return self._place(found.start(2) + 1, found.end(2) - 1)
        return self.location

    def find(self, tag: str) -> SourceElement | None:
        """Returns the first child with a tag."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[SourceElement]:
        """Returns the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def _place(self, start: int, end: int) -> Location:
        """Returns the location of a byte range in the start tag, up to the end of its first line."""
        before = _normalize_newlines(self._text.data[self._offset : start].decode())
        inside = _normalize_newlines(self._text.data[start:end].decode())
        line = before.count("\n")
        column = len(before) - (before.rfind("\n") + 1) + (0 if line else self.column)
        length = len(inside.split("\n", 1)[0])
        return self._text.lines.location(self.line + line, column, column + length)


class _ParserStop(Exception):
    """Stops the parser after an error was reported."""


class _TreeBuilder:
    """Builds the tree from the parser's events."""

    def __init__(self, text: _XmlText, findings: FileReport, bounds: XmlBounds) -> None:
        self.root: SourceElement | None = None
        self._text = text
        self._findings = findings
        self._bounds = bounds
        self._open: list[SourceElement] = []
        self._count = 0
        parser = ParserCreate("utf-8")
        parser.buffer_text = True
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.CharacterDataHandler = self._data
        parser.StartDoctypeDeclHandler = self._doctype
        self.parser = parser

    def ends_early(self, error: ExpatError) -> str | None:
        """Describes which element is still open at the end of the file; None for other errors."""
        no_more = errors.codes[errors.XML_ERROR_NO_ELEMENTS] == error.code
        return f"the file ends before <{cut(self._open[-1].tag)}> is closed" if no_more and self._open else None

    def is_after_root(self, error: ExpatError) -> bool:
        """Returns whether an error is a closing tag after the end of the root."""
        token = errors.codes[errors.XML_ERROR_INVALID_TOKEN] == error.code
        at = self.parser.ErrorByteIndex
        return token and self.root is not None and not self._open and self._text.data[at - 1 : at + 1] == b"</"

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        parser = self.parser
        element = SourceElement(
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
            self._refuse_size(element, f"it is nested more than {self._bounds.depth} elements deep")
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
        # The parser is at the declaration's name or at its end.
        start = self._text.data.rfind(b"<!DOCTYPE", 0, self.parser.CurrentByteIndex + 9)
        line, column = self._text.lines.position(len(self._text.data[:start].decode()))
        self._findings.report(
            "SC451",
            "document types are refused: they may declare entities and name files",
            self._text.lines.location(line, column, column + 9),
            hint="remove <!DOCTYPE …>, and write out the entities that it declares",
        )
        raise _ParserStop

    def _refuse_size(self, element: SourceElement, what: str) -> None:
        self._findings.report("SC452", f"the file is too large: {what}", element.location)
        raise _ParserStop


def element_at(lines: TextLines, place: Location, tag: str, text: str = "", **attributes: str) -> SourceElement:
    """Returns an element that stands for something else at a place of a text, such as a model that a YAML names."""
    line, column = (place.line or 1) - 1, (place.column or 1) - 1
    return SourceElement(tag, attributes, line, column, 0, _XmlText(b"", lines), characters=[text])


def parse_xml(
    data: bytes,
    file: str,
    findings: FileReport,
    bounds: XmlBounds | None = None,
    ignore_rest: Callable[[Location], None] | None = None,
) -> SourceElement | None:
    """Returns the root element of a document; None after an error.

    Args:
        data: UTF-8, with or without a byte order mark; a declared encoding is ignored.
        file: displayed file name.
        findings: receives the errors: SC450 (not XML), SC451 (a document type), SC452 (beyond the bounds).
        bounds: default: `XmlBounds()`.
        ignore_rest: called with the place of a closing tag after the root, which ends the document; None: an error.
    """
    bounds = XmlBounds() if bounds is None else bounds
    data = data.removeprefix(b"\xef\xbb\xbf")
    if len(data) > bounds.size:
        findings.report("SC452", f"the file is too large: it has more than {bounds.size} bytes", findings.top(file))
        return None
    try:
        text = _XmlText(data, TextLines(file, data.decode()))
    except UnicodeDecodeError as error:
        _report_encoding(error, file, findings)
        return None
    if data.count(b"=") > bounds.equals:
        findings.report("SC452", f"the file is too large: more than {bounds.equals} attributes", findings.top(file))
        return None
    builder = _TreeBuilder(text, findings, bounds)
    try:
        with collector_paused():
            for start in range(0, len(data) + 1, _PARSE_SIZE):
                builder.parser.Parse(data[start : start + _PARSE_SIZE], start + _PARSE_SIZE > len(data))
    except _ParserStop:
        return None
    except ExpatError as error:
        message = builder.ends_early(error) or str(error).rsplit(": line", 1)[0]
        place = text.lines.location(error.lineno - 1, error.offset, error.offset + 1)
        if ignore_rest is None or not builder.is_after_root(error):
            findings.report("SC450", f"this is not well-formed XML: {message}", place)
            return None
        ignore_rest(place)
    findings.sink.silence(find_xml_silencings(text.lines))
    return builder.root


_COMMENT_PATTERN = re.compile(rb"(?<=<!--).*?(?=-->)", re.DOTALL)


def without_hyphens_in_comments(data: bytes) -> bytes:
    """Blanks out hyphens in comments. XML forbids two in a row, but most readers accept them."""
    return _COMMENT_PATTERN.sub(lambda found: found[0].replace(b"-", b" "), data)


def parse_recovered_xml(data: bytes, file: str, findings: FileReport) -> SourceElement | None:
    """Returns the root element of a malformed document, as recovered by libxml2. Needs lxml.

    Bounds are those of `XmlBounds`, and document types are refused, as in `parse_xml`. Attributes have the location of
    their element.
    """
    etree: Any = import_module("lxml.etree")  # an extra
    bounds = XmlBounds()
    data = data.removeprefix(b"\xef\xbb\xbf")
    lines = TextLines(file, data.decode(errors="replace"))
    if b"<!DOCTYPE" in data or b"<!ENTITY" in data:
        findings.report("SC451", "document types are refused: they may declare entities", findings.top(file))
        return None
    options: dict[str, bool] = {"recover": True, "resolve_entities": False, "no_network": True, "load_dtd": False}
    parser: Any = etree.XMLParser(**options, huge_tree=False, remove_comments=True, remove_pis=True)
    top: Any = etree.fromstring(data, parser)
    if top is None:
        findings.report("SC450", "this is not XML: no element can be recovered", findings.top(file))
        return None
    text, count = _XmlText(data, lines), 0

    def convert(node: Any, depth: int) -> SourceElement:
        """Converts an lxml element and its descendants. Raises _ParserStop beyond the bounds."""
        nonlocal count
        count += 1
        line = max(int(node.sourceline or 1) - 1, 0)
        # A declared prefix was replaced by its namespace; an undeclared one is part of the name.
        local = str(node.tag).rpartition("}")[2]
        tag = f"{node.prefix}:{local}" if node.prefix else local
        attributes = {str(name).rpartition("}")[2]: str(value) for name, value in node.attrib.items()}
        column = max(lines.line(line).find(f"<{tag}"), 0)
        made = SourceElement(tag, attributes, line, column, len(data), text)
        if count > bounds.elements or depth > bounds.depth:
            raise _ParserStop
        made.characters.extend(part for part in (node.text, *(child.tail for child in node)) if part)
        made.children.extend(convert(child, depth + 1) for child in node)
        return made

    try:
        return convert(top, 1)
    except _ParserStop:
        findings.report("SC452", "the file is too large: too many elements, or nested too deep", findings.top(file))
        return None


def _report_encoding(error: UnicodeDecodeError, file: str, findings: FileReport) -> None:
    before = error.object[: error.start].decode()
    lines = TextLines(file, before + error.object[error.start : error.start + 200].decode(errors="replace"))
    line, column = lines.position(len(before))
    findings.report(
        "SC450",
        f"this is not UTF-8 text: byte {error.start} (0x{error.object[error.start]:02X}) is invalid",
        lines.location(line, column, column + 1),
        hint="save the file as UTF-8",
    )


def _normalize_newlines(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n")


MAX_PLAUSIBLE_RADIANS, MAX_PLAUSIBLE_DEGREES = 4 * math.pi * (1 + 1e-6), 720.0
"""Two turns in radians and in degrees. Angles between these are probably degrees; larger ones often mean "no limit"."""

_NUMBER_PATTERN = re.compile(
    r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?|nan)", re.IGNORECASE
)

_MAX_NUMBER_CHARS = 400


def parse_number(text: str) -> float | None:
    """Parses a number in the syntax that XML Schema and Python share; None if it is invalid."""
    text = text.strip()
    return float(text) if len(text) <= _MAX_NUMBER_CHARS and _NUMBER_PATTERN.fullmatch(text) else None


def read_text_attribute(element: SourceElement, attribute: str, findings: FileReport) -> str | None:
    """Returns the value of a required, non-empty attribute; None after an error (SC455)."""
    value = element.attributes.get(attribute, "").strip()
    if value:
        return element.attributes[attribute]
    missing = attribute not in element.attributes
    message = f"<{element.tag}> has no `{attribute}`" if missing else f"the `{attribute}` of <{element.tag}> is empty"
    findings.report("SC455", message, element.at(attribute))
    return None


def read_number_attribute(
    element: SourceElement, attribute: str, findings: FileReport, *, infinite: bool = False
) -> float | None:
    """Returns the number in a required attribute (SC455); it must be in range, and finite unless `infinite` (SC456)."""
    if read_text_attribute(element, attribute, findings) is None:
        return None
    found = _parse_numbers(
        element, attribute, element.attributes[attribute].split() or [""], 1, findings, infinite=infinite
    )
    return None if found is None else found[0]


def read_optional_number(
    element: SourceElement, attribute: str, findings: FileReport, *, infinite: bool = False
) -> tuple[float | None, bool]:
    """Returns the number in an optional attribute, None if missing, and whether there was no error."""
    if attribute not in element.attributes:
        return None, True
    found = read_number_attribute(element, attribute, findings, infinite=infinite)
    return found, found is not None


def read_vector3(element: SourceElement, attribute: str, findings: FileReport) -> Vec3 | None:
    """Returns the three numbers in a required attribute."""
    found = read_numbers(element, attribute, 3, findings)
    return None if found is None else (found[0], found[1], found[2])


def read_numbers(element: SourceElement, attribute: str, count: int, findings: FileReport) -> tuple[float, ...] | None:
    """Returns `count` numbers, separated by blanks, in a required attribute (SC455, SC456)."""
    if read_text_attribute(element, attribute, findings) is None:
        return None
    return _parse_numbers(element, attribute, element.attributes[attribute].split(), count, findings, infinite=False)


def warn_if_degrees(angles: Iterable[float], what: str, location: Location, findings: FileReport) -> None:
    """Warns, once per kind `what`, about angles [rad] that are probably in degrees."""
    angle = max(
        (size for size in map(abs, angles) if MAX_PLAUSIBLE_RADIANS < size <= MAX_PLAUSIBLE_DEGREES), default=None
    )
    if angle is not None:
        message = f"{what} of {angle:g} radians: that is {angle / math.tau:.3g} turns"
        findings.report_once(
            "SC526", what, message, location, "angles are in radians here; this file may contain more of these"
        )


def _parse_numbers(
    element: SourceElement, attribute: str, words: list[str], count: int, findings: FileReport, *, infinite: bool
) -> tuple[float, ...] | None:
    where = f"the `{attribute}` of <{element.tag}>"
    if len(words) != count:
        wanted = "one number" if count == 1 else f"{count} numbers separated by blanks"
        # Other formats take one number for all axes.
        repeats = len(words) == 1 and parse_number(words[0]) is not None
        hint = f'write it {count} times: `{attribute}="{" ".join(words * count)}"`' if repeats else None
        findings.report("SC456", f"{where} must have {wanted}, and has {len(words)}", element.at(attribute), hint=hint)
        return None
    values: list[float] = []
    for word in words:
        value, fault = parse_number(word), None
        if value is None or math.isnan(value) or (math.isinf(value) and not infinite):
            fault = f"which is not a {'' if value is None else 'finite '}number"
        elif math.isfinite(value) and abs(value) > FLOAT32_MAX:
            fault = "which does not fit in single precision"
        if value is None or fault is not None:
            findings.report("SC456", f"{where} contains `{cut(word)}`, {fault}", element.at(attribute))
            return None
        values.append(value)
    return tuple(values)
