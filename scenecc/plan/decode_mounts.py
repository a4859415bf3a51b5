"""What no section of a plan tells alone: that names differ, and that what is held on to is there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.plan.articulation import ArticulationStructure
from scenecc.plan.decode_numbers import Fault, is_list, is_object, shown

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.plan.mount import Mount
    from scenecc.plan.scene import Entity, ScenePlan

NAMESPACES = (("entities", "cameras"), ("constraints",), ("lights",))
"""Sections whose objects have different names."""

_HELD_BY = (("constraints", "child"), ("constraints", "parent"), ("lights", "mount"), ("cameras", "mount"))
"""Sections whose objects hold on to something, and under which key."""


def name_faults(data: dict[str, Any]) -> Iterator[Fault]:
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
                    yield Fault("SC710", f"the name {shown(name)} stands twice: {before}", (section, index, "name"))


def mount_faults(plan: ScenePlan) -> Iterator[Fault]:
    """What constraints, lights and cameras hold on to and is not there."""
    entities = {entity.name: entity for entity in plan.entities}
    for section, key in _HELD_BY:
        for index, holder in enumerate(getattr(plan, section)):
            mount: Mount | None = getattr(holder, key)
            if mount is not None:
                for fault in _mount_faults(mount, entities, holder.scene_idxs):
                    yield Fault(fault.code, fault.message, (section, index, key, *fault.keys))


def _mount_faults(mount: Mount, entities: dict[str, Entity], scene_idxs: tuple[int, ...]) -> Iterator[Fault]:
    entity = entities.get(mount.entity)
    if entity is None:
        yield Fault("SC715", f"no entity is called {shown(mount.entity)}", ("entity",))
        return
    if scene_idxs != entity.scene_idxs and not set(scene_idxs) <= set(entity.scene_idxs):
        missing = min(set(scene_idxs) - set(entity.scene_idxs))
        yield Fault("SC709", f"{shown(mount.entity)} is not in scene {missing}", ("entity",))
    for structure in entity.structures:
        if not isinstance(structure, ArticulationStructure):
            if mount.link is not None:
                yield Fault("SC715", f"{shown(mount.entity)} is a body and has no links", ("link",))
                return
        elif mount.link is None:
            yield Fault("SC704", f"{shown(mount.entity)} is an articulation: the key `link` is missing")
            return
        elif all(link.name != mount.link for link in structure.links):
            yield Fault("SC715", f"no link of {shown(mount.entity)} is called {shown(mount.link)}", ("link",))
            return
