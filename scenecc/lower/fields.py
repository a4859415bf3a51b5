"""Fields of the language to values of the plan, and what the values of one document have in common."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import dotted
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.lower.deferred_checks import DeferredCheck, ResettableValue, report_draw_failure
from scenecc.lower.variation import VARYING, VariationLowerer, field_place
from scenecc.plan import Value, literal, per_scene, varying
from scenecc.plan.scene import is_unnamed_draw, kept_draw_name
from scenecc.variation.nodes import BUILTIN_NAMES, NODE_TYPES, Rows, holds_infinity
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, DrawError, OperationCounter

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.deferred_checks import PossibleFailure
    from scenecc.lower.draws import VaryingArgument
    from scenecc.lower.field_types import FieldType
    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.forms import Template
    from scenecc.variation.node_bounds import BoundsAnalysis
    from scenecc.variation.nodes import Node


_ARRAY_KINDS = {"float64": "fi", "int64": "i", "bool": "b"}
"""Kinds of arrays that become a field's."""

_TYPE_WORDS = {"float64": "a number", "int64": "an integer", "bool": "true or false"}


class FieldLowerer:
    """Makes values over some scenes, reading names in one scope.

    Attributes:
        scenes: that the rows of the values follow.
        listed: that the items of `per_scene` lists follow.
        scope: the name of the instance that the names belong to; "" for the document.
        partial: whether maps by scene may leave out scenes, whose values are never read.
    """

    def __init__(
        self,
        sampling: SamplingContext,
        scenes: tuple[int, ...],
        listed: tuple[int, ...],
        scope: str,
        *,
        partial: bool = False,
    ) -> None:
        self.sampling = sampling
        self.partial = partial
        self.scenes = scenes
        self.listed = listed
        self.scope = scope
        self.sink = sampling.sink
        self._batch: Batch | None = None

    def value(self, given: Any, kind: FieldType, owner: Origin, *at: str, reset: bool | None = None) -> Value:
        """A leaf as a value.

        Args:
            given: as the models have it.
            kind: of the field.
            owner: of the node that has the field.
            at: the field's keys there.
            reset: whether a reset may change it; None: the type of the field says so.
        """
        if given.__class__ not in VARYING:
            return literal(given if kind.convert is None else kind.convert(given), kind.dtype)
        place = field_place(owner.child(*at))
        variation = VariationLowerer(self, place.origin)
        return self.finish(variation.item(given, kind, place), variation, kind, place.origin, reset=reset)

    def optional(self, given: Any, kind: FieldType, owner: Origin, *at: str, reset: bool | None = None) -> Value | None:
        """As `value`; None where the key was left out."""
        return None if given is None else self.value(given, kind, owner, *at, reset=reset)

    def finish(
        self, item: Any, variation: VariationLowerer, kind: FieldType, origin: Origin, *, reset: bool | None = None
    ) -> Value:
        """An item that was read as a value: of what is known by scene the rows, of the rest how they are drawn."""
        reset = kind.reset if reset is None else reset
        if not reset:
            self.fix(variation)
        if item.__class__ not in NODE_TYPES:
            return literal(item, kind.dtype)
        if variation.broken:
            return literal(kind.fallback, kind.dtype)
        if variation.known:
            return self._rows(item, variation, kind, origin)
        self.sampling.drawn = True
        support, dependence = self.bounds(item), None
        if variation.computed:
            # Expressions may couple values, so rules over several are checked by rows.
            support = replace(support, exact=False)
            dependence = self.sampling.reader().dependence(item)
        value = varying(self.drawer(item, kind), bounds=support, rows=len(self.scenes), dependence=dependence)
        if variation.risky:
            self.defer(value, kind, origin, variation)
        if reset:
            self.sampling.resets[id(value)] = ResettableValue(value, item, variation, self)
        return value

    def defer(self, value: Value, kind: FieldType, origin: Origin, variation: VariationLowerer) -> None:
        """Defers the check of a value until sampling, and reports errors that are certain or possible."""
        deferred = DeferredCheck(value, kind, self.scenes, origin, variation.origins)
        if variation.risky:
            from scenecc.lower.deferred_checks import warn_may_fail  # noqa: PLC0415 - loaded where something varies

            warn_may_fail(deferred, variation, self)
        self.sampling.deferred.append(deferred)

    def inside(self, scope: str) -> FieldLowerer:
        """The lowerer of a named object in another scope, over the same scenes; `per_scene` lists cover all scenes."""
        return self.sampling.fields(self.scenes, scope, self.sampling.all_scenes)

    def fix(self, variation: VariationLowerer) -> None:
        """Notes that a field stays as it is built, and with it all shared draws that it reads."""
        self.sampling.fixed |= variation.reads

    def keep(self, node: Node, origin: Origin, reads: Iterable[str]) -> str:
        """Makes a value a shared draw that stays as it is built, and returns its name.

        Args:
            node: of the value, which a seed decides.
            origin: of its `once`.
            reads: the shared draws that it reads.
        """
        sampling = self.sampling
        name = kept_draw_name(dotted(origin.path))
        scenes = {*self.scenes, *sampling.scenes_of.get(name, ())}
        sampling.add(name, node, frozenset(reads))
        sampling.scenes_of[name] = tuple(sorted(scenes))
        sampling.fixed.add(name)
        sampling.random.add(name)
        return name

    def keep_infinite(self, value: Value) -> None:
        """Has a value stay as it is built if it may be infinite in some scene: the engine cannot change that later."""
        reset = self.sampling.resets.get(id(value))
        if reset is not None and holds_infinity(reset.node, self.sampling.draws):
            del self.sampling.resets[id(value)]
            self.fix(reset.variation)

    def _rows(self, node: Node, variation: VariationLowerer, kind: FieldType, origin: Origin) -> Value:

        try:
            known = per_scene(self.evaluate(node), kind.dtype)
            if not variation.cycled:
                return known
            # Values that no scene has are checked too.
            found = self.bounds(node)
            if found.alternatives is not None and len(found.alternatives) <= len(known.bounds.alternatives or ()):
                return known
            return varying(self.drawer(node, kind), bounds=found, rows=len(self.scenes))
        except DrawError as error:
            report_draw_failure(error, variation.origins, origin, self.sink)
            return literal(kind.fallback, kind.dtype)

    def evaluate(self, node: Node) -> NDArray[Any]:
        """A node's rows in the scenes, as a field takes them.

        Raises:
            DrawError: it has none in some scene.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        return to_field_rows(self.batch().evaluate(node))

    def bounds(self, node: Node) -> ValueBounds:
        """Everything that a node can be."""
        return self.sampling.reader().bounds(node)

    def batch(self) -> Batch:
        """The scenes, as draws are made for them."""
        if self._batch is None:
            import numpy as np  # noqa: PLC0415 - checking a scene in which nothing varies needs none

            from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - likewise

            scenes = np.array(self.scenes, dtype=np.int64)
            sampling = self.sampling
            self._batch = Batch(scenes, sampling.seed, sampling.num_scenes, sampling.draws, {}, sampling.computed)
            self._batch.placed = sampling.placed
        return self._batch

    def drawer(self, node: Node, kind: FieldType) -> Callable[[], NDArray[Any]]:
        """What draws a node's rows when they are first asked for."""

        def draw() -> NDArray[Any]:

            rows = self.evaluate(node)
            if rows.dtype.kind not in _ARRAY_KINDS[kind.dtype] or rows.shape[1:] != kind.shape:
                raise DrawError(f"this is not {_described_type(kind)}", self.scenes[0], node)
            return rows.astype(kind.dtype)

        return draw

    def draw_names(self, template: Template, origin: Origin) -> dict[str, str] | None:
        """The shared draws that an expression reads, by the names that it has for them; None where one is unknown."""
        scope = self.scope if template.scope is None else template.scope
        prefix = f"{scope}/" if scope else ""
        draws = self.sampling.draws
        names = {name: prefix + name for name in template.names - BUILTIN_NAMES}
        for name, full in names.items():
            if full not in draws:
                known = (draw[len(prefix) :] for draw in draws if draw.startswith(prefix) and not is_unnamed_draw(draw))
                hint = suggest_name(name, known, self.sink)
                message = f"there is no parameter, loop variable or draw `{cut(name)}` here"
                self.sink.report("SC201", message, origin, hint=hint)
                return None
        self.sampling.used |= set(names.values())
        return names


def _described_type(kind: FieldType) -> str:
    one = _TYPE_WORDS[kind.dtype]
    return f"a list of {kind.shape[0]} numbers" if kind.shape else one


_RECOMPUTATIONS = 4
"""How often what is computed may be computed again."""


@dataclass(slots=True)
class SamplingContext:
    """What the values of one document have in common.

    Attributes:
        seed, num_scenes: of the batch.
        sink: takes the diagnostics.
        most: operations that its values may take (limit `computed`).
        draws: the shared draws by their full names; filled before anything reads them.
        deferred: the values that the draw stage judges.
        arguments: what parameters are given that it judges.
        used: the shared draws that anything reads.
        fixed: those that something reads which stays as it is built.
        reads: for each shared draw, those that it reads.
        scenes_of: for each shared draw, the scenes that it has a value in.
        random: the shared draws that a seed decides, by themselves or through others.
        draw_origins: of the nodes in shared draws that can have no value, by identity.
        may_fail: the shared draws that may have no value in some scene.
        failures: what is known of each expression, by all that it follows from.
        drawn: whether any value is to be drawn.
        read: how many fields with forms or expressions were read.
        resets: what a reset may change: its value by identity, its node, and what was read of it.
        sampling_operations: operations of sampling, and of the analysis of its bounds.
        placed: poses (num_scenes, 7) of what is placed, once it is.
        computed: operations of the draw stage as they are done; some do again what others have done.
    """

    seed: int
    num_scenes: int
    sink: Sink
    most: int
    draws: dict[str, Node] = field(default_factory=dict[str, "Node"])
    deferred: list[DeferredCheck] = field(default_factory=list["DeferredCheck"])
    arguments: list[VaryingArgument] = field(default_factory=list["VaryingArgument"])
    used: set[str] = field(default_factory=set[str])
    fixed: set[str] = field(default_factory=set[str])
    reads: dict[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    scenes_of: dict[str, tuple[int, ...]] = field(default_factory=dict[str, "tuple[int, ...]"])
    random: set[str] = field(default_factory=set[str])
    draw_origins: dict[int, tuple[Any, Origin]] = field(default_factory=dict[int, "tuple[Any, Origin]"])
    may_fail: set[str] = field(default_factory=set[str])
    failures: dict[tuple[Any, ...], tuple[Any, PossibleFailure | None]] = field(default_factory=dict[Any, Any])
    drawn: bool = False
    read: int = 0
    resets: dict[int, ResettableValue] = field(default_factory=dict[int, "ResettableValue"])
    all_scenes: tuple[int, ...] = ()
    placed: dict[str, NDArray[Any]] = field(default_factory=dict[str, "NDArray[Any]"])
    sampling_operations: OperationCounter = field(init=False)
    computed: OperationCounter = field(init=False)
    _reader: BoundsAnalysis | None = None
    _fields: dict[tuple[int, int, str], FieldLowerer] = field(default_factory=dict[tuple[int, int, str], FieldLowerer])

    def __post_init__(self) -> None:
        self.all_scenes = tuple(range(self.num_scenes))
        self.sampling_operations = OperationCounter(self.most)
        self.computed = OperationCounter(_RECOMPUTATIONS * self.most)

    def count_operations(self, operations: int, origin: Origin) -> None:
        """Counts what the draw stage will do; once that is too much, it is reported."""
        within = not self.sampling_operations.exhausted
        self.sampling_operations.done += operations
        if within and self.sampling_operations.exhausted:
            self.sink.report("SC609", self.sampling_operations.message, origin, hint=COMPUTE_LIMIT_HINT)

    def reader(self) -> BoundsAnalysis:
        """The analysis of bounds; that of each shared draw is done once."""
        if self._reader is None:
            from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - loaded where something varies

            self._reader = BoundsAnalysis(self.draws, {}, self.num_scenes, self.sampling_operations)
        return self._reader

    @property
    def varies(self) -> bool:
        """Whether anything is to be drawn or checked by its rows."""
        return bool(self.draws or self.deferred or self.drawn)

    def add(self, name: str, node: Node, reads: frozenset[str]) -> None:
        """Adds a shared draw. `reads`: those that it reads, all of which are there."""
        self.draws[name] = node
        self.reads[name] = reads
        found = node.scene_idxs if isinstance(node, Rows) else self.all_scenes
        for other in reads:
            limits = self.scenes_of[other]
            if limits is not self.all_scenes:
                found = limits if found is self.all_scenes else tuple(sorted(set(found).intersection(limits)))
        self.scenes_of[name] = found

    def fields(
        self, scenes: tuple[int, ...] | None = None, scope: str = "", listed: tuple[int, ...] | None = None
    ) -> FieldLowerer:
        """The field lowerer of an object.

        Args:
            scenes: that it is in; None: all.
            scope: in which its names are looked up.
            listed: the scenes of its `per_scene` lists, where these are not `scenes`.
        """
        scenes = self.all_scenes if scenes is None else scenes
        listed = scenes if listed is None else listed
        # By identity, since objects share the tuples of their scenes; the lowerers keep them.
        key = (id(scenes), id(listed), scope)
        found = self._fields.get(key)
        if found is None:
            found = self._fields[key] = FieldLowerer(self, scenes, listed, scope)
        return found
