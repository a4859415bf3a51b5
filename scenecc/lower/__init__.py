"""From the models of the language to the plan: names resolved, poses composed, tables filled, draws made."""

from scenecc.lower.scene import Lowered, LoweringLimits, draw, lower
from scenecc.spec.references import NameScopes

__all__ = ["Lowered", "LoweringLimits", "NameScopes", "draw", "lower"]
