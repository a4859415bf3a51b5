"""What only its rows can be judged by, and what a reset draws anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.forms import Reading
    from scenecc.lower.kinds import Kind
    from scenecc.lower.leaves import Leaves
    from scenecc.plan import Value
    from scenecc.values.failure import DrawError
    from scenecc.values.nodes import Node


@dataclass(frozen=True, slots=True)
class Pending:
    """A value that only its rows can be judged by: an expression's, or a rotation that can fail to be one."""

    value: Value
    kind: Kind
    scenes: tuple[int, ...]
    origin: Origin
    origins: Mapping[int, tuple[Any, Origin]]


@dataclass(frozen=True, slots=True)
class Reset:
    """A velocity that may be drawn anew."""

    value: Value
    node: Node
    reading: Reading
    leaves: Leaves


def report_failure(error: DrawError, origins: Mapping[int, tuple[Any, Origin]], origin: Origin, sink: Sink) -> None:
    """Reports what has no value in some scene, at the node that has none."""
    place = origins.get(id(error.node), (None, origin))[1]
    message, expression = f"in scene {error.scene}: {error.message}", error.expression
    if expression is None:
        sink.report("SC515", message, place)
    else:
        sink.report("SC202", message, place, hint=expression.hint, span=(expression.start, expression.end))
