"""Pairs of links and bodies that never collide, as collision groups of a scene document."""

from __future__ import annotations

from bisect import bisect
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Final

import numpy as np

from scenecc.importers.numbers import Names
from scenecc.robots.ignored_sets import MAX_SETS, cover_pairs, order_pair
from scenecc.scene_file.shared_keys import move_up

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from scenecc.robots.ignored_sets import Pairs
    from scenecc.scene_file import Node

_MAX_GROUPS: Final = 31
"""`scenecc.lower.collision_groups.GROUPS`."""

_ID: Final = 1000
"""First value of the fourth collision integer, which separates the third from those of other entities."""


@dataclass(slots=True)
class Collider:
    """A link or body that collides.

    Attributes:
        node: its keys in the document.
        shapes: the entries of its shapes that collide.
        bits: the first two collision integers of each shape.
        name: in the scene.
        entity: index of its entity.
        link: index of the link, and that of its parent; None: it has none.
        ignore_bits: links that share a bit do not collide.
        is_static: whether it cannot move.
    """

    node: Node
    shapes: Sequence[Node]
    bits: tuple[tuple[int, int], ...]
    name: str
    entity: int
    link: int
    parent: int | None
    ignore_bits: int = 0
    is_static: bool = False

    def touches(self, other: Collider) -> set[bool]:
        """Returns whether its shapes and those of another collide by their bits; both where only some do."""
        return {bool(a[0] & b[1] or b[0] & a[1]) for a in set(self.bits) for b in set(other.bits)}

    def is_never_tested(self, other: Collider) -> bool:
        """Returns whether PhysX never tests the pair."""
        near = self.entity == other.entity and (self.parent == other.link or other.parent == self.link)
        return near or (self.is_static and other.is_static)


@dataclass(slots=True)
class IgnoredPairs:
    """Finds the ignored pairs of a world, and writes them.

    Attributes:
        colliders: all that collide.
        entities: keys of each entity.
        named: ignored pairs of the world, by name in the scene.
        closed: indices of entities whose links never collide with one another.
        groups: section `collision_groups`.
        unwritten: pairs that a scene cannot ignore, since there are too many.
    """

    colliders: list[Collider]
    entities: Sequence[Node]
    named: frozenset[frozenset[str]]
    closed: frozenset[int]
    groups: dict[str, Node] = field(default_factory=dict[str, "Node"])
    unwritten: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])

    def write(self) -> None:
        """Sets `disable_self_collisions`, and `collision_group` or `collision_bits`, where a pair is ignored."""
        for index in self.closed:
            if any(collider.entity == index for collider in self.colliders):
                self.entities[index]["disable_self_collisions"] = True
        if self._all_collide():
            return
        ignored, mixed = self._pairs()
        if not mixed:
            ignored = self._with_closed(self._within_entities(ignored))
            classes = _find_classes(ignored, len(self.colliders))
            if len({*classes.values()}) <= _MAX_GROUPS:
                self._write_groups(ignored, classes)
                return
        self._write_bits()

    def _all_collide(self) -> bool:
        """Returns whether no pair is ignored, from the distinct bits only."""
        return self._all_bits_collide() and not self.named and not any(each.ignore_bits for each in self.colliders)

    def _all_bits_collide(self) -> bool:
        bits = {each for collider in self.colliders for each in collider.bits}
        return all(a[0] & b[1] or b[0] & a[1] for a in bits for b in bits)

    def _candidates(self) -> Iterable[tuple[int, int]]:
        """Returns the pairs that may be ignored, the lower index first: few of a large world whose bits collide."""
        if not self._all_bits_collide():
            return self._tested_pairs()
        marked = [number for number, each in enumerate(self.colliders) if each.ignore_bits]
        numbers = {each.name: number for number, each in enumerate(self.colliders)}
        named = (sorted(numbers[name] for name in pair) for pair in self.named if pair <= numbers.keys())
        return {*combinations(marked, 2), *((pair[0], pair[1]) for pair in named if len(pair) > 1)}

    def _tested_pairs(self) -> Iterator[tuple[int, int]]:
        """Yields the pairs of colliders that are not both static, the lower index first."""
        count = len(self.colliders)
        moving = [number for number, each in enumerate(self.colliders) if not each.is_static]
        for i, first in enumerate(self.colliders):
            others = moving[bisect(moving, i) :] if first.is_static else range(i + 1, count)
            yield from ((i, j) for j in others)

    def _pairs(self) -> tuple[Pairs, bool]:
        """Returns the ignored pairs that PhysX would test, and whether bits separate only some shapes of a pair."""
        ignored: Pairs = set()
        mixed = False
        for i, j in self._candidates():
            first, second = self.colliders[i], self.colliders[j]
            if first.is_never_tested(second) or (first.entity == second.entity and first.entity in self.closed):
                continue
            touches = first.touches(second)
            if self._ignores(first, second) or touches == {False}:
                ignored.add((i, j))
            else:
                mixed = mixed or len(touches) > 1
        return ignored, mixed

    def _ignores(self, first: Collider, second: Collider) -> bool:
        """Returns whether two colliders ignore one another for another reason than their bits."""
        closed = first.entity == second.entity and first.entity in self.closed
        return (
            bool(first.ignore_bits & second.ignore_bits) or closed or frozenset((first.name, second.name)) in self.named
        )

    def _within_entities(self, ignored: Pairs) -> Pairs:
        """Returns the pairs without those of entities whose links all ignore one another."""
        members: dict[int, list[int]] = {}
        for number, collider in enumerate(self.colliders):
            members.setdefault(collider.entity, []).append(number)
        for index, numbers in members.items():
            pairs = {
                (i, j) for i, j in combinations(numbers, 2) if not self.colliders[i].is_never_tested(self.colliders[j])
            }
            if pairs and pairs <= ignored and index not in self.closed:
                self.entities[index]["disable_self_collisions"] = True
                ignored = ignored - pairs
        return ignored

    def _with_closed(self, ignored: Pairs) -> Pairs:
        """Returns the pairs with those inside closed entities, so that their links can share a group."""
        held = {number for pair in ignored for number in pair if self.colliders[number].entity in self.closed}
        pairs = combinations(sorted(held), 2)
        return ignored.union((a, b) for a, b in pairs if self.colliders[a].entity == self.colliders[b].entity)

    def _write_groups(self, ignored: Pairs, classes: Mapping[int, int]) -> None:
        names, called = Names(), dict[int, str]()
        for first in dict.fromkeys(classes.values()):
            called[first] = names.new(self._group_name([i for i in classes if classes[i] == first]))
        for first, name in called.items():
            ignores = {called[classes[i]]: None for i in classes if order_pair(i, first) in ignored and i != first}
            twins = [i for i in classes if classes[i] == first]
            if any(pair in ignored for pair in combinations(twins, 2)):
                ignores[name] = None
            self.groups[name] = {"ignore": list(ignores)}
        members: dict[int, set[str | None]] = {}
        for number, collider in enumerate(self.colliders):
            members.setdefault(collider.entity, set()).add(called.get(classes.get(number, -1)))
        for number in classes:
            collider = self.colliders[number]
            whole = len(members[collider.entity]) == 1
            node = self.entities[collider.entity] if whole else collider.node
            node["collision_group"] = called[classes[number]]

    def _group_name(self, members: Sequence[int]) -> str:
        """Returns the first part that the names of several entities (`PART.NAME`) share, or the first member's name."""
        entities = {self.colliders[number].name.partition("/")[0] for number in members}
        parts = {entity.partition(".")[0] for entity in entities}
        if len(entities) > len(parts) == 1:
            return parts.pop()
        return self.colliders[members[0]].name.rpartition("/")[2]

    def _last_bits(self) -> list[list[int]]:
        """Returns the third and fourth integer of each collider, which cover the ignored pairs.

        Colliders that pairs connect have a fourth integer of their own, and so bits of their own.
        """
        wanted: Pairs = set()
        still = np.array([collider.is_static for collider in self.colliders])
        free = np.outer(still, still)
        for i, j in self._tested_pairs():
            first, second = self.colliders[i], self.colliders[j]
            apart = first.is_never_tested(second) or first.touches(second) == {False}
            ignores = self._ignores(first, second)
            if apart or ignores:
                free[i, j] = free[j, i] = True
            if ignores and not apart:
                wanted.add((i, j))
        last = [[0, 0] for _ in self.colliders]
        for number, part in enumerate(_connected(wanted)):
            inside = {pair for pair in wanted if pair[0] in part}
            is_in_part = np.isin(np.arange(len(last)), [*part])
            sets = cover_pairs(inside, free & np.outer(is_in_part, is_in_part))
            for left in sets[MAX_SETS:]:
                pairs = (pair for pair in combinations(sorted(left), 2) if pair in inside)
                self.unwritten += ((self.colliders[i].name, self.colliders[j].name) for i, j in pairs)
            for bit, together in enumerate(sets[:MAX_SETS]):
                for one in together:
                    last[one] = [last[one][0] | 1 << bit, _ID + number]
        return last

    def _write_bits(self) -> None:
        """Writes SAPIEN's integers, the first two from the file."""
        last = self._last_bits()
        for index in self.closed:
            self.entities[index].pop("disable_self_collisions", None)
        for number, collider in enumerate(self.colliders):
            rows = [[*bits, *last[number]] for bits in collider.bits]
            for entry, row in zip(collider.shapes, rows, strict=True):
                entry["collision_bits"] = row
            move_up(collider.node, collider.shapes, "collision_bits")


def _connected(pairs: Pairs) -> list[set[int]]:
    """Returns the sets of colliders that pairs connect."""
    parts: list[set[int]] = []
    for pair in sorted(pairs):
        touched = [part for part in parts if not part.isdisjoint(pair)]
        parts = [part for part in parts if part.isdisjoint(pair)]
        parts.append(set(pair).union(*touched))
    return parts


def _find_classes(ignored: Pairs, count: int) -> dict[int, int]:
    """Returns collider → first collider that ignores the same others, whether or not the two ignore one another."""
    neighbours: dict[int, set[int]] = {}
    for i, j in ignored:
        neighbours.setdefault(i, set()).add(j)
        neighbours.setdefault(j, set()).add(i)
    near: dict[frozenset[int], list[int]] = {}
    far: dict[frozenset[int], list[int]] = {}
    for number in range(count):
        if number in neighbours:
            near.setdefault(frozenset(neighbours[number] | {number}), []).append(number)
            far.setdefault(frozenset(neighbours[number]), []).append(number)
    found: dict[int, int] = {}
    for members in (*(each for each in near.values() if len(each) > 1), *far.values()):
        free = [number for number in members if number not in found]
        found |= dict.fromkeys(free, free[0]) if free else {}
    return {number: found[number] for number in sorted(found)}
