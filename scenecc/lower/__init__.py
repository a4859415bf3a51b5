"""From the models of the language to the plan: names resolved, poses composed, tables filled."""

from scenecc.lower.scene import Bounds, Lowered, lower

__all__ = ["Bounds", "Lowered", "lower"]
