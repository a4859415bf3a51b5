"""Looks up the body or link of a name, for lights, cameras, constraints and placements."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut, listed, suggest_name
from scenecc.lower.link_frames import find_link
from scenecc.lower.references import name_prefixes
from scenecc.plan import ArticulationStructure
from scenecc.plan.body import Mount

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import At, Origin, RelatedPlace
    from scenecc.plan import Entity
    from scenecc.spec.references import NameScopes


class MountLookup:
    """Resolves names: ENTITY, or ENTITY/LINK.

    A name with slashes refers to the longest entity name that exists. An instance of a prefab that holds one entity
    means that entity. An articulation without a link means its root link.

    Args:
        entities: all entities of the plan.
        unread: names of entities with an error in their file, which was reported. Their links are unknown.
        names: of the document.
        sink: receives the diagnostics.
    """

    def __init__(self, entities: Iterable[Entity], unread: Container[str], names: NameScopes, sink: Sink) -> None:
        self._entities = {entity.name: entity for entity in entities}
        self._unread = unread
        self._names = names
        self._sink = sink

    def find(
        self,
        written: str,
        scope: str,
        scenes: tuple[int, ...],
        place: Origin,
        *,
        span: tuple[int, int] | None = None,
        at: At = "value",
    ) -> Mount | None:
        """Finds the body or link of a name; None after an error.

        Args:
            written: the name.
            scope: of the name; "" for the document.
            scenes: in which it must exist.
            place: of the name.
            span: the part of the text at `place`; None: all of it.
            at: whether the name is a key.
        """
        prefix = self._names.prefixes.get(scope, "")
        if written.startswith("/"):
            prefix, scope, written = "", "", written[1:]
        entity, rest = self._split(prefix + written, len(prefix))
        if entity is None:
            if any(name in self._unread for name in name_prefixes(prefix + written, len(prefix))):
                return None
            seen = list(self._names_seen_from(prefix, scope))
            inside = tuple(name[len(prefix) :] for name in self._entities if name.startswith(f"{prefix}{written}/"))
            here = dict.fromkeys(
                name[len(prefix) :].split("/")[0] for name in self._entities if name.startswith(prefix)
            )
            hint = listed(inside) or suggest_name(written, here, self._sink, self._links_of(prefix, seen))
            self._sink.report("SC330", f"there is no entity `{cut(written)}`", place, at=at, hint=hint, span=span)
            return None
        mount = self._link(entity, rest, place, span)
        missing = None if entity.scene_idxs is scenes else set(scenes).difference(entity.scene_idxs)
        if mount is not None and missing:
            self._report_absent(entity, min(missing), place)
            return None
        return mount

    def _report_absent(self, entity: Entity, scene: int, place: Origin) -> None:
        related: list[RelatedPlace] = []
        if entity.origin is not None:
            related.append((f"the scenes of `{cut(entity.name)}`", entity.origin.child("scene_idxs"), "value"))
        message = f"`{cut(entity.name)}` is not in scene {scene}, but this is"
        hint = f"write the `scene_idxs` of `{cut(entity.name)}` here too"
        self._sink.report("SC311", message, place, hint=hint, related=related)

    def _split(self, name: str, shortest: int) -> tuple[Entity | None, str | None]:
        """The entity with the longest name that is a prefix of a name, and the rest."""
        for ahead in name_prefixes(name, shortest):
            entity = self._entities.get(ahead)
            if entity is not None:
                return entity, name[len(ahead) + 1 :] or None
        for instance in dict.fromkeys((name, name.rpartition("/")[0])):
            inside = [one for other, one in self._entities.items() if instance and other.startswith(f"{instance}/")]
            rest = name[len(instance) + 1 :] or None
            if len(inside) == 1 and (rest is None or isinstance(inside[0].structures[0], ArticulationStructure)):
                return inside[0], rest
        return None, None

    def _names_seen_from(self, prefix: str, scope: str) -> Iterable[str]:
        for name in self._entities:
            if name.startswith(prefix) and self._names.scopes.get(name, "") == scope:
                yield name[len(prefix) :]

    def _links_of(self, prefix: str, seen: Iterable[str]) -> Iterator[str]:
        """The link names of entities, as a scene file writes them."""
        for name in seen:
            first = self._entities[prefix + name].structures[0]
            if isinstance(first, ArticulationStructure):
                for link in first.links:
                    yield f"{name}/{link.name}"

    def _link(self, entity: Entity, link: str | None, place: Origin, span: tuple[int, int] | None) -> Mount | None:
        if not isinstance(entity.structures[0], ArticulationStructure):
            if link is None:
                return Mount(entity.name)
            self._sink.report("SC331", f"`{cut(entity.name)}` is a body and has no links", place, span=span)
            return None
        found = find_link(entity.name, entity.structures, link, place, self._sink, span)
        return None if found is None else Mount(entity.name, found)
