"""Compares convex hulls as cooked by PhysX with those of their files, because PhysX drops vertices near the hull."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from scenecc.assets.errors import AssetError
from scenecc.assets.measures import PLANE_TOLERANCE
from scenecc.assets.meshes import checked_content, read_hulls
from scenecc.backends.sapien.assets import UNMIRRORED
from scenecc.backends.sapien.audit.masses import CookedMeshes
from scenecc.backends.sapien.mesh_reading import used_meshes
from scenecc.diagnostics.diagnostic import Origin

if TYPE_CHECKING:
    from scenecc.assets.measures import Measures
    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan

MAX_CHANGE: Final = 0.5
"""Largest relative change of a hull's volume by cooking. Thin stickers on real robots gain a quarter."""

REPORTED_CHANGE: Final = 0.25
"""Smallest relative change that gives a warning."""

_MOST_OUTSIDE: Final = 4.0
"""How far a cooked hull may extend beyond its file, in units of the distance within which PhysX drops vertices."""


def report_changed_hulls(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink) -> bool:
    """Returns whether PhysX changes a hull of these scenes too much (SC423); warns of smaller changes (SC416)."""
    failed, meshes = False, CookedMeshes(plan)
    for (index, use), (geometry, origin) in used_meshes(plan, scene_idxs, rendered=False).items():
        if use not in {"hull", "parts"}:
            continue
        file, place = plan.files[index], origin or plan.origin or Origin(None)
        try:
            hulls = read_hulls(checked_content(file), parts=use == "parts")
            cooked = sum(part.enclosed for part in meshes.parts(geometry, (index, UNMIRRORED)))
            fault = _volume_error(
                hulls, cooked, "hulls to {:.0%} of their" if use == "parts" else "hull to {:.0%} of its"
            )
        except AssetError as error:
            fault = error
        if fault is not None:
            sink.report(fault.code, f"{file.uri}: {fault.message}", place, hint=fault.hint)
            failed = failed or fault.code != "SC416"
    return failed


def _volume_error(hulls: tuple[Measures, ...], cooked: float, whose: str) -> AssetError | None:
    """Returns the error for a change in volume, unless it is small. `cooked`: volume in PhysX [m³]."""
    expected = sum(hull.hull_volume or 0.0 for hull in hulls)
    ratio = cooked / expected if expected else 1.0
    change = abs(ratio - 1)
    if change <= REPORTED_CHANGE:
        return None
    code = "SC423" if change > MAX_CHANGE else "SC416"
    if cooked > sum(map(_limit_volume, hulls)):
        message = f"SAPIEN reads a different mesh: its hull has {ratio:.0%} of the volume"
        return AssetError(code, message, "export the mesh again, as GLB or OBJ")
    tolerance = max(hull.plane_tolerance for hull in hulls)
    message = f"PhysX cooks the {whose.format(ratio)} volume, because it drops vertices within {tolerance:.2g} m"
    hint = "use a capsule, a box or another solid, or shorter parts"
    if tolerance == PLANE_TOLERANCE:  # for a larger mesh it grows with the mesh
        hint = f"store the mesh larger, about 1 m long, and give the shape a `scale`; or {hint}"
    return AssetError(code, message, hint)


def _limit_volume(hull: Measures) -> float:
    """Returns the volume of a box around a hull [m³], the upper limit of a cooked hull."""
    margin = 2 * _MOST_OUTSIDE * hull.plane_tolerance
    return math.prod(high - low + margin for low, high in zip(hull.low, hull.high, strict=True))
