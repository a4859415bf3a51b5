"""Contacts of the last step as flat arrays, and the resulting forces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from scenecc.backends.sapien.objects import ArticulationObjects, BodyObjects, freeze_array, unknown_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import NDArray


class Contacts(NamedTuple):
    """Contact points, one row for each; N is their number in all scenes. The arrays are read-only.

    Bodies whose shapes are closer than the sum of their `contact_offset` also have points, with an impulse of 0. Rows
    are ordered by scene, then by build order of `a` and of `b`, then by `point`. If the caller names neither body, `a`
    is the one that was built first.

    Attributes:
        scene: (N,) int64, indices among all scenes of the plan, ascending.
        point: (N, 3) float32 [m], in the world of the scene.
        normal: (N, 3) float32, unit length, from `b` to `a`.
        separation: (N,) float32 [m], negative if shapes penetrate each other.
        impulse: (N, 3) float32 [N·s], on `a`, of one step, without friction, which SAPIEN omits.
        a, b: (N,) names of the two bodies: ENTITY, or ENTITY/LINK for a link.
    """

    scene: NDArray[np.int64]
    point: NDArray[np.float32]
    normal: NDArray[np.float32]
    separation: NDArray[np.float32]
    impulse: NDArray[np.float32]
    a: NDArray[np.str_]
    b: NDArray[np.str_]


class _Body(NamedTuple):
    """The owner of a component. `number`: in build order; `link`: of an articulation."""

    number: int
    name: str
    entity: str | None = None
    link: str | None = None

    def is_of(self, entity: str | None, link: str | None) -> bool:
        """Returns whether it belongs to an entity, or is one link of it. None: any."""
        return entity is None or (self.entity == entity and link in {None, self.link})


class _Point(NamedTuple):
    scene: int
    a: _Body
    b: _Body
    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    separation: float
    impulse: NDArray[np.float32]


class ContactReader:
    """Reads the contacts of SAPIEN's scenes by the names of the plan."""

    def __init__(self, entities: Mapping[str, BodyObjects | ArticulationObjects]) -> None:
        self._entities = entities
        self._bodies: dict[Any, _Body] = {}
        self._links: dict[str, list[list[str]]] = {}
        count = 0
        for name, objects in entities.items():
            if isinstance(objects, ArticulationObjects):
                # ManiSkill's link names are longer, but their entities have the plan's names.
                links = self._links[name] = [[each.get_name() for each in row] for row in objects.entities]
                for components, names in zip(objects.links, links, strict=True):
                    for number, (component, link) in enumerate(zip(components, names, strict=True), count):
                        self._bodies[component] = _Body(number, f"{name}/{link}", name, link)
                count += max(map(len, links))
            else:
                self._bodies |= dict.fromkeys(objects.components, _Body(count, name, name))
                count += 1
        self._count = count

    def read(self, scenes: Iterable[tuple[int, Any]], a: str | None, b: str | None) -> Contacts:
        """Reads the contacts between two bodies, of one with all others, or all. `scenes`: index and `sapien.Scene`.

        Raises KeyError for a name that is neither an entity nor ENTITY/LINK.
        """
        found = self._points(scenes, *((None, None) if name is None else self._find(name) for name in (a, b)))
        return Contacts(
            freeze_array(np.array([each.scene for each in found], np.int64)),
            freeze_array(np.array([each.position for each in found], np.float32).reshape(-1, 3)),
            freeze_array(np.array([each.normal for each in found], np.float32).reshape(-1, 3)),
            freeze_array(np.array([each.separation for each in found], np.float32)),
            freeze_array(np.array([each.impulse for each in found], np.float32).reshape(-1, 3)),
            freeze_array(np.array([each.a.name for each in found], np.str_)),
            freeze_array(np.array([each.b.name for each in found], np.str_)),
        )

    def net_force(self, scenes: Iterable[tuple[int, Any]], name: str, timestep: float) -> NDArray[np.float32]:
        """Returns the total contact force (B, 3) [N] on a body or articulation; NaN in a scene without the link.

        Rows are the scenes that have the entity. `scenes` and errors as for `read`.
        """
        entity, link = self._find(name)
        objects = self._entities[entity]
        total = np.zeros((len(objects.scene_idxs), 3))
        if link is not None:
            total[[link not in links for links in self._links[entity]]] = np.nan
        for point in self._points(scenes, (entity, link), (None, None)):
            if not point.b.is_of(entity, link):  # forces within an articulation cancel out
                total[objects.row_of[point.scene]] += point.impulse
        return freeze_array((total / timestep).astype(np.float32))

    def _points(
        self, scenes: Iterable[tuple[int, Any]], a: tuple[str | None, str | None], b: tuple[str | None, str | None]
    ) -> list[_Point]:
        """Returns points in a defined order, since that of the engine's contacts depends on memory addresses."""
        found: list[_Point] = []
        for index, scene in scenes:
            for contact in scene.get_contacts():
                first, second = (self._body(component) for component in contact.bodies)
                pairs = [(1, first, second), (-1, second, first)]
                if first.number > second.number:
                    pairs.reverse()
                for sign, one, other in pairs:
                    if one.is_of(*a) and other.is_of(*b):
                        found += [
                            _Point(index, one, other, p.position, sign * p.normal, p.separation, sign * p.impulse)
                            for p in contact.points
                        ]
                        break
        return sorted(found, key=lambda each: (each.scene, each.a.number, each.b.number, *each.position))

    def _body(self, component: Any) -> _Body:
        """Returns the owner of a component. One that was added by hand has only its name, and comes last."""
        return self._bodies.get(component) or _Body(self._count, str(component.get_entity().get_name()))

    def _find(self, name: str) -> tuple[str, str | None]:
        """Returns the entity of this name, or the entity with the longest matching prefix and its link."""
        if not isinstance(name, str):  # pyright: ignore[reportUnnecessaryIsInstance] - callers without a type checker
            raise TypeError(f"the name of an entity or link must be a string, not {name!r}")
        if name in self._entities:
            return name, None
        entity, _, _ = name.rpartition("/")
        while entity and entity not in self._entities:
            entity, _, _ = entity.rpartition("/")
        if entity not in self._links:
            raise unknown_name(name, tuple(self._entities), "entity")
        link = name[len(entity) + 1 :]
        known = dict.fromkeys(each for links in self._links[entity] for each in links)
        if link not in known:
            raise unknown_name(link, tuple(known), "link", entity)
        return entity, link
