"""`scenecc coverage`."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.cover import SHOWN, missed_pairs, pair_records
from scenecc.cli.options import FormatOption, SceneArgument, takes_compile_options
from scenecc.cli.output import end, scene_errors, usage_error
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text

if TYPE_CHECKING:
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
    form: FormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Print the pairs of alternatives that episodes never met.

    DRAWS is the output of `scenecc draws` (JSON, CSV or Parquet), the table of a sweep, starts, or a file with one JSON
    object per line, such as `info["draws"]` of an environment. Prints the first pairs that no episode met;
    --format json lists all. With --require, the exit status is 1 if fewer of the pairs are met.

    \b
    Examples:
      scenecc coverage scenes/variation.yaml draws.json
      scenecc coverage scenes/variation.yaml out/table.parquet --require 95
    """
    import scenecc

    source = checked_source(scene, form=form)
    try:
        with scene_errors(options, form):
            found = scenecc.scene_coverage(source, draws, **options)
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
            "hidden": list(found.hidden),
        },
        text=lambda: _text(found),
    )


def _text(found: SceneCoverage) -> str:
    total = found.met + len(found.missed)
    share = f" ({100 * found.share:.1f} %)" if total else ""
    many = found.episodes != 1
    lines = [f"{found.episodes} episode{'s' * many} met {found.met} of {total} pairs{share}\n"]
    counts = [(f"{name} = {value}", count) for name, values in found.factors.items() for value, count in values.items()]
    for words, names in (
        ("never drawn", [name for name, count in counts if not count]),
        ("not counted, since no drawn value shows it", found.hidden),
    ):
        if names:
            more = [f"… {len(names) - SHOWN} more"] if len(names) > SHOWN else []
            lines.append(f"{words}: {escape_text(', '.join([*names[:SHOWN], *more]))}\n")
    return "".join([*lines, missed_pairs(found.missed), missed_pairs(found.impossible)])
