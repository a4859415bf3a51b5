"""As `scenecc.load_scene`, with what a person wants to read about it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.api import SceneError, compiled, instantiated
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.front import Options, Source, select_scenes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from os import PathLike

    from scenecc.api import Audit, Backend
    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan
    from scenecc.summary import SummaryRow

__all__ = ["Build", "build_scene"]


@dataclass(frozen=True, slots=True)
class Build:
    """A scene that was built, and how.

    Attributes:
        plan: what was asked of the engine.
        batch: the live scenes; None after a dry run.
        scene_idxs: the scenes that were asked for.
        diagnostics: warnings and notes.
        timings: stage → seconds, in order.
        summary: a row an entity, in build order.
    """

    plan: ScenePlan
    batch: SceneBatch | None
    scene_idxs: tuple[int, ...]
    diagnostics: list[Diagnostic]
    timings: dict[str, float]
    summary: list[SummaryRow]


def build_scene(
    source: Source,
    *,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    scenes: str | None = None,
    backend: Backend = "cpu",
    dry_run: bool = False,
    render: bool | None = None,
    audit: Audit = "fast",
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Build:
    """As `load_scene`, with what a person wants to read about it; `scenecc build` prints this.

    Args:
        source: as for `validate`.
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: as for `validate`.
        draws: as for `validate`.
        scenes: which to build, as `scene_idxs` of a file: `0:4`, `::2`, `0,2`; all by default.
        backend: where PhysX runs.
        dry_run: compile only; no engine is started.
        render: as for `load_scene`.
        audit: as for `load_scene`.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.
        progress: called with (scenes done, scenes in all) while the engine builds.

    Raises:
        SceneError: the scene, the engine or the machine is at fault.
    """
    from scenecc.summary import summarize

    sink = Sink()
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    found = compiled(source, options, sink)
    scene_idxs = None if scenes is None else select_scenes(scenes, found.plan.num_scenes, sink)
    if sink.failed:
        raise SceneError(sink.diagnostics())
    timings = dict(found.timings)
    batch = None
    if not dry_run:
        started = time.perf_counter()
        batch = instantiated(
            found.plan, sink, backend=backend, scene_idxs=scene_idxs, render=render, audit=audit, progress=progress
        )
        timings["build"] = time.perf_counter() - started
    chosen = tuple(range(found.plan.num_scenes)) if scene_idxs is None else scene_idxs
    rows = summarize(found.plan, batch, scene_idxs)
    return Build(found.plan, batch, chosen, sink.diagnostics(), timings, rows)
