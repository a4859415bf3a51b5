"""What only its rows can be judged by, and what a reset draws anew."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.compute_limit import COMPUTE_LIMIT_HINT, ComputeLimitError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.forms import Reading
    from scenecc.lower.kinds import Kind
    from scenecc.lower.leaves import Leaves
    from scenecc.plan import Value
    from scenecc.variation.errors import DrawError
    from scenecc.variation.nodes import Node


@frozen
class Pending:
    """A value that only its rows can be judged by: an expression's, or a rotation that can fail to be one."""

    value: Value
    kind: Kind
    scenes: tuple[int, ...]
    origin: Origin
    origins: Mapping[int, tuple[Any, Origin]]


@frozen
class Follows:
    """What a joint follows: its position is multiplier · source + offset, both of which stay as they are built."""

    source: Reset
    multiplier: Value
    offset: Value


@frozen
class Reset:
    """A velocity, a position of a joint or a target that may be drawn anew.

    Attributes:
        limits: (·, 2) that stay as they are built, and that what is drawn is held within; None: the node says all.
        follows: the position that it is moved from; None: the node draws it.
    """

    value: Value
    node: Node
    reading: Reading
    leaves: Leaves
    limits: Value | None = None
    follows: Follows | None = None


def report_failure(error: DrawError, origins: Mapping[int, tuple[Any, Origin]], origin: Origin, sink: Sink) -> None:
    """Reports what has no value in some scene, at the node that has none."""
    place = origins.get(id(error.node), (None, origin))[1]
    if isinstance(error, ComputeLimitError):
        sink.report("SC609", error.message, place, hint=COMPUTE_LIMIT_HINT)
        return
    message, expression = f"in scene {error.scene}: {error.message}", error.expression
    if expression is None:
        sink.report("SC515", message, place)
    else:
        sink.report("SC202", message, place, hint=expression.hint, span=(expression.start, expression.end))
