"""`scenecc validate`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.checking import CHECK_OPTIONS, run_checks
from scenecc.cli.fixing import corrected, unified_diff, write_corrected
from scenecc.cli.options import Format, FormatOption, takes_compile_options
from scenecc.cli.output import of_settings, print_err
from scenecc.cli.paths import STDIN, find, source_of

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic
    from scenecc.options import Options
    from scenecc.source.paths import PathCache


@partial(
    takes_compile_options,
    names=("num_scenes", "params", "asset_roots", "allow_outside_assets", "limits"),
    others=CHECK_OPTIONS,
)
def validate(
    paths: Annotated[
        list[str], typer.Argument(metavar="PATH...", help="Scene files, folders of them, or - for standard input.")
    ],
    *,
    form: FormatOption = Format.text,
    fix: Annotated[bool, typer.Option("--fix", help="Correct what is safe to correct, in the files.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Show what --fix would change, on standard error.")] = False,
    scenes_only: Annotated[
        bool, typer.Option("--scenes-only", help="Skip named files that are not scenes (for commit hooks).")
    ] = False,
    options: dict[str, Any],
    others: dict[str, Any],
) -> None:
    """Check scene files without building them.

    In a folder, the command checks all scenes: .yaml and .yml files with the key `scenecc` at the
    top level. It counts and skips other YAML files. A file named on the command line is always
    checked, or with --scenes-only if it is a scene.

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

    found = find(paths, scenes_only=scenes_only)

    def check(file: str, rules: Mapping[str, Rule], memory: PathCache | None) -> list[Diagnostic]:
        return of_settings(validate_source(source_of(file), asked, rules, memory), asked.params)

    def correct(file: str, rules: Mapping[str, Rule], memory: PathCache | None) -> list[Diagnostic]:
        here = check(file, rules, memory)
        if file == STDIN or not any(one.fix for one in here):
            return here
        changed = corrected(file, here, partial(_check_text, file, asked))
        if changed is None:
            return here
        if diff:
            print_err(unified_diff(file, *changed))
            return here
        fault = write_corrected(file, changed[1])
        here = check(file, rules, memory)
        return here if fault is None else [fault, *here]

    if fix or diff:
        if others["jobs"] is not None:
            raise typer.BadParameter("files are corrected one after the other", param_hint="'--jobs'")
        others["cache"] = False
    run_checks("validate", found, others, asked, correct if fix or diff else check, form=form)


def _check_text(file: str, options: Options, text: str) -> list[Diagnostic]:
    """Checks a text in the place of a file: what it names is beside the file."""
    from scenecc.diagnostics import Sink
    from scenecc.scene import validate_source
    from scenecc.source import read_text

    sink = Sink()
    document = read_text(text, file, sink, path=Path(file).absolute())
    return sink.diagnostics() if document is None else validate_source(document, options, {}, None)
