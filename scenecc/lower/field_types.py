"""What a field's row holds, how a written value becomes it, and reports of keys without effect."""

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
    """Reports a key that does nothing (SC115).

    Args:
        key: of the node.
        where: it does nothing: "on a light without a shadow".
        origin: of the node.
        sink: takes the diagnostic.
        hint: in place of the usual one, to leave the key out.
    """
    hint = hint or f"leave `{key}` out"
    sink.report("SC115", f"`{key}` does nothing {where}", origin.child(key), at="key", hint=hint)


Convert = Callable[[Any], Any]


@frozen
class FieldType:
    """A field's row.

    Attributes:
        shape: of a row.
        within: the numbers that are allowed; None: any.
        convert: makes a row of a plain value; None where the plain value is one. Gives None for what
            it cannot read, which only the value of an expression can be.
        conversion: the name of `convert`, where what an expression gives is converted too, scene by scene.
        complain: reports a plain value that `convert` gives None for; needed where a model lets one through.
        fallback: replaces a value that was reported.
        pad: of a row's last component where only the others are written.
        wide: a single number is used for every component.
        free: a row may have any shape; that of a form which draws follows from its bounds.
        reset: whether a reset may draw it anew.
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
        """The numbers that a row may have."""
        return ANY if self.within is None else self.within


def field_type(
    quantity: str,
    *,
    fallback: Any = None,
    conversion: str | None = None,
    pad: float | None = None,
    wide: bool = False,
) -> FieldType:
    """The type of a field of the plan, from its row of `QUANTITIES`; other arguments as in `FieldType`."""
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
    """So many numbers of any size."""
    return FieldType((count,), fallback=(0.0,) * count)


def drawn_shape(bounds: Iterable[Any]) -> tuple[int, ...]:
    """The shape of a row that is drawn between bounds as written: that of the first list among them."""
    counts = (_components(bound) for bound in bounds)
    return next(((count,) for count in counts if count is not None), ())


def _components(bound: Any) -> int | None:
    # All alternatives have as many.
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
"""One number of a vector."""


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
"""Key of the language → field of the plan, and what a row of it holds."""
