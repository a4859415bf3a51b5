"""`scenecc validate`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.checking import (
    IgnoreOption,
    SelectOption,
    StatisticsOption,
    StrictOption,
    run_checks,
    settings_finder,
)
from scenecc.cli.fixing import corrected, unified_diff, write_corrected
from scenecc.cli.options import Format, FormatOption, takes_compile_options
from scenecc.cli.output import counted, print_err
from scenecc.cli.paths import STDIN, find, source_of

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic


@partial(takes_compile_options, names=("num_scenes", "params", "asset_roots", "allow_outside_assets", "limits"))
def validate(
    paths: Annotated[
        list[str], typer.Argument(metavar="PATH...", help="Scene files, folders of them, or - for standard input.")
    ],
    *,
    form: FormatOption = Format.text,
    strict: StrictOption = False,
    select: SelectOption = None,
    ignore: IgnoreOption = None,
    statistics: StatisticsOption = False,
    fix: Annotated[bool, typer.Option("--fix", help="Correct what is safe to correct, in the files.")] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Show what --fix would change, on standard error.")] = False,
    scenes_only: Annotated[
        bool, typer.Option("--scenes-only", help="Skip named files that are not scenes (for commit hooks).")
    ] = False,
    options: dict[str, Any],
) -> None:
    """Check scene files without building them.

    In a folder, the command checks all scenes: .yaml and .yml files with the key `scenecc` at the
    top level. It counts and skips other YAML files. A file named on the command line is always
    checked, or with --scenes-only if it is a scene.

    \b
    Examples:
      scenecc validate scenes/tabletop.yaml
      scenecc validate --strict scenes
      scenecc validate --diff scenes/tabletop.yaml
      scenecc validate --ignore SC4 --statistics scenes
      scenecc validate --format sarif scenes > scenes.sarif
      scenecc validate scenes/parameters.yaml --set size=0.6
      cat scene.yaml | scenecc validate -
    """
    import scenecc

    finder = settings_finder(select, ignore, strict=strict)
    found = find(paths, scenes_only=scenes_only)

    def check(file: str, rules: Mapping[str, Rule] | None) -> list[Diagnostic]:
        here = scenecc.validate(source_of(file), rules=rules, **options)
        if not (fix or diff) or file == STDIN or not any(one.fix for one in here):
            return here
        changed = corrected(file, here, partial(_check_text, file, options))
        if changed is None:
            return here
        if diff:
            print_err(unified_diff(file, *changed))
            return here
        fault = write_corrected(file, changed[1])
        here = scenecc.validate(file, rules=rules, **options)
        return here if fault is None else [fault, *here]

    files = counted("validate", found.files)
    run_checks(found, files, check, finder, params=options["params"], form=form, statistics=statistics)


def _check_text(file: str, options: dict[str, Any], text: str) -> list[Diagnostic]:
    """Checks a text in the place of a file: what it names is beside the file."""
    import scenecc
    from scenecc.diagnostics import Sink
    from scenecc.source import read_text

    sink = Sink()
    document = read_text(text, file, sink, path=Path(file).absolute())
    return sink.diagnostics() if document is None else scenecc.validate(document, **options)
