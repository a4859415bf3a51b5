"""What entities of a plan are made of, where a test knows that they are bodies and no articulations."""

from __future__ import annotations

from scenecc.plan import BodyStructure, Entity


def body_of(entity: Entity) -> BodyStructure:
    """The first structure of an entity, which is a body."""
    return bodies_of(entity)[0]


def bodies_of(entity: Entity) -> tuple[BodyStructure, ...]:
    """The structures of an entity, one or one a variant, which are bodies."""
    structures = tuple(each for each in entity.structures if isinstance(each, BodyStructure))
    assert len(structures) == len(entity.structures)
    return structures
