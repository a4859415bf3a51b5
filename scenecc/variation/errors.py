"""What goes wrong in an expression, where, and in which scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scenecc.variation.nodes import Node


class ExpressionError(Exception):
    """An expression that cannot be read, or has no value.

    Attributes:
        message: what is wrong, as a diagnostic says it.
        start, end: of the part of the scalar's text that is meant (characters, end exclusive).
        hint: what to do about it; None where nothing is known.
    """

    def __init__(self, message: str, start: int, end: int, hint: str | None = None) -> None:
        super().__init__(message)
        self.message = message
        self.start = start
        self.end = end
        self.hint = hint


class DrawError(Exception):
    """A node that has no value in one scene.

    Attributes:
        message: what is wrong, as a diagnostic says it.
        scene: the scene's index.
        node: the node that has no value; it may stand inside the one that was asked for.
        expression: what went wrong, where the node is an expression.
    """

    def __init__(self, message: str, scene: int, node: Node, expression: ExpressionError | None = None) -> None:
        super().__init__(f"scene {scene}: {message}")
        self.message = message
        self.scene = scene
        self.node = node
        self.expression = expression
