"""A joint of which nothing is said stands where SAPIEN's builder puts it, to the bit, though shapes shift the mass."""

from __future__ import annotations

from typing import Any

import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from plugins.expectations import GOOD
from sapien import physx

from scenecc import load_scene

MESH = str(GOOD / "assets/pair.obj")
INERTIA = [1.5, 1.9360108227105184, 1.0]


def by_hand(kind: str, given: dict[str, Any]) -> sapien.Scene:
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    builder = scene.create_articulation_builder()
    builder.initial_pose = sapien.Pose()
    base = builder.create_link_builder()
    base.set_name("base")
    link = builder.create_link_builder(base)
    link.set_name("link")
    limits = [] if kind == "fixed" else [float("-inf"), float("inf")]
    link.set_joint_properties(kind, limits, sapien.Pose(), sapien.Pose())
    link.add_convex_collision_from_file(MESH)
    if given:
        link.set_mass_and_inertia(1.7, sapien.Pose(), INERTIA)
    articulation = builder.build()
    articulation.name = "arm"
    if kind == "fixed":
        articulation.root_pose = articulation.root_pose
    else:
        articulation.qpos = [0]
    return scene


@pytest.mark.parametrize("given", [{}, {"inertial": {"mass": 1.7, "inertia": INERTIA}}], ids=["by density", "given"])
@pytest.mark.parametrize("kind", ["fixed", "revolute", "prismatic"])
def test_a_joint_without_poses_equals_sapiens_builder(
    kind: str, given: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(GOOD)
    shape = {"type": "convex_mesh", "file": "assets/pair.obj"}
    link = {"name": "link", "joint": {"type": kind}, "collisions": [shape], **given}
    arm = {"root": {"name": "base", "children": [link]}}
    hand = by_hand(kind, given)
    with load_scene({"scenecc": 1, "entities": {"arm": arm}}, render=False) as batch:
        assert_same_scene(batch.scenes[0], hand)
        assert_same_trajectory(batch.scenes, [hand], steps=20)
