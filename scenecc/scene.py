"""The public functions over a scene: check it, compile it, build it, compare it, list its parameters.

Stages below report into a sink and stop; here, and where a simulation diverges, `SceneError` is raised.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, indices
from scenecc.pipeline import (
    Audit,
    Backend,
    Source,
    as_plan,
    compile_source,
    compiled,
    instantiated,
    read_input,
    select_scenes,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping
    from os import PathLike
    from pathlib import Path

    from scenecc.backends.maniskill import ManiSkillScene
    from scenecc.backends.maniskill.loaded_scene import LoadedScene
    from scenecc.backends.sapien import SceneBatch
    from scenecc.expand.listing import ParamRow, PrefabRow
    from scenecc.inspect import SummaryRow
    from scenecc.plan import ScenePlan
    from scenecc.plan.diff import Difference


def validate(
    source: Source,
    **options: Unpack[CompileOptions],
) -> list[Diagnostic]:
    """Everything that can be found without an engine; empty for a scene without fault.

    Nothing is drawn, built or written, and a source's mistakes never raise.

    Args:
        source: a path, an open text or binary stream, a mapping (tuples, numpy values and paths accepted), a
            `ScenePlan`, or a plan's JSON (a path, a stream, or the text).
        options: those of `CompileOptions`.

    Raises:
        ValueError: an argument is out of its range.
        TypeError: the source is none of the above, or a number is no integer (Python's or numpy's, and no flag).
    """
    sink = Sink()
    asked = Options.of(**options)
    compile_source(source, asked, sink, drawn=False)
    return sink.diagnostics()


def compile_scene(
    source: Source,
    **options: Unpack[CompileOptions],
) -> ScenePlan:
    """The plan of a scene; no engine is started. Arguments are those of `validate`.

    Raises:
        SceneError: the scene is at fault.
    """
    sink = Sink()
    asked = Options.of(**options)
    return compiled(source, asked, sink).plan


@overload
def load_scene(
    source: Source,
    *,
    scene: None = None,
    scene_idxs: Iterable[int] | None = None,
    backend: Backend = "cpu",
    render: bool | None = None,
    audit: Audit = "fast",
    **options: Unpack[CompileOptions],
) -> SceneBatch: ...


@overload
def load_scene(
    source: Source,
    *,
    scene: ManiSkillScene,
    **options: Unpack[CompileOptions],
) -> LoadedScene: ...


def load_scene(
    source: Source,
    *,
    scene: ManiSkillScene | None = None,
    scene_idxs: Iterable[int] | None = None,
    backend: Backend = "cpu",
    render: bool | None = None,
    audit: Audit = "fast",
    **options: Unpack[CompileOptions],
) -> SceneBatch | LoadedScene:
    """Builds a scene as parallel, live SAPIEN scenes. Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        scene: a ManiSkill environment's scene, to build into it in place of scenes of our own, one in each environment:
            `scenecc.maniskill.load_into`. Everything about the simulation is the environment's then.
        scene_idxs: which of the scenes to build, each as it is among all; every one by default.
        backend: where PhysX runs.
        render: build what is seen too; None: where a render device exists.
        audit: how much is read back from the engine and compared with the plan. "fast": shape count, mass and
            pose of every body, every constraint, light and camera, and everything in the first scene of each structure;
            "full": everything; "off". Nothing is read back of what is built in an environment's `scene`.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault (`SceneError.at_fault`).
        TypeError: `scene` is no environment's.
        ValueError: an argument is out of its range, or is the environment's where there is a `scene`.
    """
    sink = Sink()
    if scene is not None:
        given = (options.get("num_scenes"), scene_idxs, backend, render, audit)
        if given != (None, None, "cpu", None, "fast"):
            raise ValueError("num_scenes, scene_idxs, backend, render and audit are not taken with scene")
        check_environments(scene)
        options["num_scenes"] = scene.num_envs
    scene_idxs = None if scene_idxs is None else indices(scene_idxs, "scene_idxs")
    asked = Options.of(**options)
    plan = compiled(source, asked, sink).plan
    if scene is not None:
        return _into(scene, plan, sink)
    return instantiated(plan, sink, backend=backend, scene_idxs=scene_idxs, render=render, audit=audit)


def _into(scene: ManiSkillScene, plan: ScenePlan, sink: Sink) -> LoadedScene:
    from scenecc.backends.maniskill import instantiate

    if (loaded := instantiate(plan, scene, sink)) is None:
        raise SceneError(sink.diagnostics())
    return loaded


def check_environments(scene: object) -> None:
    """Raises TypeError for what is no scene of a ManiSkill environment."""
    if not hasattr(scene, "sub_scenes"):
        what = "a scene of a ManiSkill environment is needed, its `env.unwrapped.scene`"
        alone = "`load_scene` without `scene` makes SAPIEN's scenes by itself"
        raise TypeError(f"{what}, and this is of the type {type(scene).__name__}; {alone}")


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
    scenes: str | None = None,
    backend: Backend = "cpu",
    dry_run: bool = False,
    render: bool | None = None,
    audit: Audit = "fast",
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> Build:
    """As `load_scene`, with what a person wants to read about it; `scenecc build` prints this.

    Args:
        source: as for `validate`.
        scenes: which to build, as `scene_idxs` of a file: `0:4`, `::2`, `0,2`; all by default.
        backend: where PhysX runs.
        dry_run: compile only; no engine is started.
        render: as for `load_scene`.
        audit: as for `load_scene`.
        progress: called with (scenes done, scenes in all) while the engine builds.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault.
    """
    from scenecc.inspect import summarize

    sink = Sink()
    asked = Options.of(**options)
    found = compiled(source, asked, sink)
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


def compare_scenes(
    a: Source,
    b: Source,
    *,
    found: list[Diagnostic] | None = None,
    **options: Unpack[CompileOptions],
) -> list[Difference]:
    """Everything in which two scenes differ, by their plans; empty where they are the same.

    A name that follows from a file's is no difference. Arguments are those of `validate`, for both scenes.

    Args:
        a: the first scene.
        b: the second one.
        found: takes the warnings and notes of both.
        options: those of `CompileOptions`.

    Raises:
        SceneError: one of them, or each, is at fault.
    """
    from scenecc.plan.diff import diff_plans

    asked = Options.of(**options)
    sinks = Sink(), Sink()
    compiled = [compile_source(source, asked, sink) for source, sink in zip((a, b), sinks, strict=True)]
    diagnostics = [diagnostic for sink in sinks for diagnostic in sink.diagnostics()]
    first, second = compiled
    if first is None or second is None:
        raise SceneError(diagnostics)
    if found is not None:
        found += diagnostics
    unnamed = [_stem(source) == done.plan.name for source, done in ((a, first), (b, second))]
    return [one for one in diff_plans(first.plan, second.plan) if not (one.path == "name" and all(unnamed))]


def _stem(source: Source) -> str:
    """The name of a scene that says none."""
    from os import PathLike
    from pathlib import Path

    return Path(source).stem if isinstance(source, str | PathLike) else "scene"


def list_params(
    source: Source,
    *,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> list[ParamRow]:
    """The parameters of a scene and of what it includes, in order. Arguments are those of `validate`.

    Nothing but the files of the language is looked at; a plan has no parameters any more.

    Raises:
        SceneError: one of these files is at fault.
    """
    from scenecc.expand.documents import scene_loader
    from scenecc.expand.listing import list_params as listed
    from scenecc.source.paths import AssetScope

    if as_plan(source) is not None:
        return []
    sink = Sink()
    options = Options.of(asset_roots=asset_roots, allow_outside_assets=allow_outside_assets, limits=limits)
    found = read_input(source, options.limits, sink)
    if found is not None and found.plan_text is not None:
        return []
    params: list[ParamRow] | None = None
    if found is not None and not sink.failed:
        document = found.document
        root = document.path.parent if document.path else None
        scope = AssetScope(root, options.asset_roots, options.allow_outside_assets)
        load = scene_loader(scope, options.limits, sink)
        params = listed(document, load=load, limits=options.limits, sink=sink)
    if params is None:
        raise SceneError(sink.diagnostics())
    return params


def list_prefabs() -> list[PrefabRow]:
    """The prefabs that ship with the package, by name."""
    from scenecc.expand.listing import list_prefabs as listed

    return listed()


def json_schema() -> dict[str, Any]:
    """The JSON Schema of scene files, for editors."""
    from scenecc.spec.json_schema import json_schema as schema

    return schema()


def plan_text(plan: ScenePlan, *, base: Path | None = None) -> str:
    """A compiled plan as JSON, without checking it or its files again. `base`: as for `emit_scene`."""
    from scenecc.plan.json_writer import plan_to_json

    return plan_to_json(plan, base=base)
