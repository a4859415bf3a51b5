"""What a file says of its robots, whatever its format.

Numbers are those that the engine is to be given: the ones that SAPIEN's own loader would give it for a URDF,
ManiSkill's for an MJCF, to the bit, with the file's scale in them. Poses are seven numbers, p [m] then q (wxyz).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY_POSE

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Location
    from scenecc.geometry.rotations import Pose7, Vec3

SapienJointType = Literal["fixed", "revolute", "revolute_unwrapped", "prismatic"]


@frozen
class SolidGeometry:
    """A primitive. `kind`: one of `plan.geometry.SOLIDS`; `sizes`: its sizes [m]."""

    kind: str
    sizes: tuple[float, ...]


@frozen
class PlaneGeometry:
    """A plane whose normal is x; `half_size` [m] of what is seen, along its own y and z."""

    half_size: tuple[float, float] | None = None


@frozen
class MeshGeometry:
    """A mesh.

    Attributes:
        uri: as a scene would name it: `pkg://…` or `asset://…` where the robot's file is named so, else the path
            relative to the top scene's folder, else an absolute path.
        path: where it is, among the places where it may be.
        scale: of its vertices; none is 0, one below it mirrors them.
        parts: whether its connected parts collide one by one, rather than its convex hull; None: as the loader is told.
    """

    uri: str
    path: Path
    scale: Vec3
    parts: bool | None = None


Geometry = SolidGeometry | PlaneGeometry | MeshGeometry


@frozen
class DescribedMaterial:
    """What a visual shape looks like. None: what SAPIEN's material has by itself.

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
    """A shape that collides.

    Attributes:
        pose: in the link's frame.
        friction: static, dynamic and restitution; None: the file does not say.
        density: [kg/m³]; None: likewise.
        location: the line that names the geometry.
    """

    geometry: Geometry
    pose: Pose7
    location: Location
    friction: tuple[float, float, float] | None = None
    density: float | None = None


@frozen
class DescribedVisual:
    """A shape that is seen. `look`: None: a mesh shows its own materials, all else a plain one."""

    geometry: Geometry
    pose: Pose7
    location: Location
    name: str = ""
    look: DescribedMaterial | None = None


@frozen
class DescribedInertial:
    """Mass [kg], centre of mass with the principal axes, principal moments [kg·m²]."""

    mass: float
    com: Pose7
    inertia: Vec3
    location: Location


@frozen
class DescribedMimic:
    """Position is multiplier · source's + offset."""

    source: str
    multiplier: float
    offset: float
    location: Location


@frozen
class DescribedJoint:
    """A joint between a link and its parent.

    Attributes:
        type: SAPIEN's. `continuous` is a `revolute` of infinite limits.
        limits: lowest and highest position; infinite where there is none; None of a fixed one.
        friction, armature: None: the file does not say.
        damping: 0 where it does not say.
        effort, velocity: limits of the actuator, above 0; None: it does not say.
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


@frozen
class DescribedLink:
    """A link.

    Attributes:
        parent: number of a link before it; None: a root.
        joint: None of a root.
        ignore_bits: bits of the third collision integer that its shapes have, so that links with a bit in common
            ignore one another.
    """

    name: str
    location: Location
    parent: int | None = None
    joint: DescribedJoint | None = None
    collisions: tuple[DescribedCollision, ...] = ()
    visuals: tuple[DescribedVisual, ...] = ()
    inertial: DescribedInertial | None = None
    ignore_bits: int = 0


@frozen
class DescribedRobot:
    """A tree of links, or one body.

    Attributes:
        links: in the order in which SAPIEN's loader builds them, the root first.
        body_type: what it is where it is one body and no articulation; None: it is an articulation.
        fixed: what the file says of the root: fixed to the world or not; None: nothing, so that the user says it.
        pose: of the root in the frame of the whole.
        ignored: for each bit of `DescribedLink.ignore_bits` that an SRDF's pair has, that pair.
    """

    links: tuple[DescribedLink, ...]
    body_type: Literal["dynamic", "kinematic", "static"] | None = None
    fixed: bool | None = None
    pose: Pose7 = IDENTITY_POSE
    location: Location | None = None
    ignored: tuple[Location, ...] = ()


@frozen
class DescribedFile:
    """A file that a description led to, its uri as a scene would name it, and the place that names it."""

    uri: str
    path: Path
    location: Location


@frozen
class RobotDescription:
    """Everything that a file describes.

    Attributes:
        robots: in build order; not empty.
        files: every file that it led to (meshes, textures, included files, an SRDF), each once.
    """

    robots: tuple[DescribedRobot, ...]
    files: tuple[DescribedFile, ...] = ()
