"""Robots as described by a URDF or MJCF file.

Numbers are those for the engine: for a URDF exactly those that SAPIEN's loader would pass, for an MJCF those of
MuJoCo's compiled model. The file's scale is applied. Poses are seven numbers: p [m], then q (wxyz).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Location

SapienJointType = Literal["fixed", "revolute", "revolute_unwrapped", "prismatic"]


@frozen
class SolidGeometry:
    """A primitive. `kind`: one of `plan.geometry.SOLIDS`; `sizes` in m."""

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
        parts: whether each connected part is a collision shape, instead of the convex hull; None: an option decides.
        optional_names: whether files that the mesh names may be missing.
        data: content of a mesh that has no file of its own, see `numeric_mesh`.
    """

    uri: str
    path: Path
    scale: Vec3
    parts: bool | None = None
    optional_names: bool = False
    data: bytes | None = None


@frozen
class HeightfieldGeometry:
    """Terrain. `size` and `heights` are as in `plan.geometry.Heightfield`, the same in every scene."""

    size: Vec3
    heights: tuple[tuple[float, ...], ...]


Geometry = SolidGeometry | PlaneGeometry | MeshGeometry | HeightfieldGeometry


@frozen
class DescribedMaterial:
    """A visual material. None: SAPIEN's default.

    Attributes:
        base_color: linear RGBA, as in SAPIEN.
        texture, texture_uri: path and URI of the base colour texture.
    """

    base_color: tuple[float, float, float, float] | None = None
    texture: Path | None = None
    texture_uri: str | None = None
    emission: tuple[float, float, float, float] | None = None
    specular: float | None = None
    roughness: float | None = None
    metallic: float | None = None


@frozen
class DescribedCollision:
    """A collision shape.

    Attributes:
        pose: in the link's frame.
        friction: static friction, dynamic friction and restitution; None: not in the file.
        density: [kg/m³]; None: not in the file.
        bits: the first two of SAPIEN's collision integers; None: not in the file.
        location: the line that names the geometry.
    """

    geometry: Geometry
    pose: Pose7
    location: Location
    friction: tuple[float, float, float] | None = None
    density: float | None = None
    bits: tuple[int, int] | None = None


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

    `inertia` None: inertia and centre of mass come from the link's collision shapes, scaled to the mass.
    """

    mass: float
    com: Pose7
    inertia: Vec3 | None
    location: Location


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

    `target` None: the joint's initial position.
    """

    stiffness: float
    damping: float
    force_limit: float | None = None
    target: float | None = None


@frozen
class DescribedJoint:
    """A joint between a link and its parent.

    Attributes:
        type: SAPIEN joint type. URDF's `continuous` is `revolute` with infinite limits.
        limits: lowest and highest position [m, rad], possibly infinite; None for a fixed joint.
        friction, armature: None: not in the file.
        damping: 0 if not in the file.
        effort, velocity: limits of the actuator, above 0; None: not in the file.
        qpos: initial position [m, rad], within the limits; None: not in the file.
        drive: None: the joint has only its damping.
    """

    name: str
    type: SapienJointType
    pose_in_parent: Pose7
    pose_in_child: Pose7
    location: Location
    limits: tuple[float, float] | None = None
    friction: float | None = None
    damping: float = 0.0
    armature: float | None = None
    effort: float | None = None
    velocity: float | None = None
    mimic: DescribedMimic | None = None
    qpos: float | None = None
    drive: DescribedDrive | None = None


@frozen
class DescribedLink:
    """A link.

    Attributes:
        parent: index of its parent, a link before it; None for the root.
        joint: joint to the parent; None for the root.
        ignore_bits: ignore bits (SAPIEN's third collision integer) of its shapes; links that share a bit do not
            collide.
        disable_gravity: whether gravity is off.
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


@frozen
class DescribedRobot:
    """A tree of links, or a single body.

    Attributes:
        links: in SAPIEN's build order, the root first.
        body_type: of a single body; None: an articulation.
        fixed: whether the root is fixed to the world; None: the scene decides.
        pose: pose of the root in the file's frame.
        ignored: SRDF pair of each bit of `DescribedLink.ignore_bits`.
        ignores_alone: whether these bits are only of this robot, not of all robots of the file.
    """

    links: tuple[DescribedLink, ...]
    body_type: Literal["dynamic", "kinematic", "static"] | None = None
    fixed: bool | None = None
    pose: Pose7 = IDENTITY_POSE
    location: Location | None = None
    ignored: tuple[Location, ...] = ()
    ignores_alone: bool = False


LinkName = tuple[str, str]
"""Names of a robot's or body's root and of one of its links."""


@frozen
class DescribedConstraint:
    """A constraint between frames of two links: the whole pose (weld) or only the origin (connection)."""

    name: str
    type: Literal["weld", "connection"]
    parent: LinkName
    child: LinkName
    pose_in_parent: Pose7
    pose_in_child: Pose7
    location: Location


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
