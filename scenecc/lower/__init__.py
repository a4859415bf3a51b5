"""Lowers the models of the language to the plan: resolves names, composes poses, fills tables, and draws values."""

from scenecc.lower.scene import Lowered, complete, lower

__all__ = ["Lowered", "complete", "lower"]
