"""Articulations at a reset, restored, removed and added: against batches that were just built, to the bit."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import built
from fidelity.hand_articulations import Case, plan_of, with_joint, with_mimic
from sapien import physx

from scenecc import load_scene
from scenecc.backends.sapien import SceneBatch
from scenecc.plan import ScenePlan, constant, per_scene


def driven(*, fixed: bool = True, mimic: bool = False) -> ScenePlan:
    """An arm whose drives pull, with velocities at the start."""
    drive = {"stiffness": constant(20.0), "damping": constant(2.0)}
    changes = [
        with_joint("shoulder", **drive, drive_target=per_scene([0.1, 0.4, -0.5]), qvel=constant(0.3)),
        with_joint("slide", **drive, drive_velocity_target=constant(0.05)),
    ]
    if mimic:
        changes.append(with_mimic("side", "shoulder", 0.5, 0.1))
    if not fixed:
        changes.append(lambda arm: replace(arm, linear_velocity=constant([0.3, 0, 0.2])))

    def change(arm: Any) -> Any:
        for each in changes:
            arm = each(arm)
        return arm

    return plan_of(Case(change, fixed=fixed))


KINDS = {"fixed": {}, "free": {"fixed": False}, "mimic": {"mimic": True}}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
@pytest.mark.parametrize("exact", [True, False])
def test_a_reset_goes_on_as_a_batch_just_built(kind: dict[str, bool], exact: bool) -> None:
    batch = built(driven(**kind))
    for steps in (0, 7, 150):
        batch.step(steps)
        arm = batch.articulations["arm"]
        arm.drive_target = arm.drive_target + np.float32(0.3)
        arm.qf = np.full(arm.dof, 0.5)
        batch.reset(exact=exact)
        fresh = built(driven(**kind))
        for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, fresh.scenes)


def test_forces_on_joints_act_as_those_that_a_person_sets() -> None:
    ours, theirs = built(driven()), built(driven())
    forces = np.array([[0.5, 1, 0, -0.3], [0, 0, 0.2, 0.1], [-1, 2, 0.4, 0]], np.float32)
    for batch in (ours, theirs):
        batch.step(20)
    ours.articulations["arm"].qf = forces
    for obj, row in zip(theirs.articulations["arm"].objs, forces, strict=True):
        obj.set_qf(row)
    assert_same_trajectory(ours.scenes, theirs.scenes)
    assert ours.articulations["arm"].qf.tolist() == forces.tolist()
    assert (ours.articulations["arm"].qpos != built(driven()).articulations["arm"].qpos).any()


def test_one_scene_is_reset_and_the_others_go_on() -> None:
    batch, other = built(driven()), built(driven())
    batch.step(40)
    other.step(40)
    batch.reset(scene_idxs=[1])
    assert_same_trajectory([batch.scenes[0], batch.scenes[2]], [other.scenes[0], other.scenes[2]])
    assert_same_trajectory([batch.scenes[1]], [built(driven()).scenes[1]])


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
@pytest.mark.parametrize("exact", [True, False])
def test_a_restored_state_is_read_again_to_the_bit(kind: dict[str, bool], exact: bool) -> None:
    batch, other = built(driven(**kind)), built(driven(**kind))
    batch.step(60)
    for obj in batch.articulations["arm"].objs:
        obj.set_qf(np.full(4, 0.25, np.float32))
    state = pickle.loads(pickle.dumps(batch.state()))
    assert state.articulations["arm"].qf.tolist() == [[0.25] * 4] * 3
    batch.step(33)
    assert batch.state() != state
    for each in (batch, other):
        each.set_state(state, exact=exact)
        found = each.state().articulations["arm"]
        wanted = state.articulations["arm"]
        for name in ("qpos", "qvel", "qf", "drive_target", "drive_velocity_target", "asleep"):
            assert np.array_equal(getattr(found, name), getattr(wanted, name)), name
        # A root's pose and velocity go through its centre of mass, as a body's do.
        for name in ("pose", "linear_velocity", "angular_velocity"):
            assert np.allclose(getattr(found, name), getattr(wanted, name), rtol=0, atol=1e-6), name
    if exact:
        assert_same_trajectory(batch.scenes, other.scenes)


def test_one_that_rests_is_restored_at_rest() -> None:
    batch = built(driven())
    for joint in batch.articulations["arm"].joints.values():
        for each in joint:
            each.set_drive_properties(0.0, 20.0)
    batch.step(1500)
    state = batch.state()
    assert state.articulations["arm"].asleep.all()
    batch.reset()
    assert not batch.state().articulations["arm"].asleep.any()
    batch.set_state(state)
    assert batch.state().articulations["arm"].asleep.all()
    before = batch.articulations["arm"].qpos
    batch.step(5)
    assert np.array_equal(batch.articulations["arm"].qpos, before)


def test_removed_and_added_it_is_as_it_was() -> None:
    batch, other = built(driven()), built(driven())
    for each in (batch, other):
        each.step(30)
    batch.remove("arm")
    assert list(batch.articulations) == []
    assert [[e.name for e in scene.entities] for scene in batch.scenes] == [["ground", "box"]] * 3
    with pytest.raises(ValueError, match="'arm' is already removed"):
        batch.remove("arm")
    state = batch.state()
    assert state.articulations["arm"] == other.state().articulations["arm"]
    batch.add("arm")
    assert batch.state().articulations["arm"] == state.articulations["arm"]
    assert [e.name for e in batch.scenes[0].entities][-6:] == ["base", "upper", "lower", "tool", "tip", "flap"]
    assert list(batch.articulations) == ["arm"]


@pytest.mark.parametrize("exact", [True, False])
def test_reset_while_it_is_removed_it_is_at_its_start_when_it_is_added(exact: bool) -> None:
    batch = built(driven())
    arm = batch.articulations["arm"]
    batch.step(30)
    batch.remove("arm")
    with pytest.raises(RuntimeError, match="'arm' is removed"):
        _ = arm.qpos
    batch.step(10)
    batch.reset(exact=exact)
    batch.add("arm")
    fresh = built(driven())
    fresh.remove("arm")
    fresh.add("arm")
    for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, fresh.scenes)


@pytest.mark.parametrize("exact", [True, False])
def test_what_holds_it_holds_it_after_a_reset(exact: bool) -> None:
    """A box that is welded to the hand by a person, and drives along."""

    def welded() -> SceneBatch:
        batch = built(driven())
        arm, box = batch.articulations["arm"], batch.entities["box"]
        for number in range(3):
            hand: Any = arm.links["tip"][number]
            where = hand.entity.pose * sapien.Pose([0, 0, 0.3])
            box.set_pose(where, [number])
            body: Any = box.objs[number].components[0]
            drive: Any = physx.PhysxDriveComponent(body)
            drive.parent = hand
            drive.pose_in_parent = sapien.Pose([0, 0, 0.3])
            for axis in "xyz":
                getattr(drive, f"set_limit_{axis}")(0, 0)
            drive.set_limit_twist(0, 0)
            drive.set_limit_cone(0, 0)
            box.objs[number].add_component(drive)
        return batch

    batch, other = welded(), welded()
    start = batch.state()
    batch.step(70)
    batch.set_state(start, exact=exact)
    other.set_state(start, exact=exact)
    assert_same_trajectory(batch.scenes, other.scenes)
    for number in range(3):
        hand: Any = batch.articulations["arm"].links["tip"][number]
        box: Any = batch.entities["box"].objs[number]
        assert np.linalg.norm((hand.entity.pose * sapien.Pose([0, 0, 0.3])).p - box.pose.p) < 5e-3


SCENE: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 4,
    "entities": {
        "door": {
            "pose": {"p": [{"uniform": [0, 1]}, 0, 0]},
            "fix_root_link": True,
            "qpos": {"hinge": {"uniform": [0.1, 0.9]}},
            "drives": {"hinge": {"stiffness": 10, "damping": 1}},
            "root": {
                "name": "frame",
                "shapes": [{"type": "box", "half_size": [0.05, 0.05, 1]}],
                "children": [
                    {
                        "name": "panel",
                        "joint": {"name": "hinge", "type": "revolute", "axis": [0, 0, 1], "limits": [0, 1.5]},
                        "shapes": [{"type": "box", "half_size": [0.4, 0.02, 0.9], "pose": [0.5, 0, 0]}],
                    }
                ],
            },
        }
    },
}


def test_a_reset_draws_poses_and_positions_anew_and_targets_with_them() -> None:
    with load_scene(SCENE, render=False) as batch, load_scene(SCENE, render=False, seed=7) as other:
        door = batch.articulations["door"]
        first = door.qpos
        assert len({*first[:, 0].tolist()}) == 4
        assert np.array_equal(door.drive_target, first)
        batch.reset(seed=7)
        assert not np.array_equal(door.qpos, first)
        assert np.array_equal(door.drive_target, door.qpos)
        assert batch.state() == other.state()
        assert_same_trajectory(batch.scenes, other.scenes)
