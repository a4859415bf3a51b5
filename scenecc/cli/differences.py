"""What differs between two scenes, for people."""

from __future__ import annotations

from itertools import groupby
from typing import TYPE_CHECKING, Final

from scenecc.cli.table import plain

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from scenecc.questions import Difference

_SIGNS: Final = {"added": "+", "removed": "-", "moved": ">", "changed": "~"}
_COLORS: Final = {"+": 32, "-": 31, ">": 33, "~": 33}


def differences_text(differences: Sequence[Difference], *, color: bool) -> str:
    """An object a line, and below it a field a line: `+` what only the second has, `-` what only the first has,
    `~` what is another in them, `>` what is built at another time. Nothing where nothing differs.
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
        yield _SIGNS[one.kind], f"{indent}{plain(one.path)}: {_values(one)}{where}"


def _name(one: Difference) -> str:
    if one.section == "plan":
        return ""
    return f"{one.section}.{plain(one.name)}" if one.name else one.section


def _values(one: Difference) -> str:
    both = [plain(text) for text in (one.a, one.b) if text is not None]
    return " → ".join(both)
