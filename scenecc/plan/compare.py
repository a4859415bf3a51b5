"""What differs between two plans: object by object, field by field."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from scenecc.plan.compare_fields import FieldDifference, Fields
from scenecc.plan.compare_tables import Tables
from scenecc.plan.fields import Plain, slots
from scenecc.plan.scene import Entity, ScenePlan

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing in which two plans differ.

    Attributes:
        kind: "added" and "removed" are objects or shapes that only the second or only the first plan has; "moved" are
            entities that are built in another order; "changed" is all else.
        section: where the object is; "plan" for what concerns the whole.
        name: of the entity or draw; "" in "plan" and "physics".
        path: of the field in the object, such as `structures[0].collisions[1].geometry.radius`; "" for the object.
        a, b: what the first and the second plan have there, in a few words; None where they have nothing.
        scene_count: in how many of the scenes that both objects are in the field differs; None where it is not told
            by scene.
    """

    kind: Literal["added", "removed", "moved", "changed"]
    section: Literal["plan", "physics", "draws", "entities"]
    name: str
    path: str
    a: str | None
    b: str | None
    scene_count: int | None = None


def differences(a: ScenePlan, b: ScenePlan) -> list[Difference]:
    """Everything in which two plans differ in what they build, and in `name`, `description` and `seed`.

    The order of the tables of files and materials and what nothing refers to in them are no difference. Files are one
    if their uris or their places are. Rows of values are compared scene by scene, in the scenes that both have;
    entities that share no scene differ in their scenes alone.
    """
    found: list[Difference] = []
    for slot in slots(ScenePlan):
        x, y = getattr(a, slot.name), getattr(b, slot.name)
        if isinstance(slot.kind, Plain) and x != y:
            found.append(Difference("changed", "plan", "", slot.name, str(x), str(y)))
    tables = Tables(a, b)
    physics = Fields(tables).compare_node(a.physics, b.physics, "")
    found += [_of(one, "physics", "") for one in physics]
    found += _draws(dict(a.draws), dict(b.draws))
    found += _entities(a, b, tables)
    return found


def _of(one: FieldDifference, section: Literal["physics", "entities"], name: str) -> Difference:
    return Difference(one.kind, section, name, one.path, one.a, one.b, one.scene_count)


def _draws(a: Mapping[str, Any], b: Mapping[str, Any]) -> Iterator[Difference]:
    if not a and not b:
        return
    from scenecc.plan.compare_fields import recipe_words  # noqa: PLC0415 - most plans have no recipes

    for name in {**a, **b}:
        x, y = a.get(name), b.get(name)
        if repr(x) != repr(y):
            words = [None if node is None else recipe_words(node) for node in (x, y)]
            yield Difference(_kind(x, y), "draws", name, "", words[0], words[1])


def _kind(x: object, y: object) -> Literal["added", "removed", "changed"]:
    return "added" if x is None else "removed" if y is None else "changed"


def _entities(a: ScenePlan, b: ScenePlan, tables: Tables) -> Iterator[Difference]:
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
        if tables.same and entity == other and a.num_scenes == b.num_scenes:
            continue
        yield from _entity(entity, other, (a.num_scenes, b.num_scenes), tables)
    for name, (_, entity) in second.items():
        if name not in first:
            yield Difference("added", "entities", name, "", None, _entity_words(entity, b))


def _entity(a: Entity, b: Entity, num_scenes: tuple[int, int], tables: Tables) -> Iterator[Difference]:
    rows = None
    if a.scene_idxs != b.scene_idxs:
        rows = _common_rows(a.scene_idxs, b.scene_idxs)
        if (len(a.scene_idxs), len(b.scene_idxs)) != num_scenes:
            first, second = _scenes_words(a.scene_idxs, num_scenes[0]), _scenes_words(b.scene_idxs, num_scenes[1])
            yield Difference("changed", "entities", a.name, "scene_idxs", first, second)
        if not len(rows[0]):
            return
    fields = Fields(tables, len(a.scene_idxs), rows)
    for one in fields.compare_node(a, b, "", but=("name", "scene_idxs")):
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
