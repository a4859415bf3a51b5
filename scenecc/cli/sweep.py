"""`scenecc sweep`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final, cast

import typer

from scenecc.cli.check import parse_seconds, parse_seeds
from scenecc.cli.checking import Parts, print_statistics, statistics, without_lacks
from scenecc.cli.completion import complete_scene, one_of
from scenecc.cli.many_files import parse_shard
from scenecc.cli.options import (
    Camera,
    TableFormatOption,
    at_least,
    quote_text,
    takes_compile_options,
)
from scenecc.cli.output import end, print_json, print_note, progress, scene_errors, status, usage_error
from scenecc.cli.paths import STDIN, find_files
from scenecc.cli.render_options import parse_size
from scenecc.cli.settings import ProjectSettings, SettingsFinder
from scenecc.diagnostics import Diagnostic, Severity
from scenecc.diagnostics.diagnostic import Location

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc import Sweep
    from scenecc.checks.house_rules import Rule

_DONE: Final = ("check", "render", "state")

_OPTIONS: Final = ("num_scenes", "params", "asset_roots", "allow_outside_assets", "limits")
"""The compile options without the seed; a sweep sets its own seeds."""


@dataclass(frozen=True, slots=True)
class _Wanted:
    """The findings that `check` would report for one of these files."""

    settings: ProjectSettings
    is_part: bool

    @property
    def rules(self) -> Mapping[str, Rule] | None:
        """House rules, by id."""
        return self.settings.rules

    def apply(self, diagnostics: list[Diagnostic], scene: str) -> list[Diagnostic]:
        """Returns the wanted diagnostics with the set severities."""
        return self.settings.apply(without_lacks(diagnostics) if self.is_part else diagnostics, scene)


def _find_scenes(paths: list[str], form: str) -> dict[str, _Wanted]:
    """Returns the files to sweep and their settings. Ends the command if a path or setting is wrong."""
    found = find_files(paths)
    faults = found.faults()
    if STDIN in found.files:
        faults.append(usage_error("SC901", "a sweep reads files, not standard input", file=STDIN, hint="name a file"))
    finder, parts = SettingsFinder(None, (), strict=False), Parts(found.files)
    wanted = {file: _Wanted(finder.of(file), file in parts) for file in found.files}
    if faults := [*faults, *finder.faults]:
        end(faults, form)
    return wanted


def _parse_do(text: str | tuple[str, ...]) -> tuple[str, ...]:
    if not isinstance(text, str):
        return text
    asked = [one.strip() for one in text.split(",")]
    for one in asked:
        if one not in _DONE:
            raise typer.BadParameter(f"{quote_text(one)} is not one of {', '.join(map(repr, _DONE))}")
    return tuple(asked)


Paths = Annotated[
    list[str], typer.Argument(metavar="PATH...", help="Scene files, or folders of them.", autocompletion=complete_scene)
]

Actions = Annotated[
    Any,
    typer.Option(
        "--do",
        metavar="WHAT",
        parser=_parse_do,
        help="What to do: any of check,render,state.",
        autocompletion=one_of(_DONE),
    ),
]


Settle = Annotated[
    float, typer.Option("--settle", metavar="SECONDS", parser=parse_seconds, help="Time to simulate in `check`.")
]


@partial(takes_compile_options, names=_OPTIONS)
def sweep(
    paths: Paths,
    *,
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Output folder for the table, pictures and log.")
    ],
    seeds: Annotated[
        Any, typer.Option("--seeds", metavar="A:B", parser=parse_seeds, help="Build with each seed from A to B-1.")
    ] = None,
    do: Actions = ("check", "state"),
    settle: Settle = 1.0,
    camera: Camera = None,
    size: Annotated[str | None, typer.Option("--size", metavar="WxH", help="Size of each picture [px].")] = None,
    jobs: Annotated[
        int, typer.Option("--jobs", "-j", metavar="N", parser=at_least(1), help="Number of processes.")
    ] = 1,
    ray: Annotated[bool, typer.Option("--ray", help="Use Ray on this machine.")] = False,
    ray_address: Annotated[
        str | None, typer.Option("--ray-address", metavar="HOST:PORT", help="Use the Ray cluster with this head node.")
    ] = None,
    shard: Annotated[
        Any, typer.Option("--shard", metavar="I/N", parser=parse_shard, help="Run only part I of N.")
    ] = None,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Check, build or render many seeds and scenes into one table.

    The table has one row per scene: file, parameters, seed, scene, draws, findings, poses, picture. To resume an
    interrupted sweep, run the same command again. Needs the extra `sweep`, or `ray`.

    \b
    Examples:
      scenecc sweep scenes/clutter.yaml --seeds 0:100 -o out --jobs 4
      scenecc sweep scenes --do check,render,state --size 320x240 -o out
      scenecc sweep scenes/clutter.yaml -o out --ray-address 10.0.0.1:6379
      scenecc sweep scenes/clutter.yaml --seeds 0:10000 -o out --shard 3/20
    """
    import scenecc

    wanted = _find_scenes(paths, form)
    with scene_errors(options, form), progress("sweep", clock=False) as show:
        result = scenecc.sweep(
            list(wanted),
            output=output,
            seeds=seeds,
            do=do,
            settle=settle,
            camera=camera,
            size=None if size is None else parse_size(size),
            jobs=jobs,
            ray=ray,
            ray_address=ray_address,
            shard=shard,
            progress=show,
            settings=wanted.__getitem__,
            **options,
        )
    _conclude(result, form, strict=any(one.settings.strict for one in wanted.values()))


def _conclude(result: Sweep, form: str, *, strict: bool) -> None:
    """Prints the findings and the path of the table, and exits with the status. `strict`: warnings count as errors."""
    table = None if result.table is None else str(result.table)
    if form == "json":
        done = {"table": table, "units": result.units, "done": result.done}
        print_json({**done, "statistics": statistics(result.counts)})
    else:
        print_statistics(result.counts)
        what = f"{result.done} of {result.units} units done"
        print_note(f"{what}; table in {table}\n" if table else f"{what}; the other parts are missing\n")
    found = [Diagnostic(code, cast("Severity", severity), "", Location(None)) for code, severity in result.counts]
    raise typer.Exit(status(found, strict=strict))
