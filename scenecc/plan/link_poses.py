"""Forward kinematics of a plan: chains of poses from the root of an articulation to its links."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Literal

from scenecc.diagnostics.frozen import frozen
from scenecc.geometry.rotations import IDENTITY_POSE

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.plan.articulation import ArticulationStructure, Joint
    from scenecc.plan.value import Value


@frozen
class PoseStep:
    """One pose of a chain.

    Attributes:
        value: (·, 7) pose, or (·,) position of a joint about or along x.
        scenes: scenes of its rows.
        kind: of the step.
        back: whether to use the inverse pose.
    """

    value: Value
    scenes: tuple[int, ...]
    kind: Literal["pose", "turn", "slide"] = "pose"
    back: bool = False


def steps_to_link(structure: ArticulationStructure, link: str, scenes: tuple[int, ...]) -> list[PoseStep]:
    """The steps from the root of an articulation to one of its links, at the initial joint positions.

    Args:
        structure: the articulation.
        link: name of the link.
        scenes: of the articulation.
    """
    at: int | None = next(number for number, one in enumerate(structure.links) if one.name == link)
    steps: list[PoseStep] = []
    while at is not None:
        joint = structure.links[at].joint
        if joint is not None:
            steps = [*steps_across(joint, scenes), *steps]
        at = structure.links[at].parent
    return steps


def link_poses(
    structure: ArticulationStructure, root: NDArray[Any], data_of: Callable[[Value], NDArray[Any]]
) -> list[NDArray[Any]]:
    """Returns the poses (B, 7) of all links, at the initial joint positions.

    Args:
        structure: the articulation.
        root: poses (B, 7) of its root.
        data_of: returns the rows (B, ·) of a pose or a joint position.
    """
    from scenecc.geometry.rotation_arrays import compose  # noqa: PLC0415 - see `step_poses`

    found: list[NDArray[Any]] = []
    for link in structure.links:
        pose = root if link.parent is None else found[link.parent]
        for step in () if link.joint is None else steps_across(link.joint, ()):
            pose = compose(pose, step_poses(step, data_of(step.value)))
        found.append(pose)
    return found


def steps_across(joint: Joint, scenes: tuple[int, ...]) -> list[PoseStep]:
    """The steps from the frame of a joint's parent link to that of its child link."""
    steps: list[PoseStep] = []
    if joint.pose_in_parent is not None:
        steps.append(PoseStep(joint.pose_in_parent, scenes))
    if joint.qpos is not None and joint.type != "fixed":
        steps.append(PoseStep(joint.qpos, scenes, "slide" if joint.type == "prismatic" else "turn"))
    if joint.pose_in_child is not None:
        steps.append(PoseStep(joint.pose_in_child, scenes, back=True))
    return steps


def step_poses(step: PoseStep, data: NDArray[Any]) -> NDArray[Any]:
    """The poses (B, 7) of a step. `data`: its value in each scene, (B, 7) or (B,)."""
    import numpy as np  # noqa: PLC0415 - loaded where something varies

    from scenecc.geometry import rotation_arrays as by_row  # noqa: PLC0415 - see above

    if step.kind == "pose":
        if not step.back:
            return data
        back = by_row.normalized(data[:, 3:]) * np.array((1.0, -1.0, -1.0, -1.0))
        return np.concatenate((0.0 - by_row.rotate(back, data[:, :3]), back + 0.0), axis=1)
    data = -data if step.back else data
    poses = np.tile(np.array(IDENTITY_POSE), (len(data), 1))
    if step.kind == "slide":
        poses[:, 0] = data
    else:
        poses[:, 3], poses[:, 4] = (by_row.map_elements(function, data / 2) for function in (math.cos, math.sin))
    return poses
