"""Scenes as the text or the files of other programs.

Where numbers are needed that only an engine knows, the scene is built without anything seen, and measured.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from importlib import import_module
from typing import TYPE_CHECKING, Literal

from typing_extensions import TypedDict, Unpack

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Location
from scenecc.diagnostics.frozen import frozen
from scenecc.emit import EMITTERS, EXPORTS, ExportOptions, emit, export
from scenecc.errors import SceneError
from scenecc.extras import install_hint
from scenecc.files import replace_set
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import Source, build_batch, compile_or_raise, select_scenes

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.plan import ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot

_LONGEST_NAME = 60
"""Characters: no file system takes less of them, with a suffix and however they are encoded."""


@frozen
class Emitted:
    """A scene in another program's form.

    Attributes:
        files: by their paths relative to the folder that they lie in, or will lie in. The first is the file itself; the
            others, which it refers to, lie in a folder beside it.
        diagnostics: warnings and notes, among them one for everything that the target cannot hold.
        paths: where they were written; empty where they were not.
    """

    files: dict[str, bytes]
    diagnostics: list[Diagnostic]
    paths: tuple[Path, ...] = ()

    @property
    def text(self) -> str:
        """The file itself as text. Raises UnicodeDecodeError where it is none."""
        return next(iter(self.files.values())).decode("utf-8")


class FileChoices(TypedDict, total=False):
    """What of a scene is written, and how.

    Attributes:
        scene: index of the scene to write; None: the first.
        grid: write all scenes side by side in place of one (glb).
        show: draw bodies as they are seen, or their colliding shapes (glb, usd).
        entity: write this entity alone (urdf).
        progress: called with (scenes done, scenes in all) while the engine builds.
    """

    scene: int | None
    grid: bool
    show: Literal["visual", "collision"]
    entity: str | None
    progress: Callable[[int, int], None] | None


class EmitChoices(FileChoices, total=False):
    """What of a scene is written, and how.

    Attributes:
        name: of the file without its suffix; None: the scene's own. What cannot stand in a file name is a `_` there.
        folder: write each entity into a file of its own name (urdf).
        binary: write the binary form of the file (usd).
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
"""Target to the suffixes of its files."""

BINARY_SUFFIXES = (".usd", ".usdc")
"""Suffixes of USD's binary form."""


def target_of(path: Path) -> str:
    """The target that a file's suffix stands for; of `.xml`, MJCF.

    Raises:
        ValueError: it stands for none.
    """
    found = next((target for target, suffixes in SUFFIXES.items() if path.suffix.lower() in suffixes), None)
    if found is None:
        known = ", ".join(dict.fromkeys(suffix for suffixes in SUFFIXES.values() for suffix in suffixes))
        raise ValueError(f"{path.name} ends in none of {known}")
    return found


def emit_source(source: Source, target: str, *, base: Path | None = None, **given: Unpack[ExportArguments]) -> Emitted:
    """A scene in another program's form, in memory.

    Numbers that only an engine knows (masses, hulls of meshes, poses of links) are those of SAPIEN, in which the scene
    is built for that, without visual shapes.

    Args:
        source: as for `validate`.
        target: a key of `SUFFIXES`.
        base: folder of the text, from which its relative paths start; None: the scene's own.
        given: those of `EmitChoices` and of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault, or nothing can be written so.
        ValueError: there is no such target, it does not take an argument, or there is no such scene.
    """
    options = Options.of_call(emit_source, given, ExportArguments)
    scene, entity = given.get("scene"), given.get("entity")
    show = given.get("show", "visual")
    flags = {word: bool(given.get(word, False)) for word in ("grid", "folder", "binary")}
    asked = {"scene": scene is not None, "show": show != "visual", "entity": entity is not None, **flags}
    check_target(target, SUFFIXES)
    check_choice(target, [word for word, on in asked.items() if on])
    sink = Sink()
    if target in EXPORTS:
        _require_packages(target, sink)
    plan = compile_or_raise(source, options, sink).plan
    if plan.expectations and target != "json":
        place = plan.expectations[0].origin or Location(None)
        sink.report(
            "SC721", "what must hold (`expect`) is left out: only scene files and plans have it", place, at="key"
        )
    stem = _file_name(given.get("name") or plan.name)
    if target in EMITTERS:
        text = emit(plan, target, sink, base=base)
        files = None if text is None else {f"{stem}{SUFFIXES[target][0]}": text.encode("utf-8")}
    else:
        chosen = None if flags["grid"] else _one_scene(scene or 0, plan, sink)
        choice = ExportOptions(stem, show, entity=entity, **flags)
        files = export(plan, _measure_snapshot(plan, chosen, sink, given.get("progress")), target, choice, sink)
    if files is None or sink.failed:
        raise SceneError(sink.diagnostics())
    return Emitted(files, sink.diagnostics())


def write_emitted(made: Emitted, target: Path) -> Emitted:
    """Writes what was made, all files or none. Returns it with the name that its first file has now, and the paths.

    Args:
        made: the files.
        target: the file that takes the first of them, whatever that is called.

    Raises:
        OSError: they cannot be written.
    """
    paths = replace_set(target, made.files, folder=False)
    (_, content), *others = made.files.items()
    return Emitted({paths[0].name: content, **dict(others)}, made.diagnostics, tuple(paths))


def _file_name(name: str) -> str:
    """A name of a file, and of nothing else: it leads to no folder, and is not hidden."""
    return re.sub(r'[/\\:*?"<>|\x00-\x1f\x7f]+', "_", name).lstrip(". ")[:_LONGEST_NAME] or "scene"


def check_target(target: object, known: Collection[str]) -> None:
    """Raises ValueError for what is no target."""
    if not isinstance(target, str) or target not in known:
        writers = {"emit_scene": EMITTERS, "export_scene": EXPORTS}
        writer = next((name for name, targets in writers.items() if target in [*targets]), None)
        hint = "" if writer is None else f"; `{writer}` writes it"
        raise ValueError(f"unknown target {target!r}{hint}; the targets are {', '.join(known)}")


def _require_packages(target: str, sink: Sink) -> None:
    """Raises SceneError where what every file of a target takes cannot be loaded: before the work, and not after it."""
    needs = EXPORTS[target].needs
    if needs is None:
        return
    module, package = needs
    try:
        import_module(module)
    except ImportError as error:
        message = f"`{target}` is written by {package}: {error}"
        sink.report("SC813", message, Location(None), hint=install_hint("export"))
        raise SceneError(sink.diagnostics()) from error


def check_choice(target: str, asked: Collection[str]) -> None:
    """Whether arguments of `Scene.emit` can be given together.

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
    chosen = select_scenes(str(integer(scene, "scene", 0)), plan.num_scenes, sink, "scene")
    if chosen is None:
        raise SceneError(sink.diagnostics())
    return list(chosen)


def _measure_snapshot(
    plan: ScenePlan, scene_idxs: list[int] | None, sink: Sink, progress: Callable[[int, int], None] | None
) -> EngineSnapshot:
    batch = build_batch(plan, sink, scene_idxs=scene_idxs, render=False, audit=True, progress=progress)
    from scenecc.backends.sapien.measure import measure_bodies  # with the engine, which is known to be there now

    with batch:
        return measure_bodies(batch)
