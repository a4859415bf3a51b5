"""Worlds as described by a file of another format: robots and bodies with constraints, lights, cameras and settings.

Every reader of worlds fills these classes; `scenecc.importers.writer` makes a scene document of them. Poses are seven
numbers: p [m], then q (wxyz). A value that the file omits is None.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.description import DescribedConstraint, DescribedRobot, DescribedTexture, LinkName


@frozen
class RobotFile:
    """A robot that stays in its file.

    Attributes:
        format: key of the entity.
        path: absolute.
        pose: of its root, in the world.
        keys: further keys of the entity, such as `repair`.
        robots: content of the file, for the names of its links; empty: nothing refers to them.
        parts: files that are attached to its links; a part may be attached to an earlier one.
    """

    format: Literal["urdf", "mjcf"]
    path: Path
    pose: Pose7 = IDENTITY_POSE
    keys: tuple[tuple[str, Any], ...] = ()
    robots: tuple[DescribedRobot, ...] = ()
    parts: tuple[FilePart, ...] = ()


@frozen
class FilePart:
    """A robot's file that is attached to a robot.

    Attributes:
        name: first part of the `LinkName`s of its links.
        to: the link that carries it.
        pose: of its root, in `to`.
        file: its own pose and parts are not used.
    """

    name: str
    to: LinkName
    pose: Pose7
    file: RobotFile
    location: Location


@frozen
class DescribedEntity:
    """A robot or body of a world.

    Attributes:
        name: unique in the world; the first part of a `LinkName`.
        content: its pose is in the world.
        wish: name in the scene, as far as it is valid and free; "": `name`.
    """

    name: str
    content: DescribedRobot | RobotFile
    location: Location
    wish: str = ""


@frozen
class DescribedPhysics:
    """Settings of the simulation.

    Attributes:
        timestep: [s].
        gravity: [m/s²].
        friction: default static friction, dynamic friction and restitution.
    """

    timestep: float | None = None
    gravity: Vec3 | None = None
    friction: tuple[float, float, float] | None = None


@frozen
class DescribedLight:
    """A light.

    Attributes:
        color: linear RGB times brightness.
        position, direction: in the world, or in the frame of `mount`.
        cone: inner and outer angle of a spot [rad].
    """

    name: str
    type: Literal["point", "directional", "spot"]
    color: Vec3
    position: Vec3
    direction: Vec3
    location: Location
    cone: tuple[float, float] | None = None
    shadow: bool = False
    mount: LinkName | None = None


@frozen
class DescribedCamera:
    """A camera, which looks along x of its pose; z is up.

    Attributes:
        pose: in the world, or in the frame of `mount`.
        lens: kind, and the field of view [rad] or half the height of an orthographic view [m].
        size: width and height [px].
        clip: near and far plane [m].
    """

    name: str
    pose: Pose7
    lens: tuple[Literal["fovx", "fovy", "orthographic"], float]
    location: Location
    size: tuple[int, int] | None = None
    clip: tuple[float, float] | None = None
    mount: LinkName | None = None


@frozen
class DescribedWorld:
    """A world.

    Attributes:
        name: of the scene.
        entities: in build order.
        constraints: between links of its entities, or with `IN_WORLD`.
        ignored: pairs of links that never collide, besides those that share a bit of `DescribedLink.ignore_bits` (of
            the whole world) and those of robots without `self_collisions`.
        ambient: ambient light, linear RGB.
        environment: environment map.
    """

    name: str
    entities: tuple[DescribedEntity, ...]
    physics: DescribedPhysics = DescribedPhysics()
    constraints: tuple[DescribedConstraint, ...] = ()
    lights: tuple[DescribedLight, ...] = ()
    cameras: tuple[DescribedCamera, ...] = ()
    ignored: frozenset[frozenset[LinkName]] = frozenset()
    ambient: Vec3 | None = None
    environment: DescribedTexture | None = None
