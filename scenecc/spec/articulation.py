"""Articulations: links and joints, from a robot's file or written in the scene file."""

from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from scenecc.spec.articulation_maps import DriveKeys, JointKeys, JointNumbers, LinkKeys, Pattern
from scenecc.spec.base import Maybe, Name, Text, key
from scenecc.spec.body import EntityKeys
from scenecc.spec.copies import Copies
from scenecc.spec.later import Later
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.material import MaterialRef
from scenecc.spec.scalars import Iterations, NonNegative, Positive, Unit, Vec3, VelocityIterations
from scenecc.spec.shape_types.convex_parts import CoacdKeys

if TYPE_CHECKING:
    from scenecc.spec.articulation_tree import TreeLink

    Root = TreeLink
else:
    Root = Annotated[Any, Later("scenecc.spec.articulation_tree", "TreeLink")]


def _nothing() -> dict[str, Any]:
    return {}


class ArticulationKeys(EntityKeys, Copies):
    """Keys of any articulation."""

    fix_root_link: Maybe[Leaf[bool]] = key("Whether the root stays where it is. true for a file, false for a `root`.")
    qpos: Maybe[JointNumbers] = key(
        "Joint positions at the start [m or rad]: a list in SAPIEN's order, or by name. Left out: 0, or the nearest "
        "limit."
    )
    qvel: Maybe[JointNumbers] = key("Joint velocities at the start [m/s or rad/s], likewise.")
    linear_velocity: Maybe[Leaf[Vec3]] = key("Of a free root at the start, world frame [m/s].", default=[0, 0, 0])
    angular_velocity: Maybe[Leaf[Vec3]] = key("Of a free root at the start, world frame [rad/s].", default=[0, 0, 0])
    beyond_limits: Maybe[Fixed[bool]] = key(
        "true: `qpos` is taken as it is, also outside of the limits, which then push the joint back, and a drive may "
        "pull beyond them.",
        default=False,
    )
    gravity: Maybe[Leaf[bool]] = key("false: gravity pulls none of its links.", default=True)
    material: Maybe[MaterialRef] = key("For its links.")
    density: Maybe[Leaf[NonNegative]] = key("For its links [kg/m³].", default=1000)
    patch_radius: Maybe[Leaf[NonNegative]] = key("For its links [m].", default=0)
    min_patch_radius: Maybe[Leaf[NonNegative]] = key("For its links [m].", default=0)
    collision_group: Maybe[Fixed[Name]] = key("A name from `collision_groups`, for its links.")
    disable_self_collisions: Maybe[Fixed[bool]] = key("true: no two of its links collide.", default=False)
    sapien_bits: Maybe[Fixed[bool]] = key(
        "true: what ignores one another among its links ignores the same of others that have it, as SAPIEN's loader "
        "does.",
        default=False,
    )
    solver_position_iterations: Maybe[Leaf[Iterations]] = key("1 to 255.", default=10)
    solver_velocity_iterations: Maybe[Leaf[VelocityIterations]] = key("0 to 255.", default=1)
    sleep_threshold: Maybe[Leaf[NonNegative]] = key("Energy per mass below which it sleeps [m²/s²].", default=0.005)
    visibility: Maybe[Leaf[Unit]] = key("Of its links, 0 to 1.", default=1)
    links: dict[Pattern, LinkKeys] = Field(
        default_factory=_nothing, description="Pattern of names → what such links have."
    )
    joints: dict[Pattern, JointKeys] = Field(
        default_factory=_nothing, description="Pattern of names → what such joints have."
    )
    drives: dict[Pattern, DriveKeys] = Field(
        default_factory=_nothing,
        description="Pattern of names → the drives of such joints.",
        examples=[{"panda_joint.*": {"stiffness": 1000, "damping": 100, "force_limit": 100}}],
    )


class Urdf(ArticulationKeys):
    """An articulation that a URDF describes."""

    urdf: Leaf[Text] = Field(description="The file.", examples=["robots/arm.urdf"])
    srdf: Maybe[Leaf[Text]] = key(
        "The file with the pairs of links that ignore one another, or `none`. Left out: the one beside the URDF."
    )
    package_dir: Maybe[Leaf[Text]] = key("The folder in which `package://` of the file looks.")
    scale: Maybe[Leaf[Positive]] = key("Of all lengths.", default=1)
    collision_is_visual: Maybe[Fixed[bool]] = key("Show what collides as well.", default=False)
    load_multiple_collisions: Maybe[Fixed[bool]] = key(
        "The connected parts of a mesh collide one by one, rather than its convex hull.", default=False
    )
    decomposition: Maybe[Fixed[Literal["none", "coacd"]]] = key(
        "none: the file's own parts; coacd: cut by CoACD (extra `convex`).", default="none"
    )
    decomposition_params: Maybe[CoacdKeys] = key("CoACD's arguments.")


class Mjcf(ArticulationKeys):
    """An articulation that an MJCF describes."""

    mjcf: Leaf[Text] = Field(description="The file.", examples=["robots/ant.xml"])


class Tree(ArticulationKeys):
    """An articulation that is written as a tree of links."""

    root: Root = Field(description="The root link, with all that hangs on it.")
