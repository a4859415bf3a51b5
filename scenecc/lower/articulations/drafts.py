"""Drafts of articulations before overrides, and alternatives of their structure.

The file, how it is read and whether the root is fixed may vary by scene. The combinations that can occur are found
before drawing. Each combination becomes a separate structure.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import show
from scenecc.geometry.rotations import IDENTITY, IDENTITY_POSE, shortest_from_x, turned
from scenecc.lower.field_types import FieldType, field_type, report_unused_key
from scenecc.lower.forms import VARYING, FieldPlace, FormStep, VariationLowerer, field_place
from scenecc.lower.local_poses import axis_node, local_pose, seven_numbers
from scenecc.lower.poses import POSE, check_limits_keys, direction, lower_limits, pose_item, warn_limits_in_degrees
from scenecc.lower.references import values_given
from scenecc.plan import CollisionShape, Value, VisualShape, literal, per_scene
from scenecc.plan.articulation import JointType, breadth_first_order
from scenecc.plan.properties import POSITIVE, property_fields
from scenecc.variation.bounds import MAX_ALTERNATIVES, ValueBounds
from scenecc.variation.nodes import Composed, Node, Posed, Stacked

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.shapes import ShapeDefaults, ShapeLowerer
    from scenecc.plan import Inertial
    from scenecc.spec.articulation import TreeJoint, TreeLink
    from scenecc.variation.evaluation import Batch

Layer = tuple[Any, "Origin"]
"""A model with keys, and the node that has them."""


@dataclass(frozen=True, slots=True)
class ContactDefaults:
    """Defaults of the shapes of a link.

    Attributes:
        default: surface and density.
        patch_radius, min_patch_radius: (·,) [m] or None.
        ignore: third and fourth collision integer of shapes whose file gives the first two; None: the scene gives all
            four.
    """

    default: ShapeDefaults
    patch_radius: Value | None = None
    min_patch_radius: Value | None = None
    ignore: tuple[int, int] | None = None


ShapeMaker = Callable[[ContactDefaults], "tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]"]
"""Makes the shapes of a link."""


@dataclass(frozen=True, slots=True)
class DraftMimic:
    """The joint that a joint follows. `multiplier`, `offset`: (·,)."""

    source: str
    multiplier: Value
    offset: Value
    origin: Origin


@dataclass(frozen=True, slots=True)
class DraftJoint:
    """The joint between a link and its parent, before pattern overrides and the initial state.

    Attributes:
        properties: values by field of `Joint`, without those that the file omits.
        effort: the default of the drive's `force_limit`; None: unknown.
        friction_force, friction_origin: see `friction_force` of the plan, and where it is written.
        limits_origin: origin of the limits, if they have their own.
        qpos: initial position from the file, if any.
    """

    type: JointType
    name: str
    origin: Origin
    pose_in_parent: Value | None = None
    pose_in_child: Value | None = None
    limits: Value | None = None
    limits_origin: Origin | None = None
    properties: dict[str, Any] = field(default_factory=dict[str, Any])
    effort: Value | None = None
    friction_force: Value | None = None
    friction_origin: Origin | None = None
    mimic: DraftMimic | None = None
    qpos: float | None = None

    @property
    def moves(self) -> bool:
        """Whether it has a degree of freedom."""
        return self.type != "fixed"


@dataclass(frozen=True, slots=True)
class DraftLink:
    """A link before pattern overrides.

    Attributes:
        parent: number of its parent link, which comes before it; None: it is the root.
        own: its own keys, which have precedence over patterns; None: it has none.
        inertial: mass properties from its file.
        mass, com: from a file without an inertia: the inertia of the shapes is scaled to the mass.
        ignore_bits, disable_gravity: see `DescribedLink`.
        collides: whether it has collision shapes.
        file: (·,) index of its file, in an articulation of several.
    """

    name: str
    origin: Origin
    shaping: ShapeMaker
    parent: int | None = None
    joint: DraftJoint | None = None
    own: Layer | None = None
    inertial: Inertial | None = None
    ignore_bits: int = 0
    mass: Value | None = None
    com: Value | None = None
    disable_gravity: bool = False
    collides: bool = False
    file: Value | None = None


@dataclass(frozen=True, slots=True)
class ArticulationDraft:
    """A whole articulation before pattern overrides.

    Attributes:
        links: the root first, each after its parent.
        fixed: whether the root is fixed to the world; None: not given, so the default applies.
        file: (·,) index of its file; None: it is written in the scene.
        ignored: origin of the rule that makes two links ignore one another, by bit of `ignore_bits`, if known.
        parts: attached parts, each before its own attachments.
    """

    links: tuple[DraftLink, ...]
    origin: Origin
    fixed: bool | None = None
    file: Value | None = None
    ignored: Mapping[int, Origin] = field(default_factory=dict[int, "Origin"])
    parts: tuple[AttachedPart, ...] = ()

    def moving(self) -> list[int]:
        """The links whose joints move, in SAPIEN's joint order: by depth, then in build order."""
        order = breadth_first_order(link.parent for link in self.links)
        return [number for number in order if (joint := self.links[number].joint) is not None and joint.moves]


@dataclass(frozen=True, slots=True)
class AttachedPart:
    """A part of an articulation.

    Attributes:
        keys, origin: the part as written, and its node.
        draft: the part with its own names; its root has the joint to the parent link.
        prefix: of these names in the whole.
        start: number of its root in the whole; its other links follow.
    """

    keys: Any
    origin: Origin
    draft: ArticulationDraft
    prefix: str
    start: int

    def __contains__(self, link: int) -> bool:
        """Whether a link of the whole belongs to it."""
        return self.start <= link < self.start + len(self.draft.links)


_JOINT_NUMBERS = (*property_fields("joint"), "damping")
"""Keys of a joint of a tree. `damping` is of the drive that it then has."""

_MOVING_JOINT_KEYS = (*_JOINT_NUMBERS, "friction_force", "axis", "pose_in_child", "limits", "limits_deg", "mimic")

_COLLIDING_KEYS = ("density", "patch_radius", "min_patch_radius")

_NO_LIMITS = (-math.inf, math.inf)


class LinkTreeDrafter:
    """Makes drafts of link trees.

    Args:
        shapes: lowers their shapes.
        sink: receives the diagnostics.
    """

    def __init__(self, shapes: ShapeLowerer, sink: Sink) -> None:
        self._shapes = shapes
        self._sink = sink

    def draft(self, root: TreeLink, origin: Origin, fields: FieldLowerer) -> ArticulationDraft:
        """Makes a draft of a tree.

        Args:
            root: of the tree.
            origin: of the root.
            fields: of the entity.
        """
        links: list[DraftLink] = []
        waiting: list[tuple[TreeLink, Origin, int | None]] = [(root, origin, None)]
        while waiting:
            link, place, parent = waiting.pop()
            number = len(links)
            links.append(self._link(link, place, parent, fields))
            below = [(child, place.child("children", i), number) for i, child in enumerate(link.children)]
            waiting += reversed(below)
        return ArticulationDraft(tuple(links), origin)

    def _link(self, link: TreeLink, origin: Origin, parent: int | None, fields: FieldLowerer) -> DraftLink:
        joint = None
        if parent is None and link.joint is not None:
            where = "on the root, which has no parent: `fix_root_link` fixes it"
            report_unused_key("joint", where, origin, self._sink)
        elif parent is not None and link.joint is None:
            self._sink.report("SC102", f"the link `{link.name}` lacks the key `joint`", origin, at="key")
        elif link.joint is not None:
            joint = self.joint(link.joint, origin.child("joint"), fields)
        self._idle(link, origin)

        def shaping(contact: ContactDefaults) -> tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]:
            return self._lower_shapes(link, contact, origin, fields)

        collides = bool(link.shapes or link.collisions)
        return DraftLink(link.name, origin, shaping, parent, joint, own=(link, origin), collides=collides)

    def _idle(self, link: TreeLink, origin: Origin) -> None:
        """Reports keys for shapes on a link without shapes."""
        if link.shapes or link.collisions:
            return
        for key in _COLLIDING_KEYS if link.visuals else (*_COLLIDING_KEYS, "material"):
            if getattr(link, key) is not None:
                shape = "shape" if key == "material" else "collision shape"
                report_unused_key(key, f"on a link without a {shape}", origin, self._sink)

    def _lower_shapes(
        self, link: TreeLink, contact: ContactDefaults, origin: Origin, fields: FieldLowerer
    ) -> tuple[tuple[CollisionShape, ...], tuple[VisualShape, ...]]:
        collisions, visuals = self._shapes.shapes(((link, origin),), contact.default, fields)
        return tuple(_with_contact_radii(shape, contact) for shape in collisions), tuple(visuals)

    def joint(self, joint: TreeJoint, origin: Origin, fields: FieldLowerer) -> DraftJoint:
        """Makes a draft of a joint. `origin`: of the joint."""
        given = joint.model_fields_set
        if joint.type == "continuous" and (wrong := next(iter(given & {"limits", "limits_deg"}), None)):
            message = f"a continuous joint has no `{wrong}`"
            self._sink.report("SC111", message, origin.child(wrong), at="key", hint="write `type: revolute`")
        check_limits_keys(joint, joint.type, origin, self._sink)
        in_parent, in_child = self._poses(joint, origin, fields)
        name = joint.name or ""
        if joint.type == "fixed":
            for key in _MOVING_JOINT_KEYS:
                # `pose_in_child` of a fixed joint is used: it places the child.
                if key in given and key != "pose_in_child":
                    report_unused_key(key, "on a fixed joint", origin, self._sink)
            return DraftJoint("fixed", name, origin, in_parent, in_child)
        type_: JointType = "revolute" if joint.type == "continuous" else joint.type
        properties = {
            key: value
            for key in _JOINT_NUMBERS
            if (value := fields.optional(getattr(joint, key), field_type(f"Joint.{key}"), origin, key)) is not None
        }
        force = fields.optional(joint.friction_force, field_type("Joint.force_limit"), origin, "friction_force")
        mimic = None
        if joint.mimic is not None:
            place = origin.child("mimic")
            if not name:
                message = "a joint that follows another lacks the key `name`"
                self._sink.report("SC102", message, origin, hint="other joints are found by name too")
            multiplier = fields.optional(joint.mimic.multiplier, field_type("Mimic.multiplier"), place, "multiplier")
            offset = fields.optional(joint.mimic.offset, field_type("Mimic.offset"), place, "offset")
            mimic = DraftMimic(joint.mimic.joint, multiplier or literal(1.0), offset or literal(0.0), place)
        limits = lower_limits(joint, origin, fields) or literal(_NO_LIMITS)
        warn_limits_in_degrees(joint, joint.type, origin, self._sink)
        place = origin.child("limits" if joint.limits_deg is None else "limits_deg")
        return DraftJoint(
            type_,
            name,
            origin,
            in_parent,
            in_child,
            limits,
            place,
            properties,
            friction_force=force,
            friction_origin=origin.child("friction_force"),
            mimic=mimic,
        )

    def _poses(self, joint: TreeJoint, origin: Origin, fields: FieldLowerer) -> tuple[Value | None, Value | None]:
        """The joint's frame in the parent's and in the child's frame."""
        if joint.pose_in_parent is not None or joint.pose_in_child is not None:
            return (
                self._pose(joint.pose_in_parent, "pose_in_parent", origin, fields),
                self._pose(joint.pose_in_child, "pose_in_child", origin, fields),
            )
        if joint.axis.__class__ in VARYING:
            return self._lower_varying_axis(joint, origin, fields)
        frame = self._pose(joint.origin, "origin", origin, fields)
        rotation = IDENTITY
        if joint.axis is not None:
            written: Any = joint.axis
            axis = direction(written)
            if not any(axis):
                self._sink.report("SC114", "an axis of length 0 has no direction", origin.child("axis"))
                return None, None
            rotation = shortest_from_x(axis)
        if rotation == IDENTITY:
            return frame, None
        return self._with_rotation(frame, rotation, joint, origin, fields), literal((0.0, 0.0, 0.0, *rotation))

    @staticmethod
    def _pose(pose: Any, key: str, origin: Origin, fields: FieldLowerer) -> Value | None:
        return None if pose is None else local_pose(pose, origin, (key,), "a joint", fields)

    @staticmethod
    def _with_rotation(
        frame: Value | None, rotation: Any, joint: TreeJoint, origin: Origin, fields: FieldLowerer
    ) -> Value:
        if frame is None:
            return literal((0.0, 0.0, 0.0, *rotation))
        if frame.is_constant:
            return literal(turned(seven_numbers(frame), rotation))
        place = field_place(origin.child("origin"))
        variation = VariationLowerer(fields, place.origin)
        item = Composed(pose_item(joint.origin, place, variation, fields.sink), (0.0, 0.0, 0.0, *rotation))
        return fields.finish(item, variation, POSE, place.origin)

    def _lower_varying_axis(self, joint: TreeJoint, origin: Origin, fields: FieldLowerer) -> tuple[Value, Value]:
        """The joint frames for an axis that varies by scene."""
        place = field_place(origin)
        variation = VariationLowerer(fields, origin.child("axis"))
        rotation = Posed((0.0, 0.0, 0.0), axis_node(joint.axis, place.key("axis"), variation))
        in_child = fields.finish(rotation, variation, POSE, origin.child("axis"))
        frame = IDENTITY_POSE
        if joint.origin is not None:
            frame = pose_item(joint.origin, place.key("origin"), variation, fields.sink)
        return fields.finish(Composed(frame, rotation), variation, POSE, origin.child("origin")), in_child


def _with_contact_radii(shape: CollisionShape, contact: ContactDefaults) -> CollisionShape:
    """Adds the radii of the link to a shape without its own."""
    radii = {
        name: radius
        for name in ("patch_radius", "min_patch_radius")
        if (radius := getattr(contact, name)) is not None and getattr(shape, name) is None
    }
    return replace(shape, **radii) if radii else shape


_TEXT_TYPE = FieldType(convert=str, fallback="")

_KEY_TYPES = {
    "urdf": _TEXT_TYPE,
    "mjcf": _TEXT_TYPE,
    "scale": FieldType(fallback=1.0, within=POSITIVE),
    "srdf": _TEXT_TYPE,
    "package_dir": _TEXT_TYPE,
    "keyframe": _TEXT_TYPE,
    "fix_root_link": FieldType(dtype="bool", convert=bool, fallback=False),
}
"""The keys, in the order of comparison."""

_TYPE_WORDS = {"float64": "a number", "bool": "true or false"}

_INDEX_TYPE = FieldType(dtype="int64", fallback=0, free=True)  # an expression gives the index

Combination = tuple[Any, ...]
"""One value for each written key, in key order."""


WrittenKey = tuple[tuple[str, ...], str, Any, "Origin"]
"""Names of the parts that contain a key, the key, its value, and its origin."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """One way to assemble an articulation.

    Attributes:
        values: by key, without omitted keys.
        places: origins of these.
        parts: alternatives of its attached parts, by name.
    """

    values: dict[str, Any]
    places: dict[str, Origin]
    parts: dict[str, Alternative] = field(default_factory=dict[str, "Alternative"])


@dataclass(frozen=True, slots=True)
class Alternatives:
    """All alternatives, one of which each scene has.

    Attributes:
        each: one or more.
        pick: (·,) index into them; None: there is only one.
    """

    each: tuple[Alternative, ...]
    pick: Value | None = None


def read_alternatives(entity: Any, origin: Origin, fields: FieldLowerer) -> Alternatives | None:
    """The combinations of the keys that determine the structure of an articulation; None after an error.

    Values that no scene has are combined with each other, so that they are checked too.

    Args:
        entity: as written.
        origin: of the entity.
        fields: of the entity.
    """
    written = list(_list_written_keys(entity, origin, ()))
    if VARYING.isdisjoint(given.__class__ for _, _, given, _ in written):
        return Alternatives((_alternative(entity, written),))
    variation = VariationLowerer(fields, origin)
    columns = [_KeyAlternatives(path, key, given, place, variation) for path, key, given, place in written]
    fields.sampling.fix(variation)
    valid = [column.check(fields) for column in columns]
    if variation.broken or not all(valid):
        return None
    return _Combinations(entity, columns, variation, fields).all()


def _list_written_keys(keys: Any, origin: Origin, path: tuple[str, ...]) -> Iterator[WrittenKey]:
    """The written keys of an articulation and its parts that determine the structure."""
    for key in _KEY_TYPES:
        # A part is always attached, so its root is not configurable.
        if (given := getattr(keys, key, None)) is not None and not (path and key == "fix_root_link"):
            yield path, key, given, origin.child(key)
    for name, part in keys.attach.items():
        yield from _list_written_keys(part, origin.child("attach", name), (*path, name))


def _alternative(keys: Any, rows: Sequence[WrittenKey]) -> Alternative:
    """Makes an alternative of an articulation and its parts from the values of all keys."""
    own = [row for row in rows if not row[0]]
    return Alternative(
        {key: value for _, key, value, _ in own},
        {key: place for _, key, _, place in own},
        {
            name: _alternative(part, [(row[0][1:], row[1], row[2], row[3]) for row in rows if row[0][:1] == (name,)])
            for name, part in keys.attach.items()
        },
    )


class _KeyAlternatives:
    """The alternatives of one key.

    Attributes:
        path: names of the parts that contain it.
        node: its value in each scene: a node, or a plain value.
        places: origins of its possible values, in the same order.
    """

    def __init__(
        self, path: tuple[str, ...], key: str, given: Any, origin: Origin, variation: VariationLowerer
    ) -> None:
        self.path = path
        self.key = key
        self.origin = origin
        self.varies = given.__class__ in VARYING
        self.places: dict[Any, Origin] = {}
        self._kind = _KEY_TYPES[key]
        self._variation = variation
        self._sources: list[tuple[Node, Origin]] = []

        def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
            inside = around.inside(step) if step else around
            if one.__class__ not in VARYING:
                self.places.setdefault(self.value(one), inside.origin)
                return one
            node = variation.item(one, self._kind, inside)
            if not variation.broken:
                self._sources.append((node, inside.origin))
            return node

        self.node = variation.select(given, field_place(origin), leaf)

    def value(self, given: Any) -> Any:
        """The value of a scene in comparable form; None if it has the wrong type."""
        if self._kind is _TEXT_TYPE:
            return given if given.__class__ is str else None
        if self._kind.dtype == "bool":
            return given if given.__class__ is bool else None
        return float(given) if given.__class__ in {int, float} else None

    def check(self, fields: FieldLowerer) -> bool:
        """Checks each value of the key in the scenes and in the samples, and reports invalid ones."""
        for node, place in self._sources:
            found = values_given(node, place, fields, is_random=self._variation.is_random, within=self.node)
            if found is None:
                return False
            if self._kind is not _TEXT_TYPE and len(found) > MAX_ALTERNATIVES:
                hint = "each value is a structure of its own: write them in a `choice`"
                fields.sink.report("SC317", f"this gives more than {MAX_ALTERNATIVES} values", place, hint=hint)
                return False
            for given in found:
                value = self.value(given)
                if value is None or not (self._kind.within is None or self._kind.bounds.allow(value)):
                    self._misfit(given, value, place, fields)
                    return False
                self.places.setdefault(value, place)
        return True

    def _misfit(self, given: Any, value: Any, place: Origin, fields: FieldLowerer) -> None:
        if value is not None:
            message = f"this expression gives {show(given)}, but it must be {self._kind.bounds.requirement(value)}"
            fields.sink.report("SC513", message, place)
            return
        wanted = "a name" if self._kind is _TEXT_TYPE else _TYPE_WORDS[self._kind.dtype]
        code = "SC317" if self._kind is _TEXT_TYPE else "SC515"
        fields.sink.report(code, f"this expression gives {show(given)}, but {wanted} is needed", place)


class _Combinations:
    """The keys of one articulation, some of which vary."""

    def __init__(
        self, entity: Any, columns: list[_KeyAlternatives], variation: VariationLowerer, fields: FieldLowerer
    ) -> None:
        self._entity = entity
        self._columns = columns
        self._variation = variation
        self._fields = fields
        self._node = Stacked(tuple(column.node for column in columns))

    def all(self) -> Alternatives | None:
        """All combinations, in written order of their values; None after an error."""
        found = values_given(self._node, self._first(), self._fields, is_random=self._variation.is_random)
        if found is None:
            return None
        had = [self._combination(row) for row in found]
        order = [{value: i for i, value in enumerate(column.places)} for column in self._columns]
        every = sorted(
            {*had, *self._find_unused(had)}, key=lambda row: [at[one] for at, one in zip(order, row, strict=True)]
        )
        numbers = {row: i for i, row in enumerate(every)}
        each = tuple(self._alternative(row) for row in every)
        variation, fields = self._variation, self._fields

        def rows(batch: Batch) -> NDArray[Any]:
            import numpy as np  # noqa: PLC0415 - loaded where something varies

            found = batch.evaluate(self._node).tolist()
            return np.array([numbers[self._combination(row)] for row in found], dtype=np.int64)

        if len(each) == 1 and not (variation.is_random and variation.risky):
            return Alternatives(each)
        if not variation.is_random:
            known = per_scene(rows(fields.batch()), "int64")
            if not variation.cycled or len(set(known.numbers())) == len(each):
                return Alternatives(each, known)
        found = range(len(each)) if variation.cycled else sorted({numbers[row] for row in had})
        pick = fields.make_drawn(rows, lambda: ValueBounds.of(found, exact=not variation.computed))
        if variation.is_random and variation.risky:
            pick = fields.check_value(pick, self._node, _INDEX_TYPE, self._first())
        return Alternatives(each, pick) if len(each) > 1 else Alternatives(each)

    def _alternative(self, row: Combination) -> Alternative:
        pairs = zip(self._columns, row, strict=True)
        return _alternative(
            self._entity, [(column.path, column.key, value, column.places[value]) for column, value in pairs]
        )

    def _combination(self, row: Sequence[Any]) -> Combination:
        return tuple(column.value(given) for column, given in zip(self._columns, row, strict=True))

    def _find_unused(self, had: list[Combination]) -> list[Combination]:
        """Combinations of values that no scene can have: the first of each key together, and so on."""
        missing = [
            [value for value in column.places if value not in used]
            for column, used in zip(self._columns, map(set, zip(*had, strict=True)), strict=True)
        ]
        return [
            tuple(one if value is None else value for one, value in zip(had[0], row, strict=True))
            for row in zip_longest(*missing)
        ]

    def _first(self) -> Origin:
        """Origin of the first key that varies."""
        return next(column.origin for column in self._columns if column.varies)
