"""Solids of revolution: mass, centre and inertia of what is built, against trimesh's of what is seen."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from plugins.nightly import examples
from sapien import physx

from scenecc.backends.sapien.geometry import make_revolved_parts
from scenecc.geometry.surfaces import revolved_surface
from scenecc.plan.geometry import REVOLVED_SOLIDS

SIZES = st.floats(0.02, 5)


def built(kind: str, *sizes: float) -> Any:
    """A body of the shapes that the engine has of a solid."""
    body = physx.PhysxRigidDynamicComponent()
    for shape in make_revolved_parts(*REVOLVED_SOLIDS[kind].unit_profile(*sizes), physx.get_default_material()):
        body.attach(shape)
    return body


@pytest.mark.parametrize("kind", REVOLVED_SOLIDS)
@settings(max_examples=examples(40), deadline=None)
@given(data=st.data())
def test_mass_and_inertia_of_a_revolved_solid_equal_the_meshs(kind: str, data: st.DataObject) -> None:
    solid = REVOLVED_SOLIDS[kind]
    given = {name: data.draw(SIZES) for name in solid.__slots__}
    if kind == "ring":
        given["inner_radius"] = given["outer_radius"] * data.draw(st.floats(0.01, 0.99))
    sizes = list(given.values())
    vertices, triangles, _, _ = revolved_surface(solid.profile(*sizes))
    mesh = trimesh.Trimesh(vertices, triangles)
    mesh.merge_vertices(merge_norm=True, merge_tex=True)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert solid.volume(*sizes) == pytest.approx(mesh.volume, rel=1e-9)

    body = built(kind, *sizes)
    assert body.mass == pytest.approx(1000 * mesh.volume, rel=1e-4)
    reach = max(sizes)
    assert_allclose(body.cmass_local_pose.p, mesh.center_mass, atol=1e-4 * reach)
    principal = np.linalg.eigvalsh(1000 * mesh.moment_inertia)
    assert_allclose(sorted(body.inertia), principal, rtol=1e-3)
