"""Poses in the frames of bodies and chains of poses from one body to another."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.geometry import rotations
from scenecc.geometry.rotations import (
    AXES,
    IDENTITY,
    IDENTITY_POSE,
    Pose7,
    Quat,
    Vec3,
    compose,
    shortest_from_x,
    turned,
)
from scenecc.lower.field_types import BODY_FIELDS, FieldType, field_type, report_unused_key, vector
from scenecc.lower.forms import VARYING, FieldPlace, FormStep, VariationLowerer, field_place
from scenecc.lower.poses import POSE, QUATERNION, direction, lower_pose, pose_item, pose_varies
from scenecc.plan import Inertial, Value, derived, literal, per_scene, varying
from scenecc.plan.geometry import LYING_SOLIDS, REVOLVED_SOLIDS
from scenecc.plan.link_poses import PoseStep, step_poses
from scenecc.spec.pose import PoseMapping
from scenecc.variation.bounds import UNKNOWN
from scenecc.variation.nodes import NODES, Node, Pointing

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.lower.fields import FieldLowerer

AXIS_TURNS: dict[str, Quat] = {
    "x": IDENTITY,
    "y": shortest_from_x((0.0, 1.0, 0.0)),
    "z": shortest_from_x((0.0, 0.0, 1.0)),
}

_NORMAL = vector(3)
_OFFSET = FieldType()
_INERTIA = field_type("Inertial.inertia")


def local_pose(
    pose: Any, owner: Origin, at: tuple[str, ...], what: str, fields: FieldLowerer, *, reset: bool = False
) -> Value:
    """A pose in the frame of the body.

    Args:
        pose: as written; None: the identity.
        owner: of the node that has it.
        at: path of the pose in the node.
        what: the object with the pose, for a message.
        fields: of the object.
        reset: whether a reset may change it.
    """
    if isinstance(pose, PoseMapping) and pose.relative_to is not None:
        where = f"here: {what} is in the frame of its body"
        report_unused_key("relative_to", where, owner.child(*at), fields.sink)
    report_unused_anchor(pose, f"on {what}", owner.child(*at), fields.sink)
    if not pose_varies(pose):
        return literal(lower_pose(pose, owner, at, fields.sink))
    place = field_place(owner.child(*at))
    variation = VariationLowerer(fields, place.origin)
    return fields.finish(pose_item(pose, place, variation, fields.sink), variation, POSE, place.origin, reset=reset)


def report_unused_anchor(pose: Any, where: str, origin: Origin, sink: Sink) -> None:
    """Reports an `anchor` on an object that is not an entity. `origin`: of the pose."""
    if isinstance(pose, PoseMapping) and pose.anchor is not None:
        report_unused_key("anchor", where, origin, sink, hint="only entities have bounds")


def shape_pose(shape: Any, origin: Origin, fields: FieldLowerer) -> Value | None:
    """The pose of a shape, including its `axis`, or `normal` and `offset`; None: the identity."""
    type_ = shape.type
    if shape.pose is None and type_ not in _TURNED:
        return None
    pose = local_pose(shape.pose, origin, ("pose",), "a shape", fields)
    if type_ in _LYING:
        pose = _with_rotation(pose, AXIS_TURNS[shape.axis], fields)
    elif type_ == "plane":
        pose = _plane_pose(shape, pose, origin, fields)
    return None if pose.is_constant and _is_identity(pose.numbers()) else pose


def axis_rotation(axis: Any, origin: Origin, fields: FieldLowerer) -> Quat | Value:
    """The shortest rotation from x to an axis: of all scenes, or a value (·, 4).

    Args:
        axis: as written; None: x.
        origin: of the node with the key `axis`.
        fields: of the object.
    """
    place = field_place(origin).key("axis")
    if axis.__class__ not in VARYING:
        vector = direction("x" if axis is None else axis)
        if not any(vector):
            fields.sink.report("SC114", "an axis of length 0 has no direction", origin.child("axis"))
            return IDENTITY
        return shortest_from_x(vector)
    variation = VariationLowerer(fields, place.origin)
    return fields.finish(axis_node(axis, place, variation), variation, QUATERNION, place.origin)


def axis_node(axis: Any, place: FieldPlace, variation: VariationLowerer) -> Node:
    """The shortest rotation from x to an axis that varies by scene. `place`: of the axis."""

    def leaf(one: Any, around: FieldPlace, step: FormStep) -> Any:
        if one.__class__ is str:
            return AXES[one]
        return variation.item(one, _NORMAL, around.inside(step) if step else around)

    return variation.risk(Pointing(variation.select(axis, place, leaf)), place.origin)


def rotated_frame(pose: Value | None, rotation: Quat | Value, fields: FieldLowerer) -> Value | None:
    """A frame followed by a rotation from `axis_rotation`; None: the identity."""
    if rotation == IDENTITY:
        return pose
    frame = literal(IDENTITY_POSE) if pose is None else pose
    if isinstance(rotation, Value):
        return derived(_turned_rows, [frame, rotation, literal((0.0, 0.0, 0.0))], fields.scenes)
    return _with_rotation(frame, rotation, fields)


def _is_identity(pose: tuple[float, ...]) -> bool:
    """Whether a pose is the identity bit by bit: a pose with -0.0 is passed to the engine unchanged."""
    return pose == IDENTITY_POSE and "-" not in repr(pose)


_LYING = frozenset((*LYING_SOLIDS, *REVOLVED_SOLIDS))

_TURNED = _LYING | {"plane"}


def _with_rotation(pose: Value, rotation: Quat, fields: FieldLowerer, step: Vec3 = (0.0, 0.0, 0.0)) -> Value:
    """A pose followed by a constant rotation and translation in its own frame."""
    if pose.is_constant:
        return literal(turned(seven_numbers(pose), rotation, step))
    if rotation == IDENTITY and not any(step):
        return pose
    return derived(_turned_rows, [pose, literal(rotation), literal(step)], fields.scenes)


def _turned_rows(poses: NDArray[Any], rotations: NDArray[Any], steps: NDArray[Any]) -> NDArray[Any]:
    """Poses moved by rotations and steps in their own frames; each part has one row, or one per scene."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.geometry import rotation_arrays  # noqa: PLC0415 - see above

    count = max(map(len, (poses, rotations, steps)))
    parts = ((poses, 7), (rotations, 4), (steps, 3))
    return rotation_arrays.turned(*(np.broadcast_to(part, (count, size)) for part, size in parts))


def seven_numbers(pose: Value) -> Pose7:
    """The numbers of a pose that is the same in every scene."""
    x, y, z, a, b, c, d = pose.numbers()
    return (x, y, z, a, b, c, d)


def _plane_pose(shape: Any, pose: Value, origin: Origin, fields: FieldLowerer) -> Value:
    if shape.normal.__class__ in VARYING or shape.offset.__class__ in VARYING:
        return _lower_varying_plane(shape, pose, origin, fields)
    normal = direction(shape.normal)
    if not any(normal):
        _no_direction(origin, fields.sink)
        return pose
    # Along the normal itself: a step along the rotated axis would contain the rotation's rounding error.
    length = math.hypot(*normal)
    x, y, z = normal
    step = (x / length * shape.offset, y / length * shape.offset, z / length * shape.offset)
    return _with_rotation(pose, shortest_from_x(normal), fields, step)


def _no_direction(origin: Origin, sink: Sink) -> None:
    sink.report("SC114", "a normal of length 0 has no direction", origin.child("normal"))


def _lower_varying_plane(shape: Any, pose: Value, origin: Origin, fields: FieldLowerer) -> Value:
    place = field_place(origin)
    variation = VariationLowerer(fields, origin)
    normal = variation.item(shape.normal, _NORMAL, place.key("normal"))
    offset = variation.item(shape.offset, _OFFSET, place.key("offset"))
    if normal.__class__ not in NODES and not any(normal):
        _no_direction(origin, fields.sink)
        return pose
    fields.sampling.fix(variation)
    if variation.broken:
        return pose
    rotation = variation.risk(Pointing(normal), origin.child("normal"))
    given = ((rotation, QUATERNION, "normal"), (normal, _NORMAL, "normal"), (offset, _OFFSET, "offset"))
    parts = [fields.finish(item, variation, kind, origin.child(key)) for item, kind, key in given]
    if fields.sink.failed:
        return pose

    def turn(
        poses: NDArray[Any], rotations: NDArray[Any], normals: NDArray[Any], offsets: NDArray[Any]
    ) -> NDArray[Any]:
        """Rotates each pose from x to its normal, and translates it along the normal."""
        from scenecc.geometry.rotation_arrays import hypot  # noqa: PLC0415 - it loads numpy

        return _turned_rows(poses, rotations, normals / hypot(normals)[:, None] * offsets[:, None])

    return derived(turn, [pose, *parts], fields.scenes)


def chain_poses(steps: Sequence[PoseStep], scenes: tuple[int, ...]) -> Value:
    """The composed pose (·, 7) of all steps, the outermost first, in float64.

    Args:
        steps: with rows in all of the scenes.
        scenes: scenes of the rows.
    """
    if all(step.value.is_constant for step in steps):
        pose = IDENTITY_POSE
        for step in steps:
            pose = compose(pose, _step_pose(step))
        return literal(pose)

    def draw() -> NDArray[Any]:
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        from scenecc.geometry.rotation_arrays import compose as compose_rows  # noqa: PLC0415 - see above

        poses = np.broadcast_to(np.array(IDENTITY_POSE), (len(scenes), 7))
        for step in steps:
            poses = compose_rows(poses, _step_rows(step, scenes))
        return poses

    if all(step.value.known for step in steps):
        return per_scene(draw())

    def sample() -> NDArray[Any]:
        # Steps in other scenes have other samples.
        from scenecc.variation.samples import as_samples  # noqa: PLC0415 - it loads numpy

        return as_samples(draw())

    return varying(draw, sample, scenes, bounds=lambda: UNKNOWN)


def inverse_pose(pose: Pose7) -> Pose7:
    """The inverse of a pose."""
    w, x, y, z = pose[3:] if pose[3:] == IDENTITY else rotations.normalized(pose[3:])
    back = (w, 0.0 - x, 0.0 - y, 0.0 - z)
    px, py, pz = rotations.rotate(back, pose[:3])
    return (0.0 - px, 0.0 - py, 0.0 - pz, *back)


def _step_pose(step: PoseStep) -> Pose7:
    if step.kind == "pose":
        pose = seven_numbers(step.value)
        return inverse_pose(pose) if step.back else pose
    (moved,) = step.value.numbers()
    moved = -moved if step.back else moved
    if step.kind == "slide":
        return (moved, 0.0, 0.0, *IDENTITY)
    return (0.0, 0.0, 0.0, math.cos(moved / 2), math.sin(moved / 2), 0.0, 0.0)


def _step_rows(step: PoseStep, scenes: tuple[int, ...]) -> NDArray[Any]:
    """The poses of a step, one row per scene."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    data = step.value.data
    if len(data) > 1 and step.scenes is not scenes:
        data = data[np.searchsorted(step.scenes, scenes)]
    return step_poses(step, np.broadcast_to(data, (len(scenes), *data.shape[1:])))


def lower_inertial(given: Any, owner: Origin, fields: FieldLowerer) -> Inertial:
    """The mass properties under the key `inertial` of a body or a link. `owner`: of the node that has the key."""
    place = owner.child("inertial")
    return Inertial(
        fields.value(given.mass, BODY_FIELDS["mass"][1], place, "mass"),
        local_pose(given.com, owner, ("inertial", "com"), "a centre of mass", fields, reset=True),
        fields.value(given.inertia, _INERTIA, place, "inertia"),
    )
