"""How many physical materials a plan needs in a process."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from scenecc.plan import Entity, ScenePlan, Value
    from scenecc.plan.body import PhysicalMaterial
    from scenecc.variation.node_bounds import BoundsAnalysis

MATERIAL_LIMIT: Final = 65_534
"""PhysX has 65 535 material numbers in a process, and its default material takes one."""

_MAX_COMBINATIONS: Final = 4096


def drawn_combinations(material: PhysicalMaterial, analysis: BoundsAnalysis | None) -> set[tuple[float, ...]] | None:
    """Returns the combinations of numbers that a varying material may have; None if there are too many to share.

    Args:
        material: of a plan.
        analysis: of the plan's draws; None: the plan has no recipes yet.
    """
    each: list[list[float]] = []
    for value in material.values():
        found = _alternatives(value, analysis)
        if found is None:
            return None
        each.append(found)
    return set(product(*each)) if len(each[0]) * len(each[1]) * len(each[2]) <= _MAX_COMBINATIONS else None


def _alternatives(value: Value, analysis: BoundsAnalysis | None) -> list[float] | None:
    if value.is_constant:
        return [*value.numbers()]
    if value.recipe is not None and analysis is not None:
        found = analysis.bounds(value.recipe).alternatives
    else:
        found = value.bounds.alternatives
    return None if found is None else [*map(float, found)]


def count_materials(plan: ScenePlan) -> tuple[int, int, Entity | None]:
    """Returns how many physical materials all scenes need, about, how many of these are of single scenes, and the first
    entity that has such a one.
    """
    shared: set[tuple[object, ...]] = set()
    scenes: dict[int, set[int]] = {}
    first: Entity | None = None
    for entity in plan.entities:
        for body in entity.bodies:
            for shape in body.collisions:
                for index in () if shape.material is None else set(map(int, shape.material.numbers())):
                    material = plan.physical_materials[index]
                    if all(value.is_constant for value in material.values()):
                        shared.add((index,))
                    elif (several := drawn_combinations(material, None)) is not None:
                        shared |= several
                    else:
                        scenes.setdefault(index, set()).update(entity.scene_idxs)
                        first = first or entity
    own = sum(map(len, scenes.values()))
    return len(shared) + own + (plan.physics.default_material is not None), own, first
