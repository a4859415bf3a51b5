"""Lowers links and joints of drafts, with their overrides."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut
from scenecc.lower.articulations.drafts import ContactDefaults, DraftJoint, DraftLink, Layer
from scenecc.lower.articulations.overrides import OverrideValues, nearest_override
from scenecc.lower.collision_groups import DEFAULT_BITS, GroupBits, find_group
from scenecc.lower.field_types import BODY_FIELDS, field_type, report_unused_key
from scenecc.lower.local_poses import lower_inertial
from scenecc.lower.materials import DENSITY, PLAIN_SURFACE
from scenecc.lower.poses import check_limits_keys, warn_limits_in_degrees
from scenecc.lower.shapes import ShapeDefaults
from scenecc.lower.variation import ResettableValue
from scenecc.plan import BodyStructure, Inertial, Value, derived, literal
from scenecc.plan.articulation import BRAKE_DAMPING, NON_LINK_FIELDS, Joint, unbuilt_resistance
from scenecc.plan.properties import FLOAT32_MAX, JOINT_PROPERTIES, properties_of, property_fields
from scenecc.variation.nodes import AffineClamp, Stacked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer

_LINK_KEYS = tuple(row.key for row in properties_of("body") if row.field not in NON_LINK_FIELDS)
"""Keys that a link shares with other bodies."""
_MASS_TYPE = BODY_FIELDS["mass"][1]
_RADIUS_TYPE = field_type("CollisionShape.patch_radius")


class LinkLowerer:
    """Makes the bodies of links.

    Args:
        groups: the bits of the collision groups of the document.
        sink: receives the diagnostics.
    """

    def __init__(self, groups: dict[str, GroupBits], sink: Sink) -> None:
        self._groups = groups
        self._sink = sink

    def body(
        self, link: DraftLink, layers: Sequence[Layer], own: int, ignored: int, values: OverrideValues
    ) -> BodyStructure:
        """Makes the body of a link.

        Args:
            link: its draft.
            layers: keys of the articulation, overrides by patterns, and the link's own keys.
            own: the id of the articulation among those with ignored pairs.
            ignored: bits of the third collision integer that are always set.
            values: of the articulation.
        """
        groups = nearest_override(layers, "collision_bits", "collision_group")
        third = link.ignore_bits | ignored
        contact = ContactDefaults(
            ShapeDefaults(values.surface(layers) or PLAIN_SURFACE, None, values.value(layers, "density", DENSITY)),
            values.value(layers, "patch_radius", _RADIUS_TYPE),
            values.value(layers, "min_patch_radius", _RADIUS_TYPE),
            (third, own if third else 0) if groups is None else None,
        )
        collisions, visuals = link.shaping(contact)
        properties: dict[str, Any] = {}
        for key in _LINK_KEYS:
            field, kind = BODY_FIELDS[key]
            found = values.value(layers, key, kind)
            if found is not None:
                properties[field] = found
        if link.disable_gravity:
            properties.setdefault("disable_gravity", literal(True, "bool"))  # noqa: FBT003 - the value itself
        # A link's own key without effect is kept, for a rule to report.
        looks = nearest_override(layers, "visibility")
        if looks is not None and (visuals or looks is link.own):
            properties["visibility"] = values.of(looks, "visibility", BODY_FIELDS["visibility"][1])
        bits = self._bits(groups, third, own, values)
        without = any(shape.collision_groups is None for shape in collisions)
        if bits is not None and (without or (groups is not None and groups is link.own)):
            properties["collision_groups"] = bits
        mass, inertial = self._weight(link, layers, values, dense=bool(collisions))
        center = nearest_override(layers, "com", "inertial")
        com = link.com if center is None else None
        if center is not None and center[0].com is not None:
            com = values.of(center, "com", BODY_FIELDS["com"][1])
            if not collisions and inertial is None:
                where = f"on `{cut(link.name)}`, which has no collision shape and no inertia"
                report_unused_key("com", where, center[1], self._sink)
        return BodyStructure(
            body_type="link",
            collisions=collisions,
            visuals=visuals,
            mass=mass,
            com=com,
            inertial=inertial,
            origin=link.origin,
            **properties,
        )

    def _bits(self, layer: Layer | None, third: int, own: int, values: OverrideValues) -> Value | None:
        """The four collision integers; None if they are SAPIEN's defaults."""
        bits: GroupBits = DEFAULT_BITS
        if layer is not None:
            keys, origin = layer
            group, written = keys.collision_group, getattr(keys, "collision_bits", None)
            if written is not None:
                return values.of(layer, "collision_bits", BODY_FIELDS["collision_bits"][1])
            found = find_group(
                self._groups, str(group), origin.child("collision_group"), values.fields.scope, self._sink
            )
            bits = found or DEFAULT_BITS
        third |= bits[2]
        bits = (bits[0], bits[1], third, own if third else bits[3])
        return None if layer is None and bits == DEFAULT_BITS else literal(bits, "int64")

    def _weight(
        self, link: DraftLink, layers: Sequence[Layer], values: OverrideValues, *, dense: bool
    ) -> tuple[Value | None, Inertial | None]:
        """The mass that scales the computed properties, and the given mass properties. `dense`: shapes have mass."""
        nearest = nearest_override(layers, "mass", "inertial")
        if nearest is None:
            return link.mass, link.inertial
        keys = nearest[0]
        if keys.inertial is not None:
            given = lower_inertial(keys.inertial, nearest[1], values.fields)
            if nearest is not link.own:
                self._report_impossible_inertia(given, link, nearest)
            return None, given
        mass = values.of(nearest, "mass", _MASS_TYPE)
        if not dense and link.inertial is None:
            message = f"`{cut(link.name)}` has no collision shape and no inertia, so `mass` has nothing to scale"
            hint = "give it `shapes` or `collisions`, or `inertial` instead of `mass`"
            self._sink.report("SC510", message, nearest[1].child("mass"), hint=hint)
        return (mass, None) if link.inertial is None else (None, _scale_inertial(link.inertial, mass, values))

    def _report_impossible_inertia(self, inertial: Inertial, link: DraftLink, layer: Layer) -> None:
        """Reports an impossible inertia from a pattern. Another rule checks a link's own inertia."""
        moments = inertial.inertia.numbers() if inertial.inertia.is_constant else ()
        if moments and 2 * max(moments) > sum(moments) * (1 + 1e-9):
            self._sink.report(
                "SC506",
                f"the inertia of `{cut(link.name)}` is impossible: one moment exceeds the sum of the others",
                layer[1].child("inertial", "inertia"),
                hint="each of ixx, iyy, izz is at most the sum of the other two",
            )


def _scale_inertial(inertial: Inertial, mass: Value, values: OverrideValues) -> Inertial:
    """Scales the inertial of a file to another mass: I · (m / m0), the centre of mass unchanged."""
    (before,) = inertial.mass.numbers()
    moments = inertial.inertia.numbers()
    if mass.is_constant:
        (after,) = mass.numbers()
        return Inertial(mass, inertial.com, literal(tuple(one * (after / before) for one in moments)))
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    def scale(masses: NDArray[Any]) -> NDArray[Any]:
        return np.array(moments) * (masses[:, None] / before)

    inertia = derived(scale, [mass], values.fields.scenes)
    resets = values.fields.sampling.resets
    if (reset := resets.get(id(mass))) is not None:
        factors = [one / before for one in moments]
        node = Stacked(tuple(AffineClamp(reset.node, -1, -FLOAT32_MAX, FLOAT32_MAX, factor) for factor in factors))
        resets[id(inertia)] = ResettableValue(inertia, node, reset.variation, values.fields.scenes)
    return Inertial(mass, inertial.com, inertia)


_JOINT_FIELDS = property_fields("joint")
_JOINT_TYPES = {row.field: field_type(row.quantity) for row in JOINT_PROPERTIES}


def with_overrides(joint: DraftJoint, layers: Sequence[Layer], values: OverrideValues) -> DraftJoint:
    """Applies the overrides of `joints`."""
    if not joint.moves or not layers:
        return joint
    overrides = {field: values.value(layers, field, _JOINT_TYPES[field]) for field in _JOINT_FIELDS}
    changed: dict[str, Any] = {
        "properties": joint.properties | {field: value for field, value in overrides.items() if value is not None}
    }
    rubs = nearest_override(layers, "friction_force")
    if rubs is not None:
        changed["friction_force"] = values.of(rubs, "friction_force", _JOINT_TYPES["force_limit"])
        changed["friction_origin"] = rubs[1].child("friction_force")
    elif overrides["friction"] is not None:
        changed["friction_force"] = None
    limits = nearest_override(layers, "limits", "limits_deg")
    if limits is not None:
        keys, origin = limits
        check_limits_keys(keys, joint.type, origin, values.fields.sink)
        warn_limits_in_degrees(keys, joint.type, origin, values.fields.sink)
        changed["limits"] = values.limits(limits)
        changed["limits_origin"] = origin.child("limits" if keys.limits_deg is None else "limits_deg")
    return replace(joint, **changed)


def lower_joint(
    joint: DraftJoint,
    drives: Sequence[Layer],
    start: tuple[Value | None, Value | None],
    values: OverrideValues,
    targets: DriveTargetCheck,
) -> Joint:
    """Lowers a joint.

    Args:
        joint: with its overrides.
        drives: overrides of its drive.
        start: its initial position and velocity; None: not given, so 0.
        values: of the articulation.
        targets: checks the drive's target.
    """
    qpos, qvel = start
    if not joint.moves:
        return Joint("fixed", joint.name, joint.pose_in_parent, joint.pose_in_child, origin=joint.origin)
    made = Joint(
        type=joint.type,
        name=joint.name,
        pose_in_parent=joint.pose_in_parent,
        pose_in_child=joint.pose_in_child,
        limits=joint.limits,
        qpos=qpos,
        qvel=qvel,
        origin=joint.origin,
        limits_origin=joint.limits_origin,
        **joint.properties,
    )
    if not drives:
        pulls = made.stiffness is not None and made.drive_target is None
        return replace(made, drive_target=qpos) if pulls else made
    aimed, target = nearest_override(drives, "target"), None
    if aimed is not None:
        target = values.of(aimed, "target", _JOINT_TYPES["drive_target"], reset=True)
        targets.judge(joint, target, aimed[1].child("target"))
    mode = nearest_override(drives, "mode")
    force_limit = values.value(drives, "force_limit", _JOINT_TYPES["force_limit"])
    return replace(
        made,
        stiffness=values.value(drives, "stiffness", _JOINT_TYPES["stiffness"]) or literal(0.0),
        damping=values.value(drives, "damping", _JOINT_TYPES["damping"]) or literal(0.0),
        force_limit=joint.effort if force_limit is None else force_limit,
        drive_mode=None if mode is None else mode[0].mode,
        drive_target=qpos if target is None else target,
        drive_velocity_target=values.value(
            drives, "velocity_target", _JOINT_TYPES["drive_velocity_target"], reset=True
        ),
    )


LostForce = tuple[str, str, "Origin"]
"""Code, message and place of a friction or a damping that is not built."""


def with_friction_force(joint: Joint, draft: DraftJoint, drives: Sequence[Layer]) -> tuple[Joint, LostForce | None]:
    """Adds the drive that is a friction force, if the joint has no other; also returns what cannot be built.

    Args:
        joint: lowered.
        draft: with its overrides.
        drives: overrides of its drive.
    """
    force, place = draft.friction_force, draft.friction_origin
    if force is None or place is None or joint.type == "fixed" or not any(force.numbers()):
        return joint, None
    slides = joint.type == "prismatic"
    what = f"friction of {max(force.numbers()):g} {'N' if slides else 'N·m'} of `{cut(joint.name)}`"
    if drives:
        is_written = place is not draft.origin
        code, place = ("SC494", place) if is_written else ("SC495", drives[-1][1])
        return joint, (code, f"the {what} is not built: the drive replaces it", place)
    damping = 0.0 if joint.damping is None else max(joint.damping.numbers())
    words = f"damping of {damping:g} {'N·s/m' if slides else 'N·m·s/rad'}"
    lost = unbuilt_resistance(max(force.numbers()), damping, is_driven=joint.stiffness is not None)
    if lost == "friction":
        reason = f"a {words}" if joint.stiffness is None else "a spring or an actuator"
        return joint, ("SC494", f"the {what} is not built: the joint has {reason}", place)
    friction = joint.friction or literal(0.0)
    made = replace(joint, friction=friction, damping=literal(BRAKE_DAMPING), force_limit=force)
    return made, ("SC494", f"the {words} is not built, but the {what} is", place) if lost else None


_TURN = 2 * math.pi - 0.1
"""Positions of a `revolute` joint wrap at a full turn; the margin is for overshoot [rad]."""


def with_counted_turns(joint: Joint, *, is_coupled: bool) -> Joint:
    """Makes a joint `revolute_unwrapped` if its position must not wrap.

    PhysX wraps the position of a `revolute` joint at a full turn, but not the drive target, the limits and the rest
    length of a tendon that it is compared with: beyond a turn, such a joint would spin for ever. Below, both types are
    equal to the bit. A joint that is compared with nothing, such as a wheel, stays `revolute`, as in SAPIEN's loader.

    Args:
        joint: lowered.
        is_coupled: whether it follows another joint, or another joint follows it.
    """
    if joint.type != "revolute":
        return joint
    low, high = widest(joint.limits)
    is_driven = joint.stiffness is not None and any(joint.stiffness.numbers())
    is_compared = is_driven or is_coupled or math.isfinite(low) or math.isfinite(high)
    return replace(joint, type="revolute_unwrapped") if is_compared and max(-low, high) > _TURN else joint


OUTSIDE = 1e-6
"""Tolerance for positions outside of a limit, since written limits are rounded [m or rad]."""

OutsidePosition = tuple[int, float, float, float]
"""Row of a position outside of its limits, the position, and the limits there."""


def widest(limits: Value | None) -> tuple[float, float]:
    """The lowest and the highest possible limit."""
    numbers = () if limits is None else limits.numbers()
    return min(numbers[0::2], default=-math.inf), max(numbers[1::2], default=math.inf)


def first_outside(limits: Value, positions: Sequence[float]) -> OutsidePosition | None:
    """The first position outside of known limits.

    Args:
        limits: (·, 2).
        positions: one for all scenes, or one per scene.
    """
    numbers = limits.numbers()
    pairs = [(numbers[i], numbers[i + 1]) for i in range(0, len(numbers), 2)]
    for row in range(max(len(pairs), len(positions))):
        low, high = pairs[row if len(pairs) > 1 else 0]
        at = positions[row if len(positions) > 1 else 0]
        if not low - OUTSIDE <= at <= high + OUTSIDE:
            return row, at, low, high
    return None


class DriveTargetCheck:
    """Warns of drive targets beyond the limits of their joints, once per place.

    Args:
        fields: of the articulation.
        sink: receives the warnings.
        beyond_limits: whether this is intended.
    """

    def __init__(self, fields: FieldLowerer, sink: Sink, *, beyond_limits: bool) -> None:
        self._fields = fields
        self._sink = sink
        self._beyond_limits = beyond_limits
        self._reported: set[int] = set()

    def judge(self, joint: DraftJoint, target: Value, place: Origin) -> None:
        """Warns of the first scene in which a target is, or may be, beyond the limits.

        The bounds of a drawn target are checked against the widest limits. An unbounded one, such as `normal`, is not
        checked.

        Args:
            joint: with its overrides.
            target: (·,) as written.
            place: where it is written.
        """
        if self._beyond_limits or joint.limits is None or id(target) in self._reported:
            return
        found = find_target_beyond_limits(joint.limits, target)
        if found is None:
            return
        self._reported.add(id(target))
        (row, at, low, high), certain = found
        several = certain and max(len(joint.limits.numbers()) // 2, len(target.numbers())) > 1
        scene = f" in scene {self._fields.scenes[row]}" if several else ""
        pulls = "pulls" if certain else "may pull"
        message = f"the drive of `{cut(joint.name)}` {pulls} to {at:g}{scene}, beyond its limits [{low:g}, {high:g}]"
        hint = "positions are radians, or metres for a prismatic joint; `beyond_limits: true` allows the target"
        self._sink.report("SC523", message, place, hint=hint)


def find_target_beyond_limits(limits: Value, target: Value) -> tuple[OutsidePosition, bool] | None:
    """A target beyond its limits, and whether this is certain."""
    if limits.known and target.known:
        found = first_outside(limits, target.numbers())
        return None if found is None else (found, True)
    low, high = widest(limits)
    numbers = [number for number in target.numbers() if math.isfinite(number)]
    at = next((number for number in numbers if not low - OUTSIDE <= number <= high + OUTSIDE), None)
    return None if at is None else ((0, at, low, high), False)
