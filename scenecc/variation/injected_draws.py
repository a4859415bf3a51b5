"""Arrays that replace shared draws, and their required types and shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.variation.nodes import Drawn, Node, Shuffled, Stacked

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from scenecc.variation.bounds import ValueBounds


class DrawType(NamedTuple):
    """The declared type of a shared draw in a scene.

    Attributes:
        kind: numbers, integers, flags or texts; None if unknown, or if it varies by scene.
        shape: of the value in one scene; None if unknown, or if it varies by scene.
    """

    kind: str | None = None
    shape: tuple[int, ...] | None = None


class InjectedDrawError(ValueError):
    """An array cannot replace a draw. The message continues after the array's name."""

    hint: str | None = None


class InjectedShapeError(InjectedDrawError):
    """An array has the wrong shape."""

    hint = "one row for each scene"


def draw_type(node: Node, found: ValueBounds) -> DrawType:
    """The declared type of a draw. `found`: its bounds, which give the type of most expressions."""
    if _draws_integers(node):
        assert isinstance(node, Drawn | Stacked)
        return DrawType("integers", node.shape if isinstance(node, Drawn) else (len(node.items),))
    if isinstance(node, Drawn):
        return DrawType("numbers", node.shape)
    listed = (node.items,) if isinstance(node, Shuffled) else found.alternatives
    values = listed or (() if found.low is None else (found.low,))
    kinds, shapes = set(map(_kind, values)), set(map(_shape, values))
    return DrawType(kinds.pop() if len(kinds) == 1 else None, shapes.pop() if len(shapes) == 1 else None)


def convert_injected(rows: ArrayLike, wanted: DrawType, count: int) -> NDArray[Any]:
    """Converts an array from the user with one row per scene to float64, int64, bool or texts.

    Args:
        rows: as given.
        wanted: declared type of the draw. Its range is not checked, since an array may have values that no form draws.
        count: of scenes.

    Raises:
        InjectedDrawError: it is not an array, or not of that kind and shape.
    """
    data = _array(rows)
    if wanted.shape is None:
        if data.ndim not in {1, 2} or len(data) != count or not data.size:
            raise InjectedShapeError(f"must be of shape ({count},) or ({count}, k), not {data.shape}")
    elif data.shape != (count, *wanted.shape):
        raise InjectedShapeError(f"must be of shape {(count, *wanted.shape)}, as the file declares, not {data.shape}")
    kind = _KINDS.get(data.dtype.kind)
    if kind is None:
        raise InjectedDrawError(f"must be of {wanted.kind or 'numbers, booleans or strings'}, not of other objects")
    if kind == "numbers":
        _check_finite(data)
    if wanted.kind == "integers" and kind == "numbers":
        return _integers(data)
    if wanted.kind not in {None, kind}:
        raise InjectedDrawError(f"must be of {wanted.kind}, as the file declares, not of {kind}")
    # A draw of numbers gives floats, and text shows 1 and 1.0 differently.
    return data.astype(np.float64) if wanted.kind == "numbers" else data


_KINDS: dict[str, str] = {"b": "flags", "i": "numbers", "u": "numbers", "f": "numbers", "U": "texts"}


def _array(rows: ArrayLike) -> NDArray[Any]:
    try:
        if isinstance(rows, np.ma.MaskedArray):
            # Masked values are missing, whatever number they hold.
            masked: Any = rows  # pyright: ignore[reportUnknownVariableType] - of any kind
            rows = masked.astype(np.float64).filled(np.nan)
        data = np.asarray(rows)
        # Columns of a table often have the dtype object, whatever they contain.
        return np.asarray(data.tolist()) if data.dtype == object else data
    except ValueError as error:
        raise InjectedShapeError("must have rows of one length") from error


def _check_finite(data: NDArray[Any]) -> None:
    wrong = np.flatnonzero(~np.isfinite(data).reshape(len(data), -1).all(axis=1))
    if wrong.size:
        raise InjectedDrawError(f"must be of finite numbers: row {wrong[0]} is {data[wrong[0]].tolist()}")


def _integers(data: NDArray[Any]) -> NDArray[np.int64]:
    whole = (data == np.floor(data)) & (data >= -(2.0**63)) & (data < 2.0**63)
    wrong = np.flatnonzero(~whole.reshape(len(data), -1).all(axis=1))
    if wrong.size:
        raise InjectedDrawError(
            f"must be of integers, as the file declares: row {wrong[0]} is {data[wrong[0]].tolist()}"
        )
    return data.astype(np.int64)


def _draws_integers(node: Any) -> bool:
    if isinstance(node, Stacked):
        return all(map(_draws_integers, node.items))
    return isinstance(node, Drawn) and node.distribution.whole


def _kind(value: Any) -> str | None:
    if value.__class__ is tuple:
        kinds = set(map(_kind, value))
        return kinds.pop() if len(kinds) == 1 else None
    return _OF_TYPE.get(value.__class__)


_OF_TYPE: dict[type[Any], str] = {bool: "flags", int: "numbers", float: "numbers", str: "texts"}


def _shape(value: Any) -> tuple[int, ...] | None:
    if value.__class__ is not tuple:
        return ()
    shapes = set(map(_shape, value))
    inner = shapes.pop() if len(shapes) == 1 else None
    return None if inner is None else (len(value), *inner)
