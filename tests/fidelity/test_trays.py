"""`scenes/trays.yaml`, whose sizes follow from `bounds` of meshes, against the same trays by SAPIEN's own builder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
import trimesh
from fidelity.yaml_cases import assert_same
from sapien import Pose, physx

from scenecc import load_scene

SCENES = Path(__file__).resolve().parents[2] / "scenes"


def add_tray(scene: Any, name: str, mesh: Path, gap: float, place: Pose) -> None:
    low, high = trimesh.load(mesh, process=False).bounds  # pyright: ignore[reportAttributeAccessIssue]
    x, y = ((high - low) / 2 + gap)[:2].tolist()
    z, wall = float(high[2] - low[2]) / 8, 0.004
    tray, content = scene.create_actor_builder(), scene.create_actor_builder()
    tray.add_box_collision(Pose([0, 0, wall / 2]), [x + wall, y + wall, wall / 2])
    for side in (-1, 1):
        tray.add_box_collision(Pose([side * (x + wall / 2), 0, wall + z]), [wall / 2, y + wall, z])
    for side in (-1, 1):
        tray.add_box_collision(Pose([0, side * (y + wall / 2), wall + z]), [x, wall / 2, z])
    content.add_convex_collision_from_file(str(mesh))
    middle = -(low + high) / 2
    for builder, part, pose in (
        (tray, "tray", Pose()),
        (content, "content", Pose([middle[0], middle[1], wall - low[2]])),
    ):
        builder.set_initial_pose(place * pose)
        builder.build(name=f"{name}/{part}")


@pytest.mark.parametrize("mesh", ["mug.obj", "bowl.obj"])
def test_trays(mesh: str) -> None:
    with load_scene(SCENES / "trays.yaml", params={"mesh": f"assets/{mesh}"}, render=False) as batch:
        ours = [batch.entities["first/tray"].objs[number].pose for number in range(2)]
        scenes: list[Any] = []
        for pose in ours:
            scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
            ground = scene.create_actor_builder()
            ground.add_plane_collision(Pose([0, 0, 0], [np.sqrt(0.5), 0, -np.sqrt(0.5), 0]))
            ground.build_static(name="ground")
            add_tray(scene, "first", SCENES / "assets" / mesh, 0.005, pose)
            add_tray(scene, "second", SCENES / "assets/gem.stl", 0.01, Pose([0, 0.3, 0]))
            scenes.append(scene)
        assert_same(batch, scenes)
