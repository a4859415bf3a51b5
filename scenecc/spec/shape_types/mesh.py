"""Meshes that are only seen."""

from typing import Literal

from pydantic import Field

from scenecc.spec.shape_keys import FileKeys, MirrorScale, VisualKeys


class MeshVisual(FileKeys, VisualKeys):
    """What a file shows, with its own materials unless one is given."""

    type: Literal["mesh"]
    scale: MirrorScale = Field(default=1.0, description="One factor or [x, y, z]; negative mirrors.")
