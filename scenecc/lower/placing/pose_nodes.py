"""Poses of which anything varies, as written, to nodes: p [m], then q (wxyz)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.lower.forms import VARYING, Place, Reading, Step
from scenecc.lower.kinds import Kind, vector
from scenecc.lower.placing.poses import (
    IDENTITY_POSE,
    axis_angle_is_clear,
    direction,
    lower_pose,
    lower_quaternion,
    rotation_of,
)
from scenecc.lower.placing.rotations import IDENTITY
from scenecc.lower.turns import doubt
from scenecc.spec.pose import AxisAngle, PoseMapping
from scenecc.variation.forms import Choice, Cycle, PerScene, RandomRotation, SceneMap
from scenecc.variation.nodes import FromAxisAngle, FromMatrix, FromRpy, Looking, Normalized, Posed, Radians

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics import Origin, Sink

POSE = Kind((7,), fallback=IDENTITY_POSE)
_POSITION = vector(3, "")
_ANGLES = vector(3, "")
_ANGLE = Kind()
_QUATERNION = Kind((4,), fallback=IDENTITY)
_MATRIX = Kind((4, 4))


def pose_varies(pose: Any) -> bool:
    """Whether anything of a pose as written may differ from scene to scene, but for what it stands relative to."""
    if pose.__class__ is not PoseMapping:
        return pose.__class__ in VARYING
    # All keys at once: ten thousand poses are asked.
    if _any_varies(pose):
        return True
    return pose.axis_angle is not None and _any_varies(pose.axis_angle)


def _any_varies(keys: PoseMapping | AxisAngle) -> bool:
    items: Iterable[Any] = vars(keys).values()
    return not VARYING.isdisjoint(map(type, items))


def pose_item(pose: Any, place: Place, reading: Reading, sink: Sink) -> Any:
    """A pose as an item: seven numbers, or a node.

    Args:
        pose: as written; `relative_to` is looked at only where it cannot be followed.
        place: of the pose.
        reading: of the field.
        sink: takes the diagnostics.
    """
    if not pose_varies(pose):
        return lower_pose(pose, place.origin, (), sink)
    if pose.__class__ is PoseMapping:
        return _mapping(pose, place, reading, sink)

    def leaf(given: Any, around: Place, step: Step) -> Any:
        if isinstance(given, PoseMapping):
            inside = around.inside(step) if step else around
            if given.relative_to is not None:
                _one_frame(inside.origin, sink)
            return pose_item(given, inside, reading, sink)
        if given.__class__ not in VARYING:
            return (*given, *IDENTITY)
        return Posed(reading.item(given, _POSITION, around.inside(step) if step else around), IDENTITY)

    # As `p` of a mapping, which is another way to write the same.
    field = place if _has_mapping(pose) else Place(place.origin, f"{place.path}.p")
    return reading.select(pose, field, leaf)


def _has_mapping(pose: Any) -> bool:
    match pose:
        case PerScene(items) | Cycle(items) | Choice(items):
            return any(map(_has_mapping, items))
        case SceneMap(items, default):
            return any(_has_mapping(one) for _, one in items) or _has_mapping(default)
        case _:
            return isinstance(pose, PoseMapping)


def _one_frame(origin: Origin, sink: Sink) -> None:
    sink.report(
        "SC316",
        "alternatives of a pose cannot each stand relative to something",
        origin.child("relative_to"),
        at="key",
        hint="write one `relative_to`, and the alternatives in `p`, `rpy` or `axis_angle` beside it",
    )


def _mapping(pose: PoseMapping, place: Place, reading: Reading, sink: Sink) -> Any:
    form, clear = rotation_of(pose, place.origin, (), sink)
    if not clear:
        return IDENTITY_POSE
    if form == "matrix":
        matrix = FromMatrix(reading.item(pose.matrix, _MATRIX, place.key("matrix")))
        return reading.risk(matrix, place.origin.child("matrix"))
    p: Any = (0.0, 0.0, 0.0) if pose.p is None else pose.p
    p = reading.item(p, _POSITION, place.key("p"))
    return Posed(p, IDENTITY if form is None else _rotation(pose, form, p, place.key(form), reading, sink))


def _rotation(pose: Any, form: str, p: Any, place: Place, reading: Reading, sink: Sink) -> Any:
    given = getattr(pose, form)
    match form:
        case "q":
            return _quaternion(given, place, reading, sink)
        case "rpy":
            doubt(given, form, place.origin, (), sink)
            return FromRpy(reading.item(given, _ANGLES, place))
        case "rpy_deg":
            return FromRpy(Radians(reading.item(given, _ANGLES, place)))
        case "axis_angle":
            return _axis_angle(given, place, reading, sink)
        case _:
            return reading.risk(Looking(reading.item(given, _POSITION, place), p), place.origin)


def _quaternion(given: Any, place: Place, reading: Reading, sink: Sink) -> Any:
    def leaf(one: Any, around: Place, step: Step) -> Any:
        if one.__class__ not in VARYING:
            return lower_quaternion(one, around.origin, step, sink) or IDENTITY
        inside = around.inside(step) if step else around
        item = reading.item(one, _QUATERNION, inside)
        return item if isinstance(one, RandomRotation) else reading.risk(Normalized(item), inside.origin)

    return reading.select(given, place, leaf)


def _axis_angle(given: AxisAngle, place: Place, reading: Reading, sink: Sink) -> Any:
    if not axis_angle_is_clear(given, place.origin, sink):
        return IDENTITY
    axis: Any = given.axis
    varies = axis.__class__ in VARYING
    axis = reading.item(axis, _axis(sink), place.key("axis"))
    if given.angle is not None:
        doubt(given.angle, "angle", place.origin, ("angle",), sink)
        angle = reading.item(given.angle, _ANGLE, place.key("angle"))
    else:
        angle = Radians(reading.item(given.angle_deg, _ANGLE, place.key("angle_deg")))
    turn = FromAxisAngle(axis, angle)
    return reading.risk(turn, place.origin.child("axis")) if varies else turn


def _axis(sink: Sink) -> Kind:
    def convert(axis: Any) -> Any:
        found = direction(axis)
        return found if any(found) else None

    def complain(_axis: Any, origin: Origin, _sink: Sink) -> None:
        sink.report("SC114", "an axis of length 0 has no direction", origin)

    return Kind((3,), convert=convert, complain=complain, fallback=(1.0, 0.0, 0.0))
