"""Poses one after the other, those of links among them: where something stands, seen from something else."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.frozen import frozen
from scenecc.lower.placing import rotations
from scenecc.lower.placing.poses import IDENTITY_POSE, Pose7, compose
from scenecc.lower.placing.rotations import IDENTITY
from scenecc.plan import Value, literal, per_scene, varying

if TYPE_CHECKING:
    from collections.abc import Sequence
    from typing import Literal

    from numpy.typing import NDArray

    from scenecc.plan import ArticulationStructure
    from scenecc.plan.articulation import Joint


@frozen
class Step:
    """One pose of a chain.

    Attributes:
        value: (·, 7), or (·,) how far a joint turns about x or slides along it.
        scenes: that its rows follow.
        kind: what it is.
        back: whether the pose is gone back.
    """

    value: Value
    scenes: tuple[int, ...]
    kind: Literal["pose", "turn", "slide"] = "pose"
    back: bool = False


def chained(steps: Sequence[Step], scenes: tuple[int, ...]) -> Value:
    """The pose (·, 7) of all steps, the outermost first, composed in float64.

    Args:
        steps: each of which has rows in all of the scenes.
        scenes: that the rows follow.
    """
    if all(step.value.is_constant for step in steps):
        pose = IDENTITY_POSE
        for step in steps:
            pose = compose(pose, _pose(step))
        return literal(pose)

    def draw() -> NDArray[Any]:
        import numpy as np  # noqa: PLC0415 - loaded where something varies

        from scenecc.geometry.rotation_arrays import compose as compose_rows  # noqa: PLC0415 - likewise

        poses = np.broadcast_to(np.array(IDENTITY_POSE), (len(scenes), 7))
        for step in steps:
            poses = compose_rows(poses, _rows(step, scenes))
        return poses

    if all(step.value.known for step in steps):
        return per_scene(draw())
    from scenecc.variation.bounds import UNKNOWN  # noqa: PLC0415 - loaded where something varies

    return varying(draw, bounds=UNKNOWN, rows=len(scenes))


def inverse(pose: Pose7) -> Pose7:
    """The pose that leads back."""
    w, x, y, z = pose[3:] if pose[3:] == IDENTITY else rotations.normalized(pose[3:])
    back = (w, 0.0 - x, 0.0 - y, 0.0 - z)
    px, py, pz = rotations.rotate(back, pose[:3])
    return (0.0 - px, 0.0 - py, 0.0 - pz, *back)


def to_link(structure: ArticulationStructure, link: str, scenes: tuple[int, ...]) -> list[Step]:
    """The steps from the root of an articulation to one of its links, its joints at their start.

    Args:
        structure: that has the link.
        link: its name.
        scenes: of the articulation.
    """
    at: int | None = next(number for number, one in enumerate(structure.links) if one.name == link)
    steps: list[Step] = []
    while at is not None:
        joint = structure.links[at].joint
        if joint is not None:
            steps = [*_across(joint, scenes), *steps]
        at = structure.links[at].parent
    return steps


def _across(joint: Joint, scenes: tuple[int, ...]) -> list[Step]:
    steps: list[Step] = []
    if joint.pose_in_parent is not None:
        steps.append(Step(joint.pose_in_parent, scenes))
    if joint.qpos is not None and joint.type != "fixed":
        steps.append(Step(joint.qpos, scenes, "slide" if joint.type == "prismatic" else "turn"))
    if joint.pose_in_child is not None:
        steps.append(Step(joint.pose_in_child, scenes, back=True))
    return steps


def _pose(step: Step) -> Pose7:
    if step.kind == "pose":
        x, y, z, a, b, c, d = step.value.numbers()
        pose: Pose7 = (x, y, z, a, b, c, d)
        return inverse(pose) if step.back else pose
    (moved,) = step.value.numbers()
    moved = -moved if step.back else moved
    if step.kind == "slide":
        return (moved, 0.0, 0.0, *IDENTITY)
    return (0.0, 0.0, 0.0, math.cos(moved / 2), math.sin(moved / 2), 0.0, 0.0)


def _rows(step: Step, scenes: tuple[int, ...]) -> NDArray[Any]:
    """The poses of a step, a row a scene."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.geometry import rotation_arrays as by_row  # noqa: PLC0415 - likewise

    data = step.value.data
    if len(data) > 1 and step.scenes is not scenes:
        data = data[np.searchsorted(step.scenes, scenes)]
    data = np.broadcast_to(data, (len(scenes), *data.shape[1:]))
    if step.kind == "pose":
        if not step.back:
            return data
        back = by_row.normalized(data[:, 3:]) * np.array((1.0, -1.0, -1.0, -1.0))
        return np.concatenate((0.0 - by_row.rotate(back, data[:, :3]), back + 0.0), axis=1)
    data = -data if step.back else data
    poses = np.tile(np.array(IDENTITY_POSE), (len(scenes), 1))
    if step.kind == "slide":
        poses[:, 0] = data
    else:
        poses[:, 3], poses[:, 4] = np.cos(data / 2), np.sin(data / 2)
    return poses
