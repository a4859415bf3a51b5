"""Applies corrections of findings to a text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import STAGES

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic


def with_fix(text: str, found: Diagnostic) -> str | None:
    """Returns the text with one correction; None if its place is not a whole key or list on one line.

    The text may already have other corrections after it.
    """
    if found.fix is None or (place := found.fix.location).line is None or place.column is None or not place.end_column:
        return None
    lines = text.split("\n")
    line = lines[place.line - 1] if place.line <= len(lines) else ""
    old, rest = line[place.column - 1 : place.end_column - 1], line[place.end_column - 1 :]
    is_list = found.fix.text.startswith("[")
    quote = old[:1] if old[:1] in {"'", '"'} and old[:1] == old[-1:] and not is_list else ""
    key = old[len(quote) : len(old) - len(quote)]
    is_same = place.text is not None and line[: place.end_column - 1] == place.text[: place.end_column - 1]
    if not is_same or not (old[:1] == "[" and old[-1:] == "]" if is_list else key.isidentifier()):
        return None
    lines[place.line - 1] = line[: place.column - 1] + quote + found.fix.text + quote + rest
    return "\n".join(lines)


def is_better(now: list[Diagnostic], then: list[Diagnostic], found: Diagnostic) -> bool:
    """Returns whether a finding is gone without a new one next to it on its line.

    Elsewhere on the line (a whole scene may be on one), new findings are allowed: this finding may have hidden them.
    """
    around = (found.path or "").rpartition(".")[0]

    def of_line(every: list[Diagnostic]) -> list[str]:
        return [one.code for one in every if one.line == found.line and (one.path or "").startswith(around)]

    return sorted([*of_line(now), found.code]) == sorted(of_line(then))


_PARSING = frozenset(("SC003", "SC004", "SC007"))
"""Errors that end the reading of the YAML."""


def is_mended(now: Sequence[Diagnostic], then: Sequence[Diagnostic], found: Diagnostic) -> bool:
    """Returns whether a finding is gone, and whatever is new is of a later stage, which its error may have hidden."""
    known, left = (Counter((one.code, one.message) for one in every) for every in (then, now))

    severities = {"error", found.severity}

    def is_new(one: Diagnostic) -> bool:
        return one.severity in severities and left[one.code, one.message] > known[one.code, one.message]

    if left[found.code, found.message] >= known[found.code, found.message]:
        return False
    return not any(is_new(one) and _stage(one) <= _stage(found) for one in now)


def _stage(found: Diagnostic) -> int:
    if found.code in _PARSING:
        return -1
    return STAGES.index(found.stage) if found.stage in STAGES else len(STAGES)
