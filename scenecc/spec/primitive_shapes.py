"""Boxes, spheres, capsules, cylinders and planes. Imported when a document has one."""

from typing import Literal

from pydantic import Field

from scenecc.spec.base import Finite, Positive, Positive2, Positive3, SpecModel, Vec3
from scenecc.spec.pose import AxisName
from scenecc.spec.shapes import CollisionKeys, ShapeBothKeys, VisualKeys
from scenecc.spec.values import Fixed, Leaf


class BoxKeys(SpecModel):
    """A box."""

    type: Literal["box"]
    half_size: Leaf[Positive3] = Field(description="Half of the edges along x, y, z [m].")


class BoxShape(BoxKeys, ShapeBothKeys):
    """A box."""


class BoxCollision(BoxKeys, CollisionKeys):
    """A box that only collides."""


class BoxVisual(BoxKeys, VisualKeys):
    """A box that is only seen."""


class SphereKeys(SpecModel):
    """A sphere."""

    type: Literal["sphere"]
    radius: Leaf[Positive] = Field(description="Radius [m].")


class SphereShape(SphereKeys, ShapeBothKeys):
    """A sphere."""


class SphereCollision(SphereKeys, CollisionKeys):
    """A sphere that only collides."""


class SphereVisual(SphereKeys, VisualKeys):
    """A sphere that is only seen."""


class CapsuleKeys(SpecModel):
    """A cylinder with a half sphere at both ends."""

    type: Literal["capsule"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length between the centres of the caps [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class CapsuleShape(CapsuleKeys, ShapeBothKeys):
    """A capsule."""


class CapsuleCollision(CapsuleKeys, CollisionKeys):
    """A capsule that only collides."""


class CapsuleVisual(CapsuleKeys, VisualKeys):
    """A capsule that is only seen."""


class CylinderKeys(SpecModel):
    """A cylinder. What collides is a convex mesh."""

    type: Literal["cylinder"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class CylinderShape(CylinderKeys, ShapeBothKeys):
    """A cylinder."""


class CylinderCollision(CylinderKeys, CollisionKeys):
    """A cylinder that only collides."""


class CylinderVisual(CylinderKeys, VisualKeys):
    """A cylinder that is only seen."""


class PlaneKeys(SpecModel):
    """An endless plane; everything on the side of its normal is free. Never on a dynamic body."""

    type: Literal["plane"]
    normal: Leaf[Vec3] = Field(default=(0.0, 0.0, 1.0), description="Direction of the free side, of any length.")
    offset: Leaf[Finite] = Field(default=0.0, description="Distance along the normal [m].")


class PlaneVisualKeys(SpecModel):
    """What is seen of a plane."""

    half_size: Leaf[Positive2] = Field(
        default=(10.0, 10.0), description="Visible half extent along the plane's own y and z, as in SAPIEN [m]."
    )


class PlaneCollisionKeys(SpecModel):
    """How often a plane is built."""

    every_scene: Fixed[bool] = Field(
        default=False, description="In a shared GPU simulation: build it in each scene, not once."
    )


class PlaneShape(PlaneKeys, PlaneVisualKeys, PlaneCollisionKeys, ShapeBothKeys):
    """A plane."""


class PlaneCollision(PlaneKeys, PlaneCollisionKeys, CollisionKeys):
    """A plane that only collides."""


class PlaneVisual(PlaneKeys, PlaneVisualKeys, VisualKeys):
    """A plane that is only seen."""


class TiledPlaneVisual(VisualKeys):
    """A flat quad facing +z with a repeated texture (ManiSkill's)."""

    type: Literal["tiled_plane"]
    half_size: Leaf[Positive2] = Field(description="Along x and y [m].")
    texture_repeat: Leaf[Positive2] = Field(description="How often the texture repeats along x and y.")
