"""The bounds that spare the contacts never hide an overlap, and settle what stands apart."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plugins.nightly import examples

from scenecc import load_scene
from scenecc.simulation.bounds import scenes_in_doubt

DEPTH = 0.0005
GROUND = {"body_type": "static", "shapes": [{"type": "plane"}]}
BOX = {"type": "box", "half_size": [0.1, 0.1, 0.1]}
SHAPES: list[dict[str, Any]] = [
    BOX,
    {"type": "sphere", "radius": 0.1},
    {"type": "capsule", "radius": 0.05, "half_length": 0.1},
    {"type": "cylinder", "radius": 0.1, "half_length": 0.05},
]


def doubted(entities: dict[str, Any], **other: Any) -> list[int]:
    with load_scene({"scenecc": 1, "entities": entities, **other}, render=False) as batch:
        return scenes_in_doubt(batch, DEPTH)


def body(random: Random) -> dict[str, Any]:
    quaternion = [random.gauss(0, 1) for _ in range(4)]
    length = sum(x * x for x in quaternion) ** 0.5
    pose = {
        "p": [random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4), random.uniform(0.05, 0.8)],
        "q": [x / length for x in quaternion],
    }
    kind = random.choice(["dynamic", "dynamic", "kinematic", "static"])
    shapes = [random.choice(SHAPES) for _ in range(random.randint(1, 2))]
    return {"body_type": kind, "pose": pose, "shapes": shapes}


@given(st.integers(0, 2**32))
@settings(max_examples=examples(40), deadline=None)
def test_a_scene_with_a_deep_contact_is_in_doubt(seed: int) -> None:
    random = Random(seed)
    scene = {"scenecc": 1, "entities": {"ground": GROUND, **{f"b{i}": body(random) for i in range(4)}}}
    with load_scene(scene, render=False) as batch:
        doubt = scenes_in_doubt(batch, DEPTH)
        batch.step(1)
        deep = (batch.contacts().separation < -DEPTH).any()
    assert doubt == [0] or not deep


@pytest.mark.parametrize(
    ("pose", "doubt"),
    [([0, 0, 0.1], []), ([0, 0, 0.0996], []), ([0, 0, 0.099], [0]), ([0.4, 0.2, 0.1], []), ([0, 0, 0.4], [])],
)
def test_a_plane_is_not_treated_as_a_box(pose: list[float], doubt: list[int]) -> None:
    table = {"body_type": "static", "pose": [2, 0, 0.1], "shapes": [BOX]}
    assert doubted({"ground": GROUND, "table": table, "box": {"pose": pose, "shapes": [BOX]}}) == doubt


def test_a_rotated_plane_is_tested_along_its_normal() -> None:
    plane = {"type": "plane", "normal": [1, 0, 0]}
    wall = {"body_type": "static", "pose": {"p": [1, 0, 0], "rpy_deg": [0, 0, 180]}, "shapes": [plane]}
    for x, doubt in ((0.9, []), (0.902, [0])):
        assert doubted({"wall": wall, "box": {"pose": [x, 0, 0.1], "shapes": [BOX]}}) == doubt, x


def test_links_connected_by_a_joint_cause_no_doubt() -> None:
    link = {"shapes": [BOX], "joint": {"type": "revolute", "origin": [0, 0, 0.15]}}
    tree = {"name": "base", "shapes": [BOX], "children": [{"name": "upper", **link}]}
    robot = {"root": tree, "fix_root_link": True, "pose": [0, 0, 1]}
    assert doubted({"ground": GROUND, "robot": robot}) == []


def test_a_plane_beside_a_box_in_one_body_leaves_doubt() -> None:
    both = {"body_type": "static", "shapes": [{"type": "plane"}, {**BOX, "pose": [3, 0, 0.1]}]}
    assert doubted({"both": both, "box": {"pose": [0, 0, 0.1], "shapes": [BOX]}}) == [0]


def test_only_scenes_with_an_overlap_are_in_doubt() -> None:
    height = {"per_scene": [[0, 0, 0.1], [0, 0, 0.05], [0, 0, 0.2]]}
    assert doubted({"ground": GROUND, "box": {"pose": height, "shapes": [BOX]}}, num_scenes=3) == [1]
