"""Export of scenes to the text or files of other programs.

If a format needs numbers that only an engine knows, the scene is built without visual shapes and measured.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.emit import EMITTERS, EXPORTS, ExportOptions, emit, export
from scenecc.errors import SceneError
from scenecc.extras import install_hint
from scenecc.files import ChangedError, replace_set
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import Source, build_batch, compile_or_raise, select_scenes

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot

_LARGE = 20_000_000
"""Size of an export that is noted [bytes]."""

_LONGEST_NAME = 60
"""Characters of a file name, without suffix. Every file system supports this length in any encoding."""


@frozen
class Emitted:
    """A scene in another program's format.

    Attributes:
        files: content by path, relative to the output folder. The first is the main file; the others, which it
            references, are in a folder beside it.
        diagnostics: warnings and notes, including one for everything that the target does not support.
        needs: what the text of python and json needs besides `files`, in words: paths relative to the output folder,
            packages, asset roots.
        paths: paths of the written files; empty if nothing was written.
    """

    files: dict[str, bytes]
    diagnostics: list[Diagnostic]
    needs: tuple[str, ...] = ()
    paths: tuple[Path, ...] = ()

    @property
    def text(self) -> str:
        """The main file as text. Raises UnicodeDecodeError if it is binary."""
        return next(iter(self.files.values())).decode("utf-8")


class FileChoices(TypedDict, total=False):
    """What to export, and how.

    Attributes:
        scene: index of the scene to export; None: the first.
        grid: export all scenes side by side instead of one (glb).
        show: export visual or collision shapes (glb, usd).
        entity: export only this entity (urdf).
        max_triangles: simplify visual meshes from files that have more triangles (glb, mjcf, urdf, usd); None: none.
        progress: called with (scenes done, total scenes) while the engine builds.
    """

    scene: int | None
    grid: bool
    show: Literal["visual", "collision"]
    entity: str | None
    max_triangles: int | None
    progress: Callable[[int, int], None] | None


class EmitChoices(FileChoices, total=False):
    """What to export, and how.

    Attributes:
        name: file name without suffix; None: the name of the scene. Characters that are invalid in a file name become
            `_`.
        folder: write each entity to its own file (urdf).
        binary: write the binary form of the format (usd).
    """

    name: str | None
    folder: bool
    binary: bool


class ExportArguments(EmitChoices, CompileOptions, total=False):
    """The arguments of `export_scene`."""


SUFFIXES: dict[str, tuple[str, ...]] = {
    "python": (".py",),
    "json": (".json",),
    "glb": (".glb",),
    "mjcf": (".xml", ".mjcf"),
    "urdf": (".urdf", ".xml"),
    "usd": (".usda", ".usd", ".usdc"),
}
"""Target → suffixes of its files."""

BINARY_SUFFIXES = (".usd", ".usdc")
"""Suffixes of the binary form of USD."""


def target_of(path: Path) -> str:
    """Returns the target for a file's suffix. `.xml` gives MJCF.

    Raises:
        ValueError: no target has this suffix.
    """
    found = next((target for target, suffixes in SUFFIXES.items() if path.suffix.lower() in suffixes), None)
    if found is None:
        known = ", ".join(dict.fromkeys(suffix for suffixes in SUFFIXES.values() for suffix in suffixes))
        raise ValueError(f"{path.name} must end in one of {known}")
    return found


def emit_source(
    source: Source, target: str, *, base: Path | None = None, copy: bool = True, **given: Unpack[ExportArguments]
) -> Emitted:
    """Exports a scene in memory.

    Numbers that only an engine knows (masses, hulls of meshes, poses of links) come from SAPIEN, in which the scene is
    built for this purpose, without visual shapes.

    Args:
        source: as for `validate`.
        target: a key of `SUFFIXES`.
        base: folder in which python and json will be written, to which their paths are relative; None: the folder of
            the scene.
        copy: whether files outside `base` are copied to the folder `NAME.assets` of `files` (python, json).
        given: fields of `EmitChoices` and `CompileOptions`.

    Raises:
        SceneError: the scene has errors, the target cannot hold it, or the engine or machine failed.
        ValueError: the target or the scene index does not exist, or the target does not accept an argument.
    """
    options = Options.of_call(emit_source, given, ExportArguments)
    scene, entity, triangles = given.get("scene"), given.get("entity"), given.get("max_triangles")
    if triangles is not None:
        integer(triangles, "max_triangles", 1)
    show = given.get("show", "visual")
    flags = {word: bool(given.get(word, False)) for word in ("grid", "folder", "binary")}
    asked = {"scene": scene, "entity": entity, "max_triangles": triangles}
    asked = {word: value is not None for word, value in asked.items()} | {"show": show != "visual", **flags}
    check_target(target, SUFFIXES)
    check_choice(target, [word for word, on in asked.items() if on])
    sink = Sink()
    if target in EXPORTS:
        _require_packages(target, sink)
    plan = compile_or_raise(source, options, sink).plan
    if plan.expectations and target != "json":
        place = plan.expectations[0].origin or Location(None)
        sink.report(
            "SC721", "expectations (`expect`) are dropped: only scene files and plans can hold them", place, at="key"
        )
    stem = _file_name(given.get("name") or plan.name)
    if target in EMITTERS:
        return emit_text(plan, target, stem, sink, base=base, copy=copy)
    chosen = None if flags["grid"] else _one_scene(scene or 0, plan, sink)
    choice = ExportOptions(stem, show, entity=entity, max_triangles=triangles, **flags)
    files = export(plan, _measure_snapshot(plan, chosen, sink, given.get("progress")), target, choice, sink)
    if files is None or sink.failed:
        raise SceneError(sink.diagnostics())
    size = sum(map(len, files.values()))
    if size > _LARGE and triangles is None:
        hint = "`--max-triangles 20000` (`max_triangles=`) simplifies visual meshes that have more"
        sink.report("SC722", f"the export has {size / 1e6:.0f} MB", plan.origin or Location(None), hint=hint)
    return Emitted(files, sink.diagnostics())


def emit_text(plan: ScenePlan, target: str, stem: str, sink: Sink, *, base: Path | None, copy: bool = True) -> Emitted:
    """Returns a plan as python or json. Arguments and errors are those of `emit_source`. `stem`: name of the file."""
    from scenecc.emit.files import copy_outside_files, list_needs  # only these targets need it
    from scenecc.emit.python.files import unused_files

    unread = unused_files(plan) if target == "python" else frozenset[int]()
    base = None if base is None else Path(os.path.realpath(base))  # paths through a link would leave its target by `..`
    copies: dict[str, bytes] = {}
    if base is not None and copy:
        try:
            plan, copies = copy_outside_files(plan, base, f"{stem}.assets", unread)
        except OSError as error:
            code = "SC422" if isinstance(error, ChangedError) else "SC407"
            sink.report(code, f"'{error.filename}' cannot be read: {error.strerror}", Location(None))
            raise SceneError(sink.diagnostics()) from error
    text = emit(plan, target, sink, base=base)
    if text is None or sink.failed:
        raise SceneError(sink.diagnostics())
    needs = tuple(one for one in list_needs(plan, base, unread) if one.strip("`") not in copies)
    return Emitted({f"{stem}{SUFFIXES[target][0]}": text.encode(), **copies}, sink.diagnostics(), needs)


def write_emitted(made: Emitted, target: Path) -> Emitted:
    """Writes all exported files or none. Returns the export with its paths and the new name of its first file.

    Args:
        made: the export.
        target: path of the first file, whatever its name in `made`.

    Raises:
        OSError: a file cannot be written.
    """
    paths = replace_set(target, made.files, folder=False)
    (_, content), *others = made.files.items()
    return replace(made, files={paths[0].name: content, **dict(others)}, paths=tuple(paths))


def _file_name(name: str) -> str:
    """Returns a safe file name: no folders in it, and not hidden."""
    return re.sub(r'[/\\:*?"<>|\x00-\x1f\x7f]+', "_", name).lstrip(". ")[:_LONGEST_NAME] or "scene"


def check_target(target: object, known: Collection[str]) -> None:
    """Raises ValueError for an unknown target."""
    if not isinstance(target, str) or target not in known:
        writers = {"emit_scene": EMITTERS, "export_scene": EXPORTS}
        writer = next((name for name, targets in writers.items() if target in [*targets]), None)
        hint = "" if writer is None else f"; use `{writer}` for it"
        raise ValueError(f"unknown target {target!r}{hint}; the targets are {', '.join(known)}")


def _require_packages(target: str, sink: Sink) -> None:
    """Raises SceneError if a package that the target always needs cannot be loaded, before any work is done."""
    needs = EXPORTS[target].needs
    if needs is None:
        return
    module, package = needs
    try:
        import_module(module)
    except ImportError as error:
        message = f"`{target}` needs {package}: {error}"
        sink.report("SC813", message, Location(None), hint=install_hint("export"))
        raise SceneError(sink.diagnostics()) from error


def check_choice(target: str, asked: Collection[str]) -> None:
    """Checks that arguments of `Scene.emit` can be combined.

    Args:
        target: as in `Scene.emit`, or a key of `scenecc.emit.EMITTERS`, which accepts none of them.
        asked: the given arguments among `scene`, `grid`, `show`, `entity`, `max_triangles`, `folder` and `binary`.

    Raises:
        ValueError: the target does not accept one of them, or two exclude each other.
    """
    for word in asked:
        takers = [name for name, row in EXPORTS.items() if word in {"scene", "max_triangles", *row.takes}]
        if target not in takers:
            raise ValueError(f"{target} does not support `{word}`, which is only for {', '.join(takers)}")
    if {"grid", "scene"} <= set(asked):
        raise ValueError("`grid` exports all scenes and `scene` only one; give one of them")
    if {"entity", "folder"} <= set(asked):
        raise ValueError("`entity` writes one file and `folder` one per entity; give one of them")


def _one_scene(scene: int, plan: ScenePlan, sink: Sink) -> list[int]:
    chosen = select_scenes(str(integer(scene, "scene", 0)), plan.num_scenes, sink, "scene")
    if chosen is None:
        raise SceneError(sink.diagnostics())
    return list(chosen)


def _measure_snapshot(
    plan: ScenePlan, scene_idxs: list[int] | None, sink: Sink, progress: Callable[[int, int], None] | None
) -> EngineSnapshot:
    batch = build_batch(plan, sink, scene_idxs=scene_idxs, render=False, audit=True, progress=progress)
    from scenecc.backends.sapien.measure import measure_bodies  # loads the engine, which `_need` has checked

    with batch:
        return measure_bodies(batch)
