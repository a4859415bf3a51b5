"""One surface with its look: in a scene of trimesh's, or as a file of its own."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.glb.materials import Materials

if TYPE_CHECKING:
    from scenecc.meshes import Part


def geometry(part: Part, materials: Materials, *, turned: bool) -> Any:
    """Trimesh's mesh of a part. `turned`: its triangles are seen from the other side."""
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals

    surface = part.surface
    # trimesh counts v from the bottom of an image.
    uv = np.zeros((len(surface.vertices), 2)) if surface.uvs is None else surface.uvs * (1, -1) + (0, 1)
    sign = -1 if turned else 1
    return Trimesh(
        vertices=surface.vertices,
        faces=surface.faces[:, ::-1] if turned else surface.faces,
        vertex_normals=None if surface.normals is None else surface.normals * sign,
        visual=TextureVisuals(uv=uv, material=materials.material(part.look)),
        process=False,
        validate=False,
    )


def part_file(part: Part, *, turned: bool) -> bytes:
    """A part as a file of its own, in the axes of its shape and before that is scaled: nothing turns z up to y up."""
    import trimesh

    scene: Any = trimesh.Scene()
    materials = Materials()
    scene.geometry["part"] = geometry(part, materials, turned=turned)
    scene.graph.update(frame_to="node", frame_from=scene.graph.base_frame, matrix=np.eye(4), geometry="part")
    gltf: Any = import_module("trimesh.exchange.gltf")
    return bytes(gltf.export_glb(scene, tree_postprocessor=materials.finish))
