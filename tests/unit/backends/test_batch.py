"""Live batches: what users read, set, step, remove, add and close."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import sapien

from scenecc.backends.sapien import SceneBatch, instantiate
from scenecc.diagnostics import Sink
from scenecc.plan import Physics, ScenePlan


@pytest.fixture
def batch(plan: ScenePlan) -> Iterator[SceneBatch]:
    built = instantiate(plan, Sink(), render=False)
    assert built is not None
    yield built
    built.close()


def test_a_scene_batch_has_plan_scenes_and_entities(batch: SceneBatch, plan: ScenePlan) -> None:
    assert batch.plan is plan
    assert batch.scene_idxs == (0, 1, 2, 3)
    assert len(batch) == len(batch.scenes) == 4
    assert all(type(scene) is sapien.Scene for scene in batch.scenes)
    assert list(batch.entities) == [entity.name for entity in plan.entities]
    assert batch.timestep == pytest.approx(0.01)
    assert not batch.render
    assert "4 scenes" in repr(batch)
    assert repr(batch.entities["post"]).startswith("EntityBatch('post', scene_idxs=[")
    cube = batch.entities["cube"]
    assert cube.name == "cube"
    assert len(cube) == len(cube.objs) == 4
    assert all(obj.scene is scene for obj, scene in zip(cube.objs, batch.scenes, strict=True))


def test_pose_is_read_as_float32_rows(batch: SceneBatch) -> None:
    pose = batch.entities["cube"].pose
    assert pose.dtype == np.float32
    assert (pose == np.array([[0.1 * i, 0, 1 + i, 1, 0, 0, 0] for i in range(4)], np.float32)).all()


@pytest.mark.parametrize("name", ["cube", "arm", "table", "marker"])
def test_set_pose_accepts_rows_and_sapien_poses(name: str, batch: SceneBatch) -> None:
    entity = batch.entities[name]
    one, rows = np.array([1, 2, 3, 0, 1, 0, 0.0]), np.tile([1, 2, 3, 0.5, 0.5, 0.5, 0.5], (4, 1))
    rows[:, 0] = range(4)
    entity.set_pose(one)
    assert (entity.pose == np.array(one, np.float32)).all()
    entity.set_pose(rows)
    assert (entity.pose == np.array(rows, np.float32)).all()
    entity.set_pose(sapien.Pose([4, 5, 6]))
    assert (entity.pose == np.array([4, 5, 6, 1, 0, 0, 0], np.float32)).all()
    entity.set_pose([sapien.Pose([i, 0, 0]) for i in range(4)])
    assert entity.pose[:, 0].tolist() == [0, 1, 2, 3]
    entity.set_pose([7, 8, 9, 1, 0, 0, 0], scene_idxs=[3, 1])
    assert entity.pose[:, 0].tolist() == [0, 7, 2, 7]
    entity.set_pose(rows[[2, 0]], scene_idxs=[2, 0])
    assert entity.pose[:, 0].tolist() == [0, 7, 2, 7]


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        ([1, 2, 3], "(4, 7)"),
        (np.zeros((3, 7)), "(4, 7)"),
        ([0, 0, 0, 2, 0, 0, 0], "unit"),
        ([0, 0, np.nan, 1, 0, 0, 0], "finite"),
        ([sapien.Pose()] * 3, "3 poses for 4"),
    ],
)
def test_set_pose_refuses_invalid_poses(pose: Any, words: str, batch: SceneBatch) -> None:
    before = batch.entities["cube"].pose
    with pytest.raises(ValueError, match=words.replace("(", r"\(").replace(")", r"\)")):
        batch.entities["cube"].set_pose(pose)
    assert (batch.entities["cube"].pose == before).all()


def test_a_misspelt_attribute_is_refused(batch: SceneBatch) -> None:
    for entity in batch.entities.values():
        with pytest.raises(AttributeError, match=r"Batch has no attribute `psoe`; did you mean `pose`\?$"):
            entity.psoe = [0, 0, 0]  # pyright: ignore[reportAttributeAccessIssue]


def test_set_pose_refuses_a_scene_without_the_entity(batch: SceneBatch) -> None:
    with pytest.raises(KeyError, match="not in scene 9"):
        batch.entities["cube"].set_pose(sapien.Pose(), scene_idxs=[9])


def test_velocities_can_be_set_and_read(batch: SceneBatch) -> None:
    cube = batch.entities["cube"]
    assert (cube.linear_velocity == np.array([1, 0, 0.5], np.float32)).all()
    assert (cube.angular_velocity == 0).all()
    cube.linear_velocity = [0, 0, 2]
    cube.angular_velocity = np.arange(12).reshape(4, 3)
    assert cube.linear_velocity.dtype == np.float32
    assert (cube.linear_velocity == [0, 0, 2]).all()
    assert (cube.angular_velocity == np.arange(12).reshape(4, 3)).all()
    cube.set_linear_velocity([1, 1, 1], scene_idxs=[2])
    cube.set_angular_velocity([1, 1, 1], scene_idxs=[0])
    assert cube.linear_velocity.tolist() == [[0, 0, 2], [0, 0, 2], [1, 1, 1], [0, 0, 2]]
    assert cube.angular_velocity[0].tolist() == [1, 1, 1]
    with pytest.raises(ValueError, match="finite"):
        cube.linear_velocity = [0, 0, np.inf]
    with pytest.raises(ValueError, match="velocity"):
        cube.linear_velocity = [0, 0]


@pytest.mark.parametrize(("name", "words"), [("table", "static"), ("marker", "no physics")])
def test_what_cannot_move_has_no_velocity(name: str, words: str, batch: SceneBatch) -> None:
    entity = batch.entities[name]
    for use in (
        lambda: entity.linear_velocity,
        lambda: entity.angular_velocity,
        lambda: entity.set_linear_velocity([0, 0, 0]),
        lambda: entity.set_angular_velocity([0, 0, 0]),
    ):
        with pytest.raises(TypeError, match=words):
            use()


def test_a_kinematic_body_has_a_velocity_that_cannot_be_set(batch: SceneBatch) -> None:
    arm = batch.entities["arm"]
    assert (arm.linear_velocity == 0).all()
    with pytest.raises(TypeError, match="kinematic"):
        arm.linear_velocity = [1, 0, 0]


def test_step_simulates_every_scene(batch: SceneBatch) -> None:
    height = batch.entities["cube"].pose[:, 2]
    batch.step()
    once = batch.entities["cube"].pose[:, 2]
    batch.step(9)
    assert (once != height).all()
    assert (batch.entities["cube"].pose[:, 2] != once).all()
    before = batch.entities["cube"].pose
    batch.step(0)
    assert (batch.entities["cube"].pose == before).all()
    with pytest.raises(ValueError, match="negative"):
        batch.step(-1)
    wrong: Any = [0]
    calls: list[Any] = [batch.step, batch.contacts, batch.net_contact_force]
    for call in (*calls, *(each.link_pose for each in batch.articulations.values())):
        with pytest.raises(TypeError, match="must be"):
            call(wrong)


def test_step_equals_steps_of_each_scene(plan: ScenePlan) -> None:
    one, other = (instantiate(plan, Sink(), render=False) for _ in range(2))
    assert one is not None
    assert other is not None
    one.step(20)
    for _ in range(20):
        for scene in other.scenes:
            scene.step()
    assert [s.pack_poses() for s in one.scenes] == [s.pack_poses() for s in other.scenes]


def test_a_removed_entity_is_added_again_unchanged(batch: SceneBatch) -> None:
    batch.step(5)
    cube = batch.entities["cube"]
    pose, velocity = cube.pose, cube.linear_velocity
    objs = list(cube.objs)
    batch.remove("cube")
    assert "cube" not in batch.entities
    assert all("cube" not in [e.name for e in scene.entities] for scene in batch.scenes)
    batch.step(5)
    batch.add("cube")
    assert list(batch.entities) == ["table", "post", "marker", "arm", "cube"]
    assert all([e.name for e in scene.entities][-1] == "cube" for scene in batch.scenes)
    again = batch.entities["cube"]
    assert again.objs == objs
    assert (again.pose == pose).all()
    assert (again.linear_velocity == velocity).all()
    batch.step()
    assert (again.pose != pose).any()


def test_remove_and_add_refuse_wrong_names_and_states(batch: SceneBatch) -> None:
    with pytest.raises(KeyError, match="no entity 'cub'"):
        batch.remove("cub")
    with pytest.raises(KeyError, match="no entity 'cub'"):
        batch.add("cub")
    with pytest.raises(ValueError, match="'cube' is in the scenes; only"):
        batch.add("cube")
    batch.remove("cube")
    with pytest.raises(ValueError, match="already removed"):
        batch.remove("cube")


def test_a_closed_batch_refuses_access(plan: ScenePlan) -> None:
    with instantiate(plan, Sink(), render=False) as batch:  # type: ignore[union-attr]
        cube, scene = batch.entities["cube"], batch.scenes[0]
        batch.remove("post")
    batch.close()
    assert scene.entities == []
    assert "closed" in repr(batch)
    for use in (
        batch.step,
        lambda: batch.scenes,
        lambda: batch.entities,
        lambda: batch.timestep,
        lambda: batch.remove("cube"),
        lambda: batch.add("post"),
        batch.__enter__,
        lambda: cube.pose,
        lambda: cube.objs,
        lambda: cube.linear_velocity,
        lambda: cube.set_pose(sapien.Pose()),
    ):
        with pytest.raises(RuntimeError, match="closed"):
            use()


def test_scenes_are_independent(batch: SceneBatch) -> None:
    before = batch.entities["post"].pose
    batch.scenes[1].step()
    after = batch.entities["post"].pose
    assert (before != after).any(axis=1).tolist() == [False, True, False, False]


@pytest.mark.parametrize("chosen", [[], [0, 0], [4], [-1]])
def test_invalid_scene_idxs_are_refused(chosen: list[int], plan: ScenePlan) -> None:
    with pytest.raises(ValueError, match="scene_idxs"):
        instantiate(plan, Sink(), scene_idxs=chosen)


def test_progress_is_reported_for_each_scene(plan: ScenePlan) -> None:
    told: list[tuple[int, int]] = []
    instantiate(plan, Sink(), render=False, scene_idxs=[1, 3], progress=lambda done, total: told.append((done, total)))
    assert told == [(1, 2), (2, 2)]


def test_a_plan_without_entities_can_be_built() -> None:
    batch = instantiate(ScenePlan("empty", 2, (), Physics()), Sink(), render=False)
    assert batch is not None
    assert batch.entities == {}
    batch.step(2)
