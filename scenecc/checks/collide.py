"""Whether two bodies of a plan can touch."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.plan import BodyStructure, Entity

DEFAULT_GROUPS = (1, 1, 0, 0)
_ID = 0xFFFF


def meet(a: Entity, a_structure: BodyStructure, b: Entity, b_structure: BodyStructure) -> bool:
    """Whether the two are in one scene with these structures and their collision groups let them collide."""
    for scene in set(a.scene_idxs).intersection(b.scene_idxs):
        row_a, row_b = a.scene_idxs.index(scene), b.scene_idxs.index(scene)
        if not (_picked(a, a_structure, row_a) and _picked(b, b_structure, row_b)):
            continue
        if collide(_groups(a_structure, row_a), _groups(b_structure, row_b)):
            return True
    return False


def collide(a: Sequence[int], b: Sequence[int]) -> bool:
    """SAPIEN's rule over the four integers of two shapes (`PhysxCollisionShape.set_collision_groups`)."""
    ignored = bool(a[2] & b[2]) and (a[3] & _ID) == (b[3] & _ID)
    return bool((a[0] & b[1]) or (a[1] & b[0])) and not ignored


def _picked(entity: Entity, structure: BodyStructure, row: int) -> bool:
    return entity.structures[entity.pick[row] if entity.pick else 0] is structure


def _groups(structure: BodyStructure, row: int) -> Sequence[int]:
    if structure.collision_groups is None:
        return DEFAULT_GROUPS
    return [int(x) for x in structure.collision_groups.row(row)]
