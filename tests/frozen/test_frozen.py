"""Every scene of the repository gives what it gave before; `python -m tests.frozen` compares and updates."""

from __future__ import annotations

import pytest
from frozen import outputs


@pytest.mark.parametrize("name", outputs.FILES)
def test_scenes_give_what_they_gave(name: str) -> None:
    assert outputs.difference(name) == []


def test_the_last_bit_counts_where_the_arithmetic_is_the_same() -> None:
    kept = ["# arithmetic a", "scene seed=0 " + outputs._digests(str, "[0.1]")]
    made = ["# arithmetic a", "scene seed=0 " + outputs._digests(str, "[0.10000000000000002]")]
    assert outputs.compared(kept, made) == [f"- {kept[1]}", f"+ {made[1]}"]
    assert outputs.compared(["# arithmetic b", kept[1]], made) == []


@pytest.mark.parametrize(("before", "after"), [("[0.1]", "[0.100001]"), ("[1]", "[2]"), ("[1e-9]", "[2e-9]")])
def test_a_number_counts_on_every_machine(before: str, after: str) -> None:
    lines = [[f"# {text}", outputs._digests(str, text)] for text in (before, after)]
    assert len(outputs.compared(*lines)) == 2


def test_what_is_zero_but_for_rounding_is_zero() -> None:
    lines = [[f"# {text}", outputs._digests(str, text)] for text in ("[0.0]", "[-6.1e-17]")]
    assert outputs.compared(*lines) == []


def test_a_line_that_occurs_twice_counts_twice() -> None:
    line = "scene.yaml:1:1 error SC101"
    assert outputs.compared(["#", line], ["#", line, line]) == [f"+ {line}"]


def test_scenes_have_draws_that_a_reset_makes_anew() -> None:
    scene = outputs.ROOT / "scenes" / "reset.yaml"
    lines = list(outputs.flat({"resets": outputs._resets(outputs.open_scene(scene, num_scenes=2, seed=0).plan)}))
    assert any(line.startswith("resets.entities[2].pose seed=11[1]: [") for line in lines)
