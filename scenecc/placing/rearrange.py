"""Draws earlier placements again where a later one has no room.

In each scene by itself, from the tries after the first `tries` on: the placement takes the first of some tries in whose
way the fewest others are, and these are drawn again in the same manner.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.placing.placer import Placer, PlacingError
from scenecc.placing.trial import Trial
from scenecc.plan.placement import TRIED_FIELDS
from scenecc.variation.nodes import placements_read_by

if TYPE_CHECKING:
    from collections.abc import Iterator

    from scenecc.geometry.rotation_arrays import Flags, Floats, Indices
    from scenecc.plan.placement import Placement


TIMES: Final = 200
"""Maximum number of times that a placement is tried in a scene after something has no room."""

TRIES: Final = 128
"""Number of tries of each of these times."""

_STEPS: Final = 500
"""Maximum number of these times in all scenes together in which a placement still has no room."""

_STEPS_OF_SCENE: Final = 10
"""Number of times that each scene of the batch adds to it."""

_VAIN_TIMES: Final = 4
"""Number of times in turn after which it is given up if only bodies that are not drawn again are in the way."""

_SCENES: Final = (16, 512)
"""Number of scenes that are rearranged together, at first and then."""


def rearrange(placer: Placer, trial: Trial, found: Floats, left: Indices) -> Floats:
    """Places a placement where it fits nowhere, and draws earlier ones again. Other scenes stay as they are.

    Args:
        placer: has placed all earlier placements; receives their new poses.
        trial: of the placement that fits nowhere in some scenes.
        found: its poses (B, 7).
        left: the rows in which it has none.

    Returns:
        Its poses (B, 7).

    Raises:
        PlacingError: it also fits nowhere if the others are drawn again, or no other can be.
    """
    if all(map(_is_constant, placer.moves_with(trial.placement))):
        raise _error(placer, trial, left, [])
    found, start = found.copy(), 0
    moved: dict[str, Floats] = {}
    while start < len(left):
        rows = left[start : start + _SCENES[min(start, 1)]]
        part = _Rearrangement(placer.selected(rows), trial.placement)
        failed = rows[part.fail(_max_steps(placer))]
        if failed.size:
            raise _error(placer, trial, failed, part.lifted_names(failed[0] == rows))
        for one in part.changed():
            pose = part.poses(one)
            if one is trial.placement:
                found[rows] = pose
            else:
                whole = moved.setdefault(one.name, placer.batch.placed[one.name][placer.batch.scenes])
                whole[rows] = pose
        start += len(rows)
    for one in placer.placed:
        if one.name in moved:
            placer.settle(one, moved[one.name])
    return found


def _error(placer: Placer, trial: Trial, failed: Indices, lifted: list[str]) -> PlacingError:
    name, tries = trial.placement.name, trial.placement.tries
    why = trial.reason(int(failed[0]))
    if lifted:
        shown = ", ".join(f"`{one}`" for one in lifted[:3]) + (", …" if len(lifted) > 3 else "")
        why += f"; it did not help to draw {shown} again, up to {TIMES} times and {_max_steps(placer)} in all scenes"
    return PlacingError(name, placer.batch.scenes[failed].tolist(), f"`{name}` fits nowhere in {tries} tries", why)


def _max_steps(placer: Placer) -> int:
    return _STEPS + _STEPS_OF_SCENE * len(placer.batch.scenes)


class _Rearrangement:
    """The placements of a batch in whose scenes one has no room."""

    def __init__(self, placer: Placer, failing: Placement) -> None:
        self._placer = placer
        self._all = [*placer.moves_with(failing), failing]
        count, scenes = len(self._all), len(placer.batch.scenes)
        self._owner = {name: number for number, one in enumerate(self._all) for name in (one.name, *one.entities)}
        self._settled = np.ones((scenes, count), np.bool_)
        self._lifted = np.zeros((scenes, count), np.bool_)
        self._used = np.tile(np.array([one.tries for one in self._all]), (scenes, 1))
        self._times, self._vain = np.zeros((2, scenes), np.int64)
        self._head = np.full(scenes, count - 1)
        self._reads = np.zeros((count, count), np.bool_)
        for number, one in enumerate(self._all):
            self._reads[number, [self._owner[name] for name in _read_by(one) if name in self._owner]] = True
        stacked = [[_may_support(under, one) for under in self._all] for one in self._all]
        self._needs = _closure(self._reads)
        self._followers = _closure(self._reads | np.array(stacked)).T
        self._constant = np.array([_is_constant(one) for one in self._all])
        placer.settle(failing, np.tile(np.array(IDENTITY_POSE), (scenes, 1)))
        self._settled[:, -1] = False
        self._show_lifted()

    def fail(self, steps: int) -> Flags:
        """Places until everything has a pose again, and returns the scenes (B,) in which it has none after all.

        `steps`: it gives up after this number of steps in all scenes that still have no room.
        """
        while (left := ~self._settled.all(axis=1)).any() and self._times[left].sum() < steps:
            rows = np.flatnonzero(left & (self._times < TIMES))
            if not len(rows):
                break
            first = (~self._settled[rows]).argmax(axis=1)
            waits = self._settled[rows, self._head[rows]]
            waits |= (self._reads[self._head[rows]] & ~self._settled[rows]).any(axis=1)
            self._head[rows] = np.where(waits, first, self._head[rows])
            for number in np.unique(self._head[rows]).tolist():
                self._advance(number, rows[self._head[rows] == number])
        failed: Any = ~self._settled.all(axis=1)
        return failed

    def changed(self) -> Iterator[Placement]:
        """Yields the placements with a new pose in some scene."""
        for number, one in enumerate(self._all):
            if one is self._all[-1] or self._lifted[:, number].any():
                yield one

    def poses(self, placement: Placement) -> Floats:
        """Returns the poses of a placement (B, 7)."""
        return self._placer.batch.placed[placement.name][self._placer.batch.scenes]

    def lifted_names(self, scene: Flags) -> list[str]:
        """Returns the names of the placements that were placed again in a scene, without the one that had no room."""
        return [one.name for number, one in enumerate(self._all[:-1]) if self._lifted[scene, number].any()]

    def _advance(self, number: int, rows: Indices) -> None:
        """Tries a placement in some scenes."""
        one = self._all[number]
        count = min(TRIES, one.tries)
        tries = self._used[rows, number][:, None] + np.arange(count)
        pose, fits, blocked = Trial(self._placer, one).blocked(np.repeat(rows, count), tries.ravel())
        lift: Any = np.zeros((len(fits), len(self._all)), np.bool_)
        for name, flags in blocked.items():
            other = self._owner.get(name)
            if other is None or self._needs[number, other] or self._constant[other]:
                fits &= ~flags
            else:
                lift |= flags[:, None] & self._followers[other]
        cost = np.where(fits, lift.sum(axis=1), len(self._all) + 1).reshape(-1, count)
        best, each = cost.argmin(axis=1), np.arange(len(rows))
        least, lift = cost[each, best], lift.reshape(-1, count, len(self._all))[each, best]
        possible = least <= len(self._all)
        # What is inside may stand on what is in its way, so its height is found when that is gone.
        settles = possible & ((least == 0) | (one.kind != "inside"))
        self._used[rows, number] += np.where(settles, best + 1, np.where(possible, best, count))
        lift[~possible] = self._lifted_for_need(number)
        self._times[rows] += 1
        self._vain[rows] = np.where(possible | lift.any(axis=1), 0, self._vain[rows] + 1)
        self._times[rows[self._vain[rows] >= _VAIN_TIMES]] = TIMES
        self._settle(number, rows[settles], pose.reshape(-1, count, 7)[each, best][settles])
        self._settled[rows] &= ~lift
        self._lifted[rows] |= lift
        self._show_lifted()

    def _lifted_for_need(self, number: int) -> Flags:
        """Returns the placements to place again where no try of one is possible: what it reads, and their followers."""
        read = self._reads[number] & ~self._constant
        lifted: Any = self._followers[read].any(axis=0)
        return lifted

    def _settle(self, number: int, rows: Indices, pose: Floats) -> None:
        whole = self.poses(self._all[number])
        whole[rows] = pose
        self._placer.settle(self._all[number], whole)
        self._settled[rows, number] = True

    def _show_lifted(self) -> None:
        self._placer.lifted = {
            member: ~self._settled[:, number]
            for member, number in self._owner.items()
            if not self._settled[:, number].all()
        }


def _read_by(one: Placement) -> Iterator[str]:
    """Yields the entities and placements that the pose of a placement depends on."""
    yield one.target.entity
    if one.facing is not None:
        yield one.facing.entity
    yield from (near.entity for near in one.near)
    if one.next_to is not None:
        yield one.next_to.mount.entity
    if one.frame is not None and one.frame.recipe is not None:
        yield from placements_read_by(one.frame.recipe)


def _may_support(under: Placement, one: Placement) -> bool:
    """Returns whether a placement may stand on another, without being placed on it by name."""
    return one is not under and one.kind == "inside" and one.target.entity in {under.target.entity, *under.carrying}


def _is_constant(one: Placement) -> bool:
    """Returns whether all tries of a placement are the same."""
    values = [getattr(one, name) for name in TRIED_FIELDS]
    has_place = one.at is not None or one.next_to is not None
    return has_place and all(value is None or value.recipe is None for value in values)


def _closure(relation: Flags) -> Flags:
    """Returns the transitive and reflexive closure of a relation (n, n)."""
    found = relation | np.eye(len(relation), dtype=np.bool_)
    while True:
        more = (found.astype(np.int64) @ found.astype(np.int64)) > 0
        if (more == found).all():
            return found
        found = more
