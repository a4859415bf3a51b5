"""Scenes as files for other programs: built without anything seen, measured, and written."""

from __future__ import annotations

import re
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

from scenecc.diagnostics import Location, SceneError, Sink
from scenecc.emit import EXPORTS, export
from scenecc.emit.choice import Choice
from scenecc.front import Options, Source, compiled, instantiated, select_scenes
from scenecc.front.options import integer

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping
    from os import PathLike

    from scenecc.diagnostics import Diagnostic
    from scenecc.plan import ScenePlan
    from scenecc.plan.measured import Measured

__all__ = ["check_choice", "export_scene"]

_LONGEST_NAME = 60
"""Characters: no file system takes less of them, with a suffix and however they are encoded."""


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
    num_scenes: int | None = None,
    seed: int | None = None,
    params: Mapping[str, Any] | None = None,
    draws: Mapping[str, Any] | None = None,
    asset_roots: Iterable[str | PathLike[str]] = (),
    allow_outside_assets: bool = False,
    limits: Mapping[str, int] | None = None,
    found: list[Diagnostic] | None = None,
    progress: Callable[[int, int], None] | None = None,
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
        num_scenes: in place of the file's.
        seed: in place of the file's.
        params: as for `validate`.
        draws: as for `validate`.
        asset_roots: as for `validate`.
        allow_outside_assets: as for `validate`.
        limits: as for `validate`.
        found: takes the warnings and notes of a scene that was written, among them one for everything that the target
            cannot hold.
        progress: called with (scenes done, scenes in all) while the engine builds.

    Raises:
        SceneError: the scene, the engine or the machine is at fault, or nothing can be written so.
        ValueError: there is no such target, it does not take an argument, or there is no such scene.
    """
    asked = {"scene": scene is not None, "grid": grid, "show": show != "visual"}
    asked |= {"entity": entity is not None, "folder": folder, "binary": binary}
    _check(target, show, [word for word, given in asked.items() if given])
    sink = Sink()
    _need(target, sink)
    options = Options.of(num_scenes, seed, params, draws, asset_roots, allow_outside_assets, limits)
    plan = compiled(source, options, sink).plan
    chosen = None if grid else _one_scene(scene or 0, plan, sink)
    choice = Choice(_file_name(name or plan.name), show, grid, entity, folder, binary)
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


def _written(files: dict[str, bytes] | None, sink: Sink, found: list[Diagnostic] | None) -> dict[str, bytes]:
    """The files, once it is clear that nothing stopped them."""
    if files is None or sink.failed:
        raise SceneError(sink.diagnostics())
    if found is not None:
        found += sink.diagnostics()
    return files


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
) -> Measured:
    batch = instantiated(
        plan, sink, backend="cpu", scene_idxs=scene_idxs, render=False, audit="fast", progress=progress
    )
    from scenecc.backends.sapien.measure import measure  # with the engine, which is known to be there now

    with batch:
        return measure(batch)
