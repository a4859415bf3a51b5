"""Surfaces as files: what viser makes of them is what SAPIEN draws."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
import trimesh

from scenecc.meshes import Look, Part, primitives
from scenecc.viewing.nodes import Files


def mesh_of(part: Part) -> Any:
    files = Files()
    content = files.contents[files.digest(part, turned=False)]
    scene: Any = trimesh.load_scene(io.BytesIO(content), file_type="glb", process=False)
    assert b"NORMAL" not in content, "viser would write over what shares its numbers"
    (mesh,) = scene.geometry.values()
    return mesh


@pytest.mark.parametrize("name", ["box", "sphere", "cylinder", "plane"])
def test_a_primitive_keeps_its_vertices(name: str) -> None:
    surface = getattr(primitives, name)()
    mesh = mesh_of(Part(surface, Look()))
    assert np.array_equal(mesh.vertices, surface.vertices)
    assert np.array_equal(mesh.faces, surface.faces)


def test_triangles_that_are_flat_share_no_vertex() -> None:
    ball = primitives.sphere()
    surface = primitives.surface(ball.vertices, ball.faces, None, ball.uvs)
    mesh = mesh_of(Part(surface, Look()))
    assert len(mesh.vertices) == 3 * len(ball.faces)
    assert np.array_equal(mesh.triangles, ball.vertices[ball.faces])
