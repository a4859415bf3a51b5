"""Shapes of a plan's bodies as triangle meshes with poses, materials, images and names. Independent of the engine.

Primitives have exactly SAPIEN's triangles, normals and texture coordinates; mesh files are read by trimesh.
"""

from scenecc.assets.errors import AssetError
from scenecc.meshes.surface import Image, MeshPart, Surface, SurfaceMaterial

__all__ = ["AssetError", "Image", "MeshPart", "Surface", "SurfaceMaterial"]
