"""What bodies of a plan look like, as triangles: their own poses, colours, images and names, and no engine.

Triangles, normals and texture coordinates of primitives are SAPIEN's own; mesh files are read by trimesh.
"""

from scenecc.meshes.drawing import Baked, Drawer, baked
from scenecc.meshes.surface import Image, Look, MeshProblem, Part, Shape, Surface

__all__ = ["Baked", "Drawer", "Image", "Look", "MeshProblem", "Part", "Shape", "Surface", "baked"]
