"""Values of a plan in a few words, for tables and comparisons."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import NDArray

    from scenecc.plan.value import Value

_FEW = 4
"""How many numbers are told one by one."""

_LONGEST = 120


def value_words(value: Value, names: Sequence[str] | None = None) -> str:
    """A value as drawn: itself where it is the same in every scene, else the range that its rows are in.

    Args:
        value: whose data are drawn if they are not yet.
        names: what its indices stand for; None: its numbers are what they are.
    """
    return rows_words(value.data, None if names is None else lambda index: names[index])


def rows_words(rows: NDArray[Any], name: Callable[[int], str] | None = None) -> str:
    """As `value_words`, of rows (·, …); `name`: what an index stands for."""
    write: Callable[[Any], str] = _text if name is None else lambda index: name(int(index))
    items = rows.tolist()
    if len(items) == 1:
        return write(items[0])
    distinct = list(dict.fromkeys(json.dumps(item) for item in items))
    if len(distinct) <= _FEW or name is not None or rows.dtype == np.bool_:
        shown = [write(json.loads(item)) for item in distinct[:_FEW]]
        return " | ".join([*shown, *(["…"] if len(distinct) > _FEW else [])])
    return f"{_text(rows.min(axis=0).tolist())} to {_text(rows.max(axis=0).tolist())}"


def cut(text: str) -> str:
    """At most a line of it."""
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"


def _text(item: Any) -> str:
    if isinstance(item, list):
        return f"[{', '.join(map(_text, item))}]"  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(item, bool):
        return "true" if item else "false"
    return repr(int(item)) if isinstance(item, float) and item.is_integer() and abs(item) < 1e6 else repr(item)
