"""Resets of scene files, as people write them: against the same file built with another seed, and by hand."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
from fidelity.compare import assert_same_scene, assert_same_trajectory

import scenecc
from scenecc.backends.sapien import SceneBatch

SCENES = 5

DRAWN = """
scenecc: 1
draws:
  side: {choice: [-0.3, 0.3]}
  height: {uniform: [0.5, 1.5]}
  fast: "${2 * height}"
frames:
  tray: {pose: {p: ["${side}", 0, "${height}"], rpy_deg: [0, 0, {uniform: [-90, 90]}]}}
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  cube:
    pose: {p: {uniform: [[-0.1, -0.1, 0.2], [0.1, 0.1, 0.4]]}, q: uniform}
    linear_velocity: [0, "${fast}", {normal: [0, 0.1], clip: [-1, 1]}]
    angular_velocity: {uniform: [[-1, -1, -1], [1, 1, 1]]}
    shapes: [{type: box, half_size: [0.1, 0.05, 0.03]}]
  on_tray:
    pose: {relative_to: tray, p: [0.1, 0, 0.2]}
    shapes: [{type: sphere, radius: 0.05}]
  beside:
    scene_idxs: "1::2"
    pose: {relative_to: cube, p: [1, {integers: [0, 3]}, 0.5]}
    shapes: [{type: capsule, radius: 0.03, half_length: 0.05}]
  pusher:
    body_type: kinematic
    pose: {cycle: [[1, 0, 0.5], {p: [0, 1, 0.5], rpy: [0, 0, {uniform: [0, 1]}]}]}
    shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]
  still:
    pose: [2, 0, 0.5]
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
"""


def loaded(text: str, seed: int = 0, **options: Any) -> SceneBatch:
    return scenecc.load_scene(io.StringIO(text), num_scenes=SCENES, seed=seed, render=False, **options)


@pytest.mark.parametrize("chosen", [None, [3, 1]])
def test_a_reset_is_the_file_built_with_that_seed(chosen: list[int] | None) -> None:
    batch, fresh = loaded(DRAWN, scene_idxs=chosen), loaded(DRAWN, seed=8, scene_idxs=chosen)
    assert batch.state() != fresh.state()
    batch.step(20)
    batch.reset(seed=8, exact=True)
    for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, fresh.scenes)


def test_a_frame_is_drawn_anew_for_what_stands_in_it() -> None:
    batch = loaded(DRAWN)
    before = batch.entities["on_tray"].pose
    batch.reset(seed=4)
    after = batch.entities["on_tray"].pose
    assert (before != after).any(axis=1).all()
    assert set(np.sign(after[:, 0])) <= {-1.0, 1.0}
    assert (batch.entities["still"].pose[:, :3] == [2, 0, 0.5]).all()


def test_given_draws_reach_all_that_reads_them() -> None:
    batch = loaded(DRAWN)
    batch.reset(draws={"height": [0.5, 0.75, 1.0, 1.25, 1.5]})
    assert batch.entities["cube"].linear_velocity[:, 1].tolist() == [1.0, 1.5, 2.0, 2.5, 3.0]
    assert np.allclose(batch.entities["on_tray"].pose[:, 2], np.array([0.7, 0.95, 1.2, 1.45, 1.7]))


BUILT = """
scenecc: 1
draws:
  half: {uniform: [0.02, 0.05]}
  lift: {uniform: [0, 1]}
entities:
  peg:
    pose: [0, {uniform: [-1, 1]}, "${lift + half}"]
    shapes: [{type: box, half_size: ["${half}", "${half}", 0.1]}]
  wall:
    body_type: static
    pose: [{uniform: [1, 2]}, 0, 0]
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
"""


def test_what_is_built_stays_as_built() -> None:
    batch = loaded(BUILT, seed=1)
    start, wall = batch.entities["peg"].pose, batch.entities["wall"].pose
    bodies: list[Any] = [obj.components[0] for obj in batch.entities["peg"].objs]
    half = np.array([body.collision_shapes[0].half_size[0] for body in bodies])
    batch.reset(seed=2)
    again = batch.entities["peg"].pose
    assert (again[:, 1:3] != start[:, 1:3]).all()
    assert (batch.entities["wall"].pose == wall).all()
    # The draw that sizes the peg is the one that was built; the other is drawn anew.
    lift = loaded(BUILT, seed=2).plan.entities[0].pose.data[:, 2]
    assert not np.allclose(again[:, 2], lift)
    batch.reset(draws={"lift": [0.0] * SCENES})
    assert np.allclose(batch.entities["peg"].pose[:, 2], half)
    with pytest.raises(ValueError, match=r"cannot change the shared draw 'half', only these: lift\. .* stay as built"):
        batch.reset(draws={"half": [0.03] * SCENES})


def test_draws_that_were_given_are_kept_until_others_are() -> None:
    """For samplers that no form covers."""
    lifts = np.linspace(0, 1, SCENES)
    batch = loaded(BUILT, draws={"lift": lifts, "half": [0.03] * SCENES})
    assert np.allclose(batch.entities["peg"].pose[:, 2], lifts + 0.03)
    batch.reset(seed=5)
    assert np.allclose(batch.entities["peg"].pose[:, 2], lifts + 0.03)
    batch.reset(draws={"lift": lifts[::-1]})
    assert np.allclose(batch.entities["peg"].pose[:, 2], lifts[::-1] + 0.03)
    with pytest.raises(ValueError, match="cannot change the shared draw 'half'"):
        batch.reset(draws={"half": [0.04] * SCENES})


def test_an_expression_that_fails_at_a_reset_changes_nothing() -> None:
    text = """
scenecc: 1
draws: {u: {uniform: [0, 1]}}
entities:
  cube: {pose: [0, 0, "${1 / u}"], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
"""
    batch = loaded(text)
    before = batch.state()
    with pytest.raises(ValueError, match="'cube' in scene 3: its pose"):
        batch.reset(seed=9, draws={"u": [1, 1, 1, 0, 1]})
    with pytest.raises(ValueError, match=r"'cube' in scene 1: the drawn pose is \[0.0, 0.0, 1e\+60"):
        batch.reset(seed=9, draws={"u": [1, 1e-60, 1, 1, 1]})
    assert batch.state() == before
    batch.step(3)
    batch.reset()
    assert batch.state() == before


def test_a_plan_read_back_is_reset_alike() -> None:
    plan = scenecc.compile_scene(io.StringIO(DRAWN), num_scenes=SCENES)
    batch, again = loaded(DRAWN), scenecc.load_scene(io.StringIO(scenecc.emit_scene(plan, "json")), render=False)
    for each in (batch, again):
        each.reset(seed=6)
    assert again.state() == batch.state()


def test_instances_and_copies_are_drawn_apart() -> None:
    text = """
scenecc: 1
entities:
  box:
    repeat: {i: {count: 3}}
    pose: [{uniform: [-1, 1]}, 0, 1]
    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
  a: {use: "scenecc:cube", pose: {p: {uniform: [[-1, 2, 1], [1, 3, 2]]}}}
  b: {use: "scenecc:cube", pose: {p: {uniform: [[-1, 4, 1], [1, 5, 2]]}}}
"""
    batch, fresh = loaded(text), loaded(text, seed=3)
    batch.reset(seed=3)
    assert batch.state() == fresh.state()
    first = [entity.pose[:, 0].tolist() for entity in batch.entities.values()]
    assert len({tuple(row) for row in first}) == len(first) == 5
