"""Convex hulls as PhysX has cooked them, compared with those of their files: PhysX drops vertices near the hull."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.assets.errors import AssetError
from scenecc.assets.measures import PLANE_TOLERANCE
from scenecc.assets.meshes import checked_content, read_hulls
from scenecc.backends.sapien.assets import UNMIRRORED
from scenecc.backends.sapien.audit.masses import CookedMeshes
from scenecc.backends.sapien.mesh_reading import used_meshes
from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

MAX_CHANGE: Final = 0.5
"""By how much of its volume a hull may be cooked to another: thin stickers on real robots gain a quarter."""

REPORTED_CHANGE: Final = 0.25
"""From which change on there is a warning."""


def report_changed_hulls(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink) -> bool:
    """Whether PhysX cooks a hull of these scenes to another (SC423). Reports smaller changes as warnings (SC416)."""
    failed, meshes = False, CookedMeshes(plan)
    for (index, use), (geometry, origin) in used_meshes(plan, scene_idxs, rendered=False).items():
        if use not in {"hull", "parts"}:
            continue
        file, place = plan.files[index], origin or plan.origin or Origin(None)
        try:
            hulls = read_hulls(checked_content(file), parts=use == "parts")
        except AssetError as fault:
            sink.report(fault.code, f"{file.uri}: {fault.message}", place, hint=fault.hint)
            failed = True
            continue
        expected = sum(hull.hull_volume or 0.0 for hull in hulls)
        cooked = sum(part.enclosed for part in meshes.parts(geometry, (index, UNMIRRORED)))
        change = abs(cooked / expected - 1) if expected else 0.0
        if change <= REPORTED_CHANGE:
            continue
        what = "hulls to {:.0%} of their" if use == "parts" else "hull to {:.0%} of its"
        message = f"{file.uri}: PhysX cooks the {what.format(cooked / expected)} volume, since it drops vertices within"
        hint = "store the mesh larger, about 1 m long, and give the shape a `scale`; or use a box or another solid"
        code = "SC423" if change > MAX_CHANGE else "SC416"
        sink.report(code, f"{message} {PLANE_TOLERANCE} m", place, hint=hint)
        failed = failed or change > MAX_CHANGE
    return failed
