"""Test reads of untrusted meshes: SAPIEN reads them in another process before this one opens them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.assets.engine import engine_fault
from scenecc.assets.mesh_uses import mesh_use
from scenecc.backends.sapien.engine import EngineFailure
from scenecc.backends.sapien.properties import rows_in_scenes, select_rows
from scenecc.plan import MeshGeometry

if TYPE_CHECKING:
    from scenecc.assets.mesh_uses import MeshUse
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import ScenePlan


def report_unreadable_meshes(plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink, *, rendered: bool) -> bool:
    """Returns whether SAPIEN cannot read a mesh of these scenes; reports it at the first shape that uses it."""
    failed = False
    for (index, use), (_, origin) in used_meshes(plan, scene_idxs, rendered=rendered).items():
        file = plan.files[index]
        converted = use != "visual" and file.path.suffix.lower() == ".dae"
        if use == "decomposed" or converted or not file.path.is_file():
            continue  # CoACD reads it, a PLY of ours replaces it, or the builder reports that it is missing
        fault = engine_fault(file, use)
        if fault is not None:
            code = "SC807" if use == "visual" else "SC801"
            message = f"SAPIEN cannot read '{file.path}': {fault}"
            failure = EngineFailure(code, message, origin=origin, hint="export the mesh again, in another format")
            failure.report(sink, plan.origin)
            failed = True
    return failed


def used_meshes(
    plan: ScenePlan, scene_idxs: tuple[int, ...], *, rendered: bool
) -> dict[tuple[int, MeshUse], tuple[MeshGeometry, Origin | None]]:
    """Returns each mesh of these scenes, by file index and use, with its first shape and that shape's origin."""
    found: dict[tuple[int, MeshUse], tuple[MeshGeometry, Origin | None]] = {}
    for entity in plan.entities:
        present, rows = rows_in_scenes(entity, scene_idxs)
        for body in entity.bodies if present else ():
            for shape in (*body.collisions, *(body.visuals if rendered else ())):
                if isinstance(geometry := shape.geometry, MeshGeometry):
                    place = shape.origin or body.origin
                    first = geometry, place and place.child("file")
                    for index in np.unique(select_rows(geometry.file, rows)).tolist():
                        found.setdefault((index, mesh_use(geometry)), first)
    return found
