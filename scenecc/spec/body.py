"""Bodies: shapes, mass and properties of a rigid body."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field, Tag

from scenecc.plan.properties import DEFAULT_DENSITY
from scenecc.spec.base import (
    GroupName,
    Iterations,
    Maybe,
    NonNegative,
    Positive,
    SpecModel,
    Speed,
    Text,
    Unit,
    Vec3,
    VelocityIterations,
    key,
    list_key,
)
from scenecc.spec.nodes import LIST, NUMBER, WORD, LazyType, union_by_kind
from scenecc.spec.pose import Pose
from scenecc.spec.shapes import CollisionBits, CollisionSpec, Color, MaterialRef, ShapeSpec, VisualSpec
from scenecc.spec.values import Fixed, Leaf

if TYPE_CHECKING:
    from scenecc.spec.physics import InertialSpec
    from scenecc.spec.placing import PlaceSpec
else:
    PlaceSpec = Annotated[Any, LazyType("scenecc.spec.placing", "PlaceSpec")]
    InertialSpec = Annotated[Any, LazyType("scenecc.spec.physics", "InertialSpec")]

BodyTypeName = Literal["dynamic", "kinematic", "static", "none"]
MotionAxis = Literal["x", "y", "z", "rx", "ry", "rz"]
MOTION_AXES: tuple[MotionAxis, ...] = ("x", "y", "z", "rx", "ry", "rz")

SceneItem = Fixed[
    Annotated[
        Annotated[int, Tag(NUMBER)] | Annotated[Text, Tag(WORD)], union_by_kind('an index or a slice such as "0:8"')
    ]
]
SceneIdxs = Fixed[
    Annotated[
        Annotated[list[SceneItem], Tag(LIST)] | Annotated[Text, Tag(WORD)],
        union_by_kind('a list of indices, or a slice such as "0:8"'),
    ]
]
"""[0, 2], a slice ("0:8", "::2", "4:"), or a list of both."""


class EntityKeys(SpecModel):
    """Keys of any entity."""

    pose: Maybe[Pose] = key("Pose in the world, or in the frame of `relative_to`: [x, y, z] or a mapping.")
    place: Maybe[PlaceSpec] = key("Instead of `pose`: finds a pose at which it overlaps nothing.", excludes=("pose",))
    scene_idxs: Maybe[SceneIdxs] = key(
        'The scenes it exists in: indices, a slice such as "0:8", or a list of both. Default: every scene.',
        examples=[[0, 2], "::2"],
    )
    hidden: Fixed[bool] = Field(default=False, description="true: hidden from cameras of the file, visible in viewers.")


class MotionKeys(SpecModel):
    """Gravity, damping and velocity limits of bodies and links."""

    gravity: Maybe[Leaf[bool]] = key("Whether gravity acts on it.", default=True)
    linear_damping: Maybe[Leaf[NonNegative]] = key("Damping [1/s]; default: 0, for a link 0.05.")
    angular_damping: Maybe[Leaf[NonNegative]] = key("[1/s]", default=0.05)
    max_linear_velocity: Maybe[Leaf[Speed]] = key("Maximum linear velocity [m/s]; default: none, for a link 10.")
    max_angular_velocity: Maybe[Leaf[Speed]] = key("Maximum angular velocity [rad/s]; default: 100, for a link 50.")
    max_depenetration_velocity: Maybe[Leaf[Positive]] = key("Maximum speed at which an overlap is resolved [m/s].")
    max_contact_impulse: Maybe[Leaf[Positive]] = key("[N·s]")


class RigidBodyKeys(MotionKeys):
    """The properties of a rigid body component."""

    linear_velocity: Maybe[Leaf[Vec3]] = key("Initial linear velocity, world frame [m/s].", default=[0, 0, 0])
    angular_velocity: Maybe[Leaf[Vec3]] = key("Initial angular velocity, world frame [rad/s].", default=[0, 0, 0])
    locked_axes: Maybe[Fixed[list[Fixed[MotionAxis]]]] = key(
        "Axes of translation and rotation that are locked.", default=[]
    )
    sleep_threshold: Maybe[Leaf[NonNegative]] = key("Energy per mass below which it sleeps [m²/s²].", default=0.005)
    solver_position_iterations: Maybe[Leaf[Iterations]] = key("1 to 255.", default=10)
    solver_velocity_iterations: Maybe[Leaf[VelocityIterations]] = key("0 to 255.", default=1)


class BodyKeys(RigidBodyKeys):
    """Keys of a body: shapes, mass, properties."""

    body_type: Fixed[BodyTypeName] = Field(
        default="dynamic",
        description="dynamic: moved by forces; kinematic: moved by your program; static: fixed; none: only visible.",
    )
    shapes: list[ShapeSpec] = list_key("Shapes that collide and are visible.")
    collisions: list[CollisionSpec] = list_key("Collision-only shapes.")
    visuals: list[VisualSpec] = list_key("Visual-only shapes.")
    material: Maybe[MaterialRef] = key("Material of shapes without their own.")
    color: Maybe[Color] = key("Base colour of shapes without their own.")
    density: Maybe[Leaf[NonNegative]] = key(
        "Density of shapes without their own or their material's [kg/m³].", default=DEFAULT_DENSITY
    )
    mass: Maybe[Leaf[Positive]] = key("Mass [kg]; scales the mass and inertia from the densities.")
    com: Maybe[Leaf[Vec3]] = key("Centre of mass in the body's frame [m]; mass and inertia about it stay.")
    inertial: Maybe[InertialSpec] = key("Explicit mass properties; not with `mass` or `com`.", excludes=("mass", "com"))
    collision_group: Maybe[Fixed[GroupName]] = key("A name from `collision_groups`.")
    collision_bits: Maybe[Fixed[CollisionBits]] = key(
        "SAPIEN's four integers; not with `collision_group`.", default=[1, 1, 0, 0], excludes=("collision_group",)
    )
    visibility: Maybe[Leaf[Unit]] = key("Visibility of the render body, 0 to 1.", default=1)
    shading_mode: Maybe[Leaf[Annotated[int, Field(ge=0, le=255)]]] = key("Shading mode of the render body.", default=0)


class BodySpec(EntityKeys, BodyKeys):
    """One rigid body per scene: shapes, mass, properties."""
