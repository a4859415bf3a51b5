"""Environments of scene files, and scene builders in tasks that are written by hand."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenecc import SceneError, replay

TABLE = """\
scenecc: 1
description: A cube above a table.
physics: {timestep: 0.005, solver_position_iterations: 20}
params:
  robot_init_qpos_noise: {type: number, default: 0.5}
entities:
  table: {body_type: static, shapes: [{type: box, half_size: [0.5, 0.5, 0.1]}], pose: [0, 0, -0.1]}
  cube:
    shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]
    density: {uniform: [100, 1000]}
    pose: {p: [{uniform: [-0.1, 0.1]}, 0, "${robot_init_qpos_noise}"]}
  goal: {body_type: kinematic, visuals: [{type: sphere, radius: 0.02}], pose: [0, 0, {uniform: [0.2, 0.3]}]}
"""

NAMES = iter(f"Made{number}-v0" for number in range(1000))


@pytest.fixture
def table(tmp_path: Path) -> Path:
    file = tmp_path / "table.yaml"
    file.write_text(TABLE)
    return file


def make(source: Any, **options: Any) -> Any:
    import gymnasium

    from scenecc.maniskill import register_env

    made = {name: options.pop(name) for name in ("obs_mode", "control_mode") if name in options}
    name = next(NAMES)
    register_env(name, source, **options)
    return gymnasium.make(name, render_backend="none", **made)


def test_a_file_is_an_environment(table: Path) -> None:
    env = make(table, max_episode_steps=3)
    observation, _ = env.reset(seed=0)
    assert observation.shape == (1, 26)
    assert env.unwrapped.sim_freq == 200
    assert env.action_space.shape == (0,)
    steps = [env.step(env.action_space.sample()) for _ in range(3)]
    assert [bool(truncated) for *_, truncated, _ in steps] == [False, False, True]
    assert all(float(reward) == 0 and not terminated for _, reward, terminated, *_ in steps)
    after = steps[-1][0]
    assert after[0, 2] < observation[0, 2]
    assert (after[0, 13:] == observation[0, 13:]).all()


def test_resets_repeat_by_their_seed_and_go_on_without_one(table: Path) -> None:
    env, other = make(table), make(table)
    first, _ = env.reset(seed=3)
    again, _ = env.reset()
    assert (again != first).any()
    assert (env.reset(seed=3)[0] == first).all()
    assert (env.reset()[0] == again).all()
    assert (other.reset(seed=3)[0] == first).all()
    assert (other.reset(seed=4)[0] != first).any()


def test_what_is_built_is_drawn_when_the_environment_is_configured(table: Path) -> None:
    env = make(table)

    def mass(**options: Any) -> float:
        env.reset(**options)
        return float(env.unwrapped.scene.actors["cube"].mass)

    built = mass(seed=1)
    assert mass(seed=2) == built
    one = mass(seed=1, options={"reconfigure": True})
    two = mass(seed=2, options={"reconfigure": True})
    assert one != two
    assert mass(seed=1, options={"reconfigure": True}) == one
    fixed = make(table, seed=7)
    masses = {float(env.unwrapped.scene.actors["cube"].mass) for env in (fixed, make(table, seed=7))}
    assert len(masses) == 1


def test_a_passport_builds_an_episode_again_without_maniskill(table: Path) -> None:
    env = make(table)
    env.reset(seed=3)
    _, info = env.reset()
    env.step(env.action_space.sample())
    text = str(info["passport"][0])
    drawn = info["draws"][0]
    content = json.loads(text)
    assert content["params"] == {"robot_init_qpos_noise": 0.02}
    assert content["seed"] != content["reset"]["seed"]
    env.reset(seed=4)
    with replay(text, file=table, render=False) as batch:
        assert batch.passport(0) == text
        starts = [batch.entities[name].pose[0] for name in ("cube", "goal")]
        assert {name: value.tolist() for name, value in drawn.items()} == {
            name: rows[0].tolist() for name, rows in batch.drawn().items()
        }
        cube: Any = batch.entities["cube"].objs[0].components[0]
        mass = cube.mass
    env.reset(seed=3)
    env.reset()
    actors = env.unwrapped.scene.actors
    assert [actors[name].pose.raw_pose[0].tolist() for name in ("cube", "goal")] == [one.tolist() for one in starts]
    assert float(actors["cube"].mass) == mass
    assert env.unwrapped.scene_builder.loaded.passport(0) == text


def test_a_state_can_be_taken_and_set(table: Path) -> None:
    env = make(table).unwrapped
    env.reset(seed=1)
    state, whole = env.get_state_dict(), env.get_state()
    assert list(state["actors"]) == ["cube", "goal"]
    for _ in range(5):
        env.step(None)
    assert (env.get_state() != whole).any()
    env.set_state_dict(state)
    assert (env.get_state() == whole).all()


GIVEN = [({}, 0.02), ({"robot_init_qpos_noise": 0.1}, 0.1), ({"params": {"robot_init_qpos_noise": 0.3}}, 0.3)]


@pytest.mark.parametrize(("given", "height"), GIVEN)
def test_the_noise_of_a_robot_is_a_parameter_of_the_file(table: Path, given: dict[str, Any], height: float) -> None:
    env = make(table, **given)
    env.reset(seed=0)
    assert float(env.unwrapped.scene.actors["cube"].pose.p[0, 2]) == pytest.approx(height)


def test_noise_for_a_file_without_the_parameter_is_an_error() -> None:
    with pytest.raises(SceneError, match="robot_init_qpos_noise"):
        make({"scenecc": 1, "entities": {}}, robot_init_qpos_noise=0.1)


def test_errors_of_a_scene_are_reported_when_it_is_registered(table: Path) -> None:
    from scenecc.maniskill import register_env

    table.write_text(TABLE.replace("cube:", "cube: {}\n  cube2:"))
    with pytest.raises(SceneError):
        register_env(next(NAMES), table)
    with table.open() as stream, pytest.raises(TypeError, match="stream"):
        register_env(next(NAMES), stream)


def test_a_name_is_registered_once(table: Path) -> None:
    from scenecc.maniskill import register_env

    name = next(NAMES)
    register_env(name, table)
    with pytest.raises(ValueError, match=f"'{name}' already"):
        register_env(name, table)
    assert register_env(name, table, override=True).__doc__ == "A cube above a table."


ARM = {
    "urdf": "pkg://mani_skill/assets/robots/panda/panda_v2.urdf",
    "pose": [-0.615, 0, 0],
    "qpos": [{"uniform": [-0.1, 0.1]}, 0.4, 0, -2, 0, 2.4, 0.8, 0.04, 0.04],
}


def test_robots_that_no_agent_controls_are_warned_of() -> None:
    ball = [{"type": "sphere", "radius": 0.1}]
    hand = {"name": "hand", "joint": {"name": "elbow", "type": "revolute"}, "shapes": ball}
    base = {"name": "base", "shapes": ball, "children": [hand]}
    for name, warned in (("fetch", 1), ("crane", 0)):
        document = {"scenecc": 1, "entities": {name: {"root": base, "pose": [2, 0, 0.5]}}}
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            env = make(document, robot_uids="panda", obs_mode="none")
            env.close()
        told = [str(one.message) for one in found if "no agent controls" in str(one.message)]
        assert len(told) == warned, name
        assert all("('fetch')" in text and "'panda' in addition" in text for text in told)


def test_an_articulation_of_the_agents_name_is_its_robot() -> None:
    document = {"scenecc": 1, "entities": {"panda": ARM}}
    env = make(document, robot_uids="panda", obs_mode="state_dict", control_mode="pd_joint_pos")
    observation, _ = env.reset(seed=0)
    plain = env.unwrapped
    assert plain.agent.robot is plain.scene.articulations["panda"]
    assert list(plain.scene.articulations) == ["panda"]
    assert observation["extra"] == {}
    start = observation["agent"]["qpos"][0].numpy()
    assert start[1:] == pytest.approx([0.4, 0, -2, 0, 2.4, 0.8, 0.04, 0.04])
    # The drives are the controller's, and hold where the episode starts.
    held = np.array([*start[:7], 1], np.float32)
    for _ in range(10):
        observation, *_ = env.step(held)
    assert observation["agent"]["qpos"][0].numpy() == pytest.approx(start, abs=2e-3)
    assert plain.agent.tcp.name == "panda_hand_tcp"


def test_an_agent_missing_from_the_file_is_built_by_maniskill(table: Path) -> None:
    from mani_skill.agents.robots.panda.panda import Panda

    env = make(table, robot_uids="panda", obs_mode="state_dict")
    observation, _ = env.reset(seed=0)
    assert list(observation["extra"]) == ["cube", "goal"]
    rest = next(iter(Panda.keyframes.values())).qpos
    assert observation["agent"]["qpos"][0].numpy() == pytest.approx(rest)
    env.step(env.action_space.sample())


def test_an_articulation_without_agent_is_observed() -> None:
    observation, _ = make({"scenecc": 1, "entities": {"arm": ARM}}, obs_mode="state_dict").reset(seed=0)
    assert observation["extra"]["arm"].shape == (1, 13 + 2 * 9)


def test_a_scene_builder_works_in_a_task(table: Path) -> None:
    import gymnasium
    from mani_skill.envs.sapien_env import BaseEnv
    from mani_skill.utils.registration import register_env

    from scenecc.maniskill import sim_config
    from scenecc.maniskill.environment import YamlSceneBuilder

    name = next(NAMES)

    class Task(BaseEnv):
        @property
        def _default_sim_config(self) -> Any:
            return sim_config(table)

        def _load_scene(self, options: dict[str, Any]) -> None:
            self.scene_builder = YamlSceneBuilder(self, table)
            assert self.scene_builder.sensor_configs == []
            with pytest.raises(RuntimeError, match="build"):
                self.scene_builder.initialize([0])
            self.scene_builder.build()

        def _initialize_episode(self, env_idx: Any, options: dict[str, Any]) -> None:
            self.scene_builder.initialize(env_idx)

    register_env(name)(Task)
    env = gymnasium.make(name, render_backend="none", robot_uids="panda").unwrapped
    builder: Any = env.scene_builder  # pyright: ignore[reportAttributeAccessIssue]
    assert list(builder.scene_objects) == ["table", "cube", "goal"]
    assert list(builder.movable_objects) == ["cube"]
    assert builder.articulations == {}
    assert not builder.builds_lighting
    env.reset(seed=1)
    first = builder.scene_objects["cube"].pose.raw_pose
    env.reset(seed=2)
    assert (builder.scene_objects["cube"].pose.raw_pose != first).any()
    env.reset(seed=1)
    assert (builder.scene_objects["cube"].pose.raw_pose == first).all()
    with pytest.raises(ValueError, match="no configurations"):
        builder.build([0])


def test_settings_become_the_environments(table: Path) -> None:
    from scenecc.maniskill import sim_config

    table.write_text(
        "scenecc: 1\n"
        "physics:\n"
        "  timestep: 0.004\n"
        "  gravity: [0, 0, -1.62]\n"
        "  contact_offset: 0.01\n"
        "  cpu_workers: 2\n"
        "  default_material: {static_friction: 0.5, dynamic_friction: 0.4, restitution: 0.1}\n"
        "  scene_spacing: 3\n"
        "  gpu_memory: {heap_capacity: 1048576}\n"
    )
    config = sim_config(table).dict()
    assert config["sim_freq"] == 250
    assert config["control_freq"] == 10  # the next below ManiSkill's 20 that divides the steps
    assert config["scene_config"]["gravity"] == [0, 0, -1.62]
    assert config["scene_config"]["contact_offset"] == 0.01
    assert config["scene_config"]["cpu_workers"] == 2
    assert config["default_materials_config"] == {"static_friction": 0.5, "dynamic_friction": 0.4, "restitution": 0.1}
    assert config["spacing"] == 3
    assert config["gpu_memory_config"]["heap_capacity"] == 1048576
    # What the file leaves out is ManiSkill's.
    assert config["scene_config"]["solver_position_iterations"] == 15
    assert sim_config(table, control_freq=50).control_freq == 50
    with pytest.raises(ValueError, match="250 steps"):
        sim_config(table, control_freq=3)


def test_a_time_step_that_does_not_divide_a_second_is_reported(table: Path) -> None:
    from scenecc.maniskill import sim_config

    table.write_text("scenecc: 1\nphysics:\n  timestep: 0.003\n")
    with pytest.raises(SceneError, match=r"0\.003 s gives 333\.333") as caught:
        sim_config(table)
    assert [(d.code, d.location.line) for d in caught.value.diagnostics] == [("SC810", 3)]


def test_without_maniskill_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    import scenecc.maniskill

    monkeypatch.delitem(sys.modules, "scenecc.maniskill.environment", raising=False)
    monkeypatch.delitem(sys.modules, "scenecc.backends.maniskill.compat", raising=False)
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(ImportError, match=r"pip install .*\[maniskill\]"):
        _ = scenecc.maniskill.YamlSceneBuilder
