"""Boxes."""

from typing import Literal

from pydantic import Field

from scenecc.spec.base import Model
from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import Positive3
from scenecc.spec.shape_keys import BothKeys, CollisionKeys, VisualKeys


class BoxKeys(Model):
    """A box."""

    type: Literal["box"]
    half_size: Leaf[Positive3] = Field(description="Half of the edges along x, y, z [m].")


class BoxShape(BoxKeys, BothKeys):
    """A box."""


class BoxCollision(BoxKeys, CollisionKeys):
    """A box that only collides."""


class BoxVisual(BoxKeys, VisualKeys):
    """A box that is only seen."""
