"""Planes with a repeated texture."""

from typing import Literal

from pydantic import Field

from scenecc.spec.leaf import Leaf
from scenecc.spec.scalars import Positive2
from scenecc.spec.shape_keys import VisualKeys


class TiledPlaneVisual(VisualKeys):
    """A flat quad facing +z with a repeated texture (ManiSkill's)."""

    type: Literal["tiled_plane"]
    half_size: Leaf[Positive2] = Field(description="Along x and y [m].")
    texture_repeat: Leaf[Positive2] = Field(description="How often the texture repeats along x and y.")
