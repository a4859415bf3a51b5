"""What can be told of expressions, and of bounds that vary, before anything is drawn."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show
from scenecc.variation.errors import DrawError
from scenecc.variation.nodes import NODE_TYPES, Computed, Drawn, draws_read_by
from scenecc.variation.operations import LISTS, kind_name, shape_mismatch

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.diagnostics import Origin
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.forms import Reading
    from scenecc.lower.kinds import Kind
    from scenecc.lower.leaves import Leaves
    from scenecc.lower.pending import Pending
    from scenecc.plan import Value
    from scenecc.variation.bounds import ExpressionBounds
    from scenecc.variation.nodes import Node

_JUDGED_LATER = "each scene is judged as it is drawn"
_TYPES = {
    "float64": (frozenset((int, float)), "a number"),
    "int64": (frozenset((int,)), "a whole number"),
    "bool": (frozenset((bool,)), "true or false"),
}
"""Of a field: the types of its values, and what these are called."""


@frozen
class Doubt:
    """Why an expression may not give what it stands for, or a draw nothing.

    Attributes:
        message: what is wrong, or would be.
        span: of the part of the scalar that has no value; None where it has one that is not wanted.
        certain: whether it can be told that this happens.
        drawn: whether it is about the bounds of a draw.
    """

    message: str
    span: tuple[int, int] | None
    certain: bool
    drawn: bool = False


def is_by_index(node: Node, drawing: Drawing) -> bool:
    """Whether the scene's index alone decides what an expression gives, and no seed."""
    return drawing.random.isdisjoint(draws_read_by(node))


def foretell(pending: Pending, reading: Reading, leaves: Leaves) -> None:
    """Reports what is wrong with a value that holds expressions, and what may be, whatever is drawn."""
    drawing = leaves.drawing
    doubts = [
        (doubt, place)
        for node, place in reading.origins.values()
        if (doubt := _doubt(node, pending.kind, leaves)) is not None
    ]
    unfit = _unfit(pending.value, pending.kind) if reading.computed else None
    if not doubts and unfit is None and drawing.doubtful.isdisjoint(reading.reads):
        return
    if not reading.drawn and drawing.random.isdisjoint(reading.reads):
        from scenecc.lower.draw import judge  # noqa: PLC0415 - it reads this module

        # Nothing of it is random, so that its rows can be looked at.
        judge(pending, drawing, leaves.sink)
        return
    _foretell_by_scene(reading, leaves)
    for doubt, place in doubts:
        _report(doubt, place, drawing)
    # A division by what may be zero gives numbers of any size: that is one thing to mend.
    told = any(doubt.certain for doubt, _ in doubts) or (doubts and math.inf in pending.value.bounds.numbers())
    if unfit is not None and not told:
        code, message = unfit
        hint = f"{_JUDGED_LATER}; `min` and `max` in the expression keep it in its range" if code == "SC514" else None
        leaves.sink.report(code, message, pending.origin, hint=hint)


def foretell_draw(name: str, reading: Reading, leaves: Leaves) -> None:
    """Reports why a shared draw may have no value, unless its scene alone decides: of that its readers tell."""
    drawing = leaves.drawing
    if not drawing.doubtful.isdisjoint(reading.reads):
        drawing.doubtful.add(name)
        if name in drawing.random:
            _foretell_by_scene(reading, leaves)
    for node, place in reading.origins.values():
        doubt = _doubt(node, None, leaves)
        if doubt is not None:
            drawing.doubtful.add(name)
            if name in drawing.random:
                _report(doubt, place, drawing)


def _foretell_by_scene(reading: Reading, leaves: Leaves) -> None:
    """Reports which draws that a value reads, and that their scene decides, have none in one of its scenes."""
    drawing = leaves.drawing
    for name in sorted((reading.reads & drawing.doubtful) - drawing.random):
        error = _failure(name, leaves)
        if error is not None and id(error.node) in drawing.draw_origins:
            span = None if error.expression is None else (error.expression.start, error.expression.end)
            doubt = Doubt(f"in scene {error.scene}: {error.message}", span, certain=False, drawn=span is None)
            _report(doubt, drawing.draw_origins[id(error.node)][1], drawing)


def _failure(name: str, leaves: Leaves) -> DrawError | None:
    try:
        leaves.batch().shared(name)
    except DrawError as error:
        return error
    return None


def _report(doubt: Doubt, place: Origin, drawing: Drawing) -> None:
    if doubt.span is None and doubt.certain:
        code, message = "SC515", doubt.message
    elif doubt.span is None and not doubt.drawn:
        code, message = "SC514", f"in some scene {doubt.message}"
    elif doubt.certain:
        code, message = "SC202", f"this has no value, whatever is drawn: {doubt.message}"
    else:
        code, message = "SC516", f"this may have no value: {doubt.message}"
    advice = "`a if c else b` keeps what has no value from being evaluated"
    if doubt.drawn:
        advice = "`min` and `max` keep a bound in its range"
    hint = f"{_JUDGED_LATER}; {advice}" if code == "SC516" else None
    drawing.sink.report(code, message, place, hint=hint, span=doubt.span)


def _doubt(node: Node, wanted: Kind | None, leaves: Leaves) -> Doubt | None:
    """Why a node may have no value: an expression, or what is drawn between bounds that vary."""
    key: tuple[Any, ...]
    if isinstance(node, Drawn):
        key, convert, dtype = tuple(map(_identity, (node.low, node.high, *(node.clip or ())))), None, None
        key = (node.kind, node.shape, *key, id(leaves.scenes))
    elif isinstance(node, Computed):
        convert = None if wanted is None or node.shape is not None else wanted.convert
        dtype = None if wanted is None or wanted.free or node.shape != () else wanted.dtype
        key = (_identity(node), id(convert), dtype, id(leaves.scenes))
    else:
        return None
    doubts = leaves.drawing.doubts
    if key not in doubts:
        found = _drawn_doubt(node, leaves) if isinstance(node, Drawn) else _found(node, convert, dtype, leaves)
        # All that is told by its id is kept with it.
        doubts[key] = (node, leaves.scenes, convert), found
    return doubts[key][1]


def _identity(item: Any) -> Any:
    """What an item is known by: copies have the same expressions."""
    if isinstance(item, Computed):
        return id(item.template), item.shape, item.reads
    return id(item) if item.__class__ in NODE_TYPES else (item.__class__, item)


def _drawn_doubt(node: Drawn, leaves: Leaves) -> Doubt | None:
    from scenecc.variation.draw_faults import find_draw_fault  # noqa: PLC0415 - loaded where bounds vary

    found = find_draw_fault(node, leaves.drawing.reader(), leaves.scenes)
    return None if found is None else Doubt(found[0], None, found[1], drawn=True)


def _found(node: Computed, convert: Any, dtype: str | None, leaves: Leaves) -> Doubt | None:
    from scenecc.variation.bounds import bounds_of_values, example_values  # noqa: PLC0415 - likewise
    from scenecc.variation.enumeration import enumerate_outcomes  # noqa: PLC0415 - loaded where something varies
    from scenecc.variation.node_bounds import bounds_and_faults  # noqa: PLC0415 - likewise

    reader = leaves.drawing.reader()
    found, faults = bounds_and_faults(reader, node)
    try:
        rows = enumerate_outcomes(node, reader.draws, reader.given, reader.num_scenes, scenes=leaves.scenes)
    except DrawError as error:
        if error.node is not node:
            # A draw that it reads has none, which is told there.
            return None
        if error.expression is None:
            return Doubt(error.message, None, certain=True)
        certain = any(fault.certain for fault in faults)
        return Doubt(error.message, (error.expression.start, error.expression.end), certain)
    if rows is not None:
        found = bounds_of_values(rows)
    elif faults:
        fault = next((fault for fault in faults if fault.certain), faults[0])
        return Doubt(fault.message, (fault.start, fault.end), fault.certain)
    if not example_values(found) and (node.shape is not None or convert is not None):
        # Of a draw that may have no value nothing more is said.
        is_told = not leaves.drawing.doubtful.isdisjoint(draws_read_by(node))
        return None if is_told else Doubt("it may give a value of another kind", None, certain=False)
    return _misfit(found, node, convert, dtype)


def _misfit(found: ExpressionBounds, node: Computed, convert: Any, dtype: str | None) -> Doubt | None:
    """Why what an expression gives is not what is written where it stands."""
    from scenecc.variation.bounds import example_values  # noqa: PLC0415 - loaded where something varies

    some = example_values(found)
    shape, text = node.shape, node.template.text
    if shape is not None:
        wrong = [words for one in some if (words := shape_mismatch(one, shape, text) or _of_another_type(one, dtype))]
    elif convert is not None:
        wrong = [f"it gives {_told(one, found)}, which means nothing here" for one in some if convert(one) is None]
    else:
        return None
    return Doubt(wrong[0], None, found.exact or len(wrong) == len(some)) if wrong else None


def _told(one: Any, found: ExpressionBounds) -> str:
    return kind_name(one) if found.values is None else show(one)


def _of_another_type(given: Any, dtype: str | None) -> str | None:
    """What is wrong with the type of one value."""
    types, words = _TYPES.get(dtype or "", (None, ""))
    if types is None or type(given) in types:
        return None
    return f"this expression gives {cut(show(given))}, and {words} is wanted"


def _unfit(value: Value, wanted: Kind) -> tuple[str, str] | None:
    """The code and words of what is wrong, or may be, with the type or size of a value's numbers."""
    support = value.bounds
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
