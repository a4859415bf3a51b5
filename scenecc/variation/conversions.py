"""Conversions to a field's row: colours as texts, one factor for three axes, corners without a height."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from scenecc.colors import read_color_text
from scenecc.geometry.rotations import MAX_COORDINATE

COLOR_TEXT = r"^#(?:[0-9a-fA-F]{6}|[0-9a-fA-F]{8})$"
"""A colour as a text: "#rrggbb" or "#rrggbbaa"."""

is_color_text = re.compile(COLOR_TEXT).fullmatch
"""Whether a text is a colour."""

Rgba = tuple[float, float, float, float]


def to_rgba(color: str | Sequence[float]) -> Rgba:
    """Converts a colour to linear RGBA: "#rrggbb" and "#rrggbbaa" are sRGB, a list is linear. Alpha is optional."""
    if isinstance(color, str):
        return read_color_text(color)
    red, green, blue, *rest = color
    return (red, green, blue, rest[0] if rest else 1.0)


def read_color(color: Any) -> Rgba | None:
    """Same as `to_rgba` for an unchecked value; None if it is not a colour."""
    if isinstance(color, str):
        return to_rgba(color) if is_color_text(color) else None
    return to_rgba(color) if _are_numbers(color) and len(color) in {3, 4} else None


def _read_light_color(color: Any) -> tuple[float, ...] | None:
    if isinstance(color, str):
        return to_rgba(color)[:3] if len(color) == 7 and is_color_text(color) else None
    return tuple(color) if _are_numbers(color) and len(color) == 3 else None


def _read_scale(scale: Any) -> tuple[float, ...] | None:
    if _are_numbers(scale):
        return tuple(scale) if len(scale) == 3 else None
    return (scale, scale, scale) if _are_numbers((scale,)) else None


def _opposite(flag: Any) -> bool | None:
    return not flag if isinstance(flag, bool) else None


def _corner(corner: Any, height: float) -> tuple[float, ...] | None:
    if not _are_numbers(corner) or len(corner) not in {2, 3}:
        return None
    return tuple(corner) if len(corner) == 3 else (*corner, height)


def _are_numbers(given: Any) -> bool:
    return given.__class__ in {tuple, list} and _NUMBERS.issuperset(map(type, given))


_NUMBERS = frozenset((int, float))


class Conversion(NamedTuple):
    """Converts a value to a row.

    Attributes:
        convert: gives the row of a value; None if it is invalid.
        shape: of the row.
    """

    convert: Callable[[Any], Any]
    shape: tuple[int, ...]


CONVERSIONS: dict[str, Conversion] = {
    "color": Conversion(read_color, (4,)),
    "light_color": Conversion(_read_light_color, (3,)),
    "scale": Conversion(_read_scale, (3,)),
    "opposite": Conversion(_opposite, ()),
    "low_corner": Conversion(partial(_corner, height=-MAX_COORDINATE), (3,)),
    "high_corner": Conversion(partial(_corner, height=MAX_COORDINATE), (3,)),
}
"""Conversions by their name in nodes: colours with alpha, without it, one factor or three, negation of a boolean, and
corners of a region, which is unbounded in z if they have no height.
"""
