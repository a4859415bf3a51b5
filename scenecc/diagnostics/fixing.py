"""Whether an edit of a text mends a finding, by the findings before and after it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

from scenecc.diagnostics.diagnostic import STAGES

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Diagnostic


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
    return not any(is_new(one) and stage_of(one) <= stage_of(found) for one in now)


def stage_of(found: Diagnostic) -> int:
    """Returns the number of the stage that reports a finding."""
    if found.code in _PARSING:
        return -1
    return STAGES.index(found.stage) if found.stage in STAGES else len(STAGES)
