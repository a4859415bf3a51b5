"""Resets of scenes that are seen: a new simulation, and everything that is seen along with it. Needs a device."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory

import scenecc
from scenecc import SceneBatch

pytestmark = [pytest.mark.render, pytest.mark.quick]

SCENES = 2
TEXT = """
scenecc: 1
draws:
  side: {choice: [-0.3, 0.3]}
entities:
  ground: {use: scenecc:ground, prefix: ""}
  cube:
    pose: {p: [{uniform: [-0.2, 0.2]}, "${side}", {uniform: [0.2, 0.6]}], q: uniform}
    color: {uniform: [[0.1, 0.1, 0.1], [0.9, 0.9, 0.9]]}
    shapes: [{type: box, half_size: {uniform: [[0.05, 0.05, 0.05], [0.15, 0.15, 0.15]]}}]
  goal:
    body_type: none
    pose: ["${side}", 0, 0.01]
    visuals: [{type: sphere, radius: 0.1, color: "#d62828"}]
  pusher:
    body_type: kinematic
    pose: [0.5, {uniform: [-0.5, 0.5]}, 0.1]
    shapes: [{type: box, half_size: [0.05, 0.05, 0.1], color: "#457b9d"}]
"""


def loaded(seed: int) -> SceneBatch:
    return scenecc.load_scene(io.StringIO(TEXT), num_scenes=SCENES, seed=seed, render=True)


@pytest.mark.parametrize("exact", [False, True], ids=["in place", "exact"])
def test_a_reset_keeps_what_is_seen(exact: bool) -> None:
    """Back to its own seed, a batch is what was just built: shapes, materials, images, and every step from there."""
    batch, fresh = loaded(3), loaded(3)
    systems = [scene.render_system for scene in batch.scenes]
    batch.step(20)
    batch.reset(seed=9, exact=exact)
    batch.step(5)
    batch.reset(seed=3, exact=exact)
    for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
        assert_same_scene(ours, theirs)
    if exact:
        assert_same_trajectory(batch.scenes, fresh.scenes)
    assert [scene.render_system for scene in batch.scenes] == systems
    assert [len(system.render_bodies) for system in systems] == [4] * SCENES


def test_bodies_are_seen_where_a_reset_has_put_them() -> None:
    batch = loaded(3)
    batch.step(10)
    batch.reset(seed=8, scene_idxs=[1], exact=True)
    for scene in batch.scenes:
        scene.update_render()
        for body in scene.render_system.render_bodies:
            assert body.entity.scene is scene
            assert (body.entity_pose.p == body.entity.pose.p).all()


def test_a_camera_goes_on_seeing_after_an_exact_reset() -> None:
    """Down to pixels: the picture of the start again, from the camera that was there before."""
    batch = loaded(3)
    scene: Any = batch.scenes[0]
    scene.set_ambient_light([0.5, 0.5, 0.5])
    scene.add_directional_light([0, 1, -1], [0.5, 0.5, 0.5])
    camera = scene.add_camera("camera", 32, 32, 1.0, 0.01, 10)
    camera.entity.pose = sapien.Pose([-1.5, 0, 0.5])

    def picture() -> Any:
        batch.scenes[0].update_render()
        camera.take_picture()
        return np.asarray(camera.get_picture("Color"))

    first = picture()
    batch.step(40)
    moved = picture()
    batch.reset(exact=True)
    assert camera.entity.scene is batch.scenes[0] is not scene
    assert batch.scenes[0].get_cameras() == [camera]
    assert np.allclose(picture(), first, atol=1 / 255)
    assert not np.allclose(moved, first, atol=1 / 255)
