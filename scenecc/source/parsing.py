"""The events of PyYAML's parser, C where it is compiled in."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

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


NextEvent = Callable[[], Any]
"""Gives an event. Who asks tells them apart by their exact types, which is quicker than any other way."""


def next_event(text: str) -> NextEvent:
    """The function that gives a text's events one after another.

    It raises `yaml.YAMLError` where the text is no YAML.
    """
    parser: Any = yaml.CSafeLoader(text) if yaml.__with_libyaml__ else yaml.SafeLoader(text)
    return parser.get_event


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
