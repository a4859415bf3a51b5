"""`scenecc cover`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.options import FormatOption, SceneArgument, at_least, takes_compile_options
from scenecc.cli.output import STDOUT, end, scene_errors, usage_error, write_files
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc import SceneCover
    from scenecc.coverage.cover import MissedPair

_OPTIONS: Final = ("seed", "params", "asset_roots", "allow_outside_assets", "limits")
"""The compile options without the number of scenes and the starts, which this command makes."""

SHOWN: Final = 10
"""Most missed pairs that are listed."""


@partial(takes_compile_options, names=_OPTIONS)
def cover(
    scene: SceneArgument,
    *,
    pairwise: Annotated[bool, typer.Option("--pairwise", help="Meet all pairs of alternatives; the default.")] = False,
    sobol: Annotated[
        int | None,
        typer.Option("--sobol", metavar="N", parser=at_least(1), help="N scenes that fill everything evenly instead."),
    ] = None,
    output: Annotated[
        str | None, typer.Option("--output", "-o", metavar="STARTS.json", help="Write the scenes here, as starts.")
    ] = None,
    form: FormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Choose few scenes that meet every pair of what a file draws.

    Alternatives are the items of `choice` and `cycle`, and up to 64 `integers`. Every two of them that can occur
    together do so in one of the scenes. Ranges are filled evenly. With `starts: STARTS.json` in the scene, or --starts,
    exactly these values are drawn. Without -o, the scenes are printed.

    \b
    Examples:
      scenecc cover scenes/draws.yaml
      scenecc cover scenes/variation.yaml --pairwise -o starts.json
      scenecc cover scenes/variation.yaml --sobol 64 -o starts.json
    """
    import scenecc

    if pairwise and sobol is not None:
        raise typer.BadParameter("give either --pairwise or --sobol", param_hint="'--sobol'")
    if output is not None and (output == STDOUT or not output.lower().endswith(".json")):
        raise typer.BadParameter("it must be a file NAME.json", param_hint="'--output'")
    source = checked_source(scene, output, form)
    try:
        with scene_errors(options, form):
            made = scenecc.cover_scene(source, sobol=sobol, **options)
    except ImportError as error:
        from scenecc.extras import install_hint

        reason = f"--sobol needs scipy: {error}"
        end([usage_error("SC828", reason, hint=install_hint("import"))], form)
    if output is not None:
        try:
            reason = write_files(output, made.files(Path(output).name), folder=False)
        except ImportError as error:
            from scenecc.extras import install_hint

            reason = "SC813", f"starts above 1 MB need pyarrow: {error}; {install_hint('sweep')}"
        if reason is not None:
            end([*made.diagnostics, usage_error(*reason, file=output)], form)
    end(
        made.diagnostics,
        form,
        data=lambda: {
            "starts": output,
            "num_scenes": len(made.rows),
            "factors": {name: list(values) for name, values in made.factors.items()},
            "ranges": list(made.ranges),
            "met": made.met,
            "total": made.met + len(made.missed),
            "missed": pair_records(made.missed),
            "rows": [dict(row) for row in made.rows],
        },
        text=lambda: ("" if output is not None else _rows(made)) + _summary(made, sobol),
    )


def _rows(made: SceneCover) -> str:
    from scenecc.plan.display import format_item

    def cell(value: Any) -> str:
        return escape_text(value if isinstance(value, str) else format_item(value))

    rows = [
        (str(scene), *(cell(row[name]) if name in row else "" for name in made.factors))
        for scene, row in enumerate(made.rows)
    ]
    return table(("scene", *map(escape_text, made.factors)), rows) if made.factors else ""


def _summary(made: SceneCover, sobol: int | None) -> str:
    """Returns the numbers of scenes, pairs and ranges, and the missed pairs."""
    count, total = len(made.rows), made.met + len(made.missed)
    of_one = next(iter(made.factors.values()), ())
    met = f"{made.met} of {total} pairs" if len(made.factors) > 1 else f"{len(of_one)} alternatives"
    lines = [f"{count} scene{'s' * (count != 1)} meet{'s' * (count == 1)} {met}"]
    if made.ranges:
        lines[0] += f" and fill{'s' * (count == 1)} {len(made.ranges)} range{'s' * (len(made.ranges) != 1)}"
    if sobol is not None and sobol & (sobol - 1):
        lines.append(f"{sobol} is not a power of two, for which a Sobol sequence fills most evenly")
    return "\n".join(lines) + "\n" + missed_pairs(made.missed)


def missed_pairs(missed: Sequence[MissedPair]) -> str:
    """Returns pairs by the reason why they were not met, the first ones of each."""
    groups: dict[tuple[str, str], list[MissedPair]] = {}
    for one in missed:
        groups.setdefault((one.why, one.by), []).append(one)
    lines: list[str] = []
    for (why, by), pairs in groups.items():
        many = len(pairs) != 1
        place = f", by {escape_text(by)}" if by else ""
        words = {
            "excluded": f"cannot occur{place}",
            "not found": f"{'were' if many else 'was'} found in no scene that can be built",
        }.get(why, f"{'are' if many else 'is'} {why}")
        lines.append(f"{len(pairs)} pair{'s' * many} {words}:")
        lines += [f"  {_named(one.first)}, {_named(one.second)}" for one in pairs[:SHOWN]]
        lines += [f"  … {len(pairs) - SHOWN} more"] if len(pairs) > SHOWN else []
    return "".join(f"{line}\n" for line in lines)


def pair_records(missed: Sequence[MissedPair]) -> list[dict[str, Any]]:
    """Returns pairs as plain data."""
    return [{"pair": [list(one.first), list(one.second)], "why": one.why, "by": one.by} for one in missed]


def _named(level: tuple[str, Any]) -> str:
    from scenecc.plan.display import format_item

    name, value = level
    return escape_text(f"{name} = {value if isinstance(value, str) else format_item(value)}")
