"""Reset: back to the start, drawn anew, in some scenes or all."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import sapien
from sapien import physx
from unit.backends.drawn import BODIES, heap, value

from scenecc.backends.sapien import SceneBatch, instantiate
from scenecc.diagnostics import Sink
from scenecc.plan import BodyStructure, Box, CollisionShape, Entity, Physics, ScenePlan, constant, per_scene, varying
from scenecc.variation.forms import Template
from scenecc.variation.nodes import Computed, Drawn, Key, Node, Posed, Stacked

SCENES = 4


def live(plan: ScenePlan, **options: Any) -> SceneBatch:
    batch = instantiate(plan, Sink(), render=False, **options)
    assert batch is not None
    return batch


@pytest.fixture
def batch() -> Iterator[SceneBatch]:
    with live(heap(SCENES, seed=3)) as built:
        yield built


def test_a_reset_is_the_start_of_a_batch_of_that_seed(batch: SceneBatch) -> None:
    batch.step(40)
    batch.reset(seed=7)
    assert batch.state() == live(heap(SCENES, seed=7)).state()
    batch.step(40)
    batch.reset(3)
    assert batch.state() == live(heap(SCENES, seed=3)).state()


def test_without_a_seed_the_last_one_of_each_scene_is_repeated(batch: SceneBatch) -> None:
    start = batch.state()
    batch.step(10)
    batch.reset()
    assert batch.state() == start
    batch.reset(seed=[5, 6], scene_idxs=[2, 0])
    batch.step(10)
    batch.reset()
    assert batch.state([0]) == live(heap(SCENES, seed=6)).state([0])
    assert batch.state([2]) == live(heap(SCENES, seed=5)).state([2])
    assert batch.state([1, 3]) == live(heap(SCENES, seed=3)).state([1, 3])


def test_scenes_that_are_not_reset_stay_untouched(batch: SceneBatch) -> None:
    batch.step(30)
    before = batch.state()
    batch.reset(seed=8, scene_idxs=[1])
    assert batch.state([0, 2, 3]).entities == {
        name: state.rows([row for row, index in enumerate(state.scene_idxs) if index != 1])
        for name, state in before.entities.items()
    }
    assert batch.state([1]) == live(heap(SCENES, seed=8)).state([1])
    assert batch.state([1]) != SceneBatch.state(live(heap(SCENES, seed=3)), [1])


def test_a_batch_of_some_scenes_is_reset_as_among_all() -> None:
    some = live(heap(SCENES, seed=3), scene_idxs=[3, 1])
    some.step(5)
    some.reset(seed=9)
    assert some.state() == live(heap(SCENES, seed=9)).state([1, 3])


def test_a_reset_keeps_engine_objects(batch: SceneBatch) -> None:
    scenes, objs = list(batch.scenes), {name: list(entity.objs) for name, entity in batch.entities.items()}
    ids = [entity.per_scene_id for scene in scenes for entity in scene.entities]
    order = [[entity.name for entity in scene.entities] for scene in scenes]
    batch.step(3)
    batch.reset(seed=1)
    assert batch.scenes == scenes
    assert {name: list(entity.objs) for name, entity in batch.entities.items()} == objs
    assert [entity.per_scene_id for scene in scenes for entity in scene.entities] == ids
    assert [[entity.name for entity in scene.entities] for scene in scenes] == order


def test_a_reset_restores_what_was_moved_by_hand(batch: SceneBatch) -> None:
    start = batch.state()
    for entity in batch.entities.values():
        entity.set_pose(sapien.Pose([1, 2, 3]))
    batch.entities["body_0"].linear_velocity = [9, 9, 9]
    component: Any = batch.entities["body_1"].objs[0].find_component_by_type(physx.PhysxRigidDynamicComponent)
    component.add_force_torque([0, 0, 1e4], [0, 0, 0])
    component.put_to_sleep()
    pusher: Any = batch.entities["pusher"].objs[0].components[0]
    pusher.set_kinematic_target(sapien.Pose([5, 5, 5]))
    batch.reset()
    assert batch.state() == start
    batch.step()
    fresh = live(heap(SCENES, seed=3))
    fresh.step()
    assert (batch.entities["body_1"].linear_velocity == fresh.entities["body_1"].linear_velocity).all()
    assert (batch.entities["pusher"].pose == fresh.entities["pusher"].pose).all()


def test_a_reset_wakes_bodies_for_as_long_as_new_ones() -> None:
    box = CollisionShape(Box(constant([0.1] * 3)))
    floor = Entity("floor", (0,), constant([0, 0, -0.1, 1, 0, 0, 0]), (BodyStructure("static", (box,)),))
    cube = Entity("cube", (0,), constant([0, 0, 0.1, 1, 0, 0, 0]), (BodyStructure("dynamic", (box,)),))
    batch = live(ScenePlan("rest", 1, (floor, cube), Physics()))
    component: Any = batch.entities["cube"].objs[0].components[0]

    def until_asleep() -> int:
        for step in range(200):
            if component.is_sleeping:
                return step
            batch.step()
        raise AssertionError("it never sleeps")

    first = until_asleep()
    batch.reset()
    assert not component.is_sleeping
    assert until_asleep() == first
    batch.reset()
    batch.step(first // 2)
    batch.reset()
    assert until_asleep() == first


def test_removed_entities_stay_removed_and_come_back_at_their_start(batch: SceneBatch) -> None:
    batch.remove("body_2")
    batch.step(20)
    batch.reset(seed=4)
    assert "body_2" not in batch.entities
    batch.add("body_2")
    fresh = live(heap(SCENES, seed=4))
    assert (batch.entities["body_2"].pose == fresh.entities["body_2"].pose).all()
    assert (batch.entities["body_2"].linear_velocity == fresh.entities["body_2"].linear_velocity).all()
    batch.step(5)


def test_a_body_that_was_made_kinematic_by_hand_is_put_back_too(batch: SceneBatch) -> None:
    component: Any = batch.entities["body_5"].objs[0].components[0]
    component.set_kinematic(True)
    batch.step(3)
    batch.reset()
    assert (batch.entities["body_5"].pose == live(heap(SCENES, seed=3)).entities["body_5"].pose).all()
    batch.step(3)


def test_given_draws_replace_drawing(batch: SceneBatch) -> None:
    batch.reset(draws={"push": [0.25, 0.5]}, scene_idxs=[3, 1])
    speeds = batch.entities["body_0"].linear_velocity[:, 0]
    assert speeds[[1, 3]].tolist() == [0.5, 0.25]
    start = live(heap(SCENES, seed=3)).entities["body_0"].linear_velocity[:, 0]
    assert speeds[[0, 2]].tolist() == start[[0, 2]].tolist()
    batch.reset()
    assert batch.entities["body_0"].linear_velocity[:, 0].tolist() == start.tolist()


@pytest.mark.parametrize(
    ("arguments", "error", "words"),
    [
        ({"seed": -1}, ValueError, "must not be negative"),
        ({"seed": True}, TypeError, "integer"),
        ({"seed": 1.5}, TypeError, r"a seed must be an integer, not 1\.5"),
        ({"seed": "a"}, TypeError, "a seed must be an integer, not 'a'"),
        ({"seed": [1, 2, "c", 4]}, TypeError, "a seed must be an integer, not 'c'"),
        ({"seed": [1, 2]}, ValueError, "2 seeds for 4 scenes"),
        ({"seed": [1, 2, 3], "scene_idxs": [0, 1]}, ValueError, "3 seeds for 2 scenes"),
        ({"scene_idxs": [4]}, KeyError, "no scene 4"),
        ({"scene_idxs": [0, 0]}, ValueError, "twice"),
        ({"scene_idxs": "0:4"}, TypeError, r"scene indices, as in \[0, 2\] or range\(4\), not '0:4'"),
        ({"scene_idxs": 3}, TypeError, r"scene indices, as in \[0, 2\] or range\(4\), not 3"),
        ({"scene_idxs": ["0"]}, TypeError, "a scene index must be an integer, not '0'"),
        ({"scene_idxs": np.array([True, False])}, TypeError, "mask"),
        ({"draws": {"half": [1] * 4}}, ValueError, "cannot change the shared draw 'half', only these: push"),
        ({"draws": {"push": [1, 2]}}, ValueError, r"must be of shape \(4,\)"),
        ({"draws": {"push": 1.0}}, ValueError, r"must be of shape \(4,\)"),
        ({"draws": {"push": [[1, 2]] * 4}}, ValueError, r"must be of shape \(4,\), .* not \(4, 2\)"),
        ({"draws": {"push": [None] * 4}}, ValueError, "must be of numbers, not of other objects"),
        ({"draws": {"push": ["a"] * 4}}, ValueError, "must be of numbers, as the file declares, not of texts"),
        ({"draws": {"push": [[1], [1, 2], [1], [1]]}}, ValueError, "must have rows of one length"),
        ({"draws": {"push": [0, 0, np.nan, 0]}}, ValueError, "must be of finite numbers: row 2 is nan"),
        ({"draws": {"push": [0, 1e39, 0, 0]}}, ValueError, "'body_0' in scene 1: the drawn linear_velocity is"),
    ],
    ids=str,
)
def test_a_refused_reset_changes_nothing(
    arguments: dict[str, Any], error: type[Exception], words: str, batch: SceneBatch
) -> None:
    batch.step(5)
    before = batch.state()
    with pytest.raises(error, match=words):
        batch.reset(**arguments)
    assert batch.state() == before
    batch.reset()
    assert batch.state() == live(heap(SCENES, seed=3)).state()


def test_an_expression_without_a_value_names_the_scene() -> None:
    where = (0, 1, 2)
    draws: dict[str, Node] = {"u": Drawn("integers", (1, 1), (), Key("draws", "u", ""))}
    height = Computed(Template("${1 / u}"), ())
    pose = Posed(Stacked((0.0, 0.0, height)), (1.0, 0.0, 0.0, 0.0))
    start = np.array([[0.0, 0, 1, 1, 0, 0, 0]] * 3)
    at = varying(lambda: start, lambda: start, where, recipe=pose)
    box = BodyStructure("dynamic", (CollisionShape(Box(constant([0.1] * 3))),))
    plan = ScenePlan("division", 3, (Entity("cube", where, at, (box,)),), Physics(), draws=tuple(draws.items()))
    batch = live(plan)
    with pytest.raises(ValueError, match=r"'cube' in scene 2: its pose has no value: .*zero.*, in '\$\{1 / u\}'"):
        batch.reset(draws={"u": [1, 2, 0]})
    assert (batch.entities["cube"].pose[:, 2] == 1).all()


def test_variants_are_reset_by_their_own_structures() -> None:
    where = (0, 1, 2, 3)
    key = Key("entities", "thing", "linear_velocity")
    drawn = value(Drawn("uniform", ((0, 0, 0), (1, 1, 1)), (3,), key), where, 4, 0)
    box = (CollisionShape(Box(constant([0.1] * 3))),)
    structures = (
        BodyStructure("dynamic", box, linear_velocity=drawn),
        BodyStructure("kinematic", box),
        BodyStructure("dynamic", box, angular_velocity=constant([1, 2, 3])),
    )
    pick = per_scene([2, 0, 1, 0], "int64")
    thing = Entity("thing", where, constant([0, 0, 1, 1, 0, 0, 0]), structures, pick)
    plan = ScenePlan("variants", 4, (thing,), Physics())
    batch = live(plan)
    start = batch.state()
    assert start.entities["thing"].dynamic.tolist() == [True, True, False, True]
    assert start.entities["thing"].angular_velocity.tolist()[0] == [1, 2, 3]
    batch.step(5)
    batch.reset()
    assert batch.state() == start
    batch.reset(seed=5)
    now = batch.state().entities["thing"]
    changed = (now.linear_velocity != start.entities["thing"].linear_velocity).any(axis=1)
    assert changed.tolist() == [False, True, False, True]


def test_a_closed_batch_is_not_reset(batch: SceneBatch) -> None:
    state = batch.state()
    batch.close()
    for use in (batch.reset, batch.state, lambda: batch.set_state(state)):
        with pytest.raises(RuntimeError, match="closed"):
            use()


def test_a_plan_without_entities_can_be_reset() -> None:
    batch = live(ScenePlan("empty", 2, (), Physics()))
    batch.reset(seed=1)
    assert batch.state().entities == {}


def test_the_plan_of_these_tests_is_a_heap_of_bodies(batch: SceneBatch) -> None:
    """The plan is what the tests above take it for."""
    assert len([name for name in batch.entities if name.startswith("body_")]) == BODIES
    assert batch.entities["body_4"].scene_idxs == (0, 2)
    poses = batch.entities["body_3"].pose
    assert len({tuple(row) for row in poses.tolist()}) == SCENES
