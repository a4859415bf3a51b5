"""What is told of a scene, against SAPIEN, against the plan and against the files themselves."""

from __future__ import annotations

import io
import json
from dataclasses import fields
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from hypothesis import HealthCheck, given, settings
from plugins.nightly import examples
from plugins.plan_strategy import plans

import scenecc
from scenecc import ScenePlan, inspect_scene
from scenecc.cli.tables import tree_text
from scenecc.inspect import Item, summarize
from scenecc.inspect.facts import axis_words, rotation_words
from scenecc.inspect.inspection import scene_item
from scenecc.plan.display import SPEC_FIELD_NAMES

ROOT = Path(__file__).parents[3]
SCENES = sorted([*(ROOT / "scenes").glob("*.yaml"), *(ROOT / "scenes/recipes").glob("*.yaml")])


def told(text: str, **options: Any) -> dict[str, Any]:
    return inspect_scene(io.StringIO(text), **options).data()


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_inspect_describes_all_scenes_or_one(path: Path) -> None:
    plan = scenecc.compile_scene(path)
    whole = inspect_scene(path).data()
    json.dumps(whole, allow_nan=False)
    assert [one["name"] for one in whole["entities"]] == [one.name for one in plan.entities]
    one = inspect_scene(path, scene=plan.num_scenes - 1).data()
    text = json.dumps(one["entities"], allow_nan=False)
    assert '"low"' not in text
    assert '"alternatives"' not in text


def test_inspected_masses_and_sizes_are_those_of_sapien() -> None:
    found = told(
        """
scenecc: 1
entities:
  thing:
    pose: {p: [1, 2, 3], rpy_deg: [10, 20, 30]}
    shapes:
      - {type: capsule, radius: 0.1, half_length: 0.2, density: 700}
      - {type: box, half_size: [0.1, 0.2, 0.3], pose: {p: [0.5, 0, 0], rpy_deg: [0, 0, 90]}}
"""
    )["entities"][0]
    scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(sapien.Pose(), 0.1, 0.2, density=700)
    builder.add_box_collision(sapien.Pose([0.5, 0, 0], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]), (0.1, 0.2, 0.3))
    body: Any = builder.build().find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
    assert found["mass"] == pytest.approx(body.mass, rel=1e-6)
    assert found["size"] == pytest.approx([1.0, 0.2, 0.6], abs=1e-6)


def test_inspected_meshes_have_size_and_mass_from_the_engine() -> None:
    path = ROOT / "scenes/materials.yaml"
    (gem,) = inspect_scene(path, entity="gem").data()["entities"]
    with scenecc.load_scene(path, render=False) as batch:
        body: Any = batch.entities["gem"].objs[0].find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
        vertices = body.collision_shapes[0].vertices
        assert gem["mass"] == pytest.approx(body.mass)
    assert gem["size"] == pytest.approx(np.ptp(vertices, axis=0).tolist(), abs=1e-6)
    assert "mass" not in inspect_scene(path, entity="gem", build=False).data()["entities"][0]


ARM = """
scenecc: 1
num_scenes: 2
entities:
  arm:
    fix_root_link: true
    qpos: {rail: {per_scene: [0.1, 0.4]}}
    drives: {rail: {stiffness: 10, damping: 1}}
    root:
      name: base
      shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
      children:
        - name: slide
          joint: {name: rail, type: prismatic, axis: y, limits: [0, 0.5]}
          shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
          children:
            - name: hand
              joint:
                {name: wrist, type: revolute, axis: [0, 0.6, 0.8], mimic: {joint: rail, multiplier: 2, offset: 0.1}}
              shapes: [{type: sphere, radius: 0.1}]
            - {name: tool, joint: {type: fixed}}
"""


def test_inspect_describes_an_articulation_link_by_link() -> None:
    (arm,) = told(ARM, scene=1)["entities"]
    assert (arm["type"], arm["link_count"], arm["dof"]) == ("articulation", 4, 2)
    base, slide, hand, tool = arm["links"]
    assert [one.get("parent") for one in arm["links"]] == [None, "base", "slide", "slide"]
    assert slide["joint"]["axis"] == pytest.approx([0, 1, 0])
    assert (slide["joint"]["name"], slide["joint"]["type"]) == ("rail", "prismatic")
    assert (slide["joint"]["limits"], slide["joint"]["qpos"], slide["joint"]["stiffness"]) == ([0, 0.5], 0.4, 10)
    assert hand["joint"]["axis"] == pytest.approx([0, 0.6, 0.8])
    assert (hand["joint"]["mimic"], hand["joint"]["mimic.multiplier"]) == ("rail", 2)
    assert tool["joint"] == {"type": "fixed"} | {k: v for k, v in tool["joint"].items() if k.startswith("pose")}
    assert arm["mass"] == pytest.approx(base["mass"] + slide["mass"] + hand["mass"], rel=1e-5)
    assert arm["size"][1] == pytest.approx(0.6, abs=1e-5), "0.2 of the base, and the slide 0.4 further"


def test_inspect_describes_varying_values_of_the_built_scene() -> None:
    (arm,) = told(ARM)["entities"]
    assert arm["size"]["scene"] == 0
    assert arm["size"]["value"][1] == pytest.approx(0.3, abs=1e-5)
    assert isinstance(arm["mass"], float), "which is the same in every scene"
    assert arm["links"][1]["joint"]["qpos"]["alternatives"] == [0.1, 0.4]


def test_inspect_omits_no_field_of_a_body() -> None:
    path = ROOT / "scenes/knobs.yaml"
    plan = scenecc.compile_scene(path)
    for entity, item in zip(plan.entities, inspect_scene(path).data()["entities"], strict=True):
        (body,) = entity.bodies
        given = {field.name for field in fields(body) if getattr(body, field.name) is not None}
        given -= {"body_type", "collisions", "visuals", "origin", "inertial"}
        assert {SPEC_FIELD_NAMES.get(name, name) for name in given} <= item.keys()
        shown = {key for shape in item["shapes"] for key in shape}
        for shape in (*body.collisions, *body.visuals):
            for holder in (shape, shape.geometry):
                names = {field.name for field in fields(holder)}
                for name in names - {"geometry", "pose", "material", "origin", "name"}:
                    if getattr(holder, name) is not None:
                        assert name in shown


def test_inspect_lists_files_with_their_users(tmp_path: Path) -> None:
    for name in ("mug.obj", "bowl.obj", "bowl.mtl", "checker.png"):
        (tmp_path / name).write_bytes((ROOT / "scenes/assets" / name).read_bytes())
    (tmp_path / "part.yaml").write_text(
        "scenecc: 1\nentities: {mug: {visuals: [{type: mesh, file: mug.obj}], body_type: kinematic}}\n"
    )
    (tmp_path / "scene.yaml").write_text(
        "scenecc: 1\nentities:\n"
        "  cup: {use: part.yaml}\n"
        "  bowl: {body_type: kinematic, visuals: [{type: mesh, file: bowl.obj}]}\n"
    )
    found = inspect_scene(tmp_path / "scene.yaml").data()["files"]
    top = str(tmp_path / "scene.yaml")
    roles = {Path(file["path"]).name: (file["type"], file["named_by"], file["used_by"]) for file in found}
    assert roles["scene.yaml"] == ("scene", [], [])
    assert roles["part.yaml"] == ("prefab", [top], [])
    assert roles["mug.obj"] == ("mesh", [str(tmp_path / "part.yaml")], ["cup/mug"])
    assert roles["bowl.obj"] == ("mesh", [top], ["bowl"])
    assert roles["bowl.mtl"] == ("mesh", ["bowl.obj"], [])
    assert roles.keys() <= {"scene.yaml", "part.yaml", "mug.obj", "bowl.obj", "bowl.mtl", "checker.png"}
    for file in found:
        data = Path(file["path"]).read_bytes()
        assert (file["bytes"], file["sha256"]) == (len(data), sha256(data).hexdigest())


def test_a_scene_without_a_file_lists_no_scene_file() -> None:
    scene = {"scenecc": 1, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 1}]}}}
    assert "files" not in inspect_scene(scene).data()
    plan = scenecc.compile_scene(scene)
    assert inspect_scene(plan).data() == inspect_scene(scene).data() | {
        "entities": inspect_scene(plan).data()["entities"]
    }


def test_a_deep_tree_of_links_can_be_inspected() -> None:
    root: dict[str, Any] = {"name": "l79", "joint": {"type": "fixed"}, "shapes": [{"type": "sphere", "radius": 0.1}]}
    for number in range(78, -1, -1):
        joint = {"joint": {"type": "fixed"}} if number else {}
        root = {"name": f"l{number}", **joint, "shapes": root["shapes"], "children": [root]}
    scene = {"scenecc": 1, "entities": {"chain": {"root": root}}}
    item = inspect_scene(scene, build=False, limits={"depth": 1000})
    assert len(item.data()["entities"][0]["links"]) == 80
    assert len(tree_text(item).splitlines()) > 160


def test_an_inspected_tree_can_be_cut_with_a_count_of_hidden_items() -> None:
    leaf = Item("leaf", "")
    item = Item("root", "", (), (("twigs", (Item("twig", "", (), (("leaves", (leaf, leaf)),)),)),))
    assert item.cut(0).data() == {"name": "root", "hidden": 3}
    assert item.cut(1).data() == {"name": "root", "twigs": [{"name": "twig", "hidden": 2}]}
    assert item.cut(2) == item


@pytest.mark.parametrize(
    ("q", "words"),
    [
        ([np.sqrt(0.5), 0, 0, np.sqrt(0.5)], "90° about z"),
        ([-np.sqrt(0.5), 0, 0, np.sqrt(0.5)], "90° about -z"),
        ([0, 1, 0, 0], "180° about x"),
        ([0.5, 0.5, 0.5, 0.5], "120° about [0.57735, 0.57735, 0.57735]"),
    ],
)
def test_an_inspected_rotation_is_an_angle_and_an_axis(q: list[float], words: str) -> None:
    assert rotation_words([float(number) for number in q]) == words


def test_coordinate_axes_are_shown_by_name() -> None:
    assert axis_words([0.0, -1.0, 0.0]) == "-y"
    assert axis_words([1e-9, 0.0, 1.0]) == "z"


def test_unknown_scenes_and_entities_are_reported() -> None:
    scene = {"scenecc": 1, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 1}]}}}
    with pytest.raises(scenecc.SceneError, match="SC910"):
        inspect_scene(scene, entity="bull")
    with pytest.raises(scenecc.SceneError, match="SC908: there is no scene 1: the only scene is 0"):
        inspect_scene(scene, scene=1)
    with pytest.raises(ValueError, match="scene must be at least 0"):
        inspect_scene(scene, scene=-1)


@settings(max_examples=examples(25), suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(plans(recipes=True, full=True))
def test_any_plan_can_be_inspected(plan: ScenePlan) -> None:
    for scene in (None, 0, plan.num_scenes - 1):
        item = scene_item(plan, scene=scene, made={})
        json.dumps(item.data(), allow_nan=False)
        assert "\x1b" not in tree_text(item)


TURNED = """
scenecc: 1
entities:
  body:
    shapes:
      - {type: sphere, radius: 0.1, pose: {p: [0, 0, 0], rpy_deg: [10, 45, 20]}}
      - {type: SHAPE, radius: 0.1, half_length: 0.3, axis: z, pose: {p: [0, 0, 0], rpy_deg: [0, 30, 0]}}
  robot:
    fix_root_link: true
    root:
      name: base
      shapes: [{type: sphere, radius: 0.1}]
      children:
        - name: arm
          joint: {name: hinge, type: revolute, axis: y, limits_deg: [-90, 90]}
          shapes:
            - {type: SHAPE, radius: 0.1, half_length: 0.3, axis: z}
    qpos: {hinge: 0.5235987755982988}
"""


@pytest.mark.parametrize(
    ("shape", "x", "z"),
    [
        ("capsule", 2 * (0.1 + 0.3 * 0.5), 2 * (0.1 + 0.3 * np.sqrt(0.75))),
        ("cylinder", 2 * (0.3 * 0.5 + 0.1 * np.sqrt(0.75)), 2 * (0.3 * np.sqrt(0.75) + 0.1 * 0.5)),
    ],
)
def test_a_rotated_round_shape_is_not_larger(shape: str, x: float, z: float) -> None:
    text = TURNED.replace("SHAPE", shape)
    found = {one["name"]: one["size"] for one in told(text)["entities"]}
    with scenecc.load_scene(io.StringIO(text), render=False) as batch:
        rows = {row.name: row.size for row in summarize(batch.plan, batch)}
    for sizes in (found, rows):
        assert sizes["body"] == pytest.approx([x, 0.2, z], abs=1e-5)
        assert sizes["robot"] == pytest.approx([x, 0.2, z], abs=1e-5)
