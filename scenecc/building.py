"""As `scenecc.load_scene`, with what a person wants to read about it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Diagnostic, SceneError, Sink
from scenecc.front import Options, Source, compiled, instantiated, select_scenes
from scenecc.front.options import integer

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from os import PathLike

    from scenecc.backends.sapien import SceneBatch
    from scenecc.front import Audit, Backend, Compiled
    from scenecc.plan import Entity, ScenePlan
    from scenecc.summary import Item, SummaryRow
    from scenecc.summary.bodies import Made

__all__ = ["Build", "build_scene", "inspect_scene"]


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


def inspect_scene(
    source: Source,
    *,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    scene: int | None = None,
    entity: str | None = None,
    depth: int | None = None,
    build: bool = True,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    found: list[Diagnostic] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Item:
    """Everything that is said of a scene, as a tree; `scenecc inspect` prints this. Other arguments: as `validate`.

    Args:
        source: as for `validate`.
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: as for `validate`.
        draws: as for `validate`.
        scene: the one that is told; None: what all of them can be.
        entity: the name of an entity, or a pattern of names (`*`, `?`, `[…]`): nothing else is told.
        depth: how far below the scene the tree goes; None: to its end.
        build: ask the engine for masses, and for sizes of meshes and articulations, in `scene` or else in the first
            scene that each entity is in. No render device is needed. Otherwise they are told where the file says them.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.
        found: takes the warnings and notes.
        progress: called with (scenes done, scenes in all) while the engine builds.

    Raises:
        SceneError: the scene, the engine or the machine is at fault; there is no such scene or entity.
        ValueError: an argument is out of its range.
    """
    from scenecc.front.listing import compiled_params
    from scenecc.summary.inspection import entities_item, scene_item

    sink = Sink()
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    done = compiled(source, options, sink)
    plan = done.plan
    chosen = _chosen(plan, scene, entity, sink)
    made = _made(plan, chosen, scene, sink, progress) if build and chosen else {}
    if entity is not None:
        item = entities_item(chosen, plan, scene=scene, made=made)
    else:
        listed, files = compiled_params(done, options.limits), _files(done)
        item = scene_item(plan, scene=scene, made=made, params=listed, given=params, files=files)
    if found is not None:
        found += sink.diagnostics()
    return item if depth is None else item.cut(depth)


def _chosen(plan: ScenePlan, scene: int | None, entity: str | None, sink: Sink) -> list[Entity]:
    """The entities that are told. Raises SceneError where what was asked for is not there."""
    from scenecc.diagnostics import Location
    from scenecc.diagnostics.words import cut, suggest
    from scenecc.summary.inspection import matching

    if scene is not None:
        select_scenes(str(integer(scene, "scene", 0)), plan.num_scenes, sink, "--scene")
        if sink.failed:
            raise SceneError(sink.diagnostics())
    chosen = matching(plan, entity, scene)
    if entity is not None and not chosen:
        where = "" if scene is None else f" in scene {scene}"
        hint = suggest(entity, [one.name for one in matching(plan, None, scene)])
        sink.report("SC910", f"no entity{where} is called `{cut(entity)}`", Location("--entity"), hint=hint)
        raise SceneError(sink.diagnostics())
    return chosen


def _made(
    plan: ScenePlan,
    entities: list[Entity],
    scene: int | None,
    sink: Sink,
    progress: Callable[[int, int], None] | None,
) -> dict[str, Made]:
    """Some entities as the engine has them, by name."""
    from scenecc.backends.sapien.measure import measure

    first = {one.name: one.scene_idxs[0] if scene is None else scene for one in entities}
    idxs = sorted({*first.values()})
    with instantiated(
        plan, sink, backend="cpu", scene_idxs=idxs, render=False, audit="off", progress=progress
    ) as batch:
        measured = measure(batch)
    return {
        one.entity.name: (at.index, one)
        for at in measured.scenes
        for one in at.entities
        if first.get(one.entity.name) == at.index
    }


def _files(done: Compiled) -> tuple[Item, ...]:
    from scenecc.summary.used_files import file_items

    document = done.document
    top = (document.name, document.path) if document is not None and document.name and document.path else None
    return file_items(done.plan, top, done.scope.memory.named)
