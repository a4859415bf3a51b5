"""A number, vector, flag or table index that may vary by scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import DTypeLike, NDArray

    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.nodes import Node

_set_attribute = object.__setattr__


class _DrawSource:
    """How a varying value is drawn.

    Attributes:
        draw: makes the data; None if the data exist already.
        sample: makes the samples, (1, …) or (256, …); None if the data exist already.
        scenes: scenes of the rows.
        bounds: gives the bounds; None: use the bounds of the samples.
        recipe: how a reset draws the value.
        samples: result of `sample`; None before the first call.
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
    """One quantity over the scenes of an entity. Immutable.

    Attributes:
        data: float64, int64 or bool, read-only. The leading axis is 1 (the same in every scene) or the number of scenes
            of the entity, by ascending scene index. The rest is the quantity's shape: () for a scalar, (3,) for a
            vector, (7,) for a pose (p then q, wxyz). Drawn on first access.

    Two values are equal if their data are equal bit by bit and their recipes have the same text.
    """

    __slots__ = ("_source", "data")

    data: NDArray[Any]
    _source: tuple[float | tuple[float, ...], DTypeLike] | _DrawSource | None
    """For a `literal` the item and its dtype, for a `varying` value how it is drawn, otherwise None."""

    def __init__(self, data: NDArray[Any]) -> None:
        _set_attribute(self, "_source", None)
        _set_attribute(self, "data", data)

    def __getattr__(self, name: str) -> Any:
        """Makes the array on first access, since checking a scene rarely needs it."""
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
        # Compared by text, since in a recipe 1 differs from 1.0 and 0.0 from -0.0.
        return same and (self.recipe is other.recipe or repr(self.recipe) == repr(other.recipe))

    def __hash__(self) -> int:
        source = self._source
        if source is None or isinstance(source, _DrawSource):
            return hash(tuple(self.data.ravel().tolist()))
        # Avoids an array. Equal numbers have equal hashes, whatever their type.
        return hash(source[0] if isinstance(source[0], tuple) else (source[0],))

    @property
    def varies(self) -> bool:
        """Whether scenes differ. Draws the value if necessary."""
        source = self._source
        return (source is None or isinstance(source, _DrawSource)) and self.data.shape[0] != 1

    @property
    def known(self) -> bool:
        """Whether the rows are available without drawing."""
        return not isinstance(self._source, _DrawSource)

    @property
    def is_constant(self) -> bool:
        """Whether the value is known without drawing and equal in every scene."""
        source = self._source
        return not isinstance(source, _DrawSource) and (source is not None or self.data.shape[0] == 1)

    @property
    def may_vary(self) -> bool:
        """Whether scenes may differ. Does not draw."""
        source = self._source
        if isinstance(source, _DrawSource):
            return len(source.scenes) != 1
        return source is None and self.data.shape[0] != 1

    @property
    def recipe(self) -> Node | None:
        """How a reset redraws the value, one row per scene; None: a reset keeps it."""
        source = self._source
        return source.recipe if isinstance(source, _DrawSource) else None

    @property
    def scenes(self) -> Sequence[int]:
        """The scenes of the rows of a drawn value; otherwise empty."""
        source = self._source
        return source.scenes if isinstance(source, _DrawSource) else ()

    @property
    def samples(self) -> NDArray[Any]:
        """One row, or one row per sample (`scenecc.variation.samples`), used to check a file.

        Raises:
            DrawError: a sample has no value.
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

    def without_samples(self) -> Value:
        """The same value, whose `samples` raise a DrawError: a fault of them was reported."""
        return varying(lambda: self.data, _raise_reported, self.scenes, bounds=_KnownBounds(self.bounds))

    def with_data(self, data: NDArray[Any]) -> Value:
        """The same value with other data, one row per scene."""
        source = self._source
        if not isinstance(source, _DrawSource) or source.recipe is None:
            return per_scene(data, data.dtype)
        return _value_of_source(data, _DrawSource(None, None, source.scenes, None, source.recipe))

    def with_recipe(self, recipe: Node, scenes: Sequence[int]) -> Value:
        """The same value with a recipe, one row per scene."""
        return varying(lambda: self.data, lambda: self.samples, scenes, bounds=lambda: self.bounds, recipe=recipe)

    @property
    def bounds(self) -> ValueBounds:
        """Bounds over all possible draws. For a value without a draw, bounds of its rows."""
        from scenecc.variation.bounds import ValueBounds  # noqa: PLC0415 - checking a scene seldom needs it

        source = self._source
        if not isinstance(source, _DrawSource):
            return ValueBounds.of_rows(self.data)
        found = self._sampled_bounds() if source.bounds is None else source.bounds()
        source.bounds = _KnownBounds(found)
        return found

    def _sampled_bounds(self) -> ValueBounds:
        from scenecc.variation.bounds import UNKNOWN, ValueBounds  # noqa: PLC0415 - checking a scene seldom needs it
        from scenecc.variation.operations import DrawError  # noqa: PLC0415 - see above

        source = self._source
        if isinstance(source, _DrawSource) and source.sample is None:
            # Not exact: a rule over several values compares their rows scene by scene, not their extremes.
            return ValueBounds.of_rows(self.data, exact=False)
        try:
            return ValueBounds.of_samples(self.samples)
        except DrawError:  # reported where it is written
            return UNKNOWN

    def numbers(self) -> tuple[float, ...]:
        """Numbers that bound the value, row by row. Does not draw.

        For a known value these are the numbers of all rows; for a drawn one those of all alternatives, or else the
        lowest and the highest row. A `literal` makes no array.
        """
        source = self._source
        if source is None:
            return tuple(self.data.ravel().tolist())
        if isinstance(source, _DrawSource):
            return self.bounds.numbers()
        item = source[0]
        return item if isinstance(item, tuple) else (item,)

    def as_drawn(self) -> tuple[float, ...]:
        """All numbers of the data, row by row. A `literal` makes no array."""
        source = self._source
        if source is None or isinstance(source, _DrawSource):
            return tuple(self.data.ravel().tolist())
        item = source[0]
        return item if isinstance(item, tuple) else (item,)

    def row(self, index: int) -> Any:
        """The entity's value in row `index` (not a scene index)."""
        return self.data[index if self.data.shape[0] != 1 else 0]


def _raise_reported() -> NDArray[Any]:
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - checking a scene seldom needs it

    raise DrawError("it was reported", 0, None)


def _same_literal(a: object, b: object) -> bool:
    """Whether two sources are the same literal. Makes no array."""
    if a.__class__ is not tuple or b.__class__ is not tuple or a != b:
        return False
    return repr(a) == repr(b)


_new_object = object.__new__
_set_source: Any = Value.__dict__["_source"].__set__
"""The slot's setter, faster than `object.__setattr__`."""


def literal(item: float | tuple[float, ...], dtype: DTypeLike = "float64") -> Value:
    """Same as `constant` for a number or a flat tuple. The array is made on first access."""
    value = _new_object(Value)
    _set_source(value, (item, dtype))
    return value


def constant(item: float | Sequence[Any] | NDArray[Any], dtype: DTypeLike = "float64") -> Value:
    """A value that is the same in every scene. `dtype`: float64, int64 (table indices, counts) or bool."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    return _read_only_value(np.array(item, dtype=dtype)[None])


def per_scene(rows: Sequence[Any] | NDArray[Any], dtype: DTypeLike = "float64") -> Value:
    """A value with one row per scene of the entity. Keeps a single row if all are equal bit by bit."""
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
    """A value that is drawn on first access.

    Args:
        draw: makes the data, (1, …) or one row per scene, float64, int64 or bool. Must be deterministic.
        sample: makes the samples, (1, …) or (256, …). Must be deterministic.
        scenes: scenes of the entity.
        bounds: gives the bounds over all possible draws; None: use the bounds of the samples.
        recipe: how a reset draws the value; only for values that a running simulation can change.
    """
    return _value_of_source(None, _DrawSource(draw, sample, scenes, bounds, recipe))


def derived(
    function: Callable[..., NDArray[Any]],
    parts: Sequence[Value],
    scenes: Sequence[int],
    *,
    bounds: Callable[[], ValueBounds] | None = None,
) -> Value:
    """A value computed from others, row by row. It is known if all of these are.

    Args:
        function: maps the rows of all parts, each (1, …) or (B, …), to rows (1, …) or (B, …).
        parts: the other values, in the same scenes.
        scenes: scenes of the entity.
        bounds: see `varying`.
    """

    def draw() -> NDArray[Any]:
        return function(*(part.data for part in parts))

    if all(part.known for part in parts):
        data = draw()
        return per_scene(data, data.dtype)
    return varying(draw, lambda: function(*(part.samples for part in parts)), scenes, bounds=bounds)


def recalled(data: NDArray[Any], recipe: Node) -> Value:
    """A value with its drawn data (·, …) and the recipe that a reset uses."""
    return _value_of_source(data, _DrawSource(None, None, range(len(data)), None, recipe))


class _KnownBounds:
    """Known bounds as a function that can be pickled."""

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
    """Whether all rows equal the first bit by bit: 0.0 differs from -0.0 and NaN equals itself."""
    import numpy as np  # noqa: PLC0415 - checking a scene needs none

    flat = np.ascontiguousarray(rows).reshape(len(rows), -1).view(np.uint8)
    return bool((flat == flat[0]).all())


def _read_only_value(data: NDArray[Any]) -> Value:
    data.flags.writeable = False
    return Value(data)
