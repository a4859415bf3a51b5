"""The judge of `benchmarks.teaching`, on faults that are written here."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def teaching() -> Any:
    """The module of the judge."""
    sys.path.insert(0, str(ROOT))
    from benchmarks.teaching import judge

    return judge


def case(teaching: Any, kind: str, old: str, new: str, codes: str) -> Any:
    """A fault in `scenes/tabletop.yaml`."""
    scene = teaching.SceneText(ROOT / "scenes/tabletop.yaml")
    at = scene.text.index(old)
    return teaching.Case(scene, kind, teaching.Fault("", (teaching.Edit(at, at + len(old), new),), (at,), codes))


@pytest.mark.parametrize(
    ("kind", "old", "new", "codes", "outcome", "is_right_line", "fixed"),
    [
        ("key", "half_size: [0.6", "halfSize: [0.6", "SC101", "error", True, True),
        ("name", "material: rubber", "material: ruber", "SC301", "error", True, True),
        ("name", "material: rubber", "material: ruber", "SC5", "missed", False, False),
        ("unit", "rpy_deg: [0, 0, 30]", "rpy: [0, 0, 30]", "SC526", "warning", True, True),
        ("number", "radius: 0.05", "radius: -0.05", "SC104", "error", True, True),
        ("structure", "visual: {base", "visual {base", "SC003", "error", True, True),
        ("structure", "body_type: kinematic", "body_type:", "SC006", "error", True, False),
        ("unit", "density: 1100", "density: 1.1", "SC53", "missed", False, False),
    ],
)
def test_a_fault_is_judged_by_what_validate_says(
    kind: str, old: str, new: str, codes: str, outcome: str, is_right_line: bool, fixed: bool, teaching: Any
) -> None:
    found = teaching.judge(case(teaching, kind, old, new, codes), simulate=False)
    assert (found.outcome, found.is_right_line, found.fixed) == (outcome, is_right_line, fixed)
    assert found.is_legal == (new == "density: 1.1")


def test_a_fault_without_effect_is_none(teaching: Any) -> None:
    assert teaching.is_same(case(teaching, "number", "radius: 0.05", "radius: 0.050", ""))
    assert not teaching.is_same(case(teaching, "number", "radius: 0.05", "radius: 0.051", ""))


def test_lines_follow_edits_before_them(teaching: Any) -> None:
    fault = case(teaching, "key", "radius: 0.05", "radiu: 0.05", "").fault
    text = (ROOT / "scenes/tabletop.yaml").read_text()
    (line,) = teaching.lines_of(text, fault, fault.edits)
    assert "radius: 0.05" in text.splitlines()[line - 1]
    assert teaching.lines_of(text, fault, (*fault.edits, teaching.Edit(0, 0, "\n"))) == {line + 1}


def test_a_seed_always_draws_the_same_faults(teaching: Any) -> None:
    drawn = [[one.text for one in teaching.draw_cases(7, 6)] for _ in range(2)]
    assert drawn[0] == drawn[1]
