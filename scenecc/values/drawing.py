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

_WIDEST = 2**53
"""How many integers one draw may be among."""


def chosen(batch: Batch, node: Chosen) -> NDArray[np.int64]:
    """The index of the item that is chosen (B,)."""
    u = _units(batch, node, node.word, 1)[:, 0]
    return generator.choice(u, len(node.items), node.weights)


def rotated(batch: Batch, node: RandomRotated) -> NDArray[np.float64]:
    """Quaternions (B, 4)."""
    return generator.rotation(_units(batch, node, 0, 3))


def drawn(batch: Batch, node: Drawn) -> NDArray[Any]:
    """Numbers (B, *shape)."""
    count = node.shape[0] if node.shape else 1
    u = _units(batch, node, node.word, count)
    low, high = _bound(batch, node, node.low, count), _bound(batch, node, node.high, count)
    match node.kind:
        case "uniform":
            _refuse(batch, node, low > high, "the lower bound is above the upper one")
            values: NDArray[Any] = generator.uniform(u, low, high)
        case "log_uniform":
            _refuse(batch, node, low > high, "the lower bound is above the upper one")
            _refuse(batch, node, low <= 0, "the lower bound is not positive")
            values = generator.log_uniform(u, low, high)
        case "integers":
            values = _integers(batch, node, u, low, high)
        case "normal":
            values = _normal(batch, node, u, low, high)
    return values if node.shape else values[:, 0]


def _integers(
    batch: Batch, node: Drawn, u: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.int64]:
    _refuse(batch, node, low > high, "the lower bound is above the upper one")
    _refuse(batch, node, (low != np.floor(low)) | (high != np.floor(high)), "a bound is no integer")
    _refuse(batch, node, (np.abs(low) > _WIDEST) | (np.abs(high) > _WIDEST), f"a bound is beyond {_WIDEST}")
    _refuse(batch, node, high - low >= _WIDEST, f"the bounds hold more than {_WIDEST} integers")
    return generator.integers(u, low.astype(np.int64), high.astype(np.int64))


def _normal(
    batch: Batch, node: Drawn, u: NDArray[np.float64], mean: NDArray[np.float64], std: NDArray[np.float64]
) -> NDArray[np.float64]:
    _refuse(batch, node, std < 0, "the standard deviation is negative")
    second = generator.units(generator.words(batch.seed, node.key, batch.scenes, node.word, u.shape[1], lane=1))
    values = mean + std * generator.normal(u, second)
    if node.clip is None:
        return values
    low, high = (_bound(batch, node, bound, u.shape[1]) for bound in node.clip)
    _refuse(batch, node, low > high, "the lower edge of `clip` is above the upper one")
    return np.clip(values, low, high)


def _units(batch: Batch, node: Chosen | Drawn | RandomRotated, first: int, count: int) -> NDArray[np.float64]:
    return generator.units(generator.words(batch.seed, node.key, batch.scenes, first, count))


def _bound(batch: Batch, node: Drawn, item: Any, count: int) -> NDArray[np.float64]:
    """A bound (B, count), the same for every component where it is one number."""
    values = columns.joined(batch.item(item))
    shapes = {(len(batch.scenes),), (len(batch.scenes), count)} if node.shape else {(len(batch.scenes),)}
    if values.dtype.kind not in "if" or values.shape not in shapes:
        wanted = f"a number or a list of {count} numbers" if node.shape else "a number"
        raise DrawError(f"a bound is not {wanted}", int(batch.scenes[0]), node)
    bound = values.astype(np.float64, copy=False)
    bound = bound[:, None] if bound.ndim == 1 else bound
    # A range of half the largest number is no range that anything in a scene has.
    _refuse(batch, node, ~(np.abs(bound) < 1e300), "a bound is beyond 1e300")
    return np.broadcast_to(bound, (len(batch.scenes), count))


def _refuse(batch: Batch, node: Drawn, wrong: NDArray[np.bool_], message: str) -> None:
    if wrong.any():
        row = int(np.flatnonzero(wrong.any(axis=1))[0])
        raise DrawError(message, int(batch.scenes[row]), node)
