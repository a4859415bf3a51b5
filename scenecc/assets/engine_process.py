"""The process in which SAPIEN reads and cooks untrusted meshes, because some broken files crash it."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenecc.worker_process import Answer, Message

_UNSCALED = [1.0, 1.0, 1.0]

_NOT_LOADED = "failed to load scene"
"""In SAPIEN's error if its renderer cannot load the file either. Otherwise the mesh can still be rendered."""


def prepare() -> Answer:
    """Returns the function that answers requests."""
    physx: Any = importlib.import_module("sapien.physx")
    material = physx.get_default_material()

    def answer(header: dict[str, Any], parts: list[bytes]) -> Message:
        """Reads the file `path` for a `use`. If SAPIEN refuses it, the returned header has the reason as `error`."""
        del parts
        physx.clear_cache()
        path = header["path"]
        try:
            match header["use"]:
                case "hull":
                    physx.PhysxCollisionShapeConvexMesh(path, _UNSCALED, material)
                case "parts":
                    physx.PhysxCollisionShapeConvexMesh.load_multiple(path, _UNSCALED, material)
                case _:  # for a triangle mesh, the renderer reads a file as PhysX does
                    physx.PhysxCollisionShapeTriangleMesh(path, _UNSCALED, material)
        except RuntimeError as error:
            if header["use"] != "visual" or _NOT_LOADED in str(error):
                return {"error": str(error)}, []
        return {}, []

    return answer
