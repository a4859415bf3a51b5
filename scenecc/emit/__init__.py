"""Emits a plan as text or as files for other programs: one module per target, imported on demand.

Text targets need only the plan. File targets hold values that only an engine knows (masses, convex hulls, link
poses), so they are written from a plan and from measurements of its build.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.json_writer import plan_to_json

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot


Show = Literal["visual", "collision"]


@frozen
class ExportOptions:
    """How the measured scenes are to be written.

    Attributes:
        name: of the file without its suffix. Files that lie beside it are in a folder `NAME.assets`.
        show: what bodies look like: as they are seen, or their colliding shapes.
        grid: whether all scenes that were measured are written side by side; otherwise there is one.
        entity: the one to write; None: all.
        folder: whether entities are to be written one by one, each into a file of its own name.
        binary: whether the file is to be in the binary form of its kind.
    """

    name: str
    show: Show = "visual"
    grid: bool = False
    entity: str | None = None
    folder: bool = False
    binary: bool = False


def _emit_json(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    """Canonical JSON; every plan can be written."""
    del sink
    return plan_to_json(plan, base=base)


def _emit_python(plan: ScenePlan, sink: Sink, base: Path | None) -> str | None:
    text: str | None = import_module("scenecc.emit.python").write(plan, sink, base)
    return text


EMITTERS: dict[str, Callable[[ScenePlan, Sink, Path | None], str | None]] = {
    "json": _emit_json,
    "python": _emit_python,
}
"""Text target to the function that writes it."""


@frozen
class ExportTarget:
    """A kind of files for another program.

    Attributes:
        module: its `write(plan, measured, options, sink)` makes the files; None after an error.
        suffix: of the file.
        takes: fields of `ExportOptions` that mean something to it, beside `name`.
        needs: a module that every file takes, and the package of the extra `export` that brings it; None where only
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
"""Target to what writes it."""


def emit(plan: ScenePlan, target: str, sink: Sink, *, base: Path | None = None) -> str | None:
    """The plan as text; None if it cannot be written so, which `sink` then tells.

    Args:
        plan: what to write.
        target: a key of `EMITTERS`.
        sink: takes diagnostics.
        base: folder that the text will lie in; relative uris are rewritten against it. None: they stay as they are.

    Raises:
        KeyError: if there is no such target.
    """
    return EMITTERS[target](plan, sink, base)


def export(
    plan: ScenePlan, measured: EngineSnapshot, target: str, options: ExportOptions, sink: Sink
) -> dict[str, bytes] | None:
    """The files of another program, by their paths relative to the folder that they will lie in.

    The first is the file itself, `NAME` and the target's suffix, and the others, which it refers to, lie in
    `NAME.assets`. Where entities are written one by one, there is one such file each.

    Args:
        plan: what to write.
        measured: what was built of it: the one scene that is written, or all of a grid.
        target: a key of `EXPORTS`.
        options: what is asked for.
        sink: takes a warning of everything that the target cannot hold, and errors; then there are no files.

    Raises:
        KeyError: if there is no such target.
    """
    files: dict[str, bytes] | None = import_module(EXPORTS[target].module).write(plan, measured, options, sink)
    return files


__all__ = ["EMITTERS", "EXPORTS", "ExportOptions", "ExportTarget", "emit", "export"]
