"""Every entity in every scene against the plan: order, name and pose, as arrays. A link is an entity, too."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.audit.difference import shown
from scenecc.backends.sapien.audit.kinematics import link_poses, mass_reach
from scenecc.backends.sapien.audit.sweep import Place, Sweep
from scenecc.backends.sapien.columns import taken
from scenecc.backends.sapien.engine import sapien
from scenecc.backends.sapien.turn import ArticulationTurn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from scenecc.backends.sapien.turn import AnyTurn

_name_of = sapien.Entity.get_name

LINK_TOLERANCE = 1e-5
"""How far a link may be from where it belongs, by its distance from the world's origin where that is beyond 1 m: the
engine goes from link to link in float32."""


class Column(NamedTuple):
    """What stands at one place of the build order, once for each scene that has it.

    Attributes:
        numbers: which bodies or articulations of the entity.
        objs: the `sapien.Entity` of each.
        poses: (·, 7) float32 of each; None: those of all bodies of the entity, which are read at once.
        tolerance: of poses; 0: to the bit.
        link: its name; None: a body.
    """

    turn: AnyTurn
    numbers: Sequence[int]
    name: str
    objs: list[Any]
    poses: NDArray[np.float32] | None = None
    tolerance: float = 0.0
    link: str | None = None

    def place(self, body: int) -> Place:
        """Of one of `numbers`."""
        return Place(self.turn, self.numbers[body], self.turn.entity.origin, self.link)


def look_at_entities(
    turns: Sequence[AnyTurn], scenes: Sequence[Any], scene_idxs: Sequence[int], sweep: Sweep, *, every_name: bool
) -> None:
    """That each scene holds the plan's entities and no others, in the plan's order, with their names and poses.

    `every_name`: in all scenes, not only in the first and the last (order and identity are looked at in all).
    """
    columns = [column for turn in turns for column in _columns(turn)]
    number_of = {index: number for number, index in enumerate(scene_idxs)}
    scene = np.array(
        [number_of[column.turn.scene_idxs[number]] for column in columns for number in column.numbers], dtype=np.intp
    )
    entities: list[list[Any]] = [each.entities for each in scenes]
    if np.bincount(scene, minlength=len(scenes)).tolist() != list(map(len, entities)):
        _look_at_counts(columns, entities, number_of, sweep)
        return
    # Entities come column by column here and scene by scene there; a stable sort by scene keeps the columns' order.
    order = np.argsort(scene, kind="stable")
    starts = np.cumsum([0, *(len(column.numbers) for column in columns)])

    def place(body: int) -> Place:
        which = int(np.searchsorted(starts, body, side="right")) - 1
        return columns[which].place(body - int(starts[which]))

    present = list(chain.from_iterable(entities))
    ordered = order.tolist()
    ends = range(len(present)) if every_name else sorted({*range(len(entities[0])), *_tail(present, entities[-1])})
    _look_at_names(columns, present, ordered, ends, place, sweep)
    _look_at_order(columns, present, ordered, place, sweep)
    # SAPIEN packs q, then p, of each entity of a scene in the order in which they were added.
    packed = np.concatenate([np.frombuffer(each.pack_poses(), dtype=np.float32).reshape(-1, 7) for each in scenes])
    found, wanted = packed[:, [4, 5, 6, 0, 1, 2, 3]], _poses(columns)[order]
    tolerances = np.repeat([column.tolerance for column in columns], [len(column.numbers) for column in columns])[order]
    for i in _elsewhere(found, wanted, tolerances).tolist():
        sweep.tell(place(int(order[i])), "pose", shown(wanted[i]), shown(found[i]))


def _columns(turn: AnyTurn) -> Iterator[Column]:
    if not isinstance(turn, ArticulationTurn):
        yield Column(turn, range(len(turn.rows)), turn.entity.name, turn.objs)
        return
    for part in turn.parts:
        numbers: list[int] = part.numbers.tolist()
        poses = link_poses(turn.entity, part.structure, part.rows)
        tolerance = LINK_TOLERANCE * mass_reach(turn.links[numbers[0]])
        for which, (link, pose) in enumerate(zip(part.structure.links, poses, strict=True)):
            objs = [turn.entities[number][which] for number in numbers]
            yield Column(turn, numbers, link.name, objs, pose, tolerance, link.name)


def _elsewhere(
    found: NDArray[np.float32], wanted: NDArray[np.float32], tolerances: NDArray[np.float64]
) -> NDArray[np.intp]:
    wrong = (found != wanted).any(axis=1)
    if tolerances.any():
        # A rotation has two quaternions, and the engine may hold either.
        sign = np.where((found[:, 3:] * wanted[:, 3:]).sum(axis=1) < 0, -1.0, 1.0)
        far = np.maximum(1.0, np.abs(wanted[:, :3]).max(axis=1))
        apart = np.maximum(
            np.abs(found[:, :3] - wanted[:, :3]).max(axis=1),
            np.abs(found[:, 3:] - sign[:, None] * wanted[:, 3:]).max(axis=1),
        )
        wrong &= (tolerances == 0) | ~(apart <= tolerances * far)
    return np.flatnonzero(wrong)


def _tail(present: list[Any], last: list[Any]) -> range:
    return range(len(present) - len(last), len(present))


def _look_at_names(
    columns: Sequence[Column],
    present: list[Any],
    order: list[int],
    which: Sequence[int],
    place: Callable[[int], Place],
    sweep: Sweep,
) -> None:
    names = [name for column in columns for name in [column.name] * len(column.numbers)]
    for i in which:
        wanted, name = names[order[i]], _name_of(present[i])
        if wanted != name:
            sweep.tell(place(order[i]), "name at its place in the build order", repr(wanted), repr(name))


def _look_at_order(
    columns: Sequence[Column], present: list[Any], order: list[int], place: Callable[[int], Place], sweep: Sweep
) -> None:
    objs = list(chain.from_iterable(column.objs for column in columns))
    handed_out = [objs[body] for body in order]
    # Comparing lists looks at identity first, and needs no loop in Python for the usual case.
    if handed_out != present:
        for body, ours, entity in zip(order, handed_out, present, strict=True):
            if ours is not entity:
                sweep.tell(place(body), "entity", "the one of the batch", "another")


def _poses(columns: Sequence[Column]) -> NDArray[np.float32]:
    """Of all entities, column by column; rounded at once for all that have one pose."""
    fixed = [(0.0,) * 7 if column.turn.entity.pose.varies else column.turn.entity.pose.as_drawn() for column in columns]
    counts = [len(column.numbers) for column in columns]
    poses = np.repeat(np.array(fixed).astype(np.float32), counts, axis=0)
    for column, end in zip(columns, np.cumsum(counts).tolist(), strict=True):
        if column.poses is not None:
            poses[end - len(column.numbers) : end] = column.poses
        elif column.turn.entity.pose.varies:
            poses[end - len(column.numbers) : end] = taken(column.turn.entity.pose, column.turn.rows)
    return poses


def _look_at_counts(
    columns: Sequence[Column], entities: list[list[Any]], number_of: dict[int, int], sweep: Sweep
) -> None:
    counted: dict[int, list[tuple[AnyTurn, int]]] = {}
    for column in columns:
        for number in column.numbers:
            counted.setdefault(column.turn.scene_idxs[number], []).append((column.turn, number))
    for index, bodies in counted.items():
        found = len(entities[number_of[index]])
        if found != len(bodies):
            turn, body = bodies[0]
            sweep.tell(Place(turn, body, None), "entities in the scene", len(bodies), found)
