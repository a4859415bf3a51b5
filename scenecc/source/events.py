"""YAML events and scalars: the parser's events, tags, and the type of a plain scalar."""

from __future__ import annotations

import re
from collections.abc import Callable
from math import inf, isinf, nan
from typing import Any, Protocol

import yaml
from yaml.events import ScalarEvent, SequenceStartEvent

from scenecc.diagnostics.coded_error import CodedError

Scalar = str | int | float | bool

MAX_INTEGER_CHARS = 100
"""Maximum length of an integer. No key needs more, and the time to convert a decimal integer grows with the square of
its length."""

_NUMBER = re.compile(
    r"(?P<int>[-+]?[0-9]+)"
    r"|0o(?P<oct>[0-7]+)"
    r"|0x(?P<hex>[0-9a-fA-F]+)"
    r"|(?P<float>[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)"
    r"|(?P<inf>[-+]?\.(?:inf|Inf|INF))"
    r"|(?P<nan>\.(?:nan|NaN|NAN))"
)

RESERVED_CHARACTER = "\0"
"""A character that no key may contain, so that internal labels that start with it never equal a key."""

RESERVED_IN_KEY_MESSAGE = "a key contains the character U+0000"
"""The message for a key that contains it."""

SCENE_KEYED_FIELD = "per_scene"
"""The key whose mapping is indexed by scene."""

_OVERRIDE = "override"


def has_index_keys(path: tuple[str | int, ...]) -> bool:
    """Returns whether integer keys of a mapping are allowed: scene indices, or list items in an override."""
    return path[-1:] == (SCENE_KEYED_FIELD,) or (path[:1] == ("entities",) and path[2:3] == (_OVERRIDE,))


_COORDINATE = re.compile(r"-?(?:[0-9]{1,20}\.[0-9]{3,}|[0-9]{2,20}\.[0-9]+)").fullmatch
"""A decimal with many digits: the most frequent new plain scalar, which gets a fast path."""

_NUMBER_STARTS = frozenset("0123456789+-.")

_BASES = {"int": 10, "oct": 8, "hex": 16}

_WORDS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}


def resolve_scalar(text: str) -> Scalar | None:
    """Returns the value of an untagged plain scalar. None is null.

    Raises:
        OverflowError: the number is not a finite double, or an extremely long integer.
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
    """Plain text → value, resolved at first use.

    None means that the reader must handle it: null, and numbers out of range.
    """

    def __missing__(self, text: str) -> Scalar | None:
        if _COORDINATE(text):
            # Not kept, because numbers with so many digits seldom repeat.
            return float(text)
        try:
            value = resolve_scalar(text)
        except OverflowError:
            value = None
        self[text] = value
        return value


class PlainKeys(dict[str, "str | None"]):
    """Plain text of a key → the key; None if it is not a string, or is the merge key."""

    def __missing__(self, text: str) -> str | None:
        try:
            value = resolve_scalar(text)
        except OverflowError:
            value = None
        key = value if isinstance(value, str) and value != "<<" else None
        self[text] = key
        return key


class Mark(Protocol):
    """A position in a text; all count from 0, in characters. `index`: in the whole text."""

    index: int
    line: int
    column: int


class Event(Protocol):
    """The common attributes of all events; scalars, aliases and starts of collections have more."""

    start_mark: Mark
    end_mark: Mark


class NodeEvent(Event, Protocol):
    """A scalar, an alias or the start of a collection. Attributes that an event lacks are never read.

    `implicit` of a scalar is (plain and untagged, quoted and untagged); for a collection, whether it is untagged.
    """

    anchor: str | None
    tag: str | None
    value: str
    implicit: tuple[bool, bool]
    flow_style: bool | None


NextEvent = Callable[[], Any]
"""Returns an event. Callers distinguish events by their exact types, which is fastest."""


def next_event(text: str) -> NextEvent:
    """Returns a function that returns a text's events one after another. It uses libyaml if PyYAML has it, which is
    faster.

    The function raises `yaml.YAMLError` for invalid YAML.
    """
    parser: Any = yaml.CSafeLoader(text) if yaml.__with_libyaml__ else yaml.SafeLoader(text)
    return parser.get_event


_CORE_TAG_PREFIX = "tag:yaml.org,2002:"

_SCALAR_TAGS = ("str", "int", "float", "bool", "null")

_TAG_HINT = "remove the tag: scene files support `!!str`, `!!int`, `!!float`, `!!bool`, `!!null`, `!!map` and `!!seq`"


class NodeError(CodedError):
    """A node cannot be read."""


def scalar_value(event: NodeEvent) -> Scalar | None:
    """Returns the value of any scalar. None is null.

    Raises:
        NodeError: the tag is unknown or does not fit, or the number is out of range.
    """
    if event.tag is not None:
        return _read_tagged_scalar(event, event.tag)
    if not event.implicit[0]:
        return event.value
    return _read_plain_scalar(event.value)


def check_collection_tag(event: NodeEvent) -> None:
    """Accepts `!!map` on a mapping and `!!seq` on a list.

    Raises:
        NodeError: any other tag.
    """
    is_list = isinstance(event, SequenceStartEvent)
    if event.tag == _CORE_TAG_PREFIX + ("seq" if is_list else "map"):
        return
    tag = format_tag(event.tag or "")
    if tag in ("!!seq", "!!map", *("!!" + name for name in _SCALAR_TAGS)):
        raise NodeError("SC008", f"the tag `{tag}` cannot be on a {'list' if is_list else 'mapping'}", "remove the tag")
    raise NodeError("SC008", f"the tag `{tag}` is not one of YAML's core schema", _TAG_HINT)


def format_tag(tag: str) -> str:
    """Returns a tag as users write it: `!!int`, `!local`, `!<tag:example.org,2000:x>`."""
    if tag.startswith(_CORE_TAG_PREFIX):
        return "!!" + tag.removeprefix(_CORE_TAG_PREFIX)
    return tag if tag.startswith("!") else f"!<{tag}>"


def format_scalar(event: NodeEvent) -> str:
    """Returns the text of a scalar, shortened if it is long."""
    text = event.value if isinstance(event, ScalarEvent) else ""
    return text if len(text) <= 40 else f"{text[:37]}..."


def _read_plain_scalar(text: str) -> Scalar | None:
    try:
        return resolve_scalar(text)
    except OverflowError as error:
        shown = text if len(text) <= 40 else f"{text[:37]}..."
        raise NodeError("SC014", f"the number {shown} is {error}", "quote it if it is meant as a string") from None


def _read_tagged_scalar(event: NodeEvent, tag: str) -> Scalar | None:
    """Returns the value of a tagged scalar by the rule of its tag, quoted or not."""
    shown, text = format_tag(tag), event.value
    kind = tag.removeprefix(_CORE_TAG_PREFIX) if tag.startswith(_CORE_TAG_PREFIX) else ""
    if kind == "str":
        return text
    if kind in ("map", "seq"):
        raise NodeError("SC008", f"the tag `{shown}` cannot be on a single value", "remove the tag")
    if kind not in _SCALAR_TAGS:
        raise NodeError("SC008", f"the tag `{shown}` is not one of YAML's core schema", _TAG_HINT)
    value = _read_plain_scalar(text)
    if kind == "float" and isinstance(value, int) and not isinstance(value, bool):
        return float(value)  # at most 100 digits, always in the range of a double
    fits = {
        "int": isinstance(value, int) and not isinstance(value, bool),
        "float": isinstance(value, float),
        "bool": isinstance(value, bool),
        "null": value is None,
    }
    if not fits[kind]:
        raise NodeError("SC008", f"`{format_scalar(event)}` does not match the tag `{shown}`", "remove the tag")
    return value


def describe_type(value: object) -> str:
    """Returns the type of a value, in words."""
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
