"""Robots and bodies as described by a file of another format.

Numbers are those for the engine: for a URDF exactly those that SAPIEN's loader would pass, for an MJCF those of
MuJoCo's compiled model. The file's scale is applied. Poses are seven numbers: p [m], then q (wxyz). A value that the
file omits is None. `scenecc.robots.world` adds the rest of a world.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Location

SapienJointType = Literal["fixed", "revolute", "revolute_unwrapped", "prismatic"]

MeshCollision = Literal["hull", "parts", "coacd", "triangles", "sdf"]
"""How a mesh collides: as its convex hull, the hulls of its connected parts, convex parts by CoACD, its triangles, or
its triangles with a signed distance field."""

MotionAxis = Literal["x", "y", "z", "rx", "ry", "rz"]


@frozen
class SolidGeometry:
    """A primitive: a box, sphere, capsule, cylinder or cone with the `sizes` of `plan.geometry` [m].

    Round solids lie along x of the shape's pose.
    """

    kind: str
    sizes: tuple[float, ...]


@frozen
class PlaneGeometry:
    """A plane with normal x. `half_size`: of its visual shape, along y and z [m]."""

    half_size: tuple[float, float] | None = None


@frozen
class MeshGeometry:
    """A mesh.

    Attributes:
        uri: URI for a scene: `pkg://…` or `asset://…` if the robot's file has that scheme, else a path relative to the
            top scene's folder, else an absolute path.
        path: path on this machine.
        scale: factors of the vertices, nonzero; negative factors mirror.
        collision: None: an option of the scene decides between "hull" and "parts".
        optional_names: whether files that the mesh names may be missing.
        data: content of a mesh that has no file of its own, see `numeric_mesh`; the name of a copy is that of `uri`.
    """

    uri: str
    path: Path
    scale: Vec3
    collision: MeshCollision | None = None
    optional_names: bool = False
    data: bytes | None = None


@frozen
class HeightfieldGeometry:
    """Terrain. `size` and `heights` are as in `plan.geometry.Heightfield`; `image`: a grey PNG instead of `heights`."""

    size: Vec3
    heights: tuple[tuple[float, ...], ...] = ()
    image: Path | None = None


Geometry = SolidGeometry | PlaneGeometry | MeshGeometry | HeightfieldGeometry


@frozen
class DescribedTexture:
    """An image. `uri`: for a scene; `srgb`, `address_mode`: as in the scene language, None: its default."""

    uri: str
    path: Path
    srgb: bool | None = None
    address_mode: Literal["border", "edge", "mirror"] | None = None


@frozen
class DescribedMaterial:
    """A visual material. None: SAPIEN's default.

    Attributes:
        name: in the file, under which shapes share it; "": none.
        base_color: linear RGBA, as in SAPIEN.
        emission: linear RGB or RGBA.
    """

    base_color: tuple[float, float, float, float] | None = None
    emission: tuple[float, ...] | None = None
    specular: float | None = None
    roughness: float | None = None
    metallic: float | None = None
    base_color_texture: DescribedTexture | None = None
    normal_texture: DescribedTexture | None = None
    roughness_texture: DescribedTexture | None = None
    metallic_texture: DescribedTexture | None = None
    emission_texture: DescribedTexture | None = None
    name: str = ""


@frozen
class DescribedCollision:
    """A collision shape.

    Attributes:
        pose: in the link's frame.
        friction: static friction, dynamic friction and restitution; None: not in the file.
        density: [kg/m³]; None: not in the file.
        bits: the first two of SAPIEN's collision integers; None: not in the file.
        location: the line that names the geometry.
        contact_offset, rest_offset: [m].
        material: name of the material of `friction` in the file, under which shapes share it; "": none.
    """

    geometry: Geometry
    pose: Pose7
    location: Location
    friction: tuple[float, float, float] | None = None
    density: float | None = None
    bits: tuple[int, int] | None = None
    contact_offset: float | None = None
    rest_offset: float | None = None
    material: str = ""


@frozen
class DescribedVisual:
    """A visual shape. `look` None: a mesh keeps its own materials, other shapes get the default."""

    geometry: Geometry
    pose: Pose7
    location: Location
    name: str = ""
    look: DescribedMaterial | None = None


@frozen
class DescribedInertial:
    """Mass [kg], centre of mass with principal axes, principal moments [kg·m²].

    `inertia` None: inertia and centre of mass come from the link's collision shapes, scaled to the mass; with
    `keeps_com`, the centre of mass is nevertheless that of `com`.
    """

    mass: float
    com: Pose7
    inertia: Vec3 | None
    location: Location
    keeps_com: bool = False


def ball_moment(mass: float) -> float:
    """Returns the moment of inertia of a sphere of water, 2/5 · m · r² [kg·m²], for a mass [kg] without shapes."""
    radius = (3 * mass / (4 * math.pi * _WATER_DENSITY)) ** (1 / 3)
    return 0.4 * mass * radius**2


_WATER_DENSITY = 1000.0
"""[kg/m³]."""


@frozen
class DescribedMimic:
    """A mimic: position = multiplier · position of source + offset."""

    source: str
    multiplier: float
    offset: float
    location: Location


@frozen
class DescribedDrive:
    """A drive: stiffness and damping per metre or radian, force limit [N, N·m] (None: unlimited), target [m, rad].

    `target` None: the joint's initial position. `mode`: whether stiffness and damping scale a force or an acceleration.
    `velocity_target`: [m/s, rad/s].
    """

    stiffness: float
    damping: float
    force_limit: float | None = None
    target: float | None = None
    mode: Literal["force", "acceleration"] = "force"
    velocity_target: float = 0.0


@frozen
class DescribedJoint:
    """A joint between a link and its parent.

    Attributes:
        type: SAPIEN joint type. URDF's `continuous` is `revolute` with infinite limits.
        limits: lowest and highest position [m, rad], possibly infinite; None for a fixed joint.
        friction: PhysX's ratio of friction to load; None: not in the file.
        friction_force: friction that does not depend on the load, above 0 [N, N·m]; None: not in the file.
        armature: None: not in the file.
        damping: 0 if not in the file.
        effort, velocity: limits of the actuator, above 0; None: not in the file.
        qpos: initial position [m, rad], within the limits for a robot's file; None: not in the file.
        drive: None: the joint has only its damping.
        qvel: initial velocity [m/s, rad/s]; None: not in the file.
    """

    name: str
    type: SapienJointType
    pose_in_parent: Pose7
    pose_in_child: Pose7
    location: Location
    limits: tuple[float, float] | None = None
    friction: float | None = None
    friction_force: float | None = None
    damping: float = 0.0
    armature: float | None = None
    effort: float | None = None
    velocity: float | None = None
    mimic: DescribedMimic | None = None
    qpos: float | None = None
    drive: DescribedDrive | None = None
    qvel: float | None = None


@frozen
class DescribedMotion:
    """Damping [1/s] and limits of the motion of a body or link [m/s, rad/s, N·s]."""

    linear_damping: float | None = None
    angular_damping: float | None = None
    max_linear_velocity: float | None = None
    max_angular_velocity: float | None = None
    max_depenetration_velocity: float | None = None
    max_contact_impulse: float | None = None


@frozen
class DescribedLink:
    """A link.

    Attributes:
        parent: index of its parent, a link before it; None for the root.
        joint: joint to the parent; None for the root.
        ignore_bits: ignore bits (SAPIEN's third collision integer) of its shapes; links that share a bit do not
            collide.
        disable_gravity: whether gravity is off.
        motion: None: not in the file.
        source: name in the source's own library, to compare poses and masses; "": its name.
        is_added: whether the source has no such link: it is between freedoms of a joint, or the root before a joint.
    """

    name: str
    location: Location
    parent: int | None = None
    joint: DescribedJoint | None = None
    collisions: tuple[DescribedCollision, ...] = ()
    visuals: tuple[DescribedVisual, ...] = ()
    inertial: DescribedInertial | None = None
    ignore_bits: int = 0
    disable_gravity: bool = False
    motion: DescribedMotion | None = None
    source: str = ""
    is_added: bool = False


@frozen
class DescribedDynamics:
    """Initial velocities in the world frame [m/s, rad/s], and settings of the solver, of a body or an articulation.

    Attributes:
        locked_axes: of a body only.
        sleep_threshold: energy per mass [m²/s²].
    """

    linear_velocity: Vec3 | None = None
    angular_velocity: Vec3 | None = None
    locked_axes: tuple[MotionAxis, ...] = ()
    sleep_threshold: float | None = None
    solver_position_iterations: int | None = None
    solver_velocity_iterations: int | None = None


@frozen
class DescribedRobot:
    """A tree of links, or a single body.

    Attributes:
        links: in SAPIEN's build order, the root first.
        body_type: of a single body; None: an articulation.
        fixed: whether the root is fixed to the world; None: the scene decides.
        pose: pose of the root in the file's frame.
        ignored: SRDF pair of each bit of `DescribedLink.ignore_bits`.
        self_collisions: whether its links collide with one another.
        dynamics: None: not in the file.
        ignores_alone: whether these bits are only of this robot, not of all robots of the file.
    """

    links: tuple[DescribedLink, ...]
    body_type: Literal["dynamic", "kinematic", "static"] | None = None
    fixed: bool | None = None
    pose: Pose7 = IDENTITY_POSE
    location: Location | None = None
    ignored: tuple[Location, ...] = ()
    self_collisions: bool = True
    dynamics: DescribedDynamics | None = None
    ignores_alone: bool = False


LinkName = tuple[str, str]
"""Names of a robot's or body's root (in a world: of its entity) and of one of its links."""

IN_WORLD: Final[LinkName] = ("world", "")
"""Stands for the world itself, as the parent of a constraint."""

LimitAxis = Literal["x", "y", "z", "twist"]

DriveAxis = Literal["x", "y", "z", "twist", "swing", "slerp"]


@frozen
class DescribedConstraint:
    """A constraint between frames of two links. A robot's file has only welds and connections.

    Attributes:
        type: as in the section `constraints` of a scene: "weld" holds the whole pose, "connection" the origin.
        parent: `IN_WORLD` is possible.
        span: of "distance" [m], "hinge" [rad] and "slider" [m]; infinite: no limit. None: no limits.
        limits: of "drive": axis, lowest and highest position [m, rad]; other axes are free.
        drives: of "drive"; of "hinge" and "slider" one, under "twist" or "x".
        target: of "drive": pose of the child's frame in the parent's frame.
        velocity_target: of "drive": linear [m/s] and angular [rad/s].
        collide: whether the two links collide with each other.
    """

    name: str
    type: Literal["weld", "ball", "connection", "distance", "drive", "hinge", "slider"]
    parent: LinkName
    child: LinkName
    pose_in_parent: Pose7
    pose_in_child: Pose7
    location: Location
    span: tuple[float, float] | None = None
    limits: tuple[tuple[LimitAxis, float, float], ...] = ()
    drives: tuple[tuple[DriveAxis, DescribedDrive], ...] = ()
    target: Pose7 = IDENTITY_POSE
    velocity_target: tuple[Vec3, Vec3] | None = None
    collide: bool = False


@frozen
class DescribedFile:
    """A file that a description refers to, its URI for a scene, and where it is named."""

    uri: str
    path: Path
    location: Location


@frozen
class RobotDescription:
    """The content of a robot file.

    Attributes:
        robots: in build order; not empty.
        files: every file that it refers to (meshes, textures, included files, an SRDF), each once.
        constraints: between its links.
        read_by: program and version that read the file; None: scenecc.
    """

    robots: tuple[DescribedRobot, ...]
    files: tuple[DescribedFile, ...] = ()
    constraints: tuple[DescribedConstraint, ...] = ()
    read_by: str | None = None
