"""`scenecc validate`."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from scenecc.cli.checking import CHECK_OPTIONS, run_checks
from scenecc.cli.completion import complete_scene
from scenecc.cli.options import Format, FormatOption, takes_compile_options
from scenecc.cli.output import of_settings, print_err, usage_error, write
from scenecc.cli.paths import STDIN, find, source_of
from scenecc.diagnostics.fixing import is_better, with_fix
from scenecc.files import open_regular

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
        list[str],
        typer.Argument(
            metavar="PATH...",
            help="Scene files, folders of them, or - for standard input.",
            autocompletion=complete_scene,
        ),
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
    top level, and packs. It counts and skips other files of these names. A file named on the command line is always
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
        if not any(one.fix for one in here):
            return here
        changed = _corrected(file, partial(_check_text, file, asked))
        if changed is None:
            return here
        if diff:
            print_err(_unified_diff(file, *changed))
            return here
        fault = _write_corrected(file, changed[1])
        here = check(file, rules, memory)
        return here if fault is None else [fault, *here]

    if fix or diff:
        if STDIN in paths:
            option = "'--fix'" if fix else "'--diff'"
            raise typer.BadParameter("standard input cannot be corrected: name a file", param_hint=option)
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


Check = Callable[[str], "list[Diagnostic]"]
"""What checks a text as if it were the file's."""


def _corrected(file: str, check: Check) -> tuple[str, str] | None:
    """The text of a file before and after its corrections; None where there is none to make.

    A correction that leads to a new error, or does not remove its finding, is not made. A stage whose mistakes are
    corrected lets the next one find its own.
    """
    with open_regular(file) as stream:
        before = text = stream.read().decode("utf-8", errors="surrogateescape")
    then, last = check(text), ""
    while text != last:
        last = text
        tried = [one for one in then if one.fix is not None and one.file == one.fix.location.file == file]
        for found in sorted(tried, key=lambda one: (one.line or 0, one.column or 0), reverse=True):
            changed = with_fix(text, found)
            now = then if changed is None else check(changed)
            if changed is not None and is_better(now, then, found):
                text, then = changed, now
    return None if text == before else (before, text)


def _unified_diff(file: str, before: str, after: str) -> str:
    """The change as `diff -u` shows it."""
    lines = difflib.unified_diff(before.splitlines(keepends=True), after.splitlines(keepends=True), file, file)
    return "".join(line if line.endswith("\n") else line + "\n" for line in lines)


def _write_corrected(file: str, text: str) -> Diagnostic | None:
    """Writes a file whole or not at all; the finding where that fails."""
    fault = write(str(Path(file)), text.encode("utf-8", errors="surrogateescape"))
    return None if fault is None else usage_error(*fault, file=file)
