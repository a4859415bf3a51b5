# A script of plain SAPIEN calls, written by scenecc.
#
# fastened: 2 parallel scenes.
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
CHECKER = HERE / "../../scenes/assets/checker.png"
FILES = [MUG, BOWL, CHECKER]


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

    shared_physical = physx.PhysxMaterial(
        static_friction=0.9,
        dynamic_friction=0.8,
        restitution=0.05,
    )

    if render:
        shared_look = sapien.render.RenderMaterial(base_color=[0.8, 0.1, 0.1, 1])

    # Bodies that constraints, lights and cameras are attached to, by scene and name.
    held = {}

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

    # arm_0
    for scene in scenes:
        builder = scene.create_articulation_builder()
        builder.initial_pose = sapien.Pose([0, 0, 0.05])
        base = builder.create_link_builder()
        base.set_name("base")
        base.collision_groups = [1, 1, 0, 0]
        base.add_box_collision(half_size=[0.1, 0.1, 0.05])
        upper = builder.create_link_builder(base)
        upper.set_name("upper")
        upper.set_joint_name("shoulder")
        upper.set_joint_properties(
            type="revolute",
            limits=[-1.5, 1.5],
            pose_in_parent=sapien.Pose([0.2, 0, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
        )
        upper.collision_groups = [1, 1, 0, 0]
        upper.add_capsule_collision(
            pose=sapien.Pose([0.1, 0, 0]),
            radius=0.02,
            half_length=0.1,
            material=shared_physical,
            density=500,
        )
        if render:
            upper.add_capsule_visual(
                pose=sapien.Pose([0.1, 0, 0]),
                radius=0.02,
                half_length=0.1,
                material=shared_look,
            )
        lower = builder.create_link_builder(upper)
        lower.set_name("lower")
        lower.set_joint_name("elbow")
        lower.set_joint_properties(
            type="revolute",
            limits=[-1.5, 1.5],
            pose_in_parent=sapien.Pose([0.2, 0, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
        )
        lower.collision_groups = [1, 1, 0, 0]
        lower.add_capsule_collision(
            pose=sapien.Pose([0.08, 0, 0]),
            radius=0.02,
            half_length=0.08,
            material=shared_physical,
            density=500,
        )
        if render:
            lower.add_capsule_visual(
                pose=sapien.Pose([0.08, 0, 0]),
                radius=0.02,
                half_length=0.08,
                material=shared_look,
            )
        camera = builder.create_link_builder(base)
        camera.set_name("camera")
        camera.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose([0.1, 0, 0], [0.7071068, 0, 0.7071068, 0]),
            pose_in_child=sapien.Pose(),
        )
        camera.collision_groups = [1, 1, 0, 0]
        camera.set_mass_and_inertia(0.05, sapien.Pose([0, 0, 0]), [0.0001, 0.0001, 0.0001])
        hand = builder.create_link_builder(lower)
        hand.set_name("hand")
        hand.set_joint_name("wrist")
        hand.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose(),
            pose_in_child=sapien.Pose(),
        )
        hand.collision_groups = [1, 1, 0, 0]
        hand.add_box_collision(half_size=[0.02, 0.06, 0.02])
        left = builder.create_link_builder(hand)
        left.set_name("left")
        left.set_joint_name("left slide")
        left.set_joint_properties(
            type="prismatic",
            limits=[0, 0.04],
            pose_in_parent=sapien.Pose([0.1, 0.01, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
        )
        left.collision_groups = [1, 1, 0, 0]
        left.add_box_collision(half_size=[0.03, 0.01, 0.01], patch_radius=0.1)
        right = builder.create_link_builder(hand)
        right.set_name("right")
        right.set_joint_name("right slide")
        right.set_joint_properties(
            type="prismatic",
            limits=[0, 0.04],
            pose_in_parent=sapien.Pose([0.1, -0.01, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
            damping=5,
        )
        right.collision_groups = [1, 1, 0, 0]
        right.add_box_collision(half_size=[0.03, 0.01, 0.01], patch_radius=0.1)
        entities = builder.build_entities(fix_root_link=True)
        component = physx.PhysxArticulationLinkComponent
        links = [entity.find_component_by_type(component) for entity in entities]
        articulation = links[0].articulation
        body = articulation.find_link_by_name("base")
        body.disable_gravity = True
        body = articulation.find_link_by_name("upper")
        body.disable_gravity = True
        body = articulation.find_link_by_name("lower")
        body.disable_gravity = True
        body = articulation.find_link_by_name("camera")
        body.disable_gravity = True
        body = articulation.find_link_by_name("hand")
        body.disable_gravity = True
        body = articulation.find_link_by_name("left")
        body.disable_gravity = True
        body = articulation.find_link_by_name("right")
        body.disable_gravity = True
        articulation.solver_position_iterations = 15
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_properties(stiffness=200, damping=20, force_limit=50)
        joint.friction = 0.1
        joint.armature = [0.05]
        joint = articulation.find_joint_by_name("elbow")
        joint.set_drive_properties(stiffness=200, damping=20, force_limit=50)
        joint.friction = 0.1
        joint.armature = [0.05]
        joint.max_velocity = 3
        joint = articulation.find_joint_by_name("left slide")
        joint.set_drive_properties(stiffness=200, damping=20, mode="acceleration")
        # right slide follows left slide: SAPIEN's own mimic joints pull with wrong forces.
        coefficients = [0, -0.5, 1]
        shares, stiffness = soft_tendon(
            links,
            [4, 5, 6],
            coefficients,
            scene.timestep,
            temporal=physx.get_scene_config().enable_tgs,
        )
        articulation.create_fixed_tendon(
            [links[4], links[5], links[6]],
            coefficients,
            shares,
            rest_length=0,
            stiffness=stiffness,
        )
        for entity in entities:
            scene.add_entity(entity)
        articulation.name = "arm_0"
        articulation.qpos = [0.3, -0.4, 0.03, 0.015]
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_target(0.3)
        joint = articulation.find_joint_by_name("elbow")
        joint.set_drive_target(-0.4)
        joint = articulation.find_joint_by_name("left slide")
        joint.set_drive_target(0.03)
        held[scene, "arm_0", "hand"] = articulation.find_link_by_name("hand").entity

    # arm_1
    for scene in scenes:
        builder = scene.create_articulation_builder()
        builder.initial_pose = sapien.Pose([0, 1, 0.05])
        base = builder.create_link_builder()
        base.set_name("base")
        base.collision_groups = [1, 1, 0, 0]
        base.add_box_collision(half_size=[0.1, 0.1, 0.05])
        upper = builder.create_link_builder(base)
        upper.set_name("upper")
        upper.set_joint_name("shoulder")
        upper.set_joint_properties(
            type="revolute",
            limits=[-1.5, 1.5],
            pose_in_parent=sapien.Pose([0.2, 0, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
        )
        upper.collision_groups = [1, 1, 0, 0]
        upper.add_capsule_collision(
            pose=sapien.Pose([0.1, 0, 0]),
            radius=0.02,
            half_length=0.1,
            material=shared_physical,
            density=500,
        )
        if render:
            upper.add_capsule_visual(
                pose=sapien.Pose([0.1, 0, 0]),
                radius=0.02,
                half_length=0.1,
                material=shared_look,
            )
        lower = builder.create_link_builder(upper)
        lower.set_name("lower")
        lower.set_joint_name("elbow")
        lower.set_joint_properties(
            type="revolute",
            limits=[-1.5, 1.5],
            pose_in_parent=sapien.Pose([0.2, 0, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
        )
        lower.collision_groups = [1, 1, 0, 0]
        lower.add_capsule_collision(
            pose=sapien.Pose([0.08, 0, 0]),
            radius=0.02,
            half_length=0.08,
            material=shared_physical,
            density=500,
        )
        if render:
            lower.add_capsule_visual(
                pose=sapien.Pose([0.08, 0, 0]),
                radius=0.02,
                half_length=0.08,
                material=shared_look,
            )
        camera = builder.create_link_builder(base)
        camera.set_name("camera")
        camera.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose([0.1, 0, 0], [0.7071068, 0, 0.7071068, 0]),
            pose_in_child=sapien.Pose(),
        )
        camera.collision_groups = [1, 1, 0, 0]
        camera.set_mass_and_inertia(0.05, sapien.Pose([0, 0, 0]), [0.0001, 0.0001, 0.0001])
        hand = builder.create_link_builder(lower)
        hand.set_name("hand")
        hand.set_joint_name("wrist")
        hand.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose(),
            pose_in_child=sapien.Pose(),
        )
        hand.collision_groups = [1, 1, 0, 0]
        hand.add_box_collision(half_size=[0.02, 0.06, 0.02])
        left = builder.create_link_builder(hand)
        left.set_name("left")
        left.set_joint_name("left slide")
        left.set_joint_properties(
            type="prismatic",
            limits=[0, 0.04],
            pose_in_parent=sapien.Pose([0.1, 0.01, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
        )
        left.collision_groups = [1, 1, 0, 0]
        left.add_box_collision(half_size=[0.03, 0.01, 0.01], patch_radius=0.1)
        right = builder.create_link_builder(hand)
        right.set_name("right")
        right.set_joint_name("right slide")
        right.set_joint_properties(
            type="prismatic",
            limits=[0, 0.04],
            pose_in_parent=sapien.Pose([0.1, -0.01, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071068, 0, 0, 0.7071068]),
            damping=5,
        )
        right.collision_groups = [1, 1, 0, 0]
        right.add_box_collision(half_size=[0.03, 0.01, 0.01], patch_radius=0.1)
        entities = builder.build_entities(fix_root_link=True)
        component = physx.PhysxArticulationLinkComponent
        links = [entity.find_component_by_type(component) for entity in entities]
        articulation = links[0].articulation
        body = articulation.find_link_by_name("base")
        body.disable_gravity = True
        body = articulation.find_link_by_name("upper")
        body.disable_gravity = True
        body = articulation.find_link_by_name("lower")
        body.disable_gravity = True
        body = articulation.find_link_by_name("camera")
        body.disable_gravity = True
        body = articulation.find_link_by_name("hand")
        body.disable_gravity = True
        body = articulation.find_link_by_name("left")
        body.disable_gravity = True
        body = articulation.find_link_by_name("right")
        body.disable_gravity = True
        articulation.solver_position_iterations = 15
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_properties(stiffness=200, damping=20, force_limit=50)
        joint.friction = 0.1
        joint.armature = [0.05]
        joint = articulation.find_joint_by_name("elbow")
        joint.set_drive_properties(stiffness=200, damping=20, force_limit=50)
        joint.friction = 0.1
        joint.armature = [0.05]
        joint.max_velocity = 3
        joint = articulation.find_joint_by_name("left slide")
        joint.set_drive_properties(stiffness=200, damping=20, mode="acceleration")
        # right slide follows left slide: SAPIEN's own mimic joints pull with wrong forces.
        coefficients = [0, -0.5, 1]
        shares, stiffness = soft_tendon(
            links,
            [4, 5, 6],
            coefficients,
            scene.timestep,
            temporal=physx.get_scene_config().enable_tgs,
        )
        articulation.create_fixed_tendon(
            [links[4], links[5], links[6]],
            coefficients,
            shares,
            rest_length=0,
            stiffness=stiffness,
        )
        for entity in entities:
            scene.add_entity(entity)
        articulation.name = "arm_1"
        articulation.qpos = [0.3, -0.4, 0.03, 0.015]
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_target(0.3)
        joint = articulation.find_joint_by_name("elbow")
        joint.set_drive_target(-0.4)
        joint = articulation.find_joint_by_name("left slide")
        joint.set_drive_target(0.03)

    # block_0
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05])
        builder.initial_pose = sapien.Pose([0, 0.5, 0.3])
        entity = builder.build(name="block_0")
        held[scene, "block_0"] = entity

    # block_1
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05])
        builder.initial_pose = sapien.Pose([0.5, 0.5, 0.3])
        entity = builder.build(name="block_1")
        held[scene, "block_1"] = entity

    # block_2
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05])
        builder.initial_pose = sapien.Pose([1, 0.5, 0.3])
        entity = builder.build(name="block_2")
        held[scene, "block_2"] = entity

    # crawler
    crawler_damping = [1, 2]
    crawler_mass = [0.1, 0.2]
    crawler_linear_damping = [0.1, 0.5]
    crawler_angular_velocity = [[0, 0, 1], [0, 0, -1]]
    for i, scene in enumerate(scenes):
        builder = scene.create_articulation_builder()
        builder.initial_pose = sapien.Pose([2, 0, 0.3])
        trunk = builder.create_link_builder()
        trunk.set_name("trunk")
        trunk.add_box_collision(half_size=[0.1, 0.05, 0.05])
        if render:
            trunk.add_box_visual(half_size=[0.1, 0.05, 0.05])
        leg_1 = builder.create_link_builder(trunk)
        leg_1.set_name("leg -1")
        leg_1.set_joint_properties(
            type="revolute",
            limits=[float("-inf"), float("inf")],
            pose_in_parent=sapien.Pose([0, -0.1, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose(),
        )
        leg_1.add_capsule_collision(
            pose=sapien.Pose([0.1, 0, 0]),
            radius=0.02,
            half_length=0.1,
            material=shared_physical,
            density=500,
        )
        if render:
            leg_1.add_capsule_visual(
                pose=sapien.Pose([0.1, 0, 0]),
                radius=0.02,
                half_length=0.1,
                material=shared_look,
            )
        leg_1_2 = builder.create_link_builder(trunk)
        leg_1_2.set_name("leg 1")
        leg_1_2.set_joint_properties(
            type="revolute",
            limits=[float("-inf"), float("inf")],
            pose_in_parent=sapien.Pose([0, 0.1, 0], [0.7071068, 0, 0, 0.7071068]),
            pose_in_child=sapien.Pose(),
        )
        leg_1_2.add_capsule_collision(
            pose=sapien.Pose([0.1, 0, 0]),
            radius=0.02,
            half_length=0.1,
            material=shared_physical,
            density=500,
        )
        if render:
            leg_1_2.add_capsule_visual(
                pose=sapien.Pose([0.1, 0, 0]),
                radius=0.02,
                half_length=0.1,
                material=shared_look,
            )
        foot = builder.create_link_builder(leg_1_2)
        foot.set_name("foot")
        foot.set_joint_properties(
            type="prismatic",
            limits=[-0.01, float("inf")],
            pose_in_parent=sapien.Pose([0.2, 0, 0]),
            pose_in_child=sapien.Pose(),
            damping=crawler_damping[i],
        )
        foot.add_sphere_collision(radius=0.03)
        tail = builder.create_link_builder(trunk)
        tail.set_name("tail")
        tail.set_joint_name("tail")
        tail.set_joint_properties(
            type="revolute_unwrapped",
            limits=[float("-inf"), float("inf")],
            pose_in_parent=sapien.Pose([-0.1, 0, 0]),
            pose_in_child=sapien.Pose(),
        )
        tail.add_capsule_collision(
            pose=sapien.Pose([0.05, 0, 0]),
            radius=0.02,
            half_length=0.05,
            material=shared_physical,
            density=500,
        )
        if render:
            tail.add_capsule_visual(
                pose=sapien.Pose([0.05, 0, 0]),
                radius=0.02,
                half_length=0.05,
                material=shared_look,
            )
        articulation = builder.build()
        articulation.name = "crawler"
        body = articulation.find_link_by_name("trunk")
        body.collision_shapes[0].contact_offset = 0.02
        body.collision_shapes[0].rest_offset = 0.001
        body.max_linear_velocity = 5
        if render:
            look = body.entity.find_component_by_type(sapien.render.RenderBodyComponent)
            look.visibility = 0.5
        body = articulation.find_link_by_name("leg -1")
        body.inertia = body.inertia.astype(float) * (crawler_mass[i] / body.mass)
        body.mass = crawler_mass[i]
        body.linear_damping = crawler_linear_damping[i]
        body = articulation.find_link_by_name("leg 1")
        body.inertia = body.inertia.astype(float) * (crawler_mass[i] / body.mass)
        body.mass = crawler_mass[i]
        body.linear_damping = crawler_linear_damping[i]
        body = articulation.find_link_by_name("tail")
        body.angular_damping = 0.2
        articulation.solver_velocity_iterations = 2
        articulation.sleep_threshold = 0.001
        joint = articulation.find_joint_by_name("tail")
        joint.set_drive_properties(stiffness=0, damping=1, force_limit=crawler_damping[i])
        articulation.root_linear_velocity = [0.2, 0, 1]
        articulation.root_angular_velocity = crawler_angular_velocity[i]
        articulation.qpos = [0, 0, 0, 0]
        articulation.qvel = [-1, 1, 0, 0]
        joint = articulation.find_joint_by_name("tail")
        joint.set_drive_velocity_target(2)
        held[scene, "crawler", "trunk"] = articulation.find_link_by_name("trunk").entity

    # ball
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05)
        builder.initial_pose = sapien.Pose([2, 0.3, 0.3])
        entity = builder.build(name="ball")
        held[scene, "ball"] = entity

    # held
    for scene in scenes:
        constraint = scene.create_drive(
            held[scene, "arm_0", "hand"],
            sapien.Pose([0.05, 0, 0]),
            held[scene, "block_0"],
            sapien.Pose(),
        )
        constraint.name = "held"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)
        constraint.set_limit_twist(0, 0)
        # A drive's swing limits have no effect, so a stiff spring holds the swing.
        constraint.set_drive_property_swing(10000000000.0, 10000, mode="acceleration")

    # hung
    hung_pose_in_parent = [sapien.Pose([1, 0, 0.5]), sapien.Pose([1, 0, 0.6])]
    for i, scene in enumerate(scenes):
        constraint = scene.create_connection(
            None,
            hung_pose_in_parent[i],
            held[scene, "block_1"],
            sapien.Pose([0, 0, 0.1]),
        )
        constraint.name = "hung"

    # tied
    scene = scenes[1]
    constraint = scene.create_connection(
        held[scene, "block_2"],
        sapien.Pose(),
        held[scene, "ball"],
        sapien.Pose(),
    )
    constraint.name = "tied"
    constraint.set_limit(0.1, 0.3, 20, 1)

    # pulled
    pulled_low_y = [0, -0.1]
    pulled_high_y = [0, 0.2]
    pulled_damping_z = [5, 10]
    for i, scene in enumerate(scenes):
        constraint = scene.create_drive(
            held[scene, "ball"],
            sapien.Pose(),
            held[scene, "crawler", "trunk"],
            sapien.Pose(),
        )
        constraint.name = "pulled"
        constraint.set_limit_x(-0.1, 0.1)
        constraint.set_limit_y(pulled_low_y[i], pulled_high_y[i])
        constraint.set_drive_property_z(50, pulled_damping_z[i], 20)
        constraint.set_drive_property_slerp(1, 0.1, mode="acceleration")
        constraint.set_drive_target(sapien.Pose([0, 0, 0.1]))
        constraint.set_drive_velocity_target([0, 0, 0.1], [0, 0, 0.2])

    if render:
        # Surroundings
        environment_ambient_light = [[0.1, 0.1, 0.1], [0.2, 0.2, 0.3]]
        for i, scene in enumerate(scenes):
            scene.set_ambient_light(environment_ambient_light[i])

    if render:
        # sun
        sun_color = [[1, 1, 1], [1, 0.5, 0.5]]
        for i, scene in enumerate(scenes):
            light = sapien.render.RenderDirectionalLightComponent()
            light.color = sun_color[i]
            light.shadow = False
            light.shadow_near = -10
            light.shadow_far = 10
            light.shadow_half_size = 10
            light.shadow_map_size = 2048
            light.name = "sun"
            entity = sapien.Entity()
            entity.name = "sun"
            entity.add_component(light)
            entity.set_pose(sapien.Pose([0, 0, 0], [0.7071068, 0, 0.7071068, 0]))
            scene.add_entity(entity)

        # lamp
        scene = scenes[1]
        light = sapien.render.RenderPointLightComponent()
        light.color = [1, 1, 1]
        light.shadow = True
        light.shadow_near = 0.5
        light.shadow_far = 20
        light.shadow_map_size = 1024
        light.name = "lamp"
        entity = sapien.Entity()
        entity.name = "lamp"
        entity.add_component(light)
        entity.set_pose(sapien.Pose([0, 0, 2]))
        scene.add_entity(entity)

        # torch
        for scene in scenes:
            light = sapien.render.RenderSpotLightComponent()
            light.color = [2, 2, 2]
            light.shadow = True
            light.shadow_near = 0.5
            light.shadow_far = 20
            light.shadow_map_size = 1024
            light.inner_fov = 0.5
            light.outer_fov = 1
            light.name = "torch"
            held[scene, "arm_0", "hand"].add_component(light)
            light.local_pose = sapien.Pose([0, 0, 0.1])

        # projector
        for scene in scenes:
            light = sapien.render.RenderTexturedLightComponent()
            light.color = [1, 1, 1]
            light.shadow = False
            light.shadow_near = 0.1
            light.shadow_far = 10
            light.shadow_map_size = 2048
            light.inner_fov = 0.5
            light.outer_fov = 1
            light.texture = sapien.render.RenderTexture2D(str(CHECKER))
            light.name = "projector"
            entity = sapien.Entity()
            entity.name = "projector"
            entity.add_component(light)
            entity.set_pose(sapien.Pose([0, 0, 3], [0.7071068, 0, 0.7071068, 0]))
            scene.add_entity(entity)

    if render:
        # front
        front_fovy = [1, 1.2]
        front_pose = [sapien.Pose([-1, 0, 0.5]), sapien.Pose([-1, 0, 0.6])]
        for i, scene in enumerate(scenes):
            camera = sapien.render.RenderCameraComponent(64, 48)
            camera.set_fovy(front_fovy[i], compute_x=True)
            camera.near = 0.01
            camera.far = 10
            camera.name = "front"
            entity = sapien.Entity()
            entity.name = "front"
            entity.add_component(camera)
            entity.set_pose(front_pose[i])
            scene.add_entity(entity)

        # wrist
        for scene in scenes:
            camera = sapien.render.RenderCameraComponent(64, 48)
            camera.set_perspective_parameters(0.01, 10, 60, 60, 32, 24, 0)
            camera.name = "wrist"
            held[scene, "arm_0", "hand"].add_component(camera)
            camera.local_pose = sapien.Pose([0, 0, 0.05])

        # top
        scene = scenes[0]
        camera = sapien.render.RenderCameraComponent(
            64,
            48,
            sapien.__path__[0] + "/vulkan_shader/minimal",
        )
        camera.name = "top"
        entity = sapien.Entity()
        entity.name = "top"
        entity.add_component(camera)
        entity.set_pose(sapien.Pose([0, 0, 3], [0.7071068, 0, 0.7071068, 0]))
        scene.add_entity(entity)
        top = 1
        right = top * 64 / 48
        camera.set_orthographic_parameters(0.01, 10, -right, right, -top, top)

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
