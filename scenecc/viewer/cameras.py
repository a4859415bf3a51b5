"""Views of a page: those of a file's cameras, as a browser's camera takes them."""

from __future__ import annotations

from math import atan, tan
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import compose, normalized, rotate, to_pose, to_vector
from scenecc.plan.framing import FRAMING_FOVY, find_subject, frame_subject
from scenecc.plan.rendering import Intrinsic, Orthographic, Perspective

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.geometry.rotations import Pose7, Vec3
    from scenecc.plan import Camera, ScenePlan
    from scenecc.plan.framing import Solids
    from scenecc.plan.snapshot import MeasuredScene

_ASPECT: Final = (4, 3)
"""Of a browser's picture, about: what is beside it is shown too."""

_BACK: Final = 1.6
"""A page is to work in: it is opened this much further away than a picture, so that there is something around."""

_NEAREST: Final = 0.1
"""A browser's camera turns about a point ahead of it, which is no nearer than this [m]."""


@frozen
class BrowserView:
    """Where a browser's camera stands.

    Attributes:
        name: of the camera.
        position, look_at: on the page [m].
        fov: from top to bottom [rad].
        mounted: whether the camera is mounted on a body: a view does not follow it.
    """

    name: str
    position: Vec3
    look_at: Vec3
    fov: float
    mounted: bool = False


def first_view(views: Sequence[BrowserView], solids: Solids, *, grid: bool) -> BrowserView | None:
    """The view that a page opens at: that of the file's first camera that stands in the world, or of what moves.

    Where scenes stand side by side it is None: all that is shown. `solids`: of the scene.
    """
    if grid:
        return None
    return next((view for view in views if not view.mounted), None) or subject_view(solids)


def subject_view(solids: Solids) -> BrowserView:
    """A view of what moves in a scene, as `scenecc render` frames it."""
    subject = find_subject(solids)
    pose = frame_subject(subject, *_ASPECT).pose
    forward = np.array(rotate(normalized(pose[3:].tolist()), (1.0, 0.0, 0.0)))
    distance = max(float((subject.center - pose[:3]) @ forward), _NEAREST)
    middle = pose[:3] + distance * forward
    return BrowserView("", to_vector(middle - _BACK * distance * forward), to_vector(middle), FRAMING_FOVY)


def camera_views(
    plan: ScenePlan, scenes: tuple[MeasuredScene, ...], origins: Mapping[int, Vec3], middle: NDArray[np.float64]
) -> Iterator[BrowserView]:
    """The cameras of scenes as they stand at the start. A browser knows no roll: what is up on the page is up.

    Args:
        plan: of the scenes.
        scenes: that are on the page.
        origins: of the scenes, on the page [m].
        middle: of all that is shown [m]: a view turns about the point ahead of it that is about as far away.
    """
    for scene in scenes:
        x, y, z = origins[scene.index]
        for camera in plan.cameras:
            if scene.index in camera.scene_idxs:
                row = camera.scene_idxs.index(scene.index)
                px, py, pz, *q = compose(_mount(camera, scene), to_pose(camera.pose.row(row)))
                position = (px + x, py + y, pz + z)
                forward = np.array(rotate(normalized((q[0], q[1], q[2], q[3])), (1.0, 0.0, 0.0)))
                distance = max(float((middle - position) @ forward), _NEAREST)
                ax, ay, az = map(float, position + distance * forward)
                name = camera.name if len(scenes) == 1 else f"{camera.name} ({scene.index})"
                yield BrowserView(name, position, (ax, ay, az), _fov(camera, row, distance), camera.mount is not None)


def _mount(camera: Camera, scene: MeasuredScene) -> Pose7:
    """The pose of what a camera is mounted on; of one that is in the world, the world's."""
    if camera.mount is not None:
        for entity in scene.entities:
            if entity.entity.name == camera.mount.entity:
                for body in entity.bodies:
                    if camera.mount.link in {None, body.name}:
                        return body.pose
    return (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def _fov(camera: Camera, row: int, distance: float) -> float:
    """Its angle from top to bottom [rad]; without perspective, what shows as much at a distance [m]."""
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
