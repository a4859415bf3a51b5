"""`scenecc render`."""

from __future__ import annotations

import sys
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

import typer

from scenecc.cli.completion import complete_scene
from scenecc.cli.many_files import ChangedSince, Jobs, Shard, are_many, choose_files, files_used, write_each
from scenecc.cli.options import (
    Format,
    FormatOption,
    Show,
    Steps,
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
    print_out,
    progress,
    usage_error,
    write_output,
)
from scenecc.cli.paths import find_files, path_faults, source_of
from scenecc.cli.render_options import PICTURE_OPTIONS, picture_choices
from scenecc.cli.tables import escape_text, stage_times, table
from scenecc.diagnostics.messages import index_ranges

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Diagnostic
    from scenecc.render.render import Rendering

Output = Annotated[
    str | None,
    typer.Option(
        "--output", "-o", metavar="FILE.png", help="Output file, or folder for many scenes; - is standard output."
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
Video = Annotated[
    str | None,
    typer.Option("--video", metavar="FILE", help="Record the steps as FILE.mp4 or FILE.gif.", show_default=False),
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
    show: Annotated[Show, typer.Option("--show", help="Shapes to draw.")] = Show.visual,
    steps: Steps = 0,
    video: Video = None,
    every: Every = None,
    form: FormatOption = Format.text,
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
      scenecc render scenes/stack.yaml --focus crate --preset dark --samples 16 -o crate.png
      scenecc render scenes/stack.yaml --eye 1.5,-1,1.2 --ground --labels -o labels.png
      scenecc render scenes/clutter.yaml --steps 200 --contacts -o contacts.png
      scenecc render scenes/cameras.yaml --what depth --legend -o depth_for_people.png
      scenecc render scenes/tabletop.yaml --show collision --size 800x600 -o collision.png
      scenecc render scenes/reset.yaml --steps 200 --video reset.mp4
      scenecc render scenes/recipes --size 320x240 -o pictures --jobs 2
      scenecc render scenes --changed-since main --shard 1/4 -o pictures
    """
    from scenecc.options import Options

    many = are_many(paths, shard, changed_since)
    kind = _choose_kind(output, video, steps, every, many=many)
    choices = picture_choices(others, steps=steps, video=kind, every=every, collision=show is Show.collision)
    picture = partial(_render, {**choices, **options}, video, form)
    if many:
        used = partial(files_used, options=Options.of(**options))
        choose = partial(choose_files, changed_since=changed_since, shard=shard, files_of=used)
        write_each("render", find_files(paths), str(output), ".png", jobs, picture, form, choose)
    if faults := _path_faults(paths[0], output, video, form):
        end(faults, form)
    if kind is not None:
        outlive_pipes()  # its encoder may end before it has all frames
    with progress("render") as told:
        diagnostics, text = picture(paths[0], output, told)
    (print_err if STDOUT in {output, video} else print_out)(text)
    end(diagnostics, form)


def _render(
    asked: dict[str, Any], video: str | None, form: Format, scene: str, output: str | None, told: Any = None
) -> tuple[list[Diagnostic], str]:
    """Renders a scene and writes the result. Returns diagnostics and a text. `asked`: arguments of `render_scene`."""
    import scenecc

    try:
        result = scenecc.render_scene(
            source_of(scene), **asked, estimate=_tell_estimate, compiling=_tell_compiling, progress=told
        )
    except scenecc.SceneError as error:
        return of_settings(error.diagnostics, asked["params"], scenes="--scene"), ""
    return _write(result, output, video, form)


def _choose_kind(
    output: str | None, video: str | None, steps: int, every: int | None, *, many: bool
) -> Literal["mp4", "gif"] | None:
    """Returns the kind of video that is requested. Raises typer.BadParameter if the options do not fit together."""
    if output is None and video is None:
        raise typer.BadParameter("an output is needed: -o FILE.png, or --video FILE.mp4", param_hint="'-o'")
    if many and (output is None or video is not None):
        raise typer.BadParameter("pictures of several scenes are written to a folder: -o FOLDER", param_hint="'-o'")
    if not many and output not in {None, STDOUT} and not str(output).lower().endswith(".png"):
        raise typer.BadParameter(f"{quote_text(str(output))} must end in .png", param_hint="'-o'")
    if every is not None and (video is None or every > steps):
        raise typer.BadParameter("it needs --video, and at least as many --steps", param_hint="'--every'")
    if video is None:
        return None
    if steps == 0:
        raise typer.BadParameter("a video needs --steps of at least 1", param_hint="'--video'")
    if video.lower().endswith(".mp4"):
        return "mp4"
    if video.lower().endswith(".gif"):
        return "gif"
    raise typer.BadParameter(f"{quote_text(video)} must end in .mp4 or .gif", param_hint="'--video'")


_WORTH_TELLING: Final = 5.0
"""Shortest ray-tracing time that is announced [s]."""


def _tell_estimate(seconds: float) -> None:
    if seconds >= _WORTH_TELLING:
        words = f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
        print_above(f"ray tracing will take about {words} on this device; fewer --samples or pixels take less")


def _tell_compiling(device: str) -> None:
    print_above(f"{device} compiles shaders, once per process: 10 to 60 s")


def _path_faults(scene: str, output: str | None, video: str | None, form: Format) -> list[Diagnostic]:
    faults = path_faults(scene, output, form)
    # The scene's path is already checked.
    return faults or [fault for fault in path_faults(scene, video, form) if fault.code != "SC901"]


def _write(result: Rendering, output: str | None, video: str | None, form: Format) -> tuple[list[Diagnostic], str]:
    """Writes the files. Returns diagnostics, and a description of the files."""
    diagnostics = list(result.diagnostics)
    grid = [] if result.cell is None else [f"ground grid: cells of {result.cell:.10g} m"]
    written: list[str] = []
    for target, content, words in _files(result, output, video):
        reason = write_output(target, content)
        if reason is None:
            written.append(f"{escape_text(target)}: {words}")
        else:
            diagnostics.append(usage_error(*reason, file=target))
    if form is not Format.text or not written:
        return diagnostics, ""
    return diagnostics, "\n".join([*_legend(result), *written, *grid, stage_times(result.timings)]) + "\n"


def _files(result: Rendering, output: str | None, video: str | None) -> Iterator[tuple[str, bytes, str]]:
    """Yields the files to write: path, content and description."""
    scenes = index_ranges([picture.scene_idx for picture in result.pictures])
    height, width, _ = result.pictures[0].pixels.shape
    one = len(result.pictures) == 1
    seen = f"{result.what}, {width} × {height}, scene{'' if one else 's'} {scenes} of {result.plan.num_scenes}"
    if output is not None:
        yield output, result.png(), seen
    if video is not None and result.video is not None:
        yield video, result.video, f"{seen}, {result.frames} frames, {result.rate:.4g} per second"


def _legend(result: Rendering) -> list[str]:
    """Returns one line per segmentation id, with what it marks."""
    from scenecc.diagnostics.formats import wants_color

    rows = [[str(row.id), row.color, escape_text(row.name), index_ranges(row.scene_idxs)] for row in result.legend()]
    if not rows:
        return []
    return [table(["id", "color", "name", "scenes"], rows, color=wants_color(sys.stdout))]
