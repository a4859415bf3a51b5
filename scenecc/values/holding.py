"""One number of several, moved and held between bounds: where a joint starts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.values.failure import DrawError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.values.evaluate import Batch
    from scenecc.values.nodes import Held


def held(batch: Batch, node: Held) -> NDArray[Any]:
    """The numbers (B,) of a node.

    Raises:
        DrawError: what it is made of are no numbers, or too few.
    """
    rows = batch.item(node.of)
    is_single = node.index < 0
    if rows.dtype.kind not in "fi" or rows.ndim != (1 if is_single else 2):
        wanted = "a number" if is_single else "a list of numbers"
        raise DrawError(f"this is not {wanted}", int(batch.scenes[0]), node)
    if not is_single:
        if node.index >= rows.shape[1]:
            raise DrawError(f"this has {rows.shape[1]} numbers only", int(batch.scenes[0]), node)
        rows = rows[:, node.index]
    moved = batch.item(node.factor) * rows + batch.item(node.offset)
    return np.maximum(np.minimum(moved.astype(np.float64), batch.item(node.high)), batch.item(node.low))
