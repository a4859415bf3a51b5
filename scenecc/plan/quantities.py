"""What each `Value` of the plan holds, one row a field: dtype, shape, range.

The lowering, the reader and the writer of the JSON and the diff work from this table.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Literal

from scenecc.geometry.float32 import FLOAT32_MAX, FLOAT32_MIN
from scenecc.plan.properties import (
    ANY,
    COUNT,
    JOINT_PROPERTIES,
    NON_NEGATIVE,
    POSITIVE,
    PROPERTIES,
    UNIT_INTERVAL,
    Bounds,
)

if TYPE_CHECKING:
    from scenecc.plan.properties import Dtype

TableName = Literal["files", "physical_materials", "visual_materials"]


@dataclass(frozen=True, slots=True)
class Quantity:
    """A `Value` of the plan: dtype, shape and range of one row.

    `table`: its numbers are indices into that table of the plan. `pose`: p then q. `reset`: it may have a recipe.
    `infinite`: a lowest and a highest number, either of which may be infinite.
    """

    dtype: Dtype = "float64"
    shape: tuple[int, ...] = ()
    bounds: Bounds = ANY
    table: TableName | None = None
    pose: bool = False
    reset: bool = False
    infinite: bool = False


_POSE = Quantity(shape=(7,), pose=True)

_NUMBER = Quantity()

_POSITIVE = Quantity(bounds=POSITIVE)

_NON_NEGATIVE = Quantity(bounds=NON_NEGATIVE)

_MIRRORING = Quantity(shape=(3,), bounds=Bounds(-FLOAT32_MAX, FLOAT32_MAX, nonzero=True))


_POSITIVE3 = Quantity(shape=(3,), bounds=POSITIVE)


_POSITIVE2 = Quantity(shape=(2,), bounds=POSITIVE)

_UNIT = Quantity(bounds=UNIT_INTERVAL)

_FILE = Quantity("int64", table="files")

_ANGLE = Quantity(bounds=Bounds(FLOAT32_MIN, pi))

QUANTITIES: dict[str, Quantity] = {
    **{
        row.field: Quantity(row.dtype, row.shape, row.bounds, reset=row.reset)
        for row in (*PROPERTIES, *JOINT_PROPERTIES)
    },
    "pose": _POSE,
    "Entity.pose": Quantity(shape=(7,), pose=True, reset=True),
    "Camera.pose": Quantity(shape=(7,), pose=True, reset=True),
    "Light.pose": Quantity(shape=(7,), pose=True, reset=True),
    "com": _POSE,
    "pose_in_parent": _POSE,
    "pose_in_child": _POSE,
    "limits": Quantity(shape=(2,), bounds=Bounds(), infinite=True),
    "Distance.limits": Quantity(shape=(2,), bounds=Bounds(0), infinite=True),
    "multiplier": Quantity(bounds=Bounds(-FLOAT32_MAX, FLOAT32_MAX, nonzero=True)),
    "offset": _NUMBER,
    "ratio": Quantity(bounds=Bounds(-FLOAT32_MAX, FLOAT32_MAX, nonzero=True)),
    "target": Quantity(shape=(7,), pose=True, reset=True),
    "linear_velocity_target": Quantity(shape=(3,), reset=True),
    "angular_velocity_target": Quantity(shape=(3,), reset=True),
    "inv_mass_scales": Quantity(shape=(2,), bounds=NON_NEGATIVE),
    "inv_inertia_scales": Quantity(shape=(2,), bounds=NON_NEGATIVE),
    "color": Quantity(shape=(3,), bounds=NON_NEGATIVE),
    "ambient_light": Quantity(shape=(3,), bounds=NON_NEGATIVE),
    "inner_fov": _ANGLE,
    "outer_fov": _ANGLE,
    "half_width": _POSITIVE,
    "half_height": _POSITIVE,
    **dict.fromkeys(("px", "nx", "py", "ny", "pz", "nz"), _FILE),
    "fovx": _ANGLE,
    "fovy": _ANGLE,
    "fx": _POSITIVE,
    "fy": _POSITIVE,
    "cx": _NUMBER,
    "cy": _NUMBER,
    "skew": _NUMBER,
    "top": _POSITIVE,
    "Camera.near": _POSITIVE,
    "Camera.far": _POSITIVE,
    "on": Quantity("bool"),
    "Shadow.near": _NUMBER,
    "Shadow.far": _NUMBER,
    "Shadow.half_size": _POSITIVE,
    "map_size": Quantity("int64", bounds=Bounds(1, 16384)),
    "half_size": _POSITIVE3,
    "size": _POSITIVE3,
    "VisualPlane.half_size": _POSITIVE2,
    "TiledPlane.half_size": _POSITIVE2,
    "texture_repeat": _POSITIVE2,
    "radius": _POSITIVE,
    "half_length": _POSITIVE,
    "inner_radius": _POSITIVE,
    "outer_radius": _POSITIVE,
    "file": _FILE,
    "scale": _POSITIVE3,
    "Mesh.scale": _MIRRORING,
    "ConvexMesh.scale": _MIRRORING,
    "ConvexParts.scale": _MIRRORING,
    "CollisionShape.material": Quantity("int64", table="physical_materials"),
    "VisualShape.material": Quantity("int64", table="visual_materials"),
    "inertia": _POSITIVE3,
    "pick": Quantity("int64", bounds=COUNT),
    "static_friction": _NON_NEGATIVE,
    "dynamic_friction": _NON_NEGATIVE,
    "restitution": _UNIT,
    "base_color": Quantity(shape=(4,), bounds=UNIT_INTERVAL),
    "emission": Quantity(shape=(4,), bounds=NON_NEGATIVE),
    "specular": _UNIT,
    "roughness": _UNIT,
    "metallic": _UNIT,
    "transmission": _UNIT,
    "transmission_roughness": _UNIT,
    "ior": Quantity(bounds=Bounds(1, FLOAT32_MAX)),
}
"""`Value` fields by name; `Class.field` goes before `field`."""
