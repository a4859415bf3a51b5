"""`scenecc params`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from scenecc.cli.options import SceneArgument, TableFormatOption, takes_compile_options
from scenecc.cli.output import end, scene_errors
from scenecc.cli.paths import checked_source
from scenecc.cli.tables import escape_text, table

if TYPE_CHECKING:
    from scenecc import ParamRow

_HEAD = ("name", "type", "default", "range", "description")


@partial(takes_compile_options, names=("asset_roots", "allow_outside_assets", "limits"))
def params(
    scene: SceneArgument,
    *,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """List the parameters of a scene. --set sets them.

    \b
    Examples:
      scenecc params scenes/parameters.yaml
      scenecc params scenes/parameters.yaml --format json
    """
    import scenecc

    source = checked_source(scene, form=form)
    with scene_errors(options, form):
        rows = scenecc.list_params(source, **options)
    end([], form, data=lambda: {"parameters": params_data(rows)}, text=lambda: params_table(rows))


def params_table(rows: Sequence[ParamRow]) -> str:
    """Returns one line per parameter. A required parameter has a dash as its default."""
    if not rows:
        return "no parameters\n"
    cells = [
        tuple(
            map(
                escape_text,
                (row.name, row.type, "–" if row.default is None else row.default, row.range, row.description),
            )
        )
        for row in rows
    ]
    return table(_HEAD, cells)


def params_data(rows: Sequence[ParamRow]) -> list[dict[str, Any]]:
    """Returns the parameters for programs. Missing properties are left out, such as the default of a required one."""
    found = [
        {
            "name": row.name,
            "type": row.type,
            "default": row.value,
            "min": row.low,
            "max": row.high,
            "options": list(row.options) or None,
            "description": row.description,
        }
        for row in rows
    ]
    return [{key: value for key, value in item.items() if value is not None} for item in found]
