"""`render_scene`: from a source to pictures, top to bottom.

What is asked for is compared with the plan before anything is built.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Location, Sink
from scenecc.diagnostics.messages import index_ranges, suggest
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import Source, compiled, instantiated, select_scenes
from scenecc.plan.camera import SHADERS_WITHOUT_NORMALS
from scenecc.plan.rendering import resize_camera, restrict_to_camera
from scenecc.plan.schema import PIXEL_BOUNDS
from scenecc.render.images import INSTALL, WHATS, What, missing, sheet_size
from scenecc.render.pictures import FrameRecorder, Rendering

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.plan import Camera, ScenePlan
    from scenecc.render.images import Film


_SIZE, _TILE = (640, 480), (320, 240)
"""Of the pictures of the camera that frames the scene, alone and on a sheet [px]."""

_MOST_OF_A_PICTURE, _MOST_OF_A_FRAME = 2**26, 2**23
"""Pixels of what is written. Each pixel of a film takes some 300 bytes while the scene is simulated."""


@dataclass(frozen=True, slots=True)
class RenderSetup:
    """The camera, None if it is to frame the scene, and of which scenes it takes pictures of which size [px]."""

    camera: Camera | None
    scene_idxs: tuple[int, ...]
    width: int
    height: int
    grid: bool


def choose_pictures(
    plan: ScenePlan,
    name: str | None,
    scenes: str | None,
    size: tuple[int, int] | None,
    what: What,
    sink: Sink,
    *,
    grid: bool,
    film: bool,
) -> RenderSetup:
    """Raises SceneError."""
    camera = None if name is None else _camera(plan, name, what, sink)
    having = tuple(range(plan.num_scenes)) if camera is None else camera.scene_idxs
    scene_idxs = having if grid else having[:1]
    if scenes is not None:
        scene_idxs = select_scenes(scenes, plan.num_scenes, sink, "--scene") or ()
        if absent := sorted({*scene_idxs}.difference(having)):
            hint = f"it is in {index_ranges(having)}"
            sink.report("SC911", f"camera '{name}' is not in scene {absent[0]}", Location("--camera"), hint=hint)
    raise_errors(sink)
    grid = grid or len(scene_idxs) > 1
    width, height = size or ((camera.width, camera.height) if camera else _TILE if grid else _SIZE)
    whole = sheet_size(len(scene_idxs), width, height) if grid else (width, height)
    most = _MOST_OF_A_FRAME if film else _MOST_OF_A_PICTURE
    if whole[0] * whole[1] > most:
        message = f"a {'film' if film else 'picture'} of {whole[0]} × {whole[1]} pixels is more than {most}"
        sink.report(
            "SC912", message, Location("--size"), hint="take fewer scenes, or smaller pictures: `--size 160x120`"
        )
    raise_errors(sink)
    return RenderSetup(camera and resize_camera(camera, width, height), scene_idxs, width, height, grid)


def _camera(plan: ScenePlan, name: str, what: What, sink: Sink) -> Camera | None:
    """The camera of a name; None where that was reported."""
    camera = {camera.name: camera for camera in plan.cameras}.get(name)
    if camera is None:
        hint = suggest(name, [camera.name for camera in plan.cameras]) or "leave it out, for one that frames the scene"
        sink.report("SC911", f"the scene has no camera '{name}'", Location("--camera"), hint=hint)
    elif what == "normal" and camera.shader in SHADERS_WITHOUT_NORMALS:
        place = camera.origin.child("shader") if camera.origin else Location("--what")
        hint = "take another camera, or leave `--camera` out"
        sink.report("SC913", f"a camera with the shader `{camera.shader}` sees no normals", place, hint=hint)
    return camera


def raise_errors(sink: Sink) -> None:
    """Raises SceneError if anything went wrong so far."""
    if sink.failed:
        raise SceneError(sink.diagnostics())


class RenderChoices(TypedDict, total=False):
    """Which pictures are taken of a scene.

    Attributes:
        camera: a camera of the file; None: one that frames each scene as it stands at its first picture.
        scenes: of which scenes, as `scene_idxs` of a file: `3`, `0:4`, `0,2`; None: the first that has the camera, or
            all that have it for a `grid`.
        grid: put the pictures on one sheet; so it is whenever there are several scenes.
        size: width and height of each picture [px], in place of the camera's (640 × 480, on a sheet 320 × 240, of one
            that frames the scene).
        what: "color", "depth", "segmentation" or "normal".
        steps: of the simulation, before the picture.
        film: take one over these steps, "mp4" or "gif".
        every: steps from one frame of the film to the next; None: as many as give about 30 a second. It plays as fast
            as the simulation's time goes.
        collision: show what collides, and not what is seen.
        hidden: show what is `hidden` too; None: where the camera is none of the file.
        progress: called with (scenes, steps, frames or pictures done, of how many) as one follows the other.
    """

    camera: str | None
    scenes: str | None
    grid: bool
    size: tuple[int, int] | None
    what: What
    steps: int
    film: Film | None
    every: int | None
    collision: bool
    hidden: bool | None
    progress: Callable[[int, int], None] | None


def render_scene(
    source: Source,
    *,
    camera: str | None = None,
    scenes: str | None = None,
    grid: bool = False,
    size: tuple[int, int] | None = None,
    what: What = "color",
    steps: int = 0,
    film: Film | None = None,
    every: int | None = None,
    collision: bool = False,
    hidden: bool | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> Rendering:
    """Builds scenes, simulates them and takes a picture of each; `scenecc render` writes these.

    Args:
        source: as for `validate`.
        camera: as of `RenderChoices`, like the arguments below.
        scenes: likewise.
        grid: likewise.
        size: likewise.
        what: likewise.
        steps: likewise.
        film: likewise.
        every: likewise.
        collision: likewise.
        hidden: likewise.
        progress: likewise.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault; there is no such camera or scene, or it does not
            take this picture.
        ValueError: an argument is out of its range.
    """
    _check(what, size, steps, film, every)
    sink = Sink()
    asked = Options.of(**options)
    _need_packages(sink, mp4=film == "mp4")
    found = compiled(source, asked, sink)
    setup = choose_pictures(found.plan, camera, scenes, size, what, sink, grid=grid, film=film is not None)
    plan, timings = restrict_to_camera(found.plan, setup.camera, collision=collision), dict(found.timings)
    started = time.perf_counter()
    with instantiated(
        plan, sink, backend="cpu", scene_idxs=setup.scene_idxs, render=True, audit="fast", progress=progress
    ) as batch:
        timings["build"], started = time.perf_counter() - started, time.perf_counter()
        if collision:
            batch.show_collision()
        studio = FrameRecorder(batch, setup, what, progress, human=camera is None if hidden is None else hidden)
        try:
            pictures, made = studio.take(steps, film, every)
        except SceneError as error:
            raise SceneError([*sink.diagnostics(), *error.diagnostics]) from error
        except (RuntimeError, OSError) as error:
            sink.report("SC814", f"the picture cannot be made: {error}", plan.origin or Location(None))
            raise SceneError(sink.diagnostics()) from error
        timings["pictures"] = time.perf_counter() - started
    return Rendering(found.plan, camera, what, setup.grid, pictures, *made, sink.diagnostics(), timings)


def _need_packages(sink: Sink, *, mp4: bool) -> None:
    if lacking := missing(mp4=mp4):
        sink.report(
            "SC812", f"pictures need {' and '.join(lacking)}, not installed here", Location("scenecc"), hint=INSTALL
        )
    raise_errors(sink)


def _check(what: str, size: tuple[int, int] | None, steps: int, film: str | None, every: int | None) -> None:
    """Raises ValueError."""
    if what not in WHATS:
        raise ValueError(f"what is one of {', '.join(WHATS)}, not {what!r}")
    if film not in {None, "mp4", "gif"}:
        raise ValueError(f"film is mp4 or gif, not {film!r}")
    for pixels in size or ():
        if not PIXEL_BOUNDS.allow(integer(pixels, "a size", 1)):
            raise ValueError(f"a picture has {PIXEL_BOUNDS.low} to {PIXEL_BOUNDS.high} pixels a side, not {pixels}")
    if integer(steps, "steps", 0) == 0 and film is not None:
        raise ValueError("a film needs steps")
    if every is not None and (film is None or integer(every, "every", 1) > steps):
        raise ValueError("every is for a film, and at most its steps")
