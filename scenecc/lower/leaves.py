"""Leaves of the language to values of the plan."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.forms import VARYING, Reading, holds_template, place_of
from scenecc.lower.pending import Pending, Reset, report_failure
from scenecc.plan import Value, literal, per_scene, varying
from scenecc.plan.shared_poses import is_pose
from scenecc.variation.nodes import BUILTIN_NAMES, NODE_TYPES

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin
    from scenecc.lower.drawing import Drawing
    from scenecc.lower.kinds import Kind
    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.nodes import Node
    from scenecc.variation.template import Template

_TAKEN = {"float64": "fi", "int64": "i", "bool": "b"}
"""Kinds of arrays that become a field's."""

_ONE = {"float64": "a number", "int64": "an integer", "bool": "true or false"}


class Leaves:
    """Makes values over some scenes, reading names in one scope.

    Attributes:
        scenes: that the rows of the values follow.
        listed: that the items of `per_scene` lists follow.
        scope: the name of the instance that the names belong to; "" for the document.
        partial: whether maps by scene need not name all scenes: nothing is asked of the others.
    """

    def __init__(
        self,
        drawing: Drawing,
        scenes: tuple[int, ...],
        listed: tuple[int, ...],
        scope: str,
        *,
        partial: bool = False,
    ) -> None:
        self.drawing = drawing
        self.partial = partial
        self.scenes = scenes
        self.listed = listed
        self.scope = scope
        self.sink = drawing.sink
        self._batch: Batch | None = None

    def value(self, given: Any, kind: Kind, owner: Origin, *at: str, reset: bool = False) -> Value:
        """A leaf as a value.

        Args:
            given: as the models have it.
            kind: of the field.
            owner: of the node that has the field.
            at: the field's keys there.
            reset: whether a reset may change it.
        """
        if given.__class__ not in VARYING:
            return literal(given if kind.convert is None else kind.convert(given), kind.dtype)
        place = place_of(owner.child(*at))
        reading = Reading(self, place.origin)
        if kind.convert is not None and holds_template(given):
            from scenecc.lower.parts import from_parts  # noqa: PLC0415 - few files have these

            return from_parts(given, kind, place, self)
        return self.finish(reading.item(given, kind, place), reading, kind, place.origin, reset=reset)

    def given(self, given: Any, kind: Kind, owner: Origin, *at: str, reset: bool = False) -> Value | None:
        """As `value`; None where the key was left out."""
        return None if given is None else self.value(given, kind, owner, *at, reset=reset)

    def finish(self, item: Any, reading: Reading, kind: Kind, origin: Origin, *, reset: bool = False) -> Value:
        """An item that was read as a value: of what is known by scene the rows, of the rest how they are drawn."""
        if not reset:
            self.fix(reading)
        if item.__class__ not in NODE_TYPES:
            return literal(item, kind.dtype)
        if reading.broken:
            return literal(kind.fallback, kind.dtype)
        if reading.known:
            return self._rows(item, reading, kind, origin)
        self.drawing.drawn = True
        support = self.bounds(item)
        if reading.computed:
            # Expressions may tie values together, so rules over several are judged by rows.
            support = replace(support, exact=False)
        value = varying(self.drawer(item, kind), bounds=support, rows=len(self.scenes))
        if reading.risky:
            self.pend(value, kind, origin, reading)
        if reset:
            self.drawing.resets[id(value)] = Reset(value, item, reading, self)
        return value

    def pend(self, value: Value, kind: Kind, origin: Origin, reading: Reading) -> None:
        """Leaves a value to the draw stage to judge, and tells what is known to be wrong or may turn out to be."""
        pending = Pending(value, kind, self.scenes, origin, reading.origins)
        if reading.risky:
            from scenecc.lower.doubts import foretell  # noqa: PLC0415 - loaded where something varies

            foretell(pending, reading, self)
        self.drawing.pending.append(pending)

    def inside(self, scope: str) -> Leaves:
        """The leaves of a named thing of another scope, over the same scenes; its `per_scene` lists are by all."""
        return self.drawing.leaves(self.scenes, scope, self.drawing.everywhere)

    def fix(self, reading: Reading) -> None:
        """Notes that a field stays as it is built, and with it all shared draws that it reads."""
        self.drawing.fixed |= reading.reads

    def _rows(self, node: Node, reading: Reading, kind: Kind, origin: Origin) -> Value:
        from scenecc.variation.errors import DrawError  # noqa: PLC0415 - loaded where something varies

        try:
            known = per_scene(self.evaluate(node), kind.dtype)
            if not reading.cycled:
                return known
            # What no scene has is judged all the same.
            found = self.bounds(node)
            if found.alternatives is not None and len(found.alternatives) <= len(known.bounds.alternatives or ()):
                return known
            return varying(self.drawer(node, kind), bounds=found, rows=len(self.scenes))
        except DrawError as error:
            report_failure(error, reading.origins, origin, self.sink)
            return literal(kind.fallback, kind.dtype)

    def evaluate(self, node: Node) -> NDArray[Any]:
        """A node's rows in the scenes, as a field takes them.

        Raises:
            DrawError: it has none in some scene.
        """
        from scenecc.variation.per_scene_arrays import to_field_rows  # noqa: PLC0415 - loads numpy

        return to_field_rows(self.batch().evaluate(node))

    def bounds(self, node: Node) -> ValueBounds:
        """Everything that a node can be."""
        return self.drawing.reader().bounds(node)

    def batch(self) -> Batch:
        """The scenes, as draws are made for them."""
        if self._batch is None:
            import numpy as np  # noqa: PLC0415 - checking a scene in which nothing varies needs none

            from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - likewise

            scenes = np.array(self.scenes, dtype=np.int64)
            drawing = self.drawing
            self._batch = Batch(scenes, drawing.seed, drawing.num_scenes, drawing.draws, {}, drawing.computed)
        return self._batch

    def drawer(self, node: Node, kind: Kind) -> Callable[[], NDArray[Any]]:
        """What draws a node's rows when they are first asked for."""

        def draw() -> NDArray[Any]:
            from scenecc.variation.errors import DrawError  # noqa: PLC0415 - loaded where something varies

            rows = self.evaluate(node)
            if rows.dtype.kind not in _TAKEN[kind.dtype] or rows.shape[1:] != kind.shape:
                raise DrawError(f"this is not {_wanted(kind)}", self.scenes[0], node)
            return rows.astype(kind.dtype)

        return draw

    def draw_names(self, template: Template, origin: Origin) -> dict[str, str] | None:
        """The shared draws that an expression reads, by the names that it has for them; None where one is unknown."""
        prefix = f"{self.scope}/" if self.scope else ""
        draws = self.drawing.draws
        names = {name: prefix + name for name in template.names - BUILTIN_NAMES}
        for name, full in names.items():
            if full not in draws:
                known = (draw[len(prefix) :] for draw in draws if draw.startswith(prefix) and not is_pose(draw))
                hint = suggest_name(name, known, self.sink)
                message = f"there is no parameter, loop variable or draw `{cut(name)}` here"
                self.sink.report("SC201", message, origin, hint=hint)
                return None
        self.drawing.used |= set(names.values())
        return names


def _wanted(kind: Kind) -> str:
    one = _ONE[kind.dtype]
    return f"a list of {kind.shape[0]} numbers" if kind.shape else one
