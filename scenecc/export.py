"""Scenes as the text or the files of other programs.

Where numbers are needed that only an engine knows, the scene is built without anything seen, and measured.
"""

from __future__ import annotations

import re
from importlib import import_module
from typing import TYPE_CHECKING, Literal, TypeVar

from typing_extensions import Unpack

from scenecc.diagnostics import Location, Sink
from scenecc.emit import EMITTERS, EXPORTS, ExportOptions, emit, export
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import Source, compiled, instantiated, select_scenes

if TYPE_CHECKING:
    from collections.abc import Callable, Collection
    from pathlib import Path

    from scenecc.diagnostics import Diagnostic
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot


Written = TypeVar("Written", str, dict[str, bytes])

_LONGEST_NAME = 60
"""Characters: no file system takes less of them, with a suffix and however they are encoded."""


def emit_scene(
    source: Source,
    target: str,
    *,
    base: Path | None = None,
    found: list[Diagnostic] | None = None,
    **options: Unpack[CompileOptions],
) -> str:
    """A scene as the text of another program's input: "python" or "json". Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        target: a key of `scenecc.emit.EMITTERS`.
        base: folder that the text will lie in, from which its relative paths then start; None: the scene's own.
        found: takes the warnings and notes of a scene that was written.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene is at fault, or cannot be written so.
        ValueError: there is no such target.
    """
    if target not in EMITTERS:
        raise ValueError(f"there is no target {target!r}; there are {', '.join(EMITTERS)}")
    sink = Sink()
    asked = Options.of(**options)
    return _written(emit(compiled(source, asked, sink).plan, target, sink, base=base), sink, found)


def export_scene(
    source: Source,
    target: str,
    *,
    name: str | None = None,
    scene: int | None = None,
    grid: bool = False,
    show: Literal["visual", "collision"] = "visual",
    entity: str | None = None,
    folder: bool = False,
    binary: bool = False,
    found: list[Diagnostic] | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> dict[str, bytes]:
    """A scene as the files of another program, by their paths relative to the folder that they will lie in.

    The first is the file itself, the others, which it refers to, lie in a folder beside it. Numbers that only an engine
    knows (masses, hulls of meshes, where links are) are those of SAPIEN, in which the scene is built for that, without
    anything seen. Other arguments are those of `validate`.

    Args:
        source: as for `validate`.
        target: a key of `scenecc.emit.EXPORTS`: "glb", "mjcf", "urdf" or "usd".
        name: of the file without its suffix; None: the scene's own. What cannot stand in a file name is a `_` there.
        scene: index of the scene to write; None: the first.
        grid: write all scenes side by side in place of one (glb).
        show: draw bodies as they are seen, or their colliding shapes (glb, usd).
        entity: write this entity alone (urdf).
        folder: write each entity into a file of its own name (urdf).
        binary: write the binary form of the file (usd).
        found: takes the warnings and notes of a scene that was written, among them one for everything that the target
            cannot hold.
        progress: called with (scenes done, scenes in all) while the engine builds.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault, or nothing can be written so.
        ValueError: there is no such target, it does not take an argument, or there is no such scene.
    """
    asked = {"scene": scene is not None, "grid": grid, "show": show != "visual"}
    asked |= {"entity": entity is not None, "folder": folder, "binary": binary}
    _check(target, show, [word for word, given in asked.items() if given])
    sink = Sink()
    _need(target, sink)
    asked = Options.of(**options)
    plan = compiled(source, asked, sink).plan
    chosen = None if grid else _one_scene(scene or 0, plan, sink)
    choice = ExportOptions(_file_name(name or plan.name), show, grid, entity, folder, binary)
    return _written(export(plan, _measured(plan, chosen, sink, progress), target, choice, sink), sink, found)


def _file_name(name: str) -> str:
    """A name of a file, and of nothing else: it leads to no folder, and is not hidden."""
    return re.sub(r'[/\\:*?"<>|\x00-\x1f\x7f]+', "_", name).lstrip(". ")[:_LONGEST_NAME] or "scene"


def _check(target: str, show: str, asked: Collection[str]) -> None:
    if target not in EXPORTS:
        raise ValueError(f"there is no target {target!r}; there are {', '.join(EXPORTS)}")
    if show not in {"visual", "collision"}:
        raise ValueError(f"show is visual or collision, not {show!r}")
    check_choice(target, asked)


def _need(target: str, sink: Sink) -> None:
    """Raises SceneError where what every file of a target takes cannot be loaded: before the work, and not after it."""
    needs = EXPORTS[target].needs
    if needs is None:
        return
    module, package = needs
    try:
        import_module(module)
    except ImportError as error:
        message = f"`{target}` is written by {package}: {error}"
        sink.report("SC813", message, Location("scenecc"), hint='run `pip install "scenecc[export]"`')
        raise SceneError(sink.diagnostics()) from error


def _written(made: Written | None, sink: Sink, found: list[Diagnostic] | None) -> Written:
    """A text or files, once it is clear that nothing stopped them."""
    if made is None or sink.failed:
        raise SceneError(sink.diagnostics())
    if found is not None:
        found += sink.diagnostics()
    return made


def check_choice(target: str, asked: Collection[str]) -> None:
    """Whether arguments of `export_scene` can be given together.

    Args:
        target: as there, or a key of `scenecc.emit.EMITTERS`, which takes none of them.
        asked: names of those among `scene`, `grid`, `show`, `entity`, `folder` and `binary` that are given.

    Raises:
        ValueError: the target does not take one of them.
    """
    for word in asked:
        takers = [name for name, row in EXPORTS.items() if word == "scene" or word in row.takes]
        if target not in takers:
            raise ValueError(f"{target} takes no `{word}`, which is for {', '.join(takers)}")
    if {"grid", "scene"} <= set(asked):
        raise ValueError("`grid` writes all scenes, and `scene` one of them")
    if {"entity", "folder"} <= set(asked):
        raise ValueError("`entity` writes one file, and `folder` one for each entity")


def _one_scene(scene: int, plan: ScenePlan, sink: Sink) -> list[int]:
    chosen = select_scenes(str(integer(scene, "scene", 0)), plan.num_scenes, sink, "--scene")
    if chosen is None:
        raise SceneError(sink.diagnostics())
    return list(chosen)


def _measured(
    plan: ScenePlan, scene_idxs: list[int] | None, sink: Sink, progress: Callable[[int, int], None] | None
) -> EngineSnapshot:
    batch = instantiated(
        plan, sink, backend="cpu", scene_idxs=scene_idxs, render=False, audit="fast", progress=progress
    )
    from scenecc.backends.sapien.measure import measure  # with the engine, which is known to be there now

    with batch:
        return measure(batch)
