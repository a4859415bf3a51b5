"""What can be said of a body and of a colliding shape beyond their geometry: one row a field of the plan.

The language's keys, the rules, the backends and the emitters read these tables, so that a new field of one is a row
here, a field of the dataclass and a key of the language.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from scenecc.plan.bounds import (
    ANY,
    AT_LEAST_0,
    POSITION_ITERATIONS,
    POSITIVE,
    UNIT,
    VELOCITY_ITERATIONS,
    Bounds,
)

if TYPE_CHECKING:
    Part = Literal["mass", "body", "groups", "look", "shape"]
    Dtype = Literal["float64", "int64", "bool"]


class Knob(NamedTuple):
    """One field that holds a `Value`.

    Attributes:
        field: of `BodyStructure` or `CollisionShape`.
        part: what of SAPIEN has it: "body", a property of a rigid dynamic component, which does nothing unless PhysX
            moves it; "mass", likewise; "groups", every colliding shape of a body; "look", a render component; "shape",
            a colliding shape.
        key: in a scene file.
        bounds, dtype, shape: of a row.
        untouched: what a fresh object of SAPIEN's has whatever its settings; None: it depends on them.
        reset: whether a reset may draw it anew.
    """

    field: str
    part: Part
    key: str
    bounds: Bounds
    dtype: Dtype = "float64"
    shape: tuple[int, ...] = ()
    untouched: Any = None
    reset: bool = False


def _same(field: str, part: Part, bounds: Bounds, dtype: Dtype = "float64", *, untouched: Any = None) -> Knob:
    """A number that is called the same everywhere."""
    return Knob(field, part, field, bounds, dtype, untouched=untouched)


def _velocity(field: str) -> Knob:
    return Knob(field, "body", field, ANY, shape=(3,), untouched=(0.0, 0.0, 0.0), reset=True)


KNOBS: tuple[Knob, ...] = (
    _same("mass", "mass", POSITIVE),
    Knob("disable_gravity", "body", "gravity", ANY, "bool", untouched=False),
    Knob("locked_motion_axes", "body", "locked_axes", ANY, "bool", (6,), untouched=(False,) * 6),
    _same("linear_damping", "body", AT_LEAST_0),
    _same("angular_damping", "body", AT_LEAST_0),
    _same("max_linear_velocity", "body", POSITIVE),
    _same("max_angular_velocity", "body", POSITIVE),
    _same("max_depenetration_velocity", "body", POSITIVE),
    _same("max_contact_impulse", "body", POSITIVE),
    _same("sleep_threshold", "body", AT_LEAST_0),
    _same("solver_position_iterations", "body", POSITION_ITERATIONS, "int64"),
    _same("solver_velocity_iterations", "body", VELOCITY_ITERATIONS, "int64"),
    _velocity("linear_velocity"),
    _velocity("angular_velocity"),
    Knob("collision_groups", "groups", "collision_bits", Bounds(0, 2**32 - 1), "int64", (4,), (1, 1, 0, 0)),
    _same("visibility", "look", UNIT),
    _same("shading_mode", "look", Bounds(0, 255), "int64"),
    _same("density", "shape", AT_LEAST_0, untouched=1000.0),
    _same("patch_radius", "shape", AT_LEAST_0, untouched=0.0),
    _same("min_patch_radius", "shape", AT_LEAST_0, untouched=0.0),
    _same("contact_offset", "shape", POSITIVE),
    _same("rest_offset", "shape", ANY),
)
"""In the order in which they are set: a body's once its shapes and its mass are there."""


def knobs_of(*parts: Part) -> tuple[Knob, ...]:
    """The rows of some parts, in the order of the table."""
    return tuple(knob for knob in KNOBS if knob.part in parts)


def fields_of(*parts: Part) -> tuple[str, ...]:
    """The fields of some parts, in the order of the table."""
    return tuple(knob.field for knob in knobs_of(*parts))
