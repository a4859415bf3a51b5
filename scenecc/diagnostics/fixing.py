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


def added(now: Sequence[Diagnostic], then: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Returns the findings that an edit adds; none of those that it moves to another line or path."""
    known, left = _counted(then), _counted(now)
    return [one for one in now if left[one.code, one.message] > known[one.code, one.message]]


def is_mended(now: Sequence[Diagnostic], then: Sequence[Diagnostic], found: Diagnostic) -> bool:
    """Returns whether a finding is gone, and whatever is new is of a later stage, which its error may have hidden."""
    if _counted(now)[found.code, found.message] >= _counted(then)[found.code, found.message]:
        return False
    new = (one for one in added(now, then) if one.severity in {"error", found.severity})
    return not any(_stage(one) <= _stage(found) for one in new)


def has_new_errors(now: Sequence[Diagnostic], then: Sequence[Diagnostic]) -> bool:
    """Returns whether an edit adds errors. Those of stages that did not run before do not count."""
    reached = max((_stage(one) for one in then if one.severity == "error"), default=len(STAGES))
    return any(one.severity == "error" and _stage(one) <= reached for one in added(now, then))


def _counted(every: Sequence[Diagnostic]) -> Counter[tuple[str, str]]:
    return Counter((one.code, one.message) for one in every)


def _stage(found: Diagnostic) -> int:
    if found.code in _PARSING:
        return -1
    return STAGES.index(found.stage) if found.stage in STAGES else len(STAGES)
