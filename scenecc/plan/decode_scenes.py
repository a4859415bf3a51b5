"""The scenes of an entity in a plan's JSON: which they are, how many objects that makes, which structure each has."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.plan.articulation import ArticulationStructure
from scenecc.plan.decode_numbers import Fault, is_list, is_object, shown

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.plan.material import PhysicalMaterial, VisualMaterial
    from scenecc.plan.scene import ScenePlan
    from scenecc.plan.value import Value

_SLICE = re.compile(r"(\d{1,9}):(\d{1,9})(?::(\d{1,9}))?")


def read_selection(data: object, limit: int) -> Sequence[int] | Fault:
    """Ascending scene indices below `limit`."""
    if isinstance(data, str):
        return _slice(data, limit)
    if not is_list(data) or not set(map(type, data)) <= {int}:
        return Fault("SC705", 'a list of scene indices or a slice such as "0:8" is wanted here')
    if not data:
        return Fault("SC709", "the entity is in no scene")
    if any(a >= b for a, b in pairwise(data)):
        return Fault("SC709", "scene indices ascend, without repetition")
    if data[0] < 0 or data[-1] >= limit:
        return Fault("SC709", f"there is no scene {shown(data[0] if data[0] < 0 else data[-1])}: there are {limit}")
    return data


def _slice(text: str, limit: int) -> range | Fault:
    match = _SLICE.fullmatch(text)
    if match is None:
        return Fault("SC705", f'{shown(text)} is no slice such as "0:8" or "0:8:2"')
    start, stop, step = int(match[1]), int(match[2]), int(match[3] or 1)
    if not step or not start < stop <= limit:
        return Fault("SC709", f"{shown(text)} selects no scenes out of {limit}")
    return range(start, stop, step)


def object_count(entity: dict[str, Any], rows: int) -> int:
    """The entity's shapes (one where it has none) summed over its scenes; what is malformed counts once.

    A shape that collides and is seen is two here and one in a scene file, whose plan must not be above its limit.
    """
    structures, pick = entity.get("structures"), entity.get("pick", 0)
    shapes = [_shape_count(structure) for structure in (structures if is_list(structures) else [])]
    picked: object = pick.get("per_scene") if is_object(pick) else None
    if is_list(picked):
        return sum(_shapes(shapes, item) for item in picked)
    return rows * _shapes(shapes, pick)


def _shape_count(structure: object) -> int:
    """Of a body, or of an articulation's links."""
    links: object = structure.get("links") if is_object(structure) else None
    bodies = [link.get("body") if is_object(link) else None for link in links] if is_list(links) else [structure]
    return max(1, sum(max(1, _length(body, "collisions"), _length(body, "visuals")) for body in bodies))


def _shapes(shapes: list[int], pick: object) -> int:
    return shapes[pick] if type(pick) is int and 0 <= pick < len(shapes) else 1


def _length(body: object, key: str) -> int:
    shapes: object = body.get(key) if is_object(body) else None
    return len(shapes) if is_list(shapes) else 0


def check_pick(pick: Value, count: int) -> Fault | None:
    """Whether there are `count` structures to pick from; keys lead to the row."""
    wrong = np.flatnonzero(pick.data >= count)
    if not wrong.size:
        return None
    message = f"there is no structure {pick.data[wrong[0]]}: the entity has {count}"
    return Fault("SC708", message, (int(wrong[0]),))


def check_materials(plan: ScenePlan) -> tuple[Fault, tuple[str | int, ...]] | None:
    """Whether materials that differ from scene to scene have a row for each scene of the entities that have them."""
    counts = {
        "physical_materials": [_row_counts(material) for material in plan.physical_materials],
        "visual_materials": [_row_counts(material) for material in plan.visual_materials],
    }
    if not any(map(any, counts.values())):
        return None
    for (i, rows), table, index, path in _materials_used(plan):
        wrong = counts[table][index] - {rows}
        if wrong:
            message = f"entry {index} of `{table}` has {max(wrong)} rows, and the entity is in {rows} scenes"
            return Fault("SC706", message), ("entities", i, "structures", *path, "material")
    return None


def _materials_used(plan: ScenePlan) -> Iterator[tuple[tuple[int, int], str, int, tuple[str | int, ...]]]:
    """The entity's number and count of scenes, the table, the index and the path of the shape in the entity."""
    for i, entity in enumerate(plan.entities):
        owner = i, len(entity.scene_idxs)
        for j, structure in enumerate(entity.structures):
            linked = isinstance(structure, ArticulationStructure)
            for number, body in enumerate(structure.bodies):
                place = (j, "links", number, "body") if linked else (j,)
                for side, table in (("collisions", "physical_materials"), ("visuals", "visual_materials")):
                    for k, shape in enumerate(getattr(body, side)):
                        for index in () if shape.material is None else np.unique(shape.material.data):
                            yield owner, table, int(index), (*place, side, k)


def _row_counts(material: PhysicalMaterial | VisualMaterial) -> set[int]:
    return {len(value.data) for value in material.values()} - {1}
