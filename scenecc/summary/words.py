"""Everything that a value can be, in few words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final, cast

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.values.support import Support

_LISTED: Final = 4
"""So many alternatives are written out."""

_LINE: Final = 60
"""And no more characters than these."""


def support_words(support: Support) -> str:
    """Alternatives (`0.1 | 0.5`), bounds (`0.1 … 0.5`), or what can be said without."""
    alternatives = support.alternatives
    if alternatives is None:
        return _bounds(support.low, support.high) if support.low is not None else "by an expression"
    return listed([item_words(item) for item in alternatives]) or (
        f"{len(alternatives)} values, {_bounds(support.low, support.high)}"
        if support.low is not None
        else f"{len(alternatives)} values"
    )


def listed(items: Sequence[str]) -> str | None:
    """Alternatives side by side; None where they are too many or too long."""
    text = " | ".join(items)
    return text if len(items) <= _LISTED and len(text) <= _LINE else None


def item_words(item: Any) -> str:
    """A number, truth value, text or vector."""
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, tuple):
        return f"[{', '.join(map(item_words, cast('tuple[Any, ...]', item)))}]"
    return f"{item:.5g}" if isinstance(item, int | float) else str(item)


def color_words(item: tuple[float, ...]) -> str:
    """A colour as files have it, `#rrggbb[aa]`, where its components are of 255 parts."""
    parts = [component * 255 for component in item]
    if not all(0 <= part <= 255 and math.isclose(part, round(part), abs_tol=1e-9) for part in parts):
        return item_words(item)
    digits = "".join(f"{round(part):02x}" for part in parts)
    return f"#{digits.removesuffix('ff') if len(parts) == 4 else digits}"


def _bounds(low: Any, high: Any) -> str:
    if not isinstance(low, tuple):
        return item_words(low) if low == high else f"{item_words(low)} … {item_words(high)}"
    parts = [_bounds(a, b) for a, b in zip(cast("tuple[Any, ...]", low), high, strict=True)]
    if len(set(parts)) == 1 and low != high:
        return f"{parts[0]} each"
    return f"[{', '.join(parts)}]"
