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


def soft_tendon(
    links: list[Any], path: list[int], coefficients: list[float], timestep: float, *, temporal: bool
) -> tuple[list[float], float]:
    """Returns the reciprocal coefficients of a fixed tendon, and its stiffness [N/m or N·m/rad].

    Each joint then feels the tendon's force times its coefficient, as virtual work has it. The
    stiffness is the largest that a substep integrates well: the stretch of the tendon falls by 0.3
    of itself in a substep.

    Args:
        links: all links of the articulation, parents first, with their masses and armatures.
        path: indices of the tendon's links, the common ancestor first.
        coefficients: by link of the path; the first is 0.
        timestep: [s].
        temporal: whether the solver is temporal Gauss-Seidel: each iteration is a substep.
    """
    # Without substeps, the iterations converge on the implicit step up to about this stiffness.
    substep = timestep / (links[0].articulation.solver_position_iterations if temporal else 4)
    moving = [number for number, link in enumerate(links[1:], 1) if link.joint.type != "fixed"]
    base = 0 if links[0].joint.type == "fixed" else 6
    column = {number: base + index for index, number in enumerate(moving)}
    parents = [0, *(links.index(link.parent) for link in links[1:])]
    frames: list[Any] = []  # of the links at the zero position, in the root's frame
    # (6, degrees of freedom): angular velocity, linear velocity at the origin
    jacobians: list[Any] = []
    # (6,) of a unit force of the joint: moment about the origin, force
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
    gain = whole @ np.linalg.solve(inertia, whole) / (0.3 * len(columns))
    divided = responses.max() / 0.5
    if all(parents[number] == path[0] for number in path[1:]):
        stiff = 1 + substep**2 * 1e5 * responses
        if stiff.max() < 1.02 * stiff.min():
            return coefficients, 1e5
        # Of stiffness times share, only the stiffness counts in PhysX's division: little of it,
        # and large shares.
        divided = max(gain, responses.max() / 0.05)
        shares *= divided / gain
    gain = max(gain, divided)
    if temporal:
        shares *= 1 + responses / gain
    return [0.0, *shares.tolist()], float(1 / gain / substep**2)
