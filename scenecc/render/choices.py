"""Arguments of `render_scene`, and their checks against each other and against a plan."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import isfinite
from typing import TYPE_CHECKING, Any, Final

from typing_extensions import TypedDict

from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.messages import index_ranges, suggest
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, integer
from scenecc.pipeline import select_scenes
from scenecc.plan.framing import View  # noqa: TC001 - read at run time
from scenecc.plan.light_rigs import DEFAULT_PRESET, LIGHT_RIGS, Preset, is_unlit
from scenecc.plan.rendering import RAY_TRACING_SHADERS, SHADERS_WITHOUT_NORMALS, ShaderName
from scenecc.plan.schema import PIXEL_BOUNDS
from scenecc.render.images import VideoFormat, What, sheet_size
from scenecc.render.plan_cameras import resize_camera

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.rendering import Camera


class RenderChoices(TypedDict, total=False):
    """Which pictures to take of a scene.

    Attributes:
        camera: a camera of the file. None: one that frames each scene at its first picture.
        focus: an entity, or a link as ENTITY/LINK, to frame. None: everything that moves.
        eye: position of the framing camera [m]. None: where the whole subject is in view.
        look_at: the point in the middle of its picture [m]. None: the middle of the subject.
        view: the side to look from instead of `eye`: "iso", "front" (from +x), "back", "left" (from +y), "right",
            "top" or "bottom".
        zoom: magnification of the framing camera about the middle of its picture, 0.1 to 100. None: 1.
        scenes: scenes to show, as `scene_idxs` of a file: `3`, `0:4`, `0,2`. None: the first that has the camera, or
            for a `grid` all that have it.
        grid: put the pictures on one sheet. Several scenes always are.
        size: width and height of each picture [px], instead of the camera's (for the framing camera 640 × 480, on a
            sheet 320 × 240).
        what: "color", "depth", "segmentation" or "normal".
        legend: draw a scale bar [m] beside depths, or names beside the colours of a segmentation. The pixels of this
            picture are colours for viewing.
        samples: samples per pixel, 1 to 256, whose mean is the colour. None: 4 for the framing camera, 1 for one of the
            file, 32 for ray tracing.
        shader: "rt" traces rays, with denoising on an NVIDIA device. None: the camera's own.
        preset: "studio", "plain" or "dark", a light rig and a background instead of the file's lights and environment.
            None: the file's, or "studio" if it has none.
        background: background colour, "#rrggbb" or a CSS colour name. None: that of the preset, or of the file's
            environment.
        ground: draw a grid on the ground; `Rendering.cell` is the side of its cells.
        labels: write names of entities on them.
        frames: draw the axes of entities and links, x red, y green, z blue.
        contacts: draw the contact points of the last step, and forces as arrows.
        steps: steps to simulate before the picture.
        film: record a film of these steps, "mp4" or "gif".
        every: steps between two frames of the film. None: about 30 frames per second. It plays in real time.
        collision: show collision shapes instead of visuals.
        hidden: also show `hidden` entities. None: only if the camera is not from the file.
        progress: called with (finished, all) scenes, steps, frames or pictures, one after the other.
        compiling: called with the name of a device that renders on the CPU before it compiles shaders, at the first
            picture of a process. That takes 10 to 60 s without a progress report.
        estimate: called before rays are traced with the expected time [s], as measured on a small picture.
    """

    camera: str | None
    focus: str | None
    eye: tuple[float, float, float] | None
    look_at: tuple[float, float, float] | None
    view: View | None
    zoom: float | None
    scenes: str | None
    grid: bool
    size: tuple[int, int] | None
    what: What
    legend: bool
    samples: int | None
    shader: ShaderName | None
    preset: Preset | None
    background: str | None
    ground: bool
    labels: bool
    frames: bool
    contacts: bool
    steps: int
    video: VideoFormat | None
    every: int | None
    collision: bool
    hidden: bool | None
    progress: Callable[[int, int], None] | None
    compiling: Callable[[str], None] | None
    estimate: Callable[[float], None] | None


class RenderArguments(RenderChoices, CompileOptions, total=False):
    """The arguments of `render_scene`."""


class ChoiceError(ValueError):
    """An argument is out of range, or conflicts with the others.

    Attributes:
        argument: its name. problem: what is wrong with it.
    """

    def __init__(self, argument: str, problem: str) -> None:
        super().__init__(f"{argument} {problem}")
        self.argument = argument
        self.problem = problem


_OF_FRAMING: Final = ("focus", "eye", "look_at", "view", "zoom")
_OF_COLOR: Final = ("samples", "background", "preset", "ground", "labels", "frames", "contacts")
_MOST_SAMPLES: Final = 256
_LEAST_ZOOM, _MOST_ZOOM = 0.1, 100


def check_choices(given: Mapping[str, Any]) -> None:
    """Checks arguments with the types of `RenderChoices` against each other.

    Raises:
        ChoiceError: an argument is out of range, or another makes it useless.
    """
    _check_numbers(given)
    what, video, camera = given.get("what", "color"), given.get("video"), given.get("camera")
    for name in _OF_FRAMING:
        if given.get(name) is not None and camera is not None:
            raise ChoiceError(name, "is for the camera that frames the scene, not for one of the file")
    if given.get("view") is not None and given.get("eye") is not None:
        raise ChoiceError("view", "contradicts the eye: both place the camera")
    for name in _OF_COLOR:
        if given.get(name) and what != "color":
            raise ChoiceError(name, f"is for pictures in colour, not for {what}")
    if what == "normal" and given.get("shader") in SHADERS_WITHOUT_NORMALS:
        raise ChoiceError("shader", f"`{given['shader']}` cannot render normals")
    if given.get("legend") and what not in {"depth", "segmentation"}:
        raise ChoiceError("legend", f"is for depth and segmentation, not for {what}")
    if given.get("legend") and video is not None:
        raise ChoiceError("legend", "is for a picture, not for a video")
    if given.get("contacts") and not given.get("steps"):
        raise ChoiceError("contacts", "needs steps: a scene that was not simulated has no contacts")
    if (text := given.get("background")) is not None and read_background(text) is None:
        raise ChoiceError("background", f"must be '#rrggbb' or a CSS colour name such as white, not {text!r}")


def _check_numbers(given: Mapping[str, Any]) -> None:
    for pixels in given.get("size") or ():
        if not PIXEL_BOUNDS.allow(integer(pixels, "a size", 1)):
            low, high = PIXEL_BOUNDS.low, PIXEL_BOUNDS.high
            raise ChoiceError("size", f"must be {low} to {high} pixels a side, not {pixels}")
    samples = given.get("samples")
    if samples is not None and not 1 <= integer(samples, "samples", 0) <= _MOST_SAMPLES:
        raise ChoiceError("samples", f"must be 1 to {_MOST_SAMPLES}, not {samples}")
    if (zoom := given.get("zoom")) is not None and not _LEAST_ZOOM <= zoom <= _MOST_ZOOM:
        raise ChoiceError("zoom", f"must be {_LEAST_ZOOM} to {_MOST_ZOOM}, not {zoom}")
    eye, look_at = given.get("eye"), given.get("look_at")
    for name, point in (("eye", eye), ("look_at", look_at)):
        if point is not None and not all(isfinite(number) and abs(number) <= _FARTHEST for number in point):
            raise ChoiceError(name, f"must be within {_FARTHEST:g} m of the origin")
    if eye is not None and look_at is not None and tuple(eye) == tuple(look_at):
        raise ChoiceError("look_at", "must not be the position of the camera")
    steps, video, every = integer(given.get("steps", 0), "steps", 0), given.get("video"), given.get("every")
    if steps == 0 and video is not None:
        raise ChoiceError("video", "needs at least 1 step")
    if every is not None and (video is None or integer(every, "every", 1) > steps):
        raise ChoiceError("every", "needs a video, and must not exceed its steps")


def written_video(file: Path, video: VideoFormat | None) -> VideoFormat | None:
    """Returns the kind of video for a file's suffix, or None for `.png`, a picture.

    Raises:
        ValueError: the suffix is unknown, or belongs to another kind of video than requested.
    """
    suffix = file.suffix.lower()
    if suffix not in _WRITTEN:
        raise ValueError(f"{file.name} must end in one of {', '.join(_WRITTEN)}")
    found = _WRITTEN[suffix]
    if found is not None and video not in {None, found}:
        raise ValueError(f"video is {video!r}, but {file.name} has another suffix")
    return found


_WRITTEN: Final[dict[str, VideoFormat | None]] = {".png": None, ".mp4": "mp4", ".gif": "gif"}
"""Suffix of a file → the video in it. None: it holds a picture."""

_FARTHEST: Final = 1e6


def read_background(text: str) -> tuple[int, int, int] | None:
    """Returns red, green and blue, 0 to 255, of "#rrggbb" or a CSS colour name; None if it is not an opaque colour."""
    from PIL import ImageColor

    try:
        color = ImageColor.getrgb(text)
    except ValueError:
        return None
    return color if len(color) == 3 else None


_SIZE, _TILE = (640, 480), (320, 240)
"""Picture size of the framing camera, single and on a sheet [px]."""

_FRAMING_SAMPLES, _RAY_SAMPLES = 4, 32
"""Samples per pixel of this camera, and of one that traces rays (as in SAPIEN)."""

_MOST_OF_A_PICTURE, _MOST_OF_A_FRAME, _MOST_OF_ALL_SAMPLES = 2**26, 2**23, 2**28
"""Limits in pixels of a picture and of a film's frame, which take about 300 bytes per pixel during the simulation, and
limit of pixels times samples.
"""


@dataclass(frozen=True, slots=True)
class RenderSetup:
    """The pictures to take, as checked against the plan.

    Attributes:
        camera: None: a framing camera.
        scene_idxs: the scenes.
        width, height: of each picture [px].
        grid: whether they are put on one sheet.
        samples: per pixel. traced: whether rays are traced, so that the shader takes the samples.
        background: red, green, blue, 0 to 255. None: what SAPIEN draws.
        choices: all choices of the caller.
    """

    camera: Camera | None
    scene_idxs: tuple[int, ...]
    width: int
    height: int
    grid: bool
    samples: int
    traced: bool
    background: tuple[int, int, int] | None
    choices: RenderChoices

    @property
    def what(self) -> What:
        """What the pictures show."""
        return self.choices.get("what", "color")


def choose_pictures(plan: ScenePlan, choices: RenderChoices, sink: Sink) -> RenderSetup:
    """Checks choices against a plan. Raises SceneError."""
    name, shader, size = choices.get("camera"), choices.get("shader"), choices.get("size")
    camera = None if name is None else _find_camera(plan, name, choices, sink)
    having = tuple(range(plan.num_scenes)) if camera is None else camera.scene_idxs
    grid = choices.get("grid", False)
    scene_idxs = having if grid else having[:1]
    if (scenes := choices.get("scenes")) is not None:
        scene_idxs = select_scenes(scenes, plan.num_scenes, sink) or ()
        if absent := sorted({*scene_idxs}.difference(having)):
            hint = f"it is in {index_ranges(having)}"
            sink.report(
                "SC911", f"camera '{name}' is not in scene {absent[0]}", Location(None), hint=hint, path=("camera",)
            )
    _check_focus(plan, choices.get("focus"), scene_idxs, sink)
    raise_errors(sink)
    grid = grid or len(scene_idxs) > 1
    width, height = size or ((camera.width, camera.height) if camera else _TILE if grid else _SIZE)
    traced = (shader or (camera and camera.shader)) in RAY_TRACING_SHADERS
    samples = choices.get("samples") or (_RAY_SAMPLES if traced else 1 if camera else _FRAMING_SAMPLES)
    _check_size(sheet_size(len(scene_idxs), width, height) if grid else (width, height), samples, choices, sink)
    if camera is not None:
        camera = replace(resize_camera(camera, width, height), shader=shader or camera.shader)
    return RenderSetup(camera, scene_idxs, width, height, grid, samples, traced, _background(plan, choices), choices)


def _background(plan: ScenePlan, choices: RenderChoices) -> tuple[int, int, int] | None:
    preset, text = choices.get("preset"), choices.get("background")
    if text is None and (preset is not None or is_unlit(plan)):
        text = LIGHT_RIGS[preset or DEFAULT_PRESET].background
    return None if text is None else read_background(text)


def _check_size(whole: tuple[int, int], samples: int, choices: RenderChoices, sink: Sink) -> None:
    """Checks the number of pixels and samples. Raises SceneError."""
    video, pixels = choices.get("video") is not None, whole[0] * whole[1]
    kind, most = ("video", _MOST_OF_A_FRAME) if video else ("picture", _MOST_OF_A_PICTURE)
    if pixels > most:
        message = f"a {kind} of {whole[0]} × {whole[1]} pixels is larger than {most} pixels"
        hint = "take fewer scenes, or smaller pictures, such as 160 × 120"
        sink.report("SC912", message, Location(None), hint=hint, path=("size",))
    elif pixels * samples > _MOST_OF_ALL_SAMPLES:
        message = (
            f"a {kind} of {whole[0]} × {whole[1]} pixels with {samples} samples each exceeds "
            f"{_MOST_OF_ALL_SAMPLES} samples"
        )
        hint = f"take smaller pictures, or at most {_MOST_OF_ALL_SAMPLES // pixels} samples"
        sink.report("SC912", message, Location(None), hint=hint, path=("samples",))
    raise_errors(sink)


def _check_focus(plan: ScenePlan, focus: str | None, scene_idxs: tuple[int, ...], sink: Sink) -> None:
    if focus is None:
        return
    found = next((one for one in plan.entities if focus in _names_of(one)), None)
    if found is None:
        hint = suggest(focus, [name for one in plan.entities for name in _names_of(one)])
        sink.report("SC910", f"the scene has no entity '{focus}'", Location(None), hint=hint, path=("focus",))
    elif absent := sorted({*scene_idxs}.difference(found.scene_idxs)):
        hint = f"it is in {index_ranges(found.scene_idxs)}"
        sink.report("SC910", f"'{focus}' is not in scene {absent[0]}", Location(None), hint=hint, path=("focus",))


def _names_of(entity: Any) -> list[str]:
    """Returns an entity's name, and ENTITY/LINK for its links."""
    links = dict.fromkeys(link.name for one in entity.structures for link in getattr(one, "links", ()))
    return [entity.name, *(f"{entity.name}/{link}" for link in links)]


def _find_camera(plan: ScenePlan, name: str, choices: RenderChoices, sink: Sink) -> Camera | None:
    """Returns the camera with a name, or None after an error, which is reported."""
    camera = {camera.name: camera for camera in plan.cameras}.get(name)
    if camera is None:
        hint = suggest(name, [camera.name for camera in plan.cameras]) or "leave it out to see the whole scene"
        sink.report("SC911", f"the scene has no camera '{name}'", Location(None), hint=hint, path=("camera",))
        return None
    shader = choices.get("shader") or camera.shader
    if choices.get("what") == "normal" and shader in SHADERS_WITHOUT_NORMALS:
        place = camera.origin.child("shader") if camera.origin else Location(None)
        hint = "use another camera, or none"
        sink.report(
            "SC913", f"a camera with the shader `{shader}` cannot render normals", place, hint=hint, path=("what",)
        )
    return camera


def raise_errors(sink: Sink) -> None:
    """Raises SceneError if an error was reported."""
    if sink.failed:
        raise SceneError(sink.diagnostics())
