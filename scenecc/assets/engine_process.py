"""Meshes of strangers as SAPIEN reads and cooks them, in a process of its own: some broken files end the process."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenecc.worker_process import Answer, Message

_UNSCALED = [1.0, 1.0, 1.0]

_NOT_LOADED = "failed to load scene"
"""In SAPIEN's error where its renderer cannot load a file either. What it only cannot cook may still be shown."""


def prepare() -> Answer:
    """What answers a request."""
    physx: Any = importlib.import_module("sapien.physx")
    material = physx.get_default_material()

    def answer(header: dict[str, Any], parts: list[bytes]) -> Message:
        """Reads the file `path` for a `use`; a header with `error` says why SAPIEN refuses it."""
        del parts
        physx.clear_cache()
        path = header["path"]
        try:
            match header["use"]:
                case "hull":
                    physx.PhysxCollisionShapeConvexMesh(path, _UNSCALED, material)
                case "parts":
                    physx.PhysxCollisionShapeConvexMesh.load_multiple(path, _UNSCALED, material)
                case _:  # the renderer reads a file as PhysX does for a triangle mesh
                    physx.PhysxCollisionShapeTriangleMesh(path, _UNSCALED, material)
        except RuntimeError as error:
            if header["use"] != "visual" or _NOT_LOADED in str(error):
                return {"error": str(error)}, []
        return {}, []

    return answer
