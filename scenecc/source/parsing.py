"""The events of PyYAML's parser, C where it is compiled in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, cast

import yaml
from yaml.events import (
    AliasEvent,
    DocumentEndEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
    StreamStartEvent,
)


class Mark(Protocol):
    """A place in a text; both count characters from 0."""

    line: int
    column: int


class Event(Protocol):
    """What all events have in common; scalars, aliases and starts of collections have more."""

    start_mark: Mark
    end_mark: Mark


class NodeEvent(Event, Protocol):
    """A scalar, an alias or the start of a collection (what an event lacks is never asked of it).

    `implicit` of a scalar is (plain and untagged, quoted and untagged); of a collection whether it is untagged.
    """

    anchor: str | None
    tag: str | None
    value: str
    implicit: tuple[bool, bool]
    flow_style: bool | None


NextEvent = Callable[[], NodeEvent]


def next_event(text: str) -> NextEvent:
    """The function that gives a text's events one after another.

    It raises `yaml.YAMLError` where the text is no YAML.
    """
    if yaml.__with_libyaml__:
        from yaml.cyaml import CParser

        return cast(NextEvent, CParser(text).get_event)  # pyright: ignore[reportUnknownMemberType]
    return cast(NextEvent, _PythonParser(text).get_event)


class _PythonParser(yaml.reader.Reader, yaml.scanner.Scanner, yaml.parser.Parser):
    """PyYAML's parser in Python, for the machines where the C one is not compiled in."""

    def __init__(self, text: str) -> None:
        yaml.reader.Reader.__init__(self, text)
        yaml.scanner.Scanner.__init__(self)
        yaml.parser.Parser.__init__(self)


__all__ = [
    "AliasEvent",
    "DocumentEndEvent",
    "DocumentStartEvent",
    "Event",
    "MappingEndEvent",
    "MappingStartEvent",
    "Mark",
    "NextEvent",
    "NodeEvent",
    "ScalarEvent",
    "SequenceEndEvent",
    "SequenceStartEvent",
    "StreamEndEvent",
    "StreamStartEvent",
    "next_event",
]
