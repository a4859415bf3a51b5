"""Reads values of a plan's JSON and checks them, alone and over several fields.

Alone: types, shapes and ranges. Over several: link trees, names, mounts, scene selections and material rows.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from scenecc.geometry.rotations import UNIT_TOLERANCE
from scenecc.plan.articulation import (
    MAX_LINKS,
    MOVING_JOINT_FIELDS,
    NON_LINK_FIELDS,
    ArticulationStructure,
    Joint,
    Link,
    Mimic,
)
from scenecc.plan.expect import Condition, Reading, Settled
from scenecc.plan.geometry import heights_fault
from scenecc.plan.properties import FLOAT32_MAX, Bounds, Quantity
from scenecc.plan.scene import Entity, ScenePlan, find_body, has_joint
from scenecc.plan.value import Value
from scenecc.variation.expression import OBSERVATIONS
from scenecc.variation.nodes import BUILTIN_NAMES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.plan.body import Mount, PhysicalMaterial, VisualMaterial
    from scenecc.plan.schema import ScalarKind


@dataclass(frozen=True, slots=True)
class JsonProblem:
    """What is wrong with some numbers, and where below them."""

    code: str
    message: str
    keys: tuple[str | int, ...] = ()


def is_object(data: object) -> TypeGuard[dict[str, Any]]:
    """Whether this is an object of JSON."""
    return isinstance(data, dict)


def is_list(data: object) -> TypeGuard[list[Any]]:
    """Whether this is a list of JSON."""
    return isinstance(data, list)


_JSON_TYPES = {
    "float64": (frozenset({float, int}), "a number"),
    "int64": (frozenset({int}), "an integer"),
    "bool": (frozenset({bool}), "true or false"),
}


def read_number(kind: ScalarKind, item: object) -> int | float | JsonProblem:
    """One number that is the same in every scene."""
    wanted = "a number" if kind.type is float else "an integer"
    if isinstance(item, bool) or not isinstance(item, (int, float) if kind.type is float else int):
        return JsonProblem("SC705", f"{wanted} is wanted here, not {describe_json(item)}")
    if kind.type is float and not abs(item) <= sys.float_info.max:
        return JsonProblem("SC707", f"{describe_json(item)} is outside the range: it must be finite")
    if not kind.bounds.allow(item):
        return JsonProblem("SC707", f"{describe_json(item)} is outside the range: it must be {kind.bounds}")
    return kind.type(item)  # type: ignore[return-value]


def read_rows(kind: Quantity, rows: list[Any], table_size: int | None) -> Value | JsonProblem:
    """Rows of a quantity. `table_size`: entries of the table that indices point into.

    Hundreds of thousands of numbers are checked as arrays; only when those checks fail is the culprit looked for.
    """
    if kind.shape:
        fault = _check_shape(kind.shape[0], rows)
        if fault is not None:
            return fault
    flat = list(chain.from_iterable(rows)) if kind.shape else rows
    types, word = _JSON_TYPES[kind.dtype]
    if not set(map(type, flat)) <= types:
        index = next(i for i, item in enumerate(flat) if type(item) not in types)
        return JsonProblem("SC705", f"{word} is wanted here, not {describe_json(flat[index])}", _row_keys(kind, index))
    try:
        data = np.array(rows, dtype=kind.dtype).reshape(len(rows), *kind.shape)
    except OverflowError:
        index = next(i for i, item in enumerate(flat) if abs(item) >= 2**63)
        return JsonProblem("SC707", f"{describe_json(flat[index])} is too large", _row_keys(kind, index))
    fault = _check_range(kind, data, table_size) or (_check_rotation(data) if kind.pose else None)
    if fault is None and kind.infinite:
        fault = _check_limits(data)
    if fault is not None:
        return fault
    data.flags.writeable = False
    return Value(data)


def _check_shape(count: int, rows: list[Any]) -> JsonProblem | None:
    for index, row in enumerate(rows):
        if not is_list(row):
            return JsonProblem("SC705", f"a list of {count} is wanted here, not {describe_json(row)}", (index,))
        if len(row) != count:
            return JsonProblem("SC706", f"a list of {count} is wanted here, not of {len(row)}", (index,))
    return None


def _check_range(kind: Quantity, data: NDArray[Any], table_size: int | None) -> JsonProblem | None:
    if kind.dtype == "bool":
        return None
    flat = data.reshape(-1)
    if table_size is not None:
        outside = np.flatnonzero((flat < 0) | (flat >= table_size))
        if outside.size:
            message = f"there is no entry {flat[outside[0]]} in `{kind.table}`, which has {table_size}"
            return JsonProblem("SC708", message, _row_keys(kind, int(outside[0])))
        return None
    outside = np.flatnonzero(_out_of_bounds(kind.bounds, flat))
    if not outside.size:
        return None
    item = flat[outside[0]]
    wanted = str(kind.bounds) if np.isfinite(item) else "finite"
    return JsonProblem(
        "SC707", f"{item.item()!r} is outside the range: it must be {wanted}", _row_keys(kind, int(outside[0]))
    )


def _out_of_bounds(bounds: Bounds, flat: NDArray[Any]) -> NDArray[np.bool_]:
    outside = ~((flat >= bounds.low) & (flat <= bounds.high))
    return outside | (flat == 0) if bounds.nonzero else outside


def _check_rotation(data: NDArray[Any]) -> JsonProblem | None:
    # Poses are composed by now, so that rounding of several rotations may have added up.
    with np.errstate(over="ignore"):
        wrong = np.flatnonzero(np.abs(np.linalg.norm(data[:, 3:], axis=1) - 1) > UNIT_TOLERANCE)
    if not wrong.size:
        return None
    return JsonProblem("SC707", "the rotation [w, x, y, z] is not of length 1", (int(wrong[0]),))


def _check_limits(data: NDArray[Any]) -> JsonProblem | None:
    """Pairs of a lowest and a highest number, of which the one may be -inf and the other inf."""
    low, high = data[:, 0], data[:, 1]
    wrong = np.flatnonzero((low > high) | np.isposinf(low) | np.isneginf(high))
    if wrong.size:
        message = f"the limits {data[wrong[0]].tolist()} leave nothing between them: the lower one comes first"
        return JsonProblem("SC707", message, (int(wrong[0]),))
    large = np.argwhere(np.isfinite(data) & (np.abs(data) > FLOAT32_MAX))
    if not large.size:
        return None
    row, side = large[0].tolist()
    message = f"{data[row, side].item()!r} is outside the range: it must be within ±{FLOAT32_MAX:g}, or infinite"
    return JsonProblem("SC707", message, (row, side))


def _row_keys(kind: Quantity, index: int) -> tuple[int, ...]:
    return divmod(index, kind.shape[0]) if kind.shape else (index,)


def describe_json(item: object) -> str:
    """An item of JSON in a message."""
    if is_object(item) or is_list(item):
        return "a list" if is_list(item) else "an object"
    text = json.dumps(item) if not isinstance(item, int) or abs(item) < 2**64 else "an integer beyond 64 bits"
    return text if len(text) <= 60 else text[:60] + "…"


class RepeatedKeyError(ValueError):
    """A key that stands twice in one object. Its words are the key."""


def reject_repeated_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An `object_pairs_hook`.

    Raises:
        RepeatedKeyError: a key stands twice.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        raise RepeatedKeyError(next(repr(key[:80]) for key, _ in pairs if key in seen or seen.add(key)))
    return found


def check_joint(read: dict[str, Any]) -> Iterator[JsonProblem]:
    """What is wrong with the fields of a joint."""
    if read["type"] == "fixed":
        for name in MOVING_JOINT_FIELDS:
            if read.get(name) is not None:
                yield JsonProblem("SC703", f"a fixed joint has no `{name}`", (name,))


def check_link(read: dict[str, Any]) -> Iterator[JsonProblem]:
    """What is wrong with the fields of a link."""
    body = read["body"]
    if body.body_type != "link":
        yield JsonProblem(
            "SC705", f'the body of a link is of type "link", not "{body.body_type}"', ("body", "body_type")
        )
    for name in NON_LINK_FIELDS:
        if getattr(body, name) is not None:
            yield JsonProblem("SC703", f"a link has no `{name}`", ("body", name))


def check_articulation(read: dict[str, Any]) -> Iterator[JsonProblem]:
    """What is wrong with the fields of an articulation: its links in a tree, the names of its joints."""
    links: tuple[Link, ...] = read["links"]
    if not links:
        yield JsonProblem("SC706", "an articulation has one link at least", ("links",))
    if len(links) > MAX_LINKS:
        message = f"an articulation has {MAX_LINKS} links at most, as PhysX counts them on the CPU, not {len(links)}"
        yield JsonProblem("SC706", message, ("links",))
    for index, link in enumerate(links):
        yield from _check_tree(index, link)
    joints = [(index, link.joint) for index, link in enumerate(links) if link.joint is not None]
    yield from _check_unique("links", "name", ((index, link.name) for index, link in enumerate(links)))
    yield from _check_unique("links", "joint.name", ((index, joint.name) for index, joint in joints if joint.name))
    yield from _check_mimics(read.get("mimics", ()), [joint for _, joint in joints])


def _check_tree(index: int, link: Link) -> Iterator[JsonProblem]:
    place = ("links", index)
    if index == 0:
        for name in ("parent", "joint"):
            if getattr(link, name) is not None:
                yield JsonProblem("SC714", f"the first link is the root, which has no `{name}`", (*place, name))
    elif link.parent is None or link.joint is None:
        name = "parent" if link.parent is None else "joint"
        yield JsonProblem("SC714", f"every link but the first has a `{name}`", place)
    elif link.parent >= index:
        message = f"a parent stands before its child, and link {link.parent} does not stand before link {index}"
        yield JsonProblem("SC714", message, (*place, "parent"))


def _check_mimics(mimics: tuple[Mimic, ...], joints: list[Joint]) -> Iterator[JsonProblem]:
    moving = {joint.name for joint in joints if joint.type != "fixed" and joint.name}
    for index, mimic in enumerate(mimics):
        for name in ("joint", "source"):
            wanted = getattr(mimic, name)
            if wanted not in moving:
                message = f"no joint that moves is called {describe_json(wanted)}"
                yield JsonProblem("SC715", message, ("mimics", index, name))
        if mimic.joint == mimic.source:
            yield JsonProblem("SC715", "a joint cannot follow itself", ("mimics", index, "source"))
    yield from _check_unique("mimics", "joint", ((index, mimic.joint) for index, mimic in enumerate(mimics)))


def check_structures(read: dict[str, Any]) -> Iterator[JsonProblem]:
    """What is wrong with the structures of an entity: all are bodies or all are articulations, and none is a link."""
    structures = read["structures"]
    if not structures:
        yield JsonProblem("SC706", "an entity has one structure at least", ("structures",))
    if len({isinstance(structure, ArticulationStructure) for structure in structures}) > 1:
        yield JsonProblem("SC705", "the structures of an entity are all bodies or all articulations", ("structures",))
    for index, structure in enumerate(structures):
        if not isinstance(structure, ArticulationStructure) and structure.body_type == "link":
            yield JsonProblem("SC705", "a link is part of an articulation", ("structures", index, "body_type"))


def check_axes(read: dict[str, Any]) -> Iterator[JsonProblem]:
    """What is wrong with the axes of a drive between two bodies: each has its limits and its drive once."""
    for name in ("limits", "drives"):
        yield from _check_unique(name, "axis", ((index, item.axis) for index, item in enumerate(read.get(name, ()))))


def check_heights(read: dict[str, Any]) -> Iterator[JsonProblem]:
    """What is wrong with the heights of terrain."""
    fault = heights_fault(read["heights"]) if "heights" in read else None
    if fault is not None:
        yield JsonProblem("SC706", fault, ("heights",))


def _check_unique(above: str, key: str, names: Iterable[tuple[int, str]]) -> Iterator[JsonProblem]:
    seen: dict[str, int] = {}
    for index, name in names:
        if seen.setdefault(name, index) != index:
            message = f"{describe_json(name)} stands twice: {above} {seen[name]} and {index}"
            yield JsonProblem("SC710", message, (above, index, *key.split(".")))


NAMESPACES = (("entities", "cameras"), ("constraints",), ("lights",), ("placements",), ("expectations",))
"""Sections whose objects have different names."""

_MOUNT_KEYS = (("constraints", "child"), ("constraints", "parent"), ("lights", "mount"), ("cameras", "mount"))
"""Sections whose objects hold on to something, and under which key."""


def check_names(data: dict[str, Any]) -> Iterator[JsonProblem]:
    """Names that stand twice, in plain data."""
    for sections in NAMESPACES:
        seen: dict[str, tuple[str, int]] = {}
        for section in sections:
            items: object = data.get(section)
            for index, item in enumerate(items if is_list(items) else ()):
                name: object = item.get("name") if is_object(item) else None
                if not isinstance(name, str):
                    continue
                first = seen.setdefault(name, (section, index))
                if first != (section, index):
                    before = f"{first[0]} {first[1]} and {'' if section == first[0] else f'{section} '}{index}"
                    yield JsonProblem(
                        "SC710", f"the name {describe_json(name)} stands twice: {before}", (section, index, "name")
                    )


def check_mounts(plan: ScenePlan) -> Iterator[JsonProblem]:
    """What constraints, lights and cameras hold on to and is not there."""
    entities = {entity.name: entity for entity in plan.entities}
    for section, key in _MOUNT_KEYS:
        for index, holder in enumerate(getattr(plan, section)):
            mount: Mount | None = getattr(holder, key)
            if mount is not None:
                for fault in _check_mount(mount, entities, holder.scene_idxs):
                    yield JsonProblem(fault.code, fault.message, (section, index, key, *fault.keys))


def check_placements(plan: ScenePlan) -> Iterator[JsonProblem]:
    """What placements name and is not there."""
    known = {entity.name for entity in plan.entities}
    for index, one in enumerate(plan.placements):
        named = [("target", one.target.entity), *(("members", name) for name in one.entities)]
        named += [("near", near.entity) for near in one.near]
        named += [("carriers", name) for name in one.carrying]
        named += [("facing", one.facing.entity)] if one.facing is not None else []
        for key, name in named:
            if name not in known:
                message = f"no entity is called {describe_json(name)}"
                yield JsonProblem("SC715", message, ("placements", index, key))


def check_expectations(plan: ScenePlan) -> Iterator[JsonProblem]:
    """What expectations name and is not there."""
    entities = {entity.name: entity for entity in plan.entities}
    draws = {name for name, _ in plan.draws}
    for index, one in enumerate(plan.expectations):
        keys = ("expectations", index)
        if isinstance(one, Condition):
            meant = {reading.name for reading in one.readings}
            for name in sorted({*one.that.names, *one.that.observations} - BUILTIN_NAMES - meant):
                yield JsonProblem("SC708", f"no reading is called {describe_json(name)}", (*keys, "that"))
            for number, reading in enumerate(one.readings):
                yield from _check_reading(reading, entities, draws, (*keys, "readings", number))
            continue
        excepted = (
            one.excepted if isinstance(one, Settled) else [name for each in one.excepted for name in (each.a, each.b)]
        )
        for key, names in (("entities", one.entities or ()), ("excepted", excepted)):
            for name in names:
                if find_body(name, entities) is None:
                    yield JsonProblem("SC715", f"no entity or link is called {describe_json(name)}", (*keys, key))


def _check_reading(
    reading: Reading, entities: dict[str, Entity], draws: set[str], keys: tuple[str | int, ...]
) -> Iterator[JsonProblem]:
    count = len(OBSERVATIONS.get(reading.kind, ("draw",)))
    if len(reading.of) != count:
        yield JsonProblem("SC706", f"{count} names are wanted here", (*keys, "of"))
    elif reading.kind == "draw":
        if reading.of[0] not in draws:
            yield JsonProblem("SC708", f"there is no shared draw {describe_json(reading.of[0])}", (*keys, "of"))
    else:
        bodies, joints = (reading.of[:1], reading.of[1:]) if reading.kind == "qpos" else (reading.of, ())
        for name in bodies:
            found = find_body(name, entities)
            if found is None:
                yield JsonProblem("SC715", f"no entity or link is called {describe_json(name)}", (*keys, "of"))
            elif missing := [joint for joint in joints if not has_joint(found[0], joint)]:
                message = f"no joint that moves is called {describe_json(missing[0])}"
                yield JsonProblem("SC715", message, (*keys, "of"))


def _check_mount(mount: Mount, entities: dict[str, Entity], scene_idxs: tuple[int, ...]) -> Iterator[JsonProblem]:
    entity = entities.get(mount.entity)
    if entity is None:
        yield JsonProblem("SC715", f"no entity is called {describe_json(mount.entity)}", ("entity",))
        return
    if scene_idxs != entity.scene_idxs and not set(scene_idxs) <= set(entity.scene_idxs):
        missing = min(set(scene_idxs) - set(entity.scene_idxs))
        yield JsonProblem("SC709", f"{describe_json(mount.entity)} is not in scene {missing}", ("entity",))
    for structure in entity.structures:
        if not isinstance(structure, ArticulationStructure):
            if mount.link is not None:
                yield JsonProblem("SC715", f"{describe_json(mount.entity)} is a body and has no links", ("link",))
                return
        elif mount.link is None:
            yield JsonProblem("SC704", f"{describe_json(mount.entity)} is an articulation: the key `link` is missing")
            return
        elif all(link.name != mount.link for link in structure.links):
            yield JsonProblem(
                "SC715", f"no link of {describe_json(mount.entity)} is called {describe_json(mount.link)}", ("link",)
            )
            return


_SLICE_PATTERN = re.compile(r"(\d{1,9}):(\d{1,9})(?::(\d{1,9}))?")


def read_selection(data: object, limit: int) -> Sequence[int] | JsonProblem:
    """Ascending scene indices below `limit`."""
    if isinstance(data, str):
        return _read_slice(data, limit)
    if not is_list(data) or not set(map(type, data)) <= {int}:
        return JsonProblem("SC705", 'a list of scene indices or a slice such as "0:8" is wanted here')
    if not data:
        return JsonProblem("SC709", "the entity is in no scene")
    if any(a >= b for a, b in pairwise(data)):
        return JsonProblem("SC709", "scene indices ascend, without repetition")
    if data[0] < 0 or data[-1] >= limit:
        return JsonProblem(
            "SC709", f"there is no scene {describe_json(data[0] if data[0] < 0 else data[-1])}: there are {limit}"
        )
    return data


def _read_slice(text: str, limit: int) -> range | JsonProblem:
    match = _SLICE_PATTERN.fullmatch(text)
    if match is None:
        return JsonProblem("SC705", f'{describe_json(text)} is no slice such as "0:8" or "0:8:2"')
    start, stop, step = int(match[1]), int(match[2]), int(match[3] or 1)
    if not step or not start < stop <= limit:
        return JsonProblem("SC709", f"{describe_json(text)} selects no scenes out of {limit}")
    return range(start, stop, step)


def count_objects(entity: dict[str, Any], rows: int) -> int:
    """The entity's shapes (one where it has none) summed over its scenes; what is malformed counts once.

    A shape that collides and is seen is two here and one in a scene file, whose plan must not be above its limit.
    """
    structures, pick = entity.get("structures"), entity.get("pick", 0)
    shapes = [_count_shapes(structure) for structure in (structures if is_list(structures) else [])]
    picked: object = pick.get("per_scene") if is_object(pick) else None
    if is_list(picked):
        return sum(_picked_shape_count(shapes, item) for item in picked)
    return rows * _picked_shape_count(shapes, pick)


def _count_shapes(structure: object) -> int:
    """Of a body, or of an articulation's links."""
    links: object = structure.get("links") if is_object(structure) else None
    bodies = [link.get("body") if is_object(link) else None for link in links] if is_list(links) else [structure]
    return max(1, sum(max(1, _list_length(body, "collisions"), _list_length(body, "visuals")) for body in bodies))


def _picked_shape_count(shapes: list[int], pick: object) -> int:
    return shapes[pick] if type(pick) is int and 0 <= pick < len(shapes) else 1


def _list_length(body: object, key: str) -> int:
    shapes: object = body.get(key) if is_object(body) else None
    return len(shapes) if is_list(shapes) else 0


def check_pick(pick: Value, count: int) -> JsonProblem | None:
    """Whether there are `count` structures to pick from; keys lead to the row."""
    wrong = np.flatnonzero(pick.data >= count)
    if not wrong.size:
        return None
    message = f"there is no structure {pick.data[wrong[0]]}: the entity has {count}"
    return JsonProblem("SC708", message, (int(wrong[0]),))


def check_materials(plan: ScenePlan) -> tuple[JsonProblem, tuple[str | int, ...]] | None:
    """Whether materials that differ from scene to scene have a row for each scene of the entities that have them."""
    counts = {
        "physical_materials": [_row_counts(material) for material in plan.physical_materials],
        "visual_materials": [_row_counts(material) for material in plan.visual_materials],
    }
    if not any(map(any, counts.values())):
        return None
    for (i, rows), table, index, path in _used_materials(plan):
        wrong = counts[table][index] - {rows}
        if wrong:
            message = f"entry {index} of `{table}` has {max(wrong)} rows, and the entity is in {rows} scenes"
            return JsonProblem("SC706", message), ("entities", i, "structures", *path, "material")
    return None


def _used_materials(plan: ScenePlan) -> Iterator[tuple[tuple[int, int], str, int, tuple[str | int, ...]]]:
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
