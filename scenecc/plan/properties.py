"""Properties of bodies, collision shapes and joints beyond the geometry, one row a field, and the ranges of numbers.

The language's keys, the rules, the backends and the emitters read this table, so that a new field is a row here, a
field of the dataclass and a key of the language.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from scenecc.geometry.float32 import FLOAT32_MAX, FLOAT32_MIN

if TYPE_CHECKING:
    Part = Literal["mass", "body", "groups", "look", "shape", "joint", "drive", "joint_state"]
    Dtype = Literal["float64", "int64", "bool"]


class Bounds(NamedTuple):
    """The numbers that are allowed, both ends included. `nonzero`: 0 is not."""

    low: float = -inf
    high: float = inf
    nonzero: bool = False

    def __str__(self) -> str:
        low = "" if self.low == -inf else f"at least {self.low:g}"
        high = "" if self.high == inf else f"at most {self.high:g}"
        return " and ".join(filter(None, (low, high, "not 0" if self.nonzero else "")))

    def allow(self, number: float) -> bool:
        """Whether a number is one of them."""
        return self.low <= number <= self.high and not (self.nonzero and number == 0)

    def requirement(self, number: float) -> str:
        """What a number outside of the bounds must be: "above 0"."""
        if number == 0 and self.nonzero:
            return "other than 0"
        if number <= 0 and self.low == FLOAT32_MIN:
            return "above 0"
        if number < self.low:
            return f"at least {self.low:g}"
        return f"at most {self.high:g}"


DEFAULT_DENSITY = 1000
"""SAPIEN's density of a shape that gives none [kg/m³]; a plane's is 0."""

MAX_BODY_OFFSET = 1e4
"""How far a shape or the centre of mass of a body that moves is from it [m]: beyond, the engine moves the body by
millimetres when it goes from the one to the other, and its inertia is noise."""

ANY = Bounds(-FLOAT32_MAX, FLOAT32_MAX)

POSITIVE = Bounds(FLOAT32_MIN, FLOAT32_MAX)

NON_NEGATIVE = Bounds(0, FLOAT32_MAX)

UNIT_INTERVAL = Bounds(0, 1)

INT32_MAX = 2**31 - 1
"""The engine's integers have 32 bits."""

COUNT = Bounds(0, INT32_MAX)

POSITION_ITERATIONS = Bounds(1, 255)

VELOCITY_ITERATIONS = Bounds(0, 255)


class Property(NamedTuple):
    """One field that holds a `Value`.

    Attributes:
        field: of `BodyStructure`, `CollisionShape` or `Joint`.
        part: what of SAPIEN has it: "body", a property of a rigid dynamic component, which does nothing unless PhysX
            moves it; "mass", likewise; "groups", every colliding shape of a body; "look", a render component; "shape",
            a colliding shape; "joint", a joint that moves; "drive", its drive; "joint_state", where it starts and
            what its drive pulls to.
        key: in a scene file.
        bounds, dtype, shape: of a row.
        untouched: what a fresh object of SAPIEN's has whatever its settings; None: it depends on them.
        reset: whether a reset may draw it anew.
        unit: of its numbers, of a joint that turns; empty where they have none.
    """

    field: str
    part: Part
    key: str
    bounds: Bounds
    dtype: Dtype = "float64"
    shape: tuple[int, ...] = ()
    untouched: Any = None
    reset: bool = False
    unit: str = ""


def _same_key(
    field: str, part: Part, bounds: Bounds, unit: str = "", *, dtype: Dtype = "float64", untouched: Any = None
) -> Property:
    """A number that is called the same everywhere."""
    return Property(field, part, field, bounds, dtype, untouched=untouched, unit=unit)


def _velocity(field: str, unit: str) -> Property:
    return Property(field, "body", field, ANY, shape=(3,), untouched=(0.0, 0.0, 0.0), reset=True, unit=unit)


PROPERTIES: tuple[Property, ...] = (
    _same_key("mass", "mass", POSITIVE, "kg"),
    Property("disable_gravity", "body", "gravity", ANY, "bool", untouched=False),
    Property("locked_motion_axes", "body", "locked_axes", ANY, "bool", (6,), untouched=(False,) * 6),
    _same_key("linear_damping", "body", NON_NEGATIVE, "1/s"),
    _same_key("angular_damping", "body", NON_NEGATIVE, "1/s"),
    _same_key("max_linear_velocity", "body", POSITIVE, "m/s"),
    _same_key("max_angular_velocity", "body", POSITIVE, "rad/s"),
    _same_key("max_depenetration_velocity", "body", POSITIVE, "m/s"),
    _same_key("max_contact_impulse", "body", POSITIVE, "N·s"),
    _same_key("sleep_threshold", "body", NON_NEGATIVE, "m²/s²"),
    _same_key("solver_position_iterations", "body", POSITION_ITERATIONS, dtype="int64"),
    _same_key("solver_velocity_iterations", "body", VELOCITY_ITERATIONS, dtype="int64"),
    _velocity("linear_velocity", "m/s"),
    _velocity("angular_velocity", "rad/s"),
    Property("collision_groups", "groups", "collision_bits", Bounds(0, 2**32 - 1), "int64", (4,), (1, 1, 0, 0)),
    _same_key("visibility", "look", UNIT_INTERVAL),
    _same_key("shading_mode", "look", Bounds(0, 255), dtype="int64"),
    _same_key("density", "shape", NON_NEGATIVE, "kg/m³", untouched=DEFAULT_DENSITY),
    _same_key("patch_radius", "shape", NON_NEGATIVE, "m", untouched=0.0),
    _same_key("min_patch_radius", "shape", NON_NEGATIVE, "m", untouched=0.0),
    _same_key("contact_offset", "shape", POSITIVE, "m"),
    _same_key("rest_offset", "shape", ANY, "m"),
)
"""Of bodies and shapes, in the order in which they are set: a body's once its shapes and its mass are there."""


def _joint_state(field: str, key: str, unit: str) -> Property:
    return Property(field, "joint_state", key, ANY, reset=True, unit=unit)


JOINT_PROPERTIES: tuple[Property, ...] = (
    _same_key("friction", "joint", NON_NEGATIVE),
    _same_key("armature", "joint", NON_NEGATIVE),
    _same_key("max_velocity", "joint", POSITIVE, "rad/s"),
    _same_key("stiffness", "drive", NON_NEGATIVE, untouched=0.0),
    _same_key("damping", "drive", NON_NEGATIVE, untouched=0.0),
    _same_key("force_limit", "drive", NON_NEGATIVE, untouched=FLOAT32_MAX),
    _joint_state("qpos", "qpos", "rad"),
    _joint_state("qvel", "qvel", "rad/s"),
    _joint_state("drive_target", "target", "rad"),
    _joint_state("drive_velocity_target", "velocity_target", "rad/s"),
)
"""Of joints, in the order in which they are set."""


def properties_of(*parts: Part) -> tuple[Property, ...]:
    """The rows of some parts, in the order of the tables."""
    return tuple(row for row in (*PROPERTIES, *JOINT_PROPERTIES) if row.part in parts)


def property_fields(*parts: Part) -> tuple[str, ...]:
    """The fields of some parts, in the order of the table."""
    return tuple(row.field for row in properties_of(*parts))
