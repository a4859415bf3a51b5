"""`scenecc validate`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.checking import CHECK_OPTIONS, Check, ScenesOnly, run_checks
from scenecc.cli.corrections import corrected, summary
from scenecc.cli.options import FormatOption, ScenePaths, takes_compile_options
from scenecc.cli.output import of_settings, print_err, print_note
from scenecc.cli.paths import STDIN, find_files, source_of
from scenecc.simulation.summary import Checked

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic
    from scenecc.options import Options
    from scenecc.source.paths import PathCache


@partial(
    takes_compile_options,
    names=("num_scenes", "params", "starts", "asset_roots", "allow_outside_assets", "limits"),
    others=CHECK_OPTIONS,
)
def validate(
    paths: ScenePaths,
    *,
    form: FormatOption = "text",
    fix: Annotated[bool, typer.Option("--fix", help="Apply safe corrections to the files.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Print what --fix would change, on standard error.")] = False,
    scenes_only: ScenesOnly = False,
    options: dict[str, Any],
    others: dict[str, Any],
) -> None:
    """Check scene files without building them.

    In a folder, the command checks all scenes: .yaml and .yml files with the key `scenecc` at the top level, and packs.
    It counts and skips other .yaml and .yml files. A file named on the command line is always checked; with
    --scenes-only, only if it is a scene.

    \b
    Examples:
      scenecc validate scenes/tabletop.yaml
      scenecc validate --strict scenes --jobs 8
      scenecc validate --diff scenes/tabletop.yaml
      scenecc validate --ignore SC4 --statistics scenes
      scenecc validate --format sarif scenes > scenes.sarif
      scenecc validate scenes/parameters.yaml --set size=0.6
      cat scene.yaml | scenecc validate -
    """
    from scenecc.options import Options
    from scenecc.scene import validate_source

    asked = Options.of(**options)
    found = find_files(paths, scenes_only=scenes_only)

    def check(file: str, rules: Mapping[str, Rule], memory: PathCache | None) -> Checked:
        return Checked(of_settings(validate_source(source_of(file), asked, rules, memory), asked.params))

    if not (fix or diff):
        run_checks("validate", found, others, asked, check, form=form)
    _check_correctable(paths, others["jobs"], "--fix" if fix else "--diff")
    made: list[Diagnostic] | None = None if diff else []
    correct = partial(_correct, check, asked, made)
    try:
        run_checks("validate", found, {**others, "cache": False}, asked, correct, form=form, corrections=made)
    finally:
        print_note(summary(made or ()))


def _correct(
    check: Check,
    options: Options,
    made: list[Diagnostic] | None,
    file: str,
    rules: Mapping[str, Rule],
    memory: PathCache | None,
) -> Checked:
    """Checks and corrects a file. `made`: collects the corrections; None: they are printed, not written."""
    from scenecc.source.hint_edits import may_be_safe

    here = check(file, rules, memory)
    better = corrected(file, options) if any(map(may_be_safe, here.diagnostics)) else None
    if better is None:
        return here
    if made is None:
        print_err(better.diff())
        return here
    if (fault := better.write()) is not None:
        return Checked([fault, *here.diagnostics])
    made += better.corrections
    return check(file, rules, memory)


def _check_correctable(paths: list[str], jobs: int | None, option: str) -> None:
    if STDIN in paths:
        raise typer.BadParameter("standard input cannot be corrected: name a file", param_hint=f"'{option}'")
    if jobs is not None:
        raise typer.BadParameter("files are corrected one at a time", param_hint="'--jobs'")
