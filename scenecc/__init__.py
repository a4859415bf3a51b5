"""scenecc: a compiler for scenes in robot simulation.

A scene is a YAML file (or the same as a dict); it is checked, lowered to a plan and instantiated as a
batch of parallel SAPIEN scenes. Importing this loads neither an engine nor a mesh library.
"""

from __future__ import annotations

from scenecc.version import VERSION as __version__

TYPE_CHECKING = False  # that of `typing` takes its time, and the command hears signals once this is loaded
if TYPE_CHECKING:
    from scenecc.api import (
        ArticulationBatch,
        ArticulationState,
        Diagnostic,
        EntityBatch,
        EntityState,
        SceneBatch,
        SceneError,
        ScenePlan,
        SceneState,
        compile_scene,
        emit_scene,
        export_scene,
        load_scene,
        render_scene,
        validate,
    )
    from scenecc.questions import json_schema

__all__ = [
    "ArticulationBatch",
    "ArticulationState",
    "Diagnostic",
    "EntityBatch",
    "EntityState",
    "SceneBatch",
    "SceneError",
    "ScenePlan",
    "SceneState",
    "__version__",
    "compile_scene",
    "emit_scene",
    "export_scene",
    "json_schema",
    "load_scene",
    "render_scene",
    "validate",
]


def __getattr__(name: str) -> object:
    if name in __all__:
        from scenecc import api, questions

        return getattr(questions if name in questions.__all__ else api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
