"""Cylinders."""

from typing import Literal

from pydantic import Field

from scenecc.spec.base import Model
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.pose import AxisName
from scenecc.spec.scalars import Positive
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, VisualKeys


class CylinderKeys(Model):
    """A cylinder. What collides is a convex mesh."""

    type: Literal["cylinder"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class CylinderShape(CylinderKeys, BothKeys):
    """A cylinder."""


class CylinderCollision(CylinderKeys, CollisionKeys):
    """A cylinder that only collides."""


class CylinderVisual(CylinderKeys, VisualKeys):
    """A cylinder that is only seen."""
