"""Entities of the plan, prepared for the loop over scenes, and the lookup of their objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

import numpy as np

from scenecc.backends.sapien.articulation_builder import BatchArticulationBuilder
from scenecc.backends.sapien.assets import Resources, refresh_caches
from scenecc.backends.sapien.builder import BatchActorBuilder
from scenecc.backends.sapien.cooked_hulls import report_changed_hulls
from scenecc.backends.sapien.engine import EngineFailure
from scenecc.backends.sapien.mesh_reading import report_unreadable_meshes
from scenecc.backends.sapien.objects import ArticulationObjects, BodyObjects, DrawnObjects
from scenecc.backends.sapien.properties import rows_in_scenes
from scenecc.plan import ArticulationStructure, BodyStructure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.plan import Entity, ScenePlan
    from scenecc.plan.body import Mount

Structure = TypeVar("Structure", bound="BodyStructure | ArticulationStructure")

PlaceInScene = Callable[[Callable[[Any], None], int], None]
"""Builds an entity in a scene, given a function that adds an entity and the scene's number."""

MakeRow = Callable[[int], "tuple[Any, Any]"]
"""Makes the entity of a row and its physical component."""


@dataclass(frozen=True, slots=True)
class StructureRows(Generic[Structure]):
    """The bodies or articulations of an entity that share a structure.

    Attributes:
        numbers: indices among the entity's bodies, ascending.
        rows: their rows in the plan's values.
    """

    structure: Structure
    numbers: NDArray[np.intp]
    rows: NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class PreparedActor:
    """A body, prepared for the loop over scenes.

    Attributes:
        scene_idxs: the built scenes that have it, ascending: one body each.
        rows: the bodies' rows in the plan's values.
        parts: the bodies by structure.
        make: builds the body for a scene's number. None: it differs by scene.
        table: then, for each scene, its builder and row there, or None if the entity is not in it.
        objs, components: what was built, one for each body.
    """

    entity: Entity
    scene_idxs: tuple[int, ...]
    rows: NDArray[np.intp]
    parts: tuple[StructureRows[BodyStructure], ...]
    make: MakeRow | None
    table: list[tuple[MakeRow, int] | None]
    objs: list[Any] = field(default_factory=list[Any])
    components: list[Any] = field(default_factory=list[Any])

    def placer(self) -> PlaceInScene:
        """Returns a function that builds the body in one scene after another."""
        everywhere, table = self.make, self.table
        keep_entity, keep_component = self.objs.append, self.components.append

        def place(add: Callable[[Any], None], number: int) -> None:
            """Builds the body of a scene, adds it and keeps it, if the entity is in the scene."""
            if everywhere is not None:
                entity, component = everywhere(number)
            elif (own := table[number]) is not None:
                entity, component = own[0](own[1])
            else:
                return
            add(entity)
            keep_entity(entity)
            keep_component(component)

        return place

    def objects(self) -> BodyObjects:
        """Returns the objects that were built."""
        return BodyObjects(self.entity.name, self.scene_idxs, self.objs, self.components)


@dataclass(frozen=True, slots=True)
class PreparedArticulation:
    """An articulation, prepared for the loop over scenes.

    Attributes:
        scene_idxs, rows, parts: as for a body.
        table: for each scene its builder and row there, or None if the entity is not in it.
        objs: the `PhysxArticulation` of each scene that has it.
        entities, links: those of the articulation's links, in the order of the plan.
    """

    entity: Entity
    scene_idxs: tuple[int, ...]
    rows: NDArray[np.intp]
    parts: tuple[StructureRows[ArticulationStructure], ...]
    table: list[tuple[BatchArticulationBuilder, int] | None]
    objs: list[Any] = field(default_factory=list[Any])
    entities: list[list[Any]] = field(default_factory=list[list[Any]])
    links: list[list[Any]] = field(default_factory=list[list[Any]])

    def placer(self) -> PlaceInScene:
        """Returns a function that builds the articulation in one scene after another."""

        def place(add: Callable[[Any], None], number: int) -> None:
            """Builds the links of a scene, adds them and sets their initial state, if the entity is in the scene."""
            if (own := self.table[number]) is None:
                return
            builder, row = own
            entities, links = builder.make(row)
            for entity in entities:
                add(entity)
            self.objs.append(builder.start(links, row))
            self.entities.append(entities)
            self.links.append(links)

        return place

    def objects(self) -> ArticulationObjects:
        """Returns the objects that were built. Call it while all are in their scenes."""
        return ArticulationObjects(self.entity.name, self.scene_idxs, self.objs, self.entities, self.links)


PreparedEntity = PreparedActor | PreparedArticulation
"""An entity, prepared for the loop over scenes."""


def prepare_entity(
    entity: Entity, scene_idxs: tuple[int, ...], resources: Resources, *, rendered: bool
) -> tuple[PreparedEntity | None, list[EngineFailure]]:
    """Prepares an entity for these scenes and returns it, with the meshes that cannot be cooked.

    The entity is None if it is in none of the scenes.

    Raises:
        EngineFailure: a shape cannot be prepared.
    """
    present, rows = rows_in_scenes(entity, scene_idxs)
    if not present:
        return None, []
    if isinstance(entity.structures[0], ArticulationStructure):
        return _prepare_articulation(entity, scene_idxs, present, rows, resources, rendered=rendered)
    failures: list[EngineFailure] = []
    parts = cast("tuple[StructureRows[BodyStructure], ...]", group_by_structure(entity, rows))
    makes: list[MakeRow] = []
    for part in parts:
        builder = BatchActorBuilder(entity, part.structure, part.rows, resources, rendered=rendered)
        failures += builder.cook()
        makes.append(builder.make)
    if len(parts) == 1 and len(present) == len(scene_idxs):
        return PreparedActor(entity, present, rows, parts, makes[0], []), failures
    by_scene: dict[int, tuple[MakeRow, int]] = {}
    for part, make in zip(parts, makes, strict=True):
        by_scene.update((present[number], (make, row)) for row, number in enumerate(map(int, part.numbers)))
    return PreparedActor(entity, present, rows, parts, None, [by_scene.get(index) for index in scene_idxs]), failures


def _prepare_articulation(
    entity: Entity,
    scene_idxs: tuple[int, ...],
    present: tuple[int, ...],
    rows: NDArray[np.intp],
    resources: Resources,
    *,
    rendered: bool,
) -> tuple[PreparedArticulation, list[EngineFailure]]:
    parts = cast("tuple[StructureRows[ArticulationStructure], ...]", group_by_structure(entity, rows))
    failures: list[EngineFailure] = []
    by_scene: dict[int, tuple[BatchArticulationBuilder, int]] = {}
    for part in parts:
        builder = BatchArticulationBuilder(entity, part.structure, part.rows, resources, rendered=rendered)
        failures += builder.cook()
        by_scene.update((present[number], (builder, row)) for row, number in enumerate(map(int, part.numbers)))
    table = [by_scene.get(index) for index in scene_idxs]
    return PreparedArticulation(entity, present, rows, parts, table), failures


def group_by_structure(
    entity: Entity, rows: NDArray[np.intp]
) -> tuple[StructureRows[BodyStructure | ArticulationStructure], ...]:
    """Groups the bodies that have these rows in the plan's values by structure."""
    if entity.pick is None:
        return (StructureRows(entity.structures[0], np.arange(len(rows)), rows),)
    picks = np.broadcast_to(entity.pick.data, len(entity.scene_idxs))[rows]
    chosen = [(pick, np.flatnonzero(picks == pick)) for pick in sorted(set(map(int, picks)))]
    return tuple(StructureRows(entity.structures[pick], numbers, rows[numbers]) for pick, numbers in chosen)


class EntityLookup:
    """Finds bodies by their mounts.

    Attributes:
        scene_idxs: the plan's scenes that are built, ascending.
        scenes: the `sapien.Scene`s in this order.
    """

    def __init__(
        self, scene_idxs: tuple[int, ...], scenes: list[Any], prepared_entities: Sequence[PreparedEntity]
    ) -> None:
        self.scene_idxs = scene_idxs
        self.scenes = scenes
        self._prepared = {prepared.entity.name: prepared for prepared in prepared_entities}
        self._row_of = {
            prepared.entity.name: {index: row for row, index in enumerate(prepared.scene_idxs)}
            for prepared in prepared_entities
        }

    def component(self, mount: Mount, number: int) -> Any:
        """Returns the physical component of a body or link that a mount names, in the scene of a number.

        None for a body of type none. A mount on an articulation means its root.

        Raises:
            KeyError: the entity is not in this scene, or has no such link there.
        """
        prepared = self._prepared[mount.entity]
        row = self._row_of[mount.entity][self.scene_idxs[number]]
        if not isinstance(prepared, PreparedArticulation):
            if mount.link is not None:
                raise KeyError(mount.link)
            return prepared.components[row]
        if mount.link is None:
            return prepared.links[row][0]
        return get_link(prepared.links[row], mount.link)

    def entity(self, mount: Mount, number: int) -> Any:
        """Returns the `sapien.Entity` of a mount. Raises KeyError as `component` does."""
        prepared = self._prepared[mount.entity]
        if isinstance(prepared, PreparedArticulation):
            return self.component(mount, number).get_entity()
        if mount.link is not None:
            raise KeyError(mount.link)
        return prepared.objs[self._row_of[mount.entity][self.scene_idxs[number]]]

    def entities(self, index: int) -> Iterator[tuple[str, Any]]:
        """Yields the `sapien.Entity`s of a scene of the plan by name; links are ENTITY/LINK."""
        for name, prepared in self._prepared.items():
            row = self._row_of[name].get(index)
            if row is None:
                continue
            if not isinstance(prepared, PreparedArticulation):
                yield name, prepared.objs[row]
                continue
            for link in prepared.links[row]:
                yield f"{name}/{link.get_name()}", link.get_entity()


def get_link(links: Sequence[Any], name: str) -> Any:
    """Returns the link with a name. Raises KeyError."""
    for link in links:
        if link.get_name() == name:
            return link
    raise KeyError(name)


def prepare_entities(
    plan: ScenePlan, scene_idxs: tuple[int, ...], sink: Sink, drawn: DrawnObjects | None = None, *, rendered: bool
) -> list[PreparedEntity] | None:
    """Prepares what all scenes share: argument tables, materials, and cooked meshes.

    Reports all failures, not only the first. `drawn` receives the objects for resets that no entity holds.
    """
    if report_unreadable_meshes(plan, scene_idxs, sink, rendered=rendered):
        return None
    refresh_caches(plan, rendered=rendered)
    resources = Resources(plan, drawn)
    prepared_entities: list[PreparedEntity] = []
    failed, crowded = False, None
    for entity in plan.entities:
        try:
            prepared, failures = prepare_entity(entity, scene_idxs, resources, rendered=rendered)
        except EngineFailure as failure:
            prepared, failures = None, [failure]
        for failure in failures:
            failure.report(sink, entity.origin)
        failed = failed or bool(failures)
        if prepared is not None:
            prepared_entities.append(prepared)
        if crowded is None and resources.limit_failure():
            crowded = entity
    if crowded is not None and (failure := resources.limit_failure()):
        failure.report(sink, crowded.origin)
        failed = True
    if not failed:
        failed = report_changed_hulls(plan, scene_idxs, sink)
    return None if failed else prepared_entities
