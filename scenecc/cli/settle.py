"""`scenecc settle`."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.check import parse_seconds, parse_seeds, refuse_seed_beside
from scenecc.cli.options import FormatOption, SceneArgument, takes_compile_options
from scenecc.cli.output import STDOUT, end, progress, scene_errors, usage_error, write_files
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic

_OPTIONS: Final = ("num_scenes", "seed", "params", "asset_roots", "allow_outside_assets", "limits")
"""The compile options without `starts`, which this command makes."""


@partial(takes_compile_options, names=_OPTIONS)
def settle(
    scene: SceneArgument,
    *,
    output: Annotated[str, typer.Option("--output", "-o", metavar="STARTS.json", help="Write the starts here.")],
    seeds: Annotated[
        Any, typer.Option("--seeds", metavar="A:B", parser=parse_seeds, help="Settle with each seed from A to B-1.")
    ] = None,
    seconds: Annotated[
        float,
        typer.Option("--seconds", metavar="SECONDS", parser=parse_seconds, help="Longest time to simulate."),
    ] = 10.0,
    form: FormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Simulate scenes until they rest, and write where, as starts.

    With `starts: STARTS.json` in the scene, or --starts, its scenes begin there. Scenes that do not rest within the
    given time, or that break `expect` when they begin at their start, are dropped and counted.

    \b
    Examples:
      scenecc settle scenes/clutter.yaml -o starts.json
      scenecc settle scenes/clutter.yaml --seeds 0:100 -o starts.json
      scenecc settle scenes/clutter.yaml -n 16 --seconds 5 -o starts.json
    """
    import scenecc

    refuse_seed_beside(seeds, options)
    if seconds <= 0:
        raise typer.BadParameter("it must be above 0", param_hint="'--seconds'")
    if output == STDOUT or not output.lower().endswith(".json"):
        raise typer.BadParameter("it must be a file NAME.json", param_hint="'--output'")
    source = checked_source(scene, output, form)
    with scene_errors(options, form), progress("settle") as show:
        made = scenecc.settle_scene(source, seeds=seeds, seconds=seconds, progress=show, **options)
    found: list[Diagnostic] = list(made.diagnostics)
    if made.kept:
        try:
            reason = write_files(output, made.files(Path(output).name), folder=False)
        except ImportError as error:
            from scenecc.extras import install_hint

            reason = "SC813", f"starts above 1 MB need pyarrow: {error}; {install_hint('sweep')}"
        if reason is not None:
            end([*found, usage_error(*reason, file=output)], form)
    else:
        found.append(usage_error("SC937", f"no scene has a start: {made.summary()}", file=scene))
    end(
        found,
        form,
        data=lambda: {
            "starts": output if made.kept else None,
            "kept": made.kept,
            "dropped": list(map(asdict, made.dropped)),
        },
        text=lambda: f"{escape_text(made.summary())}\n" if made.kept else "",
    )
