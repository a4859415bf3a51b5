"""Events and scalars of YAML: the parser's events, tags, and the type of a plain scalar."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import inf, isinf, nan
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

from scenecc.diagnostics.coded_error import CodedError

Scalar = str | int | float | bool

MAX_INTEGER_CHARS = 100
"""Integers written longer than this are refused: no key of a scene means one, and the time to convert a
decimal integer grows with the square of its length."""

_NUMBER = re.compile(
    r"(?P<int>[-+]?[0-9]+)"
    r"|0o(?P<oct>[0-7]+)"
    r"|0x(?P<hex>[0-9a-fA-F]+)"
    r"|(?P<float>[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)"
    r"|(?P<inf>[-+]?\.(?:inf|Inf|INF))"
    r"|(?P<nan>\.(?:nan|NaN|NAN))"
)

RESERVED_CHARACTER = "\0"
"""What no key holds, so that labels of the compiler's own that start with it can stand among keys."""

RESERVED_IN_KEY_MESSAGE = "a key contains the character U+0000"
"""What is said of a key with it."""

SCENE_KEYED_FIELD = "per_scene"
"""The key whose mapping is by scene index."""

_OVERRIDE = "override"


def has_index_keys(path: tuple[str | int, ...]) -> bool:
    """Whether an integer key of a mapping stands for its digits: by scene, or for items of a list in an override."""
    return path[-1:] == (SCENE_KEYED_FIELD,) or (path[:1] == ("entities",) and path[2:3] == (_OVERRIDE,))


_COORDINATE = re.compile(r"-?(?:[0-9]{1,20}\.[0-9]{3,}|[0-9]{2,20}\.[0-9]+)").fullmatch
"""A decimal of many digits: the most frequent plain scalar that is new to the reader, worth a shorter way."""

_NUMBER_STARTS = frozenset("0123456789+-.")

_BASES = {"int": 10, "oct": 8, "hex": 16}

_WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


def resolve_scalar(text: str) -> Scalar | None:
    """The value of an untagged plain scalar. None is null.

    Raises:
        OverflowError: a number that is no finite double, or an integer of absurd length.
    """
    if text[:1] in _NUMBER_STARTS:
        match = _NUMBER.fullmatch(text)
        return text if match is None else _number(match)
    return _WORDS.get(text, text)


def _number(match: re.Match[str]) -> int | float:
    kind = match.lastgroup or ""
    digits = match[kind]
    if kind == "float":
        value = float(digits)
        if isinf(value):
            raise OverflowError("beyond the range of a double")
        return value
    if kind in _BASES:
        if len(digits) > MAX_INTEGER_CHARS:
            raise OverflowError(f"an integer of {len(digits)} characters")
        return int(digits, _BASES[kind])
    if kind == "nan":
        return nan
    return -inf if digits[0] == "-" else inf


class PlainValues(dict[str, "Scalar | None"]):
    """Plain text → value, resolved at the first use.

    None stands for whatever the reader must look at: null, and numbers that cannot be held.
    """

    def __missing__(self, text: str) -> Scalar | None:
        if _COORDINATE(text):
            # Not kept: numbers of so many digits seldom come twice.
            return float(text)
        try:
            value = resolve_scalar(text)
        except OverflowError:
            value = None
        self[text] = value
        return value


class PlainKeys(dict[str, "str | None"]):
    """Plain text of a key → the key; None where it is no string, or the merge key."""

    def __missing__(self, text: str) -> str | None:
        try:
            value = resolve_scalar(text)
        except OverflowError:
            value = None
        key = value if isinstance(value, str) and value != "<<" else None
        self[text] = key
        return key


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
"""Returns an event. The caller distinguishes events by their exact types, which is the fastest way."""


def next_event(text: str) -> NextEvent:
    """The function that gives a text's events one after another; libyaml parses where PyYAML has it, which is faster.

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

_CORE_TAG_PREFIX = "tag:yaml.org,2002:"

_SCALAR_TAGS = ("str", "int", "float", "bool", "null")

_TAG_HINT = "remove the tag: scene files know `!!str`, `!!int`, `!!float`, `!!bool`, `!!null`, `!!map` and `!!seq`"


class NodeError(CodedError):
    """A node that cannot be read."""


def scalar_value(event: NodeEvent) -> Scalar | None:
    """The value of any scalar. None is null.

    Raises:
        NodeError: a tag that is unknown or does not fit, or a number that cannot be held.
    """
    if event.tag is not None:
        return _tagged_scalar_value(event, event.tag)
    if not event.implicit[0]:
        return event.value
    return _plain_scalar_value(event.value)


def check_collection_tag(event: NodeEvent) -> None:
    """Lets pass `!!map` on a mapping and `!!seq` on a list.

    Raises:
        Refused: any other tag.
    """
    is_list = isinstance(event, SequenceStartEvent)
    if event.tag == _CORE_TAG_PREFIX + ("seq" if is_list else "map"):
        return
    tag = format_tag(event.tag or "")
    if tag in ("!!seq", "!!map", *("!!" + name for name in _SCALAR_TAGS)):
        raise NodeError("SC008", f"the tag `{tag}` stands on a {'list' if is_list else 'mapping'}", "remove the tag")
    raise NodeError("SC008", f"the tag `{tag}` is not one of YAML's core schema", _TAG_HINT)


def format_tag(tag: str) -> str:
    """A tag as people write it: `!!int`, `!local`, `!<tag:example.org,2000:x>`."""
    if tag.startswith(_CORE_TAG_PREFIX):
        return "!!" + tag.removeprefix(_CORE_TAG_PREFIX)
    return tag if tag.startswith("!") else f"!<{tag}>"


def format_scalar(event: NodeEvent) -> str:
    """The text of a scalar, cut where it is long."""
    text = event.value if isinstance(event, ScalarEvent) else ""
    return text if len(text) <= 40 else f"{text[:37]}..."


def _plain_scalar_value(text: str) -> Scalar | None:
    try:
        return resolve_scalar(text)
    except OverflowError as error:
        shown = text if len(text) <= 40 else f"{text[:37]}..."
        raise NodeError("SC014", f"the number {shown} is {error}", "quote it if it is meant as a string") from None


def _tagged_scalar_value(event: NodeEvent, tag: str) -> Scalar | None:
    """The value of a tagged scalar, read by the tag's own rule, quoted or not."""
    shown, text = format_tag(tag), event.value
    kind = tag.removeprefix(_CORE_TAG_PREFIX) if tag.startswith(_CORE_TAG_PREFIX) else ""
    if kind == "str":
        return text
    if kind in ("map", "seq"):
        raise NodeError("SC008", f"the tag `{shown}` stands on a single value", "remove the tag")
    if kind not in _SCALAR_TAGS:
        raise NodeError("SC008", f"the tag `{shown}` is not one of YAML's core schema", _TAG_HINT)
    value = _plain_scalar_value(text)
    if kind == "float" and isinstance(value, int) and not isinstance(value, bool):
        return float(value)  # at most 100 digits: always within the range of a double
    fits = {
        "int": isinstance(value, int) and not isinstance(value, bool),
        "float": isinstance(value, float),
        "bool": isinstance(value, bool),
        "null": value is None,
    }
    if not fits[kind]:
        raise NodeError("SC008", f"`{format_scalar(event)}` is not what the tag `{shown}` says", "remove the tag")
    return value


def describe_type(value: object) -> str:
    """What a value is, in words."""
    match value:
        case None:
            return "null"
        case bool():
            return "a boolean"
        case int() | float():
            return "a number"
        case str():
            return "a string"
        case list():
            return "a list"
        case _:
            return "a mapping"
