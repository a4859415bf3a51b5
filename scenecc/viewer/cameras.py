"""Views of a page: the poses of a browser's camera for the file's cameras."""

from __future__ import annotations

from math import atan, tan
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import compose, normalized, rotate, to_pose, to_vector
from scenecc.plan.framing import FRAMING_FOVY, find_supported, frame_subject
from scenecc.plan.rendering import Intrinsic, Orthographic, Perspective

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.plan import Camera, Light, ScenePlan
    from scenecc.plan.framing import Solids
    from scenecc.plan.snapshot import MeasuredScene

_ASPECT: Final = (4, 3)
"""Approximate aspect of a browser's picture. Wider windows show more."""

_BACK: Final = 1.6
"""A page opens this much further away than a picture, to leave some space around the scene."""

_NEAREST: Final = 0.1
"""Minimum distance [m] of the point ahead about which a browser's camera orbits."""


@frozen
class BrowserView:
    """The pose of a browser's camera.

    Attributes:
        name: name of the camera.
        position, look_at: on the page [m].
        fov: vertical field of view [rad].
        mounted: whether the camera is mounted on a body; a view does not follow it.
    """

    name: str
    position: Vec3
    look_at: Vec3
    fov: float
    mounted: bool = False


def first_view(views: Sequence[BrowserView], solids: Solids, *, grid: bool) -> BrowserView | None:
    """Returns the initial view of a page: the file's first fixed camera, or else `subject_view`.

    In a grid it is None: everything is shown. `solids`: bounding boxes of the scene.
    """
    if grid:
        return None
    return next((view for view in views if not view.mounted), None) or subject_view(solids)


def subject_view(solids: Solids) -> BrowserView:
    """Returns a view of what moves in a scene, and of what it stands on."""
    subject = find_supported(solids)
    pose = frame_subject(subject, *_ASPECT).pose
    forward = np.array(rotate(normalized(pose[3:].tolist()), (1.0, 0.0, 0.0)))
    distance = max(float((subject.center - pose[:3]) @ forward), _NEAREST)
    middle = pose[:3] + distance * forward
    return BrowserView("", to_vector(middle - _BACK * distance * forward), to_vector(middle), FRAMING_FOVY)


def camera_views(
    plan: ScenePlan, scenes: tuple[MeasuredScene, ...], origins: Mapping[int, Vec3], middle: NDArray[np.float64]
) -> Iterator[BrowserView]:
    """Yields the views of the cameras at the start. A browser's camera has no roll: up on the page is always up.

    Args:
        plan: plan of the scenes.
        scenes: scenes on the page.
        origins: origins of the scenes on the page [m].
        middle: centre of everything shown [m]; a view orbits about a point ahead at about this distance.
    """
    for scene in scenes:
        x, y, z = origins[scene.index]
        for camera in plan.cameras:
            if scene.index in camera.scene_idxs:
                row = camera.scene_idxs.index(scene.index)
                px, py, pz, *q = compose(mount_pose(camera, scene), to_pose(camera.pose.row(row)))
                position = (px + x, py + y, pz + z)
                forward = np.array(rotate(normalized((q[0], q[1], q[2], q[3])), (1.0, 0.0, 0.0)))
                distance = max(float((middle - position) @ forward), _NEAREST)
                ax, ay, az = map(float, position + distance * forward)
                name = camera.name if len(scenes) == 1 else f"{camera.name} ({scene.index})"
                yield BrowserView(name, position, (ax, ay, az), _fov(camera, row, distance), camera.mount is not None)


def mount_pose(item: Camera | Light, scene: MeasuredScene) -> Pose7:
    """Returns the pose of the mount of a camera or light in its scene; of one in the world, the world's."""
    if item.mount is not None:
        for entity in scene.entities:
            if entity.entity.name == item.mount.entity:
                for body in entity.bodies:
                    if item.mount.link in {None, body.name}:
                        return body.pose
    return (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def _fov(camera: Camera, row: int, distance: float) -> float:
    """Returns the vertical field of view [rad]; for an orthographic camera, the one that shows as much at a distance
    [m].
    """
    match camera.lens:
        case Perspective(fovy=fovy) if fovy is not None:
            return float(fovy.row(row))
        case Perspective(fovx=fovx) if fovx is not None:
            return 2 * atan(tan(float(fovx.row(row)) / 2) * camera.height / camera.width)
        case Intrinsic(fy=fy):
            return 2 * atan(camera.height / 2 / float(fy.row(row)))
        case Orthographic(top=top):
            return 2 * atan(float(top.row(row)) / distance)
        case _:
            raise TypeError(camera.lens)
