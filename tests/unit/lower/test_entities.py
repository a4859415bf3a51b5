"""Which scenes an entity is in."""

from __future__ import annotations

import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.nightly import assert_took
from unit.lower.scenes import codes, compiled, entity, scene

PLACE = "entities.body.scene_idxs"


def selected(idxs: Any, num_scenes: int = 8) -> tuple[int, ...]:
    return entity(compiled({"scene_idxs": idxs}, num_scenes=num_scenes)).scene_idxs


@pytest.mark.parametrize(
    ("idxs", "expected"),
    [
        ([0], (0,)),
        ([7, 3], (3, 7)),
        ("0:8", tuple(range(8))),
        (":", tuple(range(8))),
        ("::2", (0, 2, 4, 6)),
        ("1::3", (1, 4, 7)),
        ("4:", (4, 5, 6, 7)),
        (":3", (0, 1, 2)),
        ("-2:", (6, 7)),
        (":-6", (0, 1)),
        ("-8:-7", (0,)),
        ("::-1", tuple(range(8))),
        ("6:2:-2", (4, 6)),
        (" 1 : 3 ", (1, 2)),
        ([5, "0:2", "6:"], (0, 1, 5, 6, 7)),
        (["::2", "1::2"], tuple(range(8))),
    ],
    ids=str,
)
def test_selection(idxs: Any, expected: tuple[int, ...]) -> None:
    assert selected(idxs) == expected


def test_left_out_is_every_scene() -> None:
    assert entity(compiled(num_scenes=3)).scene_idxs == (0, 1, 2)


BOUND = st.none() | st.integers(-10, 10)


@given(BOUND, BOUND, st.none() | st.integers(-4, 4), st.integers(1, 8))
def test_a_slice_is_pythons_within_its_bounds(start: Any, stop: Any, step: Any, num_scenes: int) -> None:
    text = f"{'' if start is None else start}:{'' if stop is None else stop}{'' if step is None else f':{step}'}"
    found = codes(scene({"scene_idxs": text}, num_scenes=num_scenes))
    bounds = [bound for bound in (start, stop) if bound is not None]
    if step == 0:
        assert found == [("SC310", PLACE)]
    elif any(not -num_scenes <= bound <= num_scenes for bound in bounds):
        assert found == [("SC307", PLACE)]
    elif not range(num_scenes)[start:stop:step]:
        assert found == [("SC309", PLACE)]
    else:
        assert selected(text, num_scenes) == tuple(sorted(range(num_scenes)[start:stop:step]))


@pytest.mark.parametrize(
    ("idxs", "expected"),
    [
        ([8], [("SC307", PLACE + "[0]")]),
        ([0, -1], [("SC307", PLACE + "[1]")]),
        ([0, 1, 0], [("SC308", PLACE + "[2]")]),
        (["0:3", "2:4"], [("SC308", PLACE + "[1]")]),
        ([], [("SC309", PLACE)]),
        ("3:3", [("SC309", PLACE)]),
        ("", [("SC104", PLACE)]),
        ("1", [("SC310", PLACE)]),
        ("a:b", [("SC310", PLACE)]),
        ("1:2:3:4", [("SC310", PLACE)]),
        ("1e1:", [("SC310", PLACE)]),
        (["0:9", 99, "x"], [("SC307", PLACE + "[0]"), ("SC307", PLACE + "[1]"), ("SC310", PLACE + "[2]")]),
        ("٣:", [("SC310", PLACE)]),
    ],
    ids=str,
)
def test_mistakes(idxs: Any, expected: list[tuple[str, str]]) -> None:
    assert codes(scene({"scene_idxs": idxs}, num_scenes=8)) == expected


def test_the_override_decides_what_is_out_of_range() -> None:
    document = scene({"scene_idxs": [5]}, num_scenes=2)
    assert codes(document) == [("SC307", PLACE + "[0]")]
    assert codes(document, num_scenes=6) == []


@pytest.mark.parametrize("idxs", [["::1"] * 65_536, [65_535] + ["::1"] * 65_536, list(range(65_536)) * 4], ids=len)
def test_a_long_list_of_repeats_takes_no_long_time(idxs: list[Any]) -> None:
    started = time.process_time()
    found = codes(scene({"scene_idxs": idxs}, num_scenes=65_536))
    assert {code for code, _ in found} <= {"SC308", "SC016"}
    assert found[0][0] == "SC308"
    assert_took(time.process_time() - started, most=5)
