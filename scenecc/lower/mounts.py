"""What lights, cameras and constraints are mounted on, and the poses of lights and cameras."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY, shortest_from_x
from scenecc.lower.field_types import POSITION, FieldType, report_unused_key
from scenecc.lower.poses import POSE, pose_item
from scenecc.lower.variation import FieldPlace, VariationLowerer, field_place
from scenecc.plan import ArticulationStructure, Value, literal
from scenecc.plan.body import Mount
from scenecc.spec.pose import PoseMapping
from scenecc.variation.nodes import Pointing, Posed

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Iterator

    from scenecc.diagnostics import Origin, Sink
    from scenecc.diagnostics.diagnostic import RelatedPlace
    from scenecc.lower.fields import FieldLowerer
    from scenecc.plan import Entity
    from scenecc.spec.references import NameScopes


class MountLookup:
    """Finds what names mean: ENTITY, or ENTITY/LINK.

    Of an entity's name with slashes the longest that exists is meant. An articulation without a link stands for its
    root link.

    Args:
        entities: all of the plan.
        unread: names of entities whose files are wrong, which was reported: what they hold is not known.
        names: of the document.
        sink: takes the diagnostics.
    """

    def __init__(self, entities: Iterable[Entity], unread: Container[str], names: NameScopes, sink: Sink) -> None:
        self._entities = {entity.name: entity for entity in entities}
        self._unread = unread
        self._names = names
        self._sink = sink

    def find(self, written: str, scope: str, scenes: tuple[int, ...], place: Origin) -> Mount | None:
        """What is meant; None where it was reported.

        Args:
            written: the name.
            scope: in which it is written; "" for the document.
            scenes: in which it must exist.
            place: of the name.
        """
        prefix = self._names.prefixes.get(scope, "")
        entity, rest = self._split(prefix + written, len(prefix))
        if entity is None:
            if any(name in self._unread for name in _prefixes(prefix + written, len(prefix))):
                return None
            seen = list(self._seen_from(prefix, scope))
            hint = suggest_name(written, seen, self._sink, self._links_of(prefix, seen))
            self._sink.report("SC330", f"there is no entity `{cut(written)}`", place, hint=hint)
            return None
        mount = self._link(entity, rest, place)
        missing = None if entity.scene_idxs is scenes else set(scenes).difference(entity.scene_idxs)
        if mount is not None and missing:
            self._absent(entity, min(missing), place)
            return None
        return mount

    def _absent(self, entity: Entity, scene: int, place: Origin) -> None:
        related: list[RelatedPlace] = []
        if entity.origin is not None:
            related.append((f"where `{cut(entity.name)}` is", entity.origin.child("scene_idxs"), "value"))
        message = f"`{cut(entity.name)}` is not in scene {scene}, and this is"
        hint = f"write the `scene_idxs` of `{cut(entity.name)}` here too"
        self._sink.report("SC311", message, place, hint=hint, related=related)

    def _split(self, name: str, shortest: int) -> tuple[Entity | None, str | None]:
        """The entity with the longest name that a name begins with, and what is left."""
        for ahead in _prefixes(name, shortest):
            entity = self._entities.get(ahead)
            if entity is not None:
                return entity, name[len(ahead) + 1 :] or None
        return None, None

    def _seen_from(self, prefix: str, scope: str) -> Iterable[str]:
        for name in self._entities:
            if name.startswith(prefix) and self._names.scopes.get(name, "") == scope:
                yield name[len(prefix) :]

    def _links_of(self, prefix: str, seen: Iterable[str]) -> Iterator[str]:
        """The links of entities, as they are written."""
        for name in seen:
            first = self._entities[prefix + name].structures[0]
            if isinstance(first, ArticulationStructure):
                for link in first.links:
                    yield f"{name}/{link.name}"

    def _link(self, entity: Entity, link: str | None, place: Origin) -> Mount | None:
        first, *others = entity.structures
        if not isinstance(first, ArticulationStructure):
            if link is None:
                return Mount(entity.name)
            self._sink.report("SC331", f"`{cut(entity.name)}` is a body and has no links", place)
            return None
        links = [one.name for one in first.links]
        # Links of an entity whose structures are several robots: those that it has in every scene.
        shared = set(links).intersection(
            *([one.name for one in other.links] for other in others if isinstance(other, ArticulationStructure))
        )
        link_name = links[0] if link is None else link
        if link_name in shared:
            return Mount(entity.name, link_name)
        hint = suggest_name(link_name, [name for name in links if name in shared], self._sink)
        message = f"no link of `{cut(entity.name)}` is called `{cut(link_name)}`"
        if others:
            message = f"not every robot that `{cut(entity.name)}` may be has a link `{cut(link_name)}`"
        self._sink.report("SC331", message, place, hint=hint)
        return None


def _prefixes(name: str, shortest: int) -> Iterator[str]:
    """What a name begins with up to each of its slashes, the whole first."""
    end = len(name)
    while end > shortest:
        yield name[:end]
        end = name.rfind("/", 0, end)


_FORWARD = (1.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class MountPose:
    """A pose as it was read.

    Attributes:
        item: seven numbers, or a node.
        variation: of it.
        relative_to: as written.
    """

    item: Any
    variation: VariationLowerer
    relative_to: str | None = None


def read_pose(pose: Any, origin: Origin, fields: FieldLowerer) -> MountPose:
    """A pose as written; None: the identity. `origin`: of the node that has the key `pose`."""
    place = field_place(origin.child("pose"))
    variation = VariationLowerer(fields, place.origin)
    relative_to = pose.relative_to if isinstance(pose, PoseMapping) else None
    return MountPose(pose_item(pose, place, variation, fields.sink), variation, relative_to)


def read_direction(position: Any, direction: Any, origin: Origin, fields: FieldLowerer) -> MountPose:
    """A position [m] and a direction that +x turns to by the shortest rotation; either may be None."""
    variation = VariationLowerer(fields, origin)
    p: Any = (0.0, 0.0, 0.0) if position is None else position
    p = variation.item(p, POSITION, field_place(origin.child("position")))
    q = (
        IDENTITY
        if direction is None
        else _direction_turn(direction, field_place(origin.child("direction")), variation, fields)
    )
    if p.__class__ is tuple and q.__class__ is tuple:
        return MountPose((*p, *q), variation)
    return MountPose(Posed(p, q), variation)


def _direction_turn(direction: Any, place: FieldPlace, variation: VariationLowerer, fields: FieldLowerer) -> Any:
    def convert(one: Any) -> Any:
        return tuple(one) if any(one) else None

    def complain(_one: Any, origin: Origin, _sink: Any) -> None:
        fields.sink.report("SC114", "a direction of length 0 points nowhere", origin)

    item = variation.item(direction, FieldType((3,), convert=convert, complain=complain, fallback=_FORWARD), place)
    if item.__class__ is tuple:
        return shortest_from_x(item)
    return variation.risk(Pointing(item), place.origin)


def mounted_pose(mount_pose: MountPose, what: str, origin: Origin, fields: FieldLowerer) -> Value:
    """The pose of what is mounted, in the frame of the body.

    Args:
        mount_pose: as read.
        what: it is, for a message.
        origin: of the node that has the key `pose`.
        fields: of the object.
    """
    if mount_pose.relative_to is not None:
        where = f"here: {what} that is mounted stands in the frame of its body"
        hint = "leave `relative_to` out, or `mount`"
        report_unused_key("relative_to", where, origin.child("pose"), fields.sink, hint=hint)
    if mount_pose.item.__class__ is tuple:
        return literal(mount_pose.item)
    return fields.finish(mount_pose.item, mount_pose.variation, POSE, origin.child("pose"))
