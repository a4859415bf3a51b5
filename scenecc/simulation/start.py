"""Findings at the start: bodies that overlap, links of a robot that clash, and bodies that nothing supports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.plan import BodyStructure
from scenecc.simulation.findings import Finding, length_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.backends.sapien import SceneBatch
    from scenecc.backends.sapien.contacts import Contacts
    from scenecc.plan import ScenePlan
    from scenecc.simulation.bodies import MovingBody

OVERLAP: Final = 0.0005
"""By how much bodies may penetrate each other at the start [m]: PhysX pushes them apart slowly enough to go unseen."""


def overlaps(contacts: Contacts, plan: ScenePlan) -> Iterator[Finding]:
    """Bodies that penetrate each other, by the contacts of the first step, which PhysX finds before anything moves.

    Args:
        contacts: of that step.
        plan: of the scenes.
    """
    articulations = {entity.name for entity in plan.entities if not isinstance(entity.structures[0], BodyStructure)}
    fixed = _fixed_bodies(plan)
    deep = np.flatnonzero(contacts.separation < -OVERLAP)
    deepest: dict[tuple[int, str, str], tuple[float, str, str]] = {}
    for number in deep.tolist():
        a, b = str(contacts.a[number]), str(contacts.b[number])
        if a in fixed and b in fixed:
            continue
        owners = _owner(a, articulations), _owner(b, articulations)
        # Of two entities the deepest pair of links is told, of one robot every pair.
        key = int(contacts.scene[number]), *((a, b) if owners[0] == owners[1] else owners)
        deepest[key] = max(deepest.get(key, (0.0, "", "")), (-float(contacts.separation[number]), a, b))
    for (scene, *names), (depth, a, b) in deepest.items():
        by = f"by {length_text(depth)} at the start"
        if _owner(a, articulations) == _owner(b, articulations):
            yield Finding("SC851", tuple(names), scene, depth, f"the links `{a}` and `{b}` overlap {by}")
        else:
            yield Finding("SC850", tuple(names), scene, depth, f"`{a}` and `{b}` overlap {by}")


def _owner(name: str, articulations: set[str]) -> str:
    """The entity of ENTITY or ENTITY/LINK."""
    owner = name
    while owner not in articulations and "/" in owner:
        owner = owner.rpartition("/")[0]
    return owner if owner in articulations else name


def _fixed_bodies(plan: ScenePlan) -> set[str]:
    """Static and kinematic bodies, and links that nothing can move: fixed to a root that is fixed, in each scene."""
    fixed: set[str] = set()
    for entity in plan.entities:
        moving: set[str] = set()
        for structure in entity.structures:
            if isinstance(structure, BodyStructure):
                moving |= {entity.name} if structure.body_type == "dynamic" else set()
                continue
            held: dict[str, bool] = {}
            for link in structure.links:
                if link.joint is None or link.parent is None:
                    held[link.name] = structure.fix_root_link
                else:
                    held[link.name] = link.joint.type == "fixed" and held[structure.links[link.parent].name]
            moving |= {f"{entity.name}/{name}" for name, stays in held.items() if not stays}
            fixed |= {f"{entity.name}/{name}" for name in held}
        fixed = (fixed | {entity.name}) - moving
    return fixed


def unsupported(batch: SceneBatch, moving: list[MovingBody]) -> Iterator[Finding]:
    """Dynamic bodies with nothing below them that could hold them, so that they fall for ever."""
    held = {mount.entity for one in batch.plan.constraints for mount in (one.child, one.parent) if mount is not None}
    falling = [body for body in moving if body.entity not in held and _falls(body)]
    by_scene: dict[int, list[MovingBody]] = {}
    for body in falling:
        by_scene.setdefault(body.scene, []).append(body)
    for scene, bodies in by_scene.items():
        components = [each for each in _components(batch, scene) if each.collision_shapes]
        if any(_is_endless(each) for each in components):
            continue
        boxes = np.array([each.get_global_aabb_fast() for each in components], np.float64).reshape(-1, 2, 3)
        for body in bodies:
            own = np.array([_is_part(each, body.component) for each in components])
            low, high = boxes[own].min(axis=0)[0], boxes[own].max(axis=0)[1]
            below = (boxes[:, 0, :2] <= high[:2]).all(axis=1) & (boxes[:, 1, :2] >= low[:2]).all(axis=1)
            if not (below & ~own & (boxes[:, 0, 2] < high[2])).any():
                yield Finding(
                    "SC852",
                    (body.entity,),
                    scene,
                    float(low[2]),
                    f"nothing is below `{body.entity}`, which falls for ever",
                    "put a body below it, fix it with `body_type: static`, or write `gravity: false`",
                )


def _is_part(component: Any, of: Any) -> bool:
    """Whether a component is a body's own, or a link of the articulation whose root that is."""
    return component is of or (
        hasattr(of, "articulation") and getattr(component, "articulation", None) is of.articulation
    )


def _falls(body: MovingBody) -> bool:
    return not body.component.get_disable_gravity() and bool(body.component.collision_shapes)


def _components(batch: SceneBatch, scene: int) -> Iterator[Any]:
    system = batch.scenes[batch.scene_idxs.index(scene)].physx_system
    yield from system.get_rigid_static_components()
    yield from system.get_rigid_dynamic_components()
    yield from system.get_articulation_link_components()


def _is_endless(component: Any) -> bool:
    return any(type(shape).__name__ == "PhysxCollisionShapePlane" for shape in component.collision_shapes)
