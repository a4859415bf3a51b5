"""scenecc: a compiler for scenes in robot simulation.

A scene is a YAML file or the equivalent dict. It is checked, lowered to a plan and instantiated as a batch of parallel
SAPIEN scenes. Importing this package loads neither an engine nor a mesh library.
"""

from __future__ import annotations

from scenecc.version import VERSION as __version__

TYPE_CHECKING = False  # importing that of `typing` delays the handling of signals
if TYPE_CHECKING:
    from scenecc.backends.sapien import ArticulationBatch as ArticulationBatch
    from scenecc.backends.sapien import ArticulationState as ArticulationState
    from scenecc.backends.sapien import EntityBatch as EntityBatch
    from scenecc.backends.sapien import EntityState as EntityState
    from scenecc.backends.sapien import SceneBatch as SceneBatch
    from scenecc.backends.sapien import SceneState as SceneState
    from scenecc.coverage.cover import MissedPair as MissedPair
    from scenecc.coverage.cover import SceneCover as SceneCover
    from scenecc.coverage.cover import cover_scene as cover_scene
    from scenecc.coverage.coverage import SceneCoverage as SceneCoverage
    from scenecc.coverage.coverage import scene_coverage as scene_coverage
    from scenecc.decompiler.decompile import Decompiled as Decompiled
    from scenecc.decompiler.decompile import decompile as decompile
    from scenecc.decompiler.record import Recording as Recording
    from scenecc.decompiler.record import record as record
    from scenecc.diagnostics import Diagnostic as Diagnostic
    from scenecc.drawn_values import SceneDraws as SceneDraws
    from scenecc.errors import SceneError as SceneError
    from scenecc.expand.listing import ParamRow as ParamRow
    from scenecc.expand.listing import PrefabRow as PrefabRow
    from scenecc.export import Emitted as Emitted
    from scenecc.importers.import_scene import Imported as Imported
    from scenecc.importers.import_scene import import_scene as import_scene
    from scenecc.inspect import Item as Item
    from scenecc.inspect.entities import SummaryRow as SummaryRow
    from scenecc.inspect.inspection import Inspection as Inspection
    from scenecc.options import CompileOptions as CompileOptions
    from scenecc.pack import Packed as Packed
    from scenecc.pack import pack_scene as pack_scene
    from scenecc.passports import replay as replay
    from scenecc.plan import ScenePlan as ScenePlan
    from scenecc.plan.diff import Difference as Difference
    from scenecc.render import render_scene as render_scene
    from scenecc.render.render import LegendRow as LegendRow
    from scenecc.render.render import Picture as Picture
    from scenecc.render.render import Rendering as Rendering
    from scenecc.scene import Build as Build
    from scenecc.scene import Comparison as Comparison
    from scenecc.scene import Scene as Scene
    from scenecc.scene import build_scene as build_scene
    from scenecc.scene import compare_scenes as compare_scenes
    from scenecc.scene import compile_scene as compile_scene
    from scenecc.scene import emit_scene as emit_scene
    from scenecc.scene import export_page as export_page
    from scenecc.scene import export_scene as export_scene
    from scenecc.scene import inspect_scene as inspect_scene
    from scenecc.scene import json_schema as json_schema
    from scenecc.scene import list_params as list_params
    from scenecc.scene import list_prefabs as list_prefabs
    from scenecc.scene import load_scene as load_scene
    from scenecc.scene import open_scene as open_scene
    from scenecc.scene import plan_text as plan_text
    from scenecc.scene import scene_draws as scene_draws
    from scenecc.scene import validate as validate
    from scenecc.scene_file.patch import Patched as Patched
    from scenecc.scene_file.patch import patch_scene as patch_scene
    from scenecc.simulation.check import check_scene as check_scene
    from scenecc.simulation.description import SceneDescription as SceneDescription
    from scenecc.simulation.description import describe_scene as describe_scene
    from scenecc.simulation.freeze import SettledScenes as SettledScenes
    from scenecc.simulation.freeze import settle_scene as settle_scene
    from scenecc.sweeps.sweep import Sweep as Sweep
    from scenecc.sweeps.sweep import sweep as sweep
    from scenecc.viewer import PageAddress as PageAddress
    from scenecc.viewer import ScenePage as ScenePage
    from scenecc.viewer import ViewOptions as ViewOptions
    from scenecc.viewer import view_scene as view_scene

_MODULES = {
    "backends.sapien": (
        "ArticulationBatch",
        "ArticulationState",
        "EntityBatch",
        "EntityState",
        "SceneBatch",
        "SceneState",
    ),
    "coverage.cover": ("MissedPair", "SceneCover", "cover_scene"),
    "coverage.coverage": ("SceneCoverage", "scene_coverage"),
    "decompiler.decompile": ("Decompiled", "decompile"),
    "decompiler.record": ("Recording", "record"),
    "diagnostics": ("Diagnostic",),
    "drawn_values": ("SceneDraws",),
    "errors": ("SceneError",),
    "expand.listing": ("ParamRow", "PrefabRow"),
    "export": ("Emitted",),
    "importers.import_scene": ("Imported", "import_scene"),
    "options": ("CompileOptions",),
    "pack": ("Packed", "pack_scene"),
    "plan": ("ScenePlan",),
    "plan.diff": ("Difference",),
    "render": ("LegendRow", "Picture", "Rendering", "render_scene"),
    "passports": ("replay",),
    "scene": (
        "Build",
        "Comparison",
        "Scene",
        "build_scene",
        "compare_scenes",
        "compile_scene",
        "emit_scene",
        "export_page",
        "export_scene",
        "inspect_scene",
        "json_schema",
        "list_params",
        "list_prefabs",
        "load_scene",
        "open_scene",
        "plan_text",
        "scene_draws",
        "validate",
    ),
    "scene_file.patch": ("Patched", "patch_scene"),
    "simulation.check": ("check_scene",),
    "simulation.description": ("SceneDescription", "describe_scene"),
    "simulation.freeze": ("SettledScenes", "settle_scene"),
    "sweeps.sweep": ("Sweep", "sweep"),
    "inspect": ("Item", "SummaryRow"),
    "inspect.inspection": ("Inspection",),
    "viewer": ("PageAddress", "ScenePage", "ViewOptions", "view_scene"),
}
"""The public names by module. A module is loaded when one of its names is first used."""

_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [*sorted(_HOME), "__version__"]  # noqa: PLE0604  # pyright: ignore[reportUnsupportedDunderAll]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return __all__
