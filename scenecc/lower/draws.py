"""The shared draws of a document, in order, and what varying parameters are given."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show, suggest_name
from scenecc.lower.deferred_checks import report_draw_failure, warn_draw_may_fail
from scenecc.lower.field_types import FieldType
from scenecc.lower.fields import FieldLowerer
from scenecc.lower.references import scope_of
from scenecc.lower.variation import FieldPlace, VariationLowerer
from scenecc.spec.params import PARAM_KINDS
from scenecc.variation.nodes import NODES, Const, Cycled
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.fields import SamplingContext
    from scenecc.spec.params import ParamIssue, ParamType
    from scenecc.spec.references import NameScopes
    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.nodes import Node


_NUMBERS = frozenset((int, float))


@frozen
class VaryingArgument:
    """What a parameter is given that differs from scene to scene.

    Attributes:
        name: of the draw that stands for it.
        wanted: what the parameter takes.
        scenes: of the instance whose parameter it is; what it would be in others does not matter.
        origin: where it is given, in the expanded data.
    """

    name: str
    wanted: ParamType
    scenes: tuple[int, ...]
    origin: Origin


def check_argument(argument: VaryingArgument, drawing: SamplingContext) -> None:
    """Reports what is known to be wrong before anything is drawn, and leaves the rest to the draw stage.

    Args:
        argument: to be judged, whose draw is there.
        drawing: of the document.
    """
    if argument.name not in drawing.random and argument.scenes is not drawing.everywhere:
        check_argument_rows(argument, drawing, drawing.sink)
        return
    found = drawing.reader().shared(argument.name)
    if found.exact and argument.scenes is drawing.everywhere:
        wrong = _misfit(found, argument.wanted)
        if wrong is not None:
            _report_misfit(argument, wrong, "which this can give", drawing.sink)
            return
        if found.alternatives is not None:
            return
    drawing.arguments.append(argument)


def check_argument_rows(argument: VaryingArgument, drawing: SamplingContext, sink: Sink) -> None:
    """Reports the first scene in which a parameter is given what it does not take."""
    from scenecc.variation.operations import DrawError  # noqa: PLC0415 - loaded where something varies

    try:
        rows = drawing.leaves(argument.scenes).batch().shared(argument.name).tolist()
    except DrawError:
        # Whatever reads it tells that it has no value.
        return
    for scene, row in zip(argument.scenes, rows, strict=True):
        wrong = argument.wanted.drawn_misfit(row)
        if wrong is not None:
            _report_misfit(argument, wrong, f"which this gives in scene {scene}", sink)
            return


def _report_misfit(argument: VaryingArgument, wrong: ParamIssue, when: str, sink: Sink) -> None:
    code, words = wrong
    declared = argument.wanted.declared
    message = f"the parameter `{cut(argument.wanted.name)}` {words}, {when}"
    related = [("the parameter", declared, "key")] if declared is not None else []
    sink.report(code, message, argument.origin, related=related)  # pyright: ignore[reportArgumentType]


def _misfit(found: ValueBounds, wanted: ParamType) -> ParamIssue | None:
    """What is wrong with the first of the alternatives that is wrong, or with bounds, each of which occurs."""
    if found.alternatives is not None:
        return next((wrong for item in found.alternatives if (wrong := wanted.drawn_misfit(item))), None)
    if found.low is None or wanted.kind == "choice":
        return None
    if wanted.kind == "color":
        wanted = replace(wanted, low=0, high=1)
    if not _has_shape(found.low, wanted):
        return "SC211", f"must be {PARAM_KINDS[wanted.kind][1]}, not {_described_bound(found.low)}"
    return wanted.outside(found.low, found.high) if wanted.ranged else None


def _has_shape(bound: Any, wanted: ParamType) -> bool:
    """Whether numbers between bounds are what is wanted, as far as their shape tells."""
    if wanted.kind in {"number", "integer"}:
        return type(bound) in _NUMBERS
    if wanted.kind not in {"vector", "color", "list"} or type(bound) in _NUMBERS:
        return False
    if wanted.kind == "list":
        return True
    counts = {3, 4} if wanted.kind == "color" else {wanted.components or len(bound)}
    return len(bound) in counts and _NUMBERS.issuperset(map(type, bound))


def _described_bound(bound: Any) -> str:
    return f"a number such as {show(bound)}" if type(bound) in _NUMBERS else f"a list of {len(bound)}"


def lower_draws(
    written: Mapping[str, Any],
    given: Mapping[str, Any],
    drawing: SamplingContext,
    names: NameScopes,
    selections: Mapping[str, tuple[int, ...]],
    origin: Origin,
) -> None:
    """Fills `drawing.draws` and what is known of each, and judges those that parameters are given.

    Args:
        written: by full name, as the models have them.
        given: arrays that take the place of draws, one row a scene.
        drawing: of the document.
        names: of the document.
        selections: the scenes of the frames of instances that are narrowed.
        origin: of `draws`.
    """
    for name in given:
        if name not in written or name in names.given:
            known = [other for other in written if other not in names.given]
            message = f"there is no shared draw `{cut(str(name))}` that could be given"
            drawing.sink.report("SC250", message, origin, hint=suggest_name(str(name), known, drawing.sink))
    for name, draw in written.items():
        place = origin.child(name)
        scope = names.given.get(name, scope_of(name))
        everywhere = drawing.everywhere
        found = selections.get(names.anchors.get(scope_of(name), "") if name in names.wanted else "", everywhere)
        scenes = everywhere if len(found) == len(everywhere) else found
        leaves = FieldLowerer(drawing, scenes, everywhere, scope, partial=name in names.given)
        reading = VariationLowerer(leaves, place)
        item = reading.item(draw, _ANY_TYPE, FieldPlace(place, ""))
        node = item if item.__class__ in NODES else Const(item)
        if name in given:
            rows = None if reading.broken else _injected_rows(given[name], node, drawing, place)
            # One for each scene, so that this is by index, as rows are: those are what stays as it is built.
            drawing.add(name, node if rows is None else Cycled(rows), frozenset())
            drawing.random.add(name)  # a reset may be given other rows
        else:
            drawing.add(name, node, frozenset(reading.reads))
            if reading.drawn or any(other in drawing.random for other in reading.reads):
                drawing.random.add(name)
            drawing.draw_origins |= reading.origins
            if reading.risky:
                warn_draw_may_fail(name, reading, leaves)
        wanted = names.wanted.get(name)
        # Forms without expressions were judged as they were given.
        if wanted is not None and not reading.broken and (reading.computed or name in given):
            check_argument(VaryingArgument(name, wanted, scenes, place), drawing)


def report_unused_draws(
    written: Mapping[str, Any], drawing: SamplingContext, names: NameScopes, origin: Origin
) -> None:
    """A warning for each shared draw that nothing reads, and what is wrong with it that its readers would tell."""
    for name in written:
        if name in drawing.used or name in names.given:
            continue
        message = f"the draw `{cut(name)}` is never read"
        drawing.sink.report("SC319", message, origin.child(name), at="key")
        if name in drawing.doubtful and name not in drawing.random:
            try:
                drawing.leaves().batch().shared(name)
            except DrawError as error:
                report_draw_failure(error, drawing.draw_origins, origin.child(name), drawing.sink)


def _injected_rows(rows: Any, node: Node, drawing: SamplingContext, place: Origin) -> tuple[Any, ...] | None:
    """What the caller gives in place of a draw, a plain row a scene; None where it was reported.

    Args:
        rows: as given.
        node: of the draw as the file declares it.
        drawing: of the document.
        place: of the draw.
    """
    from scenecc.variation.injected_draws import InjectedDrawError, convert_injected, draw_type  # noqa: PLC0415 - loads numpy

    wanted = draw_type(node, drawing.reader().bounds(node))
    try:
        data = convert_injected(rows, wanted, drawing.num_scenes)
    except InjectedDrawError as error:
        drawing.sink.report("SC318", f"the array given for this draw {error}", place, at="key", hint=error.hint)
        return None
    items: list[Any] = data.tolist()
    return tuple(map(_plain, items))


def _plain(item: Any) -> Any:
    return tuple(map(_plain, item)) if isinstance(item, list | tuple) else item  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]


_ANY_TYPE = FieldType(convert=_plain, free=True)
