"""Checks of varying values: their samples before drawing, their rows afterwards."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan.properties import FLOAT32_MAX, Bounds
from scenecc.variation.nodes import AffineClamp, Computed, Node, Placed, Rows, placements_read_by
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, ComputeLimitError, DrawError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.field_types import FieldType
    from scenecc.lower.fields import FieldLowerer, RowMaker, SamplingContext, VariationLowerer
    from scenecc.plan import Value
    from scenecc.spec.params import ParamType
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.samples import SampleBatch

    Origins = Mapping[int, tuple[Any, Origin]]
    """Origins of nodes that may have no value, by identity, each with its node."""


@frozen
class DeferredCheck:
    """The check of a value that may be missing or out of range.

    Attributes:
        node: gives the value.
        rows: computes its rows in a batch.
        scenes: scenes of its rows.
        origin: of the field.
        origins: of its nodes.
    """

    value: Value
    node: Node
    rows: RowMaker
    kind: FieldType
    scenes: tuple[int, ...]
    origin: Origin
    origins: Origins


@frozen
class MimicRelation:
    """The joint that a joint follows: its position is multiplier · source + offset. Both are fixed after the build."""

    source: ResettableValue
    multiplier: Value
    offset: Value


@frozen
class ResettableValue:
    """A velocity, a position of a joint or a target that may be redrawn.

    Attributes:
        limits: (·, 2) as built, to which the drawn value is clamped; None: no clamp.
        follows: the position that it is computed from; None: the node draws it.
    """

    value: Value
    node: Node
    variation: VariationLowerer
    fields: FieldLowerer
    limits: Value | None = None
    follows: MimicRelation | None = None


def report_draw_failure(error: DrawError, origins: Origins, origin: Origin, sink: Sink) -> None:
    """Reports a node without a value in one of the scenes."""
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

_MOST_CERTAIN = 100
"""Nodes without a value for which it is found out whether they have none in any sample."""


def check_samples(deferred: DeferredCheck, fields: FieldLowerer) -> None:
    """Reports a value that is missing or out of range: an error if it is in all samples, otherwise a warning."""
    try:
        rows = deferred.value.samples
    except DrawError as error:
        for one in _sample_errors(error, deferred, fields):
            report_sample_failure(
                one, _rows_wherever_placed(deferred, fields), deferred.origins, deferred.origin, fields
            )
        return
    bounds = deferred.kind.bounds
    outside = _rows_outside(rows, bounds)
    if outside:
        row = rows[outside[0]]
        wrong = bounds.requirement(_number_outside(row, bounds))
        from scenecc.variation.samples import same_scene, sample_of  # noqa: PLC0415 - loads numpy

        deferred.value.drop_samples()
        if len(outside) == len(rows):
            message = f"this expression gives {_span(rows)}, but it must be {wrong}"
            fields.sink.report("SC513", message, deferred.origin)
            return
        scene, seed = sample_of(outside[0], deferred.scenes)
        same = same_scene(outside[0], len(deferred.scenes))
        if set(same) <= set(outside):
            message = f"in scene {scene} this is {_span(rows[same])}: {_subject(row)} must be {wrong}"
            fields.sink.report("SC513", message, deferred.origin)
            return
        message = f"in scene {scene} with seed {seed} this is {_shown_row(row)}: {_subject(row)} must be {wrong}"
        hint = f"{_CHECKED_LATER}; `min` and `max` in the expression keep it in its range"
        fields.sink.report("SC514", message, deferred.origin, hint=hint)


def _sample_errors(error: DrawError, deferred: DeferredCheck, fields: FieldLowerer) -> Iterable[DrawError]:
    """The errors of all nodes of a value that is missing in a sample."""
    if isinstance(error, ComputeLimitError):
        return (error,)
    # A placement has no pose yet, but the expressions beside it have values.
    found = {} if isinstance(error.node, Placed) else {id(error.node): error}
    from scenecc.variation.samples import nodes_read  # noqa: PLC0415 - loads numpy

    for node, batch in nodes_read(deferred.node, fields.analysis.samples):
        one = _batch_error(node, batch) if id(node) in deferred.origins else None
        if one is not None and not isinstance(one.node, Placed):
            found.setdefault(id(one.node), one)
    return found.values()


def _batch_error(node: Node, batch: Batch) -> DrawError | None:
    try:
        batch.evaluate(node)
    except DrawError as error:
        return error
    return None


def _rows_wherever_placed(deferred: DeferredCheck, fields: FieldLowerer) -> RowMaker:
    """What gives the rows of a value before anything is placed: whether they exist does not depend on where it is."""
    placements = placements_read_by(deferred.node)
    if not placements:
        return deferred.rows
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    placed = dict.fromkeys(placements, np.tile(IDENTITY_POSE, (fields.sampling.num_scenes, 1)))

    def rows(batch: Batch) -> NDArray[Any]:
        batch.placed = placed
        return deferred.rows(batch)

    return rows


def report_sample_failure(
    error: DrawError, rows: RowMaker, origins: Origins, origin: Origin, fields: FieldLowerer
) -> None:
    """Reports each node without a value in a sample once: as an error if it has none in any sample.

    Args:
        error: of the first sample.
        rows: computes the rows of the value with the node.
        origins: of its nodes.
        origin: of the value.
        fields: of the object.
    """
    sampling = fields.sampling
    places = {**sampling.draw_origins, **origins}
    if isinstance(error, ComputeLimitError):
        report_draw_failure(error, places, origin, fields.sink)
        return
    node, place = places.get(id(error.node), (error.node, origin))
    if id(node) in sampling.failed:
        return
    sampling.failed[id(node)] = node
    # It takes milliseconds to find out, and a few errors are enough to refuse a file.
    certain = len(sampling.failed) <= _MOST_CERTAIN and not _may_have_value(rows, fields.analysis.samples, error.scene)
    where = f"in scene {error.scene} with seed {error.seed}"
    expression = error.expression
    span = None if expression is None else (expression.start, expression.end)
    if certain and span is None:
        fields.sink.report("SC515", f"in scene {error.scene}: {error.message}", place)
    elif certain:
        message = f"in scene {error.scene} this has no value, whatever is drawn: {error.message}"
        fields.sink.report("SC202", message, place, span=span)
    elif span is None and isinstance(error.node, Computed):
        fields.sink.report("SC514", f"{where} {error.message}", place, hint=_CHECKED_LATER)
    else:
        advice = "`min` and `max` keep a bound in its range"
        if span is not None:
            advice = "`a if c else b` keeps what has no value from being evaluated"
        message = f"{where} this has no value: {error.message}"
        fields.sink.report("SC516", message, place, hint=f"{_CHECKED_LATER}; {advice}", span=span)


def _may_have_value(rows: RowMaker, samples: SampleBatch, scene: int) -> bool:
    """Whether a value that is missing in a sample of a scene exists in another sample."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    for row in samples.same_scene(scene):
        with suppress(DrawError):
            rows(samples.only(np.array([row])))
            return True
    return False


def check_rows(deferred: DeferredCheck, sampling: SamplingContext, sink: Sink) -> None:
    """Reports the first scene in which a value is missing or out of range."""
    try:
        data = deferred.value.data
    except DrawError as error:
        report_draw_failure(error, {**sampling.draw_origins, **deferred.origins}, deferred.origin, sink)
        return
    bounds = deferred.kind.bounds
    outside = _rows_outside(data, bounds)
    if outside:
        scene, row = deferred.scenes[outside[0]], data[outside[0]]
        wrong = bounds.requirement(_number_outside(row, bounds))
        message = f"in scene {scene} this is {_shown_row(row)}: {_subject(row)} must be {wrong}"
        sink.report("SC513", message, deferred.origin)


def _rows_outside(data: NDArray[Any], bounds: Bounds) -> list[int]:
    """The rows that are out of range."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    if data.dtype == np.bool_:
        return []
    inside = (data >= bounds.low) & (data <= bounds.high)
    if bounds.nonzero:
        inside &= data != 0
    return np.flatnonzero(~inside.reshape(len(data), -1).all(axis=1)).tolist()


def _number_outside(row: Any, bounds: Bounds) -> float:
    return next(number for number in row.ravel().tolist() if not bounds.allow(number))


def _subject(row: Any) -> str:
    return "each number" if row.size > 1 else "it"


def _shown_row(row: Any) -> str:
    numbers = row.ravel().tolist()
    return f"{numbers[0]:g}" if len(numbers) == 1 else "[" + ", ".join(f"{number:g}" for number in numbers) + "]"


def _span(rows: NDArray[Any]) -> str:
    """Formats the range of all samples."""
    low, high = _shown_row(rows.min(axis=0)), _shown_row(rows.max(axis=0))
    return low if low == high else f"about {low} to {high}"


def reset_node(reset: ResettableValue, limit_items: Callable[[Value, tuple[int, ...]], Iterable[Any]]) -> Node:
    """The recipe of a value, clamped to its limits.

    Args:
        reset: the value.
        limit_items: gives the lower and the upper limit in some scenes as items of a recipe.
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
    """Limits that are fixed after the build, as items of a recipe."""
    return (_constant_item(side.clip(-FLOAT32_MAX, FLOAT32_MAX), scenes) for side in limits.data.T)


def drawn_limit_items(node: Node) -> Iterator[Any]:
    """Limits that a reset redraws, as items of a recipe."""
    return (AffineClamp(node, index, -FLOAT32_MAX, FLOAT32_MAX) for index in range(2))


def _constant_item(rows: NDArray[Any], scenes: tuple[int, ...]) -> Any:
    """Numbers (1,) or (B,) that a reset does not change, as an item of a recipe."""
    return Rows(scenes, tuple(rows.tolist())) if len(rows) > 1 else rows.item()


@frozen
class VaryingArgument:
    """An argument of a parameter that varies by scene.

    Attributes:
        name: of its draw.
        param: type of the parameter.
        scenes: of the instance with the parameter; values in other scenes are not checked.
        origin: of the argument, in the expanded data.
    """

    name: str
    param: ParamType
    scenes: tuple[int, ...]
    origin: Origin
