"""Shapes: one model a type and a list.

`shapes` become a collision and a visual shape, `collisions` only collide, `visuals` are only seen.
"""

from typing import Annotated, Literal

from pydantic import Field

from scenecc.spec.copies import Repeated
from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import Positive2
from scenecc.spec.shape_keys import (
    BothKeys,
    BoxKeys,
    CapsuleKeys,
    CollisionKeys,
    ConvexMeshKeys,
    ConvexPartsKeys,
    CylinderKeys,
    FileKeys,
    MirrorScale,
    PlaneColliding,
    PlaneKeys,
    PlaneSeen,
    Scale,
    SphereKeys,
    TriangleMeshKeys,
    VisualKeys,
)


class BoxCollision(BoxKeys, CollisionKeys):
    """A box that only collides."""


class BoxVisual(BoxKeys, VisualKeys):
    """A box that is only seen."""


class BoxShape(BoxKeys, BothKeys):
    """A box."""


class SphereCollision(SphereKeys, CollisionKeys):
    """A sphere that only collides."""


class SphereVisual(SphereKeys, VisualKeys):
    """A sphere that is only seen."""


class SphereShape(SphereKeys, BothKeys):
    """A sphere."""


class CapsuleCollision(CapsuleKeys, CollisionKeys):
    """A capsule that only collides."""


class CapsuleVisual(CapsuleKeys, VisualKeys):
    """A capsule that is only seen."""


class CapsuleShape(CapsuleKeys, BothKeys):
    """A capsule."""


class CylinderCollision(CylinderKeys, CollisionKeys):
    """A cylinder that only collides."""


class CylinderVisual(CylinderKeys, VisualKeys):
    """A cylinder that is only seen."""


class CylinderShape(CylinderKeys, BothKeys):
    """A cylinder."""


class PlaneCollision(PlaneKeys, PlaneColliding, CollisionKeys):
    """A plane that only collides."""


class PlaneVisual(PlaneKeys, PlaneSeen, VisualKeys):
    """A plane that is only seen."""


class PlaneShape(PlaneKeys, PlaneSeen, PlaneColliding, BothKeys):
    """A plane."""


class ConvexMeshCollision(ConvexMeshKeys, CollisionKeys):
    """A convex hull that only collides."""

    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")


class ConvexMeshVisual(ConvexMeshKeys, VisualKeys):
    """A mesh that is only seen."""

    scale: MirrorScale = Field(default=1.0, description="One factor or [x, y, z]; negative mirrors.")


class ConvexMeshShape(ConvexMeshKeys, BothKeys):
    """A convex hull that collides, and the mesh itself seen."""

    scale: Scale = Field(default=1.0, description="One factor or [x, y, z].")


class ConvexPartsCollision(ConvexPartsKeys, CollisionKeys):
    """Convex parts that only collide."""


class ConvexPartsShape(ConvexPartsKeys, BothKeys):
    """Convex parts that collide, and the mesh itself seen."""


class TriangleMeshCollision(TriangleMeshKeys, CollisionKeys):
    """A non-convex mesh that only collides."""


class TriangleMeshShape(TriangleMeshKeys, BothKeys):
    """A non-convex mesh that collides and is seen."""


class MeshVisual(FileKeys, VisualKeys):
    """What a file shows, with its own materials unless one is given."""

    type: Literal["mesh"]
    scale: MirrorScale = Field(default=1.0, description="One factor or [x, y, z]; negative mirrors.")


class TiledPlaneVisual(VisualKeys):
    """A flat quad facing +z with a repeated texture (ManiSkill's)."""

    type: Literal["tiled_plane"]
    half_size: Leaf[Positive2] = Field(description="Along x and y [m].")
    texture_repeat: Leaf[Positive2] = Field(description="How often the texture repeats along x and y.")


CollisionSpec = Annotated[
    BoxCollision
    | SphereCollision
    | CapsuleCollision
    | CylinderCollision
    | PlaneCollision
    | ConvexMeshCollision
    | ConvexPartsCollision
    | TriangleMeshCollision,
    Field(discriminator="type"),
    Repeated,
]
VisualSpec = Annotated[
    BoxVisual
    | SphereVisual
    | CapsuleVisual
    | CylinderVisual
    | PlaneVisual
    | ConvexMeshVisual
    | MeshVisual
    | TiledPlaneVisual,
    Field(discriminator="type"),
    Repeated,
]
ShapeSpec = Annotated[
    BoxShape
    | SphereShape
    | CapsuleShape
    | CylinderShape
    | PlaneShape
    | ConvexMeshShape
    | ConvexPartsShape
    | TriangleMeshShape,
    Field(discriminator="type"),
    Repeated,
]
