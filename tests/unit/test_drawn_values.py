"""The values that scenes draw, by name, as `drawn` and `scene_draws` return them."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenecc

SCENE = """\
scenecc: 1
num_scenes: 4
seed: 3
draws:
  edge: {uniform: [0.05, 0.1]}
  word: {choice: [red, blue]}
  push: {uniform: [1, 2]}
materials:
  rough: {physical: {static_friction: {uniform: [0.4, 0.6]}, dynamic_friction: 0.3, restitution: 0}}
entities:
  floor: {body_type: static, shapes: [{type: box, half_size: [1, 1, 0.1]}], pose: [0, 0, -0.1]}
  cube:
    mass: {uniform: [1, 2]}
    gravity: {choice: [true, false]}
    linear_velocity: ["${push}", 0, 0]
    shapes: [{type: box, half_size: ["${edge}", 0.1, 0.1], material: rough}]
    place: {on: floor}
  toy:
    pose: [0, 0, 2]
    mass: {uniform: [3, 4]}
    pick: {cycle: [0, 1]}
    variants: [{shapes: [{type: sphere, radius: 0.1}]}, {shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}]
  odd:
    scene_idxs: [1, 3]
    pose: [0, 0, 4]
    shapes: [{type: sphere, radius: {uniform: [0.1, 0.2]}}]
  arm:
    pose: [0, 0, 6]
    fix_root_link: true
    qpos: {slide: {uniform: [0, 0.1]}}
    drives: {slide: {stiffness: {uniform: [5, 6]}, damping: 1}}
    root:
      name: base
      shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
      children:
        - name: hand
          mass: {uniform: [1, 2]}
          shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
          joint: {name: slide, type: prismatic, axis: x}
cameras:
  eye: {pose: {p: [-2, 0, {uniform: [1, 2]}], look_at: [0, 0, 0]}, fovy: {uniform: [0.5, 1]}}
lights:
  lamp: {type: point, pose: [0, 0, 3], color: {uniform: [[1, 1, 1], [2, 2, 2]]}}
"""


@pytest.fixture(scope="module")
def batch() -> Any:
    with scenecc.load_scene(io.StringIO(SCENE), render=False) as made:
        yield made


def components(batch: scenecc.SceneBatch, name: str) -> list[Any]:
    return [each.components[0] for each in batch.entities[name].objs]


def bits(rows: Any) -> Any:
    return rows.tolist() if rows.dtype == object else rows.tobytes()


def same(a: dict[str, Any], b: dict[str, Any]) -> bool:
    return a.keys() == b.keys() and all(bits(a[name]) == bits(b[name]) for name in a)


def check_engine(batch: scenecc.SceneBatch) -> None:
    """Compares what was drawn with what the engine has."""
    drawn = batch.drawn()
    for name in ("cube", "toy"):
        masses = [component.mass for component in components(batch, name)]
        assert np.float32(drawn[f"{name}.mass"]) == pytest.approx(masses, rel=1e-6)
    assert drawn["cube.disable_gravity"].tolist() == [one.disable_gravity for one in components(batch, "cube")]
    assert (np.float32(drawn["cube.pose"]) == batch.entities["cube"].pose).all()
    assert (np.float32(drawn["cube.linear_velocity"]) == batch.entities["cube"].linear_velocity).all()
    shapes = [one.collision_shapes[0] for one in components(batch, "cube")]
    frictions = drawn["cube.shapes[0].material.static_friction"]
    assert np.float32(frictions).tolist() == [shape.physical_material.static_friction for shape in shapes]
    assert np.float32(drawn["cube.shapes[0].half_size"]).tolist() == [shape.half_size.tolist() for shape in shapes]
    arm = batch.articulations["arm"]
    assert np.float32(drawn["arm/slide.qpos"]).tolist() == arm.qpos[:, 0].tolist()
    assert np.float32(drawn["arm/slide.stiffness"]).tolist() == [one.active_joints[0].stiffness for one in arm.objs]
    assert np.float32(drawn["arm/hand.mass"]).tolist() == pytest.approx([one.links[1].mass for one in arm.objs])
    for name, state in batch.state().drawn.items():
        if " material " in name:  # named here after the shapes that have it
            continue
        rows = drawn[name][[batch.scene_idxs.index(scene) for scene in state.scene_idxs]]
        numbers = state.numbers[:, 0] if name.endswith(".mass") else state.numbers
        assert (rows == numbers.reshape(rows.shape)).all()


def test_drawn_values_are_those_of_the_engine(batch: scenecc.SceneBatch) -> None:
    batch.reset(seed=3)
    check_engine(batch)
    batch.reset(seed=8)
    check_engine(batch)
    batch.reset(seed=[4, 5], scene_idxs=[3, 1])
    check_engine(batch)


def test_drawn_values_need_no_engine(batch: scenecc.SceneBatch) -> None:
    (found,) = scenecc.scene_draws(io.StringIO(SCENE))
    with scenecc.load_scene(io.StringIO(SCENE), render=False) as made:
        assert same(made.drawn(), dict(found.values))
    batch.reset(seed=3)
    assert same(batch.drawn(), dict(found.values))
    assert (found.seed, found.scene_idxs) == (3, (0, 1, 2, 3))


def test_a_reset_changes_what_it_draws_scene_by_scene(batch: scenecc.SceneBatch) -> None:
    batch.reset(seed=3)
    before = batch.drawn()
    batch.reset(seed=9, scene_idxs=[2])
    after = batch.drawn()
    kept = {"edge", "word", "cube.shapes[0].half_size", "toy.pick", "odd.shapes[0].radius"}
    for name, rows in after.items():
        changed = [scene for scene in range(4) if bits(rows[[scene]]) != bits(before[name][[scene]])]
        if name != "word" and rows.dtype != bool:
            assert changed == ([] if name in kept else [2]), name
        assert set(changed) <= {2}
    assert same(batch.drawn([2, 0]), {name: rows[[2, 0]] for name, rows in after.items()})
    (row,) = batch.drawn_rows([2])
    assert row["cube.mass"] == after["cube.mass"][2]


def test_shared_draws_fields_and_scenes_without_them() -> None:
    (found,) = scenecc.scene_draws(io.StringIO(SCENE), scenes="1:3")
    values = found.values
    assert found.scene_idxs == (1, 2)
    assert values["word"].tolist()[0] in {"red", "blue"}
    assert (values["edge"] == values["cube.shapes[0].half_size"][:, 0]).all()
    assert (values["push"] == values["cube.linear_velocity"][:, 0]).all()
    assert values["toy.pick"].tolist() == [1, 0]
    assert np.isnan(values["odd.shapes[0].radius"]).tolist() == [False, True]
    assert values["cameras/eye.pose"].shape == (2, 7)
    assert 0.5 <= values["cameras/eye.lens.fovy"][0] <= 1
    assert values["lights/lamp.color"].shape == (2, 3)
    assert not any(name.startswith("floor") for name in values)


def test_a_chosen_material_gives_its_numbers() -> None:
    rough = {"static_friction": {"uniform": [0.4, 0.6]}, "dynamic_friction": 0.1, "restitution": 0}
    materials = {"rough": {"physical": rough}, "slick": {"physical": {**rough, "static_friction": 0.2}}}
    shape = {"type": "box", "half_size": [0.1, 0.1, 0.1], "material": {"cycle": ["rough", "slick"]}}
    document = {"scenecc": 1, "num_scenes": 3, "materials": materials, "entities": {"cube": {"shapes": [shape]}}}
    with scenecc.load_scene(document, render=False) as made:
        for _ in range(2):
            drawn = made.drawn()
            frictions = drawn["cube.shapes[0].material.static_friction"]
            built = [one.collision_shapes[0].physical_material for one in components(made, "cube")]
            assert np.float32(frictions).tolist() == [material.static_friction for material in built]
            assert frictions[1] == 0.2
            made.reset(seed=8)


def test_texts_are_none_in_scenes_without_them() -> None:
    files = {"choice": ["scenes/assets/checker.png", "scenes/assets/wear.png"]}
    material = {"visual": {"base_color_texture": {"file": files}}}
    box = {"type": "box", "half_size": [0.1, 0.1, 0.1], "material": material}
    odd = {"scene_idxs": [1], "visuals": [box], "body_type": "static"}
    document = {"scenecc": 1, "num_scenes": 2, "entities": {"odd": odd}}
    (found,) = scenecc.scene_draws(document, allow_outside_assets=True)
    values = found.values["odd.visuals[0].material.base_color_texture.file"]
    assert values[0] is None
    assert values[1] in files["choice"]


def test_seeds_are_those_of_separate_builds() -> None:
    several = scenecc.scene_draws(io.StringIO(SCENE), seeds=range(2))
    assert [one.seed for one in several] == [0, 1]
    for one in several:
        (alone,) = scenecc.scene_draws(io.StringIO(SCENE), seed=one.seed)
        assert same(dict(one.values), dict(alone.values))
    with pytest.raises(ValueError, match="cannot be combined"):
        scenecc.scene_draws(io.StringIO(SCENE), seeds=[0], seed=1)
    with pytest.raises(scenecc.SceneError, match="SC908"):
        scenecc.scene_draws(io.StringIO(SCENE), scenes="7")


def test_given_draws_are_drawn_values(batch: scenecc.SceneBatch) -> None:
    batch.reset(draws={"push": [1.25]}, scene_idxs=[1])
    assert batch.drawn()["push"][1] == batch.drawn()["cube.linear_velocity"][1, 0] == 1.25


def test_a_state_has_the_drawn_values_of_all_variants(batch: scenecc.SceneBatch) -> None:
    batch.reset(seed=3)
    state = batch.state()
    assert state.drawn["toy.mass"].scene_idxs == (0, 1, 2, 3)
    batch.reset(seed=4)
    batch.set_state(state)
    assert batch.state() == state


def test_values_keep_their_shape_in_scenes_without_them() -> None:
    shapes = [{"type": "box", "half_size": {"uniform": [[0.1, 0.1, 0.1], [0.2, 0.2, 0.2]]}}]
    scene = {"scenecc": 1, "num_scenes": 2, "entities": {"box": {"scene_idxs": [1], "shapes": shapes}}}
    (found,) = scenecc.scene_draws(scene, scenes="0")
    (values,) = found.values.values()
    assert values.shape == (1, 3)
    assert np.isnan(values).all()


def test_an_instance_may_have_the_name_of_a_section(tmp_path: Path) -> None:
    low, high = ({"p": [0, 0, {"uniform": where}]} for where in ([1, 2], [3, 4]))
    ball = {"body_type": "kinematic", "shapes": [{"type": "sphere", "radius": 0.1}], "pose": low}
    (tmp_path / "lamp.yaml").write_text(json.dumps({"scenecc": 1, "entities": {"lamp": ball}}))
    scene = {"scenecc": 1, "num_scenes": 2, "entities": {"lights": {"use": "lamp.yaml"}}}
    light = {"type": "point", "pose": high, "color": [1, 1, 1]}
    (tmp_path / "scene.yaml").write_text(json.dumps({**scene, "lights": {"lamp": light}}))
    (found,) = scenecc.scene_draws(tmp_path / "scene.yaml")
    heights = {name: rows[:, 2].tolist() for name, rows in found.values.items()}
    assert {*heights} == {"lights/lamp.pose", "lights:lamp.pose"}
    assert max(heights["lights/lamp.pose"]) < min(heights["lights:lamp.pose"])
