"""The public API: the pipeline from a source to diagnostics, a plan or live scenes, top to bottom.

This is the one place that raises `SceneError`; every stage below reports into a sink and stops.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.front import Compiled, Options, Source, compile_source, indices, select_scenes

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence
    from os import PathLike
    from pathlib import Path

    from scenecc.backends.sapien import EntityBatch, EntityState, SceneBatch, SceneState
    from scenecc.plan import ScenePlan
    from scenecc.summary import SummaryRow

__all__ = [
    "Build",
    "Diagnostic",
    "EntityBatch",
    "EntityState",
    "SceneBatch",
    "SceneError",
    "ScenePlan",
    "SceneState",
    "SummaryRow",
    "build_scene",
    "compile_scene",
    "emit_scene",
    "load_scene",
    "plan_text",
    "validate",
]

Backend = Literal["cpu", "cuda"]
Audit = Literal["full", "fast", "off"]


class SceneError(Exception):
    """A scene could not be compiled or built.

    Attributes:
        diagnostics: everything that was found, warnings included, in the order of the file.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = list(diagnostics)
        super().__init__(self.diagnostics)

    def __str__(self) -> str:
        from scenecc.diagnostics.render import render

        return "\n" + render(self.diagnostics)

    @property
    def at_fault(self) -> Literal["scene", "machine"]:
        """The scene, or the engine and the machine (codes SC8xx), which count first where both are."""
        return "machine" if any(d.severity == "error" and d.code[2] == "8" for d in self.diagnostics) else "scene"


def validate(
    source: Source,
    *,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> list[Diagnostic]:
    """Everything that can be found without an engine; empty for a scene without fault.

    Nothing is drawn, built or written, and a source's mistakes never raise.

    Args:
        source: a path, an open text or binary stream, a mapping (tuples, numpy values and paths accepted), a
            `ScenePlan`, or a plan's JSON (a path, a stream, or the text).
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: values of the file's parameters.
        draws: values of the file's shared draws, one row a scene.
        asset_roots: folders in which `asset://` is looked up, before those of `SCENECC_ASSET_PATH`.
        allow_outside_assets: let paths leave the scene's folder and the asset roots.
        limits: limits to raise or lower, by name; see `docs/language.md`.

    Raises:
        ValueError: an argument is out of its range.
        TypeError: the source is none of the above, or a number is no integer (Python's or numpy's, and no flag).
    """
    sink = Sink()
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    compile_source(source, options, sink, drawn=False)
    return sink.diagnostics()


def compile_scene(
    source: Source,
    *,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> ScenePlan:
    """The plan of a scene; no engine is started. Arguments are those of `validate`.

    Raises:
        SceneError: the scene is at fault.
    """
    sink = Sink()
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    return _compiled(source, options, sink).plan


def load_scene(
    source: Source,
    *,
    num_scenes: int | None = None,
    scene_idxs: Iterable[int] | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    backend: Backend = "cpu",
    render: bool | None = None,
    audit: Audit = "fast",
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> SceneBatch:
    """Builds a scene as parallel, live SAPIEN scenes. Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        num_scenes: in place of the file's.
        scene_idxs: which of the scenes to build, each as it is among all; every one by default.
        seed: in place of the file's.
        params: values of the file's parameters.
        draws: values of the file's shared draws.
        backend: where PhysX runs.
        render: build what is seen too; None: where a render device exists.
        audit: how much is read back from the engine and compared with the plan. "fast": shape count, mass and
            pose of every body, and everything in the first scene of each structure; "full": everything; "off".
        asset_roots: folders in which `asset://` is looked up.
        allow_outside_assets: let paths leave the scene's folder and the asset roots.
        limits: limits to raise or lower, by name.

    Raises:
        SceneError: the scene, the engine or the machine is at fault (`SceneError.at_fault`).
        ValueError: an argument is out of its range.
    """
    sink = Sink()
    if scene_idxs is not None:
        scene_idxs = indices(scene_idxs, "scene_idxs")
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    plan = _compiled(source, options, sink).plan
    return _instantiated(plan, sink, backend=backend, scene_idxs=scene_idxs, render=render, audit=audit)


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
    compiled = _compiled(source, options, sink)
    scene_idxs = None if scenes is None else select_scenes(scenes, compiled.plan.num_scenes, sink)
    if sink.failed:
        raise SceneError(sink.diagnostics())
    timings = dict(compiled.timings)
    batch = None
    if not dry_run:
        started = time.perf_counter()
        batch = _instantiated(
            compiled.plan, sink, backend=backend, scene_idxs=scene_idxs, render=render, audit=audit, progress=progress
        )
        timings["build"] = time.perf_counter() - started
    chosen = tuple(range(compiled.plan.num_scenes)) if scene_idxs is None else scene_idxs
    rows = summarize(compiled.plan, batch, scene_idxs)
    return Build(compiled.plan, batch, chosen, sink.diagnostics(), timings, rows)


def emit_scene(
    source: Source,
    target: str,
    *,
    base: Path | None = None,
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    found: list[Diagnostic] | None = None,
) -> str:
    """A scene as the text of another program's input: "python" or "json". Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        target: a key of `scenecc.emit.EMITTERS`.
        base: folder that the text will lie in, from which its relative paths then start; None: the scene's own.
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: as for `validate`.
        draws: as for `validate`.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.
        found: takes the warnings and notes of a scene that was written.

    Raises:
        SceneError: the scene is at fault, or cannot be written so.
        ValueError: there is no such target.
    """
    from scenecc.emit import EMITTERS
    from scenecc.emit import emit as write

    if target not in EMITTERS:
        raise ValueError(f"there is no target {target!r}; there are {', '.join(EMITTERS)}")
    sink = Sink()
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    text = write(_compiled(source, options, sink).plan, target, sink, base=base)
    if text is None:
        raise SceneError(sink.diagnostics())
    if found is not None:
        found += sink.diagnostics()
    return text


def plan_text(plan: ScenePlan, *, base: Path | None = None) -> str:
    """A compiled plan as JSON, without checking it or its files again. `base`: as for `emit_scene`."""
    from scenecc.plan.to_json import plan_to_json

    return plan_to_json(plan, base=base)


def _compiled(source: Source, options: Options, sink: Sink) -> Compiled:
    compiled = compile_source(source, options, sink)
    if compiled is None:
        raise SceneError(sink.diagnostics())
    return compiled


def _instantiated(
    plan: ScenePlan,
    sink: Sink,
    *,
    backend: Backend,
    scene_idxs: Sequence[int] | None,
    render: bool | None,
    audit: Audit,
    progress: Callable[[int, int], None] | None = None,
) -> SceneBatch:
    from scenecc.backends.sapien import instantiate

    for name, value, known in (("backend", backend, ("cpu", "cuda")), ("audit", audit, ("full", "fast", "off"))):
        if value not in known:
            raise ValueError(f"{name} is one of {', '.join(known)}, not {value!r}")
    batch = instantiate(
        plan, sink, device=backend, scene_idxs=scene_idxs, render=render, audit=audit, progress=progress
    )
    if batch is None:
        raise SceneError(sink.diagnostics())
    return batch


_IN = {
    **dict.fromkeys(("EntityBatch", "EntityState", "SceneBatch", "SceneState"), "backends.sapien"),
    "ScenePlan": "plan",
    "SummaryRow": "summary",
}
"""Folders of the classes below."""


def __getattr__(name: str) -> object:
    """Classes that load an engine or numpy, when somebody asks for them."""
    if name not in _IN:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"scenecc.{_IN[name]}"), name)
