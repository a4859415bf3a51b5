"""From the models of the language to the plan: names resolved, poses composed, tables filled, draws made."""

from scenecc.lower.bounds import Bounds
from scenecc.lower.draw import draw
from scenecc.lower.names import Names
from scenecc.lower.scene import Lowered, lower

__all__ = ["Bounds", "Lowered", "Names", "draw", "lower"]
