"""Values of a plan in a few words, for tables and comparisons."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

_FEW = 4
"""How many numbers are told one by one."""

_LONGEST = 120


def rows_words(rows: NDArray[Any], name: Callable[[int], str] | None = None) -> str:
    """Rows (·, …): the one that all scenes have, a few by themselves, or else the range that they are in.

    `name`: what an index stands for.
    """
    write: Callable[[Any], str] = _text if name is None else lambda index: name(int(index))
    items = rows.tolist()
    if len(items) == 1:
        return write(items[0])
    few = _first_few(items)
    if len(few) <= _FEW or name is not None or rows.dtype == np.bool_:
        return " | ".join([*map(write, few[:_FEW]), *(["…"] if len(few) > _FEW else [])])
    return f"{_text(rows.min(axis=0).tolist())} to {_text(rows.max(axis=0).tolist())}"


def _first_few(items: list[Any]) -> list[Any]:
    """Items that differ, one more than a few at most."""
    found: dict[str, Any] = {}
    for item in items:
        found.setdefault(repr(item), item)
        if len(found) > _FEW:
            break
    return list(found.values())


def cut(text: str) -> str:
    """At most a line of it."""
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _text(item: Any) -> str:
    if isinstance(item, list):
        return f"[{', '.join(map(_text, item))}]"  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(item, bool):
        return "true" if item else "false"
    return repr(int(item)) if isinstance(item, float) and item.is_integer() and abs(item) < 1e6 else repr(item)
