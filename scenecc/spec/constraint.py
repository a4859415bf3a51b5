"""Constraints, by their types."""

from typing import Annotated, Any

from scenecc.spec.copies import Repeated
from scenecc.spec.later import ByType

CONSTRAINT_TYPES = ("weld", "connection", "distance", "gear", "drive")

Constraint = Annotated[Any, ByType("Constraint", CONSTRAINT_TYPES, "scenecc.spec.constraint_types"), Repeated]
"""What stands under `constraints`."""
