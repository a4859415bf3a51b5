"""Pairs of bodies of a USD stage that do not collide."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.importers.usd_bodies import UsdBody
    from scenecc.importers.usd_joints import UsdJoint
    from scenecc.importers.usd_stage import UsdStage

Pair = frozenset[str]


class CollisionFilters:
    """Collects the pairs of bodies that do not collide.

    Args:
        stage: the stage.
        bodies: by prim path.
        groups: UsdPhysics descriptors of collision groups.

    Attributes:
        pairs: paths of two bodies each.
    """

    def __init__(self, stage: UsdStage, bodies: Mapping[str, UsdBody], groups: Iterable[Any]) -> None:
        self._stage = stage
        self._bodies = bodies
        self._groups = {str(group.primPath): group for group in groups}
        self.pairs: set[Pair] = set()

    def add_joints(self, joints: Iterable[UsdJoint]) -> None:
        """Adds the pairs connected by joints without collision."""
        for joint in joints:
            if not joint.collides and all(body in self._bodies for body in joint.bodies):
                self.pairs.add(frozenset(joint.bodies))

    def add_filtered(self, parsed: Iterable[Any]) -> None:
        """Adds the pairs of `FilteredPairsAPI`. `parsed`: descriptors of bodies, shapes and articulations."""
        for each in parsed:
            others = [other for path in each.filteredCollisions for other in self._list_bodies(str(path))]
            if not others:
                continue
            own = self._list_bodies(str(each.primPath))
            if any(
                len(self._bodies[body].colliders) > 1
                for body in (*own, *others)
                if body not in self._find_filtered(each)
            ):
                prim = self._stage.prim(each.primPath)
                self._stage.lose(
                    "collision-filters", "a filter between single colliders, applied to whole bodies", prim
                )
            self.pairs |= {frozenset((a, b)) for a in own for b in others if a != b}

    def _find_filtered(self, parsed: Any) -> set[str]:
        """Returns the bodies that a filter names as a whole."""
        paths = [str(path) for path in (parsed.primPath, *parsed.filteredCollisions)]
        return {body for path in paths for body in self._list_bodies(path) if f"{body}/".startswith(f"{path}/")}

    def _list_bodies(self, path: str) -> list[str]:
        """Returns the bodies at or below a path; for a collider, its body."""
        found = [body for body in self._bodies if f"{body}/".startswith(f"{path}/")]
        if found:
            return found
        return [
            body
            for body, each in self._bodies.items()
            if any(str(prim.GetPath()) == path for prim, _ in each.colliders)
        ]

    def add_groups(self) -> None:
        """Adds the pairs of collision groups. Reports pairs with only some filtered colliders."""
        apart = {
            frozenset((name, str(other))) for name, group in self._groups.items() for other in self._list_ignored(group)
        }
        if not apart:
            return
        signatures: dict[frozenset[frozenset[str]], list[str]] = {}
        for path, body in self._bodies.items():
            if body.colliders:
                key = frozenset(frozenset(str(each) for each in parsed.collisionGroups) for _, parsed in body.colliders)
                signatures.setdefault(key, []).append(path)
        for first, ones in signatures.items():
            for second, others in signatures.items():
                found = {any(frozenset((a, b)) in apart for a in x for b in y) for x in first for y in second}
                if found == {True, False}:
                    prim = self._stage.prim(ones[0])
                    self._stage.lose("collision-filters", "groups of only some colliders of a body", prim)
                elif found == {True}:
                    self.pairs |= {frozenset((a, b)) for a in ones for b in others if a != b}

    def _list_ignored(self, group: Any) -> list[str]:
        named = [str(path) for path in group.filteredGroups]
        # UsdPhysics may leave this flag uninitialised in its descriptor.
        inverted = self._stage.value(self._stage.prim(group.primPath), "physics:invertFilteredGroups", default=False)
        return [path for path in self._groups if path not in named] if inverted else named
