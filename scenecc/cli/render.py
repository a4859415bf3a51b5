"""`scenecc render`."""

from __future__ import annotations

import re
import sys
from enum import Enum
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal, NoReturn

import typer

from scenecc.cli.options import (
    Format,
    FormatOption,
    SceneArgument,
    Show,
    Steps,
    at_least,
    shown,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    end,
    outlive_pipes,
    print_err,
    print_out,
    progress,
    scene_errors,
    usage_error,
    write,
)
from scenecc.cli.paths import path_faults, source_of
from scenecc.cli.tables import plain, stage_times, table
from scenecc.diagnostics.messages import index_ranges

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Diagnostic
    from scenecc.render.render import Rendering

_SIZE: Final = re.compile(r"([1-9][0-9]{0,4})x([1-9][0-9]{0,4})")


class What(str, Enum):
    """Contents of a picture."""

    color = "color"
    depth = "depth"
    segmentation = "segmentation"
    normal = "normal"


def parse_size(text: str) -> tuple[int, int]:
    """`640x480`. Raises typer.BadParameter for anything else."""
    from scenecc.plan.schema import PIXEL_BOUNDS

    found, most = _SIZE.fullmatch(text), int(PIXEL_BOUNDS.high)
    size = (int(found[1]), int(found[2])) if found else (0, 0)
    if not found or max(size) > most:
        raise typer.BadParameter(
            f"{shown(text)} is not a size from 1 to {most}, such as 640x480", param_hint="'--size'"
        )
    return size


Output = Annotated[
    str | None, typer.Option("--output", "-o", metavar="FILE.png", help="Output file; - is standard output.")
]
Camera = Annotated[
    str | None, typer.Option("--camera", metavar="NAME", help="A camera of the file.", show_default="frames the scene")
]
Scene = Annotated[
    str | None,
    typer.Option(
        "--scene", metavar="IDXS", help="Scene to render, or several (0:4 or 0,2 or ::2) on one contact sheet."
    ),
]
Grid = Annotated[bool, typer.Option("--grid", help="Render all scenes on one contact sheet, labelled by index.")]
Size = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Size of each picture [px], overriding the camera."),
]
Video = Annotated[
    str | None,
    typer.Option("--video", metavar="FILE", help="Record the steps as FILE.mp4 or FILE.gif.", show_default=False),
]
Every = Annotated[
    int | None,
    typer.Option(
        "--every", metavar="N", parser=at_least(1), help="Steps per frame.", show_default="about 30 frames a second"
    ),
]
Hidden = Annotated[
    bool | None,
    typer.Option(
        "--hidden/--no-hidden", help="Show objects that are hidden from sensors.", show_default="only without --camera"
    ),
]


@takes_compile_options
def render(
    scene: SceneArgument,
    *,
    output: Output = None,
    camera: Camera = None,
    which: Scene = None,
    grid: Grid = False,
    size: Size = None,
    what: Annotated[What, typer.Option("--what", help="Content of the picture.")] = What.color,
    show: Annotated[Show, typer.Option("--show", help="Shapes to draw.")] = Show.visual,
    steps: Steps = 0,
    video: Video = None,
    every: Every = None,
    hidden: Hidden = None,
    form: FormatOption = Format.text,
    options: dict[str, Any],
) -> None:
    """Render a picture or a film of a scene with SAPIEN's renderer.

    Without --camera, a camera that frames the scene is used. Depth is written in millimetres with 16 bits per pixel.
    Segmentation is written as ids with a palette, and a table of the ids is printed. Needs a GPU, or Mesa's driver for
    the CPU, and the extra `pictures`.

    \b
    Examples:
      scenecc render scenes/tabletop.yaml -o tabletop.png
      scenecc render scenes/cameras.yaml --camera main --what depth -o depth.png
      scenecc render scenes/clutter.yaml --num-scenes 16 --grid -o sheet.png
      scenecc render scenes/tabletop.yaml --show collision --size 800x600 -o collision.png
      scenecc render scenes/reset.yaml --steps 200 --video reset.mp4
    """
    import scenecc

    film = _film(output, video, steps, every)
    if faults := _path_faults(scene, output, video, form):
        end(faults, form)
    if film is not None:
        outlive_pipes()  # its encoder may end before all frames are there
    with scene_errors(options, form), progress("render") as told:
        result = scenecc.render_scene(
            source_of(scene),
            camera=camera,
            scenes=which,
            grid=grid,
            size=None if size is None else parse_size(size),
            what=what.value,
            steps=steps,
            film=film,
            every=every,
            collision=show is Show.collision,
            hidden=hidden,
            **options,
            progress=told,
        )
    _conclude(result, output, video, form)


def _film(output: str | None, video: str | None, steps: int, every: int | None) -> Literal["mp4", "gif"] | None:
    """Which kind of film is asked for. Raises typer.BadParameter where the options do not fit together."""
    if output is None and video is None:
        raise typer.BadParameter("say where to write: -o FILE.png, or --video FILE.mp4", param_hint="'-o'")
    if output not in {None, STDOUT} and not str(output).lower().endswith(".png"):
        raise typer.BadParameter(f"{shown(str(output))} does not end in .png", param_hint="'-o'")
    if every is not None and (video is None or every > steps):
        raise typer.BadParameter("it needs --video and at least as many --steps", param_hint="'--every'")
    if video is None:
        return None
    if steps == 0:
        raise typer.BadParameter("a film needs --steps of at least 1", param_hint="'--video'")
    if video.lower().endswith(".mp4"):
        return "mp4"
    if video.lower().endswith(".gif"):
        return "gif"
    raise typer.BadParameter(f"{shown(video)} does not end in .mp4 or .gif", param_hint="'--video'")


def _path_faults(scene: str, output: str | None, video: str | None, form: Format) -> list[Diagnostic]:
    faults = path_faults(scene, output, form)
    # Of the scene's path all was said.
    return faults or [fault for fault in path_faults(scene, video, form) if fault.code != "SC901"]


def _conclude(result: Rendering, output: str | None, video: str | None, form: Format) -> NoReturn:
    """Writes the files, and says what they are."""
    diagnostics = list(result.diagnostics)
    written: list[str] = []
    for target, content, words in _files(result, output, video):
        reason = write(target, content)
        if reason is None:
            written.append(f"{plain(target)}: {words}")
        else:
            diagnostics.append(usage_error(*reason, file=target))
    if form is Format.text and written:
        lines = [*_legend(result), *written, stage_times(result.timings)]
        (print_err if STDOUT in {output, video} else print_out)("\n".join(lines) + "\n")
    end(diagnostics, form)


def _files(result: Rendering, output: str | None, video: str | None) -> Iterator[tuple[str, bytes, str]]:
    """What is written: where, its content, and what it is in words."""
    scenes = index_ranges([picture.scene_idx for picture in result.pictures])
    height, width, _ = result.pictures[0].pixels.shape
    one = len(result.pictures) == 1
    seen = f"{result.what}, {width} × {height}, scene{'' if one else 's'} {scenes} of {result.plan.num_scenes}"
    if output is not None:
        yield output, result.png(), seen
    if video is not None and result.film is not None:
        yield video, result.film, f"{seen}, {result.frames} pictures, {result.rate:.4g} a second"


def _legend(result: Rendering) -> list[str]:
    """What the ids of a segmentation stand for."""
    from scenecc.diagnostics.formats import wants_color

    rows = [[str(row.id), row.color, plain(row.name), index_ranges(row.scene_idxs)] for row in result.legend()]
    if not rows:
        return []
    return [table(["id", "color", "name", "scenes"], rows, color=wants_color(sys.stdout))]
