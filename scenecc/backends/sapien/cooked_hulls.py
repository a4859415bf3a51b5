"""Convex hulls as PhysX has cooked them, compared with those of their files: PhysX drops vertices near the hull."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.assets.measures import PLANE_TOLERANCE
from scenecc.assets.meshes import checked_content, read_hulls
from scenecc.backends.sapien.assets import collision_file
from scenecc.backends.sapien.engine import physx
from scenecc.backends.sapien.mesh_reading import mesh_uses
from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import AssetFile, ScenePlan

MAX_CHANGE: Final = 0.5
"""By how much of its volume a hull may be cooked to another: thin stickers on real robots gain a quarter."""

REPORTED_CHANGE: Final = 0.25
"""From which change on there is a warning."""

_UNSCALED: Final = (1.0, 1.0, 1.0)


def report_changed_hulls(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink) -> bool:
    """Whether PhysX cooks a hull of these scenes to another (SC423). Reports smaller changes as warnings (SC416)."""
    failed = False
    for (index, use), origin in mesh_uses(plan, scene_idxs, rendered=False).items():
        if use not in {"hull", "parts"}:
            continue
        file, place = plan.files[index], origin or plan.origin or Origin(None)
        try:
            ratio = _volume_ratio(file, parts=use == "parts")
        except AssetError as fault:
            sink.report(fault.code, f"{file.uri}: {fault.message}", place, hint=fault.hint)
            failed = True
            continue
        change = abs(ratio - 1)
        if change <= REPORTED_CHANGE:
            continue
        whose = "hulls to {:.0%} of their" if use == "parts" else "hull to {:.0%} of its"
        message = f"{file.uri}: PhysX cooks the {whose.format(ratio)} volume, since it drops vertices within"
        hint = "store the mesh larger, about 1 m long, and give the shape a `scale`; or use a box or another solid"
        code = "SC423" if change > MAX_CHANGE else "SC416"
        sink.report(code, f"{message} {PLANE_TOLERANCE} m", place, hint=hint)
        failed = failed or change > MAX_CHANGE
    return failed


def _volume_ratio(file: AssetFile, *, parts: bool) -> float:
    """The volume that PhysX has cooked, by that of the file; 1 where the file has none. Raises AssetError."""
    expected = sum(hull.hull_volume or 0.0 for hull in read_hulls(checked_content(file), parts=parts))
    return _cooked_volume(collision_file(file), parts=parts) / expected if expected else 1.0


def _cooked_volume(path: Path, *, parts: bool) -> float:
    hull, material = physx.PhysxCollisionShapeConvexMesh, physx.get_default_material()
    shapes: list[Any] = (
        hull.load_multiple(str(path), _UNSCALED, material) if parts else [hull(str(path), _UNSCALED, material)]
    )
    total = 0.0
    for shape in shapes:
        p, q, r = (shape.vertices[shape.triangles[:, i]].astype(np.float64) for i in range(3))
        total += float(np.einsum("ij,ij->", p, np.cross(q, r))) / 6
    return total
