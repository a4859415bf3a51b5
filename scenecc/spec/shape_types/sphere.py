"""Spheres."""

from typing import Literal

from pydantic import Field

from scenecc.spec.base import Model
from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import Positive
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, VisualKeys


class SphereKeys(Model):
    """A sphere."""

    type: Literal["sphere"]
    radius: Leaf[Positive] = Field(description="Radius [m].")


class SphereShape(SphereKeys, BothKeys):
    """A sphere."""


class SphereCollision(SphereKeys, CollisionKeys):
    """A sphere that only collides."""


class SphereVisual(SphereKeys, VisualKeys):
    """A sphere that is only seen."""
