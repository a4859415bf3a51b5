"""Batches as vector environments of Gymnasium, held to its own checker and to its own vector environment."""

from __future__ import annotations

import json
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers.vector import RecordEpisodeStatistics

import scenecc
from scenecc import SceneBatch
from scenecc.extras import install_hint
from scenecc.gymnasium import SceneVectorEnv

RAIL = {
    "name": "slide",
    "type": "prismatic",
    "axis": [1, 0, 0],
    "limits": [-1, 1],
}
SCENE = {
    "scenecc": 1,
    "entities": {
        "cart": {
            "root": {
                "name": "rail",
                "children": [{"name": "car", "joint": RAIL, "mass": 1, "shapes": [{"type": "sphere", "radius": 0.1}]}],
            },
            "fix_root_link": True,
            "qpos": {"slide": {"uniform": [-0.5, 0.5]}},
            "drives": {"slide": {"stiffness": 100, "damping": 20}},
        }
    },
}


def observe(batch: SceneBatch) -> np.ndarray:
    cart = batch.articulations["cart"]
    return np.hstack([cart.qpos, cart.qvel])


def reward(batch: SceneBatch) -> np.ndarray:
    return -np.abs(batch.articulations["cart"].qpos[:, 0])


def at_the_end(batch: SceneBatch) -> np.ndarray:
    return np.abs(batch.articulations["cart"].qpos[:, 0]) > 0.6


def act(batch: SceneBatch, actions: np.ndarray) -> None:
    cart = batch.articulations["cart"]
    cart.drive_target = cart.qpos + 0.3 * actions


def make(count: int = 3, **options: Any) -> SceneVectorEnv:
    batch = scenecc.load_scene(SCENE, num_scenes=count, render=False, scene_idxs=options.pop("scene_idxs", None))
    functions: dict[str, Any] = {"observation": observe, "reward": reward, "terminated": at_the_end, "act": act}
    space = spaces.Box(-1, 1, (1,), np.float32)
    defaults = {"action_space": space, "steps_per_action": 5, "max_episode_steps": 20}
    return SceneVectorEnv(batch, **{**functions, **defaults, **options})


@pytest.fixture
def envs() -> Iterator[SceneVectorEnv]:
    made = make()
    yield made
    made.close()


class OneEnv(gymnasium.Env[Any, Any]):
    """One scene of three as Gymnasium's single environment; its episodes begin where `SceneVectorEnv` began them."""

    metadata = {"render_modes": []}  # noqa: RUF012

    def __init__(self, index: int = 0, **options: Any) -> None:
        self.envs = make(scene_idxs=[index], **options)
        self.observation_space = self.envs.single_observation_space
        self.action_space = self.envs.single_action_space
        self.begun: Any = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        if self.begun is None or seed is not None:
            self.begun = self.envs.reset(seed=seed)
        (observed, infos), self.begun = self.begun, None
        return observed[0], {"passport": str(infos["passport"][0])}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        observed, rewards, terminated, truncated, infos = self.envs.step(action[None])
        ended = bool(terminated[0] or truncated[0])
        self.begun = (observed, infos) if ended else None
        final = infos["final_obs"][0] if ended else observed[0]
        return final, float(rewards[0]), bool(terminated[0]), bool(truncated[0]), {}

    def close(self) -> None:
        self.envs.close()


def test_the_checker_of_gymnasium_passes() -> None:
    check_env(OneEnv(observation_space=spaces.Box(-10, 10, (2,), np.float32)), skip_render_check=True)


def written(*given: Any) -> tuple[Any, ...]:
    """What a reset or a step gives, with the passports as texts and without draws."""
    *others, infos = given
    infos = {name: values for name, values in infos.items() if name not in {"draws", "_draws"}}
    if "passport" in infos:
        infos["passport"] = np.array([one and str(one) for one in infos["passport"]], object)
    return (*others, infos)


@pytest.mark.parametrize("scale", [0.1, 1.0])
def test_it_behaves_like_a_vector_of_single_environments(scale: float) -> None:
    """Episodes are truncated with small actions, and end on their own with large ones."""
    ours = make(3)
    theirs = SyncVectorEnv([partial(OneEnv, i) for i in range(3)], autoreset_mode=AutoresetMode.SAME_STEP)
    assert ours.metadata["autoreset_mode"] is theirs.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    for name in ("observation_space", "action_space", "single_observation_space", "single_action_space"):
        assert getattr(ours, name) == getattr(theirs, name)
    assert data_equivalence(written(*ours.reset(seed=7)), theirs.reset(seed=[7, 7, 7]), exact=True)
    ours.action_space.seed(1)
    ends = np.zeros(2, int)
    for _ in range(60):
        actions = scale * np.abs(ours.action_space.sample())
        mine, others = written(*ours.step(actions)), theirs.step(actions)
        assert data_equivalence(mine, others, exact=True)
        ends += [mine[2].sum(), mine[3].sum()]
    assert ends[0 if scale == 1 else 1] > 5
    ours.close()
    theirs.close()


def test_an_episode_equals_a_reset_with_its_seed(envs: SceneVectorEnv) -> None:
    first, infos = envs.reset(seed=5)
    assert [str(one) for one in infos.pop("passport")] == [envs.batch.passport(index) for index in range(3)]
    draws = infos.pop("draws")
    drawn = envs.batch.drawn()
    assert [dict(one) for one in draws] == [{name: rows[index] for name, rows in drawn.items()} for index in range(3)]
    assert drawn["cart/slide.qpos"].astype(np.float32).tolist() == envs.batch.articulations["cart"].qpos[:, 0].tolist()
    assert infos.pop("_passport").all()
    assert infos.pop("_draws").all()
    assert infos == {}
    assert len(np.unique(first[:, 0])) == 3
    envs.batch.reset(seed=5)
    assert (observe(envs.batch) == first).all()
    mixed, _ = envs.reset(seed=[5, 6, 5])
    assert (mixed == first).all(axis=1).tolist() == [True, False, True]
    again = [envs.reset(seed=3)[0], envs.reset()[0], envs.reset()[0]]
    assert len({each.tobytes() for each in again}) == 3
    for expected, seed in zip(again, (3, None, None), strict=True):
        assert (envs.reset(seed=seed)[0] == expected).all()


def test_a_mask_resets_some_environments(envs: SceneVectorEnv) -> None:
    envs.reset(seed=1)
    for _ in range(3):
        before = envs.step(np.ones((3, 1), np.float32))[0]
    after, infos = envs.reset(seed=9, options={"reset_mask": np.array([False, True, False])})
    assert [one is None for one in infos["passport"]] == [True, False, True]
    assert json.loads(str(infos["passport"][1]))["reset"]["seed"] == 9
    assert pickle.loads(pickle.dumps(infos["passport"][1])) == envs.batch.passport(1)
    assert [one is None for one in infos["draws"]] == [True, False, True]
    assert pickle.loads(pickle.dumps(infos["draws"][1])) == {name: rows[1] for name, rows in envs.batch.drawn().items()}
    assert (after[::2] == before[::2]).all()
    assert (after[1] == envs.reset(seed=9)[0][1]).all()


def test_the_end_of_an_episode_gives_its_last_and_the_next_first_observation() -> None:
    envs = make(2, max_episode_steps=3, terminated=lambda batch: [False, False])
    envs.reset(seed=0)
    still = np.zeros((2, 1), np.float32)
    for _ in range(2):
        *_, truncated, infos = envs.step(still)
        assert not truncated.any()
        assert infos == {}
    observed, rewards, terminated, truncated, infos = envs.step(still)
    assert (truncated.all(), terminated.any(), rewards.dtype) == (True, False, np.float64)
    assert infos["_final_obs"].tolist() == infos["_final_info"].tolist() == [True, True]
    assert (np.stack(infos["final_obs"])[:, 0] != observed[:, 0]).all()
    assert rewards == pytest.approx([-abs(final[0]) for final in infos["final_obs"]])
    assert not observed[:, 1].any()
    envs.close()


def test_gymnasium_wrappers_work() -> None:
    envs = RecordEpisodeStatistics(make(2, max_episode_steps=4))
    envs.reset(seed=0)
    for _ in range(4):
        *_, infos = envs.step(np.zeros((2, 1), np.float32))
    assert infos["episode"]["l"].tolist() == [4, 4]
    envs.close()


def test_observations_may_be_a_dict() -> None:
    box = partial(spaces.Box, -np.inf, np.inf, (1,), np.float32)
    envs = make(
        2,
        observation=lambda batch: {"q": batch.articulations["cart"].qpos, "v": batch.articulations["cart"].qvel},
        observation_space=spaces.Dict({"q": box(), "v": box()}),
        max_episode_steps=1,
    )
    observed, _ = envs.reset(seed=0)
    assert observed in envs.observation_space
    *_, infos = envs.step(np.ones((2, 1), np.float32))
    assert infos["final_obs"][1]["v"] > 0
    envs.close()


def test_closing_the_environment_closes_the_batch(envs: SceneVectorEnv) -> None:
    envs.close()
    envs.close()
    with pytest.raises(RuntimeError, match="the batch is closed"):
        _ = envs.batch.scenes


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "steps": (lambda: make(steps_per_action=0), "steps_per_action must be at least 1, not 0"),
    "length": (lambda: make(max_episode_steps=0), "max_episode_steps must be at least 1, not 0"),
    "observation": (
        lambda: make(observation=lambda batch: np.zeros(4)),
        "`observation` must return one row for each of 3",
    ),
    "no array": (lambda: make(observation=lambda batch: {"a": 1}), "it needs an `observation_space`"),
}


@pytest.mark.parametrize("case", WRONG)
def test_invalid_environments_are_refused(case: str) -> None:
    make_it, message = WRONG[case]
    with pytest.raises(ValueError, match=message):
        make_it()


@pytest.mark.parametrize("name", ["reward", "terminated"])
def test_a_callback_must_return_one_value_per_scene(name: str) -> None:
    options: dict[str, Any] = {name: lambda batch: 0}
    envs = make(**options)
    envs.reset(seed=0)
    with pytest.raises(ValueError, match=rf"`{name}` must return one row for each of 3 scenes, not the shape \(\)"):
        envs.step(np.zeros((3, 1), np.float32))


FAULTY: dict[str, tuple[dict[str, Any], str]] = {
    "reward": ({"reward": lambda batch: [0, np.nan, 0]}, r"`reward` is NaN in scene 1"),
    "observation": ({"observation": lambda batch: np.full((3, 2), np.nan)}, "`observation` is NaN in scene 0–2"),
    "shape": (
        {"observation": lambda batch: np.zeros((3, 4))},
        r"`observation` must return the shape \(3, 2\), not \(3, 4\)",
    ),
    "ends": ({"terminated": lambda batch: [0.5] * 3}, "`terminated` must return bool, not float64"),
    "info": ({"info": lambda batch: {"success": [True]}}, r"`info\['success'\]` must return one row for each of 3"),
}


@pytest.mark.parametrize("case", FAULTY)
def test_a_callback_must_return_numbers(case: str) -> None:
    functions, message = FAULTY[case]
    envs = make(observation_space=spaces.Box(-np.inf, np.inf, (2,), np.float32), **functions)
    with pytest.raises(ValueError, match=message):
        _run(envs)
    envs.close()


def _run(envs: SceneVectorEnv) -> None:
    envs.reset(seed=0)
    envs.step(np.zeros((3, 1)))


@pytest.mark.parametrize("check", [False, True])
def test_a_diverging_simulation_raises(check: bool) -> None:
    ball = {"pose": [0, 0, 5], "linear_velocity": [2e6, 0, 0], "shapes": [{"type": "sphere", "radius": 0.1}]}
    source = {**SCENE, "entities": {**SCENE["entities"], "ball": ball}}
    functions: dict[str, Any] = {"observation": observe, "reward": reward, "terminated": at_the_end, "act": act}
    batch = scenecc.load_scene(source, num_scenes=3, render=False)
    envs = SceneVectorEnv(batch, **functions, action_space=spaces.Box(-1, 1, (1,), np.float32), check=check)
    with pytest.raises(scenecc.SceneError, match="SC820") if check else nullcontext():
        _run(envs)
    envs.close()


def test_infos_contain_step_and_final_values() -> None:
    def info(batch: SceneBatch) -> dict[str, Any]:
        return {"position": batch.articulations["cart"].qpos[:, 0]}

    envs = make(info=info, max_episode_steps=1, terminated=lambda batch: np.array([False, True, False]))
    observed, infos = envs.reset(seed=0)
    assert (infos["position"] == observed[:, 0]).all()
    observed, _, _, _, infos = envs.step(np.ones((3, 1)))
    assert (infos["position"] == observed[:, 0]).all()
    assert infos["_position"].all()
    final = np.stack(list(infos["final_obs"]))
    assert np.allclose(infos["final_info"]["position"], final[:, 0])
    assert (final != observed).any()
    envs.close()


def test_invalid_arguments_are_refused(envs: SceneVectorEnv) -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((3, 1)))
    with pytest.raises(TypeError, match=r"seed must be an integer, not 1\.5"):
        envs.reset(seed=1.5)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="the only option is reset_mask"):
        envs.reset(options={"mask": [True] * 3})
    envs.reset()
    with pytest.raises(ValueError, match=r"actions must have the shape \(3, 1\), not \(1,\)"):
        envs.step(np.zeros(1))
    with pytest.raises(ValueError, match="2 seeds for 3 environments"):
        envs.reset(seed=[1, 2])
    for mask in (np.zeros(3, bool), np.ones(2, bool), [1, 0, 1]):
        with pytest.raises(ValueError, match=r"reset_mask must be \(3,\) bool with at least one True"):
            envs.reset(options={"reset_mask": mask})


def test_a_missing_gymnasium_names_the_extra() -> None:
    script = "import sys, scenecc\nsys.modules['gymnasium'] = None\nimport scenecc.gymnasium"
    done = subprocess.run([sys.executable, "-c", script], check=False, timeout=60, capture_output=True, text=True)
    last = done.stderr.strip().splitlines()[-1]
    assert last.startswith("ImportError: scenecc.gymnasium needs Gymnasium")
    assert install_hint("gymnasium") in last


def test_only_this_module_loads_gymnasium() -> None:
    script = "import sys, scenecc, scenecc.scene\nprint('gymnasium' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], check=True, timeout=60, capture_output=True, text=True)
    assert done.stdout == "False\n"
