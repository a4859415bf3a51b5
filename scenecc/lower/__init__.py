"""From the models of the language to the plan: names resolved, poses composed, tables filled, draws made."""

from scenecc.lower.deferred_checks import draw
from scenecc.lower.limits import LoweringLimits
from scenecc.lower.names import NameScopes
from scenecc.lower.scene import Lowered, lower

__all__ = ["LoweringLimits", "Lowered", "NameScopes", "draw", "lower"]
