"""What was built of each entity, in numbers that a person checks at a glance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from scenecc.plan.extent import extent

if TYPE_CHECKING:
    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import Entity, ScenePlan


@dataclass(frozen=True, slots=True)
class SummaryRow:
    """One entity.

    Attributes:
        body_type: of its structures, joined by `|` where they differ.
        shape_count: of the structure in its first scene: colliding shapes, or visible ones where those are more.
        mass: [kg] in its first scene, as the engine has it; None where the body has none or no engine was started.
        size: extents along its own axes [m] in its first scene; None where only an engine or a file could tell.
        scene_idxs: the scenes it is in.
    """

    name: str
    body_type: str
    shape_count: int
    mass: float | None
    size: tuple[float, float, float] | None
    scene_idxs: tuple[int, ...]


def summarize(plan: ScenePlan, batch: SceneBatch | None, scene_idxs: tuple[int, ...] | None = None) -> list[SummaryRow]:
    """A row an entity, in build order.

    Args:
        plan: the whole plan.
        batch: the live scenes; None after a dry run.
        scene_idxs: the scenes that were asked for; None: all of them.
    """
    asked = range(plan.num_scenes) if scene_idxs is None else set(scene_idxs)
    present = [(entity, tuple(index for index in entity.scene_idxs if index in asked)) for entity in plan.entities]
    return [_row(entity, idxs, batch) for entity, idxs in present if idxs]


def _row(entity: Entity, scene_idxs: tuple[int, ...], batch: SceneBatch | None) -> SummaryRow:
    row = entity.scene_idxs.index(scene_idxs[0])
    structure = entity.structures[entity.pick[row] if entity.pick else 0]
    return SummaryRow(
        name=entity.name,
        body_type="|".join(dict.fromkeys(s.body_type for s in entity.structures)),
        shape_count=max(len(structure.collisions), len(structure.visuals)),
        mass=None if batch is None else _mass(batch, entity.name),
        size=extent(structure, row),
        scene_idxs=scene_idxs,
    )


def _mass(batch: SceneBatch, name: str) -> float | None:
    """What the engine holds in the first scene; a body that cannot move has none."""
    components = batch.entities[name].objs[0].components
    return next((component.mass for component in components if hasattr(component, "mass")), None)
