"""Shapes by their types.

`shapes` become a collision and a visual shape, `collisions` only collide, `visuals` are only seen.
"""

from typing import Annotated, Any

from scenecc.spec.copies import Repeated
from scenecc.spec.later import ByType

_SIMPLE = ("box", "sphere", "capsule", "cylinder", "plane", "convex_mesh")
_COLLIDING = (*_SIMPLE, "convex_parts", "triangle_mesh")
_SEEN = (*_SIMPLE, "mesh", "tiled_plane")

CollisionSpec = Annotated[Any, ByType("Collision", _COLLIDING), Repeated]
VisualSpec = Annotated[Any, ByType("Visual", _SEEN), Repeated]
ShapeSpec = Annotated[Any, ByType("Shape", _COLLIDING), Repeated]
