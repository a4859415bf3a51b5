"""Shapes of a plan's bodies as triangles, with poses, colours, images and names, without an engine.

Triangles, normals and texture coordinates of primitives are SAPIEN's own; mesh files are read by trimesh.
"""

from scenecc.meshes.builder import BakedMesh, MeshBuilder, bake_scale
from scenecc.meshes.surface import Image, MeshError, MeshPart, MeshShape, Surface, SurfaceMaterial

__all__ = [
    "BakedMesh",
    "Image",
    "MeshBuilder",
    "MeshError",
    "MeshPart",
    "MeshShape",
    "Surface",
    "SurfaceMaterial",
    "bake_scale",
]
