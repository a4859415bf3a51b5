"""`scenes/cabinet.yaml`, a tree of repeated links, against the same cabinet by SAPIEN's own builder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.yaml_cases import assert_same
from sapien import Pose, physx

from scenecc import load_scene

CABINET = Path(__file__).resolve().parents[2] / "scenes" / "cabinet.yaml"


def by_hand(drawers: int, *, handles: bool) -> Any:
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    builder: Any = scene.create_articulation_builder()
    case = builder.create_link_builder()
    case.set_name("case")
    for y in (-0.21, 0.21):
        case.add_box_collision(Pose([0, y, 0.1 * drawers]), half_size=[0.2, 0.01, 0.1 * drawers])
    for i in range(drawers + 1):
        case.add_box_collision(Pose([0, 0, 0.2 * i]), half_size=[0.2, 0.2, 0.01])
    for i in range(drawers):
        drawer = builder.create_link_builder(case)
        drawer.set_name(f"drawer_{i}")
        drawer.set_joint_name(f"slide_{i}")
        drawer.set_joint_properties("prismatic", [[0, 0.35]], Pose([0, 0, 0.2 * i + 0.1]), Pose())
        drawer.add_box_collision(half_size=[0.19, 0.18, 0.07 if i % 2 else 0.08], density=200)
        if handles:
            handle = builder.create_link_builder(drawer)
            handle.set_name(f"handle_{i}")
            handle.set_joint_properties("fixed", [], Pose([0.2, 0, 0]), Pose())
            handle.add_sphere_collision(radius=0.02)
    cabinet = builder.build(fix_root_link=True)
    cabinet.name = "cabinet"
    cabinet.set_qpos([0.25 if joint.name == "slide_0" else 0 for joint in cabinet.active_joints])
    for joint in cabinet.active_joints:
        joint.set_drive_properties(20, 5)
        joint.set_drive_target(0)
    return scene


@pytest.mark.parametrize(("drawers", "handles"), [(4, True), (1, False), (7, True)])
def test_cabinet(drawers: int, *, handles: bool) -> None:
    params = {"drawers": drawers, "handles": handles}
    with load_scene(CABINET, params=params, num_scenes=2, render=False) as batch:
        assert_same(batch, [by_hand(drawers, handles=handles) for _ in range(2)])
