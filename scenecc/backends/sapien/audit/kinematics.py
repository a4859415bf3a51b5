"""Where the links of an articulation are at its start, by the plan alone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import taken
from scenecc.geometry.rotation_arrays import compose
from scenecc.geometry.rotations import IDENTITY_POSE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from scenecc.plan import ArticulationStructure, Entity, Joint, Value

    Floats = NDArray[np.float64]


def mass_reach(links: Iterable[Any]) -> float:
    """How far from links of the engine their centres of mass are at the most [m]; 1 at the least.

    The engine goes by centres of mass, and knows by as much less where links and joints are.
    """
    return max([1.0, *(float(np.abs(link.cmass_local_pose.p).max()) for link in links)])


def link_poses(entity: Entity, structure: ArticulationStructure, rows: NDArray[np.intp]) -> list[NDArray[np.float32]]:
    """(B, 7) of each link in the world of its scene, in the order of the plan."""
    found: list[Floats] = []
    for link in structure.links:
        if link.parent is None or link.joint is None:
            found.append(_unit(np.broadcast_to(taken(entity.pose, rows), (len(rows), 7))))
            continue
        in_parent = compose(_rows(link.joint.pose_in_parent, rows), _moved(link.joint, rows))
        step = compose(in_parent, _inverse(_rows(link.joint.pose_in_child, rows)))
        found.append(compose(found[link.parent], step))
    return [poses.astype(np.float32) for poses in found]


def _moved(joint: Joint, rows: NDArray[np.intp]) -> Floats:
    """How far the joint's frames are apart."""
    moved = _identity(len(rows))
    if joint.type != "fixed" and joint.qpos is not None:
        qpos = np.broadcast_to(taken(joint.qpos, rows), len(rows))
        if joint.type == "prismatic":
            moved[:, 0] = qpos
        else:
            moved[:, 3], moved[:, 4] = np.cos(qpos / 2), np.sin(qpos / 2)
    return moved


def _rows(pose: Value | None, rows: NDArray[np.intp]) -> Floats:
    if pose is None:
        return _identity(len(rows))
    return _unit(np.broadcast_to(taken(pose, rows), (len(rows), 7)))


def _identity(count: int) -> Floats:
    return np.tile(IDENTITY_POSE, (count, 1))


def _unit(poses: Floats) -> Floats:
    """With quaternions of unit length, as the engine has them."""
    found = poses.copy()
    found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
    return found


def _inverse(poses: Floats) -> Floats:
    turned = poses * [0, 0, 0, 1, -1, -1, -1]
    back = compose(turned, poses * [1, 1, 1, 0, 0, 0, 0] + [0, 0, 0, 1, 0, 0, 0])
    back[:, :3] *= -1
    back[:, 3:] = turned[:, 3:]
    return back
