"""What shapes know of themselves, against the triangles that they are drawn of."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from numpy.testing import assert_allclose

from scenecc.geometry.rotation_arrays import rotation_matrix
from scenecc.meshes import primitives
from scenecc.plan import Box, Capsule, CollisionGeometry, Cone, Cylinder, Ring, Sphere, TiledPlane, VisualPlane, literal
from scenecc.plan.geometry import REVOLVED_SOLIDS, SOLIDS, Primitive, Solid
from scenecc.plan.schema import type_name

MADE = {
    "box": Box(literal((0.1, 0.2, 0.3))),
    "sphere": Sphere(literal(0.3)),
    "capsule": Capsule(literal(0.1), literal(0.4)),
    "cylinder": Cylinder(literal(0.2), literal(0.3)),
    "cone": Cone(literal(0.2), literal(0.3)),
    "ring": Ring(literal(0.15), literal(0.2), literal(0.3)),
    "plane": VisualPlane(literal((2.0, 3.0))),
    "tiled_plane": TiledPlane(literal((2.0, 3.0)), literal((4.0, 5.0))),
}
ROTATION = rotation_matrix(np.array([0.5, 0.1, -0.7, 0.5]) / np.linalg.norm([0.5, 0.1, -0.7, 0.5]))


def vertices_of(shape: Primitive) -> tuple[np.ndarray, np.ndarray]:
    surface, scale = primitives.scaled_surface(type_name(type(shape)), shape.sizes(0))
    return surface.vertices.astype(np.float64) * scale, surface.faces


def test_solids_are_the_primitives_that_collide() -> None:
    solids = SOLIDS | REVOLVED_SOLIDS
    assert set(solids.values()) == {shape for shape in get_args(CollisionGeometry) if issubclass(shape, Solid)}
    assert [type_name(solid) for solid in solids.values()] == list(solids)


@pytest.mark.parametrize("name", SOLIDS | REVOLVED_SOLIDS)
def test_a_volume_is_that_of_the_triangles(name: str) -> None:
    solid = MADE[name]
    assert isinstance(solid, Solid)
    vertices, faces = vertices_of(solid)
    volume = np.linalg.det(vertices[faces]).sum() / 6
    assert solid.volume(*solid.sizes(0)) == pytest.approx(
        volume, rel=1e-6 if name in {"box", *REVOLVED_SOLIDS} else 0.02
    )


@pytest.mark.parametrize("name", MADE)
def test_an_extent_is_that_of_the_triangles_in_another_frame(name: str) -> None:
    vertices, _ = vertices_of(MADE[name])
    turned = vertices @ ROTATION.T
    shape, sizes = MADE[name], MADE[name].sizes(0)
    assert_allclose(shape.extent(ROTATION, *sizes), np.abs(turned).max(axis=0), rtol=0.02)
    assert_allclose(shape.bounds(ROTATION, *sizes), [turned.min(axis=0), turned.max(axis=0)], rtol=0.02)
