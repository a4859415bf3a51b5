"""`scenecc coverage`."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.cover import SHOWN, missed_pairs, pair_records
from scenecc.cli.options import FormatOption, SceneArgument, takes_compile_options
from scenecc.cli.output import end, progress, scene_errors, usage_error
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text, table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc import SceneCoverage

_OPTIONS: Final = ("seed", "params", "asset_roots", "allow_outside_assets", "limits")


@partial(takes_compile_options, names=_OPTIONS)
def coverage(
    scene: SceneArgument,
    draws: Annotated[str, typer.Argument(metavar="DRAWS", help="What the episodes have drawn.", show_default=False)],
    *,
    require: Annotated[
        float | None,
        typer.Option("--require", metavar="PERCENT", min=0, max=100, help="Fail if fewer of the pairs are met."),
    ] = None,
    whole: Annotated[bool, typer.Option("--all", help="List all pairs.")] = False,
    form: FormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Print which pairs of alternatives a set of episodes never met.

    DRAWS is the output of `scenecc draws` (JSON, CSV or Parquet), the table of a sweep, starts, or a file with one JSON
    object per line, such as `info["draws"]` of an environment. Prints the pairs that no episode met, and the tenths
    of ranges in which no episode is. With --require, the exit status is 1 if fewer of the pairs are met.

    \b
    Examples:
      scenecc coverage scenes/variation.yaml draws.json
      scenecc coverage scenes/variation.yaml out/table.parquet --require 95
    """
    import scenecc

    source = checked_source(scene, form=form)
    try:
        with scene_errors(options, form), progress("coverage") as show:
            found = scenecc.scene_coverage(source, draws, progress=show, **options)
    except ImportError as error:
        from scenecc.extras import install_hint

        end([usage_error("SC828", f"a Parquet table needs pyarrow: {error}", hint=install_hint("sweep"))], form)
    diagnostics = list(found.diagnostics)
    if require is not None and found.share * 100 < require:
        message = f"the episodes have met {found.met} of {found.met + len(found.missed)} pairs, less than {require:g} %"
        diagnostics.append(replace(usage_error("SC947", message, file=scene), hint=None))
    end(
        diagnostics,
        form,
        data=lambda: {
            "episodes": found.episodes,
            "met": found.met,
            "total": found.met + len(found.missed),
            "missed": pair_records(found.missed),
            "impossible": pair_records(found.impossible),
            "factors": {
                name: [{"value": value, "episodes": count} for value, count in counts.items()]
                for name, counts in found.factors.items()
            },
            "ranges": {
                name: {"low": one.low, "high": one.high, "tenths": list(one.tenths)}
                for name, one in found.ranges.items()
            },
            "hidden": list(found.hidden),
        },
        text=lambda: _text(found, None if whole else SHOWN),
    )


def _text(found: SceneCoverage, most: int | None) -> str:
    total = found.met + len(found.missed)
    share = f" ({100 * found.share:.1f} %)" if total else ""
    many = found.episodes != 1
    lines = [f"{found.episodes} episode{'s' * many} met {found.met} of {total} pairs{share}\n"]
    never = [(name, value) for name, counts in found.factors.items() for value, count in counts.items() if not count]
    if never:
        lines.append(f"never drawn: {_some([f'{name} = {value}' for name, value in never], most)}\n")
    lines.append(missed_pairs(found.missed, most))
    rows = [
        (escape_text(name), f"{one.low:.4g} … {one.high:.4g}", _parts(one.empty))
        for name, one in found.ranges.items()
        if one.empty
    ]
    if rows:
        lines.append(table(("range", "values", "empty parts"), rows[:most]))
        lines.append(f"… {len(rows) - most} more\n" if most is not None and len(rows) > most else "")
    if found.ranges:
        lines.append(f"{len(found.ranges) - len(rows)} of {len(found.ranges)} ranges have no empty tenth\n")
    if found.impossible:
        lines.append(missed_pairs(found.impossible, most))
    if found.hidden:
        lines.append(f"not counted, since no drawn value shows it: {_some(found.hidden, most)}\n")
    return "".join(lines)


def _some(names: Sequence[str], most: int | None) -> str:
    shown = names[:most]
    return escape_text(", ".join([*shown, *([f"… {len(names) - len(shown)} more"] if len(shown) < len(names) else [])]))


def _parts(tenths: Sequence[int]) -> str:
    """Returns tenths as percentages, adjacent ones together."""
    runs: list[list[int]] = []
    for number in tenths:
        if runs and runs[-1][1] == number:
            runs[-1][1] = number + 1
        else:
            runs.append([number, number + 1])
    return ", ".join(f"{10 * low}–{10 * high} %" for low, high in runs)
