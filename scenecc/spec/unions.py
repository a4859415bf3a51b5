"""Unions by the kind of YAML node alone, so that a mistake gives one error, not one a branch."""

from __future__ import annotations

from pydantic import Discriminator

WRONG_KIND = "wrong_kind"
"""The error type of a node that fits no branch; its message says what would."""


_KINDS: dict[type, str] = {
    bool: "#flag",
    int: "#number",
    float: "#number",
    str: "#word",
    list: "#list",
    tuple: "#list",
    dict: "#mapping",
}


def kind(value: object) -> str | None:
    """The tag of a node's kind. Tags start with `#`, which no key that leads to a union does.

    Documents hold plain data, so its exact type tells a node's kind.
    """
    return _KINDS.get(type(value))


def by_kind(expected: str) -> Discriminator:
    """A union whose branches carry the tags of `kind`.

    Args:
        expected: what a user may write, as it stands in the message: "[x, y, z] or a mapping".
    """
    return Discriminator(kind, custom_error_type=WRONG_KIND, custom_error_message=expected, custom_error_context=None)
