"""What differs between two plans: object by object, field by field."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from scenecc.plan.compare_fields import Both, FieldDifference, Fields
from scenecc.plan.compare_resets import Resets
from scenecc.plan.compare_tables import Tables
from scenecc.plan.fields import Plain, slots
from scenecc.plan.scene import Entity, ScenePlan

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing in which two plans differ.

    Attributes:
        kind: "added" and "removed" are objects or shapes that only the second or only the first plan has; "moved" are
            entities that are built in another order; "changed" is all else.
        section: where the object is; "plan" for what concerns the whole.
        name: of the entity; "" in "plan" and "physics".
        path: of the field in the object, as in the scene file where the shape is known to be from one, such as
            `shapes[1].radius`; "" for the object.
        a, b: what the first and the second plan have there, in a few words, in the scenes that differ; None where
            they have nothing. What says "at reset" is the same as built.
        scene_count: in how many of the scenes that both objects are in the field differs; None where it is not told
            by scene.
    """

    kind: Literal["added", "removed", "moved", "changed"]
    section: Literal["plan", "physics", "entities"]
    name: str
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


def differences(a: ScenePlan, b: ScenePlan) -> list[Difference]:
    """Everything in which two plans differ in what they build and reset, and in `name`, `description` and `seed`.

    Two recipes are the same if they give the same, to the bit, in every scene with each of some seeds
    (`compare_resets`), whatever they are made of; shared draws count by what reads them.

    The order of the tables of files and materials and what nothing refers to in them are no difference. Files are one
    if their uris or their places are. Rows of values are compared scene by scene, in the scenes that both have;
    entities that share no scene differ in their scenes alone.
    """
    found: list[Difference] = []
    for slot in slots(ScenePlan):
        x, y = getattr(a, slot.name), getattr(b, slot.name)
        if isinstance(slot.kind, Plain) and x != y:
            found.append(Difference("changed", "plan", "", slot.name, str(x), str(y)))
    tables, resets = Tables(a, b), Resets(a, b)
    physics = Fields(Both(tables, resets, np.zeros(1, np.int64))).compare_node(a.physics, b.physics, "")
    found += [_of(one, "physics", "") for one in physics]
    found += _entities(a, b, tables, resets)
    return found


def _of(one: FieldDifference, section: Literal["physics", "entities"], name: str) -> Difference:
    return Difference(one.kind, section, name, one.path, one.a, one.b, one.scene_count)


def _entities(a: ScenePlan, b: ScenePlan, tables: Tables, resets: Resets) -> Iterator[Difference]:
    first = {entity.name: (place, entity) for place, entity in enumerate(a.entities)}
    second = {entity.name: (place, entity) for place, entity in enumerate(b.entities)}
    common = [name for name in first if name in second]
    moved = _moved([second[name][0] for name in common])
    for name, (place, entity) in first.items():
        if name not in second:
            yield Difference("removed", "entities", name, "", _entity_words(entity, a), None)
            continue
        other_place, other = second[name]
        if other_place in moved:
            yield Difference("moved", "entities", name, "", f"number {place + 1}", f"number {other_place + 1}")
        if tables.same and resets.same_draws and entity == other:
            continue
        yield from _entity(entity, other, tables, resets)
    for name, (_, entity) in second.items():
        if name not in first:
            yield Difference("added", "entities", name, "", None, _entity_words(entity, b))


def _entity(a: Entity, b: Entity, tables: Tables, resets: Resets) -> Iterator[Difference]:
    rows = None
    num_scenes = tuple(plan.num_scenes for plan in resets.plans)
    scenes = np.array(a.scene_idxs, np.int64)
    if a.scene_idxs != b.scene_idxs:
        rows = _common_rows(a.scene_idxs, b.scene_idxs)
        if (len(a.scene_idxs), len(b.scene_idxs)) != num_scenes:
            first, second = _scenes_words(a.scene_idxs, num_scenes[0]), _scenes_words(b.scene_idxs, num_scenes[1])
            yield Difference("changed", "entities", a.name, "scene_idxs", first, second)
        if not len(rows[0]):
            return
        scenes = scenes[rows[0]]
    found = Fields(Both(tables, resets, scenes, rows)).compare_node(a, b, "", but=("name", "scene_idxs"))
    # A shape both collides and is seen, and is one in the file.
    told = {(one.path, one.kind if one.kind != "changed" else (one.a, one.b)): one for one in reversed([*found])}
    for one in reversed(told.values()):
        yield _of(one, "entities", a.name)


def _entity_words(entity: Entity, plan: ScenePlan) -> str:
    types = "|".join(dict.fromkeys(structure.body_type for structure in entity.structures))
    return f"{types} in {_scenes_words(entity.scene_idxs, plan.num_scenes)}"


def _scenes_words(scene_idxs: tuple[int, ...], num_scenes: int) -> str:
    if len(scene_idxs) == num_scenes:
        return "every scene"
    if len(scene_idxs) > 1 and scene_idxs[-1] - scene_idxs[0] == len(scene_idxs) - 1:
        return f"scenes {scene_idxs[0]} to {scene_idxs[-1]}"
    shown = ", ".join(map(str, scene_idxs[:8]))
    if len(scene_idxs) > 8:
        return f"scenes {shown}, …"
    return f"scene {shown}" if len(scene_idxs) == 1 else f"scenes {shown}"


def _common_rows(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows of the scenes that are in both."""
    _, first, second = np.intersect1d(a, b, assume_unique=True, return_indices=True)
    return first, second


def _moved(places: Sequence[int]) -> set[int]:
    """The fewest that must move for the rest to ascend."""
    ends: list[int] = []
    before: list[int | None] = []
    tails: list[int] = []
    for number, place in enumerate(places):
        at = bisect_left(ends, place)
        before.append(tails[at - 1] if at else None)
        ends[at : at + 1] = [place]
        tails[at : at + 1] = [number]
    stay: set[int] = set()
    number = tails[-1] if tails else None
    while number is not None:
        stay.add(places[number])
        number = before[number]
    return set(places) - stay
