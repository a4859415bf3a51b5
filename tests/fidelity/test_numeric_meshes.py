"""Meshes of numbers, built: against arrays that a person gives to SAPIEN, and against trimesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import trimesh
from fidelity.test_emit_python import assert_same
from hypothesis import given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from sapien import physx

from scenecc import load_scene, open_scene
from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.geometry.surfaces import ellipsoid_surface
from scenecc.robots.description import (
    DescribedCollision,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
    RobotDescription,
)
from scenecc.robots.mujoco.shapes import numeric_mesh

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

RADII = (0.03, 0.02, 0.001)
HERE = Location("robot.xml", 1)


@pytest.fixture(autouse=True, scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture
def egg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A scene with an ellipsoid that its file describes."""
    mesh = numeric_mesh("egg", *ellipsoid_surface(RADII))
    link = DescribedLink(
        "egg",
        HERE,
        collisions=(DescribedCollision(mesh, IDENTITY_POSE, HERE),),
        visuals=(DescribedVisual(mesh, IDENTITY_POSE, HERE),),
    )
    robot = RobotDescription((DescribedRobot((link,), body_type="dynamic"),))
    monkeypatch.setattr("scenecc.robots.mujoco.reader.read_mjcf", lambda *_, **__: robot)
    (tmp_path / "robot.xml").touch()
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {egg: {mjcf: robot.xml, pose: [0, 0, 1]}}\n")
    return scene


def test_a_thin_ellipsoid_has_its_mass_and_equals_a_scene_by_hand(egg: Path) -> None:
    vertices, triangles, *_ = ellipsoid_surface(RADII)
    scale = np.ptp(vertices, axis=0) / 2
    with load_scene(egg, num_scenes=2) as batch:
        bodies: list[Any] = [each.components[-1] for each in batch.entities["egg"].objs]
        (shape,) = bodies[0].collision_shapes
        by_hand = physx.PhysxCollisionShapeConvexMesh(vertices / scale, scale, physx.get_default_material())
        assert np.array_equal(shape.vertices, by_hand.vertices)
        assert np.array_equal(shape.triangles, by_hand.triangles)
        assert np.array_equal(shape.scale, by_hand.scale)
        fresh: Any = physx.PhysxRigidDynamicComponent()
        fresh.attach(by_hand)
        for body in bodies:
            assert body.mass == fresh.mass
            assert body.mass == pytest.approx(1000 * trimesh.Trimesh(vertices, triangles).volume, rel=1e-4)


def test_a_script_with_numeric_meshes_builds_an_equal_scene(egg: Path) -> None:
    assert_same(open_scene(egg).plan, egg.parent)


@settings(max_examples=examples(60), deadline=None)
@given(seed=st.integers(0, 2**32 - 1), size=st.lists(st.floats(-3, 1), min_size=3, max_size=3), far=st.floats(-3, 3))
def test_small_and_oblong_hulls_keep_their_mass(seed: int, size: list[float], far: float) -> None:
    points = np.random.default_rng(seed).uniform(-1, 1, (40, 3)) * 10 ** np.array(size) + far
    hull = trimesh.convex.convex_hull(points)
    made = numeric_mesh("hull", points, hull.faces)
    cooked: Any = physx.PhysxCollisionShapeConvexMesh(str(made.path), made.scale, physx.get_default_material())
    volume = trimesh.Trimesh(cooked.vertices * cooked.scale, cooked.triangles).volume
    assert volume == pytest.approx(hull.volume, rel=0.01)
