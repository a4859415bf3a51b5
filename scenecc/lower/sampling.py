"""The shared state of a document's values, and the scenes and names of each object's fields."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin, dotted
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.plan.scene import is_unnamed_draw, kept_draw_name
from scenecc.variation.nodes import BUILTIN_NAMES, Node, Rows
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, OperationCounter

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.lower.variation import ResettableValue, Variation
    from scenecc.variation.chosen import DrawRecord
    from scenecc.variation.evaluation import Batch
    from scenecc.variation.forms import Template
    from scenecc.variation.node_bounds import BoundsAnalysis

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
        unplaced: checks of values that depend on placements.
        used: shared draws with at least one reader.
        fixed: shared draws with a reader that is fixed after the build.
        reads: shared draw → shared draws that it reads.
        scenes_of: shared draw → scenes in which it has a value.
        random: shared draws that depend on the seed, directly or through others.
        rejected: shared draws that are invalid arguments, whose readers report nothing.
        failed, warned: origins of the nodes without a value that were reported: in a scene, in a sample.
        drawn: whether any value must be drawn.
        limited: whether an exceeded limit of operations was reported.
        read: number of fields with forms or expressions.
        resets: values that a reset may change, by identity.
        sampling_operations: operations of sampling and bounds analysis.
        placed: poses (num_scenes, 7) of placements, once they are made.
        record: chosen numbers, and what the file draws; None: not asked for.
        computed: operations of this seed's rows so far, including recomputations.
    """

    seed: int
    num_scenes: int
    sink: Sink
    most: int
    record: DrawRecord | None = None
    draws: dict[str, Node] = field(default_factory=dict[str, "Node"])
    unplaced: list[Callable[[], bool]] = field(default_factory=list["Callable[[], bool]"])
    used: set[str] = field(default_factory=set[str])
    fixed: set[str] = field(default_factory=set[str])
    reads: dict[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    scenes_of: dict[str, tuple[int, ...]] = field(default_factory=dict[str, "tuple[int, ...]"])
    random: set[str] = field(default_factory=set[str])
    rejected: set[str] = field(default_factory=set[str])
    failed: set[Origin] = field(default_factory=set["Origin"])
    warned: set[Origin] = field(default_factory=set["Origin"])
    drawn: bool = False
    limited: bool = False
    read: int = 0
    resets: dict[int, ResettableValue] = field(default_factory=dict[int, "ResettableValue"])
    all_scenes: tuple[int, ...] = ()
    placed: dict[str, NDArray[Any]] = field(default_factory=dict[str, "NDArray[Any]"])
    sampling_operations: OperationCounter = field(init=False)
    computed: OperationCounter = field(init=False)
    _analyses: dict[int, BoundsAnalysis] = field(default_factory=dict[int, "BoundsAnalysis"])
    _batches: dict[int, tuple[tuple[int, ...], Batch]] = field(
        default_factory=dict[int, "tuple[tuple[int, ...], Batch]"]
    )

    def __post_init__(self) -> None:
        self.all_scenes = tuple(range(self.num_scenes))
        if self.record is not None:
            self.record.draws, self.record.num_scenes = self.draws, self.num_scenes
        self.sampling_operations = OperationCounter(self.most)
        self.computed = OperationCounter(_RECOMPUTATIONS * self.most)

    def count_operations(self, operations: int, origin: Origin) -> None:
        """Counts operations of a form or an expression, and reports when they exceed the limit."""
        self.sampling_operations.done += operations
        if self.sampling_operations.exhausted:
            self.report_limit(self.sampling_operations.message, origin)

    def report_limit(self, message: str, origin: Origin) -> None:
        """Reports that the operations exceed the limit, at the first place only: each later value exceeds it too."""
        if not self.limited:
            self.limited = True
            self.sink.report("SC604", message, origin, hint=COMPUTE_LIMIT_HINT)

    def analysis(self, scenes: tuple[int, ...] | None = None) -> BoundsAnalysis:
        """The bounds analysis for some scenes; None: all."""
        scenes = self.all_scenes if scenes is None else scenes
        # By identity, since objects share the tuples of their scenes. The analyses keep the tuples alive.
        found = self._analyses.get(id(scenes))
        if found is None:
            from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - loaded where something varies

            found = BoundsAnalysis(self.draws, self.num_scenes, scenes, self.sampling_operations)
            self._analyses[id(scenes)] = found
        return found

    def batch(self, scenes: tuple[int, ...] | None = None) -> Batch:
        """A batch of some scenes; None: all."""
        scenes = self.all_scenes if scenes is None else scenes
        if id(scenes) not in self._batches:
            import numpy as np  # noqa: PLC0415 - checking a scene in which nothing varies needs none

            from scenecc.variation.evaluation import Batch  # noqa: PLC0415 - see above

            made = Batch(np.array(scenes, np.int64), self.seed, self.num_scenes, self.draws, {}, self.computed)
            made.placed = self.placed
            # Keeping the scenes keeps their id unique.
            self._batches[id(scenes)] = scenes, made
        return self._batches[id(scenes)][1]

    def fix(self, variation: Variation) -> None:
        """Marks all shared draws that a field reads as fixed after the build."""
        self.fixed |= variation.reads

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


class FieldScope:
    """The scenes and the names of an object's fields.

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

    def batch(self) -> Batch:
        """A batch of the scenes."""
        return self.sampling.batch(self.scenes)

    @property
    def analysis(self) -> BoundsAnalysis:
        """The bounds analysis for the scenes."""
        return self.sampling.analysis(self.scenes)

    def evaluate(self, node: Node) -> NDArray[Any]:
        """A node's rows in the scenes, in the format of the field.

        Raises:
            DrawError: it has no value in some scene.
        """
        from scenecc.variation.evaluation import to_field_rows  # noqa: PLC0415 - loads numpy

        return to_field_rows(self.batch().evaluate(node))

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
