"""Ropes of ball joints: the prefab against SAPIEN called by hand, and whether long ones hold still."""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from sapien import Pose, physx

from scenecc import load_scene

PIECES, LENGTH, RADIUS, DENSITY = 6, 0.6, 0.01, 800.0
COLLIDES = "floor: {body_type: static, collisions: [{type: plane}]}"


def rope_file(pose: str = "[0, 0, 1]", **given: Any) -> io.StringIO:
    thing = json.dumps({"use": "scenecc:rope", "with": given})[:-1] + f", pose: {pose}}}"
    return io.StringIO(f"scenecc: 1\nentities:\n  {COLLIDES}\n  rope: {thing}\n")


def by_hand() -> sapien.Scene:
    """A rope along x whose start is fixed at (0, 0, 1), above a plane."""
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    ground: Any = scene.create_actor_builder()
    ground.add_plane_collision(Pose([0, 0, 0], [0.7071067811865476, 0, -0.7071067811865475, 0]))
    ground.set_physx_body_type("static")
    ground.initial_pose = Pose()
    ground.build(name="floor")
    piece = LENGTH / PIECES
    half = piece / 2 - RADIUS
    straight, ends = DENSITY * np.pi * RADIUS**2 * 2 * half, DENSITY * np.pi * RADIUS**3 * 4 / 3
    along = (straight / 2 + ends * 2 / 5) * RADIUS**2
    across = straight * (RADIUS**2 / 4 + half**2 / 3)
    across += ends * (RADIUS**2 * 2 / 5 + half**2 + half * RADIUS * 3 / 4)
    pieces: list[Any] = []
    for i in range(PIECES):
        builder: Any = scene.create_actor_builder()
        builder.add_capsule_collision(radius=RADIUS, half_length=half)
        builder.set_mass_and_inertia(straight + ends, Pose(), [along, across, across])
        builder.initial_pose = Pose([(i + 0.5) * LENGTH / PIECES, 0, 1])
        entity = builder.build(name=f"rope/piece_{i}")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.linear_damping = 0.5
        pieces.append(entity)
    parents = [(None, Pose([0, 0, 1])), *((entity, Pose([piece / 2, 0, 0])) for entity in pieces[:-1])]
    for (parent, frame), entity in zip(parents, pieces, strict=True):
        drive: Any = scene.create_drive(parent, frame, entity, Pose([-piece / 2, 0, 0]))
        drive.set_limit_x(0, 0)
        drive.set_limit_y(0, 0)
        drive.set_limit_z(0, 0)
        if parent is not None:
            drive.set_drive_property_slerp(0, 100, mode="acceleration")
        drive.name = "rope/start" if parent is None else f"rope/joint_{pieces.index(parent)}"
    return scene


def test_the_prefab_is_what_a_person_builds() -> None:
    given = {"pieces": PIECES, "length": LENGTH, "radius": RADIUS, "density": DENSITY, "bending": 100}
    with load_scene(rope_file(fixed="start", **given), render=False) as batch:
        scene = by_hand()
        assert_same_scene(batch.scenes[0], scene)
        assert_same_trajectory(batch.scenes, [scene])


def fastest(batch: Any, seconds: float) -> float:
    """The highest speed of a piece during some seconds [m/s]."""
    pieces = [one for name, one in batch.entities.items() if "/" in name]
    speed = 0.0
    for _ in range(round(seconds / batch.timestep)):
        batch.step()
        speed = max(speed, *(float(np.linalg.norm(one.linear_velocity)) for one in pieces))
    return speed


def test_a_rope_of_forty_hangs_still_at_its_length() -> None:
    with load_scene(rope_file("{p: [0, 0, 2], rpy_deg: [0, 90, 0]}", fixed="start"), render=False) as batch:
        batch.step(300)
        assert fastest(batch, 0.5) < 0.01
        (last,) = batch.entities["rope/piece_39"].pose
        assert 2 - last[2] + 1 / 80 == pytest.approx(1, rel=0.01)


def test_a_rope_of_forty_comes_to_rest_on_a_floor() -> None:
    with load_scene(rope_file("{p: [0, 0, 0.9], rpy_deg: [0, 60, 10]}"), render=False) as batch:
        batch.step(350)
        assert fastest(batch, 0.5) < 0.02
        for i in range(39):
            (a,), (b,) = (batch.entities[f"rope/piece_{i + j}"].pose for j in (0, 1))
            assert np.linalg.norm(a[:3] - b[:3]) <= 1 / 40 * 1.02
