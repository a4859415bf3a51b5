"""Lowers the shared draws of a document, in order, and checks varying arguments of parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.field_types import FieldType
from scenecc.lower.fields import FieldLowerer
from scenecc.lower.forms import FieldPlace, VariationLowerer
from scenecc.lower.references import scope_of
from scenecc.lower.value_checks import report_draw_failure, warn_of_missing_sample
from scenecc.variation.forms import ONCE, Once
from scenecc.variation.nodes import NODES, Const, Cycled, Node
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.sampling import SamplingContext
    from scenecc.spec.params import ParamIssue, ParamType
    from scenecc.spec.references import NameScopes


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


def check_argument(argument: VaryingArgument, sampling: SamplingContext) -> bool:
    """Whether an argument of a parameter is valid in every scene; otherwise reports it. Warns of a sample with a fault.

    Args:
        argument: to check; its draw has been added.
        sampling: of the document.
    """
    if not _check_argument_rows(argument, sampling):
        return False
    if argument.name in sampling.random:
        _check_argument_samples(argument, sampling)
    return True


def _check_argument_samples(argument: VaryingArgument, sampling: SamplingContext) -> None:
    try:
        rows = sampling.analysis(argument.scenes).samples.shared(argument.name).tolist()
    except DrawError as error:
        warn_of_missing_sample(error, argument.origin, sampling)
        return
    for number, row in enumerate(rows):
        wrong = argument.param.drawn_misfit(row)
        if wrong is not None:
            from scenecc.variation.samples import name_sample, sample_hint, sample_of  # noqa: PLC0415 - loads numpy

            scene, seed = sample_of(number, argument.scenes)
            when = f"which this gives {name_sample(scene, seed)}"
            _report_misfit(argument, ("SC514", wrong[1]), when, sampling.sink, sample_hint(seed))
            return


def _check_argument_rows(argument: VaryingArgument, sampling: SamplingContext) -> bool:
    """Whether a parameter has valid arguments in every scene; otherwise reports the first scene with an invalid one."""
    try:
        rows = sampling.batch(argument.scenes).shared(argument.name).tolist()
    except DrawError as error:
        # The parameter may have no readers.
        report_draw_failure(error, argument.origin, sampling)
        return False
    for scene, row in zip(argument.scenes, rows, strict=True):
        wrong = argument.param.drawn_misfit(row)
        if wrong is not None:
            _report_misfit(argument, wrong, f"which this gives in scene {scene}", sampling.sink)
            return False
    return True


def _report_misfit(
    argument: VaryingArgument, wrong: ParamIssue, when: str, sink: Sink, hint: str | None = None
) -> None:
    code, words = wrong
    declared = argument.param.declared
    message = f"the parameter `{cut(argument.param.name)}` {words}, {when}"
    related = [("the parameter", declared, "key")] if declared is not None else []
    sink.report(code, message, argument.origin, hint=hint, related=related)  # pyright: ignore[reportArgumentType]


def lower_draws(
    written: Mapping[str, Any],
    given: Mapping[str, Any],
    sampling: SamplingContext,
    names: NameScopes,
    selections: Mapping[str, tuple[int, ...]],
    origin: Origin,
) -> None:
    """Fills `sampling.draws` and the data about each draw, and checks those that are arguments of parameters.

    Args:
        written: by full name, from the models.
        given: arrays that replace draws, one row per scene.
        sampling: of the document.
        names: of the document.
        selections: the scenes of instances that are in some scenes only.
        origin: of `draws`.
    """
    for name in given:
        if name not in written or name in names.given:
            known = [other for other in written if other not in names.given]
            message = f"there is no shared draw `{cut(str(name))}` to replace"
            sampling.sink.report("SC250", message, origin, hint=suggest_name(str(name), known, sampling.sink))
    for name, draw in written.items():
        kept = draw.__class__ is Once
        place = origin.child(name, ONCE) if kept else origin.child(name)
        scope = names.given.get(name, scope_of(name))
        all_scenes = sampling.all_scenes
        found = selections.get(names.anchors.get(scope_of(name), "") if name in names.wanted else "", all_scenes)
        scenes = all_scenes if len(found) == len(all_scenes) else found
        fields = FieldLowerer(sampling, scenes, all_scenes, scope, partial=name in names.given)
        variation = VariationLowerer(fields, place)
        item = variation.item(draw.form if kept else draw, _ANY_TYPE, FieldPlace(place, ""))
        node = item if item.__class__ in NODES else Const(item)
        if name in given:
            rows = None if variation.broken else _convert_injected_rows(given[name], node, sampling, place)
            # One item per scene, so this indexes by scene. `Rows` would be fixed after the build.
            sampling.add(name, node if rows is None else Cycled(rows), frozenset())
            sampling.random.add(name)  # a reset may be given other rows
        else:
            sampling.add(name, node, frozenset(variation.reads))
            if variation.drawn or any(other in sampling.random for other in variation.reads):
                sampling.random.add(name)
            kept |= not variation.drawn and variation.reads & sampling.random <= sampling.fixed
        if kept:
            sampling.fixed.add(name)
        param = names.wanted.get(name)
        # Forms without expressions were checked during expansion.
        if param is None or variation.broken or not (variation.computed or name in given):
            continue
        if not check_argument(VaryingArgument(name, param, scenes, place), sampling):
            sampling.rejected.add(name)


def report_unused_draws(
    written: Mapping[str, Any], sampling: SamplingContext, names: NameScopes, origin: Origin
) -> None:
    """Reports the errors of each shared draw without readers, which readers would report otherwise, and warns of it."""
    # A draw may be unread only because of a misspelt reference.
    is_certain = not sampling.sink.failed
    for name in written:
        if name in sampling.used or name in names.given or scope_of(name) in names.overridden:
            continue
        if is_certain:
            sampling.sink.report("SC319", f"the draw `{cut(name)}` is never read", origin.child(name), at="key")
            if sampling.record is not None:  # a cover of it would differ in nothing
                kept = {
                    at: one for at, one in sampling.record.sources.items() if (one.section, one.name) != ("draws", name)
                }
                sampling.record.sources = kept
        try:
            sampling.batch().shared(name)
        except DrawError as error:
            report_draw_failure(error, origin.child(name), sampling)


def _convert_injected_rows(rows: Any, node: Node, sampling: SamplingContext, place: Origin) -> tuple[Any, ...] | None:
    """The injected values of a draw, a plain row per scene; None after an error."""
    from scenecc.variation.injected_draws import InjectedDrawError, convert_injected, draw_type  # noqa: PLC0415 - loads numpy

    drawn_type = draw_type(node, sampling.analysis().bounds(node))
    try:
        data = convert_injected(rows, drawn_type, sampling.num_scenes)
    except InjectedDrawError as error:
        sampling.sink.report("SC318", f"the array given for this draw {error}", place, at="key", hint=error.hint)
        return None
    items: list[Any] = data.tolist()
    return tuple(map(_plain, items))


def _plain(item: Any) -> Any:
    return tuple(map(_plain, item)) if isinstance(item, list | tuple) else item  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]


_ANY_TYPE = FieldType(convert=_plain, free=True)
