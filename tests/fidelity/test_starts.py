"""Starts: a scene begins exactly where it rested, after each build and reset, and moves from there in the same way."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc import SceneBatch, SettledScenes
from scenecc.starts import file as starts_file

SCENE: dict[str, Any] = {
    "scenecc": 1,
    "name": "shelf",
    "num_scenes": 2,
    "params": {"height": 0.1},
    "draws": {"where": {"uniform": [-0.2, 0.2]}},
    "entities": {
        "ground": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "cube": {
            "shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.05]}],
            "mass": {"uniform": [0.5, 1.5]},
            "pose": {"p": ["${where}", 0, "${height}"], "rpy": [0, 0, {"uniform": [0, 1]}]},
        },
        "ball": {
            "shapes": [{"type": "sphere", "radius": 0.05}],
            "pose": [0, 1, 0.06],
            "angular_velocity": [0, 0, 3],
        },
        "door": {
            "root": {
                "name": "frame",
                "children": [
                    {
                        "name": "leaf",
                        "joint": {"name": "hinge", "type": "revolute", "axis": [0, 1, 0], "limits": [-1, 1]},
                        "mass": 1,
                        "shapes": [{"type": "box", "half_size": [0.1, 0.02, 0.02], "pose": [0.1, 0, 0]}],
                    }
                ],
            },
            "fix_root_link": True,
            "pose": [0, -1, 1],
            "qpos": {"hinge": {"uniform": [-0.2, 0.2]}},
            "drives": {"hinge": {"stiffness": 50, "damping": 20}},
        },
    },
}
SEEDS = (3, 4, 7)


@pytest.fixture(scope="module")
def settled() -> SettledScenes:
    return scenecc.settle_scene(SCENE, seeds=SEEDS)


@pytest.fixture
def starts(settled: SettledScenes, tmp_path: Path) -> Path:
    settled.write(tmp_path / "starts.json")
    return tmp_path / "starts.json"


def assert_at_start(batch: SceneBatch, settled: SettledScenes, seed: int) -> None:
    """Every scene is at its start with this seed, to the last bit, with the masses of this seed."""
    state = batch.state()
    for row in settled.content.rows:
        if row.seed != seed:
            continue
        for name, pose in row.poses.items():
            assert state.all[name].pose[row.scene].tolist() == np.array(pose, np.float32).tolist()
            assert not state.all[name].linear_velocity[row.scene].any()
            assert not state.all[name].angular_velocity[row.scene].any()
        assert batch.articulations["door"].qpos[row.scene, 0] == np.float32(row.joints["door"]["hinge"])
        with scenecc.load_scene(SCENE, seed=seed, render=False) as plain:
            masses = plain.state().drawn["cube.mass"].numbers[row.scene]
        assert state.drawn["cube.mass"].numbers[row.scene].tolist() == masses.tolist()


def test_builds_and_resets_begin_at_the_starts_to_the_bit(settled: SettledScenes, starts: Path) -> None:
    assert settled.summary() == "kept 6 of 6"
    with scenecc.load_scene(SCENE, starts=starts, render=False) as batch:
        assert_at_start(batch, settled, 3)  # of seed 0, which has no start, the first
        for seed, used in {4: 4, 7: 7, 1: 4, 2: 7, 9: 3}.items():
            batch.step(3)
            batch.reset(seed)
            assert_at_start(batch, settled, used)
    with scenecc.load_scene(SCENE, seed=7, starts=starts, render=False) as batch:
        assert_at_start(batch, settled, 7)


def test_drawn_values_are_those_of_the_start_after_a_build_and_a_reset(starts: Path) -> None:
    with scenecc.load_scene(SCENE, starts=starts, seed=2, render=False) as batch:  # its start is that of 7
        built = batch.drawn()
        batch.reset(4)
        batch.reset(7)
        again = batch.drawn()
        assert again.keys() == built.keys() >= {"cube.pose", "cube.mass", "door/hinge.qpos"}
        assert all(again[name].tolist() == rows.tolist() for name, rows in built.items())
        assert again["cube.pose"].astype(np.float32).tolist() == batch.entities["cube"].pose.tolist()
        assert again["door/hinge.qpos"].astype(np.float32).tolist() == batch.articulations["door"].qpos[:, 0].tolist()


def test_placed_bodies_can_be_read_after_a_reset_to_a_start(tmp_path: Path) -> None:
    floor = {"body_type": "static", "shapes": [{"type": "box", "half_size": [1, 1, 0.1]}]}
    cube = {"shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.05]}], "place": {"on": "floor"}}
    placed = {"scenecc": 1, "num_scenes": 2, "entities": {"floor": floor, "cube": cube}}
    scenecc.settle_scene(placed, seeds=(0, 1)).write(tmp_path / "starts.json")
    with scenecc.load_scene(placed, starts=tmp_path / "starts.json", render=False) as batch:
        batch.reset(1)
        poses = batch.drawn_rows()[1]["cube.pose"]
        assert np.asarray(poses, np.float32).tolist() == batch.entities["cube"].pose[1].tolist()


def test_two_loads_and_a_reset_move_in_the_same_way(starts: Path) -> None:
    plan = scenecc.compile_scene(SCENE, starts=starts)
    text = scenecc.plan_text(plan)
    with (
        scenecc.load_scene(SCENE, starts=starts, render=False) as first,
        scenecc.load_scene(text, render=False) as second,
    ):
        begun = first.state()
        assert begun == second.state()
        for batch in (first, second):
            batch.step(100)
        moved = first.state()
        assert moved == second.state()
        second.reset(exact=True)
        assert second.state() == begun
        second.step(100)
        assert second.state() == moved


def test_drawn_values_are_those_of_the_start(tmp_path: Path) -> None:
    place = {"on": "ground", "region": [[1, 1], [2, 2]]}
    placed = {"shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.02]}], "place": place}
    entities = {name: SCENE["entities"][name] for name in ("ground", "cube", "door")}
    scene = {**SCENE, "entities": {**entities, "placed": placed}}
    settled = scenecc.settle_scene(scene, seeds=(3, 4))
    settled.write(tmp_path / "starts.json")
    (plain,) = scenecc.scene_draws(scene, seeds=[4])
    with scenecc.load_scene(scene, seed=1, starts=tmp_path / "starts.json", render=False) as batch:
        begun = batch.drawn()
        batch.reset(3)
        assert batch.drawn()["cube.mass"].tolist() != begun["cube.mass"].tolist()
        batch.reset(1)
        state, again = batch.state(), batch.drawn()
    for name in ("where", "cube.mass"):  # of seed 4, because seed 1 has no start
        assert begun[name].tolist() == plain.values[name].tolist()
    assert {name: rows.tolist() for name, rows in again.items()} == {
        name: rows.tolist() for name, rows in begun.items()
    }
    for name in ("cube", "placed"):
        assert begun[f"{name}.pose"].astype(np.float32).tolist() == state.all[name].pose.tolist()
    assert begun["door/hinge.qpos"].astype(np.float32).tolist() == state.articulations["door"].qpos[:, 0].tolist()


def test_all_is_still_at_a_start(starts: Path) -> None:
    with scenecc.load_scene(SCENE, starts=starts, render=False) as batch:
        before = batch.state()
        batch.step(50)
        for name, state in batch.state().all.items():
            assert np.abs(state.pose - before.all[name].pose)[:, :3].max() < 1e-3, name


def test_large_starts_are_in_a_table(
    settled: SettledScenes, tmp_path: Path, starts: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pyarrow")
    monkeypatch.setattr(starts_file, "LARGEST_INLINE", 100)
    settled.write(tmp_path / "large.json")
    assert {path.name for path in tmp_path.iterdir()} == {"starts.json", "large.json", "large.parquet"}
    assert scenecc.compile_scene(SCENE, starts=tmp_path / "large.json") == scenecc.compile_scene(SCENE, starts=starts)
    table = tmp_path / "large.parquet"
    table.write_bytes(table.read_bytes()[:-1] + b"0")
    (fault,) = scenecc.validate(SCENE, starts=tmp_path / "large.json")
    assert (fault.code, "its table `large.parquet`" in fault.message) == ("SC935", True)


def test_built_draws_belong_to_their_seed(tmp_path: Path) -> None:
    sizes = {"half_size": [{"uniform": [0.05, 0.1]}, 0.05, 0.05], "type": "box"}
    drawn = {**SCENE, "entities": {**SCENE["entities"], "cube": {"shapes": [sizes], "pose": [0, 0, 0.1]}}}
    settled = scenecc.settle_scene(drawn, seeds=(3, 4))
    settled.write(tmp_path / "starts.json")
    with pytest.raises(scenecc.SceneError, match=r"(?s)no start with seed 0.*use one of its seeds \(3, 4\)"):
        scenecc.load_scene(drawn, starts=tmp_path / "starts.json", render=False)
    with scenecc.load_scene(drawn, seed=4, starts=tmp_path / "starts.json", render=False) as batch:
        begun = batch.state()
        batch.reset(3)
        assert batch.state() == begun  # every reset gives the start of the built sizes


def test_a_scene_that_breaks_an_expectation_is_dropped() -> None:
    cube = {"pose": [{"cycle": [0, 1]}, 0, 0.2], "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]}
    ground = {"body_type": "static", "shapes": [{"type": "plane"}]}
    expect = {"settled": {"seconds": 0.1}, "holds": [{"that": "${position('cube')[0] > 0.5}"}]}
    scene = {"scenecc": 1, "num_scenes": 2, "entities": {"ground": ground, "cube": cube}, "expect": expect}
    settled = scenecc.settle_scene(scene)
    assert [row.scene for row in settled.content.rows] == [1]
    told = "1 breaks `expect` (seed 0 scene 0: ${position('cube')[0] > 0.5})"
    assert settled.summary() == f"kept 1 of 2; dropped: {told}"


def test_a_pack_and_a_passport_contain_the_starts(settled: SettledScenes, tmp_path: Path) -> None:
    scene = tmp_path / "scene.yaml"
    scene.write_text(json.dumps({**SCENE, "starts": "starts.json"}))
    settled.write(tmp_path / "starts.json")
    scenecc.pack_scene(scene, tmp_path / "scene.scn")
    with scenecc.load_scene(scene, render=False) as batch:
        begun = batch.state()
        batch.reset(7)
        passport, reset = batch.passport(1), batch.state([1])
    with scenecc.replay(passport, file=scene, render=False) as again:
        assert again.state() == reset
    (tmp_path / "starts.json").unlink()
    with scenecc.load_scene(tmp_path / "scene.scn", render=False) as batch:
        assert batch.state() == begun


def test_an_episode_begins_at_the_start_of_its_seed(settled: SettledScenes, starts: Path) -> None:
    gymnasium = pytest.importorskip("gymnasium")
    from scenecc.gymnasium import SceneVectorEnv

    space = gymnasium.spaces.Box(-1, 1, (1,), np.float32)
    nothing: dict[str, Any] = {"action_space": space, "act": lambda _batch, _actions: None}
    envs = SceneVectorEnv(
        scenecc.load_scene(SCENE, starts=starts, render=False),
        observation=lambda batch: batch.entities["cube"].pose,
        reward=lambda batch: np.zeros(len(batch)),
        terminated=lambda batch: np.zeros(len(batch), np.bool_),
        **nothing,
    )
    observed, _ = envs.reset(seed=[4, 7])
    rows = {(row.seed, row.scene): row.poses["cube"] for row in settled.content.rows}
    assert observed.tolist() == np.array([rows[4, 0], rows[7, 1]], np.float32).tolist()
    envs.close()
