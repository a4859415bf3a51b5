"""Properties of bodies, shapes and joints in SAPIEN, and the type of each `Value` of the plan: one row per field.

Keys of the language, rules, backends and emitters read these tables, so a new field needs a row here, a field of the
dataclass and a key of the language. Ranges are those of float32, in which the engine computes.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from math import inf, pi
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

if TYPE_CHECKING:
    Part = Literal["mass", "body", "groups", "look", "shape", "joint", "drive", "joint_state"]
    Dtype = Literal["float64", "int64", "bool"]


FLOAT32_MAX = 3.4028234663852886e38


FLOAT32_MIN = 1.1754943508222875e-38
"""The largest and the smallest normal float32: beyond them a length becomes infinite or zero in the engine."""


def round_to_float32(number: float) -> float:
    """Rounds to float32; infinite beyond its range."""
    try:
        return struct.unpack("f", struct.pack("f", number))[0]
    except OverflowError:
        return math.copysign(math.inf, number)


class Bounds(NamedTuple):
    """A closed range of numbers. `nonzero`: excludes 0."""

    low: float = -inf
    high: float = inf
    nonzero: bool = False

    def __str__(self) -> str:
        low = "" if self.low == -inf else "above 0" if self.low == FLOAT32_MIN else f"at least {self.low:g}"
        high = "" if self.high == inf else f"at most {self.high:g}"
        return " and ".join(filter(None, (low, high, "not 0" if self.nonzero else "")))

    def allow(self, number: float) -> bool:
        """Whether a number is in the range."""
        return self.low <= number <= self.high and not (self.nonzero and number == 0)

    def requirement(self, number: float) -> str:
        """The requirement that a number outside of the range violates, such as "above 0"."""
        if number == 0 and self.nonzero:
            return "other than 0"
        if number <= 0 and self.low == FLOAT32_MIN:
            return "above 0"
        if number < self.low:
            return f"at least {self.low:g}"
        return f"at most {self.high:g}"


DEFAULT_DENSITY = 1000
"""SAPIEN's default density of a shape [kg/m³]; a plane's is 0."""

STATIC_FRICTION, DYNAMIC_FRICTION, RESTITUTION = 0.3, 0.3, 0.1
"""`sapien.physx.get_default_material()` of SAPIEN 3.0.3."""

CONTACT_OFFSET, REST_OFFSET = 0.01, 0
"""SAPIEN's defaults [m] (`sapien.physx.get_shape_config()`)."""

MAX_BODY_OFFSET = 1e4
"""Maximum distance of a shape or a centre of mass from the origin of its moving body [m]. Beyond it, the engine's
conversion between the two frames is off by millimetres and the inertia is noise.
"""


ANY = Bounds(-FLOAT32_MAX, FLOAT32_MAX)

POSITIVE = Bounds(FLOAT32_MIN, FLOAT32_MAX)

SPEED = Bounds(2e-19, 1.8e19)
"""Range of a body's velocity limits. PhysX stores their squares in float32."""

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
        part: the SAPIEN object that has it: "body" and "mass", a rigid dynamic component (no effect unless PhysX moves
            it); "groups", all collision shapes of a body; "look", a render component; "shape", a collision shape;
            "joint", a moving joint; "drive", its drive; "joint_state", its initial state and drive targets.
        key: in a scene file.
        bounds, dtype, shape: of a row.
        untouched: value of a fresh SAPIEN object, whatever its settings; None: depends on the settings.
        reset: whether a reset may redraw it.
        unit: unit for a revolute joint; empty if it has none.
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

    @property
    def quantity(self) -> str:
        """Its name in `QUANTITIES`."""
        return f"{_PART_CLASSES.get(self.part, 'BodyStructure')}.{self.field}"


_PART_CLASSES = {"shape": "CollisionShape", **dict.fromkeys(("joint", "drive", "joint_state"), "Joint")}
"""Part → the class with its fields; `BodyStructure` for the others."""


def _make_property(
    field: str,
    part: Part,
    bounds: Bounds,
    unit: str = "",
    *,
    dtype: Dtype = "float64",
    untouched: Any = None,
    reset: bool = False,
) -> Property:
    """A number with the same name everywhere."""
    return Property(field, part, field, bounds, dtype, untouched=untouched, reset=reset, unit=unit)


def _velocity(field: str, unit: str) -> Property:
    return Property(field, "body", field, ANY, shape=(3,), untouched=(0.0, 0.0, 0.0), reset=True, unit=unit)


PROPERTIES: tuple[Property, ...] = (
    _make_property("mass", "mass", POSITIVE, "kg", reset=True),
    Property("com", "mass", "com", ANY, shape=(3,), reset=True, unit="m"),
    Property("disable_gravity", "body", "gravity", ANY, "bool", untouched=False, reset=True),
    Property("locked_motion_axes", "body", "locked_axes", ANY, "bool", (6,), untouched=(False,) * 6),
    _make_property("linear_damping", "body", NON_NEGATIVE, "1/s", reset=True),
    _make_property("angular_damping", "body", NON_NEGATIVE, "1/s", reset=True),
    _make_property("max_linear_velocity", "body", SPEED, "m/s"),
    _make_property("max_angular_velocity", "body", SPEED, "rad/s"),
    _make_property("max_depenetration_velocity", "body", POSITIVE, "m/s"),
    _make_property("max_contact_impulse", "body", POSITIVE, "N·s"),
    _make_property("sleep_threshold", "body", NON_NEGATIVE, "m²/s²"),
    _make_property("solver_position_iterations", "body", POSITION_ITERATIONS, dtype="int64"),
    _make_property("solver_velocity_iterations", "body", VELOCITY_ITERATIONS, dtype="int64"),
    _velocity("linear_velocity", "m/s"),
    _velocity("angular_velocity", "rad/s"),
    Property("collision_groups", "groups", "collision_bits", Bounds(0, 2**32 - 1), "int64", (4,), (1, 1, 0, 0)),
    _make_property("visibility", "look", UNIT_INTERVAL),
    _make_property("shading_mode", "look", Bounds(0, 255), dtype="int64"),
    _make_property("density", "shape", NON_NEGATIVE, "kg/m³", untouched=DEFAULT_DENSITY),
    _make_property("patch_radius", "shape", NON_NEGATIVE, "m", untouched=0.0),
    _make_property("min_patch_radius", "shape", NON_NEGATIVE, "m", untouched=0.0),
    _make_property("contact_offset", "shape", POSITIVE, "m"),
    _make_property("rest_offset", "shape", ANY, "m"),
)
"""Properties of bodies and shapes, in the order in which they are set: a body's after its shapes and mass."""


def _joint_state(field: str, key: str, unit: str) -> Property:
    return Property(field, "joint_state", key, ANY, reset=True, unit=unit)


JOINT_PROPERTIES: tuple[Property, ...] = (
    _make_property("friction", "joint", NON_NEGATIVE, reset=True),
    _make_property("armature", "joint", NON_NEGATIVE, reset=True),
    _make_property("max_velocity", "joint", POSITIVE, "rad/s", reset=True),
    _make_property("stiffness", "drive", NON_NEGATIVE, untouched=0.0, reset=True),
    _make_property("damping", "drive", NON_NEGATIVE, untouched=0.0, reset=True),
    _make_property("force_limit", "drive", NON_NEGATIVE, untouched=FLOAT32_MAX, reset=True),
    _joint_state("qpos", "qpos", "rad"),
    _joint_state("qvel", "qvel", "rad/s"),
    _joint_state("drive_target", "target", "rad"),
    _joint_state("drive_velocity_target", "velocity_target", "rad/s"),
)
"""Properties of joints, in the order in which they are set."""


def properties_of(*parts: Part) -> tuple[Property, ...]:
    """The rows of some parts, in table order."""
    return tuple(row for row in (*PROPERTIES, *JOINT_PROPERTIES) if row.part in parts)


def property_fields(*parts: Part) -> tuple[str, ...]:
    """The fields of some parts, in table order."""
    return tuple(row.field for row in properties_of(*parts))


TableName = Literal["files", "physical_materials", "visual_materials"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A `Value` of the plan: dtype, shape and range of one row.

    `table`: plan table that its numbers index. `pose`: p then q. `reset`: it may have a recipe.
    `infinite`: a lower and an upper limit, each of which may be infinite.
    """

    dtype: Dtype = "float64"
    shape: tuple[int, ...] = ()
    bounds: Bounds = ANY
    table: TableName | None = None
    pose: bool = False
    reset: bool = False
    infinite: bool = False


_POSE = Quantity(shape=(7,), pose=True)

_DRAWN_POSE = Quantity(shape=(7,), pose=True, reset=True)

_RADIANCE = Quantity(shape=(3,), bounds=NON_NEGATIVE, reset=True)

_NONZERO = Quantity(bounds=Bounds(-FLOAT32_MAX, FLOAT32_MAX, nonzero=True))

_NUMBER = Quantity()

_LENS = Quantity(reset=True)

_POSITIVE = Quantity(bounds=POSITIVE)

_POSITIVE_LENS = Quantity(bounds=POSITIVE, reset=True)

_NON_NEGATIVE = Quantity(bounds=NON_NEGATIVE)

_MIRRORING = Quantity(shape=(3,), bounds=Bounds(-FLOAT32_MAX, FLOAT32_MAX, nonzero=True))


_POSITIVE3 = Quantity(shape=(3,), bounds=POSITIVE)


_POSITIVE2 = Quantity(shape=(2,), bounds=POSITIVE)

_UNIT = Quantity(bounds=UNIT_INTERVAL)

_FRICTION = Quantity(bounds=NON_NEGATIVE, reset=True)

_UNIT_AT_RESET = Quantity(bounds=UNIT_INTERVAL, reset=True)

_FILE = Quantity("int64", table="files")

_ANGLE = Quantity(bounds=Bounds(FLOAT32_MIN, pi))

_WHOLE_INDEX = Quantity("int64", bounds=COUNT)

_PROPERTIES = {
    row.quantity: Quantity(row.dtype, row.shape, row.bounds, reset=row.reset)
    for row in (*PROPERTIES, *JOINT_PROPERTIES)
}


def _copy_rows(cls: str, *fields: str) -> dict[str, Quantity]:
    """Rows of some fields of a class, for another class with the same field names."""
    return {field: _PROPERTIES[f"{cls}.{field}"] for field in fields}


_SPRING = {"stiffness": _NON_NEGATIVE, "damping": _NON_NEGATIVE}

_FIELDS: dict[str, dict[str, Quantity]] = {
    "Entity": {"pose": _DRAWN_POSE, "pick": _WHOLE_INDEX},
    "ArticulationStructure": {
        **_copy_rows("BodyStructure", "linear_velocity", "angular_velocity", "sleep_threshold"),
        **_copy_rows("BodyStructure", "solver_position_iterations", "solver_velocity_iterations"),
        "file": _FILE,
    },
    "Link": {"file": _FILE},
    "Joint": {
        "pose_in_parent": _POSE,
        "pose_in_child": _POSE,
        "limits": Quantity(shape=(2,), bounds=Bounds(), infinite=True, reset=True),
    },
    "Mimic": {"multiplier": _NONZERO, "offset": _NUMBER},
    "Inertial": {
        **_copy_rows("BodyStructure", "mass"),
        "com": _DRAWN_POSE,
        "inertia": Quantity(shape=(3,), bounds=POSITIVE, reset=True),
    },
    "CollisionShape": {
        **_copy_rows("BodyStructure", "collision_groups"),
        "pose": _POSE,
        "material": Quantity("int64", table="physical_materials"),
    },
    "VisualShape": {"pose": _POSE, "material": Quantity("int64", table="visual_materials")},
    "Box": {"half_size": _POSITIVE3},
    "Sphere": {"radius": _POSITIVE},
    "Capsule Cylinder Cone": {"radius": _POSITIVE, "half_length": _POSITIVE},
    "Ring": {"inner_radius": _POSITIVE, "outer_radius": _POSITIVE, "half_length": _POSITIVE},
    "Heightfield": {"size": _POSITIVE3},
    "VisualPlane": {"half_size": _POSITIVE2},
    "TiledPlane": {"half_size": _POSITIVE2, "texture_repeat": _POSITIVE2},
    "ConvexMesh ConvexParts Mesh": {"file": _FILE, "scale": _MIRRORING},
    "TriangleMesh": {"file": _FILE, "scale": _POSITIVE3},
    "PhysicalMaterial": {
        **dict.fromkeys(("static_friction", "dynamic_friction"), _FRICTION),
        "restitution": _UNIT_AT_RESET,
    },
    "VisualMaterial": {
        "base_color": Quantity(shape=(4,), bounds=UNIT_INTERVAL, reset=True),
        "emission": Quantity(shape=(4,), bounds=NON_NEGATIVE, reset=True),
        **dict.fromkeys(("specular", "roughness", "metallic", "transmission_roughness"), _UNIT_AT_RESET),
        "transmission": _UNIT,
        "ior": Quantity(bounds=Bounds(1, FLOAT32_MAX)),
    },
    "Texture SkyMap": {"file": _FILE},
    "CubeMap": dict.fromkeys(("px", "nx", "py", "ny", "pz", "nz"), _FILE),
    "Environment": {"ambient_light": _RADIANCE},
    "Constraint": {"pose_in_parent": _POSE, "pose_in_child": _POSE, "enabled": Quantity("bool", reset=True)},
    "AxisLimit": {"limits": Quantity(shape=(2,), bounds=Bounds(), infinite=True), **_SPRING},
    "AxisDrive": _copy_rows("Joint", "stiffness", "damping", "force_limit"),
    "Distance": {"limits": Quantity(shape=(2,), bounds=Bounds(0), infinite=True), **_SPRING},
    "Gear": {"ratio": _NONZERO},
    "Drive": {
        "target": _DRAWN_POSE,
        "linear_velocity_target": Quantity(shape=(3,), reset=True),
        "angular_velocity_target": Quantity(shape=(3,), reset=True),
        "inv_mass_scales": Quantity(shape=(2,), bounds=NON_NEGATIVE),
        "inv_inertia_scales": Quantity(shape=(2,), bounds=NON_NEGATIVE),
    },
    "Light": {"pose": _DRAWN_POSE, "color": _RADIANCE},
    "SpotLight TexturedLight": {"inner_fov": _ANGLE, "outer_fov": _ANGLE},
    "AreaLight": {"half_width": _POSITIVE, "half_height": _POSITIVE},
    "Shadow": {
        "on": Quantity("bool"),
        "near": _NUMBER,
        "far": _NUMBER,
        "half_size": _POSITIVE,
        "map_size": Quantity("int64", bounds=Bounds(1, 16384)),
    },
    "Camera": {"pose": _DRAWN_POSE, "near": _POSITIVE_LENS, "far": _POSITIVE_LENS},
    "Perspective": dict.fromkeys(("fovx", "fovy"), Quantity(bounds=_ANGLE.bounds, reset=True)),
    "Intrinsic": {"fx": _POSITIVE_LENS, "fy": _POSITIVE_LENS, "cx": _LENS, "cy": _LENS, "skew": _LENS},
    "Orthographic": {"top": _POSITIVE_LENS},
    "Placement": {
        **dict.fromkeys(("at", "center", "facing_point", "height"), Quantity(shape=(2,), reset=True)),
        **dict.fromkeys(("low", "high"), Quantity(shape=(3,), reset=True)),
        "radius": Quantity(bounds=POSITIVE, reset=True),
        "frame": _DRAWN_POSE,
        "rotation": Quantity(shape=(4,), reset=True),
    },
}
"""Class of the plan → its `Value` fields, except those in the property tables."""

QUANTITIES: dict[str, Quantity] = _PROPERTIES | {
    f"{cls}.{field}": row for classes, rows in _FIELDS.items() for cls in classes.split() for field, row in rows.items()
}
"""What each `Value` of the plan holds, by `Class.field`."""
