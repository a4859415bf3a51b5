"""`scenecc validate`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
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
from scenecc.cli.options import Format, FormatOption, takes_compile_options
from scenecc.cli.output import counted
from scenecc.cli.paths import find, source_of

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
      scenecc validate --ignore SC4 --statistics scenes
      scenecc validate --format sarif scenes > scenes.sarif
      scenecc validate scenes/parameters.yaml --set size=0.6
      cat scene.yaml | scenecc validate -
    """
    import scenecc

    finder = settings_finder(select, ignore, strict=strict)
    found = find(paths, scenes_only=scenes_only)

    def check(file: str, rules: Mapping[str, Rule] | None) -> list[Diagnostic]:
        return scenecc.validate(source_of(file), rules=rules, **options)

    files = counted("validate", found.files)
    run_checks(found, files, check, finder, params=options["params"], form=form, statistics=statistics)
