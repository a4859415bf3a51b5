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
from scenecc.cli.many_files import FileChoices
from scenecc.cli.options import ChangedSince, Format, FormatOption, Jobs, Shard, UseCache, takes_compile_options
from scenecc.cli.output import of_settings
from scenecc.cli.paths import find, source_of

if TYPE_CHECKING:
    from scenecc.checks.house_rules import Rule
    from scenecc.diagnostics import Diagnostic
    from scenecc.source.paths import PathCache


@partial(takes_compile_options, names=("num_scenes", "params", "asset_roots", "allow_outside_assets", "limits"))
def validate(
    paths: Annotated[
        list[str], typer.Argument(metavar="PATH...", help="Scene files, folders of them, or - for standard input.")
    ],
    *,
    form: FormatOption = Format.text,
    jobs: Jobs = None,
    shard: Shard = None,
    changed_since: ChangedSince = None,
    cache: UseCache = True,
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
      scenecc validate --strict scenes --jobs 8
      scenecc validate --ignore SC4 --statistics scenes
      scenecc validate --format sarif scenes > scenes.sarif
      scenecc validate scenes/parameters.yaml --set size=0.6
      cat scene.yaml | scenecc validate -
    """
    from scenecc.options import Options
    from scenecc.scene import validate_source

    asked = Options.of(**options)

    finder = settings_finder(select, ignore, strict=strict)
    found = find(paths, scenes_only=scenes_only)

    def check_file(file: str, rules: Mapping[str, Rule], memory: PathCache | None) -> list[Diagnostic]:
        return of_settings(validate_source(source_of(file), asked, rules, memory), asked.params)

    choices = FileChoices(jobs or 0, shard, changed_since, cache)
    run_checks("validate", found, choices, asked, check_file, finder, form=form, statistics=statistics)
