"""Pictures and videos of a scene, from a source to files: `render_scene` and its result.

The arguments are checked against the plan before anything is built.
"""

from __future__ import annotations

import time
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.errors import SceneError
from scenecc.extras import install_hint
from scenecc.options import Options
from scenecc.pipeline import Source, build_batch, compile_or_raise
from scenecc.plan.rendering import RAY_TRACING_SHADERS
from scenecc.render.choices import RenderArguments, RenderChoices, check_choices, choose_pictures, raise_errors
from scenecc.render.images import NO_ENCODER, What, colors, encode_pixels, has_encoder, png, png_of_ids, video_pixels
from scenecc.render.legends import add_depth_bar, add_names, depth_colors, depth_range
from scenecc.render.plan_cameras import restrict_to_camera
from scenecc.render.recorder import FrameRecorder, Picture, label_sheet

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan
    from scenecc.render.choices import RenderSetup


@dataclass(frozen=True, slots=True)
class LegendRow:
    """A visible id of a segmentation.

    Attributes:
        scene_idxs: the scenes in which it is visible with this name, ascending.
        id: of the entity.
        color: of its pixels, as #rrggbb.
        name: of the entity; ENTITY/LINK for a link.
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
        camera: the camera's name. None: one that frames the scene.
        what: what the pictures show.
        grid: whether they are written as one sheet.
        pictures: one for each scene, by ascending index, after the simulation.
        video: the bytes of the video's file. None: no video.
        frames, rate: number of frames of the video, and frames per second [1/s]; 0 without one. In a GIF, equal
            successive frames are one longer frame.
        explained: whether depths or ids are written as colours with a legend.
        cell: the side of a cell of the ground grid [m]. None: no grid.
        diagnostics: warnings and notes.
        timings: stage → seconds, in order.
    """

    plan: ScenePlan
    camera: str | None
    what: What
    grid: bool
    pictures: tuple[Picture, ...]
    video: bytes | None = None
    frames: int = 0
    rate: float = 0.0
    explained: bool = False
    cell: float | None = None
    diagnostics: list[Diagnostic] = field(default_factory=list[Diagnostic])
    timings: dict[str, float] = field(default_factory=dict[str, float])

    def png(self) -> bytes:
        """Returns the pictures as one PNG: the picture itself, or a sheet with a label above each.

        Colours and normals have three bytes per pixel, a depth 16 bits [mm]. A segmentation has ids as palette indices,
        but colours on a sheet or if an id exceeds 255. With a legend, all are colours.
        """
        if self.explained:
            return png(self._add_legend())
        if self.grid:
            return png(
                label_sheet([encode_pixels(self.what, picture.pixels) for picture in self.pictures], self.pictures)
            )
        (picture,) = self.pictures
        if self.what == "segmentation":
            return png_of_ids(picture.pixels[..., 0])
        return png(encode_pixels(self.what, picture.pixels))

    def legend(self) -> list[LegendRow]:
        """Returns the visible ids of a segmentation, ascending; empty for other pictures."""
        scenes: dict[tuple[int, str], list[int]] = {}
        for picture in self.pictures if self.what == "segmentation" else ():
            for number in np.unique(picture.pixels).tolist():
                if number:
                    scenes.setdefault((number, picture.names.get(number, "")), []).append(picture.scene_idx)
        return [
            LegendRow(tuple(idxs), number, f"#{colors(np.array(number)).tobytes().hex()}", name)
            for (number, name), idxs in sorted(scenes.items())
        ]

    def _add_legend(self) -> NDArray[np.uint8]:
        """Returns the picture or sheet in colours, (H, W, 3), with its legend on the right."""
        found = [picture.pixels for picture in self.pictures]
        low, high = depth_range(found) if self.what == "depth" else (0.0, 1.0)
        tiles = [
            depth_colors(one, low, high) if self.what == "depth" else video_pixels(self.what, one) for one in found
        ]
        whole = label_sheet(tiles, self.pictures) if self.grid else tiles[0]
        if self.what == "depth":
            return add_depth_bar(whole, low, high)
        names: dict[tuple[str, str], None] = {(row.color, row.name): None for row in self.legend()}
        return add_names(whole, [*names])


def render_scene(source: Source, **given: Unpack[RenderArguments]) -> Rendering:
    """Builds scenes, simulates them and takes a picture of each, for `scenecc render`.

    Args:
        source: as for `validate`.
        given: those of `RenderChoices` and of `CompileOptions`.

    Raises:
        SceneError: the scene is invalid, the engine or the machine cannot build it, there is no such camera or scene,
            or the camera does not support this picture.
        TypeError: a flag is not a bool, or a number is not an integer.
        ValueError: an argument is out of range.
    """
    asked = Options.of_call(render_scene, given, RenderArguments)
    check_choices(given)
    own = {name: value for name, value in given.items() if name in RenderChoices.__annotations__}
    choices = cast("RenderChoices", own)
    sink = Sink()
    if choices.get("video") == "mp4" and not has_encoder():
        sink.report("SC812", NO_ENCODER, Location(None), hint=install_hint("pictures"))
    raise_errors(sink)
    found = compile_or_raise(source, asked, sink)
    setup = choose_pictures(found.plan, choices, sink)
    collision, preset = choices.get("collision", False), choices.get("preset")
    plan = restrict_to_camera(found.plan, setup.camera, collision=collision, unlit=preset is not None)
    timings, started, progress = dict(found.timings), time.perf_counter(), choices.get("progress")
    with (
        _ray_tracing(setup),
        build_batch(plan, sink, scene_idxs=setup.scene_idxs, render=True, audit=True, progress=progress) as batch,
    ):
        found.reset_replayed(batch, sink.another())
        timings["build"], started = time.perf_counter() - started, time.perf_counter()
        if collision:
            batch.show_collision()
        if preset is not None:
            batch.set_light_preset(preset)
        rendering = _take(found.plan, batch, setup, sink)
        timings["pictures"] = time.perf_counter() - started
    return replace(rendering, diagnostics=sink.diagnostics(), timings=timings)


def _take(plan: ScenePlan, batch: SceneBatch, setup: RenderSetup, sink: Sink) -> Rendering:
    """Takes the pictures. Raises SceneError."""
    choices = setup.choices
    camera, focus, hidden = choices.get("camera"), choices.get("focus"), choices.get("hidden")
    steps, video, every = choices.get("steps", 0), choices.get("video"), choices.get("every")
    try:
        recorder = FrameRecorder(
            batch, setup, choices.get("progress"), human=camera is None if hidden is None else hidden
        )
        _tell_compiling(setup)
        estimate = choices.get("estimate")
        if setup.traced and estimate is not None:
            frames = 1 if video is None else 2 + steps // recorder.stride(steps, every)
            estimate(recorder.estimate(frames * len(batch)))
        pictures, made = recorder.take(steps, video, every)
        cell = recorder.cell
    except SceneError as error:
        raise SceneError([*sink.diagnostics(), *error.diagnostics]) from error
    except KeyError as error:
        if focus is None:
            raise
        hint = "name an entity with visuals"
        sink.report("SC910", f"'{focus}' has no visuals", Location(None), hint=hint, path=("focus",))
        raise SceneError(sink.diagnostics()) from error
    except (RuntimeError, OSError) as error:
        sink.report("SC814", f"the picture cannot be rendered: {error}", Location(None))
        raise SceneError(sink.diagnostics()) from error
    explained = choices.get("legend", False)
    return Rendering(plan, camera, setup.what, setup.grid, pictures, *made, explained=explained, cell=cell)


_COMPILED: Final = set[str]()
"""Shader packs that this process has compiled."""


def _tell_compiling(setup: RenderSetup) -> None:
    from scenecc.backends.sapien.engine import cpu_renderer, keep_renderer

    keep_renderer()
    shader = setup.choices.get("shader") or (setup.camera and setup.camera.shader) or "default"
    compiling = setup.choices.get("compiling")
    if shader not in _COMPILED and compiling is not None and (device := cpu_renderer()) is not None:
        compiling(device)
    _COMPILED.add(shader)


def _ray_tracing(setup: RenderSetup) -> AbstractContextManager[object]:
    """Returns SAPIEN's ray tracing settings, if the caller chose any."""
    asked = setup.choices.get("shader") in RAY_TRACING_SHADERS
    if not setup.traced or not (asked or setup.choices.get("samples")):
        return nullcontext()
    from scenecc.backends.sapien.engine import ray_tracing_quality

    return ray_tracing_quality(setup.samples, denoise=asked)
