"""An entity's part in a build: which rows, of which structures, in which scenes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.builder import BatchActorBuilder

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.failure import EngineFailure
    from scenecc.backends.sapien.resources import Resources
    from scenecc.plan import BodyStructure, Entity

Make = Callable[[int], "tuple[Any, Any]"]
"""From a row of a builder to a new entity and its physical component."""


class Part(NamedTuple):
    """The bodies of an entity that have one structure.

    Attributes:
        numbers: which of the entity's bodies, ascending.
        rows: their rows in the plan's values.
    """

    structure: BodyStructure
    numbers: NDArray[np.intp]
    rows: NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Turn:
    """An entity in the loop over scenes.

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
    parts: tuple[Part, ...]
    make: Make | None
    table: list[tuple[Make, int] | None]
    objs: list[Any] = field(default_factory=list[Any])
    components: list[Any] = field(default_factory=list[Any])


def take_turn(
    entity: Entity, scene_idxs: tuple[int, ...], resources: Resources, *, rendered: bool
) -> tuple[Turn | None, list[EngineFailure]]:
    """The entity's part among the scenes named, None where it is in none, and what the engine cannot cook.

    Raises:
        EngineFailure: a shape cannot even be prepared.
    """
    present, rows = present_rows(entity, scene_idxs)
    if not present:
        return None, []
    failures: list[EngineFailure] = []
    parts = parts_of(entity, rows)
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


def present_rows(entity: Entity, scene_idxs: tuple[int, ...]) -> tuple[tuple[int, ...], NDArray[np.intp]]:
    """Those of the scenes that have the entity, and their rows in the plan's values."""
    if entity.scene_idxs == scene_idxs:
        return scene_idxs, np.arange(len(scene_idxs))
    row_of = {index: row for row, index in enumerate(entity.scene_idxs)}
    present = tuple(index for index in scene_idxs if index in row_of)
    return present, np.array([row_of[index] for index in present], dtype=np.intp)


def parts_of(entity: Entity, rows: NDArray[np.intp]) -> tuple[Part, ...]:
    """The bodies that have these rows in the plan's values, by structure."""
    if entity.pick is None:
        return (Part(entity.structures[0], np.arange(len(rows)), rows),)
    picks = np.broadcast_to(entity.pick.data, len(entity.scene_idxs))[rows]
    chosen = [(pick, np.flatnonzero(picks == pick)) for pick in sorted(set(map(int, picks)))]
    return tuple(Part(entity.structures[pick], numbers, rows[numbers]) for pick, numbers in chosen)
