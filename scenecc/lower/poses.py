"""Lowers poses and angles to numbers, or to a node if anything varies.

A pose is seven numbers: p [m], then q (wxyz). Angles are in radians or degrees. Radians that look like degrees give a
warning.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

from scenecc.geometry import rotations
from scenecc.geometry.rotations import (
    AXES,
    EXACT_UNIT_TOLERANCE,
    IDENTITY,
    IDENTITY_POSE,
    RIGID_TOLERANCE,
    UNIT_TOLERANCE,
    Pose7,
    Quat,
    Vec3,
)
from scenecc.lower.field_types import POSITION, FieldType, field_type, vector
from scenecc.lower.forms import VARYING, FieldPlace, FormStep, VariationLowerer, field_place
from scenecc.plan import Value, literal
from scenecc.plan.properties import Bounds
from scenecc.spec.pose import ROTATIONS, AxisAngle, PoseMapping
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import (
    Choice,
    Cycle,
    DrawForm,
    Once,
    PerScene,
    RandomRotation,
    SceneMap,
    Vector,
    alternative_values,
    alternatives,
)
from scenecc.variation.nodes import NODE_TYPES, FromAxisAngle, FromMatrix, FromRpy, Looking, Normalized, Posed, Radians
from scenecc.variation.operations import DrawError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin, Path
    from scenecc.lower.fields import FieldLowerer

_FIXED_LENGTH = 0.05
"""Largest deviation from length 1 of a quaternion that was only rounded: 0.7 for 0.7071 is 0.01 off."""

_NEARLY_VERTICAL = math.tan(math.radians(5))
"""Horizontal part of a view, relative to its vertical one, below which small changes turn its up direction far."""

_TWO_TURNS = 4 * math.pi * (1 + 1e-6)
"""Two turns [rad]. Few angles are larger; below this, radians cannot be distinguished from degrees."""


def warn_probable_degrees(written: Any, key: str, owner: Origin, at: Path, sink: Sink, *, more: str = "") -> None:
    """Warns of angles [rad] that exceed two turns in every draw.

    Does not check expressions that read draws, nor unbounded values.

    Args:
        written: one or several numbers or forms of them.
        key: of the angle, which has an alternative in degrees.
        owner: of the node that has the key.
        at: path of the key in the node.
        sink: receives the warning.
        more: added to the hint.
    """
    largest = suspect_degrees(written)
    if largest:
        hint = f"write `{key}_deg` instead of `{key}`: angles are radians{more}"
        place = owner.child(*at)
        # No automatic fix for `limits`: a joint that turns freely may have large limits in radians.
        is_named = place.path[-1:] == (key,) and key != "limits"
        warn_large_angle(largest, place, sink, hint=hint, fix=("key", f"{key}_deg") if is_named else None)


def warn_large_angle(
    angle: float, place: Origin, sink: Sink, *, hint: str, fix: tuple[Literal["key"], str] | None = None
) -> None:
    """Warns of an angle [rad]."""
    sink.report("SC526", f"{angle:g} radians are {angle / math.tau:.3g} turns", place, hint=hint, fix=fix)


def suspect_degrees(written: Any) -> float:
    """The largest angle that exceeds two turns in every scene; 0 if there is none.

    Uses the smallest of alternatives and bounds.
    """
    sizes = _least_magnitude(written)
    return max((size for size in (sizes if sizes.__class__ is tuple else (sizes,)) if size > _TWO_TURNS), default=0.0)


def _least_magnitude(written: Any) -> Any:
    """The least magnitude of one or several numbers; 0 if unknown or unbounded."""
    if written.__class__ in {tuple, list}:
        return tuple(map(_least_magnitude, written))
    parts: tuple[Any, ...]
    match written:
        case int() | float():
            return abs(written) if math.isfinite(written) else 0.0
        case Vector(items):
            return tuple(map(_least_magnitude, items))
        case PerScene() | SceneMap() | Cycle() | Choice() | Once():
            parts = tuple(one for _, one in alternatives(written))
        case DrawForm(kind, operands) if (between := DISTRIBUTIONS[kind].between) and between[1] < len(operands):
            parts = (operands[between[0]], operands[between[1]])
        case _:
            return 0.0
    found = [_least_magnitude(part) for part in parts]
    if all(one.__class__ is tuple for one in found):
        return tuple(min(ones) for ones in zip(*found, strict=False))
    return 0.0 if any(one.__class__ is tuple for one in found) else min(found, default=0.0)


_DEGREES = FieldType(within=Bounds(0.0, 180.0))


def lower_angle(keys: Any, quantity: str, owner: Origin, fields: FieldLowerer) -> Value | None:
    """An angle [rad]; None if neither key is given.

    Args:
        keys: the model.
        quantity: of the plan; its field has the name of the key in radians.
        owner: of the node that has the keys.
        fields: of the object.
    """
    kind, name = field_type(quantity), quantity.rpartition(".")[2]
    radians, degrees = getattr(keys, name), getattr(keys, f"{name}_deg")
    if radians is not None:
        return fields.value(radians, kind, owner, name)
    if degrees is None:
        return None
    return _lower_degrees(degrees, _DEGREES, kind, owner.child(f"{name}_deg"), fields)


def _lower_degrees(written: Any, degrees: FieldType, radians: FieldType, origin: Origin, fields: FieldLowerer) -> Value:
    """Lowers one or several angles in degrees to [rad]."""
    variation = VariationLowerer(fields, origin)
    item = variation.item(written, degrees, field_place(origin))
    if item.__class__ in NODE_TYPES:
        return fields.finish(Radians(item), variation, radians, origin)
    return literal(tuple(map(math.radians, item)) if radians.shape else math.radians(item))


_LIMITS = field_type("Joint.limits")


def lower_limits(keys: Any, origin: Origin, fields: FieldLowerer) -> Value | None:
    """Lowest and highest position, (·, 2) [m or rad]; None if neither key is given.

    Args:
        keys: model with `limits` and `limits_deg`.
        origin: of the model.
        fields: of the entity.
    """
    if keys.limits_deg is None:
        found = fields.optional(keys.limits, _LIMITS, origin, "limits")
    else:
        found = _lower_degrees(keys.limits_deg, _LIMITS, _LIMITS, origin.child("limits_deg"), fields)
    if found is not None:
        fields.keep_infinite(found)
    return found


def check_limits_keys(keys: Any, type_: str, origin: Origin, sink: Sink) -> None:
    """Reports limits in degrees for a prismatic joint."""
    if keys.limits_deg is not None and type_ == "prismatic":
        message = "the positions of a prismatic joint are lengths, and `limits_deg` are angles"
        sink.report("SC111", message, origin.child("limits_deg"), at="key", hint="write `limits`, in metres")


def warn_limits_in_degrees(keys: Any, type_: str, origin: Origin, sink: Sink) -> None:
    """Warns of limits of a revolute joint that are probably in degrees."""
    if type_ != "prismatic":
        warn_probable_degrees(keys.limits, "limits", origin, ("limits",), sink, more=", for several turns too")


def lower_pose(pose: Any, owner: Origin, at: Path, sink: Sink) -> Pose7:
    """A pose as seven numbers; the identity if it is left out or has an error.

    Ignores `relative_to`, which is resolved for the document.

    Args:
        pose: as written, without variation.
        owner: of the node that has the pose.
        at: path of the pose in the node (an origin per pose would be wasted on most).
        sink: receives the diagnostics.
    """
    if pose is None:
        return IDENTITY_POSE
    if pose.__class__ is tuple:
        x, y, z = pose
        return (x, y, z, 1.0, 0.0, 0.0, 0.0)
    form = rotation_key(pose)
    if form == "matrix":
        return _lower_matrix(pose.matrix, owner.child(*at), sink)
    p: Vec3 = pose.p or (0.0, 0.0, 0.0)
    if form is None:
        return (*p, 1.0, 0.0, 0.0, 0.0)
    return (*p, *(_lower_rotation(pose, form, p, owner, (*at, form), sink) or IDENTITY))


_ROTATIONS = frozenset(("matrix", *ROTATIONS))


def rotation_key(pose: PoseMapping) -> str | None:
    """The key of a pose's rotation, including `matrix`; None if it has none."""
    for key in pose.model_fields_set:
        if key in _ROTATIONS:
            return key
    return None


def direction(axis: str | Vec3) -> Vec3:
    """The direction of an axis name, or the vector itself."""
    return AXES[axis] if isinstance(axis, str) else axis


def _lower_rotation(pose: Any, form: str, p: Vec3, owner: Origin, at: Path, sink: Sink) -> Quat | None:
    match form:
        case "q":
            return lower_quaternion(pose.q, owner, at, sink)
        case "rpy":
            warn_probable_degrees(pose.rpy, form, owner, at, sink)
            return rotations.from_rpy(*pose.rpy)
        case "rpy_deg":
            roll, pitch, yaw = pose.rpy_deg
            return rotations.from_rpy(math.radians(roll), math.radians(pitch), math.radians(yaw))
        case "axis_angle":
            return _lower_axis_angle(pose.axis_angle, owner.child(*at), sink)
        case _:
            return _lower_look_at(pose.look_at, p, owner.child(*at), sink)


def lower_quaternion(q: Quat, owner: Origin, at: Path, sink: Sink) -> Quat | None:
    """A quaternion of length 1, normalised if close enough; None after an error."""
    off = abs(math.hypot(*q) - 1)
    if off <= EXACT_UNIT_TOLERANCE:
        return q
    if off <= UNIT_TOLERANCE:
        return rotations.normalized(q)
    sink.report(
        "SC112",
        f"the quaternion's length is {math.hypot(*q):.6g}, not 1",
        owner.child(*at),
        fix=("value", str([float(x) for x in rotations.normalized(q)])) if off <= _FIXED_LENGTH else None,
        hint=f"write `q: {_shown(rotations.normalized(q))}`, of length 1, or use `rpy_deg`" if any(q) else None,
    )
    return None


def _shown(q: Quat) -> str:
    return f"[{', '.join(f'{x:.9g}' for x in q)}]"


def has_angle(given: AxisAngle, origin: Origin, sink: Sink) -> bool:
    """Whether an angle is given; otherwise reports it."""
    if given.angle is None and given.angle_deg is None:
        sink.report("SC102", "`axis_angle` lacks the key `angle` or `angle_deg`", origin, at="key")
        return False
    return True


def _lower_axis_angle(given: Any, origin: Origin, sink: Sink) -> Quat | None:
    if not has_angle(given, origin, sink):
        return None
    axis = direction(given.axis)
    if not any(axis):
        sink.report("SC114", "an axis of length 0 has no direction", origin.child("axis"))
        return None
    if given.angle is not None:
        warn_probable_degrees(given.angle, "angle", origin, ("angle",), sink)
        return rotations.from_axis_angle(axis, given.angle)
    return rotations.from_axis_angle(axis, math.radians(given.angle_deg or 0.0))


def _lower_look_at(target: Vec3, p: Vec3, origin: Origin, sink: Sink) -> Quat | None:
    q = rotations.looking((target[0] - p[0], target[1] - p[1], target[2] - p[2]))
    if q is None:
        sink.report(
            "SC114",
            "`look_at` is where the pose itself is, or straight above or below it",
            origin,
            hint="a view straight up or down needs another form: rpy_deg: [0, 90, 0] looks down",
        )
    return q


def _lower_matrix(matrix: Any, origin: Origin, sink: Sink) -> Pose7:
    if (off := rotations.rigidity(matrix)) > RIGID_TOLERANCE:
        sink.report(
            "SC113",
            f"the matrix is not rigid: it is off by {off:.3g}",
            origin.child("matrix"),
            hint="its upper left 3×3 must be a rotation (orthonormal, determinant +1), its last row [0, 0, 0, 1]",
        )
        return IDENTITY_POSE
    (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = matrix
    return (x, y, z, *rotations.from_matrix(((a, b, c), (d, e, f), (g, h, i))))


POSE = FieldType((7,), fallback=IDENTITY_POSE)

_ANGLES = vector(3)

_ANGLE = FieldType()

QUATERNION = FieldType((4,), fallback=IDENTITY)

_MATRIX = FieldType((4, 4))


def pose_varies(pose: Any) -> bool:
    """Whether a pose, without its `relative_to`, may vary by scene."""
    if pose.__class__ is not PoseMapping:
        return pose.__class__ in VARYING
    # All keys at once: this is called for ten thousand poses.
    if _any_varies(pose):
        return True
    return pose.axis_angle is not None and _any_varies(pose.axis_angle)


def _any_varies(keys: PoseMapping | AxisAngle) -> bool:
    items: Iterable[Any] = vars(keys).values()
    return not VARYING.isdisjoint(map(type, items))


def pose_item(pose: Any, place: FieldPlace, variation: VariationLowerer, sink: Sink) -> Any:
    """Reads a pose as an item: seven numbers, or a node.

    Args:
        pose: as written; `relative_to` is only checked if it is not supported here.
        place: of the pose.
        variation: of the field.
        sink: receives the diagnostics.
    """
    if not pose_varies(pose):
        return lower_pose(pose, place.origin, (), sink)
    if pose.__class__ is PoseMapping:
        return _pose_mapping_node(pose, place, variation, sink)

    def leaf(given: Any, around: FieldPlace, step: FormStep) -> Any:
        """Reads one alternative: a mapping, or a position without a rotation."""
        if isinstance(given, PoseMapping):
            inside = around.inside(step) if step else around
            for key in ("relative_to", "anchor"):
                if getattr(given, key) is not None:
                    _report_several_frames(key, inside.origin, sink)
            return pose_item(given, inside, variation, sink)
        if given.__class__ not in VARYING:
            return (*given, *IDENTITY)
        return Posed(variation.item(given, POSITION, around.inside(step) if step else around), IDENTITY)

    # Same path as `p` of a mapping, an equivalent notation.
    several = any(isinstance(one, PoseMapping) for one in alternative_values(pose))
    field = place if several else FieldPlace(place.origin, f"{place.path}.p")
    return variation.select(pose, field, leaf)


def _report_several_frames(key: str, origin: Origin, sink: Sink) -> None:
    what = "be relative to something" if key == "relative_to" else "have an anchor"
    sink.report(
        "SC316",
        f"alternatives of a pose cannot each {what}",
        origin.child(key),
        at="key",
        hint=f"write one `{key}`, and the alternatives in `p`, `rpy` or `axis_angle` beside it",
    )


def _pose_mapping_node(pose: PoseMapping, place: FieldPlace, variation: VariationLowerer, sink: Sink) -> Any:
    form = rotation_key(pose)
    if form == "matrix":
        matrix = FromMatrix(variation.item(pose.matrix, _MATRIX, place.key("matrix")))
        return variation.risk(matrix, place.origin.child("matrix"))
    p: Any = (0.0, 0.0, 0.0) if pose.p is None else pose.p
    p = variation.item(p, POSITION, place.key("p"))
    return Posed(p, IDENTITY if form is None else _rotation_node(pose, form, p, place.key(form), variation, sink))


def _rotation_node(pose: Any, form: str, p: Any, place: FieldPlace, variation: VariationLowerer, sink: Sink) -> Any:
    given = getattr(pose, form)
    match form:
        case "q":
            return _quaternion_node(given, place, variation, sink)
        case "rpy":
            warn_probable_degrees(given, form, place.origin, (), sink)
            return FromRpy(variation.item(given, _ANGLES, place))
        case "rpy_deg":
            return FromRpy(Radians(variation.item(given, _ANGLES, place)))
        case "axis_angle":
            return _axis_angle_node(given, place, variation, sink)
        case _:
            node = Looking(variation.item(given, POSITION, place), p)
            if _may_be_vertical(node, variation):
                message = "this view can come within a few degrees of straight up or down, where its up direction flips"
                hint = "keep `p` and `look_at` apart sideways, or turn it by `rpy_deg`: [0, 90, 0] looks down"
                sink.report("SC588", message, place.origin, hint=hint)
            return variation.risk(node, place.origin)


def _may_be_vertical(node: Looking, variation: VariationLowerer) -> bool:
    """Returns whether a view of a continuous distribution can be within `_NEARLY_VERTICAL` of the vertical.

    Independent components with bounds are checked over their whole range, expressions and normal distributions by
    samples.
    """
    target, p = (variation.analysis.item(item) for item in (node.target, node.p))
    if target.alternatives is not None and p.alternatives is not None:
        return False
    bounds = [*target.low, *target.high, *p.low, *p.high] if target.exact and p.exact else [math.inf]
    if not all(map(math.isfinite, bounds)):
        try:
            ends = [variation.analysis.samples.item(item) for item in (node.target, node.p)]
        except DrawError:
            return False
        return any(math.hypot(x, y) < _NEARLY_VERTICAL * abs(z) for x, y, z in (ends[0] - ends[1]).tolist())
    low = [a - b for a, b in zip(target.low, p.high, strict=True)]
    high = [a - b for a, b in zip(target.high, p.low, strict=True)]
    across = math.hypot(*(max(least, -most, 0.0) for least, most in zip(low[:2], high[:2], strict=True)))
    return across < _NEARLY_VERTICAL * max(abs(low[2]), abs(high[2]))


def _quaternion_node(given: Any, place: FieldPlace, variation: VariationLowerer, sink: Sink) -> Any:
    def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
        if one.__class__ not in VARYING:
            return lower_quaternion(one, around.origin, step, sink) or IDENTITY
        inside = around.inside(step) if step else around
        item = variation.item(one, QUATERNION, inside)
        return item if isinstance(one, RandomRotation) else variation.risk(Normalized(item), inside.origin)

    return variation.select(given, place, leaf)


def _axis_angle_node(given: AxisAngle, place: FieldPlace, variation: VariationLowerer, sink: Sink) -> Any:
    if not has_angle(given, place.origin, sink):
        return IDENTITY
    axis: Any = given.axis
    varies = axis.__class__ in VARYING
    axis = variation.item(axis, _axis_type(sink), place.key("axis"))
    if given.angle is not None:
        warn_probable_degrees(given.angle, "angle", place.origin, ("angle",), sink)
        angle = variation.item(given.angle, _ANGLE, place.key("angle"))
    else:
        angle = Radians(variation.item(given.angle_deg, _ANGLE, place.key("angle_deg")))
    rotation = FromAxisAngle(axis, angle)
    return variation.risk(rotation, place.origin.child("axis")) if varies else rotation


def _axis_type(sink: Sink) -> FieldType:
    def convert(axis: Any) -> Any:
        found = direction(axis)
        return found if any(found) else None

    def complain(_axis: Any, origin: Origin, _sink: Sink) -> None:
        sink.report("SC114", "an axis of length 0 has no direction", origin)

    return FieldType((3,), convert=convert, complain=complain, fallback=(1.0, 0.0, 0.0))
