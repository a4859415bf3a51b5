"""The shared draws of a document, in order, each of which may read those before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.arguments import Argument, judge_argument
from scenecc.lower.doubts import foretell_draw
from scenecc.lower.forms import Place, Reading
from scenecc.lower.kinds import Kind
from scenecc.lower.leaves import Leaves
from scenecc.lower.names import scope_of
from scenecc.lower.pending import report_failure
from scenecc.variation.errors import DrawError
from scenecc.variation.nodes import NODES, Const, Cycled

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.names import Names
    from scenecc.variation.nodes import Node


def lower_draws(
    written: Mapping[str, Any],
    given: Mapping[str, Any],
    drawing: Drawing,
    names: Names,
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
        leaves = Leaves(drawing, scenes, everywhere, scope, partial=name in names.given)
        reading = Reading(leaves, place)
        item = reading.item(draw, _ANY, Place(place, ""))
        node = item if item.__class__ in NODES else Const(item)
        if name in given:
            rows = None if reading.broken else _given(given[name], node, drawing, place)
            # One for each scene, so that this is by index, as rows are: those are what stays as it is built.
            drawing.add(name, node if rows is None else Cycled(rows), frozenset())
            drawing.random.add(name)  # a reset may be given other rows
        else:
            drawing.add(name, node, frozenset(reading.reads))
            if reading.drawn or any(other in drawing.random for other in reading.reads):
                drawing.random.add(name)
            drawing.draw_origins |= reading.origins
            if reading.risky:
                foretell_draw(name, reading, leaves)
        wanted = names.wanted.get(name)
        # Forms without expressions were judged as they were given.
        if wanted is not None and not reading.broken and (reading.computed or name in given):
            judge_argument(Argument(name, wanted, scenes, place), drawing)


def report_unused(written: Mapping[str, Any], drawing: Drawing, names: Names, origin: Origin) -> None:
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
                report_failure(error, drawing.draw_origins, origin.child(name), drawing.sink)


def _given(rows: Any, node: Node, drawing: Drawing, place: Origin) -> tuple[Any, ...] | None:
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


_ANY = Kind(convert=_plain, free=True)
