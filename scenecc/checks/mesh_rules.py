"""Rules for meshes, by use. During the build, `backends/sapien/cooked_hulls.py` compares cooked meshes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.files import check_measures

if TYPE_CHECKING:
    from scenecc.assets.measures import Measures
    from scenecc.assets.mesh_uses import MeshUse
    from scenecc.assets.meshes import MeshRecord

MIN_THICKNESS = 1e-5
"""Minimum thickness of a hull [m]. PhysX cooks thinner ones to something else, or fails."""


def check_mesh_use(
    mesh: MeshRecord, use: MeshUse, suffix: str, parts: Callable[[], tuple[Measures, ...]]
) -> Iterator[AssetError]:
    """Yields faults of a mesh in one use; of its parts, only those of the first faulty one.

    Args:
        mesh: the mesh.
        use: how it is used.
        suffix: suffix of the file, in lower case.
        parts: measures the convex parts that SAPIEN makes of the mesh.
    """
    try:
        whole = check_measures(mesh)
    except AssetError as fault:
        yield fault
        return
    if use == "visual":
        yield from (AssetError(*fault) for fault in mesh.visual_faults)
    if use == "parts" and suffix == ".stl":
        yield AssetError(
            "SC421",
            "an STL has no named parts: SAPIEN guesses them from its triangles",
            "export the parts as objects of an OBJ",
        )
    if use in {"triangles", "decomposed"} and all(part.degenerate for part in mesh.parts):
        yield AssetError("SC415", "all triangles of the mesh are degenerate", "export the mesh again")
    if use == "hull":
        yield from _hull_faults((whole,), "", _FLAT)
    if use == "parts":
        hint = _FLAT if suffix != ".ply" else "merge its vertices: triangles that share vertices form one part"
        yield from _hull_faults(parts(), " of one of its parts", hint)


_FLAT = "give it a thickness, or use a box"


def _hull_faults(hulls: tuple[Measures, ...], whose: str, hint: str) -> Iterator[AssetError]:
    """Yields faults of hulls without volume, or far from their origin. `hint`: hint of the first."""
    thin = min(hull.thickness for hull in hulls)
    if thin < MIN_THICKNESS:
        yield AssetError("SC415", f"the hull{whose} has no volume: it is {thin:.3g} m thick", hint)
        return
    for hull in hulls:
        step, tolerance = float(np.spacing(np.float32(hull.reach))), hull.plane_tolerance
        if step > tolerance:
            # If rounding moves vertices farther than that, PhysX may never finish.
            yield AssetError(
                "SC417",
                f"the hull{whose} is {hull.length:.3g} m long and reaches {hull.reach:.3g} m from its origin, where "
                f"coordinates are rounded to {step:.2g} m",
                "export it around its own centre",
            )
            return
