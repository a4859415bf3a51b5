"""Meshes of strangers: before this process opens them, SAPIEN reads them in another one."""

from __future__ import annotations

from collections.abc import Iterator
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
    """Whether SAPIEN cannot read a mesh of these scenes; each is reported at the first shape that uses it so."""
    seen: set[tuple[int, str]] = set()
    failed = False
    for index, use, origin in _uses(plan, scene_idxs, rendered=rendered):
        if (index, use) in seen:
            continue
        seen.add((index, use))
        file = plan.files[index]
        fault = engine_fault(file, use) if file.path.is_file() else None  # a missing one is reported by the builder
        if fault is not None:
            code = "SC807" if use == "visual" else "SC801"
            message = f"SAPIEN cannot read '{file.path}': {fault}"
            failure = EngineFailure(code, message, origin=origin, hint="export the mesh again, as GLB or OBJ")
            report_failure(failure, sink, plan.origin)
            failed = True
    return failed


def _uses(
    plan: ScenePlan, scene_idxs: tuple[int, ...], *, rendered: bool
) -> Iterator[tuple[int, EngineUse, Origin | None]]:
    """Each file that the engine opens, by its index, with its use and place."""
    for entity in plan.entities:
        present, rows = rows_in_scenes(entity, scene_idxs)
        for body in entity.bodies if present else ():
            for shape in (*body.collisions, *(body.visuals if rendered else ())):
                geometry = shape.geometry
                if not isinstance(geometry, MeshGeometry):
                    continue
                use = _use(geometry)
                for index in np.unique(select_rows(geometry.file, rows)).tolist():
                    # A COLLADA that collides becomes a PLY of ours.
                    if use is not None and (use == "visual" or plan.files[index].path.suffix.lower() != ".dae"):
                        yield index, use, shape.origin or body.origin


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
