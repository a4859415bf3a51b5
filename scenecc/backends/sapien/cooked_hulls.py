"""Convex hulls as PhysX has cooked them, compared with those of their files: PhysX drops vertices near the hull."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.measures import PLANE_TOLERANCE
from scenecc.assets.meshes import checked_content, read_hulls
from scenecc.backends.sapien.assets import collision_file
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.mesh_reading import used_meshes
from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan import AssetFile, ScenePlan

MAX_CHANGE: Final = 0.5
"""By how much of its volume a hull may be cooked to another: thin stickers on real robots gain a quarter."""

REPORTED_CHANGE: Final = 0.25
"""From which change on there is a warning."""

_MOST_OUTSIDE: Final = 4.0
"""How far outside its file a hull may be cooked, by the distance within which PhysX drops vertices."""

_UNSCALED: Final = (1.0, 1.0, 1.0)


def report_changed_hulls(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink) -> bool:
    """Whether PhysX cooks a hull of these scenes to another (SC423). Reports smaller changes as warnings (SC416)."""
    failed = False
    for (index, use), origin in used_meshes(plan, scene_idxs, rendered=False).items():
        if use not in {"hull", "parts"}:
            continue
        file, place = plan.files[index], origin or plan.origin or Origin(None)
        try:
            fault = _hull_fault(file, parts=use == "parts")
        except AssetError as error:
            fault = error
        if fault is not None:
            sink.report(fault.code, f"{file.uri}: {fault.message}", place, hint=fault.hint)
            failed = failed or fault.code != "SC416"
    return failed


def _hull_fault(file: AssetFile, *, parts: bool) -> AssetError | None:
    """How much the hulls of a file change. Raises AssetError where it cannot be read."""
    hulls = read_hulls(checked_content(file), parts=parts)
    expected = sum(hull.hull_volume or 0.0 for hull in hulls)
    if not expected:
        return None
    cooked = _cooked_triangles(collision_file(file), parts=parts)
    p, q, r = cooked[:, 0], cooked[:, 1], cooked[:, 2]
    ratio = float(np.einsum("ij,ij->", p, np.cross(q, r))) / 6 / expected
    change = abs(ratio - 1)
    if change <= REPORTED_CHANGE:
        return None
    code = "SC423" if change > MAX_CHANGE else "SC416"
    low, high = np.min([hull.low for hull in hulls], axis=0), np.max([hull.high for hull in hulls], axis=0)
    outside = float(np.maximum(low - cooked, cooked - high).max(initial=0.0))
    if outside > _MOST_OUTSIDE * max(hull.plane_tolerance for hull in hulls):
        message = f"SAPIEN reads another mesh: its hull reaches {outside:.3g} m outside the mesh of the file"
        return AssetError(code, message, "export the mesh again, as GLB or OBJ")
    whose = "hulls to {:.0%} of their" if parts else "hull to {:.0%} of its"
    message = f"PhysX cooks the {whose.format(ratio)} volume, since it drops vertices within {PLANE_TOLERANCE} m"
    hint = "store the mesh larger, about 1 m long, and give the shape a `scale`; or use a box or another solid"
    return AssetError(code, message, hint)


def _cooked_triangles(path: Path, *, parts: bool) -> NDArray[np.float64]:
    """The corners (n, 3, 3) of all triangles that PhysX has cooked [m]."""
    hull, material = physx.PhysxCollisionShapeConvexMesh, physx.get_default_material()
    shapes: list[Any] = (
        hull.load_multiple(str(path), _UNSCALED, material) if parts else [hull(str(path), _UNSCALED, material)]
    )
    return np.concatenate([np.zeros((0, 3, 3)), *(shape.vertices[shape.triangles] for shape in shapes)])
