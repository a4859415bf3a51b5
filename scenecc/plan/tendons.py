"""The tendon of a mimic joint: a spring with the forces of virtual work.

PhysX divides what a tendon does to a joint by 1 + substep² · stiffness · response of the joint, so a stiff tendon
pulls its joints in the ratio of their inertias, not in that of their coefficients. If source and follower are on
different links, it also acts back on the link above the source instead of the follower's own parent. Both are made up
for here, from the inertia of the built links. Only two joints on one link with equal responses need nothing, and have
SAPIEN's stiff tendon.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def link_dynamics(
    links: list[Any],
) -> tuple[list[int], dict[int, int], list[Any], list[Any], np.ndarray[Any, Any]]:
    """Returns parents, columns, Jacobians, wrenches and inertia of an articulation at position 0.

    Parent: of each link, the index; the root's is 0. Column: of each moving joint in the inertia,
    by its link's index. Jacobian (6, n): of each link, angular velocity and linear velocity at the
    origin of the root's frame. Wrench (6,): of a unit force of each link's joint, moment about this
    origin and force. Inertia (n, n): with armatures; first the root's 6 if it is free, then the
    moving joints.

    Args:
        links: all links, parents first, with their masses and armatures.
    """
    moving = [number for number, link in enumerate(links[1:], 1) if link.joint.type != "fixed"]
    base = 0 if links[0].joint.type == "fixed" else 6
    column = {number: base + index for index, number in enumerate(moving)}
    parents = [0, *(links.index(link.parent) for link in links[1:])]
    frames: list[Any] = []  # of the links, in the root's frame
    jacobians: list[Any] = []
    wrenches: list[Any] = []
    inertia = np.zeros((base + len(moving), base + len(moving)))
    for number, link in enumerate(links):
        frame, jacobian, wrench = np.eye(4), np.zeros((6, len(inertia))), np.zeros(6)
        axis = arm = np.zeros(3)
        jacobian[:, :base] = np.eye(6)[:, :base]
        if number:
            frame = frames[parents[number]] @ link.joint.pose_in_parent.to_transformation_matrix()
            axis, arm = frame[:3, 0], np.cross(frame[:3, 3], frame[:3, 0])
            frame = frame @ link.joint.pose_in_child.inv().to_transformation_matrix()
            jacobian = jacobians[parents[number]].copy()
        if number in column:
            slides = link.joint.type == "prismatic"
            jacobian[:, column[number]] = [0, 0, 0, *axis] if slides else [*axis, *arm]
            wrench = np.array([*arm, *axis] if slides else [*axis, 0, 0, 0])
            inertia[column[number], column[number]] += np.sum(link.joint.armature)
        centre = frame @ link.cmass_local_pose.to_transformation_matrix()
        angular = centre[:3, :3].T @ jacobian[:3]
        linear = jacobian[3:] + np.cross(jacobian[:3].T, centre[:3, 3]).T
        inertia += link.mass * linear.T @ linear + angular.T @ np.diag(link.inertia) @ angular
        frames.append(frame)
        jacobians.append(jacobian)
        wrenches.append(wrench)
    return parents, column, jacobians, wrenches, inertia


def soft_tendon(
    links: list[Any], path: list[int], coefficients: list[float], timestep: float, *, temporal: bool
) -> tuple[list[float], float]:
    """Returns the reciprocal coefficients of a fixed tendon, and its stiffness [N/m or N·m/rad].

    Each joint then feels the tendon's force times its coefficient, as virtual work has it. The
    stretch of the tendon falls by 0.3 of itself for each joint in a substep. Measured at 0.01 s: a
    source with two followers diverges from 1.5 on, the hands of mani_skill from 2 on; at 0.1 their
    joints are 0.04 rad apart under their weight, at 0.3 0.015 rad.

    Args:
        links: all links of the articulation, parents first, with their masses and armatures.
        path: indices of the tendon's links, the common ancestor first.
        coefficients: by link of the path; the first is 0.
        timestep: [s].
        temporal: whether the solver is temporal Gauss-Seidel: each iteration is a substep.
    """
    # Without substeps, the iterations converge on the implicit step only up to some stiffness. Of
    # random pairs at 0.01 s and 10 iterations, a quarter of the step shows 0.001 rad of error in
    # the source and 0.014 rad of stretch (medians); an eighth 0.012 and 0.005, a half 0.001 and
    # 0.055.
    substep = timestep / (links[0].articulation.solver_position_iterations if temporal else 4)
    parents, column, jacobians, wrenches, inertia = link_dynamics(links)

    def branch(number: int) -> int:
        return number if parents[number] == path[0] else branch(parents[number])

    # PhysX pushes the joint's link, and back on the first link of the path, about the axis of the
    # branch's first joint.
    back = jacobians[path[0]].T
    pushes = np.array([jacobians[n].T @ wrenches[n] - back @ wrenches[branch(n)] for n in path[1:]])
    columns = [column[number] for number in path[1:]]
    shares = np.linalg.solve(pushes[:, columns].T, coefficients[1:])
    whole = np.zeros(len(inertia))
    whole[columns] = coefficients[1:]
    responses = np.einsum("ij,ij->i", pushes, np.linalg.solve(inertia, pushes.T).T)
    if all(parents[number] == path[0] for number in path[1:]):
        stiff = 1 + substep**2 * 1e5 * responses
        # SAPIEN's stiff tendon pulls in this ratio. At 1.02 its error is that of the soft one (a
        # thousandth of a radian under the weight of the links), at 1.05 larger.
        if stiff.max() < 1.02 * stiff.min():
            return coefficients, 1e5
    # PhysX divides by at most 1.3, since of stiffness and shares only the stiffness counts. At 1.1
    # the shares are so large that, without substeps, pairs of unequal inertia on one link diverge.
    gain = whole @ np.linalg.solve(inertia, whole) / (0.3 * len(columns))
    divided = max(gain, responses.max() / 0.3)
    shares *= divided / gain
    if temporal:
        shares *= 1 + responses / divided
    return [0.0, *shares.tolist()], float(1 / divided / substep**2)
