"""`scenecc render`."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from scenecc.cli.completion import complete_scene
from scenecc.cli.many_files import ChangedSince, Jobs, Shard, Written, are_many, choose_files, files_used, write_each
from scenecc.cli.options import (
    FormatOption,
    Show,
    Steps,
    Timings,
    at_least,
    quote_text,
    takes_compile_options,
)
from scenecc.cli.output import (
    STDOUT,
    end,
    of_settings,
    outlive_pipes,
    print_above,
    print_err,
    progress,
    usage_error,
    write_output,
)
from scenecc.cli.paths import find_files, path_faults, source_of
from scenecc.cli.render_options import PICTURE_OPTIONS, picture_choices
from scenecc.cli.tables import escape_text, stage_times, table
from scenecc.diagnostics.messages import index_ranges

if TYPE_CHECKING:
    from scenecc.render.render import Rendering

Output = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        metavar="FILE",
        help="Picture .png, video .mp4 or .gif of the steps, or folder for many scenes; - is standard output.",
    ),
]
Paths = Annotated[
    list[str],
    typer.Argument(
        metavar="SCENE...",
        help="Scene files, folders of them, or - for standard input.",
        autocompletion=complete_scene,
    ),
]
Every = Annotated[
    int | None,
    typer.Option(
        "--every", metavar="N", parser=at_least(1), help="Steps per frame.", show_default="about 30 frames per second"
    ),
]


@partial(takes_compile_options, others=PICTURE_OPTIONS)
def render(
    paths: Paths,
    *,
    output: Output = None,
    jobs: Jobs = None,
    shard: Shard = None,
    changed_since: ChangedSince = None,
    show: Annotated[Show, typer.Option("--show", help="Shapes to draw.")] = "visual",
    steps: Steps = 0,
    every: Every = None,
    timings: Timings = False,
    form: FormatOption = "text",
    options: dict[str, Any],
    others: dict[str, Any],
) -> None:
    """Render a picture or video of a scene with SAPIEN's renderer.

    Without --camera, a default camera frames the moving objects. Depth is written in millimetres with 16 bits per
    pixel. Segmentation is written as ids with a palette, and a table of the ids is printed. Rendering needs a GPU, or
    Mesa's software driver. MP4 videos need the extra `pictures`.

    For several scenes, or the scenes in a folder, each picture is written to the folder OUTPUT, under the name of its
    scene.

    \b
    Examples:
      scenecc render scenes/tabletop.yaml -o tabletop.png
      scenecc render scenes/cameras.yaml --camera main --what depth -o depth.png
      scenecc render scenes/clutter.yaml --num-scenes 16 --grid -o sheet.png
      scenecc render scenes/stack.yaml --focus crate --preset dark -o crate.png
      scenecc render scenes/stack.yaml --eye 1.5,-1,1.2 --labels -o labels.png
      scenecc render scenes/clutter.yaml --steps 200 --contacts -o contacts.png
      scenecc render scenes/cameras.yaml --what depth --legend -o legend.png
      scenecc render scenes/tabletop.yaml --show collision -o collision.png
      scenecc render scenes/reset.yaml --steps 200 -o reset.mp4
      scenecc render scenes/recipes --size 320x240 -o pictures --jobs 2
      scenecc render scenes --changed-since main --shard 1/4 -o pictures
    """
    from scenecc.options import Options

    many = are_many(paths, shard, changed_since)
    output, kind = _choose_kind(output, steps, every, many=many)
    choices = picture_choices(others, steps=steps, video=kind, every=every, collision=show == "collision")
    picture = partial(_render, {**choices, **options}, timings)
    if many:
        used = partial(files_used, options=Options.of(**options))
        choose = partial(choose_files, changed_since=changed_since, shard=shard, files_of=used)
        write_each("render", find_files(paths), output, ".png", jobs, picture, form, choose)
    if faults := path_faults(paths[0], output, form):
        end(faults, form)
    if kind is not None:
        outlive_pipes()  # its encoder may end before it has all frames
    with progress("render") as told:
        diagnostics, text, files = picture(paths[0], output, told)
    end(diagnostics, form, data=lambda: {"files": files}, text=lambda: text, beside=output == STDOUT)


def _render(asked: dict[str, Any], timings: bool, scene: str, output: str, told: Any = None) -> Written:
    """Renders a scene and writes the result. `asked`: arguments of `render_scene`."""
    import scenecc

    try:
        result = scenecc.render_scene(
            source_of(scene), **asked, estimate=_tell_estimate, compiling=_tell_compiling, progress=told
        )
    except scenecc.SceneError as error:
        return of_settings(error.diagnostics, asked["params"]), "", []
    if timings:
        print_err(f"{stage_times(result.timings)}\n")
    return _write(result, output)


def _choose_kind(
    output: str | None, steps: int, every: int | None, *, many: bool
) -> tuple[str, Literal["mp4", "gif"] | None]:
    """Returns the output, and the kind of video that its suffix requests. Raises typer.BadParameter if the options do
    not fit together.
    """
    if output is None:
        raise typer.BadParameter("an output is needed: -o FILE.png or FILE.mp4", param_hint="'-o'")
    suffix = Path(output).suffix.lower()
    kind: Literal["mp4", "gif"] | None = "mp4" if suffix == ".mp4" else "gif" if suffix == ".gif" else None
    if many and kind is not None:
        raise typer.BadParameter("pictures of several scenes are written to a folder: -o FOLDER", param_hint="'-o'")
    if not many and output != STDOUT and kind is None and suffix != ".png":
        raise typer.BadParameter(f"{quote_text(output)} must end in .png, .mp4 or .gif", param_hint="'-o'")
    if every is not None and (kind is None or every > steps):
        raise typer.BadParameter("it needs a video, and at least as many --steps", param_hint="'--every'")
    if kind is not None and steps == 0:
        raise typer.BadParameter("a video needs --steps of at least 1", param_hint="'-o'")
    return output, kind


_WORTH_TELLING: Final = 5.0
"""Shortest ray-tracing time that is announced [s]."""


def _tell_estimate(seconds: float) -> None:
    if seconds >= _WORTH_TELLING:
        words = f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
        print_above(f"ray tracing will take about {words} on this device; fewer --samples or pixels take less")


def _tell_compiling(device: str) -> None:
    print_above(f"{device} compiles shaders, once per process: 10 to 60 s")


def _write(result: Rendering, output: str) -> Written:
    """Writes the file."""
    scenes = index_ranges(scene_idxs := [picture.scene_idx for picture in result.pictures])
    height, width, _ = result.pictures[0].pixels.shape
    one = "" if len(result.pictures) == 1 else "s"
    words = f"{result.what}, {width} × {height}, scene{one} {scenes} of {result.plan.num_scenes}"
    if result.video is not None:
        words += f", {result.frames} frames, {result.rate:.4g} per second"
    reason = write_output(output, result.png() if result.video is None else result.video)
    if reason is not None:
        return [*result.diagnostics, usage_error(*reason, file=output)], "", []
    grid = [] if result.cell is None else [f"ground grid: cells of {result.cell:.10g} m"]
    text = "\n".join([*_legend(result), f"{escape_text(output)}: {words}", *grid]) + "\n"
    seen = {"what": result.what, "size": [width, height], "scene_idxs": scene_idxs, "frames": result.frames}
    legend = [asdict(row) for row in result.legend()]
    return result.diagnostics, text, [{"file": output, **seen, "legend": legend}]


def _legend(result: Rendering) -> list[str]:
    """Returns one line per segmentation id, with what it marks."""
    rows = [[str(row.id), row.color, escape_text(row.name), index_ranges(row.scene_idxs)] for row in result.legend()]
    if not rows:
        return []
    return [table(["id", "color", "name", "scenes"], rows)]
