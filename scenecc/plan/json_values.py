"""Reads numbers from a plan's JSON and checks their types, shapes and ranges."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from scenecc.plan.properties import FLOAT32_MAX
from scenecc.plan.value import Value

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.properties import Bounds
    from scenecc.plan.schema import Quantity, ScalarKind


@dataclass(frozen=True, slots=True)
class JsonProblem:
    """What is wrong with some numbers, and where below them."""

    code: str
    message: str
    keys: tuple[str | int, ...] = ()


def is_object(data: object) -> TypeGuard[dict[str, Any]]:
    """Whether this is an object of JSON."""
    return isinstance(data, dict)


def is_list(data: object) -> TypeGuard[list[Any]]:
    """Whether this is a list of JSON."""
    return isinstance(data, list)


_JSON_TYPES = {
    np.float64: (frozenset({float, int}), "a number"),
    np.int64: (frozenset({int}), "an integer"),
    np.bool_: (frozenset({bool}), "true or false"),
}


def read_number(kind: ScalarKind, item: object) -> int | float | JsonProblem:
    """One number that is the same in every scene."""
    wanted = "a number" if kind.type is float else "an integer"
    if isinstance(item, bool) or not isinstance(item, (int, float) if kind.type is float else int):
        return JsonProblem("SC705", f"{wanted} is wanted here, not {describe_json(item)}")
    if kind.type is float and not abs(item) <= sys.float_info.max:
        return JsonProblem("SC707", f"{describe_json(item)} is outside the range: it must be finite")
    if not kind.bounds.allow(item):
        return JsonProblem("SC707", f"{describe_json(item)} is outside the range: it must be {kind.bounds}")
    return kind.type(item)  # type: ignore[return-value]


def read_rows(kind: Quantity, rows: list[Any], table_size: int | None) -> Value | JsonProblem:
    """Rows of a quantity. `table_size`: entries of the table that indices point into.

    Hundreds of thousands of numbers are checked as arrays; only when those checks fail is the culprit looked for.
    """
    if kind.shape:
        fault = _check_shape(kind.shape[0], rows)
        if fault is not None:
            return fault
    flat = list(chain.from_iterable(rows)) if kind.shape else rows
    types, word = _JSON_TYPES[kind.dtype]
    if not set(map(type, flat)) <= types:
        index = next(i for i, item in enumerate(flat) if type(item) not in types)
        return JsonProblem("SC705", f"{word} is wanted here, not {describe_json(flat[index])}", _row_keys(kind, index))
    try:
        data = np.array(rows, dtype=kind.dtype).reshape(len(rows), *kind.shape)
    except OverflowError:
        index = next(i for i, item in enumerate(flat) if abs(item) >= 2**63)
        return JsonProblem("SC707", f"{describe_json(flat[index])} is too large", _row_keys(kind, index))
    fault = _check_range(kind, data, table_size) or (_check_rotation(data) if kind.pose else None)
    if fault is None and kind.infinite:
        fault = _check_limits(data)
    if fault is not None:
        return fault
    data.flags.writeable = False
    return Value(data)


def _check_shape(count: int, rows: list[Any]) -> JsonProblem | None:
    for index, row in enumerate(rows):
        if not is_list(row):
            return JsonProblem("SC705", f"a list of {count} is wanted here, not {describe_json(row)}", (index,))
        if len(row) != count:
            return JsonProblem("SC706", f"a list of {count} is wanted here, not of {len(row)}", (index,))
    return None


def _check_range(kind: Quantity, data: NDArray[Any], table_size: int | None) -> JsonProblem | None:
    if kind.dtype is np.bool_:
        return None
    flat = data.reshape(-1)
    if table_size is not None:
        outside = np.flatnonzero((flat < 0) | (flat >= table_size))
        if outside.size:
            message = f"there is no entry {flat[outside[0]]} in `{kind.table}`, which has {table_size}"
            return JsonProblem("SC708", message, _row_keys(kind, int(outside[0])))
        return None
    outside = np.flatnonzero(_out_of_bounds(kind.bounds, flat))
    if not outside.size:
        return None
    item = flat[outside[0]]
    wanted = str(kind.bounds) if np.isfinite(item) else "finite"
    return JsonProblem(
        "SC707", f"{item.item()!r} is outside the range: it must be {wanted}", _row_keys(kind, int(outside[0]))
    )


def _out_of_bounds(bounds: Bounds, flat: NDArray[Any]) -> NDArray[np.bool_]:
    outside = ~((flat >= bounds.low) & (flat <= bounds.high))
    return outside | (flat == 0) if bounds.nonzero else outside


def _check_rotation(data: NDArray[Any]) -> JsonProblem | None:
    # Poses are composed by now, so that rounding of several rotations may have added up.
    with np.errstate(over="ignore"):
        wrong = np.flatnonzero(np.abs(np.linalg.norm(data[:, 3:], axis=1) - 1) > 1e-3)
    if not wrong.size:
        return None
    return JsonProblem("SC707", "the rotation [w, x, y, z] is not of length 1", (int(wrong[0]),))


def _check_limits(data: NDArray[Any]) -> JsonProblem | None:
    """Pairs of a lowest and a highest number, of which the one may be -inf and the other inf."""
    low, high = data[:, 0], data[:, 1]
    wrong = np.flatnonzero((low > high) | np.isposinf(low) | np.isneginf(high))
    if wrong.size:
        message = f"the limits {data[wrong[0]].tolist()} leave nothing between them: the lower one comes first"
        return JsonProblem("SC707", message, (int(wrong[0]),))
    large = np.argwhere(np.isfinite(data) & (np.abs(data) > FLOAT32_MAX))
    if not large.size:
        return None
    row, side = large[0].tolist()
    message = f"{data[row, side].item()!r} is outside the range: it must be within ±{FLOAT32_MAX:g}, or infinite"
    return JsonProblem("SC707", message, (row, side))


def _row_keys(kind: Quantity, index: int) -> tuple[int, ...]:
    return divmod(index, kind.shape[0]) if kind.shape else (index,)


def describe_json(item: object) -> str:
    """An item of JSON in a message."""
    if is_object(item) or is_list(item):
        return "a list" if is_list(item) else "an object"
    text = json.dumps(item) if not isinstance(item, int) or abs(item) < 2**64 else "an integer beyond 64 bits"
    return text if len(text) <= 60 else text[:60] + "…"


class RepeatedKeyError(ValueError):
    """A key that stands twice in one object. Its words are the key."""


def reject_repeated_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An `object_pairs_hook`.

    Raises:
        RepeatedKeyError: a key stands twice.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        raise RepeatedKeyError(next(repr(key[:80]) for key, _ in pairs if key in seen or seen.add(key)))
    return found
