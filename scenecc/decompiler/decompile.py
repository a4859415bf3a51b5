"""`scenecc.decompile`: live scenes as a scene file, built again and compared."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from os import PathLike

    from scenecc.decompiler.record import Recording


@dataclass(frozen=True)
class Decompiled:
    """A scene file that was made of live scenes.

    Attributes:
        document: the scene file as plain data: what `load_scene` takes as a dict.
        text: the same as YAML.
        problems: what of the live scenes a scene file cannot say, or nobody recorded; one sentence each.
        differences: what is not equal in the scenes that the file builds, one line each; None: nobody compared.
    """

    document: dict[str, Any]
    text: str
    problems: tuple[str, ...]
    differences: tuple[str, ...] | None

    @property
    def is_equal(self) -> bool:
        """Whether the file was built and gave scenes that are equal to the live ones, to the bit."""
        return self.differences == ()


@dataclass(frozen=True)
class _Source:
    """Live scenes, and what their names are without what a simulator puts before them."""

    scenes: list[Any]
    rename: Callable[[int, str], str]
    hidden: frozenset[str] = frozenset()
    maniskill: bool = False


def decompile(
    source: Any,
    *,
    recording: Recording | None = None,
    base: str | PathLike[str] = ".",
    name: str | None = None,
    description: str | None = None,
    check: bool = True,
) -> Decompiled:
    """Writes live scenes as a scene file, and builds it to compare.

    Decompile right after a build or a reset: what the engine keeps of contacts once it has stepped cannot be read.

    Args:
        source: a `sapien.Scene`, an environment or a scene of ManiSkill, or a list of these, which are parallel scenes
            of one file. They are scenes of PhysX on the CPU.
        recording: what `scenecc.record()` noted while the scenes were built. Without it, collision meshes, robots'
            files, fixed tendons and environment maps are unknown.
        base: folder of the file that will be written; paths of files are relative to it, or `pkg://`.
        name: of the scene file.
        description: of the scene file.
        check: whether to build the file, once, and to compare; it takes as long as the build.

    Raises:
        TypeError: `source` is none of these, or is simulated on the GPU.
        UnlikeScenes: the scenes differ in what all scenes of a file have in common.
    """
    from scenecc.decompiler.live import LiveSceneReader, has_render_system  # noqa: PLC0415 - loads the engine
    from scenecc.decompiler.prefabs import use_lights, use_prefabs  # noqa: PLC0415 - likewise
    from scenecc.decompiler.reading import read_scene  # noqa: PLC0415 - likewise
    from scenecc.decompiler.values import FileNamer  # noqa: PLC0415 - likewise
    from scenecc.scene_file.layout import scene_text  # noqa: PLC0415
    from scenecc.scene_file.parallel import merge_scenes  # noqa: PLC0415
    from scenecc.scene_file.simplify import simplify  # noqa: PLC0415

    live, folder = _live_scenes(source), Path(base)
    files = FileNamer(folder)
    problems: dict[str, None] = {}
    documents: list[dict[str, Any]] = []
    facts: list[Any] = []
    for index, scene in enumerate(live.scenes):
        reader = LiveSceneReader(recording, files, partial(live.rename, index), live.hidden)
        documents.append(reader.document(scene))
        facts.append(read_scene(scene, reader.names.of))
        problems.update(dict.fromkeys(reader.problems))
    render = has_render_system(live.scenes[0])
    merged = merge_scenes(documents)
    if render or live.maniskill:  # what ManiSkill builds is seen as prefabs show it
        merged = use_lights(use_prefabs(merged, facts[0], render=render))
    head = {"scenecc": 1} | ({"name": name} if name else {}) | ({"description": description} if description else {})
    document = {**head, **simplify(merged)}
    differences = None
    if check:
        differences = tuple(_differences(document, folder, facts, render=render))
    return Decompiled(document, scene_text(document), tuple(problems), differences)


def _differences(document: dict[str, Any], base: Path, facts: list[Any], *, render: bool) -> list[str]:
    import scenecc  # noqa: PLC0415 - the facade is above this module's other users
    from scenecc.decompiler.verify import rebuilt_differences  # noqa: PLC0415 - loads the engine

    try:
        return rebuilt_differences(document, base, facts, render=render)
    except scenecc.SceneError as error:
        return [f"the file does not build: {line}" for line in str(error).strip().splitlines()]


def _live_scenes(source: Any) -> _Source:
    sources: list[Any] = [*source] if isinstance(source, list | tuple) else [source]
    owners = [_maniskill_scene(each) for each in sources]
    maniskill = bool(owners) and all(owner is not None for owner in owners)
    scenes = [scene for owner in owners for scene in owner.sub_scenes] if maniskill else sources
    if not scenes or not all(hasattr(each, "physx_system") and hasattr(each, "entities") for each in scenes):
        raise TypeError("decompile takes a sapien.Scene, an environment or a scene of ManiSkill, or a list of these")
    if any(type(scene.physx_system).__name__ == "PhysxGpuSystem" for scene in scenes):
        raise TypeError('decompile reads scenes of the CPU: build it with `sim_backend="cpu"`, or a PhysxCpuSystem')
    if not maniskill:
        return _Source(scenes, lambda _, name: name)
    hidden = {actor.name for each in sources for actor in getattr(_environment(each), "_hidden_objects", ())}
    return _Source(scenes, _maniskill_names(scenes), frozenset(hidden), maniskill=True)


def _environment(source: Any) -> Any:
    return getattr(source, "unwrapped", source)


def _maniskill_scene(source: Any) -> Any:
    """The scene of an environment of ManiSkill, or the source if it is one; None of anything else."""
    environment = _environment(source)
    owner = None if hasattr(environment, "physx_system") else getattr(environment, "scene", None)
    return next((each for each in (owner, environment) if hasattr(each, "sub_scenes")), None)


def _maniskill_names(scenes: list[Any]) -> Callable[[int, str], str]:
    """ManiSkill's names without the scene's index, and links' and joints' without their robot's name."""
    from scenecc.decompiler.reading import articulations  # noqa: PLC0415 - loads the engine

    prefixes = [_link_prefixes(articulation.name for articulation in articulations(scene)) for scene in scenes]

    def rename(index: int, name: str) -> str:
        for prefix in prefixes[index]:
            if name.startswith(prefix):
                return name.removeprefix(prefix)
        return re.sub(r"^scene-\d+_", "", name)

    return rename


def _link_prefixes(articulations: Iterable[str]) -> list[str]:
    """`scene-0-panda_` for `scene-0_panda`; the longest first, since one robot's name may begin another's."""
    return sorted((f"{name.replace('_', '-', 1)}_" for name in articulations), key=len, reverse=True)
