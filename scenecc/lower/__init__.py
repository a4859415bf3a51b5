"""From the models of the language to the plan: names resolved, poses composed, tables filled, draws made."""

from scenecc.lower.scene import Lowered, draw, lower

__all__ = ["Lowered", "draw", "lower"]
