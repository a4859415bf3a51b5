"""Convex hulls of meshes."""

from typing import Literal

from pydantic import Field

from scenecc.spec.shape_keys import BothKeys, CollisionKeys, FileKeys, MirrorScale, Scale, VisualKeys


class ConvexMeshKeys(FileKeys):
    """The convex hull of a file collides; the mesh itself is seen."""

    type: Literal["convex_mesh"]


class ConvexMeshShape(ConvexMeshKeys, BothKeys):
    """A convex hull that collides, and the mesh itself seen."""

    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")


class ConvexMeshCollision(ConvexMeshKeys, CollisionKeys):
    """A convex hull that only collides."""

    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")


class ConvexMeshVisual(ConvexMeshKeys, VisualKeys):
    """A mesh that is only seen."""

    scale: MirrorScale = Field(default=1.0, description="One factor or [x, y, z]; negative mirrors.")
