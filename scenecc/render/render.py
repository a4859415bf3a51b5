"""Pictures and films of a scene, from a source to files: `render_scene`, what it returns, and the recorder of frames.

The arguments are checked against the plan before anything is built.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import index_ranges, suggest
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import Source, build_batch, compile_or_raise, select_scenes
from scenecc.plan.rendering import SHADERS_WITHOUT_NORMALS, resize_camera, restrict_to_camera
from scenecc.plan.schema import PIXEL_BOUNDS
from scenecc.render.images import (
    INSTALL,
    Film,
    What,
    colors,
    encoded,
    missing,
    png,
    png_of_ids,
    sheet,
    sheet_size,
    shown,
)
from scenecc.render.images import film as filmed

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan
    from scenecc.plan.rendering import Camera


@dataclass(frozen=True, slots=True)
class Picture:
    """What a camera sees of a scene.

    Attributes:
        scene_idx: the scene's index.
        pixels: (H, W, C) as `CameraBatch.capture` gives what was asked for: of a colour (H, W, 4) float32, of a depth
            (H, W, 1) float32 [m], of a segmentation (H, W, 1) int32, of normals (H, W, 3) float32.
        names: what the ids of a segmentation stand for in this scene.
    """

    scene_idx: int
    pixels: NDArray[Any]
    names: dict[int, str]


@dataclass(frozen=True, slots=True)
class LegendRow:
    """An id that is seen in a segmentation.

    Attributes:
        scene_idxs: the scenes in which it has this name and is seen, ascending.
        id: of the entity.
        color: of its pixels, as #rrggbb.
        name: of the entity, ENTITY/LINK of a link.
    """

    scene_idxs: tuple[int, ...]
    id: int
    color: str
    name: str


@dataclass(frozen=True, slots=True)
class Rendering:
    """Pictures of a scene, and how they were taken.

    Attributes:
        plan: the scene's plan.
        camera: the camera's name; None: one that frames the scene.
        what: what the pictures show.
        grid: whether they are written as one sheet.
        pictures: one a scene, by ascending index, as it is after the simulation.
        film: the bytes of the film's file; None: none was taken.
        frames, rate: how many pictures the film shows, and how many a second [1/s]; 0 without one. Equal pictures in a
            row are one frame of a GIF's file, which lasts as long as all of them.
        diagnostics: warnings and notes.
        timings: stage → seconds, in order.
    """

    plan: ScenePlan
    camera: str | None
    what: What
    grid: bool
    pictures: tuple[Picture, ...]
    film: bytes | None = None
    frames: int = 0
    rate: float = 0.0
    diagnostics: list[Diagnostic] = field(default_factory=list[Diagnostic])
    timings: dict[str, float] = field(default_factory=dict[str, float])

    def png(self) -> bytes:
        """The pictures as one PNG: the picture itself, or a sheet with a label above each.

        Colours and normals have three bytes a pixel, a depth 16 bits [mm], a segmentation the ids as a palette's
        indices, and colours on a sheet or where an id is beyond 255.
        """
        if self.grid:
            return png(labelled([encoded(self.what, picture.pixels) for picture in self.pictures], self.pictures))
        (picture,) = self.pictures
        if self.what == "segmentation":
            return png_of_ids(picture.pixels[..., 0])
        return png(encoded(self.what, picture.pixels))

    def legend(self) -> list[LegendRow]:
        """The ids that are seen in a segmentation, ascending; empty for other pictures."""
        scenes: dict[tuple[int, str], list[int]] = {}
        for picture in self.pictures if self.what == "segmentation" else ():
            for number in np.unique(picture.pixels).tolist():
                if number:
                    scenes.setdefault((number, picture.names.get(number, "")), []).append(picture.scene_idx)
        return [
            LegendRow(tuple(idxs), number, f"#{colors(np.array(number)).tobytes().hex()}", name)
            for (number, name), idxs in sorted(scenes.items())
        ]


def labelled(tiles: Sequence[NDArray[Any]], pictures: Sequence[Picture]) -> NDArray[Any]:
    """A sheet of pictures, (H, W) or (H, W, 3) each, with the scene of each above it."""
    return sheet(tiles, [f"scene {picture.scene_idx}" for picture in pictures])


_FRAMES_A_SECOND = 30
"""About as many has a film of which nothing is said."""

_STRIDE = 10
"""Steps between two reports of the progress."""


class FrameRecorder:
    """Simulates scenes and takes their pictures. `human`: show what is hidden too."""

    def __init__(
        self,
        batch: SceneBatch,
        setup: RenderSetup,
        what: What,
        progress: Callable[[int, int], None] | None,
        *,
        human: bool,
    ) -> None:
        self._batch = batch
        named = setup.camera
        self._camera = batch.framed(setup.width, setup.height) if named is None else batch.cameras[named.name]
        self._what: What = what
        self._grid = setup.grid
        self._human = human
        self._progress = progress or _untold

    def take(
        self, steps: int, film: Film | None, every: int | None
    ) -> tuple[tuple[Picture, ...], tuple[bytes | None, int, float]]:
        """A picture of each scene after the steps, and the film: its bytes, its number of frames and its rate [1/s].

        Raises:
            SceneError: the simulation diverges.
            RuntimeError: the renderer fails.
            OSError: the film's encoder does.
        """
        if film is None:
            self._step(steps)
            return self._stills(), (None, 0, 0.0)
        stride = every or min(steps, max(1, round(1 / (_FRAMES_A_SECOND * self._batch.timestep))))
        count, rate = 1 + steps // stride, 1 / (stride * self._batch.timestep)
        data = filmed(film, self._frames(count, stride), rate, count)
        self._batch.step(steps % stride, check=True)
        return self._stills(), (data, count, rate)

    def _step(self, steps: int) -> None:
        for done in range(0, steps, _STRIDE):
            self._progress(done, steps)
            self._batch.step(min(_STRIDE, steps - done), check=True)

    def _frames(self, count: int, stride: int) -> Iterator[NDArray[np.uint8]]:
        for number in range(count):
            self._progress(number, count)
            self._batch.step(stride if number else 0, check=True)
            pictures = [self._picture(index) for index in self._batch.scene_idxs]
            tiles = [shown(self._what, picture.pixels) for picture in pictures]
            yield labelled(tiles, pictures) if self._grid else tiles[0]

    def _stills(self) -> tuple[Picture, ...]:
        """The last pictures that are taken: the memory of one camera is enough for all of them."""
        pictures: list[Picture] = []
        for index in self._batch.scene_idxs:
            self._progress(len(pictures), len(self._batch))
            pictures.append(self._picture(index))
            self._camera.retire(index)
        return tuple(pictures)

    def _picture(self, index: int) -> Picture:
        name = self._what
        pixels = self._camera.capture(name, [index], human=self._human)[name][0]
        return Picture(index, pixels, self._camera.names(index) if name == "segmentation" else {})


def _untold(done: int, of: int) -> None:
    """Ignores progress."""


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


class RenderArguments(RenderChoices, CompileOptions, total=False):
    """The arguments of `render_scene`."""


def render_scene(source: Source, **given: Unpack[RenderArguments]) -> Rendering:
    """Builds scenes, simulates them and takes a picture of each; `scenecc render` writes these.

    Args:
        source: as for `validate`.
        given: those of `RenderChoices` and of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault; there is no such camera or scene, or it does not
            take this picture.
        TypeError: a flag is neither True nor False, or a number is no integer.
        ValueError: an argument is out of its range.
    """
    asked = Options.of_call(render_scene, given, RenderArguments)
    camera, size, what = given.get("camera"), given.get("size"), given.get("what", "color")
    steps, film, every = given.get("steps", 0), given.get("film"), given.get("every")
    hidden, progress = given.get("hidden"), given.get("progress")
    _check(size, steps, film, every)
    grid, collision = bool(given.get("grid", False)), bool(given.get("collision", False))
    hidden = camera is None if hidden is None else bool(hidden)
    sink = Sink()
    _need_packages(sink, mp4=film == "mp4")
    found = compile_or_raise(source, asked, sink)
    setup = choose_pictures(found.plan, camera, given.get("scenes"), size, what, sink, grid=grid, film=film is not None)
    plan, timings = restrict_to_camera(found.plan, setup.camera, collision=collision), dict(found.timings)
    started = time.perf_counter()
    with build_batch(
        plan, sink, backend="cpu", scene_idxs=setup.scene_idxs, render=True, audit="fast", progress=progress
    ) as batch:
        timings["build"], started = time.perf_counter() - started, time.perf_counter()
        if collision:
            batch.show_collision()
        recorder = FrameRecorder(batch, setup, what, progress, human=hidden)
        try:
            pictures, made = recorder.take(steps, film, every)
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


def _check(size: tuple[int, int] | None, steps: int, film: str | None, every: int | None) -> None:
    """Raises ValueError."""
    for pixels in size or ():
        if not PIXEL_BOUNDS.allow(integer(pixels, "a size", 1)):
            raise ValueError(f"a picture has {PIXEL_BOUNDS.low} to {PIXEL_BOUNDS.high} pixels a side, not {pixels}")
    if integer(steps, "steps", 0) == 0 and film is not None:
        raise ValueError("a film needs steps")
    if every is not None and (film is None or integer(every, "every", 1) > steps):
        raise ValueError("every is for a film, and at most its steps")
