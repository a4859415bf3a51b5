"""Shapes of a plan's bodies as triangles, with poses, colours, images and names, without an engine.

Triangles, normals and texture coordinates of primitives are SAPIEN's own; mesh files are read by trimesh.
"""

from scenecc.assets.errors import AssetError
from scenecc.meshes.surface import Image, MeshPart, Surface, SurfaceMaterial

__all__ = ["AssetError", "Image", "MeshPart", "Surface", "SurfaceMaterial"]
