"""Which entities a script builds in one loop."""

from __future__ import annotations

import io
import re
from typing import Any

import pytest

from scenecc import compile_scene, emit_scene
from scenecc.emit.python.entities import RepeatedEntity, fold_repeats

BOX: dict[str, Any] = {"shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]}
BALL: dict[str, Any] = {"shapes": [{"type": "sphere", "radius": 0.1}]}


def names(entities: dict[str, Any], **top: Any) -> list[str | tuple[str, ...]]:
    """What is folded, in order: names of entities, and tuples of them."""
    plan = compile_scene({"scenecc": 1, "entities": entities, **top})
    return [part.names if isinstance(part, RepeatedEntity) else part.name for part in fold_repeats(plan)[1]]


def copies(body: dict[str, Any], count: int) -> dict[str, Any]:
    return {"repeat": {"i": {"count": count}}, **body}


def test_three_that_follow_one_another_are_a_loop() -> None:
    found = names({"a": copies(BOX, 2), "b": BALL, "c": copies(BOX, 2), "d": BOX, "e": BALL})
    assert found == ["a_0", "a_1", "b", ("c_0", "c_1", "d"), "e"]


@pytest.mark.parametrize(
    "odd",
    [
        BALL,
        {**BOX, "body_type": "kinematic"},
        {**BOX, "mass": 1},
        {**BOX, "hidden": True},
        {**BOX, "scene_idxs": [1]},
        {"shapes": [*BOX["shapes"], *BOX["shapes"]]},
        {"pick": 0, "variants": [BOX]},
        {"shapes": [{**BOX["shapes"][0], "contact_offset": 0.1}]},
    ],
    ids=str,
)
def test_what_is_built_otherwise_is_not_in_it(odd: dict[str, Any]) -> None:
    found = names({"a": copies(BOX, 3), "odd": odd, "b": copies(BOX, 3)}, num_scenes=2)
    assert found == [("a_0", "a_1", "a_2"), "odd", ("b_0", "b_1", "b_2")]


def test_a_script_grows_by_the_values_alone() -> None:
    def lines(count: int, body: dict[str, Any], scenes: int = 64) -> int:
        document = {"scenecc": 1, "num_scenes": scenes, "entities": {"post": copies(body, count)}}
        return emit_scene(document, "python").count("\n")

    post = {**BOX, "pose": ["${i}", 0, 1]}
    assert lines(1000, post) - lines(500, post) == 500
    assert lines(500, post, 64) == lines(500, post, 2)


def test_lists_are_by_copy_by_scene_or_by_both() -> None:
    text = """
scenecc: 1
num_scenes: 2
entities:
  post:
    repeat: {i: {count: 3}}
    pose: ["${i}", 0, 1]
    mass: "${scene + 1}"
    shapes: [{type: sphere, radius: "${1 + i + scene}"}]
"""
    script = emit_scene(io.StringIO(text), "python")
    assert "post_radius = [[1, 2], [2, 3], [3, 4]]" in script
    assert "post_mass = [1, 2]" in script
    for used in ("radius=post_radius[k][i]", "post_mass[i]", "initial_pose = post_pose[k]"):
        assert used in script
    assert re.search(r"for k, name in enumerate\(post_names\):\n        for i, scene in enumerate\(scenes\):", script)
    assert 'post_names = [f"post_{k}" for k in range(3)]' in script


def test_names_of_any_kind_are_texts() -> None:
    script = emit_scene({"scenecc": 1, "entities": dict.fromkeys(("a.b", "c-d", "e_1"), BALL)}, "python")
    assert '["a.b", "c-d", "e_1"]' in script


def test_two_articulations_are_a_loop() -> None:
    child = {"name": "panel", "joint": {"type": "revolute", "name": "hinge", "limits": [0, 1]}, **BOX}
    door = {"root": {"name": "frame", **BOX, "children": [child]}}
    longer = {"root": {"name": "frame", **BOX, "children": [{**child, "joint": {**child["joint"], "limits": [0, 2]}}]}}
    other = {"root": {"name": "frame", **BOX, "children": [{**child, "name": "other"}]}}
    assert names({"a": door, "b": longer, "c": other}) == [("a", "b"), "c"]
    script = emit_scene({"scenecc": 1, "entities": {"a": door, "b": longer}}, "python")
    assert "    a_limits = [[0, 1], [0, 2]]\n" in script
    assert "            limits=a_limits[k],\n" in script
