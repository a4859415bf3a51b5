"""Types of fields, the conversion of written values to rows, and reports of keys without effect."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.properties import ANY, QUANTITIES, Bounds, Property, properties_of
from scenecc.spec.body import MOTION_AXES
from scenecc.variation import forms
from scenecc.variation.conversions import CONVERSIONS

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan.properties import Dtype


def report_unused_key(key: str, where: str, origin: Origin, sink: Sink, *, hint: str = "") -> None:
    """Reports a key that has no effect (SC115).

    Args:
        key: of the node.
        where: the context: "on a light without a shadow".
        origin: of the node.
        sink: receives the diagnostic.
        hint: replaces the default hint to leave the key out.
    """
    hint = hint or f"leave `{key}` out"
    sink.report("SC115", f"`{key}` does nothing {where}", origin.child(key), at="key", hint=hint)


Convert = Callable[[Any], Any]


@frozen
class FieldType:
    """The type of a field.

    Attributes:
        shape: of a row.
        within: allowed numbers; None: any.
        convert: converts a plain value to a row; None: no conversion. Gives None for an invalid value, which only an
            expression can give.
        conversion: name of `convert`, if values of expressions are converted too, scene by scene.
        complain: reports a plain value for which `convert` gives None, if the model allows any.
        fallback: replaces a value with an error.
        pad: last component of a row if only the others are written.
        wide: whether a single number is used for every component.
        free: whether a row may have any shape. A drawn row takes its shape from the form's bounds.
        reset: whether a reset may redraw it.
    """

    shape: tuple[int, ...] = ()
    dtype: Dtype = "float64"
    convert: Convert | None = None
    conversion: str | None = None
    complain: Callable[[Any, Origin, Sink], None] | None = None
    fallback: Any = 0.0
    pad: float | None = None
    wide: bool = False
    free: bool = False
    within: Bounds | None = None
    reset: bool = False

    @property
    def bounds(self) -> Bounds:
        """The allowed numbers of a row."""
        return ANY if self.within is None else self.within


def field_type(
    quantity: str,
    *,
    fallback: Any = None,
    conversion: str | None = None,
    pad: float | None = None,
    wide: bool = False,
) -> FieldType:
    """The type of a plan field, from its row of `QUANTITIES`. Other arguments: see `FieldType`."""
    row = QUANTITIES[quantity]
    if fallback is None:
        fallback = (0.0,) * row.shape[0] if row.shape else 0.0
    convert = None if conversion is None else CONVERSIONS[conversion].convert
    return FieldType(
        row.shape,
        row.dtype,
        convert,
        conversion,
        fallback=fallback,
        pad=pad,
        wide=wide,
        within=row.bounds,
        reset=row.reset,
    )


def vector(count: int) -> FieldType:
    """The type of `count` unbounded numbers."""
    return FieldType((count,), fallback=(0.0,) * count)


def drawn_shape(bounds: Iterable[Any]) -> tuple[int, ...]:
    """The shape of a row that is drawn between written bounds: that of the first list among them."""
    counts = (_components(bound) for bound in bounds)
    return next(((count,) for count in counts if count is not None), ())


def _components(bound: Any) -> int | None:
    # All alternatives have the same length.
    first: Any = next(forms.alternative_values(bound), None)
    match first:
        case forms.DrawForm(_, operands):
            return next(iter(drawn_shape(operands)), None)
        case forms.Vector(items) | forms.Shuffle(items):
            return len(items)
        case _:
            return len(first) if first.__class__ in {list, tuple} else None


COLOR = field_type("VisualMaterial.base_color", conversion="color", fallback=(0.0, 0.0, 0.0, 1.0), pad=1.0)

EMISSION = field_type("VisualMaterial.emission", conversion="color", fallback=(0.0, 0.0, 0.0, 1.0), pad=1.0)

LIGHT_COLOR = field_type("Light.color", conversion="light_color")

SCALE = field_type("TriangleMesh.scale", conversion="scale", fallback=(1.0, 1.0, 1.0), wide=True)

MIRROR_SCALE = field_type("Mesh.scale", conversion="scale", fallback=(1.0, 1.0, 1.0), wide=True)

POSITION = vector(3)

COMPONENT_TYPES: dict[Dtype, FieldType] = {dtype: FieldType(dtype=dtype) for dtype in ("float64", "int64", "bool")}
"""Types of one component of a vector."""


def _locked(axes: list[str]) -> tuple[bool, ...]:
    return tuple(axis in axes for axis in MOTION_AXES)


def _field_type(row: Property) -> FieldType:
    if row.field == "disable_gravity":
        return field_type(row.quantity, conversion="opposite", fallback=False)
    if row.field == "locked_motion_axes":
        return FieldType((6,), "bool", convert=_locked)
    return field_type(row.quantity)


BODY_FIELDS: dict[str, tuple[str, FieldType]] = {
    row.key: (row.field, _field_type(row)) for row in properties_of("mass", "body", "groups", "look")
}
"""Key of the language → field of the plan, and its type."""
