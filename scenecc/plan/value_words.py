"""Everything that a value can be, in few words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, cast

from scenecc.variation.bounds import ValueBounds

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

_LISTED: Final = 4
"""So many alternatives are written out."""

_LINE: Final = 60
"""And no more characters than these."""

DIGITS: Final = 5
"""So many digits of a number, where no more are needed to tell it from another."""

_MORE_DIGITS: Final = (DIGITS, 8, 12, 17)


def support_words(support: ValueBounds) -> str:
    """Alternatives (`0.1 | 0.5`), bounds (`0.1 … 0.5`), or what can be said without."""
    alternatives = support.alternatives
    if alternatives is None:
        return _bounds(support.low, support.high) if support.low is not None else "by an expression"
    return listed([item_words(item) for item in alternatives]) or (
        f"{len(alternatives)} values, {_bounds(support.low, support.high)}"
        if support.low is not None
        else f"{len(alternatives)} values"
    )


def part_of(support: ValueBounds, start: int, end: int) -> ValueBounds:
    """Some components of a vector."""
    if support.alternatives is not None:
        return ValueBounds.of(item[start:end] for item in support.alternatives)
    return ValueBounds(None, support.low[start:end], support.high[start:end], support.exact)


def is_any_rotation(q: ValueBounds) -> bool:
    """Whether a quaternion may be any: its bounds say little, unless they leave out an axis."""
    return q.alternatives is None and q.low == (-1, -1, -1, -1) and q.high == (1, 1, 1, 1)


def listed(items: Sequence[str]) -> str | None:
    """Alternatives side by side; None where they are too many or too long."""
    text = " | ".join(items)
    return text if len(items) <= _LISTED and len(text) <= _LINE else None


def item_words(item: Any, digits: int = DIGITS) -> str:
    """A number to so many digits, truth value, text or vector."""
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, tuple):
        return f"[{', '.join(item_words(one, digits) for one in cast('tuple[Any, ...]', item))}]"
    return f"{item:.{digits}g}" if isinstance(item, int | float) else str(item)


def color_words(item: tuple[float, ...], digits: int = DIGITS) -> str:
    """A colour as files have it, `#rrggbb[aa]`, where its components are of 255 parts."""
    parts = [component * 255 for component in item]
    if not all(0 <= part <= 255 and math.isclose(part, round(part), abs_tol=1e-9) for part in parts):
        return item_words(item, digits)
    text = "".join(f"{round(part):02x}" for part in parts)
    return f"#{text.removesuffix('ff') if len(parts) == 4 else text}"


def pair_words(a: Sequence[Any], b: Sequence[Any], show: Callable[[Any, int], str] = item_words) -> tuple[str, str]:
    """Two sets of items that occur, with as many digits as it takes to tell one from the other."""
    first, second = _distinct(a), _distinct(b)
    both = ("", "")
    for digits in _MORE_DIGITS:
        both = _set_words(first, digits, show), _set_words(second, digits, show)
        if both[0] != both[1]:
            break
    return both


def set_words(items: Sequence[Any], show: Callable[[Any, int], str] = item_words) -> str:
    """A set of items that occur."""
    return _set_words(_distinct(items), DIGITS, show)


def _distinct(items: Sequence[Any]) -> list[Any]:
    return list({repr(item): item for item in items}.values())


def _set_words(items: list[Any], digits: int, show: Callable[[Any, int], str]) -> str:
    text = listed([show(item, digits) for item in items])
    if text is not None or not _are_numbers(items):
        return text or (show(items[0], digits) if len(items) == 1 else f"{len(items)} values")
    if not isinstance(items[0], tuple):
        return _bounds(min(items), max(items), digits)
    columns = list(zip(*items, strict=True))
    return _bounds(tuple(map(min, columns)), tuple(map(max, columns)), digits)


def _are_numbers(items: list[Any]) -> bool:
    """Whether they are numbers, or vectors of these of one length."""
    if not isinstance(items[0], tuple):
        return all(isinstance(item, int | float) and not isinstance(item, bool) for item in items)
    vectors = cast("list[tuple[Any, ...]]", [item for item in items if isinstance(item, tuple)])
    lengths = {len(vector) for vector in vectors}
    return len(vectors) == len(items) and len(lengths) == 1 and all(_are_numbers([*vector]) for vector in vectors)


def _bounds(low: Any, high: Any, digits: int = DIGITS) -> str:
    if not isinstance(low, tuple):
        first = item_words(low, digits)
        return first if low == high else f"{first} … {item_words(high, digits)}"
    parts = [_bounds(a, b, digits) for a, b in zip(cast("tuple[Any, ...]", low), high, strict=True)]
    if len(set(parts)) == 1 and low != high:
        return f"{parts[0]} each"
    return f"[{', '.join(parts)}]"
