"""Comments in YAML and XML that silence findings. Only text that contains the marker is searched."""

from __future__ import annotations

import re
from bisect import bisect_right
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import yaml
from yaml.events import ScalarEvent, StreamEndEvent

from scenecc.diagnostics.diagnostic import MARKER, Silencing, silencings_of
from scenecc.source.events import next_event

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Location
    from scenecc.source.text import TextLines


_YAML_COMMENT = re.compile(rf"(?<!\S)#[ \t]*{MARKER}\b")
_XML_COMMENT = re.compile(rf"<!--[ \t]*{MARKER}\b(?P<body>.*?)-->")


def find_yaml_silencings(lines: TextLines) -> list[Silencing]:
    """Returns the silencing comments of a YAML text. `#` in a string is not a comment."""
    if MARKER not in lines.text:
        return []
    marked = _find_marked_lines(lines)
    starts, ends = _scalars(lines.text, {number for number, _ in marked})

    def is_text(place: tuple[int, int]) -> bool:
        before = bisect_right(starts, place) - 1
        return before >= 0 and place < ends[before]

    def comments() -> Iterator[tuple[Location, str, bool]]:
        for number, line in marked:
            for match in _YAML_COMMENT.finditer(line):
                if not is_text((number, match.start())):
                    is_alone = line.lstrip().startswith("#")
                    yield lines.location(number, match.start()), line[match.end() :], is_alone
                    break

    return silencings_of(comments())


def find_xml_silencings(lines: TextLines) -> list[Silencing]:
    """Returns the silencing comments of an XML text, each on one line."""
    if MARKER not in lines.text:
        return []

    def comments() -> Iterator[tuple[Location, str, bool]]:
        for number, line in _find_marked_lines(lines):
            for match in _XML_COMMENT.finditer(line):
                place = lines.location(number, match.start(), match.end())
                yield place, match["body"], match[0] == line.strip()

    return silencings_of(comments())


def _find_marked_lines(lines: TextLines) -> list[tuple[int, str]]:
    """Returns the 0-based lines that contain the marker."""
    every = lines.text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    return [(number, line) for number, line in enumerate(every) if MARKER in line]


def _scalars(text: str, marked: set[int]) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Returns the starts and ends of scalars that may contain a marker, as 0-based (line, column), in order."""
    starts: list[tuple[int, int]] = []
    ends: list[tuple[int, int]] = []
    get = next_event(text)
    with suppress(yaml.YAMLError):  # reported as an error elsewhere
        while not isinstance(event := get(), StreamEndEvent):
            if not isinstance(event, ScalarEvent):
                continue
            start: Any = event.start_mark
            end: Any = event.end_mark
            if start.line in marked or start.line != end.line:
                # A comment may follow the `|` of a block.
                is_block = event.style in {"|", ">"}
                starts.append((start.line + 1, 0) if is_block else (start.line, start.column))
                ends.append((end.line, end.column))
    return starts, ends
