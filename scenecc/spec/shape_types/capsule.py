"""Capsules."""

from typing import Literal

from pydantic import Field

from scenecc.spec.base import Model
from scenecc.spec.leaf import Fixed, Leaf
from scenecc.spec.pose import AxisName
from scenecc.spec.scalars import Positive
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, VisualKeys


class CapsuleKeys(Model):
    """A cylinder with a half sphere at both ends."""

    type: Literal["capsule"]
    radius: Leaf[Positive] = Field(description="Radius [m].")
    half_length: Leaf[Positive] = Field(description="Half of the length between the centres of the caps [m].")
    axis: Fixed[AxisName] = Field(default="x", description="The axis it lies along.")


class CapsuleShape(CapsuleKeys, BothKeys):
    """A capsule."""


class CapsuleCollision(CapsuleKeys, CollisionKeys):
    """A capsule that only collides."""


class CapsuleVisual(CapsuleKeys, VisualKeys):
    """A capsule that is only seen."""
