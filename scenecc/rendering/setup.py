"""Which camera, which scenes, which size: what is asked for, held against the plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenecc.diagnostics import Location
from scenecc.diagnostics.messages import index_ranges, suggest
from scenecc.errors import SceneError
from scenecc.pictures.sheet import sheet_size
from scenecc.pipeline import select_scenes
from scenecc.plan.camera import WITHOUT_NORMALS
from scenecc.plan.pictured import resized

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.pictures.encode import What
    from scenecc.plan import Camera, ScenePlan

_SIZE, _TILE = (640, 480), (320, 240)
"""Of the pictures of the camera that frames the scene, alone and on a sheet [px]."""

_MOST_OF_A_PICTURE, _MOST_OF_A_FRAME = 2**26, 2**23
"""Pixels of what is written. Each pixel of a film takes some 300 bytes while the scene is simulated."""


@dataclass(frozen=True, slots=True)
class SetUp:
    """The camera, None if it is to frame the scene, and of which scenes it takes pictures of which size [px]."""

    camera: Camera | None
    scene_idxs: tuple[int, ...]
    width: int
    height: int
    grid: bool


def set_up(
    plan: ScenePlan,
    name: str | None,
    scenes: str | None,
    size: tuple[int, int] | None,
    what: What,
    sink: Sink,
    *,
    grid: bool,
    film: bool,
) -> SetUp:
    """Raises SceneError."""
    camera = None if name is None else _camera(plan, name, what, sink)
    having = tuple(range(plan.num_scenes)) if camera is None else camera.scene_idxs
    scene_idxs = having if grid else having[:1]
    if scenes is not None:
        scene_idxs = select_scenes(scenes, plan.num_scenes, sink, "--scene") or ()
        if absent := sorted({*scene_idxs}.difference(having)):
            hint = f"it is in {index_ranges(having)}"
            sink.report("SC911", f"camera '{name}' is not in scene {absent[0]}", Location("--camera"), hint=hint)
    stop(sink)
    grid = grid or len(scene_idxs) > 1
    width, height = size or ((camera.width, camera.height) if camera else _TILE if grid else _SIZE)
    whole = sheet_size(len(scene_idxs), width, height) if grid else (width, height)
    most = _MOST_OF_A_FRAME if film else _MOST_OF_A_PICTURE
    if whole[0] * whole[1] > most:
        message = f"a {'film' if film else 'picture'} of {whole[0]} × {whole[1]} pixels is more than {most}"
        sink.report(
            "SC912", message, Location("--size"), hint="take fewer scenes, or smaller pictures: `--size 160x120`"
        )
    stop(sink)
    return SetUp(camera and resized(camera, width, height), scene_idxs, width, height, grid)


def _camera(plan: ScenePlan, name: str, what: What, sink: Sink) -> Camera | None:
    """The camera of a name; None where that was reported."""
    camera = {camera.name: camera for camera in plan.cameras}.get(name)
    if camera is None:
        hint = suggest(name, [camera.name for camera in plan.cameras]) or "leave it out, for one that frames the scene"
        sink.report("SC911", f"the scene has no camera '{name}'", Location("--camera"), hint=hint)
    elif what == "normal" and camera.shader in WITHOUT_NORMALS:
        place = camera.origin.child("shader") if camera.origin else Location("--what")
        hint = "take another camera, or leave `--camera` out"
        sink.report("SC913", f"a camera with the shader `{camera.shader}` sees no normals", place, hint=hint)
    return camera


def stop(sink: Sink) -> None:
    """Raises SceneError if anything went wrong so far."""
    if sink.failed:
        raise SceneError(sink.diagnostics())
