"""Lights, by their types."""

from typing import Annotated, Any

from scenecc.spec.copies import Repeated
from scenecc.spec.later import ByType

LIGHT_TYPES = ("directional", "point", "spot", "area", "textured")

Light = Annotated[Any, ByType("Light", LIGHT_TYPES, "scenecc.spec.light_types"), Repeated]
"""What stands under `lights`."""
