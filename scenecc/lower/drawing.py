"""What the values of one document have in common while they are lowered."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenecc.lower.leaves import Leaves
from scenecc.variation.compute_limit import COMPUTE_LIMIT_HINT, OperationCounter
from scenecc.variation.nodes import Rows

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.arguments import Argument
    from scenecc.lower.doubts import Doubt
    from scenecc.lower.pending import Pending, Reset
    from scenecc.variation.node_bounds import BoundsAnalysis
    from scenecc.variation.nodes import Node

_AGAIN = 4
"""How often what is computed may be computed again."""


@dataclass(slots=True)
class Drawing:
    """What the values of one document have in common.

    Attributes:
        seed, num_scenes: of the batch.
        sink: takes the diagnostics.
        most: operations that its values may take (limit `computed`).
        draws: the shared draws by their full names; filled before anything reads them.
        pending: the values that the draw stage judges.
        arguments: what parameters are given that it judges.
        used: the shared draws that anything reads.
        fixed: those that something reads which stays as it is built.
        reads: for each shared draw, those that it reads.
        scenes_of: for each shared draw, the scenes that it has a value in.
        random: the shared draws that a seed decides, by themselves or through others.
        draw_origins: of the nodes in shared draws that can have no value, by identity.
        doubtful: the shared draws that may have no value in some scene.
        doubts: what is known of each expression, by all that it follows from.
        drawn: whether any value is to be drawn.
        read: how many fields with forms or expressions were read.
        resets: what a reset may change: its value by identity, its node, and what was read of it.
        foreseen: operations of the draw stage, and those that tell what it can give.
        computed: operations of the draw stage as they are done; some do again what others have done.
    """

    seed: int
    num_scenes: int
    sink: Sink
    most: int
    draws: dict[str, Node] = field(default_factory=dict[str, "Node"])
    pending: list[Pending] = field(default_factory=list["Pending"])
    arguments: list[Argument] = field(default_factory=list["Argument"])
    used: set[str] = field(default_factory=set[str])
    fixed: set[str] = field(default_factory=set[str])
    reads: dict[str, frozenset[str]] = field(default_factory=dict[str, frozenset[str]])
    scenes_of: dict[str, tuple[int, ...]] = field(default_factory=dict[str, "tuple[int, ...]"])
    random: set[str] = field(default_factory=set[str])
    draw_origins: dict[int, tuple[Any, Origin]] = field(default_factory=dict[int, "tuple[Any, Origin]"])
    doubtful: set[str] = field(default_factory=set[str])
    doubts: dict[tuple[Any, ...], tuple[Any, Doubt | None]] = field(default_factory=dict[Any, Any])
    drawn: bool = False
    read: int = 0
    resets: dict[int, Reset] = field(default_factory=dict[int, "Reset"])
    everywhere: tuple[int, ...] = ()
    foreseen: OperationCounter = field(init=False)
    computed: OperationCounter = field(init=False)
    _reader: BoundsAnalysis | None = None
    _leaves: dict[tuple[int, int, str], Leaves] = field(default_factory=dict[tuple[int, int, str], Leaves])

    def __post_init__(self) -> None:
        self.everywhere = tuple(range(self.num_scenes))
        self.foreseen = OperationCounter(self.most)
        self.computed = OperationCounter(_AGAIN * self.most)

    def foresee(self, operations: int, origin: Origin) -> None:
        """Counts what the draw stage will do; once that is too much, it is reported."""
        within = not self.foreseen.exhausted
        self.foreseen.done += operations
        if within and self.foreseen.exhausted:
            self.sink.report("SC609", self.foreseen.message, origin, hint=COMPUTE_LIMIT_HINT)

    def reader(self) -> BoundsAnalysis:
        """What tells supports, those of the shared draws once."""
        if self._reader is None:
            from scenecc.variation.node_bounds import BoundsAnalysis  # noqa: PLC0415 - loaded where something varies

            self._reader = BoundsAnalysis(self.draws, {}, self.num_scenes, self.foreseen)
        return self._reader

    @property
    def varies(self) -> bool:
        """Whether anything is to be drawn or judged by its rows."""
        return bool(self.draws or self.pending or self.drawn)

    def add(self, name: str, node: Node, reads: frozenset[str]) -> None:
        """Adds a shared draw. `reads`: those that it reads, all of which are there."""
        self.draws[name] = node
        self.reads[name] = reads
        found = node.scene_idxs if isinstance(node, Rows) else self.everywhere
        for other in reads:
            limits = self.scenes_of[other]
            if limits is not self.everywhere:
                found = limits if found is self.everywhere else tuple(sorted(set(found).intersection(limits)))
        self.scenes_of[name] = found

    def leaves(
        self, scenes: tuple[int, ...] | None = None, scope: str = "", listed: tuple[int, ...] | None = None
    ) -> Leaves:
        """The leaves of an object.

        Args:
            scenes: that it is in; None: all.
            scope: in which its names are looked up.
            listed: the scenes of its `per_scene` lists, where these are not `scenes`.
        """
        scenes = self.everywhere if scenes is None else scenes
        listed = scenes if listed is None else listed
        # By identity, since objects share the tuples of their scenes; the leaves keep them.
        key = (id(scenes), id(listed), scope)
        found = self._leaves.get(key)
        if found is None:
            found = self._leaves[key] = Leaves(self, scenes, listed, scope)
        return found
