"""`scenecc diff`."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from scenecc.cli.arguments import path_faults
from scenecc.cli.differences import differences_text
from scenecc.cli.find import STDIN
from scenecc.cli.options import (
    AllowOutside,
    AssetRoots,
    Format,
    Limits,
    NumScenes,
    Params,
    Seed,
    TableFormat,
    TableFormatOption,
    parse_limits,
    parse_params,
)
from scenecc.cli.output import print_out
from scenecc.cli.report import Status, end, of_settings, print_asides

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


def diff(
    first: Annotated[str, typer.Argument(metavar="A", help="A scene file or a plan, or - for standard input.")],
    second: Annotated[str, typer.Argument(metavar="B", help="The same.")],
    *,
    num_scenes: NumScenes = None,
    seed: Seed = None,
    params: Params = None,
    asset_roots: AssetRoots = None,
    allow_outside_assets: AllowOutside = False,
    limits: Limits = None,
    form: TableFormatOption = TableFormat.text,
) -> None:
    """Say what differs between two scenes, by what they build.

    Compared are the plans, object by object and field by field: a scene that is only written otherwise
    is the same. Options hold for both.

    Exit status: 0 the same, 1 not the same, 2 wrong usage, or one of them is at fault.

    \b
    Examples:
      scenecc diff scenes/tabletop.yaml scenes/obstacle.yaml
      git show HEAD:scenes/tabletop.yaml | scenecc diff - scenes/tabletop.yaml
    """
    from scenecc import api, questions

    checked_limits, values = parse_limits(limits), parse_params(params)
    if first == second == STDIN:
        raise typer.BadParameter("standard input holds one scene only", param_hint="'B'")
    faults = [*path_faults(first, None), *path_faults(second, None)]
    if faults:
        end(faults, least=Status.usage)  # 1 is the status of scenes that differ
    found: list[Diagnostic] = []
    try:
        differences = questions.compare_scenes(
            sys.stdin.buffer if first == STDIN else first,
            sys.stdin.buffer if second == STDIN else second,
            num_scenes=num_scenes,
            seed=seed,
            params=values,
            asset_roots=asset_roots or (),
            allow_outside_assets=allow_outside_assets,
            limits=checked_limits,
            found=found,
        )
    except api.SceneError as error:
        end(of_settings(error.diagnostics, values), least=Status.usage)
    print_asides(found, Format.text)
    if form is TableFormat.json:
        rows = [asdict(difference) for difference in differences]
        print_out(json.dumps({"differences": rows}, indent=2, ensure_ascii=False) + "\n")
    else:
        from scenecc.diagnostics.render import wants_color

        print_out(differences_text(differences, color=wants_color(sys.stdout)))
    raise typer.Exit(Status.scene if differences else Status.fine)
