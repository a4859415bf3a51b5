"""Cameras as written to those of the plan."""

from __future__ import annotations

from math import radians
from typing import TYPE_CHECKING, Any

from scenecc.lower.angles import lower_angle
from scenecc.lower.field_types import number
from scenecc.lower.mounts import mounted_pose, read_pose
from scenecc.plan import Camera, Intrinsic, Orthographic, Perspective, Value, literal

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.mounts import MountLookup
    from scenecc.plan.body import Mount
    from scenecc.spec.camera import CameraSpec as CameraKeys

WIDTH, HEIGHT = 640, 480
FOVY = radians(60)
NEAR, FAR = 0.01, 100.0
"""What is left out (LANGUAGE, cameras)."""

_LENSES = ("fovy", "fovy_deg", "fovx", "fovx_deg", "intrinsic", "orthographic")
_INTRINSIC = {name: number(name) for name in ("fx", "fy", "cx", "cy", "skew")}
_TOP = number("top")
_NEAR, _FAR = number("Camera.near"), number("Camera.far")


class CameraLowerer:
    """Lowers the cameras of a document.

    Args:
        mounts: what they may be mounted on.
        places: where entities and frames stand.
        sink: takes the diagnostics.
    """

    def __init__(self, mounts: MountLookup, places: FrameGraph, sink: Sink) -> None:
        self._mounts = mounts
        self._places = places
        self._sink = sink

    def lower(self, name: str, camera: CameraKeys, leaves: FieldLowerer, origin: Origin) -> Camera:
        """A camera of the plan.

        Args:
            name: of it.
            camera: as written.
            leaves: over its scenes.
            origin: of it.
        """
        width = WIDTH if camera.width is None else camera.width
        height = HEIGHT if camera.height is None else camera.height
        mount: Mount | None = None
        if camera.mount is not None:
            mount = self._mounts.find(camera.mount, leaves.scope, leaves.scenes, origin.child("mount"))
        return Camera(
            name=name,
            scene_idxs=leaves.scenes,
            pose=self._pose(name, camera, leaves, origin),
            width=width,
            height=height,
            lens=self._lens(camera, (width, height), leaves, origin),
            near=literal(NEAR) if camera.near is None else leaves.value(camera.near, _NEAR, origin, "near"),
            far=literal(FAR) if camera.far is None else leaves.value(camera.far, _FAR, origin, "far"),
            mount=mount,
            shader=camera.shader,
            origin=origin,
        )

    def _pose(self, name: str, camera: CameraKeys, leaves: FieldLowerer, origin: Origin) -> Value:
        stand = read_pose(camera.pose, origin, leaves)
        if camera.mount is not None:
            return mounted_pose(stand, "a camera", origin, leaves)
        return self._places.follow(name, stand.relative_to, stand.item, stand.reading, leaves, origin)

    def _lens(
        self, camera: Any, size: tuple[int, int], leaves: FieldLowerer, origin: Origin
    ) -> Perspective | Intrinsic | Orthographic:
        given = [key for key in _LENSES if getattr(camera, key) is not None]
        # One angle that is given twice is told by what reads it.
        lenses = [key for key in given if key not in {f"{other}_deg" for other in given}]
        if len(lenses) > 1:
            self._sink.report(
                "SC111",
                f"a camera has one lens, and this has {len(lenses)}: {', '.join(f'`{key}`' for key in lenses)}",
                origin.child(lenses[1]),
                at="key",
                related=[("the first", origin.child(lenses[0]), "key")],
            )
        if camera.orthographic is not None:
            return Orthographic(leaves.value(camera.orthographic.top, _TOP, origin, "orthographic", "top"))
        if camera.intrinsic is not None:
            return _intrinsic(camera.intrinsic, size, leaves, origin)
        fovx = lower_angle(camera, "fovx", origin, leaves) if any(key.startswith("fovx") for key in given) else None
        if fovx is not None:
            return Perspective(fovx=fovx)
        fovy = lower_angle(camera, "fovy", origin, leaves) if given else None
        return Perspective(fovy=literal(FOVY) if fovy is None else fovy)


def _intrinsic(given: Any, size: tuple[int, int], leaves: FieldLowerer, origin: Origin) -> Intrinsic:
    left_out = {"cx": size[0] / 2, "cy": size[1] / 2, "skew": 0.0}
    values: dict[str, Value] = {}
    for name, kind in _INTRINSIC.items():
        item = getattr(given, name)
        values[name] = literal(left_out[name]) if item is None else leaves.value(item, kind, origin, "intrinsic", name)
    return Intrinsic(**values)
