"""Constraints that a reset tears at: their frames stay where the bodies were built, and these start elsewhere."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.lower.resets import stays
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.lower.drawing import Drawing
    from scenecc.lower.forms import Reading
    from scenecc.lower.placing.places import Places
    from scenecc.plan import Constraint, Entity, Mount


def report_torn(
    constraints: tuple[Constraint, ...], built: tuple[Entity, ...], drawing: Drawing, places: Places
) -> None:
    """A warning for each constraint without a frame of its own one of whose bodies starts elsewhere at a reset.

    What both of them stand relative to moves them alike, and is no reason.

    Args:
        constraints: whose `pose_in_parent` was left out.
        built: the entities.
        drawing: of the document, all of which is lowered.
        places: where the entities stand.
    """
    entities = {entity.name: entity for entity in built}
    kept = stays(drawing)

    def is_drawn(reading: Reading) -> bool:
        return reading.drawn or any(name in drawing.random and name not in kept for name in reading.reads)

    for constraint in constraints:
        ends = [mount for mount in (constraint.child, constraint.parent) if mount is not None]
        chains = [list(_chain(mount.entity, places)) for mount in ends]
        # What only one of the two stands relative to.
        own = set(chains[0]).symmetric_difference(chains[1] if len(chains) > 1 else ())
        readings = [reading for name in own if (reading := places.standing(name).reading) is not None]
        readings += [reading for mount in ends for reading in _of_joints(mount, entities[mount.entity], drawing)]
        if constraint.origin is not None and any(map(is_drawn, readings)):
            drawing.sink.report(
                "SC343",
                f"`{cut(constraint.name)}` stays where it is built, and a reset draws anew where its bodies start",
                constraint.origin,
                at="key",
                hint="write `pose_in_parent`, or let one body stand `relative_to` the other",
            )


def _chain(name: str, places: Places) -> Iterator[str]:
    """An entity and all that it stands relative to, up to what stays as it is built."""
    at: str | None = name
    while at is not None and not places.is_fixed(at):
        yield at
        at = places.standing(at).parent


def _of_joints(mount: Mount, entity: Entity, drawing: Drawing) -> Iterator[Reading]:
    """What was read of the positions of joints on the way to a link."""
    for structure in entity.structures:
        if not isinstance(structure, ArticulationStructure):
            continue
        numbers = {link.name: number for number, link in enumerate(structure.links)}
        at = numbers.get(mount.link or "")
        while at is not None:
            joint = structure.links[at].joint
            reset = None if joint is None else drawing.resets.get(id(joint.qpos))
            if reset is not None:
                yield reset.reading
            at = structure.links[at].parent
