"""The parameters of what was compiled; a plan has none any more."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics import Sink
from scenecc.expand.documents import scene_loader
from scenecc.expand.listing import list_params

if TYPE_CHECKING:
    from scenecc.expand.listing import ParamRow
    from scenecc.front.compile import Compiled
    from scenecc.source import Limits


def compiled_params(done: Compiled, limits: Limits) -> list[ParamRow]:
    """The parameters of a scene that was compiled, in order; none of a plan."""
    if done.document is None or not done.document.data:
        return []
    load, sink = scene_loader(done.scope, limits, Sink()), Sink()
    found = list_params(done.document, load=load, limits=limits, sink=sink)
    assert found is not None, "what was compiled has parameters that can be listed"
    return found
