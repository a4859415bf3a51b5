"""Articulations: links, joints and drives, from a robot's file or as a tree in the scene file."""

from math import inf
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AfterValidator, Field, Strict, Tag, WithJsonSchema
from typing_extensions import TypeAliasType

from scenecc.plan.properties import DEFAULT_DENSITY
from scenecc.spec.base import (
    MAPPING_KEY,
    PATTERN,
    Excludes,
    Finite,
    GroupName,
    Iterations,
    Maybe,
    Name,
    NameRole,
    NonNegative,
    Positive,
    SpecModel,
    Text,
    Unit,
    Vec3,
    VelocityIterations,
    custom_error,
    key,
    list_key,
    names_key,
)
from scenecc.spec.body import EntityKeys, MotionKeys
from scenecc.spec.nodes import COMPONENTS, MAPPING, LazyType, union_by_kind
from scenecc.spec.pose import Direction, Pose
from scenecc.spec.references import PatternError, compile_name_pattern
from scenecc.spec.repetition import CopyKeys, RepeatKeys
from scenecc.spec.shapes import CollisionBits, CollisionSpec, MaterialRef, ShapeSpec, VisualSpec
from scenecc.spec.values import Fixed, Leaf

if TYPE_CHECKING:
    from scenecc.spec.mesh_shapes import CoacdKeys
    from scenecc.spec.physics import InertialSpec
else:
    CoacdKeys = Annotated[Any, LazyType("scenecc.spec.mesh_shapes", "CoacdKeys")]
    InertialSpec = Annotated[Any, LazyType("scenecc.spec.physics", "InertialSpec")]

_PATTERN_HINT = (
    "letters, `.`, `[…]`, `|`, groups, `?`, `*`, `+` and `{m,n}`; `*` and `+` repeat letters, sets, and groups "
    "without `|` or repetition; a pattern matches whole names"
)


def _check_pattern(text: str) -> str:
    try:
        compile_name_pattern(text)
    except PatternError as error:
        raise custom_error("SC323", str(error), at="key", hint=_PATTERN_HINT) from error
    return text


Pattern = Annotated[str, AfterValidator(_check_pattern), MAPPING_KEY, PATTERN]
"""A regular expression that matches whole names."""

LinkPattern = Annotated[Pattern, NameRole("link")]

JointPattern = Annotated[Pattern, NameRole("joint")]

_Limit = Annotated[float, Field(ge=-inf, allow_inf_nan=True)]

LimitPair = Annotated[tuple[_Limit, _Limit], Strict(strict=False)]

Limits = TypeAliasType("Limits", Leaf[LimitPair])
"""[lowest, highest]; `-.inf` and `.inf` for no limit."""

MAX_JOINTS = 4096
"""Most numbers in a list of joint values; no articulation has more joints."""

JointNumbers = TypeAliasType(
    "JointNumbers",
    Leaf[
        Annotated[
            Annotated[list[Finite], Field(min_length=0, max_length=MAX_JOINTS), Tag(COMPONENTS)]
            | Annotated[dict[Annotated[str, MAPPING_KEY, NameRole("joint")], Leaf[Finite]], Tag(MAPPING)],
            union_by_kind("a list of one number for each joint that moves, or a mapping of their names"),
        ]
    ],
)
"""One number per moving joint, in SAPIEN's order or by name."""


class LinkKeys(MotionKeys):
    """Keys of a link."""

    material: Maybe[MaterialRef] = key("Material of its shapes.")
    density: Maybe[Leaf[NonNegative]] = key("Density of its shapes [kg/m³].")
    patch_radius: Maybe[Leaf[NonNegative]] = key("Torsional patch radius of its shapes [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("Smallest torsional patch radius of its shapes [m].", default=0)
    collision_group: Maybe[Fixed[GroupName]] = key("A name from `collision_groups`.")
    collision_bits: Maybe[Fixed[CollisionBits]] = key(
        "SAPIEN's four integers, used unchanged; not with `collision_group`.",
        default=[1, 1, 0, 0],
        excludes=("collision_group",),
    )
    mass: Maybe[Leaf[Positive]] = key("Mass [kg]; scales the inertia accordingly.")
    com: Maybe[Leaf[Vec3]] = key("Centre of mass in the link's frame [m]; mass and inertia about it stay.")
    inertial: Maybe[InertialSpec] = key("Explicit mass properties; not with `mass` or `com`.", excludes=("mass", "com"))
    visibility: Maybe[Leaf[Unit]] = key("Visibility of the render body, 0 to 1.", default=1)


class JointKeys(SpecModel):
    """Keys of joints."""

    friction: Maybe[Leaf[NonNegative]] = key("Friction as a ratio of the joint's load.", default=0.05)
    friction_force: Maybe[Leaf[NonNegative]] = key(
        "Friction that does not depend on the load [N or N·m]. A drive replaces it. Default: the file's."
    )
    armature: Maybe[Leaf[NonNegative]] = key("Inertia of the actuator, added to the joint [kg or kg·m²].", default=0)
    limits: Maybe[Limits] = key("Lowest and highest position [m or rad].", examples=[[-1.57, 1.57]])
    limits_deg: Maybe[Limits] = key("The same in degrees.", examples=[[-90, 90]], excludes=("limits",))
    max_velocity: Maybe[Leaf[Positive]] = key("Maximum speed [m/s or rad/s].")


class DriveKeys(SpecModel):
    """Keys of joint drives. A drive replaces the joint's own damping."""

    stiffness: Maybe[Leaf[NonNegative]] = key("Stiffness: force per metre or radian of position error.", default=0)
    damping: Maybe[Leaf[NonNegative]] = key(
        "Damping: force per metre or radian per second of velocity error.", default=0
    )
    force_limit: Maybe[Leaf[NonNegative]] = key("Maximum force [N or N·m]. Default: a URDF's effort.")
    mode: Maybe[Fixed[Literal["force", "acceleration"]]] = key(
        "Whether stiffness and damping scale a force or an acceleration.", default="force"
    )
    target: Maybe[Leaf[Finite]] = key(
        "Target position. Default: the initial position of the joint, also after a reset."
    )
    velocity_target: Maybe[Leaf[Finite]] = key("Target velocity [m/s or rad/s].", default=0)


TreeJointType = Literal["fixed", "revolute", "revolute_unwrapped", "continuous", "prismatic"]


class MimicKeys(SpecModel):
    """A joint that follows another joint."""

    joint: Fixed[Annotated[Name, NameRole("joint")]] = Field(description="The other joint.")
    multiplier: Maybe[Leaf[Finite]] = key("Factor of its position.", default=1)
    offset: Maybe[Leaf[Finite]] = key("Offset added to the product [m or rad].", default=0)


class TreeJoint(SpecModel):
    """The joint between a link and its parent."""

    name: Maybe[Fixed[Name]] = key("Name of the joint in `qpos`, `joints` and `drives`.")
    type: Fixed[TreeJointType] = Field(
        description="fixed; revolute, revolute_unwrapped, continuous (no limits): about the axis; prismatic: along it."
    )
    origin: Maybe[Pose] = key("Pose of the link in its parent's frame when the joint is at 0.", default=[0, 0, 0])
    axis: Maybe[Leaf[Direction]] = key("Axis in the link's frame: [x, y, z] or one of x, y, z.", default="x")
    pose_in_parent: Maybe[Pose] = key(
        "Pose of the joint's frame in the parent, instead of `origin`; its x is the axis.", excludes=("origin", "axis")
    )
    pose_in_child: Maybe[Pose] = key(
        "Pose of the joint's frame in the link, instead of `axis`; its x is the axis.", excludes=("origin", "axis")
    )
    limits: Maybe[Limits] = key("Lowest and highest position [m or rad]. Default: no limits.", examples=[[0, 1.57]])
    limits_deg: Maybe[Limits] = key("The same in degrees.", examples=[[0, 90]], excludes=("limits",))
    friction: Maybe[Leaf[NonNegative]] = key("Friction as a ratio of the joint's load.", default=0.05)
    friction_force: Maybe[Leaf[NonNegative]] = key(
        "Friction that does not depend on the load [N or N·m], instead of `damping`; `drives` replaces it.",
        excludes=("damping",),
    )
    damping: Maybe[Leaf[NonNegative]] = key("Damping [N·s/m or N·m·s/rad]; `drives` replaces it.", default=0)
    armature: Maybe[Leaf[NonNegative]] = key("Inertia of the actuator, added to the joint [kg or kg·m²].", default=0)
    max_velocity: Maybe[Leaf[Positive]] = key("Maximum speed [m/s or rad/s].")
    mimic: Maybe[MimicKeys] = key("The joint to mimic.")


if TYPE_CHECKING:
    Children = list["ChildLink"]
else:
    Children = list[
        Annotated[Any, LazyType("scenecc.spec.articulation", "ChildLink"), WithJsonSchema({"x-ref": "ChildLink"})]
    ]


class TreeLink(LinkKeys):
    """A link with its child links."""

    name: Fixed[Name] = Field(description="Name of the link in `links` and mounts.")
    joint: Maybe[TreeJoint] = key("Joint to the parent link; for all links except the root.")
    shapes: list[ShapeSpec] = list_key("Shapes that collide and are visible.")
    collisions: list[CollisionSpec] = list_key("Collision-only shapes.")
    visuals: list[VisualSpec] = list_key("Visual-only shapes.")
    children: Children = list_key("Child links.")


class ChildLink(TreeLink, CopyKeys):
    """A link with its parent, or several copies. Copies without an expression in their `name` are NAME_0, NAME_1, …."""


if TYPE_CHECKING:
    RootLink = TreeLink
else:
    RootLink = Annotated[Any, LazyType("scenecc.spec.articulation", "TreeLink")]


class JointPatterns(SpecModel):
    """Keys for links, joints and drives, by name pattern."""

    links: dict[LinkPattern, LinkKeys] = names_key("Pattern of names → properties of the matching links.")
    joints: dict[JointPattern, JointKeys] = names_key("Pattern of names → properties of the matching joints.")
    drives: dict[JointPattern, DriveKeys] = names_key(
        "Pattern of names → drives of the matching joints.",
        examples=[{"panda_joint.*": {"stiffness": 1000, "damping": 100, "force_limit": 100}}],
    )


if TYPE_CHECKING:
    Part = Any
else:
    Part = Annotated[Any, LazyType("scenecc.spec.attachments", "Part")]


class ArticulationKeys(JointPatterns, EntityKeys, RepeatKeys):
    """Keys of any articulation."""

    body_type: Maybe[Fixed[Literal["static", "kinematic"]]] = key(
        "Makes one body of all links, at their poses at `qpos`: static (fixed) or kinematic (moved by your program). "
        "Default: an articulation whose joints move.",
        examples=["static"],
    )
    fix_root_link: Maybe[Leaf[bool]] = key(
        "Whether the root is fixed to the world. Default: true for a file, false for a `root`."
    )
    qpos: Maybe[JointNumbers] = key(
        "Initial joint positions [m or rad]: a list in SAPIEN's order, or by name. Default: 0, or the nearest limit."
    )
    qvel: Maybe[JointNumbers] = key("Initial joint velocities [m/s or rad/s]: a list in SAPIEN's order, or by name.")
    linear_velocity: Maybe[Leaf[Vec3]] = key(
        "Initial linear velocity of a free root, world frame [m/s].", default=[0, 0, 0]
    )
    angular_velocity: Maybe[Leaf[Vec3]] = key(
        "Initial angular velocity of a free root, world frame [rad/s].", default=[0, 0, 0]
    )
    beyond_limits: Maybe[Fixed[bool]] = key(
        "true: `qpos` may be outside the limits, which then push the joint back, and a drive may pull beyond them.",
        default=False,
    )
    gravity: Maybe[Leaf[bool]] = key("Whether gravity acts on its links.", default=True)
    material: Maybe[MaterialRef] = key("Material of its links.")
    density: Maybe[Leaf[NonNegative]] = key("Density of its links [kg/m³].", default=DEFAULT_DENSITY)
    patch_radius: Maybe[Leaf[NonNegative]] = key("For its links [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("For its links [m].", default=0)
    collision_group: Maybe[Fixed[GroupName]] = key("A name from `collision_groups`, for its links.")
    disable_self_collisions: Maybe[Fixed[bool]] = key("true: its links do not collide with one another.", default=False)
    sapien_bits: Maybe[Fixed[bool]] = key(
        "true: links that ignore one another also ignore those of other robots with this key, as in SAPIEN's loader.",
        default=False,
    )
    solver_position_iterations: Maybe[Leaf[Iterations]] = key("1 to 255.", default=10)
    solver_velocity_iterations: Maybe[Leaf[VelocityIterations]] = key("0 to 255.", default=1)
    sleep_threshold: Maybe[Leaf[NonNegative]] = key("Energy per mass below which it sleeps [m²/s²].", default=0.005)
    visibility: Maybe[Leaf[Unit]] = key("Visibility of its links, 0 to 1.", default=1)
    attach: dict[Annotated[Name, MAPPING_KEY], Part] = names_key(
        "Parts from other files, by name. They are built as one articulation."
    )


def _check_distinct(names: list[Any]) -> list[Any]:
    """Rejects a repair or geom group that is named twice."""
    repeated = next((one for number, one in enumerate(names) if one in names[:number]), None)
    if repeated is not None:
        what = "repair" if isinstance(repeated, str) else "group"
        raise custom_error("SC104", f"`{repeated}` is named twice", hint=f"name each {what} once")
    return names


Repairs = Annotated[
    list[Literal["inertia", "mass", "limits", "files", "shapes"]],
    AfterValidator(_check_distinct),
    WithJsonSchema(
        {"type": "array", "items": {"enum": ["inertia", "mass", "limits", "files", "shapes"]}, "uniqueItems": True}
    ),
]


VisualGroups = Annotated[
    list[Annotated[int, Field(ge=0, le=5)]],
    AfterValidator(_check_distinct),
    WithJsonSchema({"type": "array", "items": {"type": "integer", "minimum": 0, "maximum": 5}, "uniqueItems": True}),
]
"""MuJoCo's groups of geoms are 0 to 5."""


class UrdfKeys(SpecModel):
    """A URDF and its loader options."""

    urdf: Annotated[Leaf[Annotated[Text, NameRole("URDF file")]], Excludes(("mjcf", "root"))] = Field(
        description="The file.", examples=["robots/arm.urdf"]
    )
    srdf: Maybe[Leaf[Annotated[Text, NameRole("SRDF file")]]] = key(
        "SRDF with the pairs of links that do not collide, or `none`. Default: the SRDF beside the URDF."
    )
    package_dir: Maybe[Leaf[Text]] = key("Folder that resolves `package://` in the file.")
    repair: Maybe[Fixed[Repairs]] = key(
        "What to repair in the file: `inertia` (impossible moments become those of the collision shapes), `mass` "
        "(fixed links without a mass get almost none), `limits` "
        "(missing limits are infinite), `files` (missing textures, .mtl and visual meshes are omitted), `shapes` "
        "(collisions of size 0 are omitted). Each repair is a note.",
        examples=[["inertia", "limits", "files"]],
    )
    scale: Maybe[Leaf[Positive]] = key("Scale of all lengths.", default=1)
    collision_is_visual: Maybe[Fixed[bool]] = key("Also show the collision shapes.", default=False)
    load_multiple_collisions: Maybe[Fixed[bool]] = key(
        "Each connected part of a mesh collides by itself, instead of the convex hull of the mesh.", default=False
    )
    decomposition: Maybe[Fixed[Literal["none", "coacd"]]] = key(
        "none: the file's own parts; coacd: cut by CoACD (extra `convex`).", default="none"
    )
    decomposition_params: Maybe[CoacdKeys] = key("CoACD's arguments.")


class Urdf(UrdfKeys, ArticulationKeys):
    """An articulation that a URDF describes."""


class MjcfKeys(SpecModel):
    """An MJCF and its loader options."""

    mjcf: Annotated[Leaf[Annotated[Text, NameRole("MJCF file")]], Excludes(("urdf", "root"))] = Field(
        description="The file.", examples=["robots/ant.xml"]
    )
    keyframe: Maybe[Leaf[Text]] = key("The keyframe of the file that gives initial positions; `qpos` replaces it.")
    visual_groups: Maybe[Fixed[VisualGroups]] = key("The visible geom groups.", default=[0, 1, 2])


class Mjcf(MjcfKeys, ArticulationKeys):
    """An articulation that an MJCF describes."""


class TreeKeys(SpecModel):
    """A tree of links."""

    root: Annotated[RootLink, Excludes(("urdf", "mjcf"))] = Field(description="The root link with its descendants.")


class Tree(TreeKeys, ArticulationKeys):
    """An articulation written as a tree of links."""
