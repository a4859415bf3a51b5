"""What can be told of expressions before anything is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.values.order import read_by

if TYPE_CHECKING:
    from scenecc.lower.leaves import Drawing
    from scenecc.values.nodes import Computed


def is_by_index(node: Computed, drawing: Drawing) -> bool:
    """Whether the scene's index alone decides what an expression gives, and no seed."""
    return drawing.random.isdisjoint(read_by(node))
