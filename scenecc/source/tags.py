"""Scalars and collections out of the common: tagged, or not what a scene can hold."""

from __future__ import annotations

from scenecc.source.parsing import NodeEvent, ScalarEvent, SequenceStartEvent
from scenecc.source.scalars import Scalar, resolve

_CORE = "tag:yaml.org,2002:"
_SCALAR_TAGS = ("str", "int", "float", "bool", "null")
_TAG_HINT = "take the tag away: scene files know `!!str`, `!!int`, `!!float`, `!!bool`, `!!null`, `!!map` and `!!seq`"


class Refused(Exception):
    """A node that cannot be read.

    Attributes:
        code, message, hint: what to report.
    """

    def __init__(self, code: str, message: str, hint: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.hint = hint


def scalar_value(event: NodeEvent) -> Scalar | None:
    """The value of any scalar. None is null.

    Raises:
        Refused: a tag that is unknown or does not fit, or a number that cannot be held.
    """
    if event.tag is not None:
        return _tagged(event, event.tag)
    if not event.implicit[0]:
        return event.value
    return _plain(event.value)


def check_collection_tag(event: NodeEvent) -> None:
    """Lets pass `!!map` on a mapping and `!!seq` on a list.

    Raises:
        Refused: any other tag.
    """
    is_list = isinstance(event, SequenceStartEvent)
    if event.tag == _CORE + ("seq" if is_list else "map"):
        return
    tag = shown_tag(event.tag or "")
    if tag in ("!!seq", "!!map", *("!!" + name for name in _SCALAR_TAGS)):
        raise Refused("SC008", f"the tag `{tag}` stands on a {'list' if is_list else 'mapping'}", "take the tag away")
    raise Refused("SC008", f"the tag `{tag}` is not one of YAML's core schema", _TAG_HINT)


def shown_tag(tag: str) -> str:
    """A tag as people write it: `!!int`, `!local`, `!<tag:example.org,2000:x>`."""
    if tag.startswith(_CORE):
        return "!!" + tag.removeprefix(_CORE)
    return tag if tag.startswith("!") else f"!<{tag}>"


def shown_scalar(event: NodeEvent) -> str:
    """The text of a scalar, cut where it is long."""
    text = event.value if isinstance(event, ScalarEvent) else ""
    return text if len(text) <= 40 else f"{text[:37]}..."


def _plain(text: str) -> Scalar | None:
    try:
        return resolve(text)
    except OverflowError as error:
        shown = text if len(text) <= 40 else f"{text[:37]}..."
        raise Refused("SC014", f"the number {shown} is {error}", "quote it if it is meant as a string") from None


def _tagged(event: NodeEvent, tag: str) -> Scalar | None:
    """The value of a tagged scalar, read by the tag's own rule, quoted or not."""
    shown, text = shown_tag(tag), event.value
    kind = tag.removeprefix(_CORE) if tag.startswith(_CORE) else ""
    if kind == "str":
        return text
    if kind in ("map", "seq"):
        raise Refused("SC008", f"the tag `{shown}` stands on a single value", "take the tag away")
    if kind not in _SCALAR_TAGS:
        raise Refused("SC008", f"the tag `{shown}` is not one of YAML's core schema", _TAG_HINT)
    value = _plain(text)
    if kind == "float" and isinstance(value, int) and not isinstance(value, bool):
        return float(value)  # at most 100 digits: always within the range of a double
    fits = {
        "int": isinstance(value, int) and not isinstance(value, bool),
        "float": isinstance(value, float),
        "bool": isinstance(value, bool),
        "null": value is None,
    }
    if not fits[kind]:
        raise Refused("SC008", f"`{shown_scalar(event)}` is not what the tag `{shown}` says", "take the tag away")
    return value


def kind(value: object) -> str:
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
