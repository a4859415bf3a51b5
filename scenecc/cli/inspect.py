"""`scenecc inspect`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.options import (
    SceneArgument,
    TableFormat,
    TableFormatOption,
    at_least,
    takes_compile_options,
)
from scenecc.cli.output import print_asides, print_json, print_out, progress, scene_errors
from scenecc.cli.paths import checked_source

if TYPE_CHECKING:
    pass

Scene = Annotated[
    int | None, typer.Option("--scene", metavar="K", parser=at_least(0), help="Tell what this one scene has.")
]
Entity = Annotated[
    str | None, typer.Option("--entity", metavar="NAME", help="Tell these entities only; takes * and ? as well.")
]
Depth = Annotated[
    int | None, typer.Option("--depth", metavar="N", parser=at_least(0), help="How far below the scene the tree goes.")
]
AskEngine = Annotated[
    bool, typer.Option("--build/--no-build", help="Ask the engine for masses and sizes, in one scene an entity.")
]


@takes_compile_options
def inspect(
    scene: SceneArgument,
    *,
    index: Scene = None,
    entity: Entity = None,
    depth: Depth = None,
    ask: AskEngine = True,
    form: TableFormatOption = TableFormat.text,
    options: dict[str, Any],
) -> None:
    """Show what a scene holds, as a tree.

    It tells sizes, masses, materials, joints, scenes, and all files with their hashes. Values that
    scenes differ in are told as alternatives or ranges; of one scene, as they are there. Masses are
    the engine's, which starts for them without a render device.

    \b
    Examples:
      scenecc inspect scenes/tabletop.yaml
      scenecc inspect scenes/clutter.yaml --scene 3 --entity 'things/*'
      scenecc inspect scenes/robot_arm.yaml --depth 2 --no-build
      scenecc inspect scenes/tabletop.yaml --format json
    """
    import scenecc

    source = checked_source(scene)
    with scene_errors(options), progress("build") as show:
        inspection = scenecc.open_scene(source, **options).inspect(
            scene=index, entity=entity, depth=depth, build=ask, progress=show
        )
    item = inspection.item
    print_asides(inspection.diagnostics)
    if form is TableFormat.json:
        print_json(item.data())
    else:
        from scenecc.cli.tables import tree_text

        print_out(tree_text(item))
