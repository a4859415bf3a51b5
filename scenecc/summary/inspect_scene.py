"""`inspect_scene`: everything that is said of a scene, as a tree."""

from __future__ import annotations

from typing import TYPE_CHECKING

from typing_extensions import Unpack

from scenecc.diagnostics import Diagnostic, Location, Sink
from scenecc.diagnostics.messages import cut, suggest
from scenecc.errors import SceneError
from scenecc.options import CompileOptions, Options, integer
from scenecc.pipeline import Compiled, Source, compiled, compiled_params, instantiated, select_scenes
from scenecc.summary.inspection import entities_item, matching, scene_item
from scenecc.summary.used_files import file_items

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.plan import Entity, ScenePlan
    from scenecc.summary import Item
    from scenecc.summary.bodies import Made


def inspect_scene(
    source: Source,
    *,
    scene: int | None = None,
    entity: str | None = None,
    depth: int | None = None,
    build: bool = True,
    found: list[Diagnostic] | None = None,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[CompileOptions],
) -> Item:
    """Everything that is said of a scene, as a tree; `scenecc inspect` prints this. Other arguments: as `validate`.

    Args:
        source: as for `validate`.
        scene: the one that is told; None: what all of them can be.
        entity: the name of an entity, or a pattern of names (`*`, `?`, `[…]`): nothing else is told.
        depth: how far below the scene the tree goes; None: to its end.
        build: ask the engine for masses, and for sizes of meshes and articulations, in `scene` or else in the first
            scene that each entity is in. No render device is needed. Otherwise they are told where the file says them.
        found: takes the warnings and notes.
        progress: called with (scenes done, scenes in all) while the engine builds.
        options: those of `CompileOptions`.

    Raises:
        SceneError: the scene, the engine or the machine is at fault; there is no such scene or entity.
        ValueError: an argument is out of its range.
    """
    sink = Sink()
    asked = Options.of(**options)
    done = compiled(source, asked, sink)
    plan = done.plan
    chosen = _chosen(plan, scene, entity, sink)
    made = _made(plan, chosen, scene, sink, progress) if build and chosen else {}
    if entity is not None:
        item = entities_item(chosen, plan, scene=scene, made=made)
    else:
        listed, files = compiled_params(done, asked.limits), _files(done)
        item = scene_item(plan, scene=scene, made=made, params=listed, given=asked.params, files=files)
    if found is not None:
        found += sink.diagnostics()
    return item if depth is None else item.cut(depth)


def _chosen(plan: ScenePlan, scene: int | None, entity: str | None, sink: Sink) -> list[Entity]:
    """The entities that are told. Raises SceneError where what was asked for is not there."""
    if scene is not None:
        select_scenes(str(integer(scene, "scene", 0)), plan.num_scenes, sink, "--scene")
        if sink.failed:
            raise SceneError(sink.diagnostics())
    chosen = matching(plan, entity, scene)
    if entity is not None and not chosen:
        where = "" if scene is None else f" in scene {scene}"
        hint = suggest(entity, [one.name for one in matching(plan, None, scene)])
        sink.report("SC910", f"no entity{where} is called `{cut(entity)}`", Location("--entity"), hint=hint)
        raise SceneError(sink.diagnostics())
    return chosen


def _made(
    plan: ScenePlan,
    entities: list[Entity],
    scene: int | None,
    sink: Sink,
    progress: Callable[[int, int], None] | None,
) -> dict[str, Made]:
    """Some entities as the engine has them, by name."""
    from scenecc.backends.sapien.measure import measure

    first = {one.name: one.scene_idxs[0] if scene is None else scene for one in entities}
    idxs = sorted({*first.values()})
    with instantiated(
        plan, sink, backend="cpu", scene_idxs=idxs, render=False, audit="off", progress=progress
    ) as batch:
        measured = measure(batch)
    return {
        one.entity.name: (at.index, one)
        for at in measured.scenes
        for one in at.entities
        if first.get(one.entity.name) == at.index
    }


def _files(done: Compiled) -> tuple[Item, ...]:

    document = done.document
    top = (document.name, document.path) if document is not None and document.name and document.path else None
    return file_items(done.plan, top, done.scope.memory.named)
