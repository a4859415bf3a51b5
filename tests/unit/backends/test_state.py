"""Saving and restoring where everything is."""

from __future__ import annotations

import pickle
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sapien
from unit.backends.drawn import heap
from unit.backends.test_reset import live

from scenecc.backends.sapien import EntityState, SceneBatch, SceneState
from scenecc.plan import ScenePlan

SCENES = 3


@pytest.fixture
def batch() -> Iterator[SceneBatch]:
    with live(heap(SCENES, seed=3)) as built:
        yield built


def shifted(state: SceneState, **changed: Any) -> SceneState:
    """A state whose `body_0` is another."""
    return replace(state, entities={**state.entities, "body_0": replace(state.entities["body_0"], **changed)})


def test_a_state_has_poses_velocities_and_sleep_of_all_entities(batch: SceneBatch) -> None:
    batch.step(10)
    state = batch.state()
    assert state.scene_idxs == (0, 1, 2)
    assert list(state.entities) == list(batch.entities)
    body = state.entities["body_4"]
    assert body.scene_idxs == (0, 2)
    assert (body.pose == batch.entities["body_4"].pose).all()
    assert (body.linear_velocity == batch.entities["body_4"].linear_velocity).all()
    assert (body.angular_velocity == batch.entities["body_4"].angular_velocity).all()
    assert all(array.dtype == np.float32 for array in (body.pose, body.linear_velocity, body.angular_velocity))
    assert body.dynamic.all()
    assert not body.asleep.any()
    pusher, marker = state.entities["pusher"], state.entities["marker"]
    assert not pusher.dynamic.any()
    assert np.isnan(pusher.kinematic_target).all()
    assert (marker.linear_velocity == 0).all()


@pytest.mark.parametrize("exact", [False, True])
def test_a_restored_state_is_read_again_to_the_bit(exact: bool, batch: SceneBatch) -> None:
    saved: list[SceneState] = []
    for steps in (0, 1, 30, 200, 700):
        batch.step(steps)
        saved.append(batch.state())
    assert saved[-1].entities["body_0"].asleep.any()
    for state in reversed(saved):
        batch.set_state(state, exact=exact)
        assert batch.state() == state
        batch.step(3)
        assert batch.state() != state


def test_a_state_fits_another_batch_of_the_same_plan_and_survives_pickling(batch: SceneBatch) -> None:
    batch.step(50)
    state = pickle.loads(pickle.dumps(batch.state()))
    assert state == batch.state()
    assert hash(state.entities["body_0"]) == hash(batch.state().entities["body_0"])
    other = live(heap(SCENES, seed=99))
    other.set_state(state)
    assert other.state() == state


def test_a_state_can_be_restored_in_some_scenes(batch: SceneBatch) -> None:
    batch.step(20)
    saved = batch.state()
    batch.step(20)
    later = batch.state()
    batch.set_state(saved, scene_idxs=[1])
    assert batch.state([1]) == live_part(saved, 1)
    assert batch.state([0, 2]).entities["body_0"] == later.entities["body_0"].rows([0, 2])
    one = batch.state([2])
    assert one.scene_idxs == (2,)
    batch.step(5)
    batch.set_state(one)
    assert batch.state([2]) == one
    some = live(heap(SCENES), scene_idxs=[2])
    some.set_state(saved, scene_idxs=[2])
    assert some.state() == live_part(saved, 2)


def live_part(state: SceneState, scene: int) -> SceneState:
    found = {
        name: [row for row, i in enumerate(each.scene_idxs) if i == scene] for name, each in state.entities.items()
    }
    return SceneState((scene,), {name: state.entities[name].rows(rows) for name, rows in found.items() if rows})


def test_a_kinematic_target_is_restored(batch: SceneBatch) -> None:
    component: Any = batch.entities["pusher"].objs[1].components[0]
    component.set_kinematic_target(sapien.Pose([0, 0, 3]))
    state = batch.state()
    assert state.entities["pusher"].kinematic_target[1].tolist() == [0, 0, 3, 1, 0, 0, 0]
    batch.step()
    assert batch.entities["pusher"].pose[1, 2] == 3
    batch.set_state(state)
    assert batch.state() == state
    assert batch.entities["pusher"].pose[1, 2] == pytest.approx(0.1)
    batch.step()
    assert batch.entities["pusher"].pose[:, 2].tolist() == pytest.approx([0.1, 3, 0.1])


def test_removed_entities_have_a_state(batch: SceneBatch) -> None:
    batch.step(20)
    batch.remove("body_1")
    state = batch.state()
    assert "body_1" in state.entities
    batch.add("body_1")
    batch.step(5)
    batch.remove("body_1")
    batch.set_state(state)
    assert "body_1" not in batch.entities
    assert batch.state() == state


def without(plan: ScenePlan, name: str) -> ScenePlan:
    return replace(plan, entities=tuple(entity for entity in plan.entities if entity.name != name))


def test_states_of_other_plans_are_refused(batch: SceneBatch) -> None:
    state = batch.state()
    batch.step(2)
    before = batch.state()
    fewer = live(without(heap(SCENES), "body_3")).state()
    with pytest.raises(
        ValueError, match=r"another plan: 'body_3' is in the scenes none there, and in \[0, 1, 2\] here"
    ):
        batch.set_state(fewer)
    with pytest.raises(
        ValueError, match=r"another plan: 'body_3' is in the scenes \[0, 1, 2\] there, and in none here"
    ):
        live(without(heap(SCENES), "body_3")).set_state(state)
    with pytest.raises(KeyError, match="no scene 2"):
        live(heap(2)).set_state(state)
    with pytest.raises(ValueError, match="the state has no scene 2"):
        batch.set_state(live(heap(2)).state(), scene_idxs=[2])
    assert batch.state() == before


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"pose": np.zeros((3, 7), np.float32)}, "unit"),
        ({"pose": np.zeros((2, 7), np.float32)}, r"pose of 'body_0' must be \(3, 7\), not \(2, 7\)"),
        ({"linear_velocity": np.full((3, 3), np.nan, np.float32)}, "finite"),
        ({"angular_velocity": np.zeros(3, np.float32)}, r"must be \(3, 3\)"),
        ({"asleep": np.zeros(2, np.bool_)}, r"asleep of 'body_0' must be \(3,\)"),
        ({"dynamic": np.array([True, False, True])}, "'body_0' not dynamic in scene 1, where it is dynamic here"),
    ],
    ids=str,
)
def test_states_that_the_engine_cannot_hold_are_refused(changed: dict[str, Any], words: str, batch: SceneBatch) -> None:
    state = batch.state()
    batch.step(2)
    before = batch.state()
    with pytest.raises(ValueError, match=words):
        batch.set_state(shifted(state, **changed))
    assert batch.state() == before


def test_a_state_may_be_edited(batch: SceneBatch) -> None:
    state = batch.state()
    state.entities["body_0"].pose[:, 2] += 1
    batch.set_state(state)
    assert batch.state() == state
    assert isinstance(state.entities["body_0"], EntityState)


def test_states_that_differ_by_one_bit_are_not_equal(batch: SceneBatch) -> None:
    state = batch.state()
    negative = shifted(state, linear_velocity=-0.0 * np.abs(state.entities["body_5"].linear_velocity))
    zero = shifted(state, linear_velocity=0.0 * np.abs(state.entities["body_5"].linear_velocity))
    assert negative != zero
    assert zero == shifted(state, linear_velocity=np.zeros((3, 3), np.float32))
    assert state != "a state"
    assert state.entities["body_0"] != "a state"
