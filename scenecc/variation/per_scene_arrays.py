"""Plain values as arrays with one row a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.variation.operations import LISTS, as_lists

if TYPE_CHECKING:
    from numpy.typing import NDArray


def value_array(data: Any) -> NDArray[Any]:
    """One value: float64, int64 or bool of its own shape, or an object of shape () for anything else."""
    whole = row_array([data])
    return whole[0] if whole.ndim > 1 else whole.reshape(())


def row_array(items: Sequence[Any]) -> NDArray[Any]:
    """Several values, one a row; objects where they are not all numbers, or all booleans, of one shape."""
    if not any(map(_has_text, items)) and len({type(item) is bool for item in items}) <= 1:
        try:
            whole = np.array(items)
        except ValueError:
            # Rows of several lengths.
            return object_array(items)
        # Integers of 64 bits without a sign would lose their highest.
        if whole.dtype.kind in "bif":
            return to_value_dtype(whole)
    return object_array(items)


def typed_row_array(items: Sequence[Any]) -> NDArray[Any]:
    """As `table`, but objects where integers stand beside floats.

    A text tells 1 from 1.0, and what a scene has must not depend on what others have.
    """
    return row_array(items) if len(_kinds(items)) <= 1 else object_array(items)


def _kinds(items: Sequence[Any]) -> set[type]:
    kinds = set(map(type, items))
    if kinds.isdisjoint(LISTS):
        return kinds
    return {kind for item in items for kind in (_kinds(item) if type(item) in LISTS else {type(item)})}


def object_array(items: Sequence[Any]) -> NDArray[Any]:
    """Several values of any kind, one a row; lists where they were tuples."""
    whole = np.empty(len(items), dtype=object)
    for index, item in enumerate(items):
        whole[index] = as_lists(item)
    return whole


def to_value_dtype(array: NDArray[Any]) -> NDArray[Any]:
    """An array in one of the kinds that values have: float64, int64, bool or object."""
    if array.dtype.kind == "f":
        return array.astype(np.float64, copy=False)
    if array.dtype.kind in "iu":
        return array.astype(np.int64, copy=False)
    return array if array.dtype.kind == "b" else array.astype(object, copy=False)


def distinct_rows(rows: NDArray[Any]) -> NDArray[np.intp]:
    """Where the different rows (B, …) stand first, in order: to the bit, so that 0.0 is not -0.0."""
    if rows.dtype == object or len(rows) < 2 or not rows[0].size:
        return np.arange(len(rows))
    flat = np.ascontiguousarray(rows).reshape(len(rows), -1)
    _, first = np.unique(flat.view(np.dtype((np.void, flat.dtype.itemsize * flat.shape[1]))), return_index=True)
    return np.sort(first)


def merge_rows(size: int, parts: Sequence[tuple[NDArray[np.intp], NDArray[Any]]]) -> NDArray[Any]:
    """One array of `size` rows from parts, each with the rows where it belongs.

    Integers stay integers beside floats: which parts there are is the batch's, and a text tells 1 from 1.0.
    """
    shapes = {part.shape[1:] for _, part in parts}
    kinds = {part.dtype.kind for _, part in parts}
    if len(shapes) == 1 and len(kinds) == 1:
        whole = np.empty((size, *shapes.pop()), dtype=parts[0][1].dtype)
        for rows, part in parts:
            whole[rows] = part
        return whole
    whole = np.empty(size, dtype=object)
    for rows, part in parts:
        for row, value in zip(rows.tolist(), part.tolist(), strict=True):
            whole[row] = value
    return whole


def to_field_rows(rows: NDArray[Any]) -> NDArray[Any]:
    """Rows (B, …) as a field takes them, to which integers and floats are numbers alike; others as they are."""
    return row_array(rows.tolist()) if rows.dtype == object else rows


def _has_text(item: Any) -> bool:
    """Whether it is a text or a list with one: numpy would make all as wide as the longest."""
    return type(item) is str or (type(item) in LISTS and str in set(map(type, item)))
