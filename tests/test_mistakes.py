"""Plausible mistakes that a command reports stay reported, and good scenes are not blamed."""

from __future__ import annotations

from pathlib import Path

import pytest
from plugins.mistakes import CORPUS, Mistake, check_findings, codes_of, mistakes, static_findings

GOOD = [*sorted((CORPUS / "bases").glob("*.yaml")), *sorted((CORPUS / "good").glob("*.yaml"))]
BASES = sorted({mistake.base for mistake in mistakes()})

TOLD = 0.9
"""Share of the mistakes that `check --strict` is to report."""


def _missed(base: str, stages: set[str], *, simulated: bool) -> list[str]:
    """Names of the mistakes of a base scene that are reported no longer."""
    run = check_findings if simulated else static_findings
    asked: list[Mistake] = [one for one in mistakes() if one.base == base and one.stage in stages]
    return [one.name for one in asked if not codes_of(run(one.scene())) & one.codes]


@pytest.mark.parametrize("base", BASES)
def test_a_mistake_that_was_reported_before_a_build_still_is(base: str) -> None:
    assert _missed(base, {"validate", "static"}, simulated=False) == []


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_a_mistake_that_was_reported_by_a_simulation_still_is(base: str) -> None:
    assert _missed(base, {"check"}, simulated=True) == []


@pytest.mark.parametrize("file", GOOD, ids=lambda file: file.stem)
def test_a_good_scene_is_not_blamed(file: Path) -> None:
    assert codes_of(static_findings(str(file))) == set()


@pytest.mark.slow
@pytest.mark.parametrize("file", GOOD, ids=lambda file: file.stem)
def test_a_good_scene_is_not_blamed_after_a_simulation(file: Path) -> None:
    assert codes_of(check_findings(str(file))) == set()


def test_most_mistakes_are_reported() -> None:
    silent = [one.name for one in mistakes() if one.stage == "silent"]
    assert len(silent) <= (1 - TOLD) * len(mistakes()), silent
