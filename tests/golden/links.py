# A script of plain SAPIEN calls, written by scenecc.
#
# links: 2 parallel scenes.
#
# Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.
# It finds its files relative to its own folder: move it together with them, or emit it again.

from pathlib import Path
from typing import Any

import numpy as np
import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
MUG = HERE / "../../scenes/assets/mug.obj"
BOWL = HERE / "../../scenes/assets/bowl.obj"
FILES = [MUG, BOWL]


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


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 2 parallel scenes. `render`: also build visuals."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    scenes: list[sapien.Scene] = []
    for _ in range(2):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    chest_physical = physx.PhysxMaterial(static_friction=0.5, dynamic_friction=0.4, restitution=0.1)

    if render:
        chest_look = sapien.render.RenderMaterial(base_color=[0.1, 0.1, 0.8, 1])

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]))
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]),
                scale=[10, 10, 10],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # chest
    chest_damping = [0.1, 0.5]
    chest_pose = [sapien.Pose([0, 0, 0.4]), sapien.Pose([0, 0, 0.5])]
    chest_coefficients = [[0, -1, 0.5], [0, 1, 1]]
    chest_rest_length = [0, 0.1]
    chest_qpos = [[0, 0.2, 0.4], [0, 0.2, -0.1]]
    for i, scene in enumerate(scenes):
        entities, links = [], []
        entity = sapien.Entity()
        body = physx.PhysxArticulationLinkComponent()
        body.name = "box"
        parts = physx.PhysxCollisionShapeConvexMesh.load_multiple(
            filename=str(MUG),
            scale=[1, 1, 1],
            material=physx.get_default_material(),
        )
        for shape in parts:
            shape.contact_offset = 0.02
            body.attach(shape)
        body.inertia = body.inertia.astype(float) * (2 / body.mass)
        body.mass = 2
        body.linear_damping = 0.1
        entity.add_component(body)
        entity.name = "box"
        entities.append(entity)
        links.append(body)
        entity = sapien.Entity()
        body = physx.PhysxArticulationLinkComponent(links[0])
        body.name = "lid"
        shape = physx.PhysxCollisionShapeTriangleMesh(
            filename=str(BOWL),
            scale=[1, 1, 1],
            material=physx.get_default_material(),
            sdf=False,
        )
        shape.local_pose = sapien.Pose([0.1, 0, 0])
        body.attach(shape)
        body.mass = 0.5
        body.cmass_local_pose = sapien.Pose([0.1, 0, 0])
        body.inertia = [0.01, 0.01, 0.01]
        entity.add_component(body)
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "lid"
            shape = sapien.render.RenderShapeTriangleMesh(filename=str(BOWL), scale=[1, -1, 1])
            shape.set_front_face("clockwise")
            look.attach(shape)
            shape = sapien.render.RenderShapeTriangleMesh(
                vertices=[[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]],
                triangles=[[0, 1, 2], [0, 2, 3]],
                normals=[[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]],
                uvs=[[-0.5, -0.5], [1.5, -0.5], [1.5, 1.5], [-0.5, 1.5]],
                material=sapien.render.RenderMaterial(),
            )
            shape.set_front_face("clockwise")
            look.attach(shape)
            look.visibility = 0.7
            entity.add_component(look)
        entity.name = "lid"
        joint = body.joint
        joint.name = "lid"
        joint.type = "revolute"
        joint.pose_in_child = sapien.Pose([0, 0, 0])
        joint.pose_in_parent = sapien.Pose([0.1, 0, 0], [0.7071068, 0, 0.7071068, 0])
        joint.limit = [0, 1]
        joint.set_drive_properties(stiffness=0, damping=chest_damping[i])
        entities.append(entity)
        links.append(body)
        entity = sapien.Entity()
        body = physx.PhysxArticulationLinkComponent(links[0])
        body.name = "knob"
        shape = physx.PhysxCollisionShapeCapsule(
            radius=0.02,
            half_length=0.03,
            material=chest_physical,
        )
        shape.local_pose = sapien.Pose([0.03, 0, 0])
        shape.density = 500
        body.attach(shape)
        entity.add_component(body)
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "knob"
            shape = sapien.render.RenderShapeCapsule(
                radius=0.02,
                half_length=0.03,
                material=chest_look,
            )
            shape.local_pose = sapien.Pose([0.03, 0, 0])
            look.attach(shape)
            entity.add_component(look)
        entity.name = "knob"
        joint = body.joint
        joint.name = "knob"
        joint.type = "revolute"
        joint.pose_in_child = sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068])
        joint.pose_in_parent = sapien.Pose([0.2, 0, 0], [0.7071068, 0, 0, 0.7071068])
        joint.limit = [-1.5, 1.5]
        entities.append(entity)
        links.append(body)
        entity = sapien.Entity()
        body = physx.PhysxArticulationLinkComponent(links[0])
        body.name = "wheel"
        shape = physx.PhysxCollisionShapeCapsule(
            radius=0.02,
            half_length=0.04,
            material=chest_physical,
        )
        shape.local_pose = sapien.Pose([0.04, 0, 0])
        shape.density = 500
        body.attach(shape)
        entity.add_component(body)
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "wheel"
            shape = sapien.render.RenderShapeCapsule(
                radius=0.02,
                half_length=0.04,
                material=chest_look,
            )
            shape.local_pose = sapien.Pose([0.04, 0, 0])
            look.attach(shape)
            entity.add_component(look)
        entity.name = "wheel"
        joint = body.joint
        joint.name = "wheel"
        joint.type = "revolute"
        joint.pose_in_child = sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068])
        joint.pose_in_parent = sapien.Pose([0.2, 0, 0], [0.7071068, 0, 0, 0.7071068])
        joint.limit = [float("-inf"), float("inf")]
        joint.set_drive_properties(stiffness=0, damping=0)
        entities.append(entity)
        links.append(body)
        entity = sapien.Entity()
        body = physx.PhysxArticulationLinkComponent(links[1])
        body.name = "mark"
        body.mass = 0.05
        body.cmass_local_pose = sapien.Pose([0, 0, 0])
        body.inertia = [0.0001, 0.0001, 0.0001]
        entity.add_component(body)
        entity.name = "mark"
        joint = body.joint
        joint.type = "fixed"
        joint.pose_in_child = sapien.Pose()
        joint.pose_in_parent = sapien.Pose()
        entities.append(entity)
        links.append(body)
        entities[0].pose = chest_pose[i]
        articulation = links[0].articulation
        joint = articulation.find_joint_by_name("knob")
        joint.set_drive_properties(stiffness=5, damping=1)
        # wheel follows knob: SAPIEN's own mimic joints pull with wrong forces.
        coefficients = chest_coefficients[i]
        shares, stiffness = soft_tendon(
            links,
            [0, 2, 3],
            coefficients,
            scene.timestep,
            temporal=physx.get_scene_config().enable_tgs,
        )
        articulation.create_fixed_tendon(
            [links[0], links[2], links[3]],
            coefficients,
            shares,
            rest_length=chest_rest_length[i],
            stiffness=stiffness,
        )
        for entity in entities:
            scene.add_entity(entity)
        articulation.name = "chest"
        articulation.qpos = chest_qpos[i]
        joint = articulation.find_joint_by_name("knob")
        joint.set_drive_target(0.2)

    # still
    scene = scenes[1]
    entities, links = [], []
    entity = sapien.Entity()
    body = physx.PhysxArticulationLinkComponent()
    body.name = "only"
    parts = physx.PhysxCollisionShapeConvexMesh.load_multiple(
        filename=str(MUG),
        scale=[1, 1, 1],
        material=physx.get_default_material(),
    )
    for shape in parts:
        shape.set_collision_groups([1, 1, 2, 0])
        shape.contact_offset = 0.02
        body.attach(shape)
    entity.add_component(body)
    entity.name = "only"
    entities.append(entity)
    links.append(body)
    links[0].joint.type = "fixed"
    entities[0].pose = sapien.Pose([1, 0, 0.4])
    articulation = links[0].articulation
    for entity in entities:
        scene.add_entity(entity)
    articulation.name = "still"
    articulation.root_pose = articulation.root_pose

    return scenes


def main() -> None:
    """Simulates 100 steps and prints the poses of all entities in the first scene."""
    scenes = build_scenes()
    for _ in range(100):
        for scene in scenes:
            scene.step()
    for entity in scenes[0].entities:
        print(entity.name, entity.pose.p, entity.pose.q)


if __name__ == "__main__":
    main()
