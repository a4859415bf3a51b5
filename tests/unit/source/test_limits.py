"""Limits as a user gives them."""

from __future__ import annotations

import pytest

from scenecc.source import Limits, make_limits


def test_make_limits_without_changes_gives_the_defaults() -> None:
    assert make_limits() == make_limits({}) == Limits()
    assert Limits() == Limits(
        text_bytes=16 * 2**20,
        depth=100,
        alias_nodes=10_000,
        objects=130_000,
        scenes=65_536,
        asset_bytes=64 * 2**20,
    )
    assert Limits().objects_in_all_scenes == 13_000_000


def test_make_limits_changes_some_limits() -> None:
    assert make_limits({"depth": 7, "scenes": 8}) == Limits(depth=7, scenes=8)


@pytest.mark.parametrize("value", [0, -1, 1.5, "7", True, None, float("inf")])
def test_invalid_limit_values_are_refused(value: object) -> None:
    with pytest.raises(ValueError, match="depth must be a positive integer"):
        make_limits({"depth": value})


def test_the_depth_limit_cannot_exceed_that_of_the_parser() -> None:
    assert make_limits({"depth": 1000}).depth == 1000
    with pytest.raises(ValueError, match="depth must be at most 1000: the YAML parser reads no deeper"):
        make_limits({"depth": 1001})


def test_unknown_limit_names_are_refused() -> None:
    with pytest.raises(ValueError, match="did you mean `alias_nodes`"):
        make_limits({"alias_node": 1})
    with pytest.raises(ValueError, match="did you mean `depth`"):
        make_limits({"dept": 1})
    with pytest.raises(ValueError, match=r"the nearest here: [a-z, _]+ and 3 others"):
        make_limits({"zzz": 1})
