"""`scenecc inspect`."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from scenecc.cli.completion import complete_entity
from scenecc.cli.options import (
    SceneArgument,
    TableFormatOption,
    at_least,
    takes_compile_options,
)
from scenecc.cli.output import end, progress, scene_errors
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import tree_text

Scene = Annotated[
    int | None, typer.Option("--scene", metavar="K", parser=at_least(0), help="Show the values of this scene.")
]
Entity = Annotated[
    str | None,
    typer.Option(
        "--entity",
        metavar="NAME",
        help="Show only these entities; * and ? are wildcards.",
        autocompletion=complete_entity,
    ),
]
Depth = Annotated[int | None, typer.Option("--depth", metavar="N", parser=at_least(0), help="Depth of the tree.")]
AskEngine = Annotated[
    bool, typer.Option("--build/--no-build", help="Build one scene per entity to get masses and sizes.")
]


@takes_compile_options
def inspect(
    scene: SceneArgument,
    *,
    index: Scene = None,
    entity: Entity = None,
    depth: Depth = None,
    ask: AskEngine = True,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Show the contents of a scene as a tree.

    The tree lists sizes, masses, materials, joints, scenes, and all files with their hashes. Values
    that differ between scenes are shown as alternatives or ranges, or with --scene as the values of
    that scene. Masses come from the engine. No render device is needed.

    \b
    Examples:
      scenecc inspect scenes/tabletop.yaml
      scenecc inspect scenes/clutter.yaml --scene 3 --entity 'things/*'
      scenecc inspect scenes/robot_arm.yaml --depth 2 --no-build
      scenecc inspect scenes/tabletop.yaml --format json
    """
    import scenecc

    source = checked_source(scene, form=form)
    with scene_errors(options, form), progress("build") as show:
        inspection = scenecc.open_scene(source, **options).inspect(
            scene=index, entity=entity, depth=depth, build=ask, progress=show
        )
    end(inspection.diagnostics, form, data=inspection.item.data, text=lambda: tree_text(inspection.item))
