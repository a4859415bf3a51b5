"""`scenecc inspect`."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from scenecc.cli.arguments import path_faults
from scenecc.cli.find import STDIN
from scenecc.cli.options import (
    AllowOutside,
    AssetRoots,
    Format,
    Limits,
    NumScenes,
    Params,
    SceneArgument,
    Seed,
    TableFormat,
    TableFormatOption,
    at_least,
    parse_limits,
    parse_params,
)
from scenecc.cli.output import print_out
from scenecc.cli.progress import progress
from scenecc.cli.report import end, of_settings, print_asides

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic

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


def inspect(
    scene: SceneArgument,
    *,
    index: Scene = None,
    entity: Entity = None,
    depth: Depth = None,
    ask: AskEngine = True,
    num_scenes: NumScenes = None,
    seed: Seed = None,
    params: Params = None,
    asset_roots: AssetRoots = None,
    allow_outside_assets: AllowOutside = False,
    limits: Limits = None,
    form: TableFormatOption = TableFormat.text,
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
    from scenecc import api

    checked_limits, values = parse_limits(limits), parse_params(params)
    faults = path_faults(scene, None)
    if faults:
        end(faults)
    warnings: list[Diagnostic] = []
    try:
        with progress("build") as show:
            item = api.inspect_scene(
                sys.stdin.buffer if scene == STDIN else scene,
                scene=index,
                entity=entity,
                depth=depth,
                build=ask,
                num_scenes=num_scenes,
                seed=seed,
                params=values,
                asset_roots=asset_roots or (),
                allow_outside_assets=allow_outside_assets,
                limits=checked_limits,
                found=warnings,
                progress=show,
            )
    except api.SceneError as error:
        end(of_settings(error.diagnostics, values))
    print_asides(warnings, Format.text)
    if form is TableFormat.json:
        print_out(json.dumps(item.data(), indent=2, ensure_ascii=False) + "\n")
    else:
        from scenecc.cli.tree import tree_text

        print_out(tree_text(item))
