"""Towers: each stands relative to the one below, and the recipe of the topmost can still be written and read."""

from __future__ import annotations

import io

import numpy as np
import pytest

from scenecc import compile_scene, load_scene
from scenecc.plan import ScenePlan
from scenecc.plan.shared_poses import MOST_COMPOSED, is_pose
from scenecc.plan.to_json import plan_to_json
from scenecc.variation.evaluation import Batch

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


@pytest.mark.parametrize("count", [MOST_COMPOSED - 2, MOST_COMPOSED, 60])
def test_a_tower_is_reset_as_it_is_built(count: int) -> None:
    plan, other = tower(count), tower(count, seed=5)
    read = compile_scene(io.StringIO(plan_to_json(plan)))
    assert read == plan
    assert any(is_pose(name) for name, _ in plan.draws) is (count >= MOST_COMPOSED)
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
        with pytest.raises(ValueError, match="those that it can: lean"):
            batch.reset(draws={"b_15.pose": np.zeros((4, 7))})
        batch.reset(seed=3, draws={"lean": np.zeros(4)})
