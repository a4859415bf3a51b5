"""Planes."""

from typing import Literal

from pydantic import Field

from scenecc.spec.base import Model
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.scalars import Finite, Positive2, Vec3
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, VisualKeys


class PlaneKeys(Model):
    """An endless plane; everything on the side of its normal is free. Never on a dynamic body."""

    type: Literal["plane"]
    normal: Leaf[Vec3] = Field(default=(0.0, 0.0, 1.0), description="Direction of the free side, of any length.")
    offset: Leaf[Finite] = Field(default=0.0, description="Distance along the normal [m].")


class PlaneSeen(Model):
    """What is seen of a plane."""

    half_size: Leaf[Positive2] = Field(
        default=(10.0, 10.0), description="What is seen, along the plane's own y and z as SAPIEN has them [m]."
    )


class PlaneColliding(Model):
    """How often a plane is built."""

    every_scene: Fixed[bool] = Field(
        default=False, description="Where scenes share one GPU simulation: build it in each, not once."
    )


class PlaneShape(PlaneKeys, PlaneSeen, PlaneColliding, BothKeys):
    """A plane."""


class PlaneCollision(PlaneKeys, PlaneColliding, CollisionKeys):
    """A plane that only collides."""


class PlaneVisual(PlaneKeys, PlaneSeen, VisualKeys):
    """A plane that is only seen."""
