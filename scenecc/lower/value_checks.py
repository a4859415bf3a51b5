"""Checks of varying values: of the rows of this seed, and of the samples of other seeds."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.chosen import DrawFailure
from scenecc.variation.nodes import Computed, Drawn, Node, Placed
from scenecc.variation.operations import ComputeLimitError, DrawError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.field_types import FieldType
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan import Value
    from scenecc.plan.properties import Bounds
    from scenecc.variation.evaluation import Batch


@frozen
class ValueCheck:
    """The check of a value that may be missing or out of range.

    Attributes:
        value: to check.
        node: gives it.
        kind: of the field.
        scenes: scenes of its rows.
        origin: of the field.
    """

    value: Value
    node: Node
    kind: FieldType
    scenes: tuple[int, ...]
    origin: Origin


def report_draw_failure(error: DrawError, origin: Origin, sampling: SamplingContext) -> None:
    """Reports a node without a value in one of the scenes, for the first of the fields that read it.

    Args:
        error: of the first scene.
        origin: of the field, for a node without an origin of its own.
        sampling: of the document.
    """
    place, expression, sink = _place_of(error, origin), error.expression, sampling.sink
    if sampling.record is not None:
        sampling.record.failures.append(DrawFailure((error.scene,), error.node))  # pyright: ignore[reportArgumentType] - a node
    if place in sampling.failed:
        return
    sampling.failed.add(place)
    message = f"in scene {error.scene}: {error.message}"
    if isinstance(error, ComputeLimitError):
        sampling.report_limit(error.message, place)
    elif expression is None:
        sink.report("SC515", message, place)
    else:
        sink.report("SC202", message, place, hint=expression.hint, span=(expression.start, expression.end))


def _place_of(error: DrawError, origin: Origin) -> Origin:
    return getattr(error.node, "origin", None) or origin


def check_rows(check: ValueCheck, sampling: SamplingContext) -> bool:
    """Whether a value exists and is in range in every scene; otherwise reports the first scene in which it is not.

    A value that depends on a placement is checked once everything is placed.
    """
    try:
        data = check.value.data
    except DrawError as error:
        errors = _errors_of_nodes(error, check.node, sampling.batch(check.scenes))
        for one in errors:
            report_draw_failure(one, check.origin, sampling)
        if not errors:
            sampling.unplaced.append(partial(check_rows, check, sampling))
        return not errors
    bounds = check.kind.bounds
    outside = _rows_outside(data, bounds)
    if outside:
        scene, row = check.scenes[outside[0]], data[outside[0]]
        wrong = bounds.requirement(_number_outside(row, bounds))
        message = f"in scene {scene} this is {_format_row(row)}: {_subject(row)} must be {wrong}"
        sampling.sink.report("SC513", message, check.origin)
        if sampling.record is not None:
            failed = tuple(check.scenes[row] for row in outside) if len(data) > 1 else check.scenes
            sampling.record.failures.append(DrawFailure(failed, check.node))
    return not outside


def check_samples(check: ValueCheck, sampling: SamplingContext) -> bool:
    """Whether a value exists and is in range in every sample; otherwise warns of a scene and a seed."""
    try:
        rows = check.value.samples
    except DrawError as error:
        for one in _errors_of_nodes(error, check.node, sampling.analysis(check.scenes).samples):
            warn_of_missing_sample(one, check.origin, sampling)
        return False
    bounds = check.kind.bounds
    outside = _rows_outside(rows, bounds)
    if outside:
        from scenecc.variation.samples import name_sample, sample_hint, sample_of  # noqa: PLC0415 - loads numpy

        row = rows[outside[0]]
        scene, seed = sample_of(outside[0], check.scenes)
        message = f"{name_sample(scene, seed)} this is {_format_row(row)}: {_subject(row)}"
        message += f" must be {bounds.requirement(_number_outside(row, bounds))}"
        hint = sample_hint(seed, "`min` and `max` in the expression keep it in its range")
        sampling.sink.report("SC514", message, check.origin, hint=hint)
    return not outside


def _errors_of_nodes(error: DrawError, node: Node, batch: Batch) -> Iterable[DrawError]:
    """The errors of all nodes without a value in a batch, of which `error` is the first; none for a placement alone."""
    if isinstance(error, ComputeLimitError):
        return (error,)
    # A placement has no pose yet, but the expressions beside it have values.
    found = {} if isinstance(error.node, Placed) else {id(error.node): error}
    from scenecc.variation.samples import nodes_read  # noqa: PLC0415 - loads numpy

    for part, rows in nodes_read(node, batch):
        one = _error_of(part, rows) if getattr(part, "origin", None) is not None else None
        if one is not None and not isinstance(one.node, Placed):
            found.setdefault(id(one.node), one)
    return found.values()


def _error_of(node: Node, batch: Batch) -> DrawError | None:
    try:
        batch.evaluate(node)
    except DrawError as error:
        return error
    return None


def warn_of_missing_sample(error: DrawError, origin: Origin, sampling: SamplingContext) -> None:
    """Warns of a node without a value in a sample. Arguments as of `report_draw_failure`."""
    place, expression = _place_of(error, origin), error.expression
    if isinstance(error, ComputeLimitError):
        report_draw_failure(error, origin, sampling)
        return
    if place in sampling.failed or place in sampling.warned:
        return
    sampling.warned.add(place)
    from scenecc.variation.samples import name_sample, sample_hint  # noqa: PLC0415 - loads numpy

    where = name_sample(error.scene, error.seed)
    if expression is None and isinstance(error.node, Computed):
        sampling.sink.report("SC514", f"{where} {error.message}", place, hint=sample_hint(error.seed))
        return
    advice = "`min` and `max` keep a bound in its range" if isinstance(error.node, Drawn) else ""
    if expression is not None:
        advice = "`a if c else b` keeps what has no value from being evaluated"
    span = None if expression is None else (expression.start, expression.end)
    message = f"{where} this has no value: {error.message}"
    sampling.sink.report("SC516", message, place, hint=sample_hint(error.seed, advice), span=span)


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


def _format_row(row: Any) -> str:
    numbers = row.ravel().tolist()
    return f"{numbers[0]:g}" if len(numbers) == 1 else "[" + ", ".join(f"{number:g}" for number in numbers) + "]"
