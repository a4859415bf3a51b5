"""`scenecc prefabs`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from scenecc.cli.completion import complete_prefab
from scenecc.cli.options import TableFormatOption
from scenecc.cli.output import end, usage_error
from scenecc.cli.params import params_data, params_table
from scenecc.cli.tables import escape_text, table

if TYPE_CHECKING:
    from scenecc import PrefabRow

_HEAD = ("name", "description", "parameters")
_SHIPPED = "scenecc:"


def prefabs(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="A prefab, such as table or scenecc:table.", autocompletion=complete_prefab
        ),
    ] = None,
    *,
    form: TableFormatOption = "text",
) -> None:
    """List the built-in prefabs, or the parameters of one.

    \b
    Examples:
      scenecc prefabs
      scenecc prefabs table
      scenecc prefabs --format json
    """
    import scenecc

    rows = scenecc.list_prefabs()
    if name is not None:
        full = name if name.startswith(_SHIPPED) else _SHIPPED + name
        chosen = [row for row in rows if row.name == full]
        if not chosen:
            _refuse(name, [row.name for row in rows], form)
        rows = chosen
    text = _table if name is None else _one
    end([], form, data=lambda: {"prefabs": _data(rows)}, text=lambda: text(rows))


def _refuse(name: str, known: list[str], form: str) -> NoReturn:
    from scenecc.diagnostics.messages import cut, listed, nearest

    # The common prefix would make any word look similar.
    near = nearest(name.removeprefix(_SHIPPED), [other.removeprefix(_SHIPPED) for other in known])
    hint = listed(known, name, "`scenecc prefabs`") if near is None else f"did you mean `{_SHIPPED}{near}`?"
    unknown = usage_error("SC909", f"no prefab `{cut(name)}` ships with scenecc", hint=hint)
    end([unknown], form)


def _table(rows: Sequence[PrefabRow]) -> str:
    cells = [(row.name, escape_text(row.description), ", ".join(param.name for param in row.params)) for row in rows]
    return table(_HEAD, cells)


def _one(rows: Sequence[PrefabRow]) -> str:
    return f"{rows[0].name}: {rows[0].description}\n{_editions(rows[0])}\n{params_table(rows[0].params)}"


def _editions(row: PrefabRow) -> str:
    """Returns one line per package for which the prefab has its own edition; "" for most prefabs."""
    lines = [
        f"This is the edition for {package}, which is installed here."
        if package == row.edition
        else f"If {package} is installed, its edition is used."
        for package in row.editions
    ]
    return "".join(f"{line}\n" for line in lines)


def _data(rows: Sequence[PrefabRow]) -> list[dict[str, Any]]:
    return [
        {
            "name": row.name,
            "description": row.description,
            "editions": list(row.editions),
            "edition": row.edition,
            "parameters": params_data(row.params),
        }
        for row in rows
    ]
