"""Rules for meshes, by use. What PhysX cooks of them is compared in the build (`backends/sapien/cooked_hulls.py`)."""

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
"""Thickness below which a hull is refused [m]. PhysX cooks a thinner one to something else, or not at all."""


def check_mesh_use(
    mesh: MeshRecord, use: MeshUse, suffix: str, parts: Callable[[], tuple[Measures, ...]]
) -> Iterator[AssetError]:
    """Faults of a mesh in one use, of parts only that of the first.

    Args:
        mesh: what was read.
        use: what is made of it.
        suffix: of the file, in lower case.
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
            "an STL has no parts: SAPIEN guesses them from its triangles",
            "export the parts as objects of an OBJ",
        )
    if use in {"triangles", "decomposed"} and all(part.degenerate for part in mesh.parts):
        yield AssetError("SC415", "all triangles of the mesh are degenerate", "export the mesh again")
    if use == "hull":
        yield from _hull_faults((whole,), "", _FLAT)
    if use == "parts":
        hint = _FLAT if suffix != ".ply" else "merge its vertices: triangles are one part where they share vertices"
        yield from _hull_faults(parts(), " of one of its parts", hint)


_FLAT = "give it a thickness, or use a box"


def _hull_faults(hulls: tuple[Measures, ...], whose: str, hint: str) -> Iterator[AssetError]:
    """Hulls without volume, and far from their origin. `hint`: of the first."""
    thin = min(hull.thickness for hull in hulls)
    if thin < MIN_THICKNESS:
        yield AssetError("SC415", f"the hull{whose} has no volume: it is {thin:.3g} m thick", hint)
        return
    for hull in hulls:
        step, tolerance = float(np.spacing(np.float32(hull.reach))), hull.plane_tolerance
        if step > tolerance:
            # Where rounding moves vertices farther than that, PhysX may cook for ever.
            yield AssetError(
                "SC417",
                f"the hull{whose} is {hull.length:.3g} m long and reaches {hull.reach:.3g} m from its origin, where "
                f"coordinates are rounded to {step:.2g} m",
                "export it about its own centre",
            )
            return
