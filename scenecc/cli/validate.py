"""`scenecc validate`."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

import typer

from scenecc.cli.options import Format, FormatOption, takes_compile_options
from scenecc.cli.output import counted, of_settings, print_err, print_findings, status
from scenecc.cli.paths import find, source_of


@partial(takes_compile_options, names=("num_scenes", "params", "asset_roots", "allow_outside_assets", "limits"))
def validate(
    paths: Annotated[
        list[str], typer.Argument(metavar="PATH...", help="Scene files, folders of them, or - for standard input.")
    ],
    *,
    form: FormatOption = Format.text,
    strict: Annotated[bool, typer.Option("--strict", help="Treat warnings as errors.")] = False,
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
      scenecc validate --format sarif scenes > scenes.sarif
      scenecc validate scenes/parameters.yaml --set size=0.6
      cat scene.yaml | scenecc validate -
    """
    import scenecc

    found = find(paths, scenes_only=scenes_only)
    diagnostics = found.faults()
    for file in counted("validate", found.files):
        here = scenecc.validate(source_of(file), **options)
        diagnostics += of_settings(here, options["params"]) if options["params"] else here
    print_findings(diagnostics, form)
    if form is Format.text:
        print_err(found.counts())
    raise typer.Exit(status(diagnostics, strict=strict))
