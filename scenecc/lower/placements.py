"""What is placed: the keys of `place` to placements, in the order in which they are made, and their poses."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.lower.field_types import FieldType, field_type, report_exclusive_keys, report_unused_key
from scenecc.lower.placing_areas import warn_of_areas
from scenecc.lower.poses import ROTATIONS, pose_item, warn_probable_degrees
from scenecc.lower.rendering import MountLookup
from scenecc.lower.variation import VariationLowerer, field_place
from scenecc.plan import ArticulationStructure, Mount, Nearness, Placement, Value, literal
from scenecc.plan.geometry import Plane
from scenecc.plan.properties import MAX_COORDINATE
from scenecc.spec.pose import PoseMapping
from scenecc.variation.nodes import NODES, FromAxisAngle, Posed, Radians

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.entities import EntityLowerer
    from scenecc.lower.fields import FieldLowerer
    from scenecc.plan import CollisionShape, Entity
    from scenecc.spec.document import SceneFile
    from scenecc.spec.references import NameScopes

_KINDS = ("on", "inside", "above")
_WHERE = ("at", "region")
_TURNS = ("yaw", "yaw_deg", "q", "rpy", "rpy_deg", "axis_angle", "facing")
_POINT = FieldType((2,), fallback=(0.0, 0.0))
_ANGLE = FieldType()
_QUATERNION = field_type("rotation", fallback=(1.0, 0.0, 0.0, 0.0))
_RADIUS = field_type("Placement.radius", fallback=1.0)
_HEIGHT = field_type("height")


_LOW, _HIGH = (
    field_type(end, conversion=f"{end}_corner", fallback=(0.0, 0.0, far), pad=far)
    for end, far in (("low", -MAX_COORDINATE), ("high", MAX_COORDINATE))
)


def placed_nodes(scene: SceneFile) -> dict[str, tuple[str, Any]]:
    """What a document places, entities and instances: name → its section and its keys."""
    sections: tuple[tuple[str, Mapping[str, Any]], ...] = (("frames", scene.frames), ("entities", scene.entities))
    return {
        name: (section, node.place)
        for section, nodes in sections
        for name, node in nodes.items()
        if getattr(node, "place", None) is not None
    }


class PlacementLowerer:
    """Lowers what a document places.

    Args:
        scene: the document.
        built: its entities.
        entities: lowered them.
        names: what names of the document mean.
        origin: of its root.
    """

    def __init__(
        self, scene: SceneFile, built: tuple[Entity, ...], entities: EntityLowerer, names: NameScopes, origin: Origin
    ) -> None:
        self._scene, self._names, self._origin = scene, names, origin
        self._built = {entity.name: entity for entity in built}
        self._entities = entities
        self._frames = entities.frames
        self._sink = entities.frames.sink
        self._placed = placed_nodes(scene)
        self._roots: dict[str, str] = {}
        self._upright: set[str] = set()
        self._member_names: dict[str | None, list[str]] = {}
        self._mounts = MountLookup(built, entities.frames.unread, names, self._sink)

    def lower(self) -> tuple[Placement, ...]:
        """The placements in the order in which they are made; what was reported is missing."""
        made: dict[str, Placement] = {}
        for name, (section, place) in self._placed.items():
            one = self._placement(name, place, self._origin.child(section, name))
            if one is not None:
                made[name] = one
        if self._sink.failed:
            return ()
        # An instance counts where the first of what it holds stands.
        number = {name: index for index, name in enumerate(self._built)}
        first = {name: min((number[member] for member in one.entities), default=0) for name, one in made.items()}
        ordered = self._ordered({name: made[name] for name in sorted(made, key=first.__getitem__)})
        warn_of_areas(ordered, self._upright, self._built, self._sink)
        return ordered

    def _placement(self, name: str, place: Any, owner: Origin) -> Placement | None:
        origin, fields = owner.child("place"), self._entities.fields(name)
        if owner.path[0] == "frames" and name not in self._names.anchors.values():
            self._sink.report("SC101", "unknown key `place` of a frame", origin, at="key", hint="write a `pose`")
            return None
        inner = [one for one in self._placed if self._names.scopes.get(one, "").startswith(name)]
        if owner.path[0] == "frames" and inner:
            message = f"`{cut(name)}` places `{cut(inner[0])}` itself"
            self._sink.report("SC358", message, origin, at="key", hint="give the instance a `pose`")
            return None
        if owner.path[0] == "entities" and self._scene.entities[name].pose is not None:
            report_exclusive_keys("pose", "place", owner, self._sink)
        kind = self._one_key(place, _KINDS, origin, required=True)
        where = self._one_key(place, _WHERE, origin)
        turn = self._one_key(place, _TURNS, origin)
        if turn not in ROTATIONS:
            self._upright.add(name)
        if kind is None:
            return None
        target = self._mount(getattr(place, kind), name, fields, origin.child(kind))
        if target is None or not self._collides(target, origin.child(kind)):
            return None
        made = Placement(
            name, fields.scenes, kind, target, self._members(name), near=self._near(place, name, fields, origin),
            apart=place.apart, gap=place.gap, tries=place.tries, origin=origin,
            height=self._height(place, kind, fields, origin),
        )  # fmt: skip
        if place.at is not None:
            made = replace(made, at=fields.value(place.at, _POINT, owner, "place", "at", reset=True))
        elif where == "region":
            made = self._region(made, place.region, fields, owner)
        elif self._is_endless(target):
            self._sink.report(
                "SC352", f"`{target}` is a plane without an end", origin.child(kind), hint="write `region` or `at`"
            )
        made = self._axes(made, place, fields, owner)
        return self._turned(made, place, turn, fields, owner)

    def _one_key(self, place: Any, keys: tuple[str, ...], origin: Origin, *, required: bool = False) -> Any:
        given = [key for key in keys if getattr(place, key) is not None]
        if len(given) > 1:
            report_exclusive_keys(given[0], given[1], origin, self._sink)
        if not given and required:
            self._sink.report("SC102", "`place` lacks the key `on`, `inside` or `above`", origin, at="key")
        return given[0] if given else None

    def _mount(self, written: str, name: str, fields: FieldLowerer, place: Origin) -> Mount | None:
        scope = self._names.scopes.get(name, "")
        found = self._mounts.find(written, scope, fields.scenes, place)
        if found is not None and found.entity == self._names.full_name(written, scope):
            return Mount(found.entity)
        return found

    def _members(self, name: str) -> tuple[Mount, ...]:
        if not self._member_names:
            for entity in self._built:
                self._member_names.setdefault(self._frames.placed_root(entity), []).append(entity)
        return tuple(map(Mount, self._member_names.get(name, ())))

    def _collides(self, target: Mount, place: Origin) -> bool:
        if any(self._shapes(target)):
            return True
        hint = "give it `collisions`, or write it as `shapes`, which collide and are visible"
        self._sink.report("SC359", f"nothing stands on `{target}`: it has no colliding shape", place, hint=hint)
        return False

    def _is_endless(self, target: Mount) -> bool:
        return all(isinstance(shape.geometry, Plane) for shape in self._shapes(target))

    def _shapes(self, target: Mount) -> Iterator[CollisionShape]:
        for structure in self._built[target.entity].structures:
            names = [link.name for link in structure.links] if isinstance(structure, ArticulationStructure) else [None]
            for name, body in zip(names, structure.bodies, strict=True):
                if target.link in {None, name}:
                    yield from body.collisions

    def _near(self, place: Any, name: str, fields: FieldLowerer, origin: Origin) -> tuple[Nearness, ...]:
        found: list[Nearness] = []
        for other, (least, most) in place.near.items():
            where = origin.child("near", other)
            mount = self._mount(other, name, fields, where)
            if least > most:
                self._sink.report("SC107", f"the least distance {least:g} is above the greatest, {most:g}", where)
            if mount is not None and mount.link is not None:
                self._sink.report("SC331", f"`near` names entities, and `{cut(other)}` is a link", where, at="key")
            elif mount is not None:
                found.append(Nearness(mount.entity, least, most))
        return tuple(found)

    def _height(self, place: Any, kind: str, fields: FieldLowerer, origin: Origin) -> Value | None:
        if place.height is None:
            if kind == "above":
                self._sink.report("SC102", "`above` needs the key `height`", origin, at="key")
            return None
        if kind != "above":
            report_unused_key("height", f"beside `{kind}`", origin, self._sink)
            return None
        value = fields.value(place.height, _HEIGHT, origin, "height", reset=True)
        if value.known and (value.data[:, 0] > value.data[:, 1]).any():
            self._sink.report("SC107", "the least height is above the greatest", origin.child("height"))
        return value

    def _region(self, made: Placement, region: Any, fields: FieldLowerer, owner: Origin) -> Placement:
        at: tuple[str, ...] = ("place", "region")
        if isinstance(region, str):
            frame = self._names.full_name(region, self._names.scopes.get(made.name, ""))
            node = self._scene.frames.get(frame)
            if node is None or node.region is None:
                known = ", ".join(name for name, one in self._scene.frames.items() if one.region is not None)
                hint = f"frames with a region: {known}" if known else "give a frame the key `region`"
                self._sink.report(
                    "SC353", f"there is no frame `{cut(region)}` with a `region`", owner.child(*at), hint=hint
                )
                return made
            owner, at, region = self._origin.child("frames", frame), ("region",), node.region
            made = self._in_frame(made, frame, fields, owner)
            fields = self._entities.fields(frame) if fields.scenes is self._entities.fields(frame).scenes else fields
        if region.__class__ is list:
            place = owner.child(*at)
            if len({len(corner) for corner in region if corner.__class__ is list}) > 1:
                message = "one corner has a height and the other has none"
                self._sink.report("SC106", message, place, hint="write both as [x, y], or both as [x, y, z]")
            low, high = (
                fields.value(region[number], kind, place.child(number), reset=True)
                for number, kind in enumerate((_LOW, _HIGH))
            )
            return replace(made, low=low, high=high)
        return replace(
            made,
            center=fields.value(region.center, _POINT, owner, *at, "center", reset=True),
            radius=fields.value(region.radius, _RADIUS, owner, *at, "radius", reset=True),
        )

    def _axes(self, made: Placement, place: Any, fields: FieldLowerer, owner: Origin) -> Placement:
        if place.relative_to is None:
            return made
        frame = self._names.parent(made.name, place.relative_to)
        if frame is None:
            return replace(made, frame=literal(IDENTITY_POSE))
        return self._in_frame(made, frame, fields, owner.child("place"))

    def _in_frame(self, made: Placement, name: str, fields: FieldLowerer, origin: Origin) -> Placement:
        key = f"placements:{made.name}"
        variation = VariationLowerer(fields, origin)
        frame = self._frames.follow(key, name, IDENTITY_POSE, variation, fields, origin)
        follower = self._frames.followers.get(key)
        root = None if follower is None or follower.parent is None else self._frames.placed_root(follower.parent)
        if root is not None:
            self._roots[made.name] = root
        return replace(made, frame=frame)

    def _turned(self, made: Placement, place: Any, turn: str | None, fields: FieldLowerer, owner: Origin) -> Placement:
        if turn is None:
            return made
        at = owner.child("place", turn)
        if turn == "facing":
            if isinstance(place.facing, str):
                found = self._mount(place.facing, made.name, fields, at)
                return made if found is None else replace(made, facing=found)
            return replace(made, facing_point=fields.value(place.facing, _POINT, owner, "place", turn, reset=True))
        variation = VariationLowerer(fields, at)
        item: Any
        if turn in ROTATIONS:
            pose = PoseMapping.model_construct(_fields_set={turn}, **{turn: getattr(place, turn)})
            item = pose_item(pose, field_place(owner.child("place")), variation, self._sink)
            item = item.q if isinstance(item, Posed) else tuple(item[3:])
        else:
            written = getattr(place, turn)
            if turn == "yaw":
                warn_probable_degrees(written, turn, owner, ("place", turn), self._sink)
            angle = variation.item(written, _ANGLE, field_place(at))
            item = FromAxisAngle((0.0, 0.0, 1.0), angle if turn == "yaw" else Radians(angle))
        if item.__class__ not in NODES:
            return replace(made, rotation=literal(item))
        return replace(made, rotation=fields.finish(item, variation, _QUATERNION, at, reset=True))

    def _ordered(self, made: dict[str, Placement]) -> tuple[Placement, ...]:
        """Build-time placements first, then the others, each after those that it reads."""
        owner = {member: one.name for one in made.values() for member in one.entities}
        reads: dict[str, dict[str, Origin]] = {}
        fixed = {name: all(map(self._frames.is_fixed, one.entities)) for name, one in made.items()}
        for name, one in made.items():
            reads[name] = {owner[entity]: place for entity, place in _read_entities(one) if entity in owner}
            if name in self._roots:
                reads[name].setdefault(self._roots[name], _place_of(one))
            for entity, place in _read_entities(one) if fixed[name] else ():
                moving = not fixed[owner[entity]] if entity in owner else self._moves_at_reset(entity)
                if moving:
                    message = (
                        f"`{cut(name)}` stays as it is built, and a reset moves `{cut(owner.get(entity, entity))}`"
                    )
                    self._sink.report("SC351", message, place, hint="give one of them another body_type")
        if self._reports_circle(reads):
            return ()
        ordered: dict[str, Placement] = {}

        for name in sorted(made, key=lambda one: not fixed[one]):
            todo = [name]
            while todo:
                waiting = [other for other in reads[todo[-1]] if other not in ordered]
                if not waiting:
                    ready = todo.pop()
                    ordered[ready] = made[ready]
                else:
                    todo.append(waiting[0])
        return tuple(replace(one, carriers=self._carriers(one, made, owner)) for one in ordered.values())

    def _moves_at_reset(self, entity: str) -> bool:
        return not (self._built[entity].pose.known or self._frames.is_fixed(entity))

    def _reports_circle(self, reads: Mapping[str, Mapping[str, Origin]]) -> bool:
        clear: set[str] = set()
        found = False
        for start in reads:
            if start in clear:
                continue
            chain, todo = [start], [iter(reads[start])]
            while todo:
                other = next(todo[-1], None)
                if other is None:
                    clear.add(chain.pop())
                    todo.pop()
                elif other in chain:
                    members = [*chain[chain.index(other) :], other]
                    shown = " → ".join(map(cut, members))
                    message = f"placements wait for one another in a circle: {shown}"
                    self._sink.report("SC350", message, reads[other][members[1]], hint="give one of them a `pose`")
                    found = True
                elif other not in clear:
                    chain.append(other)
                    todo.append(iter(reads[other]))
        return found

    def _carriers(self, one: Placement, made: Mapping[str, Placement], owner: Mapping[str, str]) -> tuple[Mount, ...]:
        """What a target stands on or in, or is relative to."""
        found: dict[str, None] = {}
        todo = [one.target.entity]
        while todo:
            at = todo.pop()
            parent = self._frames.frame_pose(at).parent
            below = [parent] if parent is not None else []
            if at in owner:
                below.append(made[owner[at]].target.entity)
            for other in below:
                if other not in found and other != one.target.entity:
                    found[other] = None
                    todo.append(other)
        return tuple(Mount(name) for name in found if name in self._built)


def _place_of(one: Placement) -> Origin:
    assert one.origin is not None
    return one.origin


def _read_entities(one: Placement) -> Iterator[tuple[str, Origin]]:
    """The entities that a placement reads, and where it names each."""
    origin = _place_of(one)
    yield one.target.entity, origin.child(one.kind)
    if one.facing is not None:
        yield one.facing.entity, origin.child("facing")
    for near in one.near:
        yield near.entity, origin.child("near")


def lower_placements(
    scene: SceneFile, built: tuple[Entity, ...], entities: EntityLowerer, names: NameScopes, origin: Origin
) -> tuple[Placement, ...]:
    """The placements of a document, in the order in which they are made. Arguments are those of `PlacementLowerer`."""
    return PlacementLowerer(scene, built, entities, names, origin).lower()
