"""`scenecc describe`."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from scenecc.cli.options import SceneArgument, TableFormatOption, at_least, takes_compile_options
from scenecc.cli.output import end, progress, scene_errors
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text


@takes_compile_options
def describe(
    scene: SceneArgument,
    *,
    index: Annotated[int, typer.Option("--scene", metavar="K", parser=at_least(0), help="Describe this scene.")] = 0,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Describe a built scene: sizes, poses, and what stands on what.

    Lists each object with its size, position and mass, what it stands on, is in, is suspended from, touches and
    overlaps, and gaps below it. Contacts come from the engine, in the initial poses. No render device is needed.

    \b
    Examples:
      scenecc describe scenes/tabletop.yaml
      scenecc describe scenes/clutter.yaml --scene 3
      scenecc describe scenes/clutter.yaml --format json
    """
    import scenecc

    source = checked_source(scene, form=form)
    with scene_errors(options, form), progress("build") as show:
        found = scenecc.describe_scene(source, scene=index, progress=show, **options)
    end(
        found.diagnostics,
        form,
        data=lambda: found.data,
        text=lambda: "".join(f"{escape_text(line)}\n" for line in found.text.splitlines()),
    )
