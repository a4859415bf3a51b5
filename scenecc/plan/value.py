"""A number, vector, flag or table index that may differ from scene to scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import DTypeLike, NDArray

_put = object.__setattr__


class Value:
    """One quantity over the scenes of an entity. Nothing of it can be changed.

    Attributes:
        data: float64, int64 or bool, read-only. The leading axis is 1 (the same in every scene) or
            the number of scenes that the entity is in, by ascending scene index. What follows is
            the quantity's own shape: () for a scalar, (3,) for a vector, (7,) for a pose (p then q,
            wxyz).

    Two values are equal if every bit of their data is.
    """

    __slots__ = ("_literal", "data")

    data: NDArray[Any]
    _literal: tuple[float | tuple[float, ...], DTypeLike]

    def __init__(self, data: NDArray[Any]) -> None:
        _put(self, "data", data)

    def __getattr__(self, name: str) -> Any:
        """The array of a `literal`, made when it is first asked for: checking a scene seldom does."""
        if name != "data":
            raise AttributeError(f"a Value has no attribute {name!r}", name=name, obj=self)
        import numpy as np  # noqa: PLC0415 - checking a scene needs none

        item, dtype = self._literal
        data = np.array((item,), dtype=dtype)
        data.flags.writeable = False
        _put(self, "data", data)
        return data

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a Value is read-only: {name!r} cannot be set", name=name, obj=self)

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a Value is read-only: {name!r} cannot be deleted", name=name, obj=self)

    def __reduce__(self) -> tuple[type[Value], tuple[NDArray[Any]]]:
        return Value, (self.data,)

    def __repr__(self) -> str:
        return f"Value(data={self.data!r})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Value):
            return NotImplemented
        a, b = self.data, other.data
        return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()

    def __hash__(self) -> int:
        return hash((self.data.dtype.str, self.data.shape, self.data.tobytes()))

    @property
    def varies(self) -> bool:
        """Whether the scenes do not all have the same."""
        return not hasattr(self, "_literal") and self.data.shape[0] != 1

    def numbers(self) -> tuple[float, ...]:
        """All numbers of all rows, one after another; for a `literal`'s own no array is made."""
        if not hasattr(self, "_literal"):
            return tuple(self.data.ravel().tolist())
        item, _ = self._literal
        return item if isinstance(item, tuple) else (item,)

    def row(self, index: int) -> Any:
        """What the entity's scene number `index` (a row, not a scene index) has."""
        return self.data[index if self.data.shape[0] != 1 else 0]


_new = object.__new__
_put_literal: Any = Value.__dict__["_literal"].__set__
"""The slot's own setter, which is quicker than `object.__setattr__`."""


def literal(item: float | tuple[float, ...], dtype: DTypeLike = "float64") -> Value:
    """As `constant`, of a number or a flat tuple of numbers; the array is made when it is first asked for."""
    value = _new(Value)
    _put_literal(value, (item, dtype))
    return value


def constant(item: float | Sequence[Any] | NDArray[Any], dtype: DTypeLike = "float64") -> Value:
    """The same in every scene. `dtype`: float64, int64 (table indices, counts) or bool."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    return _value(np.array(item, dtype=dtype)[None])


def per_scene(rows: Sequence[Any] | NDArray[Any], dtype: DTypeLike = "float64") -> Value:
    """One row a scene of the entity; one row in all where they are equal to the bit."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    data = np.array(rows, dtype=dtype)
    return _value(data[:1] if len(data) > 1 and _same_bits(data) else data)


def _same_bits(rows: NDArray[Any]) -> bool:
    """Whether all rows are the first one: as bytes, since 0.0 is not -0.0 and a NaN is itself."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    flat = np.ascontiguousarray(rows).reshape(len(rows), -1).view(np.uint8)
    return bool((flat == flat[0]).all())


def _value(data: NDArray[Any]) -> Value:
    data.flags.writeable = False
    return Value(data)
