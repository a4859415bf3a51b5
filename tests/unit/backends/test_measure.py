"""What is measured of a build, against the same by hand in SAPIEN."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from plugins.mesh_files import TETRA
from sapien import physx

import scenecc
from scenecc.backends.sapien import instantiate
from scenecc.backends.sapien.measure import measure_bodies
from scenecc.diagnostics import Sink
from scenecc.plan import ScenePlan
from scenecc.plan.snapshot import MeasuredEntity, MeasuredScene

ROOT = Path(__file__).parents[3]


def measured(source: Any, scene_idxs: Sequence[int] | None = None, **options: Any) -> tuple[MeasuredScene, ...]:
    plan = source if isinstance(source, ScenePlan) else scenecc.compile_scene(source, **options)
    batch = instantiate(plan, Sink(), scene_idxs=scene_idxs, render=False)
    assert batch is not None
    with batch:
        return measure_bodies(batch).scenes


def entity(scene: MeasuredScene, name: str) -> MeasuredEntity:
    return next(each for each in scene.entities if each.entity.name == name)


def test_measured_bodies_equal_hand_built_ones(plan: ScenePlan) -> None:
    scenes = measured(plan)
    assert [scene.index for scene in scenes] == [0, 1, 2, 3]
    for number, scene in enumerate(scenes):
        by_hand = sapien.Scene([physx.PhysxCpuSystem()])
        builder = by_hand.create_actor_builder()
        size: Any = np.array([0.02, 0.02, 0.1 + 0.1 * number], np.float32)
        builder.add_box_collision(half_size=size)
        builder.initial_pose = sapien.Pose([0, 1, 1])
        component: Any = builder.build().find_component_by_type(physx.PhysxRigidDynamicComponent)
        post = entity(scene, "post")
        (body,) = post.bodies
        assert post.row == number
        assert body.pose == (0, 1, 1, 1, 0, 0, 0)
        assert body.mass is not None
        assert (body.mass.mass, body.mass.inertia) == (component.mass, tuple(component.inertia))
        assert body.mass.com == tuple(component.cmass_local_pose.__getstate__())
        (shape,) = body.shapes
        assert (shape.kind, shape.sizes, shape.density) == ("box", tuple(size.tolist()), 1000)
        assert shape.shape is post.structure.bodies[0].collisions[0]


def test_a_body_that_the_engine_gives_no_mass_has_none(plan: ScenePlan) -> None:
    scene = measured(plan, scene_idxs=[2])[0]
    assert [scene.index, entity(scene, "post").row] == [2, 2]
    assert entity(scene, "table").bodies[0].mass is None
    marker = entity(scene, "marker").bodies[0]
    assert (marker.mass, marker.shapes, marker.pose[:3]) == (None, (), (0, 0, 2))


def test_measured_settings_are_those_of_the_scene() -> None:
    scene = measured({"scenecc": 1, "physics": {"gravity": [0, 0, -1], "timestep": 0.25}, "entities": {}})[0]
    assert (scene.gravity, scene.timestep, scene.entities) == ((0, 0, -1), 0.25, ())


def test_measured_meshes_are_scaled_shared_and_face_outwards(tmp_path: Path) -> None:
    (tmp_path / "tetra.obj").write_text(TETRA)
    shape = {"type": "triangle_mesh", "file": str(tmp_path / "tetra.obj")}
    shapes = [shape | {"scale": [2, 3, 4]}, shape | {"scale": [2, 3, 4]}, shape]
    source = {"scenecc": 1, "entities": {"a": {"body_type": "static", "shapes": shapes}}}
    (body,) = entity(measured(source, allow_outside_assets=True)[0], "a").bodies
    first, second, other = [each.mesh for each in body.shapes]
    assert first is second
    assert first is not None
    assert other is not None
    assert first != other
    assert sorted(map(tuple, first.vertices.round(6))) == [(0, 0, 0), (0, 0, 0.4), (0, 0.3, 0), (0.2, 0, 0)]
    a, b, c = (first.vertices[first.triangles[:, i]] for i in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6 == pytest.approx(0.001 / 6 * 24)


def test_measured_links_and_joints_are_those_of_the_engine() -> None:
    with scenecc.load_scene(ROOT / "scenes/robot_arm.yaml", render=False) as batch:
        scene = measure_bodies(batch).scenes[0]
        for name, articulation in batch.articulations.items():
            found = entity(scene, name)
            joints = {body.joint.name: body.joint for body in found.bodies if body.joint and body.joint.type != "fixed"}
            assert [joints[each].qpos for each in articulation.active_joint_names] == articulation.qpos[0].tolist()
            assert [list(joints[each].limits) for each in articulation.active_joint_names] == (
                articulation.qlimits[0].tolist()
            )
            for body in found.bodies:
                link: Any = articulation.links[body.name][0]
                assert body.pose == tuple(link.entity.pose.__getstate__())
                assert body.mass is not None
                assert body.mass.mass == link.mass
                assert (None if body.parent is None else found.bodies[body.parent].name) == (
                    link.parent and link.parent.name
                )
