"""`scenecc check`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.checking import CHECK_OPTIONS, ScenesOnly, run_checks
from scenecc.cli.options import FormatOption, ScenePaths, Scenes, quote_text, takes_compile_options
from scenecc.cli.output import of_settings, progress
from scenecc.cli.paths import find_files, source_of

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.simulation.summary import Checked
    from scenecc.source.paths import PathCache

_SEEDS: Final = re.compile(r"([0-9]{1,18}):([0-9]{1,18})")
_SECONDS: Final = re.compile(r"[0-9]{1,4}(\.[0-9]{1,9})?")


def parse_seeds(text: str | range) -> range:
    """Parses `0:20`. Raises typer.BadParameter for anything else."""
    found = _SEEDS.fullmatch(str(text))
    if found is None or int(found[1]) >= int(found[2]):
        raise typer.BadParameter(f"{quote_text(str(text))} must be A:B with A below B, as in 0:20")
    return range(int(found[1]), int(found[2]))


def refuse_seed_beside(seeds: range | None, options: Mapping[str, Any]) -> None:
    """Raises typer.BadParameter if both `--seeds` and `--seed` are given."""
    if seeds is not None and options["seed"] is not None:
        raise typer.BadParameter("it cannot be combined with --seed", param_hint="'--seeds'")


def parse_seconds(text: str | float) -> float:
    """Parses `2.5`. Raises typer.BadParameter for anything else."""
    if not _SECONDS.fullmatch(str(text)):
        raise typer.BadParameter(f"{quote_text(str(text))} must be a time in seconds below 10 000, as in 2.5")
    return float(text)


@partial(takes_compile_options, others=CHECK_OPTIONS)
def check(
    paths: ScenePaths,
    *,
    settle: Annotated[
        float,
        typer.Option(
            "--settle",
            metavar="SECONDS",
            parser=parse_seconds,
            help="Time to simulate; longer if `expect` needs it. 0: only `expect`.",
        ),
    ] = 1.0,
    seeds: Annotated[
        Any, typer.Option("--seeds", metavar="A:B", parser=parse_seeds, help="Check each seed from A to B-1.")
    ] = None,
    scenes: Scenes = None,
    permute: Annotated[
        bool,
        typer.Option("--permute", help="Also check that scenes do not depend on others in the batch, bit for bit."),
    ] = False,
    scenes_only: ScenesOnly = False,
    form: FormatOption = "text",
    options: dict[str, Any],
    others: dict[str, Any],
) -> None:
    """Check scene files, then build and simulate all of their scenes.

    Reports everything that `validate` reports. It also reports bodies that overlap at the start, lack support,
    topple, sink or fly away, robot links that collide, and robots that sag. Each finding names the scene where it is
    worst and the command that shows this scene.

    \b
    Examples:
      scenecc check scenes/tabletop.yaml
      scenecc check scenes/clutter.yaml --seeds 0:20
      scenecc check scenes/clutter.yaml --seed 7 --scene 3
      scenecc check --settle 0 --strict scenes --jobs 8
      scenecc check scenes/clutter.yaml --permute
    """
    from scenecc.options import Options
    from scenecc.simulation.check import check_source

    refuse_seed_beside(seeds, options)
    asked = Options.of(**options)
    found = find_files(paths, scenes_only=scenes_only)
    # Many files get a separate process: SAPIEN keeps some memory of every scene, and can crash its process.
    others["jobs"] = others["jobs"] or int(len(found.files) > 1)

    runs = settle, seeds, scenes

    def check_file(file: str, rules: Mapping[str, Rule], memory: PathCache | None) -> Checked:
        with progress("check", where=others["jobs"] == 0) as show:
            here = check_source(
                source_of(file), asked, *runs, rules=rules, progress=show, memory=memory, permute=permute
            )
        return replace(here, diagnostics=of_settings(here.diagnostics, asked.params))

    run_checks("check", found, others, (asked, runs, permute), check_file, form=form)
