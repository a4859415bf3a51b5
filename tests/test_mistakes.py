"""Plausible mistakes that a command reports stay reported, and good scenes are not blamed."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest
from plugins.mistakes import CORPUS, Mistake, check_findings, codes_of, mistakes, static_findings

GOOD = [*sorted((CORPUS / "bases").glob("*.yaml")), *sorted((CORPUS / "good").glob("*.yaml"))]
BASES = sorted({mistake.base for mistake in mistakes()})

TOLD: Final = 0.9
"""Share of the mistakes that `check --strict` is to report."""


QUICK: Final = 12
"""One of so many mistakes is in the quick tests."""


def _missed(asked: list[Mistake], *, simulated: bool = False) -> list[str]:
    """Names of the mistakes that are reported no longer."""
    run = check_findings if simulated else static_findings
    return [one.name for one in asked if not codes_of(run(one.scene())) & one.codes]


def _of_stages(*stages: str) -> list[Mistake]:
    return [one for one in mistakes() if one.stage in stages]


@pytest.mark.parametrize("first", [0, 4, 8])
def test_some_mistakes_that_were_reported_before_a_build_still_are(first: int) -> None:
    assert _missed(_of_stages("validate", "static")[first :: 3 * QUICK]) == []


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_a_mistake_that_was_reported_before_a_build_still_is(base: str) -> None:
    assert _missed([one for one in _of_stages("validate", "static") if one.base == base]) == []


@pytest.mark.slow
def test_a_mistake_that_was_reported_by_a_simulation_still_is() -> None:
    assert _missed(_of_stages("check"), simulated=True) == []


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
