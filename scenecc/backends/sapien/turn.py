"""An entity's part in a build: which rows, of which structures, in which scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar, cast

import numpy as np

from scenecc.backends.sapien.articulation_builder import BatchArticulationBuilder
from scenecc.backends.sapien.bodies import Articulations, Bodies
from scenecc.backends.sapien.builder import BatchActorBuilder
from scenecc.plan import ArticulationStructure, BodyStructure

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.failure import EngineFailure
    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import Entity

Structure = TypeVar("Structure", bound="BodyStructure | ArticulationStructure")

Place = Callable[[Callable[[Any], None], int], None]
"""Builds an entity's part in a scene, given what adds an entity to it and the scene's number."""

Make = Callable[[int], "tuple[Any, Any]"]
"""From a row of a builder to a new entity and its physical component."""


@dataclass(frozen=True, slots=True)
class Part(Generic[Structure]):
    """The bodies, or the articulations, of an entity that have one structure.

    Attributes:
        numbers: which of the entity's bodies, ascending.
        rows: their rows in the plan's values.
    """

    structure: Structure
    numbers: NDArray[np.intp]
    rows: NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Turn:
    """A body in the loop over scenes.

    Attributes:
        scene_idxs: the scenes that are built and have it, ascending: one body each.
        rows: the bodies' rows in the plan's values.
        parts: the bodies by structure.
        make: builds the body of any scene by the scene's number; None: it differs by scene.
        table: then for each scene its builder and row there, or None where the entity is not in it.
        objs, components: what was built, one each body.
    """

    entity: Entity
    scene_idxs: tuple[int, ...]
    rows: NDArray[np.intp]
    parts: tuple[Part[BodyStructure], ...]
    make: Make | None
    table: list[tuple[Make, int] | None]
    objs: list[Any] = field(default_factory=list[Any])
    components: list[Any] = field(default_factory=list[Any])

    def placer(self) -> Place:
        """What builds its body in one scene after the other."""
        everywhere, table = self.make, self.table
        keep_entity, keep_component = self.objs.append, self.components.append

        def place(add: Callable[[Any], None], number: int) -> None:
            """Builds the body of a scene, adds it and keeps it; nothing where the entity is not in the scene."""
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

    def held(self) -> Bodies:
        """What was built, as the classes of a batch share it."""
        return Bodies(self.entity.name, self.scene_idxs, self.objs, self.components)


@dataclass(frozen=True, slots=True)
class ArticulationTurn:
    """An articulation in the loop over scenes.

    Attributes:
        scene_idxs, rows, parts: as of a body.
        table: for each scene its builder and row there, or None where the entity is not in it.
        objs: the `PhysxArticulation` of each scene that has it.
        entities, links: those of their links, in the order of the plan.
    """

    entity: Entity
    scene_idxs: tuple[int, ...]
    rows: NDArray[np.intp]
    parts: tuple[Part[ArticulationStructure], ...]
    table: list[tuple[BatchArticulationBuilder, int] | None]
    objs: list[Any] = field(default_factory=list[Any])
    entities: list[list[Any]] = field(default_factory=list[list[Any]])
    links: list[list[Any]] = field(default_factory=list[list[Any]])

    def placer(self) -> Place:
        """What builds its articulation in one scene after the other."""

        def place(add: Callable[[Any], None], number: int) -> None:
            """Builds the links of a scene, adds them and lets them start; nothing where the entity is not in it."""
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

    def held(self) -> Articulations:
        """What was built, as the classes of a batch share it; called while all are in their scenes."""
        return Articulations(self.entity.name, self.scene_idxs, self.objs, self.entities, self.links)


AnyTurn = Turn | ArticulationTurn
"""An entity's part in a build."""


def take_turn(
    entity: Entity, scene_idxs: tuple[int, ...], resources: Resources, *, rendered: bool
) -> tuple[AnyTurn | None, list[EngineFailure]]:
    """The entity's part among the scenes named, None where it is in none, and what the engine cannot cook.

    Raises:
        EngineFailure: a shape cannot even be prepared.
    """
    present, rows = present_rows(entity, scene_idxs)
    if not present:
        return None, []
    if isinstance(entity.structures[0], ArticulationStructure):
        return _articulation(entity, scene_idxs, present, rows, resources, rendered=rendered)
    failures: list[EngineFailure] = []
    parts = cast("tuple[Part[BodyStructure], ...]", parts_of(entity, rows))
    makes: list[Make] = []
    for part in parts:
        builder = BatchActorBuilder(entity, part.structure, part.rows, resources, rendered=rendered)
        failures += builder.cook()
        makes.append(builder.make)
    if len(parts) == 1 and len(present) == len(scene_idxs):
        return Turn(entity, present, rows, parts, makes[0], []), failures
    by_scene: dict[int, tuple[Make, int]] = {}
    for part, make in zip(parts, makes, strict=True):
        by_scene.update((present[number], (make, row)) for row, number in enumerate(map(int, part.numbers)))
    return Turn(entity, present, rows, parts, None, [by_scene.get(index) for index in scene_idxs]), failures


def _articulation(
    entity: Entity,
    scene_idxs: tuple[int, ...],
    present: tuple[int, ...],
    rows: NDArray[np.intp],
    resources: Resources,
    *,
    rendered: bool,
) -> tuple[ArticulationTurn, list[EngineFailure]]:
    parts = cast("tuple[Part[ArticulationStructure], ...]", parts_of(entity, rows))
    failures: list[EngineFailure] = []
    by_scene: dict[int, tuple[BatchArticulationBuilder, int]] = {}
    for part in parts:
        builder = BatchArticulationBuilder(entity, part.structure, part.rows, resources, rendered=rendered)
        failures += builder.cook()
        by_scene.update((present[number], (builder, row)) for row, number in enumerate(map(int, part.numbers)))
    table = [by_scene.get(index) for index in scene_idxs]
    return ArticulationTurn(entity, present, rows, parts, table), failures


def present_rows(entity: Entity, scene_idxs: tuple[int, ...]) -> tuple[tuple[int, ...], NDArray[np.intp]]:
    """Those of the scenes that have the entity, and their rows in the plan's values."""
    if entity.scene_idxs == scene_idxs:
        return scene_idxs, np.arange(len(scene_idxs))
    row_of = {index: row for row, index in enumerate(entity.scene_idxs)}
    present = tuple(index for index in scene_idxs if index in row_of)
    return present, np.array([row_of[index] for index in present], dtype=np.intp)


def parts_of(entity: Entity, rows: NDArray[np.intp]) -> tuple[Part[BodyStructure | ArticulationStructure], ...]:
    """The bodies that have these rows in the plan's values, by structure."""
    if entity.pick is None:
        return (Part(entity.structures[0], np.arange(len(rows)), rows),)
    picks = np.broadcast_to(entity.pick.data, len(entity.scene_idxs))[rows]
    chosen = [(pick, np.flatnonzero(picks == pick)) for pick in sorted(set(map(int, picks)))]
    return tuple(Part(entity.structures[pick], numbers, rows[numbers]) for pick, numbers in chosen)
