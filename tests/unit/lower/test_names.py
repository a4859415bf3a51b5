"""Names inside instances of prefabs: what is inside of them, and what stands relative to them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.structures import body_of
from unit.lower.scenes import entity

from scenecc import SceneError, ScenePlan, compile_scene

PREFAB = """\
scenecc: 1
params: {size: 0.1}
draws: {half: {uniform: [0.1, 0.2]}}
materials:
  oak: {physical: {static_friction: 0.9, dynamic_friction: 0.8, restitution: {uniform: [0, 1]}}}
collision_groups: {debris: {ignore: [debris]}}
frames: {top: {pose: [0, 0, 1]}}
entities:
  leg:
    material: oak
    collision_group: debris
    pose: {p: ["${half}", 0, 0], relative_to: top}
    mass: "${size}"
    shapes: [{type: box, half_size: ["${half}", "${half}", 0.1]}]
"""

SCENE = """\
scenecc: 1
num_scenes: 4
materials:
  oak: {physical: {static_friction: 0.2, dynamic_friction: 0.1}}
draws: {half: {uniform: [1, 2]}}
entities:
  a: {use: prefab.yaml, pose: {p: {uniform: [[0, 0, 0], [1, 1, 1]]}}, with: {size: "${half}"}}
  b: {use: prefab.yaml, scene_idxs: [1, 3], pose: [0, 0, 5], with: {size: {cycle: [1, 2]}}}
  cube:
    material: oak
    pose: {p: [0, 0, 1], relative_to: a/leg}
    shapes: [{type: sphere, radius: "${half}"}]
"""


def compiled(tmp_path: Path, scene: str = SCENE, prefab: str = PREFAB) -> ScenePlan:
    (tmp_path / "prefab.yaml").write_text(prefab)
    (tmp_path / "scene.yaml").write_text(scene)
    return compile_scene(tmp_path / "scene.yaml")


def shape(plan: ScenePlan, name: str) -> Any:
    return body_of(entity(plan, name)).collisions[0]


def test_names_mean_what_is_inside(tmp_path: Path) -> None:
    plan = compiled(tmp_path)
    a, b, cube = (entity(plan, name) for name in ("a/leg", "b/leg", "cube"))
    assert b.scene_idxs == (1, 3)
    inside, outside = shape(plan, "a/leg").material.data[0], shape(plan, "cube").material.data[0]
    assert plan.physical_materials[inside].static_friction.data.tolist() == [0.9]
    assert plan.physical_materials[outside].static_friction.data.tolist() == [0.2]
    halves = [shape(plan, name).geometry.half_size.data[:, 0] for name in ("a/leg", "b/leg")]
    assert (np.concatenate(halves) < 0.2).all()
    assert not set(halves[0]) & set(halves[1])
    assert (shape(plan, "cube").geometry.radius.data >= 1).all()
    # The bits of a group of each instance.
    bits = [body_of(one).collision_groups.data[0].tolist() for one in (a, b)]  # type: ignore[union-attr]
    assert bits[0] != bits[1]
    assert body_of(a).mass.data.tolist() == shape(plan, "cube").geometry.radius.data.tolist()  # type: ignore[union-attr]
    assert body_of(b).mass.data.tolist() == [2]  # type: ignore[union-attr]
    assert (cube.pose.data[:, :3] - a.pose.data[:, :3]).round(12).tolist() == [[0, 0, 1]] * 4


def test_what_is_inside_stands_where_the_instance_does(tmp_path: Path) -> None:
    plan = compiled(tmp_path)
    halves = shape(plan, "b/leg").geometry.half_size.data[:, 0]
    assert entity(plan, "b/leg").pose.data[:, :3].tolist() == [[half, 0, 6] for half in halves]
    a = entity(plan, "a/leg").pose.data
    assert ((a[:, 1:3] >= [0, 1]) & (a[:, 1:3] <= [1, 2])).all()
    assert len(set(a[:, 1])) == 4


def test_rows_of_a_material_inside_follow_the_scenes_of_each_instance(tmp_path: Path) -> None:
    plan = compiled(tmp_path)
    of_a, of_b = (
        plan.physical_materials[shape(plan, name).material.data[0]].restitution.data.shape
        for name in ("a/leg", "b/leg")
    )
    assert (of_a, of_b) == ((4,), (2,))


def test_what_is_outside_cannot_be_named(tmp_path: Path) -> None:
    prefab = PREFAB.replace("relative_to: top", "relative_to: cube").replace("material: oak", "material: ash")
    with pytest.raises(SceneError) as caught:
        compiled(tmp_path, SCENE + "  ash: {shapes: [{type: sphere, radius: 1}]}\n", prefab)
    found = {(diagnostic.code, Path(diagnostic.file or "").name) for diagnostic in caught.value.diagnostics}
    assert found == {("SC303", "prefab.yaml"), ("SC301", "prefab.yaml")}


def test_a_frame_inside_needs_values_in_the_scenes_of_its_instance_alone(tmp_path: Path) -> None:
    prefab = """\
scenecc: 1
params: {x: 1.0}
frames: {f: {pose: ["${x}", 0, 0]}}
entities: {ball: {pose: {relative_to: f}, shapes: [{type: sphere, radius: 0.1}]}}
"""
    scene = """\
scenecc: 1
num_scenes: 4
entities: {a: {use: prefab.yaml, scene_idxs: [1, 3], with: {x: {per_scene: {1: 5, 3: 7}}}}}
"""
    assert entity(compiled(tmp_path, scene, prefab), "a/ball").pose.data[:, 0].tolist() == [5, 7]


def test_a_map_by_scene_inside_may_name_scenes_that_the_instance_is_not_in(tmp_path: Path) -> None:
    prefab = """\
scenecc: 1
entities: {ball: {mass: {per_scene: {0: 1, 3: 2, default: 4}}, shapes: [{type: sphere, radius: 0.1}]}}
"""
    scene = "scenecc: 1\nnum_scenes: 4\nentities: {a: {use: prefab.yaml, scene_idxs: [1, 3]}}\n"
    mass = body_of(entity(compiled(tmp_path, scene, prefab), "a/ball")).mass
    assert mass is not None
    assert mass.data.tolist() == [4, 2]


@pytest.mark.parametrize(("scenes", "fine"), [("[1]", True), ("[1, 3]", True), ("[0, 1]", False), ("':'", False)])
def test_an_instance_is_stood_on_in_its_own_scenes(tmp_path: Path, scenes: str, fine: bool) -> None:
    scene = "scenecc: 1\nnum_scenes: 4\nentities:\n  a: {use: prefab.yaml, scene_idxs: [1, 3], pose: [1, 0, 0]}\n"
    scene += f"  cube: {{scene_idxs: {scenes}, pose: {{relative_to: a}}, shapes: [{{type: sphere, radius: 1}}]}}\n"
    prefab = "scenecc: 1\nentities: {ball: {shapes: [{type: sphere, radius: 0.1}]}}\n"
    if fine:
        assert entity(compiled(tmp_path, scene, prefab), "cube").pose.data[0, 0] == 1
        return
    with pytest.raises(SceneError) as caught:
        compiled(tmp_path, scene, prefab)
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == ["SC311"]
