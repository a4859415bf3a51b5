"""What differs between two plans: object by object, field by field."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from scenecc.plan.camera import Camera
from scenecc.plan.compare_fields import Both, FieldDifference, Fields
from scenecc.plan.compare_order import moved
from scenecc.plan.compare_resets import Resets
from scenecc.plan.compare_tables import Tables
from scenecc.plan.constraint import Constraint
from scenecc.plan.fields import Plain, slots, type_name
from scenecc.plan.light import Environment, Light
from scenecc.plan.scene import Entity, ScenePlan, structure_word

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray


Section = Literal["plan", "physics", "entities", "constraints", "environment", "lights", "cameras"]
_Object = Entity | Constraint | Light | Camera


@dataclass(frozen=True, slots=True)
class Difference:
    """One thing in which two plans differ.

    Attributes:
        kind: "added" and "removed" are objects, links or shapes that only the second or only the first plan has;
            "moved" are objects and links that are built in another order; "changed" is all else.
        section: where the object is; "plan" for what concerns the whole.
        name: of the object; "" in "plan", "physics" and "environment".
        path: of the field in the object, as in the scene file where the shape is known to be from one, such as
            `shapes[1].radius`, and by the names of links: `links.hand.joint.limits`; "" for the object.
        a, b: what the first and the second plan have there, in a few words, in the scenes that differ; None where
            they have nothing. What says "at reset" is the same as built.
        scene_count: in how many of the scenes that both objects are in the field differs; None where it is not told
            by scene.
    """

    kind: Literal["added", "removed", "moved", "changed"]
    section: Section
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
    found += _objects("entities", a, b, tables, resets)
    found += _objects("constraints", a, b, tables, resets)
    found += _environment(a, b, tables, resets)
    found += _objects("lights", a, b, tables, resets)
    found += _objects("cameras", a, b, tables, resets)
    return found


def _of(one: FieldDifference, section: Section, name: str) -> Difference:
    return Difference(one.kind, section, name, one.path, one.a, one.b, one.scene_count)


def _environment(a: ScenePlan, b: ScenePlan, tables: Tables, resets: Resets) -> Iterator[Difference]:
    first, second = (plan.environment if plan.environment is not None else Environment() for plan in (a, b))
    count = min(a.num_scenes, b.num_scenes)
    # It has a row a scene of the batch.
    rows = None if a.num_scenes == b.num_scenes else (np.arange(count), np.arange(count))
    for one in Fields(Both(tables, resets, np.arange(count), rows)).compare_node(first, second, ""):
        yield _of(one, "environment", "")


def _objects(section: Section, a: ScenePlan, b: ScenePlan, tables: Tables, resets: Resets) -> Iterator[Difference]:
    first: dict[str, tuple[int, _Object]] = {one.name: (place, one) for place, one in enumerate(getattr(a, section))}
    second: dict[str, tuple[int, _Object]] = {one.name: (place, one) for place, one in enumerate(getattr(b, section))}
    common = [name for name in first if name in second]
    elsewhere = moved([second[name][0] for name in common])
    for name, (place, one) in first.items():
        if name not in second:
            yield Difference("removed", section, name, "", _object_words(one, a), None)
            continue
        other_place, other = second[name]
        if other_place in elsewhere:
            yield Difference("moved", section, name, "", f"number {place + 1}", f"number {other_place + 1}")
        if tables.same and resets.same_draws and one == other:
            continue
        yield from _object(section, one, other, tables, resets)
    for name, (_, one) in second.items():
        if name not in first:
            yield Difference("added", section, name, "", None, _object_words(one, b))


def _object(section: Section, a: _Object, b: _Object, tables: Tables, resets: Resets) -> Iterator[Difference]:
    rows = None
    num_scenes = tuple(plan.num_scenes for plan in resets.plans)
    scenes = np.array(a.scene_idxs, np.int64)
    if a.scene_idxs != b.scene_idxs:
        rows = _common_rows(a.scene_idxs, b.scene_idxs)
        if (len(a.scene_idxs), len(b.scene_idxs)) != num_scenes:
            first, second = _scenes_words(a.scene_idxs, num_scenes[0]), _scenes_words(b.scene_idxs, num_scenes[1])
            yield Difference("changed", section, a.name, "scene_idxs", first, second)
        if not len(rows[0]):
            return
        scenes = scenes[rows[0]]
    found = Fields(Both(tables, resets, scenes, rows)).compare_node(a, b, "", but=("name", "scene_idxs"))
    # A shape both collides and is seen, and is one in the file.
    told = {(one.path, one.kind if one.kind != "changed" else (one.a, one.b)): one for one in reversed([*found])}
    for one in reversed(told.values()):
        yield _of(one, section, a.name)


def _object_words(one: _Object, plan: ScenePlan) -> str:
    match one:
        case Entity():
            word = "|".join(dict.fromkeys(map(structure_word, one.structures)))
        case Constraint():
            word = type_name(one.joint.__class__)
        case Light():
            word = type_name(one.light.__class__)
        case Camera():
            word = f"{one.width} × {one.height} px"
    return f"{word} in {_scenes_words(one.scene_idxs, plan.num_scenes)}"


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
