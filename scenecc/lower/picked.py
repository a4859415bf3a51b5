"""One of several values in each scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.plan import Value, per_scene, varying

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray


def picked(values: Sequence[Value], pick: Value, rows: int) -> Value:
    """The value with the number that `pick` gives, scene by scene.

    Args:
        values: of one dtype and shape.
        pick: (·,) index into them.
        rows: how many scenes there are.
    """
    first = values[0]
    if all(value is first or _same(value, first) for value in values):
        return first
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.bounds import union_bounds  # noqa: PLC0415 - likewise

    def draw() -> NDArray[Any]:
        which = np.broadcast_to(pick.data, (rows,))
        drawn = np.empty((rows, *first.data.shape[1:]), dtype=first.data.dtype)
        for number, value in enumerate(values):
            mine = which == number
            drawn[mine] = np.broadcast_to(value.data, drawn.shape)[mine]
        return drawn

    if pick.known and all(value.known for value in values):
        return per_scene(draw(), first.data.dtype)
    return varying(draw, bounds=union_bounds([value.bounds for value in values]), rows=rows)


def _same(a: Value, b: Value) -> bool:
    return a.is_constant and b.is_constant and a.numbers() == b.numbers()
