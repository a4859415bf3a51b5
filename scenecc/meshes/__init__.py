"""What bodies of a plan look like, as triangles: their own poses, colours, images and names, and no engine.

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
