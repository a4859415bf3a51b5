"""What can be told of expressions before anything is drawn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.words import cut, show
from scenecc.values.failure import DrawError
from scenecc.values.nodes import Computed
from scenecc.values.operations import LISTS, is_number, kind
from scenecc.values.order import read_by

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Origin
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.forms import Reading
    from scenecc.lower.kinds import Kind
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.pending import Pending
    from scenecc.plan import Value
    from scenecc.values.nodes import Node
    from scenecc.values.reach import Reach

_JUDGED_LATER = "each scene is judged as it is drawn"
_TYPES = {"float64": (frozenset((int, float)), "a number"), "bool": (frozenset((bool,)), "true or false")}
"""Of a field: the types of its values, and what these are called."""


@frozen
class Doubt:
    """Why an expression may not give what it stands for.

    Attributes:
        message: what is wrong, or would be.
        span: of the part of the scalar that has no value; None where it has one that is not wanted.
        certain: whether it can be told that this happens.
    """

    message: str
    span: tuple[int, int] | None
    certain: bool


def is_by_index(node: Node, drawing: Drawing) -> bool:
    """Whether the scene's index alone decides what an expression gives, and no seed."""
    return drawing.random.isdisjoint(read_by(node))


def foretell(pending: Pending, reading: Reading, leaves: Leaves) -> None:
    """Reports what is wrong with a value that holds expressions, and what may be, whatever is drawn."""
    drawing = leaves.drawing
    doubts = [
        (doubt, place)
        for node, place in reading.origins.values()
        if isinstance(node, Computed) and (doubt := _doubt(node, pending.kind, leaves)) is not None
    ]
    unfit = _unfit(pending.value, pending.kind)
    if not doubts and unfit is None and drawing.doubtful.isdisjoint(reading.reads):
        return
    if not reading.drawn and drawing.random.isdisjoint(reading.reads):
        from scenecc.lower.draw import judge  # noqa: PLC0415 - it reads this module

        # Nothing of it is random, so that its rows can be looked at.
        judge(pending, drawing, leaves.sink)
        return
    for doubt, place in doubts:
        _report(doubt, place, drawing)
    # A division by what may be zero gives numbers of any size: that is one thing to mend.
    told = any(doubt.certain for doubt, _ in doubts) or (doubts and math.inf in pending.value.support.numbers())
    if unfit is not None and not told:
        code, message = unfit
        hint = f"{_JUDGED_LATER}; `min` and `max` in the expression keep it in its range" if code == "SC514" else None
        leaves.sink.report(code, message, pending.origin, hint=hint)


def foretell_draw(name: str, reading: Reading, leaves: Leaves) -> None:
    """Reports why a shared draw may have no value, unless its scene alone decides: of that its readers tell."""
    drawing = leaves.drawing
    if not drawing.doubtful.isdisjoint(reading.reads):
        drawing.doubtful.add(name)
    for node, place in reading.origins.values():
        if not isinstance(node, Computed) or (doubt := _doubt(node, None, leaves)) is None:
            continue
        drawing.doubtful.add(name)
        if name in drawing.random:
            _report(doubt, place, drawing)


def _report(doubt: Doubt, place: Origin, drawing: Drawing) -> None:
    if doubt.span is None:
        code, message = ("SC515", doubt.message) if doubt.certain else ("SC514", f"in some scene {doubt.message}")
    elif doubt.certain:
        code, message = "SC202", f"this has no value, whatever is drawn: {doubt.message}"
    else:
        code, message = "SC516", f"this may have no value: {doubt.message}"
    hint = None if doubt.certain else f"{_JUDGED_LATER}; `a if c else b` keeps what has no value from being evaluated"
    drawing.sink.report(code, message, place, hint=hint if code == "SC516" else None, span=doubt.span)


def _doubt(node: Computed, wanted: Kind | None, leaves: Leaves) -> Doubt | None:
    convert = None if wanted is None or node.shape is not None else wanted.convert
    key = id(node.template), node.shape, node.reads, id(leaves.scenes), id(convert)
    doubts = leaves.drawing.doubts
    if key not in doubts:
        # All that is told by its id is kept with it.
        doubts[key] = (node.template, leaves.scenes, convert), _found(node, convert, leaves)
    return doubts[key][1]


def _found(node: Computed, convert: Any, leaves: Leaves) -> Doubt | None:
    from scenecc.values.enumerating import outcomes  # noqa: PLC0415 - loaded where something varies
    from scenecc.values.reach import known  # noqa: PLC0415 - likewise
    from scenecc.values.support_rules import reach_and_faults  # noqa: PLC0415 - likewise

    reader = leaves.drawing.reader()
    found, faults = reach_and_faults(reader, node)
    try:
        rows = outcomes(node, reader.draws, reader.given, reader.num_scenes, scenes=leaves.scenes)
    except DrawError as error:
        if error.node is not node:
            # A draw that it reads has none, which is told there.
            return None
        if error.expression is None:
            return Doubt(error.message, None, certain=True)
        certain = any(fault.certain for fault in faults)
        return Doubt(error.message, (error.expression.start, error.expression.end), certain)
    if rows is not None:
        found = known(rows)
    elif faults:
        fault = next((fault for fault in faults if fault.certain), faults[0])
        return Doubt(fault.message, (fault.start, fault.end), fault.certain)
    return _misfit(found, node.shape, convert)


def _misfit(found: Reach, shape: tuple[int, ...] | None, convert: Any) -> Doubt | None:
    """Why what an expression gives is not what is written where it stands."""
    examples = list(_examples(found))
    if shape is not None:
        wrong = [words for one in examples if (words := _unlike(one, shape)) is not None]
    elif convert is not None and found.values is not None:
        wrong = [f"it gives {show(one)}, which means nothing here" for one in examples if convert(one) is None]
    else:
        return None
    return Doubt(wrong[0], None, found.exact or len(wrong) == len(examples)) if wrong else None


def _unlike(given: Any, shape: tuple[int, ...]) -> str | None:
    """What is wrong with the shape of a value."""
    if not shape:
        return f"it gives {kind(given)} where one value is wanted" if type(given) in LISTS else None
    wanted = " lists of ".join(map(str, shape)) + " numbers"
    if type(given) not in LISTS:
        return f"it gives {kind(given)} where {wanted} are wanted"
    return None if _has_shape(given, shape) else f"it gives a list that is not {wanted}"


def _has_shape(given: Any, shape: tuple[int, ...]) -> bool:
    if not shape:
        return is_number(given)
    return type(given) in LISTS and len(given) == shape[0] and all(_has_shape(item, shape[1:]) for item in given)


def _examples(found: Reach) -> Iterator[Any]:
    """Values of every shape that something can have; none where that is not known."""
    if found.values is not None:
        yield from found.values
    elif found.low is not None:
        yield found.low
    elif found.items is not None:
        items = [next(_examples(item), None) for item in found.items]
        if None not in items:
            yield items


def _unfit(value: Value, wanted: Kind) -> tuple[str, str] | None:
    """The code and words of what is wrong, or may be, with the type or size of a value's numbers."""
    support = value.support
    if support.alternatives is not None and wanted.dtype in _TYPES:
        types, words = _TYPES[wanted.dtype]
        wrong = [one for one in support.alternatives if not types.issuperset(map(type, _flat(one)))]
        if wrong and len(wrong) == len(support.alternatives):
            return "SC515", f"this expression gives {cut(show(wrong[0]))}, and {words} is wanted"
    if not (wanted.quantity or wanted.within):
        return None
    bounds = wanted.bounds()
    outside = next((number for number in support.numbers() if not bounds.allow(number)), None)
    if outside is None:
        return None
    for low, high in zip(_flat(support.low), _flat(support.high), strict=True):
        end, words = (high, "at most") if high < bounds.low else (low, "at least")
        if high < bounds.low or low > bounds.high or low == high == outside:
            given = f"{end:g}" if low == high else f"{words} {end:g}"
            return "SC513", f"this expression gives {given}, and it must be {bounds.wanted(end)}"
    given = f"{outside:g}" if math.isfinite(outside) else "numbers of any size"
    return "SC514", f"this expression may give {given}, and it must be {bounds.wanted(outside)}"


def _flat(item: Any) -> Iterator[Any]:
    if type(item) in LISTS:
        for one in item:
            yield from _flat(one)
    elif item is not None:
        yield item
