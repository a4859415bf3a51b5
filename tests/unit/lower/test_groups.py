"""Collision groups against SAPIEN's rule, by trying every pair."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.structures import body_of
from sapien import physx
from unit.lower.scenes import BALL, codes, entity, scene

from scenecc import compile_scene, load_scene

NAMES = [f"g{i}" for i in range(31)]


def collide(a: Any, b: Any) -> bool:
    """SAPIEN's rule over the four integers of two shapes."""
    ignored = (a[2] & b[2]) and (a[3] & 0xFFFF) == (b[3] & 0xFFFF)
    return bool(((a[0] & b[1]) or (a[1] & b[0])) and not ignored)


def bits_of(groups: dict[str, Any]) -> dict[str | None, list[int]]:
    """The integers of every group, and under None those of what has no group."""
    entities = {f"in_{name}": {"shapes": BALL, "collision_group": name} for name in groups}
    plan = compile_scene({"scenecc": 1, "collision_groups": groups, "entities": {**entities, "free": {"shapes": BALL}}})
    found: dict[str | None, list[int]] = {None: [1, 1, 0, 0]}
    for name in groups:
        value = body_of(entity(plan, f"in_{name}")).collision_groups
        assert value is not None
        found[name] = value.data[0].tolist()
    assert body_of(entity(plan, "free")).collision_groups is None, "no group: SAPIEN's default, untouched"
    return found


@st.composite
def groupings(draw: st.DrawFn) -> dict[str, Any]:
    names = draw(st.lists(st.sampled_from(NAMES), unique=True, min_size=1))
    return {name: {"ignore": draw(st.lists(st.sampled_from(names), max_size=4))} for name in names}


@given(groupings())
def test_two_collide_unless_one_ignores_the_other(groups: dict[str, Any]) -> None:
    bits = bits_of(groups)
    for a, b in itertools.product(bits, repeat=2):
        ignored = a is not None and b is not None and (b in groups[a]["ignore"] or a in groups[b]["ignore"])
        assert collide(bits[a], bits[b]) == (not ignored), (a, b)


def test_exactly_31_groups_fit() -> None:
    groups: dict[str, Any] = {name: {"ignore": [name]} for name in NAMES}
    bits = bits_of(groups)
    assert all(0 <= number < 2**32 for row in bits.values() for number in row)
    assert codes({"scenecc": 1, "collision_groups": {**groups, "g31": {}}}) == [("SC312", "collision_groups.g31")]


def test_all_of_a_body_s_shapes_get_them_in_the_engine() -> None:
    document = scene(
        {"shapes": [*BALL, *BALL], "collision_group": "b"}, collision_groups={"a": {"ignore": ["b"]}, "b": {}}
    )
    with load_scene(document, render=False) as batch:
        component = batch.entities["body"].objs[0].components[0]
        assert isinstance(component, physx.PhysxRigidBaseComponent)
        assert [shape.collision_groups for shape in component.collision_shapes] == [[4, 0b101, 0, 0]] * 2


@pytest.mark.parametrize("bits", [[0, 0, 0, 0], [2**32 - 1, 1, 7, 65535]])
def test_bits_are_passed_on(bits: list[int]) -> None:
    value = body_of(entity(compile_scene(scene({"collision_bits": bits})))).collision_groups
    assert value is not None
    assert value.data.tolist() == [bits]
