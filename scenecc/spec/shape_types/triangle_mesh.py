"""Non-convex meshes."""

from typing import Literal

from pydantic import Field

from scenecc.spec.leaf import Fixed
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, FileKeys, Scale


class TriangleMeshKeys(FileKeys):
    """A non-convex mesh; on a dynamic body it needs `sdf: true`."""

    type: Literal["triangle_mesh"]
    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")
    sdf: Fixed[bool] = Field(default=False, description="Cook a signed distance field, which a dynamic body needs.")


class TriangleMeshShape(TriangleMeshKeys, BothKeys):
    """A non-convex mesh that collides and is seen."""


class TriangleMeshCollision(TriangleMeshKeys, CollisionKeys):
    """A non-convex mesh that only collides."""
