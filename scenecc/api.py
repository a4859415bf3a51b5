"""The public API: the pipeline from a source to diagnostics, a plan or live scenes, top to bottom.

This is the one place that raises `SceneError`, beside a simulation that diverges; every stage below reports into a sink
and stops.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, overload

from scenecc.diagnostics import Diagnostic, SceneError, Sink
from scenecc.front import Audit, Backend, Options, Source, compile_source, compiled, indices, instantiated

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from os import PathLike
    from pathlib import Path

    from scenecc.backends.maniskill import LoadedScene, ManiSkillScene
    from scenecc.backends.sapien import (
        ArticulationBatch,
        ArticulationState,
        EntityBatch,
        EntityState,
        SceneBatch,
        SceneState,
    )
    from scenecc.building import Build, build_scene, inspect_scene
    from scenecc.exporting import export_scene
    from scenecc.plan import ScenePlan
    from scenecc.questions import emit_scene
    from scenecc.rendering import LegendRow, Picture, Rendering, render_scene
    from scenecc.summary import Item, SummaryRow
    from scenecc.viewing import Look, Place, export_page, view_scene

__all__ = [
    "ArticulationBatch",
    "ArticulationState",
    "Build",
    "Diagnostic",
    "EntityBatch",
    "EntityState",
    "Item",
    "LegendRow",
    "Look",
    "Picture",
    "Place",
    "Rendering",
    "SceneBatch",
    "SceneError",
    "ScenePlan",
    "SceneState",
    "SummaryRow",
    "build_scene",
    "compile_scene",
    "emit_scene",
    "export_page",
    "export_scene",
    "inspect_scene",
    "load_scene",
    "plan_text",
    "render_scene",
    "validate",
    "view_scene",
]


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
    return compiled(source, options, sink).plan


@overload
def load_scene(
    source: Source,
    *,
    scene: None = None,
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
) -> SceneBatch: ...


@overload
def load_scene(
    source: Source,
    *,
    scene: ManiSkillScene,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
) -> LoadedScene: ...


def load_scene(
    source: Source,
    *,
    scene: ManiSkillScene | None = None,
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
) -> SceneBatch | LoadedScene:
    """Builds a scene as parallel, live SAPIEN scenes. Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        scene: a ManiSkill environment's scene, to build into it in place of scenes of our own, one in each environment:
            `scenecc.maniskill.load_into`. Everything about the simulation is the environment's then.
        num_scenes: in place of the file's.
        scene_idxs: which of the scenes to build, each as it is among all; every one by default.
        seed: in place of the file's.
        params: values of the file's parameters.
        draws: values of the file's shared draws.
        backend: where PhysX runs.
        render: build what is seen too; None: where a render device exists.
        audit: how much is read back from the engine and compared with the plan. "fast": shape count, mass and
            pose of every body, every constraint, light and camera, and everything in the first scene of each structure;
            "full": everything; "off". Nothing is read back of what is built in an environment's `scene`.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault (`SceneError.at_fault`).
        TypeError: `scene` is no environment's.
        ValueError: an argument is out of its range, or is the environment's where there is a `scene`.
    """
    sink = Sink()
    if scene is not None:
        if (num_scenes, scene_idxs, backend, render, audit) != (None, None, "cpu", None, "fast"):
            raise ValueError("num_scenes, scene_idxs, backend, render and audit are not taken with scene")
        check_environments(scene)
        num_scenes = scene.num_envs
    scene_idxs = None if scene_idxs is None else indices(scene_idxs, "scene_idxs")
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    plan = compiled(source, options, sink).plan
    if scene is not None:
        return _into(scene, plan, sink)
    return instantiated(plan, sink, backend=backend, scene_idxs=scene_idxs, render=render, audit=audit)


def check_environments(scene: object) -> None:
    """Raises TypeError for what is no scene of a ManiSkill environment."""
    if not hasattr(scene, "sub_scenes"):
        what = "a scene of a ManiSkill environment is needed, its `env.unwrapped.scene`"
        alone = "`load_scene` without `scene` makes SAPIEN's scenes by itself"
        raise TypeError(f"{what}, and this is of the type {type(scene).__name__}; {alone}")


def plan_text(plan: ScenePlan, *, base: Path | None = None) -> str:
    """A compiled plan as JSON, without checking it or its files again. `base`: as for `emit_scene`."""
    from scenecc.plan.to_json import plan_to_json

    return plan_to_json(plan, base=base)


def _into(scene: ManiSkillScene, plan: ScenePlan, sink: Sink) -> LoadedScene:
    from scenecc.backends.maniskill import instantiate

    if (loaded := instantiate(plan, scene, sink)) is None:
        raise SceneError(sink.diagnostics())
    return loaded


_BATCHES = ("ArticulationBatch", "ArticulationState", "EntityBatch", "EntityState", "SceneBatch", "SceneState")

_IN = {
    **dict.fromkeys(("Build", "build_scene", "inspect_scene"), "building"),
    **dict.fromkeys(("Look", "Place", "export_page", "view_scene"), "viewing"),
    **dict.fromkeys(("LegendRow", "Picture", "Rendering", "render_scene"), "rendering"),
    "emit_scene": "questions",
    "export_scene": "exporting",
    **dict.fromkeys(_BATCHES, "backends.sapien"),
    "ScenePlan": "plan",
    **dict.fromkeys(("Item", "SummaryRow"), "summary"),
}
"""Where the names are that are loaded when somebody asks for them."""


def __getattr__(name: str) -> object:
    """Classes that load an engine or numpy, and what only some need."""
    if name not in _IN:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"scenecc.{_IN[name]}"), name)
