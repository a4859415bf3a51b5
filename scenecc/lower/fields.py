"""Lowers fields of the language to values of the plan; the shared state of a document's values."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin, dotted
from scenecc.diagnostics.messages import cut, show, suggest_name
from scenecc.lower.forms import VARYING, VariationLowerer, field_place
from scenecc.lower.resettable import ResettableValue
from scenecc.lower.value_checks import ValueCheck, check_rows, check_samples, report_draw_failure
from scenecc.plan import Value, literal, per_scene, varying
from scenecc.plan.scene import is_unnamed_draw, kept_draw_name
from scenecc.variation.nodes import (
    BUILTIN_NAMES,
    NODE_TYPES,
    Node,
    Rows,
    holds_infinity,
)
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, DrawError, OperationCounter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.lower.field_types import FieldType
    from scenecc.variation.bounds import ValueBounds
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.forms import (
        Template,
    )
    from scenecc.variation.node_bounds import BoundsAnalysis

_ARRAY_KINDS = {"float64": "fi", "int64": "i", "bool": "b"}
"""NumPy dtype kinds accepted for a field's dtype."""

_VALUE_TYPES = {
    "float64": (frozenset((int, float)), "a number"),
    "int64": (frozenset((int,)), "an integer"),
    "bool": (frozenset((bool,)), "true or false"),
}
"""Accepted value types of a field, and their name."""

RowMaker = Callable[["Batch"], "NDArray[Any]"]
"""Computes the rows (B, …) of a value in a batch."""


class FieldLowerer:
    """Makes values over some scenes and resolves names in one scope.

    Attributes:
        scenes: scenes of the rows.
        listed: scenes of the items of `per_scene` lists.
        scope: name of the instance that the names belong to; "" for the document.
        partial: whether maps by scene may omit scenes, whose values are never read.
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
        """Lowers a leaf to a value.

        Args:
            given: from the model.
            kind: of the field.
            owner: of the node that has the field.
            at: keys of the field in the node.
            reset: whether a reset may change it; None: decided by the field's type.
        """
        if given.__class__ not in VARYING:
            return literal(given if kind.convert is None else kind.convert(given), kind.dtype)
        place = field_place(owner.child(*at))
        variation = VariationLowerer(self, place.origin)
        return self.finish(variation.item(given, kind, place), variation, kind, place.origin, reset=reset)

    def optional(self, given: Any, kind: FieldType, owner: Origin, *at: str, reset: bool | None = None) -> Value | None:
        """Same as `value`; None if the key was left out."""
        return None if given is None else self.value(given, kind, owner, *at, reset=reset)

    def finish(
        self, item: Any, variation: VariationLowerer, kind: FieldType, origin: Origin, *, reset: bool | None = None
    ) -> Value:
        """Makes a value from a parsed item: known rows, or a drawn value."""
        reset = kind.reset if reset is None else reset
        if not reset:
            self.fix(variation)
        if item.__class__ not in NODE_TYPES:
            return literal(item, kind.dtype)
        if variation.broken:
            return literal(kind.fallback, kind.dtype)
        if not variation.is_random:
            return self._rows(item, variation, kind, origin)
        self.sampling.drawn = True
        value = self.make_drawn(partial(self.rows, node=item, kind=kind), lambda: self.analysis.bounds(item))
        if variation.risky:
            value = self.check_value(value, item, kind, origin)
        if reset:
            self.sampling.resets[id(value)] = ResettableValue(value, item, variation, self)
        return value

    def make_drawn(self, rows: RowMaker, bounds: Callable[[], ValueBounds] | None = None) -> Value:
        """Makes a value that is drawn on first access.

        Args:
            rows: computes its rows in a batch.
            bounds: gives its possible values; None: those of the samples.
        """
        return varying(lambda: rows(self.batch()), lambda: rows(self.analysis.samples), self.scenes, bounds=bounds)

    def check_value(self, value: Value, node: Node, kind: FieldType, origin: Origin) -> Value:
        """Draws a value and checks its rows and its samples.

        Returns:
            The value; a placeholder after an error; a value without samples after a warning, so that the rules do not
            find the same fault again.
        """
        self.sampling.drawn = True
        if self.sampling.sampling_operations.exhausted:
            return literal(kind.fallback, kind.dtype)
        check = ValueCheck(value, node, kind, self.scenes, origin)
        if not check_rows(check, self):
            return literal(kind.fallback, kind.dtype)
        return value if check_samples(check, self) else value.without_samples()

    def rows(self, batch: Batch, *, node: Node, kind: FieldType) -> NDArray[Any]:
        """The rows (B, …) of a node in a batch, in the format of the field.

        Raises:
            DrawError: it has no value in a scene, or one of another type.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        found = to_field_rows(batch.evaluate(node))
        if found.dtype.kind in _ARRAY_KINDS[kind.dtype] and found.shape[1:] == kind.shape:
            return found.astype(kind.dtype)
        types, words = _VALUE_TYPES[kind.dtype]
        for row, one in enumerate(found.tolist()):
            if not kind.shape and type(one) not in types:
                raise batch.error(f"this expression gives {cut(show(one))}, but {words} is needed", row, node)
        raise batch.error(f"this is not {_describe_type(kind)}", 0, node)

    def inside(self, scope: str) -> FieldLowerer:
        """The lowerer of a named object in another scope, over the same scenes. `per_scene` lists cover all scenes."""
        return self.sampling.fields(self.scenes, scope, self.sampling.all_scenes)

    def fix(self, variation: VariationLowerer) -> None:
        """Marks a field, and all shared draws that it reads, as fixed after the build."""
        self.sampling.fixed |= variation.reads

    def keep(self, node: Node, origin: Origin, reads: Iterable[str]) -> str:
        """Adds a shared draw that is fixed after the build, and returns its name.

        Args:
            node: of the value, which depends on the seed.
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
        """Fixes a value after the build if it may be infinite in some scene: the engine cannot change it later."""
        reset = self.sampling.resets.get(id(value))
        if reset is not None and holds_infinity(reset.node, self.sampling.draws):
            del self.sampling.resets[id(value)]
            self.fix(reset.variation)

    def _rows(self, node: Node, variation: VariationLowerer, kind: FieldType, origin: Origin) -> Value:
        """Makes a value with known rows from a node that depends only on the scene index."""
        rows = partial(self.rows, node=node, kind=kind)
        try:
            known = per_scene(rows(self.batch()), kind.dtype)
        except DrawError as error:
            report_draw_failure(error, origin, self.sampling)
            return literal(kind.fallback, kind.dtype)
        if variation.computed:
            check_rows(ValueCheck(known, node, kind, self.scenes, origin), self)
        if variation.cycled:
            # Also checks alternatives that no scene uses.
            found = self.analysis.bounds(node)
            if found.alternatives is None or len(found.alternatives) > len(known.bounds.alternatives or ()):
                return self.make_drawn(rows, lambda: found)
        return known

    def evaluate(self, node: Node) -> NDArray[Any]:
        """A node's rows in the scenes, in the format of the field.

        Raises:
            DrawError: it has no value in some scene.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        return to_field_rows(self.batch().evaluate(node))

    @property
    def analysis(self) -> BoundsAnalysis:
        """The bounds analysis for the scenes."""
        return self.sampling.analysis(self.scenes)

    def batch(self) -> Batch:
        """A batch of the scenes."""
        if self._batch is None:
            import numpy as np  # noqa: PLC0415 - checking a scene in which nothing varies needs none

            from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - see above

            scenes = np.array(self.scenes, dtype=np.int64)
            sampling = self.sampling
            self._batch = Batch(scenes, sampling.seed, sampling.num_scenes, sampling.draws, {}, sampling.computed)
            self._batch.placed = sampling.placed
        return self._batch

    def draw_names(self, template: Template, origin: Origin) -> dict[str, str] | None:
        """The shared draws that an expression reads, by name in the expression; None if one is unknown."""
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


def _describe_type(kind: FieldType) -> str:
    one = _VALUE_TYPES[kind.dtype][1]
    return f"a list of {kind.shape[0]} numbers" if kind.shape else one


_RECOMPUTATIONS = 4
"""How often a computed value may be recomputed."""


@dataclass(slots=True)
class SamplingContext:
    """The shared state of one document's values.

    Attributes:
        seed, num_scenes: of the batch.
        sink: receives the diagnostics.
        most: limit of operations.
        draws: the shared draws by full name; filled before anything reads them.
        unplaced: checks of values that depend on placements, with the lowerers of their objects.
        used: shared draws with at least one reader.
        fixed: shared draws with a reader that is fixed after the build.
        reads: shared draw → shared draws that it reads.
        scenes_of: shared draw → scenes in which it has a value.
        random: shared draws that depend on the seed, directly or through others.
        failed, warned: origins of the nodes without a value that were reported: in a scene, in a sample.
        limit_reported: whether an exceeded limit was reported.
        drawn: whether any value must be drawn.
        read: number of fields with forms or expressions.
        resets: values that a reset may change, by identity: node and variation.
        sampling_operations: operations of sampling and bounds analysis.
        placed: poses (num_scenes, 7) of placements, once they are made.
        computed: operations of the draw stage so far, including recomputations.
    """

    seed: int
    num_scenes: int
    sink: Sink
    most: int
    draws: dict[str, Node] = field(default_factory=dict[str, "Node"])
    unplaced: list[tuple[ValueCheck, FieldLowerer]] = field(default_factory=list[tuple[ValueCheck, FieldLowerer]])
    used: set[str] = field(default_factory=set[str])
    fixed: set[str] = field(default_factory=set[str])
    reads: dict[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    scenes_of: dict[str, tuple[int, ...]] = field(default_factory=dict[str, "tuple[int, ...]"])
    random: set[str] = field(default_factory=set[str])
    failed: set[Origin] = field(default_factory=set["Origin"])
    warned: set[Origin] = field(default_factory=set["Origin"])
    limit_reported: bool = False
    drawn: bool = False
    read: int = 0
    resets: dict[int, ResettableValue] = field(default_factory=dict[int, "ResettableValue"])
    all_scenes: tuple[int, ...] = ()
    placed: dict[str, NDArray[Any]] = field(default_factory=dict[str, "NDArray[Any]"])
    sampling_operations: OperationCounter = field(init=False)
    computed: OperationCounter = field(init=False)
    _analyses: dict[int, BoundsAnalysis] = field(default_factory=dict[int, "BoundsAnalysis"])
    _fields: dict[tuple[int, int, str], FieldLowerer] = field(default_factory=dict[tuple[int, int, str], FieldLowerer])

    def __post_init__(self) -> None:
        self.all_scenes = tuple(range(self.num_scenes))
        self.sampling_operations = OperationCounter(self.most)
        self.computed = OperationCounter(_RECOMPUTATIONS * self.most)

    def count_operations(self, operations: int, origin: Origin) -> None:
        """Counts operations of the draw stage, and reports when they exceed the limit."""
        within = not self.sampling_operations.exhausted
        self.sampling_operations.done += operations
        if within and self.sampling_operations.exhausted:
            self.report_limit(self.sampling_operations.message, origin)

    def report_limit(self, message: str, origin: Origin) -> None:
        """Reports that the operations exceed the limit, at the first place only."""
        if not self.limit_reported:
            self.limit_reported = True
            self.sink.report("SC604", message, origin, hint=COMPUTE_LIMIT_HINT)

    def analysis(self, scenes: tuple[int, ...] | None = None) -> BoundsAnalysis:
        """The bounds analysis for some scenes; None: all."""
        scenes = self.all_scenes if scenes is None else scenes
        # By identity, since objects share the tuples of their scenes. The analyses keep the tuples alive.
        found = self._analyses.get(id(scenes))
        if found is None:
            from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - loaded where something varies

            found = BoundsAnalysis(self.draws, {}, self.num_scenes, scenes, self.sampling_operations)
            self._analyses[id(scenes)] = found
        return found

    @property
    def varies(self) -> bool:
        """Whether any value is drawn."""
        return bool(self.draws or self.drawn)

    def add(self, name: str, node: Node, reads: frozenset[str]) -> None:
        """Adds a shared draw. `reads`: the draws that it reads, which must already be added."""
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
            scenes: of the object; None: all.
            scope: for its names.
            listed: the scenes of its `per_scene` lists, if not `scenes`.
        """
        scenes = self.all_scenes if scenes is None else scenes
        listed = scenes if listed is None else listed
        # By identity, since objects share the tuples of their scenes. The lowerers keep the tuples alive.
        key = (id(scenes), id(listed), scope)
        found = self._fields.get(key)
        if found is None:
            found = self._fields[key] = FieldLowerer(self, scenes, listed, scope)
        return found
