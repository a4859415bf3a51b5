"""What a reset and a restored state are worth: every later step against batches that were just built, to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import built
from sapien import physx
from unit.backends.drawn import heap

from scenecc.plan import BodyStructure, Box, CollisionShape, Entity, Physics, Plane, ScenePlan, constant, per_scene

SCENES = 3
ENGINES = {
    "usual": Physics(),
    "pgs": Physics(enable_tgs=False, enable_pcm=False),
    "ccd": Physics(enable_ccd=True, enable_enhanced_determinism=True, timestep=0.005),
    "moon": Physics(gravity=(0.1, 0, -1.6), solver_position_iterations=20, sleep_threshold=0.01),
}


@pytest.mark.parametrize("physics", ENGINES.values(), ids=ENGINES)
def test_an_exact_reset_goes_on_as_a_batch_just_built(physics: Physics) -> None:
    """In a heap, whatever was before: a few steps, a long time, another seed, all at rest."""
    batch = built(heap(SCENES, physics=physics))
    for seed, steps in ((0, 7), (5, 150), (5, 0), (1, 600)):
        batch.step(steps)
        batch.reset(seed, exact=True)
        fresh = built(heap(SCENES, seed=seed, physics=physics))
        for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
            assert_same_scene(ours, theirs)
            assert [e.per_scene_id for e in ours.entities] == [e.per_scene_id for e in theirs.entities]
            assert ours.timestep == theirs.timestep
        assert_same_trajectory(batch.scenes, fresh.scenes)


def test_an_exact_reset_of_some_scenes() -> None:
    batch, other = built(heap(SCENES)), built(heap(SCENES))
    for each in (batch, other):
        each.step(60)
    scenes = list(batch.scenes)
    batch.reset(seed=4, scene_idxs=[1], exact=True)
    assert [ours is theirs for ours, theirs in zip(scenes, batch.scenes, strict=True)] == [True, False, True]
    assert scenes[1].entities == []
    assert batch.scenes[1].physx_system.config.gravity.tolist() == scenes[1].physx_system.config.gravity.tolist()
    assert_same_trajectory([batch.scenes[0], batch.scenes[2]], [other.scenes[0], other.scenes[2]])
    assert_same_trajectory([batch.scenes[1]], [built(heap(SCENES, seed=4), scene_idxs=[1]).scenes[0]])


def test_what_was_added_by_hand_comes_along() -> None:
    batch = built(heap(1))
    scene: Any = batch.scenes[0]
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05] * 3)
    builder.initial_pose = sapien.Pose([2, 0, 1])
    guest = builder.build(name="guest")
    drive = scene.create_drive(guest, sapien.Pose(), batch.entities["body_0"].objs[0], sapien.Pose([2, 0, 0]))
    drive.set_limit_x(0, 0)
    batch.step(10)
    where = guest.pose.p.tolist()
    batch.reset(exact=True)
    assert guest.scene is batch.scenes[0]
    assert guest.pose.p.tolist() == where
    assert batch.scenes[0].entities[-1] is guest
    batch.step(10)
    assert guest.pose.p.tolist() != where


def sparse() -> ScenePlan:
    """Bodies that touch the ground and, in pairs, one another."""
    solid = CollisionShape(Box(constant([0.05, 0.05, 0.05])))
    floor = CollisionShape(Plane(), pose=constant([0, 0, 0, 0.7071068, 0, -0.7071068, 0]))
    turned = [0.9238795, 0.2209424, 0.2209424, 0.2209424]
    bodies = [
        Entity(f"b{i}", (0, 1), per_scene([[i // 2, 0.01 * i, 0.1 + 0.2 * (i % 2) + 0.1 * s, *turned] for s in (0, 1)]),
               (BodyStructure("dynamic", (solid,)),))
        for i in range(6)
    ]  # fmt: skip
    ground = Entity("ground", (0, 1), constant([0, 0, 0, 1, 0, 0, 0]), (BodyStructure("static", (floor,)),))
    return ScenePlan("sparse", 2, (ground, *bodies), Physics())


def test_bodies_that_touch_in_pairs_go_on_exactly_in_the_same_scenes_too() -> None:
    batch = built(sparse())
    for steps in (30, 400, 3):
        batch.step(steps)
        batch.reset()
        assert_same_trajectory(batch.scenes, built(sparse()).scenes)


def test_after_an_exact_restoring_the_simulation_depends_on_the_state_alone() -> None:
    batch, other = built(heap(SCENES)), built(heap(SCENES, seed=9))
    batch.step(80)
    state = batch.state()
    batch.step(33)
    batch.set_state(state, exact=True)
    other.set_state(state, exact=True)
    assert_same_trajectory(batch.scenes, other.scenes)
    batch.set_state(state, exact=True)
    other.step(500)
    other.set_state(state, exact=True)
    assert_same_trajectory(batch.scenes, other.scenes)


def test_a_free_body_flies_on_as_it_would_have() -> None:
    """Without contacts there is nothing that the engine remembers, and the centre of mass is at the body's origin."""
    box = BodyStructure(
        "dynamic", (CollisionShape(Box(constant([0.1, 0.2, 0.3]))),), angular_velocity=constant([1, 2, 3])
    )
    plan = ScenePlan("free", 1, (Entity("box", (0,), constant([0, 0, 5, 1, 0, 0, 0]), (box,)),), Physics())
    batch, other = built(plan), built(plan)
    batch.step(50)
    batch.set_state(batch.state())
    other.step(50)
    assert_same_trajectory(batch.scenes, other.scenes, 100)


def test_the_process_keeps_its_settings() -> None:
    config: Any = physx.get_scene_config()
    before = config.gravity.tolist()
    batch = built(heap(1, physics=Physics(gravity=(0, 0, -3))))
    batch.reset(exact=True)
    assert physx.get_scene_config().gravity.tolist() == before
    assert np.allclose(batch.scenes[0].physx_system.config.gravity, [0, 0, -3])
