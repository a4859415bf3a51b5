"""A number, vector, flag or table index that may differ from scene to scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import DTypeLike, NDArray

    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.nodes import Node

_set_attribute = object.__setattr__


class _DrawSource:
    """How a value that varies is drawn.

    Attributes:
        draw: makes the data; None of data that were drawn before.
        sample: makes the samples, (1, …) or (256, …); None likewise.
        scenes: that the rows belong to.
        bounds: gives the bounds; None: they are those of the samples.
        recipe: how a reset draws the value.
        samples: as `sample` made them; None: it was not called.
    """

    __slots__ = ("bounds", "draw", "recipe", "sample", "samples", "scenes")

    def __init__(
        self,
        draw: Callable[[], NDArray[Any]] | None,
        sample: Callable[[], NDArray[Any]] | None,
        scenes: Sequence[int],
        bounds: Callable[[], ValueBounds] | None,
        recipe: Node | None,
    ) -> None:
        self.draw = draw
        self.sample = sample
        self.scenes = scenes
        self.bounds = bounds
        self.recipe = recipe
        self.samples: NDArray[Any] | None = None


class Value:
    """One quantity over the scenes of an entity. Nothing of it can be changed.

    Attributes:
        data: float64, int64 or bool, read-only. The leading axis is 1 (the same in every scene) or
            the number of scenes that the entity is in, by ascending scene index. What follows is
            the quantity's own shape: () for a scalar, (3,) for a vector, (7,) for a pose (p then q,
            wxyz). What is drawn is drawn when this is first asked for.

    Two values are equal if every bit of their data is and their recipes say the same.
    """

    __slots__ = ("_source", "data")

    data: NDArray[Any]
    _source: tuple[float | tuple[float, ...], DTypeLike] | _DrawSource | None
    """Of a `literal`: the item and its dtype, of a `varying`: how it is drawn, otherwise None."""

    def __init__(self, data: NDArray[Any]) -> None:
        _set_attribute(self, "_source", None)
        _set_attribute(self, "data", data)

    def __getattr__(self, name: str) -> Any:
        """The array, made when it is first asked for: checking a scene seldom does."""
        if name != "data":
            raise AttributeError(f"a Value has no attribute {name!r}", name=name, obj=self)
        source = self._source
        data = _draw_data(source) if isinstance(source, _DrawSource) else _literal_data(source)
        _set_attribute(self, "data", data)
        return data

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a Value is read-only: {name!r} cannot be set", name=name, obj=self)

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a Value is read-only: {name!r} cannot be deleted", name=name, obj=self)

    def __reduce__(self) -> tuple[Callable[..., Value], tuple[Any, ...]]:
        source = self._source
        if isinstance(source, _DrawSource):
            bounds = _KnownBounds(self.bounds)
            return _value_of_source, (self.data, _DrawSource(None, None, source.scenes, bounds, source.recipe))
        return _read_only_value, (self.data,)

    def __repr__(self) -> str:
        source = self._source
        if not isinstance(source, _DrawSource):
            return f"Value(data={self.data!r})"
        return f"Value(rows={len(source.scenes)}, recipe={source.recipe!r})"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Value):
            return NotImplemented
        if self is other:
            return True
        if _same_literal(self._source, other._source):
            return True
        a, b = self.data, other.data
        same = a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
        # As they are written, since 1 is not 1.0 in a recipe and 0.0 is not -0.0.
        return same and (self.recipe is other.recipe or repr(self.recipe) == repr(other.recipe))

    def __hash__(self) -> int:
        source = self._source
        if source is None or isinstance(source, _DrawSource):
            return hash(tuple(self.data.ravel().tolist()))
        # Without an array: numbers that are equal have one hash, whatever their type.
        return hash(source[0] if isinstance(source[0], tuple) else (source[0],))

    @property
    def varies(self) -> bool:
        """Whether the scenes do not all have the same, as drawn: what is not drawn yet is drawn for this."""
        source = self._source
        return (source is None or isinstance(source, _DrawSource)) and self.data.shape[0] != 1

    @property
    def known(self) -> bool:
        """Whether its rows are there without drawing anything."""
        return not isinstance(self._source, _DrawSource)

    @property
    def is_constant(self) -> bool:
        """Whether it is one thing, whatever is drawn: known, and the same in every scene."""
        source = self._source
        return not isinstance(source, _DrawSource) and (source is not None or self.data.shape[0] == 1)

    @property
    def may_vary(self) -> bool:
        """Whether the scenes need not all have the same; draws nothing."""
        source = self._source
        if isinstance(source, _DrawSource):
            return len(source.scenes) != 1
        return source is None and self.data.shape[0] != 1

    @property
    def recipe(self) -> Node | None:
        """How a reset draws it anew, a row a scene; None: it stays as it is."""
        source = self._source
        return source.recipe if isinstance(source, _DrawSource) else None

    @property
    def scenes(self) -> Sequence[int]:
        """The scenes of the rows of a value that is drawn; empty of any other."""
        source = self._source
        return source.scenes if isinstance(source, _DrawSource) else ()

    @property
    def samples(self) -> NDArray[Any]:
        """One row, or a row for each sample (`scenecc.variation.samples`), by which a file is judged.

        Raises:
            DrawError: it has no value in one of the samples.
        """
        source = self._source
        if isinstance(source, _DrawSource) and source.sample is not None:
            if source.samples is None:
                source.samples = source.sample()
            return source.samples
        rows = self.data
        if len(rows) == 1:
            return rows

        from scenecc.variation.samples import as_samples  # noqa: PLC0415 - checking a scene seldom needs it

        return as_samples(rows)

    def drop_samples(self) -> None:
        """Makes `samples` raise a DrawError, since they were reported. The bounds stay."""
        source = self._source
        if isinstance(source, _DrawSource):
            source.bounds = _KnownBounds(self.bounds)
            source.samples, source.sample = None, _raise_reported

    @property
    def bounds(self) -> ValueBounds:
        """The values that it can have, whatever is drawn; those of its rows where only these are known."""
        from scenecc.variation.bounds import ValueBounds  # noqa: PLC0415 - checking a scene seldom needs it

        source = self._source
        if not isinstance(source, _DrawSource):
            return ValueBounds.of_rows(self.data)
        found = self._sampled_bounds() if source.bounds is None else source.bounds()
        source.bounds = _KnownBounds(found)
        return found

    def _sampled_bounds(self) -> ValueBounds:
        from scenecc.variation.bounds import UNKNOWN, ValueBounds  # noqa: PLC0415 - checking a scene seldom needs it
        from scenecc.variation.operations import DrawError  # noqa: PLC0415 - likewise

        source = self._source
        if isinstance(source, _DrawSource) and source.sample is None:
            return ValueBounds.of_rows(self.data)
        try:
            return ValueBounds.of_samples(self.samples)
        except DrawError:  # reported where it is written
            return UNKNOWN

    def numbers(self) -> tuple[float, ...]:
        """Numbers that bound everything that it can be, row by row; draws nothing.

        Of what is the same everywhere or known by scene these are the numbers of all rows, of what is drawn those of
        all alternatives, or else the lowest and the highest row. For a `literal`'s own no array is made.
        """
        source = self._source
        if source is None:
            return tuple(self.data.ravel().tolist())
        if isinstance(source, _DrawSource):
            return self.bounds.numbers()
        item = source[0]
        return item if isinstance(item, tuple) else (item,)

    def as_drawn(self) -> tuple[float, ...]:
        """All numbers of the data, row by row. For a `literal`'s own no array is made."""
        source = self._source
        if source is None or isinstance(source, _DrawSource):
            return tuple(self.data.ravel().tolist())
        item = source[0]
        return item if isinstance(item, tuple) else (item,)

    def row(self, index: int) -> Any:
        """What the entity's scene number `index` (a row, not a scene index) has."""
        return self.data[index if self.data.shape[0] != 1 else 0]


def _raise_reported() -> NDArray[Any]:
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - checking a scene seldom needs it

    raise DrawError("it was reported", 0, None)


def _same_literal(a: object, b: object) -> bool:
    """Whether two sources are one literal, so that no array need be made to compare them."""
    if a.__class__ is not tuple or b.__class__ is not tuple or a != b:
        return False
    return repr(a) == repr(b)


_new_object = object.__new__
_set_source: Any = Value.__dict__["_source"].__set__
"""The slot's own setter, which is quicker than `object.__setattr__`."""


def literal(item: float | tuple[float, ...], dtype: DTypeLike = "float64") -> Value:
    """As `constant`, of a number or a flat tuple of numbers; the array is made when it is first asked for."""
    value = _new_object(Value)
    _set_source(value, (item, dtype))
    return value


def constant(item: float | Sequence[Any] | NDArray[Any], dtype: DTypeLike = "float64") -> Value:
    """The same in every scene. `dtype`: float64, int64 (table indices, counts) or bool."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    return _read_only_value(np.array(item, dtype=dtype)[None])


def per_scene(rows: Sequence[Any] | NDArray[Any], dtype: DTypeLike = "float64") -> Value:
    """One row a scene of the entity; one row in all where they are equal to the bit."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    data = np.array(rows, dtype=dtype)
    return _read_only_value(data[:1] if len(data) > 1 and _same_bits(data) else data)


def varying(
    draw: Callable[[], NDArray[Any]],
    sample: Callable[[], NDArray[Any]],
    scenes: Sequence[int],
    *,
    bounds: Callable[[], ValueBounds] | None = None,
    recipe: Node | None = None,
) -> Value:
    """A value that is drawn when its data are first asked for.

    Args:
        draw: makes the data, (1, …) or a row a scene, float64, int64 or bool; the same at every call.
        sample: makes the samples, (1, …) or (256, …), likewise.
        scenes: that the entity is in.
        bounds: gives the values that it can have, whatever is drawn; None: those of the samples.
        recipe: how a reset draws it; only for what a running simulation can change.
    """
    return _value_of_source(None, _DrawSource(draw, sample, scenes, bounds, recipe))


def derived(
    function: Callable[..., NDArray[Any]],
    parts: Sequence[Value],
    scenes: Sequence[int],
    *,
    bounds: Callable[[], ValueBounds] | None = None,
) -> Value:
    """A value that is computed from others, row by row; known if these are.

    Args:
        function: takes the rows of all parts, each (1, …) or (B, …), and gives rows (1, …) or (B, …).
        parts: the other values, in the same scenes.
        scenes: that the entity is in.
        bounds: as of `varying`.
    """

    def draw() -> NDArray[Any]:
        return function(*(part.data for part in parts))

    if all(part.known for part in parts):
        data = draw()
        return per_scene(data, data.dtype)
    return varying(draw, lambda: function(*(part.samples for part in parts)), scenes, bounds=bounds)


def recalled(data: NDArray[Any], recipe: Node) -> Value:
    """A value as it was drawn once, (·, …), with the recipe by which a reset draws it."""
    return _value_of_source(data, _DrawSource(None, None, range(len(data)), None, recipe))


class _KnownBounds:
    """Bounds that are known, as a function that can be copied to another process."""

    def __init__(self, bounds: ValueBounds) -> None:
        self._bounds = bounds

    def __call__(self) -> ValueBounds:
        return self._bounds


def _value_of_source(data: NDArray[Any] | None, source: _DrawSource) -> Value:
    value = _new_object(Value)
    _set_source(value, source)
    if data is not None:
        data.flags.writeable = False
        _set_attribute(value, "data", data)
    return value


def _draw_data(source: _DrawSource) -> NDArray[Any]:
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    assert source.draw is not None
    data = np.array(source.draw())
    if len(data) not in {1, len(source.scenes)}:
        raise ValueError(f"{len(data)} rows were drawn for {len(source.scenes)} scenes")
    return _read_only_value(data[:1] if len(data) > 1 and _same_bits(data) else data).data


def _literal_data(source: Any) -> NDArray[Any]:
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    item, dtype = source
    data = np.array((item,), dtype=dtype)
    data.flags.writeable = False
    return data


def _same_bits(rows: NDArray[Any]) -> bool:
    """Whether all rows are the first one: as bytes, since 0.0 is not -0.0 and a NaN is itself."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    flat = np.ascontiguousarray(rows).reshape(len(rows), -1).view(np.uint8)
    return bool((flat == flat[0]).all())


def _read_only_value(data: NDArray[Any]) -> Value:
    data.flags.writeable = False
    return Value(data)
