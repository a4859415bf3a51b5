from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.cli.table import index_ranges, stage_times


@pytest.mark.parametrize(
    ("idxs", "shown"),
    [
        ((), ""),
        ((0,), "0"),
        ((0, 2), "0, 2"),
        ((0, 1), "0, 1"),
        (range(4096), "0–4095"),
        ((0, 1, 2, 3, 8, 10, 11, 12), "0–3, 8, 10–12"),
    ],
)
def test_scene_indices_in_short(idxs: tuple[int, ...], shown: str) -> None:
    assert index_ranges(idxs) == shown


@given(st.sets(st.integers(0, 60)))
def test_short_indices_say_the_same(idxs: set[int]) -> None:
    read: list[int] = []
    for part in filter(None, index_ranges(sorted(idxs)).split(", ")):
        first, _, last = part.partition("–")
        read += range(int(first), int(last or first) + 1)
    assert read == sorted(idxs)


def test_stage_times_add_up() -> None:
    assert stage_times({"read": 0.0021, "build": 1.5}) == "read 2.1 ms, build 1.50 s; 1.50 s in all"
