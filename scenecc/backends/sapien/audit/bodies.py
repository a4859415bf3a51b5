"""Every body in every scene against the plan: order, name, pose, shape count and mass, as arrays."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.audit.difference import shown
from scenecc.backends.sapien.audit.mass import RELATIVE_TOLERANCE, expected_mass
from scenecc.backends.sapien.audit.shapes import part_counts
from scenecc.backends.sapien.audit.sweep import Place, Sweep
from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.plan import ConvexParts

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.turn import Part, Turn

_name_of = sapien.Entity.get_name
_shapes_of = physx.PhysxRigidBaseComponent.get_collision_shapes
_mass_of = physx.PhysxRigidBodyComponent.get_mass


def look_at_entities(
    turns: Sequence[Turn], scenes: Sequence[Any], scene_idxs: Sequence[int], sweep: Sweep, *, every_name: bool
) -> None:
    """That each scene holds the plan's entities and no others, in the plan's order, with their names and poses.

    `every_name`: in all scenes, not only in the first and the last (order and identity are looked at in all).
    """
    number_of = {index: number for number, index in enumerate(scene_idxs)}
    scene = np.array([number_of[index] for turn in turns for index in turn.scene_idxs], dtype=np.intp)
    entities: list[list[Any]] = [each.entities for each in scenes]
    if np.bincount(scene, minlength=len(scenes)).tolist() != list(map(len, entities)):
        _look_at_counts(turns, entities, number_of, sweep)
        return
    # Entities come turn by turn here and scene by scene there; a stable sort by scene keeps the turns' order.
    order = np.argsort(scene, kind="stable")
    starts = np.cumsum([0, *(len(turn.rows) for turn in turns)])

    def place(body: int) -> Place:
        which = int(np.searchsorted(starts, body, side="right")) - 1
        return Place(turns[which], body - int(starts[which]), turns[which].entity.origin)

    present = list(chain.from_iterable(entities))
    ordered = order.tolist()
    ends = range(len(present)) if every_name else sorted({*range(len(entities[0])), *_tail(present, entities[-1])})
    _look_at_names(turns, present, ordered, ends, place, sweep)
    _look_at_order(turns, present, ordered, place, sweep)
    # SAPIEN packs q, then p, of each entity of a scene in the order in which they were added.
    packed = np.concatenate([np.frombuffer(each.pack_poses(), dtype=np.float32).reshape(-1, 7) for each in scenes])
    found, wanted = packed[:, [4, 5, 6, 0, 1, 2, 3]], _poses(turns)[order]
    for i in np.flatnonzero((found != wanted).any(axis=1)).tolist():
        sweep.tell(place(int(order[i])), "pose", shown(wanted[i]), shown(found[i]))


def _tail(present: list[Any], last: list[Any]) -> range:
    return range(len(present) - len(last), len(present))


def _look_at_names(
    turns: Sequence[Turn],
    present: list[Any],
    order: list[int],
    which: Sequence[int],
    place: Callable[[int], Place],
    sweep: Sweep,
) -> None:
    names = [name for turn in turns for name in [turn.entity.name] * len(turn.rows)]
    for i in which:
        wanted, name = names[order[i]], _name_of(present[i])
        if wanted != name:
            sweep.tell(place(order[i]), "name at its place in the build order", repr(wanted), repr(name))


def _look_at_order(
    turns: Sequence[Turn], present: list[Any], order: list[int], place: Callable[[int], Place], sweep: Sweep
) -> None:
    objs = list(chain.from_iterable(turn.objs for turn in turns))
    handed_out = [objs[body] for body in order]
    # Comparing lists looks at identity first, and needs no loop in Python for the usual case.
    if handed_out != present:
        for body, ours, entity in zip(order, handed_out, present, strict=True):
            if ours is not entity:
                sweep.tell(place(body), "entity", "the one of the batch", "another")


def _poses(turns: Sequence[Turn]) -> NDArray[np.float32]:
    """Of all bodies, turn by turn; rounded at once for all entities that have one pose."""
    fixed = [(0.0,) * 7 if turn.entity.pose.varies else turn.entity.pose.as_drawn() for turn in turns]
    counts = [len(turn.rows) for turn in turns]
    poses = np.repeat(np.array(fixed).astype(np.float32), counts, axis=0)
    for turn, end in zip(turns, np.cumsum(counts).tolist(), strict=True):
        if turn.entity.pose.varies:
            poses[end - len(turn.rows) : end] = taken(turn.entity.pose, turn.rows)
    return poses


def _look_at_counts(turns: Sequence[Turn], entities: list[list[Any]], number_of: dict[int, int], sweep: Sweep) -> None:
    counted: dict[int, list[tuple[Turn, int]]] = {}
    for turn in turns:
        for body, index in enumerate(turn.scene_idxs):
            counted.setdefault(index, []).append((turn, body))
    for index, bodies in counted.items():
        found = len(entities[number_of[index]])
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
    # One body's shapes at a time: Python's objects for all of them would have to be made and kept at once.
    shapes: Iterator[Any] = map(_shapes_of, components)
    found = np.fromiter(map(len, shapes), dtype=np.int64, count=len(components))
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
