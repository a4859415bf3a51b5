"""Meshes and terrain that a robot's description holds as numbers."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

import numpy as np
import pytest
import trimesh
from numpy.testing import assert_allclose

from scenecc import open_scene
from scenecc.assets.meshes import checked_content, read_triangles
from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.geometry.surfaces import ellipsoid_surface
from scenecc.plan import AssetFile, Heightfield, MeshGeometry
from scenecc.plan.diff import diff_plans
from scenecc.plan.json_codec import plan_to_json
from scenecc.robots.description import (
    DescribedCollision,
    DescribedLink,
    DescribedRobot,
    DescribedVisual,
    HeightfieldGeometry,
    RobotDescription,
)
from scenecc.robots.mujoco.shapes import numeric_mesh

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc import Scene
    from scenecc.robots.description import Geometry

RADII = (0.03, 0.02, 0.001)
HERE = Location("robot.xml", 1)


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache"


def scene_of(*geometries: Geometry, folder: Path, monkeypatch: pytest.MonkeyPatch) -> Scene:
    """A static body that its file describes so."""
    link = DescribedLink(
        "rock",
        HERE,
        collisions=tuple(DescribedCollision(one, IDENTITY_POSE, HERE) for one in geometries),
        visuals=tuple(DescribedVisual(one, IDENTITY_POSE, HERE) for one in geometries),
    )
    robot = RobotDescription((DescribedRobot((link,), body_type="static"),))
    monkeypatch.setattr("scenecc.robots.mujoco.reader.read_mjcf", lambda *_, **__: robot)
    (folder / "robot.xml").touch()
    (folder / "scene.yaml").write_text("scenecc: 1\nentities: {rock: {mjcf: robot.xml}}\n")
    return open_scene(folder / "scene.yaml")


@pytest.mark.parametrize("radii", [(1, 1, 1), RADII, (0.1, 3, 20)], ids=str)
def test_an_ellipsoid_becomes_a_hull_with_its_volume(radii: tuple[float, ...]) -> None:
    vertices, triangles, normals, uvs = ellipsoid_surface(radii)
    mesh = trimesh.Trimesh(vertices, triangles)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(4 / 3 * np.pi * np.prod(radii), rel=1e-12)
    assert len(mesh.vertices) == 222
    assert len(mesh.facets) + len(trimesh.convex.convex_hull(mesh).faces) - sum(map(len, mesh.facets)) <= 255
    assert_allclose(np.linalg.norm(vertices / np.array(radii), axis=1), 1.0114291792)
    assert_allclose(np.linalg.norm(normals, axis=1), 1)
    assert (np.einsum("ij,ij->i", vertices, normals) > 0).all()
    assert uvs.shape == (len(vertices), 2)


def test_a_numeric_mesh_is_normalized_and_scaled_to_its_size() -> None:
    vertices, triangles, normals, uvs = ellipsoid_surface(RADII)
    made = numeric_mesh("a/b \n", vertices, triangles, normals, uvs)
    assert made.uri == "mesh://a_b__.ply"
    assert made.data == made.path.read_bytes()
    assert_allclose(made.scale, np.ptp(vertices, axis=0) / 2)
    read = trimesh.load(made.path, process=False)
    assert isinstance(read, trimesh.Trimesh)
    assert_allclose(np.ptp(read.vertices, axis=0), 2, rtol=1e-6)
    assert_allclose(read.vertices * made.scale, vertices, atol=1e-8)
    assert_allclose(read.vertex_normals, vertices / made.scale / 1.0114291792, atol=2e-2)
    ((vertices, faces),) = read_triangles(checked_content(AssetFile(made.uri, made.path)))
    assert np.array_equal(vertices, read.vertices)
    assert np.array_equal(faces, triangles)


def test_a_flat_mesh_keeps_its_size_where_it_is_flat() -> None:
    square = np.array([[0, 0, 3], [4, 0, 3], [4, 2, 3], [0, 2, 3]])
    assert numeric_mesh("flat", square, np.array([[0, 1, 2], [0, 2, 3]])).scale == (2, 1, 1)


def test_equal_meshes_are_one_file(cache: Path) -> None:
    vertices, triangles, *_ = ellipsoid_surface(RADII)
    one, two = (numeric_mesh("egg", size * vertices, triangles) for size in (1, 2))
    assert one.path == two.path
    assert len(list(cache.rglob("*.ply"))) == 1


def test_a_cache_folder_that_cannot_be_written_is_an_error(cache: Path) -> None:
    cache.touch()
    with pytest.raises(OSError, match="cache"):
        numeric_mesh("egg", *ellipsoid_surface(RADII)[:2])


def test_a_numeric_mesh_is_saved_with_the_plan(tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    egg = numeric_mesh("egg", *ellipsoid_surface(RADII))
    plan = scene_of(egg, folder=tmp_path, monkeypatch=monkeypatch).plan
    (body,) = plan.entities[0].bodies
    for shape in (*body.collisions, *body.visuals):
        assert isinstance(shape.geometry, MeshGeometry)
        assert shape.geometry.scale.row(0).tolist() == list(egg.scale)
        assert plan.files[int(shape.geometry.file.row(0))].data == egg.data
    (tmp_path / "plan.json").write_text(plan_to_json(plan))
    egg.path.unlink()
    assert open_scene(tmp_path / "plan.json").plan == plan
    assert egg.path.is_file()


def test_a_different_mesh_with_the_same_name_is_a_difference(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, triangles, *_ = ellipsoid_surface(RADII)
    other = vertices[:, [0, 2, 1]] * (1, 1, -1)
    a, b = (
        scene_of(numeric_mesh("egg", points, triangles), folder=tmp_path, monkeypatch=monkeypatch).plan
        for points in (vertices, other)
    )
    assert a != b
    assert any("mesh://egg.ply" in str(one.a) for one in diff_plans(a, b))


def test_a_plan_whose_mesh_cannot_be_stored_is_an_error(
    tmp_path: Path, cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    egg = numeric_mesh("egg", *ellipsoid_surface(RADII)[:2])
    (tmp_path / "plan.json").write_text(plan_to_json(scene_of(egg, folder=tmp_path, monkeypatch=monkeypatch).plan))
    shutil.rmtree(cache)
    cache.touch()
    (told,) = open_scene(tmp_path / "plan.json").diagnostics
    assert (told.code, told.path) == ("SC711", "files[1].uri")
    assert "'mesh://egg.ply' cannot be kept in the cache folder" in told.message


def test_mesh_data_with_a_wrong_hash_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    egg = numeric_mesh("egg", *ellipsoid_surface(RADII)[:2])
    text = plan_to_json(scene_of(egg, folder=tmp_path, monkeypatch=monkeypatch).plan)
    (tmp_path / "plan.json").write_text(text.replace(egg.path.stem, "0" * 64))
    assert [one.code for one in open_scene(tmp_path / "plan.json").diagnostics] == ["SC716"]


def test_terrain_becomes_a_heightfield_that_collides_and_is_visible(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = ((0.0, 0.5, 1.0), (0.25, 0.0, 0.0))
    scene = scene_of(HeightfieldGeometry((4, 2, 0.5), heights), folder=tmp_path, monkeypatch=monkeypatch)
    (body,) = scene.plan.entities[0].bodies
    for shape in (*body.collisions, *body.visuals):
        assert isinstance(shape.geometry, Heightfield)
        assert shape.geometry.heights == heights
        assert shape.geometry.size.row(0).tolist() == [4, 2, 0.5]


def test_terrain_in_a_file_has_the_same_limit_as_in_a_scene(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    large = HeightfieldGeometry((4, 2, 0.5), ((0.0,) * 1024,) * 300)
    scene = scene_of(large, folder=tmp_path, monkeypatch=monkeypatch)
    assert {one.message for one in scene.diagnostics} == {"invalid heightfield: there are more than 262144 heights"}
