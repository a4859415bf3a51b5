"""Primitives against the triangles of SAPIEN's own render shapes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from scenecc.meshes import Surface, primitives

NAMES = ("box", "sphere", "capsule", "cylinder", "plane")


def ours(name: str) -> Surface:
    return primitives.capsule(0.2, 0.5) if name == "capsule" else getattr(primitives, name)()


def sapiens(name: str) -> Any:
    from sapien import render

    material = render.RenderMaterial()
    return {
        "box": lambda: render.RenderShapeBox([1, 1, 1], material),
        "sphere": lambda: render.RenderShapeSphere(1, material),
        "capsule": lambda: render.RenderShapeCapsule(0.2, 0.5, material),
        "cylinder": lambda: render.RenderShapeCylinder(1, 1, material),
        "plane": lambda: render.RenderShapePlane([1, 1, 1], material),
    }[name]()


@pytest.mark.render
@pytest.mark.parametrize("name", NAMES)
def test_a_primitive_equals_sapiens(name: str) -> None:
    mine, theirs = ours(name), sapiens(name)
    assert mine.normals is not None
    assert mine.uvs is not None
    assert_allclose(mine.vertices, theirs.vertices, atol=5e-7)
    assert_allclose(mine.normals, theirs.vertex_normal, atol=5e-7)
    assert_allclose(mine.uvs, theirs.vertex_uv, atol=1e-7)
    assert_array_equal(mine.faces, theirs.triangles)


@pytest.mark.parametrize("name", NAMES)
def test_primitive_triangles_face_outwards_and_are_read_only(name: str) -> None:
    surface = ours(name)
    assert surface.normals is not None
    corners = surface.vertices[surface.faces].astype(np.float64)
    facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    shaded = surface.normals[surface.faces].mean(axis=1)
    assert ((facing * shaded).sum(axis=1) > 0).all()
    with pytest.raises(ValueError, match="read-only"):
        surface.vertices[0] = 0


def test_a_tiled_plane_faces_z_and_repeats_its_image() -> None:
    surface = primitives.tiled_plane((4.0, 2.0))
    assert surface.uvs is not None
    assert_array_equal(surface.vertices[:, 2], 0)
    assert_array_equal(np.ptp(surface.uvs, axis=0), [4, 2])
    a, b, c = surface.vertices[surface.faces[0]]
    assert np.cross(b - a, c - a)[2] > 0
