"""`scenecc.decompile`: writes live scenes as a scene file, rebuilds it and compares."""

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
    """A scene file made from live scenes.

    Attributes:
        document: the scene file as plain data, as `load_scene` takes it.
        text: the scene file as YAML.
        problems: content that a scene file cannot represent or that was not recorded; one sentence each.
        differences: differences of the rebuilt scenes, one line each; None: not compared.
    """

    document: dict[str, Any]
    text: str
    problems: tuple[str, ...]
    differences: tuple[str, ...] | None

    @property
    def is_equal(self) -> bool:
        """Whether the file was rebuilt and gave bit-identical scenes."""
        return self.differences == ()


@dataclass(frozen=True)
class _Source:
    """Live scenes, and how to remove a simulator's prefixes from names."""

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
    """Writes live scenes as a scene file, and rebuilds it to compare.

    Decompile right after a build or a reset: after a step, the engine's contact state cannot be read.

    Args:
        source: a `sapien.Scene`, a ManiSkill environment or scene, or a list of these, which become parallel scenes of
            one file. Only PhysX on the CPU.
        recording: from `scenecc.record()` while the scenes were built. Without it, collision meshes, robot files, fixed
            tendons and environment maps are unknown.
        base: folder of the scene file; asset paths are relative to it, or `pkg://`.
        name: name of the scene file.
        description: description of the scene file.
        check: whether to rebuild the file once and compare; takes as long as the build.

    Raises:
        TypeError: `source` has another type, or is simulated on the GPU.
        UnlikeScenes: the scenes differ in what all scenes of a file must share.
    """
    from scenecc.decompiler.live import LiveSceneReader, has_render_system  # noqa: PLC0415 - loads the engine
    from scenecc.decompiler.prefabs import use_lights, use_prefabs  # noqa: PLC0415 - as above
    from scenecc.decompiler.reading import read_scene  # noqa: PLC0415 - as above
    from scenecc.decompiler.values import FileNamer  # noqa: PLC0415 - as above
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
    if render or live.maniskill:  # ManiSkill's own bodies look as in the prefabs
        merged = use_lights(use_prefabs(merged, facts[0], render=render))
    if "constraints" in merged:
        merged = {**merged, "constraints": {key: _as_ball(node) for key, node in merged["constraints"].items()}}
    head = {"scenecc": 1} | ({"name": name} if name else {}) | ({"description": description} if description else {})
    document = {**head, **simplify(merged)}
    differences = None
    if check:
        differences = tuple(_differences(document, folder, facts, render=render))
    return Decompiled(document, scene_text(document), tuple(problems), differences)


def _as_ball(node: dict[str, Any]) -> dict[str, Any]:
    """Returns a constraint in the short form `type: ball`, if that means the same."""
    if node.get("type") != "drive":
        return node
    limits, drives = dict(node.get("limits", {})), node.get("drive", {})
    held = [limits.pop(axis, None) for axis in "xyz"]
    if held != [[0, 0]] * 3 or not drives.keys() <= {"slerp"} or node.keys() & _ONLY_OF_DRIVES:
        return node
    rest = {"limits": limits.get("twist"), "drive": drives.get("slerp")}
    kept = {key: value for key, value in {**node, **rest}.items() if value is not None}
    return {**kept, "type": "ball"}


_ONLY_OF_DRIVES = {"limit_springs", "target", "velocity_target", "inv_mass_scales", "inv_inertia_scales"}


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
        raise TypeError("decompile takes a sapien.Scene, a ManiSkill environment or scene, or a list of these")
    if any(type(scene.physx_system).__name__ == "PhysxGpuSystem" for scene in scenes):
        raise TypeError('decompile reads CPU scenes only: build it with `sim_backend="cpu"`, or a PhysxCpuSystem')
    if not maniskill:
        return _Source(scenes, lambda _, name: name)
    hidden = {actor.name for each in sources for actor in getattr(_environment(each), "_hidden_objects", ())}
    return _Source(scenes, _maniskill_names(scenes), frozenset(hidden), maniskill=True)


def _environment(source: Any) -> Any:
    return getattr(source, "unwrapped", source)


def _maniskill_scene(source: Any) -> Any:
    """Returns the scene of a ManiSkill environment, or the source if it is a scene; None for anything else."""
    environment = _environment(source)
    owner = None if hasattr(environment, "physx_system") else getattr(environment, "scene", None)
    return next((each for each in (owner, environment) if hasattr(each, "sub_scenes")), None)


def _maniskill_names(scenes: list[Any]) -> Callable[[int, str], str]:
    """Returns a function that removes the scene's index, and the robot's name from links and joints."""
    from scenecc.decompiler.reading import articulations  # noqa: PLC0415 - loads the engine

    prefixes = [_link_prefixes(articulation.name for articulation in articulations(scene)) for scene in scenes]

    def rename(index: int, name: str) -> str:
        for prefix in prefixes[index]:
            if name.startswith(prefix):
                return name.removeprefix(prefix)
        return re.sub(r"^scene-\d+_", "", name)

    return rename


def _link_prefixes(articulations: Iterable[str]) -> list[str]:
    """Returns prefixes like `scene-0-panda_` for `scene-0_panda`; longest first, as one name may begin another."""
    return sorted((f"{name.replace('_', '-', 1)}_" for name in articulations), key=len, reverse=True)
