"""Poses relative to other things: long chains, robots of a file, and instances."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc import compile_scene, load_scene, validate
from scenecc.plan import ScenePlan
from scenecc.plan.json_codec import plan_to_json
from scenecc.plan.scene import MAX_COMPOSED_POSES, is_unnamed_draw
from scenecc.variation.evaluation import Batch

if TYPE_CHECKING:
    from pathlib import Path


TOWER = """scenecc: 1
num_scenes: 4
draws: {lean: {uniform: [0, 0.1]}}
entities:
  ground: {body_type: static, pose: {p: [{uniform: [0, 1]}, 0, 0]}, shapes: [{type: sphere, radius: 1}]}
  b_0: {pose: {relative_to: ground, p: [0, 0, 1]}, shapes: [{type: sphere, radius: 1}]}
  b:
    repeat: {i: {count: COUNT}}
    name: "b_${i + 1}"
    body_type: BODY
    pose: {relative_to: "b_${i}", p: [{uniform: [-0.01, 0.01]}, "${lean}", 1], rpy_deg: [0, 0, {uniform: [-3, 3]}]}
    shapes: [{type: sphere, radius: 1}]
  flag: {scene_idxs: "::2", pose: {relative_to: b_COUNT, p: [0, {normal: [0, 1]}, 1]}, shapes: [{type: sphere, radius: 1}]}
"""  # noqa: E501 - as files have it


def tower(count: int, *, seed: int = 0, body: str = "dynamic") -> ScenePlan:
    return compile_scene(io.StringIO(TOWER.replace("COUNT", str(count)).replace("BODY", body)), seed=seed)


@pytest.mark.parametrize("count", [MAX_COMPOSED_POSES - 2, MAX_COMPOSED_POSES, 60])
def test_a_tower_is_reset_as_it_is_built(count: int) -> None:
    plan, other = tower(count), tower(count, seed=5)
    read = compile_scene(io.StringIO(plan_to_json(plan)))
    assert read == plan
    assert any(is_unnamed_draw(name) for name, _ in plan.draws) is (count >= MAX_COMPOSED_POSES)
    # The ground stays, and all else is as a batch of that seed has it.
    ground, moved = (each.entities[0].pose.data for each in (plan, other))
    for entity, again in zip(read.entities[2:], other.entities[2:], strict=True):
        scenes = np.array(entity.scene_idxs)
        assert entity.pose.recipe is not None
        drawn = Batch(scenes, 5, 4, dict(read.draws), {}).evaluate(entity.pose.recipe)
        wanted = again.pose.data.copy()
        wanted[:, 0] += ground[scenes, 0] - moved[scenes, 0]
        assert np.allclose(drawn, wanted, atol=1e-12)
        same = Batch(scenes, 0, 4, dict(read.draws), {}).evaluate(entity.pose.recipe)
        assert same.tobytes() == entity.pose.data.tobytes()


def test_what_stands_still_may_be_a_long_chain_too() -> None:
    plan = tower(400, body="static")
    # What does not move cannot stand upon what does.
    assert all(entity.pose.recipe is None for entity in plan.entities[:-1])
    assert plan.entities[-1].pose.recipe is not None
    assert plan.entities[-2].pose.data[:, 2] == pytest.approx(401)


def test_the_poses_within_a_tower_are_no_draws_of_its_file() -> None:
    with load_scene(tower(40), render=False) as batch:
        with pytest.raises(ValueError, match="only these: lean"):
            batch.reset(draws={"b_15.pose": np.zeros((4, 7))})
        batch.reset(seed=3, draws={"lean": np.zeros(4)})


BALL = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
TWO = (
    f"<robot name='two'><link name='base'>{BALL}</link><link name='ball'>{BALL}</link>"
    "<joint name='free' type='floating'><parent link='base'/><child link='ball'/>"
    "<origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/></joint></robot>"
)
PREFAB = """scenecc: 1
entities:
  on: {pose: {p: [0, 0, 2], relative_to: r/ball}, shapes: [{type: sphere, radius: 0.1}]}
  r: {urdf: two.urdf, fix_root_link: false, pose: [0, 0, 5]}
"""
SCENE = """scenecc: 1
num_scenes: 3
frames:
  above: {pose: {p: [1, 0, 0.5], relative_to: r/ball}}
entities:
  before: {pose: {p: [1, 0, 0], relative_to: r/ball}, shapes: [{type: sphere, radius: 0.1}]}
  r: {urdf: two.urdf, fix_root_link: false, pose: [{uniform: [0, 9]}, 0, 5]}
  after: {pose: {p: [1, 0, 0], relative_to: r/ball}, shapes: [{type: sphere, radius: 0.1}]}
  framed: {pose: {relative_to: above}, shapes: [{type: sphere, radius: 0.1}]}
  p: {use: prefab.yaml, pose: [7, 0, 0]}
  outside: {pose: {p: [1, 0, 0], relative_to: p/r/ball}, shapes: [{type: sphere, radius: 0.1}]}
cameras:
  eye: {pose: {p: [1, 0, 0], relative_to: p/r/ball}}
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "two.urdf").write_text(TWO)
    (tmp_path / "prefab.yaml").write_text(PREFAB)
    (tmp_path / "scene.yaml").write_text(SCENE)
    return tmp_path / "scene.yaml"


def test_whatever_comes_first_in_the_file_it_stands_relative_to_the_robot(scene: Path) -> None:
    assert validate(scene) == []
    plan = compile_scene(scene)
    at = {entity.name: entity.pose.data[:, :3] for entity in plan.entities}
    ball = at["r/ball"]
    assert len(ball) == 3
    # The ball is turned by a quarter: its x is y.
    assert np.allclose(at["before"], ball + np.array([0, 1, 0]))
    assert np.array_equal(at["before"], at["after"])
    assert np.allclose(at["framed"], ball + np.array([0, 1, 0.5]))
    assert at["p/r/ball"].tolist() == [[7, 0, 6]]
    assert np.allclose(at["p/on"], [[7, 0, 8]])
    assert np.allclose(at["outside"], [[7, 1, 6]])
    assert np.allclose(plan.cameras[0].pose.data[:, :3], [[7, 1, 6]])


def test_it_follows_the_robot_at_a_reset(scene: Path) -> None:
    with load_scene(scene, render=False) as batch:
        before = batch.entities["r/ball"].pose
        batch.reset(seed=5)
        ball = batch.entities["r/ball"].pose
        assert (ball[:, 0] != before[:, 0]).all()
        for name in ("before", "after"):
            assert np.allclose(batch.entities[name].pose[:, :3], ball[:, :3] + [0, 1, 0], atol=1e-6)


WRONG: dict[str, tuple[str, str, list[tuple[str, str | None]]]] = {
    "no such robot": ("r/ball", "r/bal", [("SC303", "did you mean `r/ball`?")] * 3),
    "a circle": ("pose: [{uniform: [0, 9]}, 0, 5]", "pose: {relative_to: before}", [("SC304", None)]),
    # The ball of which nothing is known is not missed as well.
    "a torn file": ("urdf: two.urdf, fix_root_link: false, pose: [{", "urdf: three.urdf, pose: [{", [("SC401", None)]),
}


@pytest.mark.parametrize(("old", "new", "expected"), WRONG.values(), ids=WRONG)
def test_mistakes(scene: Path, old: str, new: str, expected: list[tuple[str, Any]]) -> None:
    text = SCENE.replace("  p: {use", "  q: {use").replace("p/r/ball", "q/r/ball")
    scene.write_text(text.replace(old, new) if old != "r/ball" else text.replace(": r/ball", ": r/bal"))
    found = validate(scene)
    assert [one.code for one in found] == [code for code, _ in expected]
    assert [one.hint for one in found if one.code == "SC303"] == [hint for _, hint in expected if hint]


def test_an_articulation_that_is_misspelt() -> None:
    ball = [{"type": "sphere", "radius": 0.1}]
    entities: dict[str, Any] = {
        "arm": {"root": {"name": "base", "shapes": ball}},
        "ball": {"shapes": ball, "pose": {"relative_to": "arm/base"}},
        "other": {"shapes": ball, "pose": {"relative_to": "amr"}},
    }
    hints = [(one.code, one.hint) for one in validate({"scenecc": 1, "entities": entities})]
    assert hints == [("SC303", "did you mean `arm`?")]


CHAIN = """scenecc: 1
num_scenes: 3
entities:
  snake: {urdf: snake.urdf, pose: [{uniform: [0, 1]}, 0, 1], qpos: QPOS}
  tip: {pose: {p: [0, 0, 0.1], relative_to: snake/l COUNT}, shapes: [{type: sphere, radius: 0.1}]}
constraints:
  glue: {type: weld, parent: snake/l COUNT, child: tip}
"""


@pytest.mark.parametrize("count", [MAX_COMPOSED_POSES, 2 * MAX_COMPOSED_POSES + 5])
def test_a_long_chain_of_joints_is_reset_as_it_is_built(tmp_path: Path, count: int) -> None:
    links = "".join(f"<link name='l {i}'>{BALL}</link>" for i in range(count + 1))
    joints = "".join(
        f"<joint name='j{i}' type='continuous'><parent link='l {i}'/><child link='l {i + 1}'/><axis xyz='0 1 0'/>"
        "<origin xyz='0 0 1'/></joint>"
        for i in range(count)
    )
    (tmp_path / "snake.urdf").write_text(f"<robot name='snake'>{links}{joints}</robot>")
    scene = tmp_path / "scene.yaml"
    qpos = "{" + ", ".join(f"j{i}: {{uniform: [-1, 1]}}" for i in range(count)) + "}"
    scene.write_text(CHAIN.replace("COUNT", str(count)).replace("QPOS", qpos))
    # Of the weld there is nothing to tell: what is relative to the link follows it.
    assert validate(scene) == []
    plan, other = compile_scene(scene), compile_scene(scene, seed=5)
    (tmp_path / "plan.json").write_text(plan_to_json(plan))
    read = compile_scene(tmp_path / "plan.json")
    assert read == plan
    for entity, again in zip(read.entities, other.entities, strict=True):
        assert entity.pose.recipe is not None
        drawn = Batch(np.arange(3), 5, 3, dict(read.draws), {}).evaluate(entity.pose.recipe)
        assert drawn.tobytes() == again.pose.data.tobytes()


def test_an_instance_stands_in_the_frame_of_a_link(tmp_path: Path) -> None:
    ball = [{"type": "sphere", "radius": 0.1}]
    (tmp_path / "part.yaml").write_text(
        "scenecc: 1\nentities: {ball: {pose: [0, 0, 1], shapes: [{type: sphere, radius: 0.1}]},"
        " arm: {root: {name: base, shapes: [{type: sphere, radius: 0.1}]}},"
        " top: {pose: {p: [0, 1, 0], relative_to: arm/base}, shapes: [{type: sphere, radius: 0.1}]}}"
    )
    tree = {
        "name": "base",
        "shapes": ball,
        "children": [
            {
                "name": "hand",
                "shapes": ball,
                "joint": {"name": "j", "type": "prismatic", "axis": "x", "limits": [0, 3], "origin": [0, 0, 1]},
            }
        ],
    }
    entities: dict[str, Any] = {
        "arm": {"root": tree, "qpos": {"j": 2.5}},
        "part": {"use": str(tmp_path / "part.yaml"), "pose": {"relative_to": "arm/hand", "p": [0, 0, 0.5]}},
        "outside": {"shapes": ball, "pose": {"relative_to": "part/arm/base", "p": [0, 0, 7]}},
    }
    plan = compile_scene({"scenecc": 1, "entities": entities}, asset_roots=[tmp_path])
    at = {entity.name: entity.pose.data[0, :3].tolist() for entity in plan.entities}
    assert at["part/ball"] == [2.5, 0, 2.5]
    assert at["part/top"] == [2.5, 1, 1.5]
    assert at["outside"] == [2.5, 0, 8.5]
