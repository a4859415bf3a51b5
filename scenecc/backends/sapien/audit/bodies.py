"""All bodies of one structure against the plan: shape count and mass, as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.difference import CODE, shown
from scenecc.backends.sapien.audit.mass import expected_mass, fault, misses
from scenecc.backends.sapien.audit.shapes import part_counts
from scenecc.backends.sapien.audit.sweep import Place, Sweep
from scenecc.backends.sapien.engine import physx
from scenecc.plan import ConvexParts

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.turn import AnyTurn, Part
    from scenecc.plan import BodyStructure

_shapes_of = physx.PhysxRigidBaseComponent.get_collision_shapes
_mass_of = physx.PhysxRigidBodyComponent.get_mass


def look_at_all(
    turn: AnyTurn,
    part: Part[BodyStructure],
    components: list[Any],
    meshes: Meshes,
    sweep: Sweep,
    *,
    link: str | None = None,
) -> None:
    """Shape count and mass of all bodies of one structure, given their components."""

    def place(body: int) -> Place:
        return Place(turn, int(part.numbers[body]), part.structure.origin, link)

    _counts(part, components, place, meshes, sweep)
    if part.structure.body_type != "static":
        _masses(part, components, place, meshes, sweep)


def _counts(
    part: Part[BodyStructure], components: list[Any], place: Callable[[int], Place], meshes: Meshes, sweep: Sweep
) -> None:
    # One body's shapes at a time: Python's objects for all of them would have to be made and kept at once.
    shapes: Iterator[Any] = map(_shapes_of, components)
    found = np.fromiter(map(len, shapes), dtype=np.int64, count=len(components))
    if any(isinstance(shape.geometry, ConvexParts) for shape in part.structure.collisions):
        expected = np.array([sum(part_counts(part.structure, row, meshes)) for row in map(int, part.rows)])
    else:
        expected = np.full(len(found), len(part.structure.collisions))
    for i in np.flatnonzero(found != expected).tolist():
        sweep.tell(place(i), "collision_shapes", int(expected[i]), int(found[i]))


def _masses(
    part: Part[BodyStructure], components: list[Any], place: Callable[[int], Place], meshes: Meshes, sweep: Sweep
) -> None:
    found = np.array([*map(_mass_of, components)], dtype=np.float32)
    expected, exact = expected_mass(part.structure, part.rows, meshes)
    if exact:
        wrong = found != expected
    else:
        wrong = misses(found, expected)
        if len(expected) == 1:
            # One value of every size and density: then the engine's sum is one value, too.
            wrong |= found != found[0]
    for i in np.flatnonzero(wrong).tolist():
        wanted = np.broadcast_to(expected, found.shape)[i]
        sweep.tell(place(i), "mass", shown(wanted), shown(found[i]), CODE if exact else fault(wanted))
