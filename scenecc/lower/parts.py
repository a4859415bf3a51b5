"""Fields that are written in several ways (a colour as text or as numbers), where an expression gives the whole."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import show
from scenecc.lower.forms import Place, Reading, Step
from scenecc.plan import Value, literal, varying
from scenecc.variation.bounds import UNKNOWN, ValueBounds
from scenecc.variation.errors import DrawError
from scenecc.variation.nodes import NODES, Const
from scenecc.variation.template import Template

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.lower.kinds import Kind
    from scenecc.lower.leaves import Leaves


def from_parts(given: Any, kind: Kind, place: Place, leaves: Leaves) -> Value:
    """A leaf in which an expression stands for a whole value, converted scene by scene.

    Args:
        given: as the models have it.
        kind: of the field; it converts.
        place: of the leaf.
        leaves: of its object.
    """
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.variation.bounds import union_bounds  # noqa: PLC0415 - likewise

    assert kind.convert is not None
    convert = kind.convert
    reading = Reading(leaves, place.origin)
    parts: list[Any] = []

    def leaf(one: Any, around: Place, step: Step) -> int:
        """Keeps one alternative as a part; its number stands in its place among those that are picked from."""
        inside = around.inside(step) if step else around
        item = reading.item(one, kind, inside)
        parts.append((item if item.__class__ in NODES else Const(item), isinstance(one, Template)))
        return len(parts) - 1

    index = reading.select(given, place, leaf)
    leaves.fix(reading)
    if reading.broken:
        return literal(kind.fallback, kind.dtype)
    which = index if index.__class__ in NODES else Const(index)

    def row(made: Any, node: Any, scene: int) -> Any:
        """What an expression gave in a scene, converted."""
        found = convert(made)
        if found is None:
            raise DrawError(f"it gives {show(made)}, which means nothing here", scene, node)
        return found

    def draw() -> NDArray[Any]:
        """The rows: each part is evaluated in the scenes that have it."""
        numbers = leaves.evaluate(which)
        rows = np.empty((len(leaves.scenes), *kind.shape), dtype=kind.dtype)
        for number, (node, written) in enumerate(parts):
            mine = np.flatnonzero(numbers == number)
            if mine.size:
                made = leaves.batch().only(mine).evaluate(node).tolist()
                scenes = [leaves.scenes[i] for i in mine]
                rows[mine] = [row(one, node, s) for one, s in zip(made, scenes, strict=True)] if written else made
        return rows

    supports = [_converted(leaves.bounds(node), kind) if written else leaves.bounds(node) for node, written in parts]
    value = varying(draw, bounds=replace(union_bounds(supports), exact=False), rows=len(leaves.scenes))
    leaves.pend(value, kind, place.origin, reading)
    return value


def _converted(support: ValueBounds, kind: Kind) -> ValueBounds:
    """What a field can be whose expression can give so much."""
    assert kind.convert is not None
    ends = () if support.low is None else (support.low, support.high)
    made = [kind.convert(item) for item in (ends if support.alternatives is None else support.alternatives)]
    if not made or None in made:
        return UNKNOWN
    if support.alternatives is not None:
        return ValueBounds.of(made, exact=support.exact)
    return ValueBounds(None, *made, exact=support.exact)
