"""Lowers constraints: the connected bodies, the frames, and the type."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY
from scenecc.lower.articulations.links import find_target_beyond_limits
from scenecc.lower.field_types import FieldType, field_type, report_unused_key, vector
from scenecc.lower.fields import fields_of
from scenecc.lower.forms import VariationLowerer, field_place
from scenecc.lower.link_frames import moved_along_x
from scenecc.lower.local_poses import axis_rotation, chain_poses, local_pose, rotated_frame
from scenecc.lower.poses import POSE, check_limits_keys, lower_limits, warn_limits_in_degrees
from scenecc.plan import (
    ArticulationStructure,
    AxisDrive,
    AxisLimit,
    Connection,
    Constraint,
    Distance,
    Drive,
    Gear,
    Value,
    Weld,
    literal,
)
from scenecc.plan.body import Mount
from scenecc.plan.constraint import WELD_SWING, ConstraintJoint, DriveAxis, LimitAxis
from scenecc.plan.link_poses import PoseStep, steps_to_link
from scenecc.plan.properties import FLOAT32_MAX
from scenecc.spec.constraint import (
    DRIVE_AXES,
    LIMIT_AXES,
    AxisKeys,
    BallConstraint,
    ConnectionConstraint,
    DistanceConstraint,
    DriveConstraint,
    GearConstraint,
    HingeConstraint,
    SliderConstraint,
    WeldConstraint,
)
from scenecc.spec.references import WORLD, NameScopes, qualified_name
from scenecc.variation.nodes import NODE_TYPES, AffineClamp, Stacked

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.entities import EntityLowerer
    from scenecc.lower.fields import FieldLowerer
    from scenecc.lower.mounts import MountLookup
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan import Entity
    from scenecc.robots.description import DescribedConstraint

_DISTANCES = field_type("Distance.limits")
_LIMITS = field_type("AxisLimit.limits")
_RATIO = field_type("Gear.ratio", fallback=1.0)
_STIFFNESS, _DAMPING, _FORCE = (field_type(f"AxisDrive.{key}") for key in ("stiffness", "damping", "force_limit"))
_VELOCITY = vector(3)
_SPRING = field_type("AxisLimit.stiffness")
"""Type of a limit's spring constant, which is fixed after the build."""
_SCALES = field_type("Drive.inv_mass_scales")
_NUMBER = FieldType()
_ENABLED = field_type("Constraint.enabled", fallback=True)


def lower_constraint_joint(written: Any, fields: FieldLowerer, origin: Origin) -> ConstraintJoint:
    """Lowers the type-specific part of a constraint.

    Args:
        written: the constraint.
        fields: of the constraint.
        origin: of the constraint.
    """
    match written:
        case WeldConstraint() | ConnectionConstraint():
            return Weld() if isinstance(written, WeldConstraint) else Connection()
        case DistanceConstraint():
            return Distance(
                limits=fields.value(written.limits, _DISTANCES, origin, "limits"),
                stiffness=fields.optional(written.stiffness, _SPRING, origin, "stiffness"),
                damping=fields.optional(written.damping, _SPRING, origin, "damping"),
            )
        case GearConstraint():
            ratio = fields.value(written.ratio, _RATIO, origin, "ratio")
            return Gear(ratio, enable_hinges=bool(written.enable_hinges))
        case HingeConstraint() | SliderConstraint():
            return _one_axis(written, fields, origin)
        case BallConstraint():
            return _ball(written, fields, origin)
        case _:
            return _drive(written, fields, origin)


def _one_axis(written: HingeConstraint | SliderConstraint, fields: FieldLowerer, origin: Origin) -> Drive:
    """A drive that only moves about or along x, and holds the other axes like a weld.

    The swing of a hinge with a spring is separate: a target may turn any angle, also when it is set in the engine.
    """
    zero = literal((0.0, 0.0))
    if isinstance(written, HingeConstraint):
        axis, limits = "twist", _angle_limits(written, fields, origin)
    else:
        axis, limits = "x", fields.optional(written.limits, _LIMITS, origin, "limits")
    each: dict[LimitAxis, Value | None] = {other: limits if other == axis else zero for other in LIMIT_AXES}
    drives = [AxisDrive("swing", *map(literal, WELD_SWING), mode="acceleration")]
    target, linear, angular = None, None, None
    if written.drive is not None:
        drives = [_axis_drive(axis, written.drive, ("drive",), fields, origin), *drives]
        _warn_of_target(written.drive.target, limits, fields, origin.child("drive", "target"))
        target = _motor(written.drive, "target", axis, fields, origin)
        velocity = _motor(written.drive, "velocity_target", axis, fields, origin)
        linear, angular = (velocity, None) if axis == "x" else (None, velocity)
    return Drive(
        limits=tuple(AxisLimit(axis, one) for axis, one in each.items() if one is not None),
        drives=tuple(drives),
        target=target,
        linear_velocity_target=linear,
        angular_velocity_target=angular,
        separate_swing=axis == "twist" and written.drive is not None and written.drive.stiffness is not None,
    )


def _angle_limits(written: HingeConstraint | BallConstraint, fields: FieldLowerer, origin: Origin) -> Value | None:
    check_limits_keys(written, "revolute", origin, fields.sink)
    warn_limits_in_degrees(written, "revolute", origin, fields.sink)
    return lower_limits(written, origin, fields)


def _ball(written: BallConstraint, fields: FieldLowerer, origin: Origin) -> Drive:
    """A drive with locked translations.

    SAPIEN's connection is a distance of 0, which PhysX corrects along the line between the origins. Close to 0 the
    direction of that line is noise, so a chain of connections gains energy.
    """
    zero = literal((0.0, 0.0))
    limits = _angle_limits(written, fields, origin)
    each: dict[LimitAxis, Value | None] = {"x": zero, "y": zero, "z": zero, "twist": limits}
    drives = () if written.drive is None else (_axis_drive("slerp", written.drive, ("drive",), fields, origin),)
    return Drive(limits=tuple(AxisLimit(axis, one) for axis, one in each.items() if one is not None), drives=drives)


def _warn_of_target(target: Any, limits: Value | None, fields: FieldLowerer, origin: Origin) -> None:
    """Warns of a target beyond the limits, as for articulation joints (SC523)."""
    if target is None or limits is None:
        return
    place = field_place(origin)
    variation = VariationLowerer(fields, place.origin)
    value = fields.finish(variation.item(target, _NUMBER, place), variation, _NUMBER, place.origin, reset=True)
    found = find_target_beyond_limits(limits, value)
    if found is not None:
        (_, at, low, high), certain = found
        pulls = "pulls" if certain else "may pull"
        message = f"the drive {pulls} to {at:g}, beyond the limits [{low:g}, {high:g}]"
        fields.sink.report("SC523", message, origin, hint="positions are radians, or metres for a slider")


def _motor(written: Any, key: str, axis: DriveAxis, fields: FieldLowerer, origin: Origin) -> Value | None:
    """The target (·, 7) or the velocity (·, 3) of a one-axis drive; None: SAPIEN's default."""
    given = getattr(written, key)
    if given is None:
        return None
    strength = "stiffness" if key == "target" else "damping"
    if getattr(written, strength) is None:
        message = f"`{key}` does nothing without `{strength}`"
        fields.sink.report("SC115", message, origin.child("drive", key), at="key", hint=f"write `{strength}` beside it")
    place = field_place(origin.child("drive", key))
    variation = VariationLowerer(fields, place.origin)
    item = variation.item(given, _NUMBER, place)
    if key == "target":
        return fields.finish(moved_along_x(item, slides=axis == "x"), variation, POSE, place.origin, reset=True)
    if axis == "twist":
        # PhysX applies a twist velocity target with the opposite sign.
        item = AffineClamp(item, -1, -FLOAT32_MAX, FLOAT32_MAX, -1.0) if item.__class__ in NODE_TYPES else -item
    whole = Stacked((item, 0.0, 0.0)) if item.__class__ in NODE_TYPES else (item, 0.0, 0.0)
    return fields.finish(whole, variation, _VELOCITY, place.origin, reset=True)


def _drive(written: DriveConstraint, fields: FieldLowerer, origin: Origin) -> Drive:
    target = None
    if written.target is not None:
        target = local_pose(written.target, origin, ("target",), "the target of a drive", fields, reset=True)
    velocity: Any = written.velocity_target
    linear, angular = (
        None
        if velocity is None
        else fields.optional(getattr(velocity, key), _VELOCITY, origin, "velocity_target", key, reset=True)
        for key in ("linear", "angular")
    )
    return Drive(
        limits=_axis_limits(written, fields, origin),
        drives=_axis_drives(written, fields, origin),
        target=target,
        linear_velocity_target=linear,
        angular_velocity_target=angular,
        inv_mass_scales=fields.optional(written.inv_mass_scales, _SCALES, origin, "inv_mass_scales"),
        inv_inertia_scales=fields.optional(written.inv_inertia_scales, _SCALES, origin, "inv_inertia_scales"),
    )


def _axis_limits(written: DriveConstraint, fields: FieldLowerer, origin: Origin) -> tuple[AxisLimit, ...]:
    found: list[AxisLimit] = []
    for axis in LIMIT_AXES:
        limits = None if written.limits is None else getattr(written.limits, axis)
        spring: Any = None if written.limit_springs is None else getattr(written.limit_springs, axis)
        if limits is None:
            if spring is not None:
                message = f"the limit spring of `{axis}` has no effect: the axis has no limits"
                place = origin.child("limit_springs", axis)
                fields.sink.report("SC115", message, place, at="key", hint=f"write `{axis}` under `limits` too")
            continue
        stiffness, damping = None, None
        if spring is not None:
            at = ("limit_springs", axis)
            stiffness = fields.optional(spring.stiffness, _SPRING, origin, *at, "stiffness")
            damping = fields.optional(spring.damping, _SPRING, origin, *at, "damping")
        found.append(AxisLimit(axis, fields.value(limits, _LIMITS, origin, "limits", axis), stiffness, damping))
    return tuple(found)


def _axis_drives(written: DriveConstraint, fields: FieldLowerer, origin: Origin) -> tuple[AxisDrive, ...]:
    found: list[AxisDrive] = []
    for axis in DRIVE_AXES:
        drive: Any = None if written.drive is None else getattr(written.drive, axis)
        if drive is None:
            continue
        found.append(_axis_drive(axis, drive, ("drive", axis), fields, origin))
    return tuple(found)


def _axis_drive(axis: DriveAxis, drive: Any, at: tuple[str, ...], fields: FieldLowerer, origin: Origin) -> AxisDrive:
    stiffness = fields.optional(drive.stiffness, _STIFFNESS, origin, *at, "stiffness")
    damping = fields.optional(drive.damping, _DAMPING, origin, *at, "damping")
    force_limit = fields.optional(drive.force_limit, _FORCE, origin, *at, "force_limit")
    return AxisDrive(axis, _or_zero(stiffness), _or_zero(damping), force_limit, drive.mode)


def _or_zero(value: Value | None) -> Value:
    return literal(0.0) if value is None else value


_FRAME = "the frame of a constraint"


class ConstraintLowerer:
    """Lowers the constraints of a document.

    Args:
        built: its lowered entities.
        entities: has lowered them.
        mounts: finds the connected bodies.
        sampling: of the document.
        names: of the document.
        sink: receives the diagnostics.
    """

    def __init__(
        self,
        built: tuple[Entity, ...],
        entities: EntityLowerer,
        mounts: MountLookup,
        sampling: SamplingContext,
        names: NameScopes,
        sink: Sink,
    ) -> None:
        self._built = {entity.name: entity for entity in built}
        self._entities = entities
        self._mounts = mounts
        self._sampling = sampling
        self._names = names
        self._sink = sink

    def lower(self, written: Mapping[str, Any], origin: Origin) -> tuple[Constraint, ...]:
        """The constraints of the plan, without those with errors. `origin`: of `constraints`."""
        found = [self._constraint(name, one, origin.child(name)) for name, one in written.items()]
        made = tuple(one for one in found if one is not None)
        self._report_unused_collide(made)
        if self._sampling.resets and not self._sink.failed:
            from scenecc.lower.resets import check_constraint_resets  # noqa: PLC0415 - loaded where something varies

            left_out = tuple(one for one in made if written[one.name].pose_in_parent is None)
            check_constraint_resets(left_out, self._sampling, self._entities.frames)
        return made

    def _report_unused_collide(self, made: Sequence[Constraint]) -> None:
        """Reports `collide` of constraints whose bodies another one keeps apart in all of their scenes."""
        for one in made:
            if not one.collide or one.parent is None or one.origin is None:
                continue
            apart = [each for each in made if not each.collide and {each.child, each.parent} == {one.child, one.parent}]
            if apart and {*one.scene_idxs} <= {index for each in apart for index in each.scene_idxs}:
                where = f"beside `{cut(apart[0].name)}`, which connects the same bodies without it"
                report_unused_key("collide", where, one.origin, self._sink, hint="write `collide: true` there too")

    def describe(self) -> tuple[Constraint, ...]:
        """Makes the constraints from robot files."""
        return tuple(self._lower_constraint(name, *found) for name, found in self._entities.constraints.items())

    def _lower_constraint(
        self, name: str, constraint: DescribedConstraint, entities: Mapping[str, str], place: Origin
    ) -> Constraint:
        ends = [
            (self._built[entities[root]], link, pose)
            for (root, link), pose in (
                (constraint.parent, constraint.pose_in_parent),
                (constraint.child, constraint.pose_in_child),
            )
        ]
        if ends[1][0].structures[0].bodies[0].body_type == "static":
            ends.reverse()
        parent, child = (
            Mount(entity.name, link if isinstance(entity.structures[0], ArticulationStructure) else None)
            for entity, link, _ in ends
        )
        return Constraint(
            name=name,
            scene_idxs=_common_scenes(ends[0][0].scene_idxs, ends[1][0].scene_idxs),
            joint=Weld() if constraint.type == "weld" else Connection(),
            child=child,
            parent=parent,
            pose_in_parent=literal(ends[0][2]),
            pose_in_child=literal(ends[1][2]),
            origin=place.into(constraint.location),
        )

    def _constraint(self, name: str, written: Any, origin: Origin) -> Constraint | None:
        scope = self._names.scopes.get(qualified_name("constraints", name), "")
        child = self._mount("child", written.child, scope, origin)
        parent = self._mount("parent", written.parent, scope, origin)
        if child is None or (parent is None and written.parent != WORLD):
            return None
        scenes = self._scenes(name, (child, parent), scope, origin)
        if not scenes:
            return None
        for key, mount in (("child", child), ("parent", parent)):
            if mount is not None:
                self._mounts.find(getattr(written, key), scope, scenes, origin.child(key))
        if parent is None and written.collide is not None:
            report_unused_key(
                "collide", "with `parent: world`, with which nothing stops collisions", origin, self._sink
            )
        fields = fields_of(self._sampling, scenes, scope)
        in_child = None
        if written.pose_in_child is not None:
            in_child = local_pose(written.pose_in_child, origin, ("pose_in_child",), _FRAME, fields)
        rotation = axis_rotation(written.axis, origin, fields) if isinstance(written, AxisKeys) else IDENTITY
        in_child = rotated_frame(in_child, rotation, fields)
        in_parent = self._pose_in_parent(written, (child, parent), in_child, fields, origin)
        if written.pose_in_parent is not None:
            in_parent = rotated_frame(in_parent, rotation, fields)
        return Constraint(
            name=name,
            scene_idxs=scenes,
            joint=lower_constraint_joint(written, fields, origin),
            child=child,
            parent=parent,
            pose_in_parent=in_parent,
            pose_in_child=in_child,
            enabled=fields.optional(written.enabled, _ENABLED, origin, "enabled"),
            collide=bool(written.collide),
            origin=origin,
        )

    def _mount(self, key: str, written: str, scope: str, origin: Origin) -> Mount | None:
        if written != WORLD:
            return self._mounts.find(written, scope, (), origin.child(key))
        if key == "child":
            message = "the world cannot be the child of a constraint: the child must be able to move"
            hint = "write `parent: world`, and the fastened body as `child`"
            self._sink.report("SC340", message, origin.child(key), hint=hint)
        return None

    def _scenes(
        self, name: str, mounts: tuple[Mount | None, ...], scope: str, origin: Origin
    ) -> tuple[int, ...] | None:
        """The scenes of a constraint: as selected, or else those of its bodies."""
        selections = self._entities.selections
        selected = selections.get(qualified_name("constraints", name))
        if selected is not None and selected is not selections.get(self._names.anchors.get(scope, "")):
            return selected
        scenes = self._sampling.all_scenes
        for mount in mounts:
            others = None if mount is None else self._built[mount.entity].scene_idxs
            if others is not None and others is not scenes:
                scenes = others if scenes is self._sampling.all_scenes else _common_scenes(scenes, others)
        if not scenes:
            message = f"`{cut(name)}` connects bodies that are never in the same scene"
            self._sink.report("SC341", message, origin, at="key")
        return scenes

    def _pose_in_parent(
        self,
        written: Any,
        mounts: tuple[Mount, Mount | None],
        in_child: Value | None,
        fields: FieldLowerer,
        origin: Origin,
    ) -> Value | None:
        """The constraint frame in the parent's frame: as written, or the child's frame at the start."""
        child, parent = mounts
        scenes = fields.scenes
        if written.pose_in_parent is not None:
            value = local_pose(written.pose_in_parent, origin, ("pose_in_parent",), _FRAME, fields)
            scope = self._names.worlds.get(qualified_name("constraints", str(origin.path[-1])), fields.scope)
            anchor = self._names.anchors.get(scope) if parent is None else None
            if anchor is None:
                return value
            # A prefab's world is the frame of its instance.
            around = self._entities.frames.world(anchor, origin, fixed=True)
            return chain_poses(
                [PoseStep(around, self._entities.fields(anchor).scenes), PoseStep(value, scenes)], scenes
            )
        steps = self._to(child, "child", origin)
        outer = [] if parent is None else self._to(parent, "parent", origin)
        if steps is None or outer is None:
            return None
        back = [PoseStep(step.value, step.scenes, step.kind, not step.back) for step in reversed(outer)]
        last = [] if in_child is None else [PoseStep(in_child, scenes)]
        return chain_poses([*back, *steps, *last], scenes)

    def _to(self, mount: Mount, key: str, origin: Origin) -> list[PoseStep] | None:
        """The steps from the world to a body at the start; None if they are not unique, which is an error."""
        entity = self._built[mount.entity]
        steps = [PoseStep(entity.pose, entity.scene_idxs)]
        if mount.link is None:
            return steps
        first, *others = entity.structures
        if isinstance(first, ArticulationStructure) and mount.link != first.links[0].name:
            if others:
                message = f"where `{cut(mount.link)}` starts differs between the structures of `{cut(mount.entity)}`"
                self._sink.report("SC342", message, origin.child(key), hint="write `pose_in_parent`")
                return None
            steps += steps_to_link(first, mount.link, entity.scene_idxs)
        return steps


def _common_scenes(a: tuple[int, ...], b: tuple[int, ...]) -> tuple[int, ...]:
    others = frozenset(b)
    return tuple(scene for scene in a if scene in others)
