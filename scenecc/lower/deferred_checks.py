"""Checks of values that vary: those that need no draw, and those that need the drawn rows."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show
from scenecc.plan.properties import FLOAT32_MAX, Bounds
from scenecc.variation.nodes import NODE_TYPES, AffineClamp, Computed, Drawn, Node, Rows, draws_read_by
from scenecc.variation.operations import (
    COMPUTE_LIMIT_HINT,
    LISTS,
    ComputeLimitError,
    DrawError,
    kind_name,
    shape_mismatch,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.field_types import FieldType
    from scenecc.lower.fields import FieldLowerer, SamplingContext, VariationLowerer
    from scenecc.plan import Value
    from scenecc.spec.params import ParamType
    from scenecc.variation.bounds import ExpressionBounds


@frozen
class DeferredCheck:
    """A check deferred until sampling: of an expression's value, or of a rotation that can fail to be one."""

    value: Value
    kind: FieldType
    scenes: tuple[int, ...]
    origin: Origin
    origins: Mapping[int, tuple[Any, Origin]]


@frozen
class MimicRelation:
    """What a joint follows: its position is multiplier · source + offset, both of which stay as they are built."""

    source: ResettableValue
    multiplier: Value
    offset: Value


@frozen
class ResettableValue:
    """A velocity, a position of a joint or a target that may be drawn anew.

    Attributes:
        limits: (·, 2) as built, to which the drawn value is clamped; None: no clamp.
        follows: the position that it is moved from; None: the node draws it.
    """

    value: Value
    node: Node
    variation: VariationLowerer
    fields: FieldLowerer
    limits: Value | None = None
    follows: MimicRelation | None = None


def report_draw_failure(
    error: DrawError, origins: Mapping[int, tuple[Any, Origin]], origin: Origin, sink: Sink
) -> None:
    """Reports what has no value in some scene, at the node that has none."""
    place = origins.get(id(error.node), (None, origin))[1]
    if isinstance(error, ComputeLimitError):
        sink.report("SC604", error.message, place, hint=COMPUTE_LIMIT_HINT)
        return
    message, expression = f"in scene {error.scene}: {error.message}", error.expression
    if expression is None:
        sink.report("SC515", message, place)
    else:
        sink.report("SC202", message, place, hint=expression.hint, span=(expression.start, expression.end))


_CHECKED_LATER = "each scene is checked when it is built"
_VALUE_TYPES = {
    "float64": (frozenset((int, float)), "a number"),
    "int64": (frozenset((int,)), "a whole number"),
    "bool": (frozenset((bool,)), "true or false"),
}
"""Of a field: the types of its values, and what these are called."""


@frozen
class PossibleFailure:
    """Why an expression may give a wrong value, or a draw none.

    Attributes:
        message: what is wrong, or would be.
        span: of the part of the scalar that has no value; None where it has one that is not wanted.
        certain: whether this is known to happen.
        drawn: whether it is about the bounds of a draw.
    """

    message: str
    span: tuple[int, int] | None
    certain: bool
    drawn: bool = False


def depends_on_scene_only(node: Node, sampling: SamplingContext) -> bool:
    """Whether the scene's index alone decides what an expression gives, and no seed."""
    return sampling.random.isdisjoint(draws_read_by(node))


def warn_may_fail(deferred: DeferredCheck, variation: VariationLowerer, fields: FieldLowerer) -> None:
    """Reports errors of a value with expressions that are certain, and those that are possible."""
    sampling = fields.sampling
    failures = [
        (failure, place)
        for node, place in variation.origins.values()
        if (failure := _possible_failure(node, deferred.kind, fields)) is not None
    ]
    unfit = _outside_bounds(deferred.value, deferred.kind) if variation.computed else None
    if not failures and unfit is None and sampling.may_fail.isdisjoint(variation.reads):
        return
    if not variation.drawn and sampling.random.isdisjoint(variation.reads):
        # Nothing of it is random, so that its rows can be looked at.
        check_rows(deferred, sampling, fields.sink)
        return
    _warn_scene_failures(variation, fields)
    for failure, place in failures:
        _report_possible_failure(failure, place, sampling)
    # A division by what may be zero gives numbers of any size: that is one thing to mend.
    is_certain = any(failure.certain for failure, _ in failures) or (
        failures and math.inf in deferred.value.bounds.numbers()
    )
    if unfit is not None and not is_certain:
        code, message = unfit
        hint = f"{_CHECKED_LATER}; `min` and `max` in the expression keep it in its range" if code == "SC514" else None
        fields.sink.report(code, message, deferred.origin, hint=hint)


def warn_draw_may_fail(name: str, variation: VariationLowerer, fields: FieldLowerer) -> None:
    """Reports why a shared draw may have no value, unless the scene alone decides: its readers report that."""
    sampling = fields.sampling
    if not sampling.may_fail.isdisjoint(variation.reads):
        sampling.may_fail.add(name)
        if name in sampling.random:
            _warn_scene_failures(variation, fields)
    for node, place in variation.origins.values():
        failure = _possible_failure(node, None, fields)
        if failure is not None:
            sampling.may_fail.add(name)
            if name in sampling.random:
                _report_possible_failure(failure, place, sampling)


def _warn_scene_failures(variation: VariationLowerer, fields: FieldLowerer) -> None:
    """Reports which draws that a value reads, and that their scene decides, have none in one of its scenes."""
    sampling = fields.sampling
    for name in sorted((variation.reads & sampling.may_fail) - sampling.random):
        error = _draw_error(name, fields)
        if error is not None and id(error.node) in sampling.draw_origins:
            span = None if error.expression is None else (error.expression.start, error.expression.end)
            failure = PossibleFailure(
                f"in scene {error.scene}: {error.message}", span, certain=False, drawn=span is None
            )
            _report_possible_failure(failure, sampling.draw_origins[id(error.node)][1], sampling)


def _draw_error(name: str, fields: FieldLowerer) -> DrawError | None:
    try:
        fields.batch().shared(name)
    except DrawError as error:
        return error
    return None


def _report_possible_failure(failure: PossibleFailure, place: Origin, sampling: SamplingContext) -> None:
    if failure.span is None and failure.certain:
        code, message = "SC515", failure.message
    elif failure.span is None and not failure.drawn:
        code, message = "SC514", f"in some scene {failure.message}"
    elif failure.certain:
        code, message = "SC202", f"this has no value, whatever is drawn: {failure.message}"
    else:
        code, message = "SC516", f"this may have no value: {failure.message}"
    advice = "`a if c else b` keeps what has no value from being evaluated"
    if failure.drawn:
        advice = "`min` and `max` keep a bound in its range"
    hint = f"{_CHECKED_LATER}; {advice}" if code == "SC516" else None
    sampling.sink.report(code, message, place, hint=hint, span=failure.span)


def _possible_failure(node: Node, kind: FieldType | None, fields: FieldLowerer) -> PossibleFailure | None:
    """Why a node may have no value: an expression, or what is drawn between bounds that vary."""
    key: tuple[Any, ...]
    if isinstance(node, Drawn):
        convert = dtype = None
        key = (node.kind, node.shape, *map(_identity, node.operands), id(fields.scenes))
    elif isinstance(node, Computed):
        convert = None if kind is None or node.shape is not None else kind.convert
        dtype = None if kind is None or kind.free or node.shape != () else kind.dtype
        key = (_identity(node), id(convert), dtype, id(fields.scenes))
    else:
        return None
    failures = fields.sampling.failures
    if key not in failures:
        found = (
            _draw_failure(node, fields)
            if isinstance(node, Drawn)
            else _expression_failure(node, convert, dtype, fields)
        )
        # Objects in the key by their id are kept alive with it.
        failures[key] = (node, fields.scenes, convert), found
    return failures[key][1]


def _identity(item: Any) -> Any:
    """What an item is known by: copies have the same expressions."""
    if isinstance(item, Computed):
        return id(item.template), item.shape, item.reads
    return id(item) if item.__class__ in NODE_TYPES else (item.__class__, item)


def _draw_failure(node: Drawn, fields: FieldLowerer) -> PossibleFailure | None:
    from scenecc.variation.draw_faults import find_draw_fault  # noqa: PLC0415 - loaded where bounds vary

    found = find_draw_fault(node, fields.sampling.reader(), fields.scenes)
    return None if found is None else PossibleFailure(found[0], None, found[1], drawn=True)


def _expression_failure(
    node: Computed, convert: Any, dtype: str | None, fields: FieldLowerer
) -> PossibleFailure | None:
    from scenecc.variation.bounds import bounds_of_values, example_values  # noqa: PLC0415 - likewise
    from scenecc.variation.node_bounds import bounds_and_faults, enumerate_outcomes  # noqa: PLC0415 - likewise

    reader = fields.sampling.reader()
    found, faults = bounds_and_faults(reader, node)
    try:
        rows = enumerate_outcomes(node, reader, scenes=fields.scenes)
    except DrawError as error:
        if error.node is not node:
            # A draw that it reads has none, which is reported there.
            return None
        if error.expression is None:
            return PossibleFailure(error.message, None, certain=True)
        certain = any(fault.certain for fault in faults)
        return PossibleFailure(error.message, (error.expression.start, error.expression.end), certain)
    if rows is not None:
        found = bounds_of_values(rows)
    elif faults:
        fault = next((fault for fault in faults if fault.certain), faults[0])
        return PossibleFailure(fault.message, (fault.start, fault.end), fault.certain)
    if not example_values(found) and (node.shape is not None or convert is not None):
        # A draw that may have no value is reported elsewhere.
        is_reported = not fields.sampling.may_fail.isdisjoint(draws_read_by(node))
        return None if is_reported else PossibleFailure("it may give a value of another kind", None, certain=False)
    return _misfit(found, node, convert, dtype)


def _misfit(found: ExpressionBounds, node: Computed, convert: Any, dtype: str | None) -> PossibleFailure | None:
    """Why the value of an expression does not fit its field."""
    from scenecc.variation.bounds import example_values  # noqa: PLC0415 - loaded where something varies

    some = example_values(found)
    shape, text = node.shape, node.template.text
    if shape is not None:
        wrong = [words for one in some if (words := shape_mismatch(one, shape, text) or _of_another_type(one, dtype))]
    elif convert is not None:
        wrong = [f"it gives {_described(one, found)}, which is not valid here" for one in some if convert(one) is None]
    else:
        return None
    return PossibleFailure(wrong[0], None, found.exact or len(wrong) == len(some)) if wrong else None


def _described(one: Any, found: ExpressionBounds) -> str:
    return kind_name(one) if found.values is None else show(one)


def _of_another_type(given: Any, dtype: str | None) -> str | None:
    """What is wrong with the type of one value."""
    types, words = _VALUE_TYPES.get(dtype or "", (None, ""))
    if types is None or type(given) in types:
        return None
    return f"this expression gives {cut(show(given))}, but {words} is needed"


def _outside_bounds(value: Value, kind: FieldType) -> tuple[str, str] | None:
    """The code and words of what is wrong, or may be, with the type or size of a value's numbers."""
    support = value.bounds
    if kind.within is None:
        return None
    bounds = kind.bounds
    outside = next((number for number in support.numbers() if not bounds.allow(number)), None)
    if outside is None:
        return None
    for low, high in zip(_flattened(support.low), _flattened(support.high), strict=True):
        end, words = (high, "at most") if high < bounds.low else (low, "at least")
        if high < bounds.low or low > bounds.high or low == high == outside:
            given = f"{end:g}" if low == high else f"{words} {end:g}"
            return "SC513", f"this expression gives {given}, but it must be {bounds.requirement(end)}"
    given = f"{outside:g}" if math.isfinite(outside) else "numbers of any size"
    return "SC514", f"this expression may give {given}, but it must be {bounds.requirement(outside)}"


def _flattened(item: Any) -> Iterator[Any]:
    if type(item) in LISTS:
        for one in item:
            yield from _flattened(one)
    elif item is not None:
        yield item


def check_rows(deferred: DeferredCheck, sampling: SamplingContext, sink: Sink) -> None:
    """Reports the first scene in which a value is none, or out of its range."""
    try:
        data = deferred.value.data
    except DrawError as error:
        report_draw_failure(error, {**sampling.draw_origins, **deferred.origins}, deferred.origin, sink)
        return
    bounds = deferred.kind.bounds
    row = _first_row_outside(data, bounds)
    if row is not None:
        scene = deferred.scenes[row]
        wrong = next(number for number in data[row].ravel().tolist() if not bounds.allow(number))
        each = "each number" if data[row].size > 1 else "it"
        message = f"in scene {scene} this is {_shown_row(data[row])}: {each} must be {bounds.requirement(wrong)}"
        sink.report("SC513", message, deferred.origin)


def _first_row_outside(data: NDArray[Any], bounds: Bounds) -> int | None:
    """The first row that is outside of its range."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    if data.dtype == np.bool_:
        return None
    inside = (data >= bounds.low) & (data <= bounds.high)
    if bounds.nonzero:
        inside &= data != 0
    rows = np.flatnonzero(~inside.reshape(len(data), -1).all(axis=1))
    return int(rows[0]) if rows.size else None


def _shown_row(row: Any) -> str:
    numbers = row.ravel().tolist()
    return f"{numbers[0]:g}" if len(numbers) == 1 else "[" + ", ".join(f"{number:g}" for number in numbers) + "]"


def reset_node(reset: ResettableValue, limit_items: Callable[[Value, tuple[int, ...]], Iterable[Any]]) -> Node:
    """What draws a value anew, held within its limits.

    Args:
        reset: the value.
        limit_items: gives the lower and the upper limit as items of a recipe, in some scenes.
    """
    node, scenes, follows = reset.node, reset.fields.scenes, reset.follows
    if follows is not None:
        factor, offset = (_constant_item(value.data, scenes) for value in (follows.multiplier, follows.offset))
        node = AffineClamp(reset_node(follows.source, limit_items), -1, -FLOAT32_MAX, FLOAT32_MAX, factor, offset)
    if reset.limits is not None and isinstance(node, AffineClamp):
        low, high = limit_items(reset.limits, scenes)
        node = replace(node, low=low, high=high)
    return node


def built_limit_items(limits: Value, scenes: tuple[int, ...]) -> Iterator[Any]:
    """Limits that stay as they are built, as items of a recipe."""
    return (_constant_item(side.clip(-FLOAT32_MAX, FLOAT32_MAX), scenes) for side in limits.data.T)


def drawn_limit_items(node: Node) -> Iterator[Any]:
    """Limits that a reset draws anew, by their recipe."""
    return (AffineClamp(node, index, -FLOAT32_MAX, FLOAT32_MAX) for index in range(2))


def _constant_item(rows: NDArray[Any], scenes: tuple[int, ...]) -> Any:
    """Numbers (1,) or (B,) that a reset does not change, as an item of a recipe."""
    return Rows(scenes, tuple(rows.tolist())) if len(rows) > 1 else rows.item()


@frozen
class VaryingArgument:
    """What a parameter is given that differs from scene to scene.

    Attributes:
        name: of its draw.
        param: type of the parameter.
        scenes: of the instance whose parameter it is; what it would be in others does not matter.
        origin: where it is given, in the expanded data.
    """

    name: str
    param: ParamType
    scenes: tuple[int, ...]
    origin: Origin
