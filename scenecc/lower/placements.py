"""Lowers `place` keys to placements, in the order in which they are made, and computes their poses."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.assets.errors import AssetError
from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.geometry.rotations import IDENTITY_POSE, MAX_COORDINATE
from scenecc.lower.field_types import FieldType, field_type, report_unused_key
from scenecc.lower.forms import VariationLowerer, field_place
from scenecc.lower.mounts import MountLookup
from scenecc.lower.placing_areas import distance_beyond_target, warn_of_areas
from scenecc.lower.poses import pose_item, warn_probable_degrees
from scenecc.placing.bodies import UnsupportedShapeError, rows_in, rows_of
from scenecc.placing.place import place_next
from scenecc.placing.placer import Placer, PlacingError
from scenecc.plan import ArticulationStructure, Mount, Nearness, NextTo, Placement, Value, literal
from scenecc.plan.geometry import Plane
from scenecc.spec.placing import TARGETS, TURNS
from scenecc.spec.pose import ROTATIONS, PoseMapping
from scenecc.variation.chosen import DrawFailure
from scenecc.variation.evaluation import Batch
from scenecc.variation.nodes import NODES, FromAxisAngle, Posed, Radians
from scenecc.variation.operations import COMPUTE_LIMIT_HINT, ComputeLimitError, DrawError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import At
    from scenecc.geometry.rotation_arrays import Floats
    from scenecc.lower.entities import EntityLowerer
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.frames import FrameGraph
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan import CollisionShape, Entity, ScenePlan
    from scenecc.spec.document import SceneFile
    from scenecc.spec.references import NameScopes


_POINT = FieldType((2,), fallback=(0.0, 0.0))
_ANGLE = FieldType()
_QUATERNION = field_type("Placement.rotation", fallback=(1.0, 0.0, 0.0, 0.0))
_RADIUS = field_type("Placement.radius", fallback=1.0)
_HEIGHT = field_type("Placement.height")


_LOW, _HIGH = (
    field_type(f"Placement.{end}", conversion=f"{end}_corner", fallback=(0.0, 0.0, far), pad=far)
    for end, far in (("low", -MAX_COORDINATE), ("high", MAX_COORDINATE))
)

_COLLISIONS_HINT = "give it `collisions`, or write it as `shapes`, which collide and are visible"


def placed_nodes(scene: SceneFile) -> dict[str, tuple[str, Any]]:
    """The placed entities and instances of a document: name → section and keys."""
    sections: tuple[tuple[str, Mapping[str, Any]], ...] = (("frames", scene.frames), ("entities", scene.entities))
    return {
        name: (section, node.place)
        for section, nodes in sections
        for name, node in nodes.items()
        if getattr(node, "place", None) is not None
    }


class PlacementLowerer:
    """Lowers the placements of a document.

    Args:
        scene: the document.
        built: its entities.
        entities: has lowered them.
        names: resolves names of the document.
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
        """The placements in the order in which they are made, without those with errors."""
        made: dict[str, Placement] = {}
        for name, (section, place) in self._placed.items():
            one = self._lower_placement(name, place, self._origin.child(section, name))
            if one is not None:
                made[name] = one
        if self._sink.failed:
            return ()
        # An instance has the position of its first entity.
        number = {name: index for index, name in enumerate(self._built)}
        first = {name: min((number[member] for member in one.entities), default=0) for name, one in made.items()}
        ordered = self._order({name: made[name] for name in sorted(made, key=first.__getitem__)})
        warn_of_areas(ordered, self._upright, self._built, self._sink)
        return ordered

    def _lower_placement(self, name: str, place: Any, owner: Origin) -> Placement | None:
        origin, fields = owner.child("place"), self._entities.fields(name)
        if owner.path[0] == "frames" and name not in self._names.anchors.values():
            self._sink.report("SC101", "unknown key `place` of a frame", origin, at="key", hint="write a `pose`")
            return None
        inner = [one for one in self._placed if f"{self._names.scopes.get(one, '')}/".startswith(f"{name}/")]
        if owner.path[0] == "frames" and inner:
            message = f"`{cut(name)}` contains `{cut(inner[0])}`, which has its own `place`"
            self._sink.report("SC358", message, origin, at="key", hint="give the instance a `pose`")
            return None
        kind, turn = _given_key(place, TARGETS), _given_key(place, TURNS)
        if turn not in ROTATIONS:
            self._upright.add(name)
        if kind is None:
            hint = (
                None if place.next_to is None else "`next_to` places it sideways: add what it stands on, `on: ENTITY`"
            )
            self._sink.report("SC102", "`place` lacks the key `on`, `inside` or `above`", origin, at="key", hint=hint)
            return None
        target = self._mount(getattr(place, kind), name, fields, origin.child(kind))
        if target is None or not self._collides(target, origin.child(kind)):
            return None
        made = Placement(
            name, fields.scenes, kind, target, self._find_members(name),
            near=self._lower_nearness(place, name, fields, origin),
            apart=place.apart, gap=place.gap, tries=place.tries, origin=origin,
            height=self._lower_height(place, kind, fields, origin),
        )  # fmt: skip
        if place.at is not None:
            made = replace(made, at=fields.value(place.at, _POINT, owner, "place", "at", reset=True))
        elif place.region is not None:
            made = self._with_region(made, place.region, fields, owner)
        elif place.next_to is not None:
            made = self._with_neighbour(made, place, fields, origin)
        elif self._is_endless(target):
            self._sink.report(
                "SC352", f"`{target}` is an infinite plane", origin.child(kind), hint="write `region` or `at`"
            )
        if place.align is not None and place.next_to is None:
            report_unused_key("align", "without `next_to`", origin, self._sink)
        made = self._with_axes(made, place, fields, owner)
        made = self._with_rotation(made, place, turn, fields, owner)
        # All tries of a neighbour without drawn rotation are the same.
        is_one = made.next_to is not None and (made.rotation is None or made.rotation.is_constant)
        if fields.sampling.record is not None:
            from scenecc.lower.draw_sources import add_placing  # noqa: PLC0415 - only where numbers are chosen

            add_placing(fields.sampling, made)
        return replace(made, tries=1) if is_one else made

    def _mount(self, written: str, name: str, fields: FieldLowerer, place: Origin, at: At = "value") -> Mount | None:
        scope = self._names.scopes.get(name, "")
        found = self._mounts.find(written, scope, fields.scenes, place, at=at)
        if found is not None and found.entity == self._names.full_name(written, scope):
            return Mount(found.entity)
        return found

    def _find_members(self, name: str) -> tuple[Mount, ...]:
        if not self._member_names:
            for entity in self._built:
                self._member_names.setdefault(self._frames.placed_root(entity), []).append(entity)
        return tuple(map(Mount, self._member_names.get(name, ())))

    def _collides(self, target: Mount, place: Origin) -> bool:
        if any(self._shapes(target)):
            return True
        message = f"nothing can be placed on `{target}`: it has no collision shape"
        self._sink.report("SC359", message, place, hint=_COLLISIONS_HINT)
        return False

    def _is_endless(self, target: Mount) -> bool:
        return all(isinstance(shape.geometry, Plane) for shape in self._shapes(target))

    def _shapes(self, target: Mount) -> Iterator[CollisionShape]:
        for structure in self._built[target.entity].structures:
            names = [link.name for link in structure.links] if isinstance(structure, ArticulationStructure) else [None]
            for name, body in zip(names, structure.bodies, strict=True):
                if target.link in {None, name}:
                    yield from body.collisions

    def _lower_nearness(self, place: Any, name: str, fields: FieldLowerer, origin: Origin) -> tuple[Nearness, ...]:
        found: list[Nearness] = []
        for other, (least, most) in place.near.items():
            where = origin.child("near", other)
            mount = self._mount(other, name, fields, where, at="key")
            if least > most:
                self._sink.report("SC107", f"the minimum distance {least:g} is above the maximum, {most:g}", where)
            if mount is not None and mount.link is not None:
                self._sink.report("SC331", f"`near` takes entities, but `{cut(other)}` is a link", where, at="key")
            elif mount is not None and self._has_distances(mount, where):
                found.append(Nearness(mount.entity, least, most))
        if found and not any(any(self._shapes(member)) for member in self._find_members(name)):
            message = f"`near` measures between colliding shapes, and `{cut(name)}` has none"
            self._sink.report("SC359", message, origin.child("near"), at="key", hint=_COLLISIONS_HINT)
        return tuple(found)

    def _has_distances(self, other: Mount, place: Origin) -> bool:
        """Whether distances from an entity can be computed for `near`; otherwise reports it."""
        shapes = [*self._shapes(other)]
        if not shapes:
            message, hint = f"`near` measures between colliding shapes, and `{other}` has none", _COLLISIONS_HINT
        elif self._is_endless(other):
            message = f"`near` measures no distance from a plane, and all colliding shapes of `{other}` are planes"
            hint = "remove it; `region` or `at` says where on a plane"
        else:
            return True
        self._sink.report("SC359", message, place, at="key", hint=hint)
        return False

    def _lower_height(self, place: Any, kind: str, fields: FieldLowerer, origin: Origin) -> Value | None:
        if place.height is None:
            if kind == "above":
                self._sink.report("SC102", "`above` needs the key `height`", origin, at="key")
            return None
        if kind != "above":
            report_unused_key("height", f"beside `{kind}`", origin, self._sink)
            return None
        value = fields.value(place.height, _HEIGHT, origin, "height", reset=True)
        if value.known and (value.data[:, 0] > value.data[:, 1]).any():
            self._sink.report("SC107", "the minimum height is above the maximum", origin.child("height"))
        return value

    def _with_neighbour(self, made: Placement, place: Any, fields: FieldLowerer, origin: Origin) -> Placement:
        where = origin.child("next_to", "of")
        mount = self._mount(place.next_to.of, made.name, fields, where)
        if mount is None:
            return made
        if not any(self._shapes(mount)):
            message = f"nothing can be placed next to `{mount}`: it has no collision shape"
            self._sink.report("SC359", message, where, hint=_COLLISIONS_HINT)
        elif any(isinstance(shape.geometry, Plane) for shape in self._shapes(mount)):
            message = f"nothing can be placed next to `{mount}`: it has a plane, which has no end"
            self._sink.report("SC359", message, where, hint="`region` or `at` says where on a plane")
        next_to = NextTo(mount, place.next_to.side, place.next_to.gap, place.align or "center")
        return replace(made, next_to=next_to)

    def _with_region(self, made: Placement, region: Any, fields: FieldLowerer, owner: Origin) -> Placement:
        at: tuple[str, ...] = ("place", "region")
        if isinstance(region, str):
            frame = self._names.full_name(region, self._names.scopes.get(made.name, ""))
            node = self._scene.frames.get(frame)
            if node is None or node.region is None:
                known = [name for name, one in self._scene.frames.items() if one.region is not None]
                hint = suggest_name(region, known, self._sink) or "give a frame the key `region`"
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
                message = "only one corner has a height"
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

    def _with_axes(self, made: Placement, place: Any, fields: FieldLowerer, owner: Origin) -> Placement:
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

    def _with_rotation(
        self, made: Placement, place: Any, turn: str | None, fields: FieldLowerer, owner: Origin
    ) -> Placement:
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

    def _order(self, made: dict[str, Placement]) -> tuple[Placement, ...]:
        """Sorts placements: build-time ones first, then the others, each after those that it depends on."""
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
                    message = f"`{cut(name)}` cannot move after it is built, but a reset moves `{entity}`"
                    self._sink.report("SC351", message, place, hint="give one of them another `body_type`")
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
                    message = f"circular placements: {shown}"
                    self._sink.report("SC350", message, reads[other][members[1]], hint="give one of them a `pose`")
                    found = True
                elif other not in clear:
                    chain.append(other)
                    todo.append(iter(reads[other]))
        return found

    def _carriers(self, one: Placement, made: Mapping[str, Placement], owner: Mapping[str, str]) -> tuple[Mount, ...]:
        """The bodies that support or contain a target, or that it is relative to."""
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


def _given_key(place: Any, keys: tuple[str, ...]) -> Any:
    """The first of some keys that is given."""
    return next((key for key in keys if getattr(place, key) is not None), None)


def _place_of(one: Placement) -> Origin:
    assert one.origin is not None
    return one.origin


def _read_entities(one: Placement) -> Iterator[tuple[str, Origin]]:
    """The entities that a placement depends on, and the origin of each reference."""
    origin = _place_of(one)
    yield one.target.entity, origin.child(one.kind)
    if one.facing is not None:
        yield one.facing.entity, origin.child("facing")
    for near in one.near:
        yield near.entity, origin.child("near")
    if one.next_to is not None:
        yield one.next_to.mount.entity, origin.child("next_to", "of")


def place_as_built(plan: ScenePlan, sampling: SamplingContext, frames: FrameGraph, sink: Sink) -> None:
    """Computes the poses of all placements of a plan, for the values that depend on them.

    Args:
        plan: whose placements have their recipes.
        sampling: of the document; receives the poses.
        frames: poses of the document.
        sink: receives failed placements.
    """
    scenes = np.arange(plan.num_scenes)
    batch = Batch(scenes, sampling.seed, plan.num_scenes, sampling.draws, {}, sampling.computed)
    placement = plan.placements[0]
    origin = placement.origin or Origin(None)
    try:
        standing: dict[str, Floats] = {}
        local: dict[str, Floats] = {}
        for entity in plan.entities:
            (local if frames.placed_root(entity.name) else standing)[entity.name] = _pose(entity, frames, batch)
        still = {one.name for one in plan.placements if all(map(frames.is_fixed, one.entities))}
        redrawn = {one.name for one in plan.entities if not one.pose.known and not frames.is_fixed(one.name)}
        placer = Placer(plan, batch, standing, local, still, redrawn)
        for placement in plan.placements:
            origin = placement.origin or origin
            place_next(placer, placement)
            # The next placement needs the poses of everything relative to this one.
            sampling.placed.update(batch.placed)
        overlap = placer.drawn_overlap()
        if overlap is not None:
            sink.report("SC356", overlap, origin)
    except PlacingError as error:
        first = error.scenes[0]
        message = f"in scene {first}: {error.message}"
        if len(error.scenes) > 1:
            message += f", nor in {len(error.scenes) - 1} other scenes"
        message += f"; {error.why}" if error.why else ""
        hint = distance_beyond_target(placement, plan)
        beside = "use a smaller `gap`, another `side` or a larger target"
        region = "make the region larger, `apart` or the bodies smaller, or place fewer"
        region += "" if placement.kind == "above" else "; place a heap `above`, from where it falls"
        hint = hint or (region if placement.next_to is None else beside)
        sink.report("SC354", message, origin, hint=hint)
        if sampling.record is not None:
            sampling.record.failures.append(DrawFailure(tuple(error.scenes)))
    except UnsupportedShapeError as error:
        sink.report("SC357", f"nothing can be placed beside {error}", origin)
    except AssetError as error:
        error.report(sink, origin)
    except ComputeLimitError as error:
        sink.report("SC604", error.message, origin, hint=COMPUTE_LIMIT_HINT)
    except DrawError as error:
        sink.report("SC515", f"in scene {error.scene}: {error.message}", origin)


def _pose(entity: Entity, frames: FrameGraph, batch: Batch) -> Floats:
    """The pose of an entity in all scenes, (N, 7): in the world, or relative to its placed ancestor."""
    rows, there = rows_in(entity.scene_idxs, batch.scenes)
    root = frames.placed_root(entity.name)
    if root is None:
        return np.asarray(rows_of(entity.pose, rows), np.float64)
    found = np.tile(np.array(IDENTITY_POSE), (len(rows), 1))
    world: Any = frames.frame_pose(entity.name).world
    if world.__class__ in NODES:
        part = Batch(batch.scenes[there], batch.seed, batch.num_scenes, batch.draws, batch.given, batch.work)
        part.placed = {root: np.tile(np.array(IDENTITY_POSE), (batch.num_scenes, 1))}
        found[there] = part.evaluate(world)
    return found
