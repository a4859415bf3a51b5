"""A plan as text or as files for other programs: one module a target, loaded when it is asked for.

Texts need the plan alone. Files of other programs hold numbers that only an engine knows (masses, hulls, where links
are), so these are written of a plan and of what was measured of its build.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.emit.choice import Choice
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot

EMITTERS: dict[str, str] = {
    "json": "scenecc.emit.plan_json",
    "python": "scenecc.emit.python.script",
}
"""Target to the module whose `write(plan, sink, base)` makes its text."""


@frozen
class Export:
    """A kind of files for another program.

    Attributes:
        module: its `write(plan, measured, choice, sink)` makes the files; None after an error.
        suffix: of the file.
        takes: fields of `Choice` that mean something to it, beside `name`.
        needs: a module that every file takes, and the package of the extra `export` that brings it; None where only
            some scenes need one.
    """

    module: str
    suffix: str
    takes: frozenset[str] = frozenset()
    needs: tuple[str, str] | None = None


EXPORTS: dict[str, Export] = {
    "glb": Export("scenecc.emit.glb.write", ".glb", frozenset({"show", "grid"})),
    "mjcf": Export("scenecc.emit.mjcf.write", ".xml"),
    "urdf": Export("scenecc.emit.urdf.write", ".urdf", frozenset({"entity", "folder"})),
    "usd": Export("scenecc.emit.usd.write", ".usda", frozenset({"show", "binary"}), ("pxr.Usd", "usd-core")),
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
    text: str | None = import_module(EMITTERS[target]).write(plan, sink, base)
    return text


def export(
    plan: ScenePlan, measured: EngineSnapshot, target: str, choice: Choice, sink: Sink
) -> dict[str, bytes] | None:
    """The files of another program, by their paths relative to the folder that they will lie in.

    The first is the file itself, `NAME` and the target's suffix, and the others, which it refers to, lie in
    `NAME.assets`. Where entities are written one by one, there is one such file each.

    Args:
        plan: what to write.
        measured: what was built of it: the one scene that is written, or all of a grid.
        target: a key of `EXPORTS`.
        choice: what is asked for.
        sink: takes a warning of everything that the target cannot hold, and errors; then there are no files.

    Raises:
        KeyError: if there is no such target.
    """
    files: dict[str, bytes] | None = import_module(EXPORTS[target].module).write(plan, measured, choice, sink)
    return files


__all__ = ["EMITTERS", "EXPORTS", "Export", "emit", "export"]
