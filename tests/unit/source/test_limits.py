"""Limits as a user gives them."""

from __future__ import annotations

import pytest

from scenecc.source import Limits, make_limits


def test_the_defaults_are_those_of_the_language() -> None:
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


def test_some_are_changed() -> None:
    assert make_limits({"depth": 7, "scenes": 8}) == Limits(depth=7, scenes=8)


@pytest.mark.parametrize("value", [0, -1, 1.5, "7", True, None, float("inf")])
def test_values_that_are_no_limit(value: object) -> None:
    with pytest.raises(ValueError, match="depth must be a positive integer"):
        make_limits({"depth": value})


def test_no_limit_lets_a_text_be_deeper_than_its_parser_reads() -> None:
    assert make_limits({"depth": 1000}).depth == 1000
    with pytest.raises(ValueError, match="depth must be at most 1000: the YAML parser reads no deeper"):
        make_limits({"depth": 1001})


def test_unknown_names() -> None:
    with pytest.raises(ValueError, match="did you mean 'alias_nodes'"):
        make_limits({"alias_node": 1})
    with pytest.raises(ValueError, match="did you mean 'depth'"):
        make_limits({"dept": 1})
    with pytest.raises(ValueError, match="the limits are text_bytes, depth"):
        make_limits({"zzz": 1})
