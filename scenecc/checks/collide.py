"""Whether two bodies of a plan can touch."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.plan.body import may_collide

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.plan import ArticulationStructure, BodyStructure, Entity, Value

DEFAULT_GROUPS = (1, 1, 0, 0)

Reach = tuple[tuple[int, ...], "tuple[int, ...] | None", "Value | None"]
"""The scenes of an entity, those of its rows that have a structure (None: all), and the structure's groups."""


def meet(a: Entity, a_structure: BodyStructure, b: Entity, b_structure: BodyStructure) -> bool:
    """Whether the two are in one scene with these structures and their collision groups let them collide."""
    if not any(_varies(*body) for body in ((a, a_structure), (b, b_structure))):
        # The many bodies that are everywhere share one tuple.
        together = a.scene_idxs is b.scene_idxs or not set(a.scene_idxs).isdisjoint(b.scene_idxs)
        return together and may_collide(_groups(a_structure, 0), _groups(b_structure, 0))
    rows = {scene: row for row, scene in enumerate(b.scene_idxs)}
    for row_a, scene in enumerate(a.scene_idxs):
        row_b = rows.get(scene)
        if row_b is None or not (_picked(a, a_structure, row_a) and _picked(b, b_structure, row_b)):
            continue
        if may_collide(_groups(a_structure, row_a), _groups(b_structure, row_b)):
            return True
    return False


def reach(entity: Entity, structure: BodyStructure) -> Reach:
    """All that `meet` looks at: bodies of one reach meet the same others."""
    rows = None
    if entity.pick is not None:
        rows = tuple(row for row in range(len(entity.scene_idxs)) if _picked(entity, structure, row))
    return entity.scene_idxs, rows, structure.collision_groups


def _varies(entity: Entity, structure: BodyStructure) -> bool:
    """Whether the entity's scenes differ in what `meet` looks at."""
    groups = structure.collision_groups
    return entity.pick is not None or (groups is not None and groups.may_vary)


def _picked(entity: Entity, structure: BodyStructure, row: int) -> bool:
    """Whether an entity may have a structure in one of its scenes, whatever is drawn."""
    if entity.pick is None or entity.pick.known:
        return _has(entity.structure(row), structure)
    return any(_has(entity.structures[int(index)], structure) for index in entity.pick.numbers())


def _has(whole: BodyStructure | ArticulationStructure, body: BodyStructure) -> bool:
    return any(one is body for one in whole.bodies)


def _groups(structure: BodyStructure, row: int) -> Sequence[int]:
    if structure.collision_groups is None:
        return DEFAULT_GROUPS
    return [int(x) for x in structure.collision_groups.row(row)]
