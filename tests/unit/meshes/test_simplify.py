"""Visual meshes with many triangles, simplified for an export."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

import scenecc
from scenecc import export
from scenecc.meshes.simplify import simplify_parts
from scenecc.meshes.surface import MeshPart, Surface, SurfaceMaterial


def part(subdivisions: int) -> MeshPart:
    ball = trimesh.creation.icosphere(subdivisions, radius=0.1)
    vertices, normals = np.asarray(ball.vertices, np.float32), np.asarray(ball.vertex_normals, np.float32)
    return MeshPart(Surface(vertices, np.asarray(ball.faces), normals, vertices[:, :2]), SurfaceMaterial())


def test_a_mesh_keeps_its_shape_with_fewer_triangles() -> None:
    ball, small = part(5), part(1)
    assert simplify_parts((ball,), len(ball.surface.faces)) == (ball,)
    made, kept = simplify_parts((ball, small), 2000)
    assert kept.surface is small.surface
    surface = made.surface
    assert 1000 < len(surface.faces) <= 2000
    assert surface.faces.max() < len(surface.vertices)
    assert surface.normals is not None
    assert np.linalg.norm(surface.normals, axis=1) == pytest.approx(1, abs=1e-5)
    assert surface.uvs is not None
    assert len(surface.uvs) == len(surface.vertices)
    found = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert found.volume == pytest.approx(4 / 3 * np.pi * 0.1**3, rel=0.05)
    assert np.abs(found.bounds) == pytest.approx(0.1, abs=0.005)


def test_exports_are_smaller_and_large_ones_are_noted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trimesh.creation.icosphere(5, radius=0.1).export(tmp_path / "ball.obj")
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {ball: {body_type: none, visuals: [{type: mesh, file: ball.obj}]}}\n")
    monkeypatch.setattr(export, "_LARGE", 100_000)
    whole = scenecc.open_scene(scene).emit("glb")
    assert [one.code for one in whole.diagnostics] == ["SC722"]
    made = scenecc.open_scene(scene).emit("glb", max_triangles=1000)
    assert made.diagnostics == []
    assert len(made.files["scene.glb"]) < len(whole.files["scene.glb"]) / 10
    with pytest.raises(ValueError, match="python does not support `max_triangles`"):
        scenecc.open_scene(scene).emit("python", max_triangles=1000)
