"""Which bodies of a USD stage do not collide with one another, as collision groups of a scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.importers.usd_bodies import UsdBody
    from scenecc.importers.usd_joints import UsdJoint
    from scenecc.importers.usd_stage import UsdStage

_MAX_GROUPS: Final = 31

Pair = frozenset[str]


class CollisionFilters:
    """The pairs of bodies that are kept apart.

    Args:
        stage: of the bodies.
        bodies: by the paths of their prims.
        groups: what UsdPhysics says of collision groups.
    """

    def __init__(self, stage: UsdStage, bodies: Mapping[str, UsdBody], groups: Iterable[Any]) -> None:
        self._stage = stage
        self._bodies = bodies
        self._groups = {str(group.primPath): group for group in groups}
        self._pairs: set[Pair] = set()

    def add_joints(self, joints: Iterable[UsdJoint]) -> None:
        """Adds the pairs that joints connect without letting them collide."""
        for joint in joints:
            if not joint.collides and all(body in self._bodies for body in joint.bodies):
                self._pairs.add(frozenset(joint.bodies))

    def add_filtered(self, parsed: Iterable[Any]) -> None:
        """Adds the pairs of `FilteredPairsAPI`s. `parsed`: bodies, shapes and articulations of UsdPhysics."""
        for each in parsed:
            others = [other for path in each.filteredCollisions for other in self._below(str(path))]
            if not others:
                continue
            own = self._below(str(each.primPath))
            if any(len(self._bodies[body].colliders) > 1 for body in (*own, *others) if body not in self._named(each)):
                prim = self._stage.prim(each.primPath)
                self._stage.lose("collision-filters", "a filter between single colliders, which holds for bodies", prim)
            self._pairs |= {frozenset((a, b)) for a in own for b in others if a != b}

    def _named(self, parsed: Any) -> set[str]:
        """Bodies that a filter names as a whole."""
        paths = [str(path) for path in (parsed.primPath, *parsed.filteredCollisions)]
        return {body for path in paths for body in self._below(path) if f"{body}/".startswith(f"{path}/")}

    def _below(self, path: str) -> list[str]:
        """The bodies at a path and below it; of a collider, its body."""
        found = [body for body in self._bodies if f"{body}/".startswith(f"{path}/")]
        if found:
            return found
        return [
            body
            for body, each in self._bodies.items()
            if any(str(prim.GetPath()) == path for prim, _ in each.colliders)
        ]

    def add_groups(self) -> None:
        """Adds the pairs of collision groups. Pairs of which only some colliders are kept apart are told."""
        apart = {
            frozenset((name, str(other))) for name, group in self._groups.items() for other in self._ignored(group)
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
                    self._stage.lose("collision-filters", "groups that hold for some colliders of a body", prim)
                elif found == {True}:
                    self._pairs |= {frozenset((a, b)) for a in ones for b in others if a != b}

    def _ignored(self, group: Any) -> list[str]:
        named = [str(path) for path in group.filteredGroups]
        # Of what UsdPhysics has parsed this one flag may be uninitialised memory.
        inverted = self._stage.value(self._stage.prim(group.primPath), "physics:invertFilteredGroups", default=False)
        return [path for path in self._groups if path not in named] if inverted else named

    def section(self, keys: Mapping[str, dict[str, Any]], names: Mapping[str, str]) -> dict[str, Any]:
        """The section `collision_groups`, whose names are set in the keys of the bodies.

        Args:
            keys: of each body that the scene has, by path.
            names: of the bodies.
        """
        neighbours: dict[str, set[str]] = {}
        for pair in self._pairs:
            if all({"shapes", "collisions"} & keys.get(body, {}).keys() for body in pair):
                a, b = sorted(pair)
                neighbours.setdefault(a, set()).add(b)
                neighbours.setdefault(b, set()).add(a)
        order = [path for path in keys if path in neighbours]
        classes = _twins(order, neighbours)
        if len(set(classes.values())) > _MAX_GROUPS:
            for pair in self._pairs:
                self._stage.lose("collision-filters", "a pair that is kept apart", self._stage.prim(min(pair)))
            return {}
        found: dict[str, Any] = {}
        group_names: dict[str, str] = {}
        for path in order:
            first = classes[path]
            if first not in group_names:
                wish = names[first].rpartition("/")[2]
                group_names[first] = wish if wish not in found else names[first].replace("/", "_")
                found[group_names[first]] = {}
            keys[path]["collision_group"] = group_names[first]
        for path in order:
            ignored = {group_names[classes[other]]: None for other in order if other in neighbours[path]}
            found[group_names[classes[path]]] = {"ignore": list(ignored)}
        return found


def _twins(order: list[str], neighbours: Mapping[str, set[str]]) -> dict[str, str]:
    """Body → the first body that is kept apart from the same others: either from one another too, or not."""
    found: dict[str, str] = {}
    near: dict[frozenset[str], list[str]] = {}
    far: dict[frozenset[str], list[str]] = {}
    for path in order:
        near.setdefault(frozenset(neighbours[path] | {path}), []).append(path)
        far.setdefault(frozenset(neighbours[path]), []).append(path)
    for members in (*(each for each in near.values() if len(each) > 1), *far.values()):
        alone = [path for path in members if path not in found]
        found.update(dict.fromkeys(alone, alone[0]) if alone else {})
    return found
