"""`scenecc emit`."""

from __future__ import annotations

import sys
from enum import Enum
from typing import TYPE_CHECKING, Annotated, NoReturn

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
    parse_limits,
    parse_params,
)
from scenecc.cli.output import STDOUT, base_folder, write
from scenecc.cli.report import of_settings, print_asides, status, usage_error

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Diagnostic


class Target(str, Enum):
    """What a scene is emitted as."""

    python = "python"
    json = "json"


def emit(
    scene: SceneArgument,
    *,
    target: Annotated[Target, typer.Option("--to", help="What to write.")],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FILE", help="Where to write it; - is standard output.")
    ] = STDOUT,
    num_scenes: NumScenes = None,
    seed: Seed = None,
    params: Params = None,
    asset_roots: AssetRoots = None,
    allow_outside_assets: AllowOutside = False,
    limits: Limits = None,
) -> None:
    """Write a scene as Python or as JSON.

    Python is a script of plain SAPIEN calls that needs no scenecc; JSON is the scene's plan.

    \b
    Examples:
      scenecc emit scenes/tabletop.yaml --to python
      scenecc emit scenes/tabletop.yaml --to json -o tabletop.plan.json
    """
    from scenecc import api

    checked_limits, values = parse_limits(limits), parse_params(params)
    faults = path_faults(scene, output)
    if faults:
        _refuse(faults)
    warnings: list[Diagnostic] = []
    try:
        text = api.emit_scene(
            sys.stdin.buffer if scene == STDIN else scene,
            target.value,
            base=base_folder(output),
            num_scenes=num_scenes,
            seed=seed,
            params=values,
            asset_roots=asset_roots or (),
            allow_outside_assets=allow_outside_assets,
            limits=checked_limits,
            found=warnings,
        )
    except api.SceneError as error:
        _refuse(of_settings(error.diagnostics, values))
    reason = write(output, text)
    print_asides(warnings, Format.text)
    if reason is not None:
        _refuse([usage_error("SC904", reason, file=output)])


def _refuse(diagnostics: Sequence[Diagnostic]) -> NoReturn:
    print_asides(diagnostics, Format.text)
    raise typer.Exit(status(diagnostics))
