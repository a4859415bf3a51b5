"""`scenecc diff`."""

from __future__ import annotations

import sys
from dataclasses import asdict
from itertools import groupby
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from scenecc.cli.completion import complete_scene
from scenecc.cli.options import TableFormatOption, takes_compile_options
from scenecc.cli.output import Status, end, scene_errors
from scenecc.cli.paths import STDIN, path_faults, source_of
from scenecc.cli.tables import escape_text
from scenecc.diagnostics.formats import wants_color

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.plan.diff import Difference


_SIGNS: Final = {"added": "+", "removed": "-", "moved": ">", "changed": "~"}
_COLORS: Final = {"+": 32, "-": 31, ">": 33, "~": 33}


def differences_text(differences: Sequence[Difference], *, color: bool) -> str:
    """Returns one line per object, and below it one line per field. Empty if nothing differs.

    `+` marks what only the second has, `-` what only the first has, `~` a changed value, `>` another build order.
    """
    if not differences:
        return ""
    lines = [line for _, group in groupby(differences, _object) for line in _lines(list(group))]
    count = "1 difference" if len(differences) == 1 else f"{len(differences)} differences"
    shown = [f"\x1b[{_COLORS[sign]}m{sign} {text}\x1b[0m" if color else f"{sign} {text}" for sign, text in lines]
    return "\n".join([*shown, count]) + "\n"


def _object(one: Difference) -> tuple[str, str]:
    return one.section, one.name


def _lines(group: Sequence[Difference]) -> Iterator[tuple[str, str]]:
    name = _name(group[0])
    fields = [one for one in group if one.path]
    for one in group:
        if not one.path:
            yield _SIGNS[one.kind], f"{name}: {_values(one)}"
    if fields and len(fields) == len(group) and name:
        yield "~", name
    for one in fields:
        where = "" if one.scene_count is None else f" (in {one.scene_count} scene{'s' * (one.scene_count != 1)})"
        indent = "    " if name else ""
        yield _SIGNS[one.kind], f"{indent}{escape_text(one.path)}: {_values(one)}{where}"


def _name(one: Difference) -> str:
    if one.section == "plan":
        return ""
    return f"{one.section}.{escape_text(one.name)}" if one.name else one.section


def _values(one: Difference) -> str:
    """Returns both values; `unset` for the one that does not set the field."""
    if one.kind == "changed":
        return " → ".join("unset" if text is None else escape_text(text) for text in (one.a, one.b))
    return " → ".join(escape_text(text) for text in (one.a, one.b) if text is not None)


@takes_compile_options
def diff(
    first: Annotated[
        str,
        typer.Argument(
            metavar="A", help="A scene file or a plan, or - for standard input.", autocompletion=complete_scene
        ),
    ],
    second: Annotated[
        str, typer.Argument(metavar="B", help="The other scene file or plan.", autocompletion=complete_scene)
    ],
    *,
    form: TableFormatOption = "text",
    options: dict[str, Any],
) -> None:
    """Show the differences between two scenes.

    The command compares the plans object by object and field by field, so a different notation is not a difference,
    except of what a reset redraws. The options apply to both scenes.

    Exit status: 0 equal, 1 different, 2 wrong usage or an error in one of the scenes.

    \b
    Examples:
      scenecc diff scenes/tabletop.yaml scenes/obstacle.yaml
      git show HEAD:scenes/tabletop.yaml | scenecc diff - scenes/tabletop.yaml
    """
    import scenecc

    if first == second == STDIN:
        raise typer.BadParameter("standard input contains only one scene", param_hint="'B'")
    faults = [*path_faults(first, None), *path_faults(second, None)]
    if faults:
        end(faults, form, least=Status.usage)  # status 1 means that the scenes differ
    with scene_errors(options, form, least=Status.usage):
        a, b = (scenecc.open_scene(source_of(name), **options) for name in (first, second))
        comparison = a.diff(b)
    differences = comparison.differences
    end(
        comparison.diagnostics,
        form,
        data=lambda: {"differences": [asdict(difference) for difference in differences]},
        text=lambda: differences_text(differences, color=wants_color(sys.stdout)),
        least=Status.scene if differences else Status.fine,
    )
