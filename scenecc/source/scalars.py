"""Plain scalars by the core schema of YAML 1.2 (section 10.3.2 of its specification)."""

from __future__ import annotations

import re
from math import inf, isinf, nan

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

RESERVED_IN_KEY_MESSAGE = "a key holds the character U+0000"
"""What is said of a key with it."""

SCENE_KEYED_FIELD = "per_scene"
"""The one key whose mapping is by scene index: there an integer key stands for its digits."""

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
