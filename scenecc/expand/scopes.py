"""One use of a module: the names, values and scenes that hold inside of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenecc.expand.run import Budget, Run

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.expand.compiled import CompiledModule
    from scenecc.expand.modules import Part
    from scenecc.expand.prefabs import Chain
    from scenecc.expand.scenes import Selection


@dataclass(slots=True)
class Scope:
    """One use of a module.

    Attributes:
        compiled: the module.
        name: full name of the instance; "" for the top.
        prefix: what stands before the names of its entities and frames.
        use: the `use`; None for the top.
        selection: the scenes that the instance is in.
        values: of parameters and constants.
        failed: parameters without a value, which was reported.
        chain: the modules that lead here, this one last.
        hidden: whether only people see what is inside.
    """

    compiled: CompiledModule
    name: str
    prefix: str
    use: Origin | None
    selection: Selection
    values: dict[str, Any]
    failed: frozenset[str]
    chain: Chain
    hidden: bool = False
    runs: dict[int, Run] = field(default_factory=dict[int, Run])

    def run(self, part: Part, objects: Budget, sink: Sink) -> Run:
        """The run of one of its documents."""
        run = self.runs.get(id(part))
        if run is None:
            parent = part.parent(self.use)
            run = Run(part.document.name, parent, self.values, objects, sink, self.failed)
            self.runs[id(part)] = run
        return run
