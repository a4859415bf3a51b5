"""Consistency between the fields of a plan that is read from JSON: names, trees, row counts.

Consumers of a plan rely on it. The compiler always makes consistent plans.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.plan.articulation import (
    MAX_LINKS,
    MOVING_JOINT_FIELDS,
    NON_LINK_FIELDS,
    ArticulationStructure,
    Joint,
    Link,
)
from scenecc.plan.constraint import Drive
from scenecc.plan.expect import Condition, Expectation, Reading, Settled
from scenecc.plan.geometry import Heightfield, heights_fault
from scenecc.plan.scene import Entity, ScenePlan, find_body, has_joint
from scenecc.plan.starts import start_faults
from scenecc.variation.expression import OBSERVATIONS
from scenecc.variation.nodes import BUILTIN_NAMES

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path as Keys
    from scenecc.plan.body import Mount

_NAMESPACES: Final = (("entities", "cameras"), ("constraints",), ("lights",), ("placements",), ("expectations",))
"""Groups of sections that share a namespace."""

_MOUNT_KEYS: Final = (("constraints", "child"), ("constraints", "parent"), ("lights", "mount"), ("cameras", "mount"))
"""Sections whose objects are attached to an entity, and the key with its name."""


class PlanFormatError(Exception):
    """JSON is not a plan of this version. `keys`: path to the missing or invalid value."""

    def __init__(self, keys: Keys) -> None:
        super().__init__()
        self.keys = keys


def _joint_faults(joint: Joint) -> Iterator[Keys]:
    if joint.type == "fixed":
        yield from ((name,) for name in MOVING_JOINT_FIELDS if getattr(joint, name) is not None)


def _link_faults(link: Link) -> Iterator[Keys]:
    if link.body.body_type != "link":
        yield ("body", "body_type")
    yield from (("body", name) for name in NON_LINK_FIELDS if getattr(link.body, name) is not None)


def _articulation_faults(one: ArticulationStructure) -> Iterator[Keys]:
    if not 1 <= len(one.links) <= MAX_LINKS:
        yield ("links",)
    for index, link in enumerate(one.links):
        is_root = link.parent is None and link.joint is None
        is_child = link.parent is not None and link.parent < index and link.joint is not None
        if not (is_child if index else is_root):
            yield ("links", index)
    joints = [link.joint for link in one.links if link.joint is not None]
    for index in _find_repeats(link.name for link in one.links):
        yield ("links", index, "name")
    if any(_find_repeats(joint.name for joint in joints if joint.name)):
        yield ("links",)
    moving = {joint.name for joint in joints if joint.type != "fixed" and joint.name}
    for index, mimic in enumerate(one.mimics):
        if not {mimic.joint, mimic.source} <= moving or mimic.joint == mimic.source:
            yield ("mimics", index)
    for index in _find_repeats(mimic.joint for mimic in one.mimics):
        yield ("mimics", index, "joint")


def _entity_faults(entity: Entity) -> Iterator[Keys]:
    types = {getattr(structure, "body_type", "articulation") for structure in entity.structures}
    if not types or "link" in types or ("articulation" in types and len(types) > 1):
        yield ("structures",)
    if entity.pick is not None and (entity.pick.data >= len(entity.structures)).any():
        yield ("pick",)


def _drive_faults(drive: Drive) -> Iterator[Keys]:
    for name in ("limits", "drives"):
        for index in _find_repeats(one.axis for one in getattr(drive, name)):
            yield (name, index, "axis")


def _find_repeats(items: Iterable[Hashable]) -> Iterator[int]:
    """Indices of the items that equal an earlier one."""
    first: dict[Hashable, int] = {}
    return (index for index, item in enumerate(items) if first.setdefault(item, index) != index)


def _plan_faults(plan: ScenePlan) -> Iterator[Keys]:
    for sections in _NAMESPACES:
        named = [(section, index, one.name) for section in sections for index, one in enumerate(getattr(plan, section))]
        for number in _find_repeats(name for *_, name in named):
            yield (*named[number][:2], "name")
    entities = {entity.name: entity for entity in plan.entities}
    for section, key in _MOUNT_KEYS:
        for index, holder in enumerate(getattr(plan, section)):
            mount: Mount | None = getattr(holder, key)
            if mount is not None and not _is_mountable(mount, entities.get(mount.entity), holder.scene_idxs):
                yield (section, index, key)
    for index, one in enumerate(plan.placements):
        named = [one.target.entity, *one.entities, *one.carrying, *(near.entity for near in one.near)]
        named += [] if one.facing is None else [one.facing.entity]
        named += [] if one.next_to is None else [one.next_to.mount.entity]
        if not entities.keys() >= {*named}:
            yield ("placements", index)
    draws = {name for name, _ in plan.draws}
    for index, one in enumerate(plan.expectations):
        if not _is_known(one, entities, draws):
            yield ("expectations", index)
    yield from (("starts", index) for index in start_faults(plan))
    yield from _material_faults(plan)


def _is_mountable(mount: Mount, entity: Entity | None, scene_idxs: tuple[int, ...]) -> bool:
    """Whether the entity exists in all the scenes and each of its structures has the link."""
    if entity is None or (scene_idxs != entity.scene_idxs and not {*scene_idxs} <= {*entity.scene_idxs}):
        return False
    return all(
        any(link.name == mount.link for link in structure.links)
        if isinstance(structure, ArticulationStructure)
        else mount.link is None
        for structure in entity.structures
    )


def _is_known(one: Expectation, entities: dict[str, Entity], draws: set[str]) -> bool:
    """Whether the plan has everything that an expectation refers to."""
    if isinstance(one, Condition):
        names = {*one.that.names, *one.that.observations}
        return names <= BUILTIN_NAMES | {reading.name for reading in one.readings} and all(
            _is_readable(reading, entities, draws) for reading in one.readings
        )
    pairs = one.excepted if isinstance(one, Settled) else [name for pair in one.excepted for name in (pair.a, pair.b)]
    return all(find_body(name, entities) is not None for name in (*(one.entities or ()), *pairs))


def _is_readable(reading: Reading, entities: dict[str, Entity], draws: set[str]) -> bool:
    if len(reading.of) != len(OBSERVATIONS.get(reading.kind, ("draw",))):
        return False
    if reading.kind == "draw":
        return reading.of[0] in draws
    bodies, joints = (reading.of[:1], reading.of[1:]) if reading.kind == "qpos" else (reading.of, ())
    found = [find_body(name, entities) for name in bodies]
    return all(one is not None and all(has_joint(one[0], joint) for joint in joints) for one in found)


def _material_faults(plan: ScenePlan) -> Iterator[Keys]:
    """Shapes whose material does not have a row for each scene of the entity."""
    counts = {
        side: [{len(value.data) for value in material.values()} - {1} for material in table]
        for side, table in (("collisions", plan.physical_materials), ("visuals", plan.visual_materials))
    }
    for index, entity in enumerate(plan.entities) if any(map(any, counts.values())) else ():
        for side, rows in counts.items():
            shapes = [shape for body in entity.bodies for shape in getattr(body, side) if shape.material is not None]
            used = {int(number) for shape in shapes for number in np.unique(shape.material.data)}
            if any(rows[number] - {len(entity.scene_idxs)} for number in used):
                yield ("entities", index)


FAULTS: Final[dict[type, Callable[[Any], Iterator[Keys]]]] = {
    Joint: _joint_faults,
    Link: _link_faults,
    ArticulationStructure: _articulation_faults,
    Entity: _entity_faults,
    Drive: _drive_faults,
    Heightfield: lambda one: iter((("heights",),) if heights_fault(one.heights) else ()),
    ScenePlan: _plan_faults,
}
"""Class → paths below an object to its inconsistent values."""
