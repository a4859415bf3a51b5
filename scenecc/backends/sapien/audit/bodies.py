"""Every body in every scene against the plan: shape count, mass and pose, as arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.difference import shown
from scenecc.backends.sapien.audit.mass import RELATIVE_TOLERANCE, expected_mass
from scenecc.backends.sapien.audit.shapes import part_counts
from scenecc.backends.sapien.audit.sweep import Place, Sweep
from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.engine import physx
from scenecc.plan import ConvexParts

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.turn import Part, Turn

_shapes_of = physx.PhysxRigidBaseComponent.get_collision_shapes
_mass_of = physx.PhysxRigidBodyComponent.get_mass


def look_at_poses(turns: Sequence[Turn], scenes: Sequence[Any], scene_idxs: Sequence[int], sweep: Sweep) -> None:
    """The poses of all entities, and that each scene holds as many as the plan says."""
    number_of = {index: number for number, index in enumerate(scene_idxs)}
    # SAPIEN packs q, then p, of each entity of a scene in the order in which they were added.
    packed = [np.frombuffer(scene.pack_poses(), dtype=np.float32).reshape(-1, 7) for scene in scenes]
    scene = np.array([number_of[index] for turn in turns for index in turn.scene_idxs], dtype=np.intp)
    if np.bincount(scene, minlength=len(scenes)).tolist() != [len(rows) for rows in packed]:
        _look_at_counts(turns, packed, number_of, sweep)
        return
    wanted = [taken(turn.entity.pose, turn.rows).astype(np.float32) for turn in turns]
    whole = np.concatenate([_spread(rows, len(turn.rows)) for rows, turn in zip(wanted, turns, strict=True)])
    # Entities come turn by turn here and scene by scene there; a stable sort by scene keeps the turns' order.
    order = np.argsort(scene, kind="stable")
    found = np.concatenate(packed)[:, [4, 5, 6, 0, 1, 2, 3]]
    starts = np.cumsum([0, *(len(turn.rows) for turn in turns)])
    for i in np.flatnonzero((found != whole[order]).any(axis=1)).tolist():
        body = int(order[i])
        which = int(np.searchsorted(starts, body, side="right")) - 1
        place = Place(turns[which], body - int(starts[which]), turns[which].entity.origin)
        sweep.tell(place, "pose", shown(whole[body]), shown(found[i]))


def _spread(rows: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    return rows if len(rows) == count else np.broadcast_to(rows, (count, 7))


def _look_at_counts(turns: Sequence[Turn], packed: Sequence[Any], number_of: dict[int, int], sweep: Sweep) -> None:
    counted: dict[int, list[tuple[Turn, int]]] = {}
    for turn in turns:
        for body, index in enumerate(turn.scene_idxs):
            counted.setdefault(index, []).append((turn, body))
    for index, bodies in counted.items():
        found = len(packed[number_of[index]])
        if found != len(bodies):
            turn, body = bodies[0]
            sweep.tell(Place(turn, body, None), "entities in the scene", len(bodies), found)


def look_at_all(turn: Turn, part: Part, meshes: Meshes, sweep: Sweep) -> None:
    """Shape count and mass of all bodies of one structure."""
    components: list[Any] = [turn.components[number] for number in part.numbers]
    _counts(turn, part, components, meshes, sweep)
    if part.structure.body_type != "static":
        _masses(turn, part, components, meshes, sweep)


def _counts(turn: Turn, part: Part, components: list[Any], meshes: Meshes, sweep: Sweep) -> None:
    shapes: list[list[Any]] = list(map(_shapes_of, components))
    found = np.array(list(map(len, shapes)))
    if any(isinstance(shape.geometry, ConvexParts) for shape in part.structure.collisions):
        expected = np.array([sum(part_counts(part.structure, row, meshes)) for row in map(int, part.rows)])
    else:
        expected = np.full(len(found), len(part.structure.collisions))
    for i in np.flatnonzero(found != expected).tolist():
        place = Place(turn, int(part.numbers[i]), part.structure.origin)
        sweep.tell(place, "collision_shapes", int(expected[i]), int(found[i]))


def _masses(turn: Turn, part: Part, components: list[Any], meshes: Meshes, sweep: Sweep) -> None:
    found = np.array([*map(_mass_of, components)], dtype=np.float32)
    expected, exact = expected_mass(part.structure, part.rows, meshes)
    if exact:
        wrong = found != expected
    else:
        wrong = np.abs(found - expected) > RELATIVE_TOLERANCE * expected
        if len(expected) == 1:
            # One value of every size and density: then the engine's sum is one value, too.
            wrong |= found != found[0]
    for i in np.flatnonzero(wrong).tolist():
        place = Place(turn, int(part.numbers[i]), part.structure.origin)
        sweep.tell(place, "mass", shown(np.broadcast_to(expected, found.shape)[i]), shown(found[i]))
