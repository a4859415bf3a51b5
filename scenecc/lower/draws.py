"""The shared draws of a document, in order, each of which may read those before it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.words import cut, suggest_name
from scenecc.lower.forms import Place, Reading
from scenecc.lower.kinds import Kind
from scenecc.lower.leaves import Leaves
from scenecc.lower.names import scope_of
from scenecc.values.nodes import NODES, Const, Cycled

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.leaves import Drawing
    from scenecc.lower.names import Names


def lower_draws(
    written: Mapping[str, Any], given: Mapping[str, Any], drawing: Drawing, names: Names, origin: Origin
) -> None:
    """Fills `drawing.draws` and what is known of each.

    Args:
        written: by full name, as the models have them.
        given: arrays that take the place of draws, one row a scene.
        drawing: of the document.
        names: of the document.
        origin: of `draws`.
    """
    for name in given:
        if name not in written or name in names.given:
            known = [other for other in written if other not in names.given]
            message = f"there is no shared draw `{cut(str(name))}` that could be given"
            drawing.sink.report("SC250", message, origin, hint=suggest_name(str(name), known, drawing.sink))
    for name, draw in written.items():
        place = origin.child(name)
        if name in given and (rows := _given(given[name], drawing, place, drawing.sink)) is not None:
            drawing.add(name, rows, frozenset())
            drawing.random.add(name)  # a reset may be given other rows
            continue
        scope = names.given.get(name, scope_of(name))
        everywhere = drawing.everywhere
        leaves = Leaves(drawing, everywhere, everywhere, scope, partial=name in names.given)
        reading = Reading(leaves, place)
        item = reading.item(draw, _ANY, Place(place, ""))
        node = item if item.__class__ in NODES else Const(item)
        drawing.add(name, node, frozenset(reading.reads))
        if reading.drawn or any(other in drawing.random for other in reading.reads):
            drawing.random.add(name)
        drawing.draw_origins |= reading.origins


def report_unused(written: Mapping[str, Any], drawing: Drawing, names: Names, origin: Origin) -> None:
    """A warning for each shared draw that nothing reads."""
    for name in written:
        if name not in drawing.used and name not in names.given:
            message = f"the draw `{cut(name)}` is never read"
            drawing.sink.report("SC319", message, origin.child(name), at="key")


def _given(rows: Any, drawing: Drawing, place: Origin, sink: Sink) -> Cycled | None:
    """What the caller gives in place of a draw, as a node; None where it was reported."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    data = np.asarray(rows)
    wanted = f"({drawing.num_scenes},) or ({drawing.num_scenes}, k)"
    if data.ndim not in {1, 2} or len(data) != drawing.num_scenes:
        message = f"an array of shape {tuple(data.shape)} was given for this draw: it must be {wanted}"
        sink.report("SC318", message, place, at="key", hint="one row for each scene of the batch")
    elif data.dtype.kind not in "biufU" or (data.dtype.kind == "f" and not np.isfinite(data).all()):
        sink.report("SC318", "this draw was given something else than finite numbers, flags or texts", place, at="key")
    else:
        # One for each scene, so that this is by index, as rows are: those are what stays as it is built.
        items: list[Any] = data.tolist()
        return Cycled(tuple(map(_row, items)))
    return None


def _row(item: Any) -> Any:
    return tuple(item) if item.__class__ is list else item


def _plain(item: Any) -> Any:
    return tuple(map(_plain, item)) if isinstance(item, list | tuple) else item  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]


_ANY = Kind(convert=_plain, free=True)
