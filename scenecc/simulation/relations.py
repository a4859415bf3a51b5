"""What stands on, is in, touches and overlaps what in a scene, by the engine's contact points."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.diagnostics import Sink
from scenecc.pipeline import build_batch
from scenecc.plan import ArticulationStructure, BodyStructure, Heightfield, Plane, TriangleMesh
from scenecc.simulation.bodies import up_of
from scenecc.simulation.start import OVERLAP, articulation_names, owner

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from scenecc.plan import Entity, ScenePlan
    from scenecc.plan.snapshot import EngineSnapshot

    Floats = NDArray[np.float64]

TOUCH: Final = 0.002
"""Maximum gap between bodies that touch [m]."""

NEAR: Final = 0.1
"""Maximum gap that the contact points show [m]. Each shape has half of it as its contact offset."""

_UPWARD: Final = 0.5
"""Minimum cosine between up and the normal of a contact that supports a body: 60° from the horizontal."""

_OPEN: Final = (Plane, Heightfield, TriangleMesh)
"""Shapes that the engine cannot move freely."""


@dataclass(frozen=True)
class Neighbours:
    """The bodies next to one entity, by entity.

    Attributes:
        gaps: smallest distance [m], negative if they overlap.
        below: smallest distance of points that would support the entity from below [m]. Nothing that moves supports
            an entity that does not.
    """

    gaps: dict[str, float] = field(default_factory=dict[str, float])
    below: dict[str, float] = field(default_factory=dict[str, float])

    def stands_on(self) -> dict[str, float]:
        """Returns the entities on which it stands, with the gaps [m]."""
        return {name: gap for name, gap in self.below.items() if gap <= TOUCH}

    def touches(self) -> dict[str, float]:
        """Returns other entities that it touches, with the gaps [m]."""
        return {
            name: gap
            for name, gap in self.gaps.items()
            if -OVERLAP <= gap <= TOUCH and self.below.get(name, np.inf) > TOUCH
        }

    def overlaps(self) -> dict[str, float]:
        """Returns the entities with which it overlaps, with the depths [m]."""
        return {name: -gap for name, gap in self.gaps.items() if gap < -OVERLAP}


def find_neighbours(
    plan: ScenePlan,
    scene: int,
    measure: Callable[[Any], EngineSnapshot],
    progress: Callable[[int, int], None] | None,
) -> tuple[Mapping[str, Neighbours], EngineSnapshot]:
    """Builds a scene, and returns the neighbours of each entity and the measured scene.

    The engine ignores pairs of bodies that never move. So static and kinematic bodies and fixed roots are built as if
    they could move, except bodies with planes and triangle meshes. One step then gives all contact points in the
    initial poses.

    Args:
        plan: of the scenes.
        scene: index of the scene.
        measure: `measure_bodies` of the engine.
        progress: as for `build_batch`.

    Raises:
        SceneError: the engine or the machine failed.
    """
    movable = replace(plan, entities=tuple(map(_movable, plan.entities)), expectations=())
    articulations, up = articulation_names(plan), up_of(plan)
    up = np.array([0.0, 0.0, 1.0]) if up is None else up
    with build_batch(movable, Sink(), scene_idxs=[scene], render=False, audit=False, progress=progress) as batch:
        measured = measure(batch)
        system = batch.scenes[0].physx_system
        for component in system.get_rigid_dynamic_components():
            kinds = {type(shape).__name__ for shape in component.collision_shapes}
            component.kinematic = component.kinematic and any("Triangle" in kind for kind in kinds)
            if not component.kinematic:
                component.wake_up()  # pairs of sleeping bodies have no contact points
        for component in (
            *system.get_rigid_dynamic_components(),
            *system.get_rigid_static_components(),
            *system.get_articulation_link_components(),
        ):
            for shape in component.collision_shapes:
                shape.contact_offset = max(NEAR / 2, float(shape.rest_offset) + 1e-4)
        batch.step(1)
        contacts = batch.contacts()
    found = {entity.name: Neighbours() for entity in plan.entities}
    rows = [(one.entity.name, one.row) for one in measured.scenes[0].entities]
    planned = {one.name: one for one in plan.entities}
    moving = {name for name, row in rows if moves_freely(planned[name].structure(row))}
    rises = contacts.normal @ up
    for number, gap in enumerate(contacts.separation.tolist()):
        a, b = (owner(str(each[number]), articulations) for each in (contacts.a, contacts.b))
        if a == b or a not in found or b not in found:
            continue
        for one, other, rise in ((a, b, rises[number]), (b, a, -rises[number])):
            found[one].gaps[other] = min(gap, found[one].gaps.get(other, np.inf))
            if rise >= _UPWARD and (one in moving or other not in moving):
                found[one].below[other] = min(gap, found[one].below.get(other, np.inf))
    return found, measured


def moves_freely(structure: BodyStructure | ArticulationStructure) -> bool:
    """Returns whether forces move a body, or the root of an articulation."""
    if isinstance(structure, ArticulationStructure):
        return not structure.fix_root_link
    return structure.body_type == "dynamic"


def _movable(entity: Entity) -> Entity:
    """Returns an entity whose static bodies are kinematic, where the engine allows that, and whose root is free."""

    def changed(structure: Any) -> Any:
        if isinstance(structure, ArticulationStructure):
            return replace(structure, fix_root_link=False)
        is_static = isinstance(structure, BodyStructure) and structure.body_type == "static"
        if not is_static or any(isinstance(one.geometry, _OPEN) for one in structure.collisions):
            return structure
        return replace(structure, body_type="kinematic")

    return replace(entity, structures=tuple(map(changed, entity.structures)))
