"""`scene_idxs` to scene indices, as the language has it."""

from scenecc.spec.selection import count, select

__all__ = ["count", "select"]
