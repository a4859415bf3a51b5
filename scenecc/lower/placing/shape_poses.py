"""Where shapes and centres of mass stand in the frames of their bodies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.lower.forms import VARYING, Reading, place_of
from scenecc.lower.kinds import Kind, vector
from scenecc.lower.placing.pose_nodes import POSE, pose_item, pose_varies
from scenecc.lower.placing.poses import IDENTITY_POSE, Pose7, direction, lower_pose, turned
from scenecc.lower.placing.rotations import IDENTITY, Quat, Vec3, shortest_from_x
from scenecc.plan import Value, literal, varying
from scenecc.spec.pose import PoseMapping
from scenecc.variation.nodes import NODES

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.diagnostics import Origin, Sink
    from scenecc.lower.leaves import Leaves

AXIS_TURNS: dict[str, Quat] = {
    "x": IDENTITY,
    "y": shortest_from_x((0.0, 1.0, 0.0)),
    "z": shortest_from_x((0.0, 0.0, 1.0)),
}

_NORMAL = vector(3, "")
_OFFSET = Kind()


def local_pose(
    pose: Any, owner: Origin, at: tuple[str, ...], what: str, leaves: Leaves, *, reset: bool = False
) -> Value:
    """A pose in the frame of the body.

    Args:
        pose: as written; None: the identity.
        owner: of the node that has it.
        at: where it is there.
        what: has the pose, for a message.
        leaves: of the object.
        reset: whether a reset may change it.
    """
    if isinstance(pose, PoseMapping) and pose.relative_to is not None:
        leaves.sink.report(
            "SC115",
            f"`relative_to` does nothing here: {what} stands in the frame of its body",
            owner.child(*at, "relative_to"),
            at="key",
            hint="leave `relative_to` out",
        )
    if not pose_varies(pose):
        return literal(lower_pose(pose, owner, at, leaves.sink))
    place = place_of(owner.child(*at))
    reading = Reading(leaves, place.origin)
    return leaves.finish(pose_item(pose, place, reading, leaves.sink), reading, POSE, place.origin, reset=reset)


def shape_pose(shape: Any, origin: Origin, leaves: Leaves) -> Value | None:
    """The pose of a shape, with what its `axis`, or `normal` and `offset`, put before it; None: the identity."""
    type_ = shape.type
    if shape.pose is None and type_ not in _TURNED:
        return None
    pose = local_pose(shape.pose, origin, ("pose",), "a shape", leaves)
    if type_ in {"capsule", "cylinder"}:
        pose = _before(pose, AXIS_TURNS[shape.axis], leaves)
    elif type_ == "plane":
        pose = _plane_pose(shape, pose, origin, leaves)
    return None if pose.is_constant and _is_identity(pose.numbers()) else pose


def _is_identity(pose: tuple[float, ...]) -> bool:
    """To the bit: what stands at -0.0 is told to the engine as it is written."""
    return pose == IDENTITY_POSE and "-" not in repr(pose)


_TURNED = frozenset(("capsule", "cylinder", "plane"))


def _before(pose: Value, turn: Quat, leaves: Leaves, step: Vec3 = (0.0, 0.0, 0.0)) -> Value:
    """A pose with the same turn and step in every scene put before it."""
    if pose.is_constant:
        return literal(turned(_seven(pose), turn, step))
    if turn == IDENTITY and not any(step):
        return pose

    return _turned_rows(pose, literal(turn), literal(step), leaves)


def _seven(pose: Value) -> Pose7:
    x, y, z, *q = pose.numbers()
    a, b, c, d = q
    return (x, y, z, a, b, c, d)


def _plane_pose(shape: Any, pose: Value, origin: Origin, leaves: Leaves) -> Value:
    if shape.normal.__class__ in VARYING or shape.offset.__class__ in VARYING:
        return _varying_plane(shape, pose, origin, leaves)
    normal = direction(shape.normal)
    if not any(normal):
        _no_direction(origin, leaves.sink)
        return pose
    # Along the normal itself: turned from x, a step along z would be off by the rotation's rounding.
    length = math.hypot(*normal)
    x, y, z = normal
    step = (x / length * shape.offset, y / length * shape.offset, z / length * shape.offset)
    return _before(pose, shortest_from_x(normal), leaves, step)


def _no_direction(origin: Origin, sink: Sink) -> None:
    sink.report("SC114", "a normal of length 0 has no direction", origin.child("normal"))


def _varying_plane(shape: Any, pose: Value, origin: Origin, leaves: Leaves) -> Value:
    place = place_of(origin)
    reading = Reading(leaves, origin)
    normal = reading.item(shape.normal, _NORMAL, place.key("normal"))
    offset = reading.item(shape.offset, _OFFSET, place.key("offset"))
    if normal.__class__ not in NODES and not any(normal):
        _no_direction(origin, leaves.sink)
        return pose
    leaves.fix(reading)
    if reading.broken:
        return pose
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.geometry import rotation_arrays  # noqa: PLC0415 - likewise
    from scenecc.variation.bounds import UNKNOWN  # noqa: PLC0415 - likewise
    from scenecc.variation.errors import DrawError  # noqa: PLC0415 - likewise
    from scenecc.variation.per_scene_arrays import to_field_rows  # noqa: PLC0415 - likewise

    def draw() -> NDArray[Any]:
        """The poses (B, 7): each row turned from x to its normal, and moved along that."""
        batch = leaves.batch()
        normals, offsets = to_field_rows(batch.item(normal)), to_field_rows(batch.item(offset))
        for numbers, node in ((normals, normal), (offsets, offset)):
            if numbers.dtype.kind not in "fi":
                raise DrawError("this is not made of numbers", leaves.scenes[0], node)
        flat = ~normals.any(axis=1)
        if flat.any():
            scene = leaves.scenes[int(np.flatnonzero(flat)[0])]
            raise DrawError("a normal of length 0 has no direction", scene, normal)
        steps = normals / rotation_arrays.hypot(normals)[:, None] * offsets[:, None]
        poses = np.broadcast_to(pose.data, (len(normals), 7))
        return rotation_arrays.turned(poses, rotation_arrays.shortest_from_x(normals), steps)

    value = varying(draw, bounds=UNKNOWN, rows=len(leaves.scenes))
    leaves.pend(value, POSE, origin.child("normal"), reading)
    return value


def _turned_rows(pose: Value, turn: Value, step: Value, leaves: Leaves) -> Value:
    """A pose before which shapes are turned and moved, row by row; drawn later where the pose is."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.geometry import rotation_arrays  # noqa: PLC0415 - likewise
    from scenecc.plan import per_scene  # noqa: PLC0415 - likewise
    from scenecc.variation.bounds import UNKNOWN  # noqa: PLC0415 - likewise

    def draw() -> NDArray[Any]:
        rows = len(leaves.scenes)
        poses = np.broadcast_to(pose.data, (rows, 7))
        return rotation_arrays.turned(
            poses, np.broadcast_to(turn.data, (rows, 4)), np.broadcast_to(step.data, (rows, 3))
        )

    return per_scene(draw()) if pose.known else varying(draw, bounds=UNKNOWN, rows=len(leaves.scenes))
