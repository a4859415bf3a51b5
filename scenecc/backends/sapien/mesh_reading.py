"""Meshes of strangers: before this process opens them, SAPIEN reads them in another one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.assets.engine import engine_fault
from scenecc.backends.sapien.engine import EngineFailure, report_failure
from scenecc.backends.sapien.properties import rows_in_scenes, select_rows
from scenecc.plan import ConvexMesh, ConvexParts, Mesh, MeshGeometry

if TYPE_CHECKING:
    from scenecc.assets.engine import EngineUse
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import ScenePlan


def report_unreadable_meshes(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink, *, rendered: bool) -> bool:
    """Whether SAPIEN cannot read a mesh of these scenes; reported where the first shape that uses it names it."""
    failed = False
    for (index, use), origin in mesh_uses(plan, scene_idxs, rendered=rendered).items():
        file = plan.files[index]
        if not file.path.is_file() or (use != "visual" and file.path.suffix.lower() == ".dae"):
            continue  # the builder reports what is missing, and a COLLADA that collides becomes a PLY of ours
        fault = engine_fault(file, use)
        if fault is not None:
            code = "SC807" if use == "visual" else "SC801"
            message = f"SAPIEN cannot read '{file.path}': {fault}"
            failure = EngineFailure(code, message, origin=origin, hint="export the mesh again, as GLB or OBJ")
            report_failure(failure, sink, plan.origin)
            failed = True
    return failed


def mesh_uses(
    plan: ScenePlan, scene_idxs: tuple[int, ...], *, rendered: bool
) -> dict[tuple[int, EngineUse], Origin | None]:
    """Each file that the engine opens, by its index, with its use; and where the first shape that uses it names it."""
    found: dict[tuple[int, EngineUse], Origin | None] = {}
    for entity in plan.entities:
        present, rows = rows_in_scenes(entity, scene_idxs)
        for body in entity.bodies if present else ():
            for shape in (*body.collisions, *(body.visuals if rendered else ())):
                geometry = shape.geometry
                use = _use(geometry) if isinstance(geometry, MeshGeometry) else None
                if use is None or not isinstance(geometry, MeshGeometry):
                    continue
                for index in np.unique(select_rows(geometry.file, rows)).tolist():
                    place = shape.origin or body.origin
                    found.setdefault((index, use), place and place.child("file"))
    return found


def _use(geometry: MeshGeometry) -> EngineUse | None:
    """What the engine makes of a mesh; None: CoACD reads it."""
    match geometry:
        case ConvexMesh():
            return "hull"
        case ConvexParts():
            return "parts" if geometry.coacd is None else None
        case Mesh():
            return "visual"
        case _:
            return "triangles"
