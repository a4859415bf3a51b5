"""`scenecc validate`."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.options import Format, FormatOption, takes_compile_options
from scenecc.cli.output import counted, of_settings, print_err, print_findings, status, usage_error
from scenecc.cli.paths import Found, find, source_of

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


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
    diagnostics = _faults(found)
    for file in counted("validate", found.files):
        here = scenecc.validate(source_of(file), **options)
        diagnostics += of_settings(here, options["params"]) if options["params"] else here
    print_findings(diagnostics, form)
    if form is Format.text:
        print_err(_counts(found))
    raise typer.Exit(status(diagnostics, strict=strict))


def _faults(found: Found) -> list[Diagnostic]:
    return [
        *(usage_error("SC901", f"file or folder `{path}` not found", file=path) for path in found.missing),
        *(
            usage_error("SC902", f"no scene in the folder `{path}`", file=path, hint="a scene has the key `scenecc`")
            for path in found.empty
        ),
        *(
            usage_error("SC903", f"`{path}` cannot be read: {error.strerror}", file=path)
            for path, error in found.unreadable
        ),
    ]


def _counts(found: Found) -> str:
    checked, skipped = len(found.files), len(found.skipped)
    passed_over = f", {_files(skipped, 'other YAML file')} skipped" if skipped else ""
    return f"{_files(checked, 'file')} checked{passed_over}\n"


def _files(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
