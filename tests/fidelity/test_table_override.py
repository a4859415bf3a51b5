"""`scenes/maniskill/table_override.yaml`, the table scene with overrides, against SAPIEN's loader and builders."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.hand_prefabs import TABLE_HEIGHT, WORKSPACE_POSE
from fidelity.test_articulations_urdf import without_visuals
from fidelity.yaml_cases import UP, assert_same
from sapien import Pose, physx
from sapien.wrapper.urdf_loader import URDFLoader

from scenecc import compile_scene, load_scene

FILE = Path(__file__).resolve().parents[2] / "scenes" / "maniskill" / "table_override.yaml"
REST = [0, np.pi / 8, 0, -np.pi * 5 / 8, 0, np.pi * 3 / 4, np.pi / 4, 0.04, 0.04]


def panda(scene: Any) -> None:
    found = importlib.util.find_spec("mani_skill")
    assert found is not None
    assert found.origin is not None
    path = Path(found.origin).parent / "assets/robots/panda/panda_v2.urdf"
    loader: Any = URDFLoader()
    for finger in ("panda_leftfinger", "panda_rightfinger"):
        loader.set_link_material(finger, 1.2, 1, 0)
        loader.set_link_patch_radius(finger, 0.1)
        loader.set_link_min_patch_radius(finger, 0.1)
    loader.set_scene(scene)
    loader.package_dir, loader.urdf_dir = None, str(path.parent)
    loader.ignore_pairs = loader.parse_srdf(path.with_suffix(".srdf").read_text())
    (builder,), _, _ = loader._parse_urdf(without_visuals(path))
    builder.set_initial_pose(Pose([-0.615, 0, 0]))
    links = builder.build_entities()
    # The fingers mimic each other, which SAPIEN's loader would have the other way round.
    by_name = {entity.name: entity.components[0] for entity in links}
    chain = [by_name[name] for name in ("panda_hand", "panda_leftfinger", "panda_rightfinger")]
    chain[0].articulation.create_fixed_tendon(chain, [0, -1, 1], [0, -1, 1], rest_length=0, stiffness=1e5)
    for entity in links:
        scene.add_entity(entity)
    arm = links[0].components[0].articulation
    arm.name = "panda"
    for joint, start in zip(arm.active_joints, REST, strict=True):
        is_arm = joint.name.startswith("panda_joint")
        joint.set_drive_properties(400 if is_arm else 1000, 40 if is_arm else 100, 100)
        joint.set_drive_target(start)
        joint.set_friction(0)
        joint.set_max_velocity(100)
    for link in arm.links:
        link.set_disable_gravity(True)
    arm.set_qpos(REST)


def by_hand() -> Any:
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    panda(scene)
    table = scene.create_actor_builder()
    table.set_physx_body_type("kinematic")
    table.add_box_collision(Pose([0, 0, TABLE_HEIGHT / 2]), half_size=[2.418 / 2, 1.209 / 2, TABLE_HEIGHT / 2])
    table.initial_pose = WORKSPACE_POSE
    table.build(name="table-workspace")
    ground = scene.create_actor_builder()
    ground.add_plane_collision(Pose([0, 0, -TABLE_HEIGHT], UP))
    ground.build_static(name="ground")
    return scene


@pytest.mark.maniskill
def test_the_table_scene_with_overrides() -> None:
    with load_scene(FILE, num_scenes=2, render=False) as batch:
        assert_same(batch, [by_hand() for _ in range(2)])


@pytest.mark.maniskill
def test_the_table_has_the_colour() -> None:
    plan = compile_scene(FILE)
    table: Any = next(entity for entity in plan.entities if entity.name == "table-workspace").structures[0]
    assert table.visuals
    for shape in table.visuals:
        assert shape.material is not None
        material = plan.visual_materials[int(shape.material.data[0])]
        assert material.base_color is not None
        assert np.array_equal(material.base_color.data[0], [*[0.8713671191987972] * 3, 1])
