"""Emits a plan as text or as files for other programs: one module per target, imported on demand.

Text targets need only the plan. File targets hold values that only an engine knows (masses, convex hulls, link
poses), so they are written from a plan and from measurements of its build.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.json_codec import plan_to_json

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot


Show = Literal["visual", "collision"]


@frozen
class ExportOptions:
    """How to write the measured scenes.

    Attributes:
        name: of the file, without its suffix. Meshes and images are in the folder `NAME.assets` next to it.
        show: show visual or collision shapes.
        grid: write all measured scenes side by side, instead of only one.
        entity: name of the entity to write. None: all.
        folder: write one file per entity, named after it.
        binary: write the binary variant of the format.
        max_triangles: simplify visual meshes from files that have more triangles. None: none.
    """

    name: str
    show: Show = "visual"
    grid: bool = False
    entity: str | None = None
    folder: bool = False
    binary: bool = False
    max_triangles: int | None = None


def _emit_json(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    """Returns canonical JSON. Every plan can be written."""
    del sink
    return plan_to_json(plan, base=base)


def _emit_python(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    text: str | None = import_module("scenecc.emit.python").write(plan, sink, base)
    return text


EMITTERS: dict[str, Callable[[ScenePlan, Sink, Path | None], str | None]] = {
    "json": _emit_json,
    "python": _emit_python,
}
"""Text target → the function that writes it."""


@frozen
class ExportTarget:
    """A file format of another program.

    Attributes:
        module: its `write(plan, measured, options, sink)` returns the files, or None after an error.
        suffix: of the file.
        takes: fields of `ExportOptions` that it uses, besides `name`.
        needs: a module that every file requires, and the package of the extra `export` that provides it. None: only
            some scenes need one.
    """

    module: str
    suffix: str
    takes: frozenset[str] = frozenset()
    needs: tuple[str, str] | None = None


EXPORTS: dict[str, ExportTarget] = {
    "glb": ExportTarget("scenecc.emit.glb", ".glb", frozenset({"show", "grid"})),
    "mjcf": ExportTarget("scenecc.emit.mjcf", ".xml"),
    "urdf": ExportTarget("scenecc.emit.urdf", ".urdf", frozenset({"entity", "folder"})),
    "usd": ExportTarget("scenecc.emit.usd", ".usda", frozenset({"show", "binary"}), ("pxr.Usd", "usd-core")),
}
"""Target name → its format."""


def emit(plan: ScenePlan, target: str, sink: Sink, *, base: Path | None = None) -> str | None:
    """Returns the plan as text, or None after an error, which is reported to `sink`.

    Args:
        plan: what to write.
        target: a key of `EMITTERS`.
        sink: receives diagnostics.
        base: folder in which the text will be saved; relative URIs then start there. None: they stay as they are.

    Raises:
        KeyError: there is no such target.
    """
    return EMITTERS[target](plan, sink, base)


def export(
    plan: ScenePlan, measured: EngineSnapshot, target: str, options: ExportOptions, sink: Sink
) -> dict[str, bytes] | None:
    """Returns the exported files by their paths relative to the output folder, or None after an error.

    The first is the file itself, `NAME` with the target's suffix. The files that it refers to are in `NAME.assets`.
    With `folder`, there is one such file per entity.

    Args:
        plan: what to write.
        measured: snapshot of the built plan: the scene to write, or all scenes of a grid.
        target: a key of `EXPORTS`.
        options: how to write it.
        sink: receives a warning for every feature that the format does not support, and errors.

    Raises:
        KeyError: there is no such target.
    """
    files: dict[str, bytes] | None = import_module(EXPORTS[target].module).write(plan, measured, options, sink)
    return files


__all__ = ["EMITTERS", "EXPORTS", "ExportOptions", "ExportTarget", "emit", "export"]
