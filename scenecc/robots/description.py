"""Robots as described by a URDF or MJCF file.

Numbers are those for the engine: for a URDF those that SAPIEN's own loader would pass, to the bit, for an MJCF those
of the model that MuJoCo compiles. The file's scale is applied. Poses are seven numbers, p [m] then q (wxyz).
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
    """A primitive. `kind`: one of `plan.geometry.SOLIDS`; `sizes`: its sizes [m]."""

    kind: str
    sizes: tuple[float, ...]


@frozen
class PlaneGeometry:
    """A plane with normal x. `half_size`: of its visual shape, along its y and z [m]."""

    half_size: tuple[float, float] | None = None


@frozen
class MeshGeometry:
    """A mesh.

    Attributes:
        uri: as a scene would name it: `pkg://…` or `asset://…` where the robot's file is named so, else the path
            relative to the top scene's folder, else an absolute path.
        path: where it is, among the places where it may be.
        scale: of its vertices, nonzero; a negative one mirrors them.
        parts: whether each connected part is a collision shape, rather than the convex hull; None: an option.
        optional_names: whether files that it names may be missing, and are then left out.
        data: what it holds, where no file of the robot does: `robots.numeric_meshes` makes such a mesh.
    """

    uri: str
    path: Path
    scale: Vec3
    parts: bool | None = None
    optional_names: bool = False
    data: bytes | None = None


@frozen
class HeightfieldGeometry:
    """Terrain. `size` and `heights`: as those of `plan.geometry.Heightfield`, the same in every scene."""

    size: Vec3
    heights: tuple[tuple[float, ...], ...]


Geometry = SolidGeometry | PlaneGeometry | MeshGeometry | HeightfieldGeometry


@frozen
class DescribedMaterial:
    """A visual material. None: SAPIEN's default.

    Attributes:
        base_color: four numbers, linear as SAPIEN takes them.
        texture, texture_uri: file of the base colour, and the uri by which a scene would name it.
        emission, specular, roughness, metallic: likewise.
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
    """A visual shape. `look`: None: a mesh has its own materials, other shapes a default one."""

    geometry: Geometry
    pose: Pose7
    location: Location
    name: str = ""
    look: DescribedMaterial | None = None


@frozen
class DescribedInertial:
    """Mass [kg], centre of mass with the principal axes, principal moments [kg·m²].

    `inertia` None: it and the centre of mass are those of the link's colliding shapes, scaled to the mass.
    """

    mass: float
    com: Pose7
    inertia: Vec3 | None
    location: Location


def ball_moment(mass: float) -> float:
    """Moment of inertia of a ball of water, 2/5 · m · r² [kg·m²], for a mass [kg] without shapes."""
    radius = (3 * mass / (4 * math.pi * _WATER_DENSITY)) ** (1 / 3)
    return 0.4 * mass * radius**2


_WATER_DENSITY = 1000.0
"""[kg/m³]."""


@frozen
class DescribedMimic:
    """Position is multiplier · source's + offset."""

    source: str
    multiplier: float
    offset: float
    location: Location


@frozen
class DescribedDrive:
    """A drive: stiffness and damping per metre or radian, force limit [N, N·m] (None: none), target [m, rad].

    `target` None: the initial position of the joint.
    """

    stiffness: float
    damping: float
    force_limit: float | None = None
    target: float | None = None


@frozen
class DescribedJoint:
    """A joint between a link and its parent.

    Attributes:
        type: in SAPIEN's words. A `continuous` joint is a `revolute` one with infinite limits.
        limits: lowest and highest position [m, rad], possibly infinite; None for a fixed joint.
        friction, armature: None: not in the file.
        damping: 0 if it is not in the file.
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
        parent: number of its parent, a link before it; None: it is the root.
        joint: to the parent; None for the root.
        ignore_bits: bits of the third collision integer that its shapes have, so that links with a bit in common
            ignore one another.
        disable_gravity: whether gravity does not pull it.
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
    """A tree of links, or one body.

    Attributes:
        links: in the order in which SAPIEN's loader builds them, the root first.
        body_type: of a single body; None: it is an articulation.
        fixed: whether the root is fixed to the world; None: not in the file, so the scene decides.
        pose: of the root in the frame of the whole.
        ignored: the SRDF pair of each bit of `DescribedLink.ignore_bits`.
    """

    links: tuple[DescribedLink, ...]
    body_type: Literal["dynamic", "kinematic", "static"] | None = None
    fixed: bool | None = None
    pose: Pose7 = IDENTITY_POSE
    location: Location | None = None
    ignored: tuple[Location, ...] = ()


LinkName = tuple[str, str]
"""The name of the root of a robot or body, and that of one of its links."""


@frozen
class DescribedConstraint:
    """What keeps a frame of one link at a frame of another: the whole pose, or the origin alone."""

    name: str
    type: Literal["weld", "connection"]
    parent: LinkName
    child: LinkName
    pose_in_parent: Pose7
    pose_in_child: Pose7
    location: Location


@frozen
class DescribedFile:
    """A file that a description refers to, its uri as in a scene, and where it is named."""

    uri: str
    path: Path
    location: Location


@frozen
class RobotDescription:
    """Everything that a file describes.

    Attributes:
        robots: in build order; not empty.
        files: every file that it refers to (meshes, textures, included files, an SRDF), each once.
        constraints: between its links.
        read_by: the program that read the file, and its version; None: scenecc itself.
    """

    robots: tuple[DescribedRobot, ...]
    files: tuple[DescribedFile, ...] = ()
    constraints: tuple[DescribedConstraint, ...] = ()
    read_by: str | None = None
