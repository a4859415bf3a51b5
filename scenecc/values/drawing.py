"""Nodes that draw: from the generator's words to values, their bounds checked in every scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.values import columns, generator
from scenecc.values.failure import DrawError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.values.evaluate import Batch
    from scenecc.values.nodes import Chosen, Drawn, RandomRotated

WIDEST = 2**53
"""How many integers one draw may be among."""

CROSSED = "the lower bound is above the upper one"
CROSSED_CLIP = "the lower edge of `clip` is above the upper one"
NOT_POSITIVE = "the lower bound is not positive"
NEGATIVE = "the standard deviation is negative"
NOT_WHOLE = "a bound is no integer"
TOO_MANY = f"the bounds hold more than {WIDEST} integers"


def no_bound(node: Drawn) -> str:
    """What is said of a bound of another kind or size than what is drawn."""
    return f"a bound is not a number or a list of {node.shape[0]} numbers" if node.shape else "a bound is not a number"


def chosen(batch: Batch, node: Chosen) -> NDArray[np.int64]:
    """The index of the item that is chosen (B,)."""
    u = _units(batch, node, node.word, 1)[:, 0]
    return generator.choice(u, len(node.items), node.weights)


def rotated(batch: Batch, node: RandomRotated) -> NDArray[np.float64]:
    """Quaternions (B, 4)."""
    return generator.rotation(_units(batch, node, 0, 3))


def drawn(batch: Batch, node: Drawn) -> NDArray[Any]:
    """Numbers (B, *shape)."""
    low, high, *clip = bounds(batch, node)
    u = _units(batch, node, node.word, low.shape[1])
    match node.kind:
        case "uniform":
            values: NDArray[Any] = generator.uniform(u, low, high)
        case "log_uniform":
            values = generator.log_uniform(u, low, high)
        case "integers":
            values = generator.integers(u, low.astype(np.int64), high.astype(np.int64))
        case "normal":
            second = generator.units(generator.words(batch.seed, node.key, batch.scenes, node.word, u.shape[1], lane=1))
            values = low + high * generator.normal(u, second)
            values = np.clip(values, *clip) if clip else values
    return values if node.shape else values[:, 0]


def bounds(batch: Batch, node: Drawn) -> list[NDArray[np.float64]]:
    """Between what numbers are drawn, as the node has them: low, high and the edges of `clip`, each (B, n).

    Raises:
        DrawError: they are no bounds in one of the scenes.
    """
    count = node.shape[0] if node.shape else 1
    found = [_bound(batch, node, item, count) for item in (node.low, node.high, *(node.clip or ()))]
    low, high, *clip = found
    if node.kind == "normal":
        _refuse(batch, node, high < 0, NEGATIVE)
        if clip:
            _refuse(batch, node, clip[0] > clip[1], CROSSED_CLIP)
        return found
    _refuse(batch, node, low > high, CROSSED)
    if node.kind == "log_uniform":
        _refuse(batch, node, low <= 0, NOT_POSITIVE)
    elif node.kind == "integers":
        _refuse(batch, node, (low != np.floor(low)) | (high != np.floor(high)), NOT_WHOLE)
        _refuse(batch, node, (np.abs(low) > WIDEST) | (np.abs(high) > WIDEST), f"a bound is beyond {WIDEST}")
        _refuse(batch, node, high - low >= WIDEST, TOO_MANY)
    return found


def _units(batch: Batch, node: Chosen | Drawn | RandomRotated, first: int, count: int) -> NDArray[np.float64]:
    return generator.units(generator.words(batch.seed, node.key, batch.scenes, first, count))


def _bound(batch: Batch, node: Drawn, item: Any, count: int) -> NDArray[np.float64]:
    """A bound (B, count), the same for every component where it is one number."""
    values = columns.joined(batch.item(item))
    shapes = {(len(batch.scenes),), (len(batch.scenes), count)} if node.shape else {(len(batch.scenes),)}
    if values.dtype.kind not in "if" or values.shape not in shapes:
        raise DrawError(no_bound(node), int(batch.scenes[0]), node)
    bound = values.astype(np.float64, copy=False)
    bound = bound[:, None] if bound.ndim == 1 else bound
    # A range of half the largest number is no range that anything in a scene has.
    _refuse(batch, node, ~(np.abs(bound) < 1e300), "a bound is beyond 1e300")
    return np.broadcast_to(bound, (len(batch.scenes), count))


def _refuse(batch: Batch, node: Drawn, wrong: NDArray[np.bool_], message: str) -> None:
    if wrong.any():
        row = int(np.flatnonzero(wrong.any(axis=1))[0])
        raise DrawError(message, int(batch.scenes[row]), node)
