"""The start check of `scenecc check` for the scenes on a page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.pipeline import build_batch
from scenecc.simulation.check import batch_findings, check_plan, origins_of
from scenecc.simulation.findings import report_findings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics import Diagnostic
    from scenecc.viewer.world import Loaded

_OVERLAPS = frozenset({"SC850", "SC851"})


@frozen
class SceneFindings:
    """Result of a check.

    Attributes:
        diagnostics: diagnostics, by line.
        overlapping: overlapping bodies, as (scene, ENTITY or ENTITY/LINK).
    """

    diagnostics: tuple[Diagnostic, ...]
    overlapping: frozenset[tuple[int, str]]


def check_start(loaded: Loaded, scene_idxs: Sequence[int]) -> SceneFindings:
    """Builds scenes again and checks their start, as `scenecc check` does without settling.

    Raises:
        SceneError: the engine or the machine failed.
    """
    sink = loaded.sink.another()
    check_plan(loaded.result, sink)
    with build_batch(loaded.plan, sink.another(), scene_idxs=scene_idxs, render=False, audit=True) as batch:
        found = [*batch_findings(batch, 0, set())]
    report_findings(found, origins_of(loaded.plan), None, sink, several_seeds=False)
    overlapping = {(one.scene, name) for one in found if one.code in _OVERLAPS for name in one.names}
    told = sorted(sink.diagnostics(), key=lambda one: (one.file or "", one.line or 0, one.column or 0))
    return SceneFindings(tuple(told), frozenset(overlapping))
