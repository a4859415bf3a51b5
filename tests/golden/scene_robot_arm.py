# A script of plain SAPIEN calls, written by scenecc.
#
# robot_arm: 2 parallel scenes.
# Arms from a URDF: one bolted to the ground and driven, and one that tumbles.
# Two robots that each ignore their own links do collide with one another.
#
# Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.
# Values that a reset would draw again are those of seed 0.

import sapien
from sapien import physx


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 2 parallel scenes. `render`: also build visuals."""
    scenes: list[sapien.Scene] = []
    for _ in range(2):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    arm_physical = physx.PhysxMaterial(static_friction=1, dynamic_friction=0.9, restitution=0)

    if render:
        shared_look = sapien.render.RenderMaterial(base_color=[0.5, 0.5, 0.5, 1])

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        )
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
                scale=[10, 10, 10],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # arm
    # From ../../scenes/robots/arm.urdf.
    arm_qpos = [[0.22197205672905634, 0.8], [0.23421379849852206, 0.8]]
    arm_drive_target = [0.22197205672905634, 0.23421379849852206]
    for i, scene in enumerate(scenes):
        builder = scene.create_articulation_builder()
        builder.initial_pose = sapien.Pose([0, 0, 0.05])
        base = builder.create_link_builder()
        base.set_name("base")
        base.collision_groups = [1, 1, 536870912, 0]
        base.add_box_collision(half_size=[0.1, 0.1, 0.05])
        if render:
            base.add_box_visual(half_size=[0.1, 0.1, 0.05], material=shared_look, name="foot")
        upper = builder.create_link_builder(base)
        upper.set_name("upper")
        upper.set_joint_name("shoulder")
        upper.set_joint_properties(
            type="revolute_unwrapped",
            limits=[-1.5, 1.5],
            pose_in_parent=sapien.Pose([0, 0, 0.05000000074505806], [-0.5, 0.5, 0.5, -0.5]),
            pose_in_child=sapien.Pose([0, 0, 0], [-0.5, 0.5, 0.5, -0.5]),
        )
        upper.collision_groups = [1, 1, 536870912, 0]
        upper.add_cylinder_collision(
            pose=sapien.Pose(
                [0, 0, 0.20000000298023224],
                [0.7071068286895752, 0, 0.7071068286895752, 0],
            ),
            radius=0.04,
            half_length=0.2,
        )
        upper.set_mass_and_inertia(
            1.5,
            sapien.Pose([0, 0, 0.20000000298023224]),
            [0.02, 0.02, 0.002],
        )
        lower = builder.create_link_builder(upper)
        lower.set_name("lower")
        lower.set_joint_name("elbow")
        lower.set_joint_properties(
            type="revolute_unwrapped",
            limits=[0.1, 2.5],
            pose_in_parent=sapien.Pose([0, 0, 0.4000000059604645], [-0.5, 0.5, 0.5, -0.5]),
            pose_in_child=sapien.Pose([0, 0, 0], [-0.5, 0.5, 0.5, -0.5]),
        )
        lower.collision_groups = [1, 1, 536870912, 0]
        lower.add_box_collision(
            pose=sapien.Pose([0, 0, 0.15000000596046448]),
            half_size=[0.03, 0.03, 0.15],
            material=arm_physical,
        )
        tip = builder.create_link_builder(lower)
        tip.set_name("tip")
        tip.set_joint_name("tool")
        tip.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose([0, 0, 0.30000001192092896], [0, 1, 0, 0]),
            pose_in_child=sapien.Pose([0, 0, 0], [0, 1, 0, 0]),
        )
        articulation = builder.build(fix_root_link=True)
        articulation.name = "arm"
        body = articulation.find_link_by_name("lower")
        body.disable_gravity = True
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_properties(stiffness=200, damping=20, force_limit=50)
        joint.max_velocity = 2
        joint = articulation.find_joint_by_name("elbow")
        joint.set_drive_properties(stiffness=200, damping=20, force_limit=10)
        joint.max_velocity = 3
        articulation.qpos = arm_qpos[i]
        joint = articulation.find_joint_by_name("shoulder")
        joint.set_drive_target(arm_drive_target[i])
        joint = articulation.find_joint_by_name("elbow")
        joint.set_drive_target(1.2)

    # tumbling
    # From ../../scenes/robots/arm.urdf.
    tumbling_pose = [
        sapien.Pose([0.1, 0, 1.0256972010337972], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.1, 0, 1.3588445582515618], [0.7071067811865476, 0, 0.7071067811865475, 0]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_articulation_builder()
        builder.initial_pose = tumbling_pose[i]
        base = builder.create_link_builder()
        base.set_name("base")
        base.collision_groups = [1, 1, 536870912, 1]
        base.add_box_collision(half_size=[0.1, 0.1, 0.05])
        if render:
            base.add_box_visual(half_size=[0.1, 0.1, 0.05], material=shared_look, name="foot")
        upper = builder.create_link_builder(base)
        upper.set_name("upper")
        upper.set_joint_name("shoulder")
        upper.set_joint_properties(
            type="revolute_unwrapped",
            limits=[-1.5, 1.5],
            pose_in_parent=sapien.Pose([0, 0, 0.05000000074505806], [-0.5, 0.5, 0.5, -0.5]),
            pose_in_child=sapien.Pose([0, 0, 0], [-0.5, 0.5, 0.5, -0.5]),
            damping=0.5,
        )
        upper.collision_groups = [1, 1, 536870912, 1]
        upper.add_cylinder_collision(
            pose=sapien.Pose(
                [0, 0, 0.20000000298023224],
                [0.7071068286895752, 0, 0.7071068286895752, 0],
            ),
            radius=0.04,
            half_length=0.2,
        )
        upper.set_mass_and_inertia(
            1.5,
            sapien.Pose([0, 0, 0.20000000298023224]),
            [0.02, 0.02, 0.002],
        )
        lower = builder.create_link_builder(upper)
        lower.set_name("lower")
        lower.set_joint_name("elbow")
        lower.set_joint_properties(
            type="revolute_unwrapped",
            limits=[0.1, 2.5],
            pose_in_parent=sapien.Pose([0, 0, 0.4000000059604645], [-0.5, 0.5, 0.5, -0.5]),
            pose_in_child=sapien.Pose([0, 0, 0], [-0.5, 0.5, 0.5, -0.5]),
        )
        lower.collision_groups = [1, 1, 536870912, 1]
        lower.add_box_collision(
            pose=sapien.Pose([0, 0, 0.15000000596046448]),
            half_size=[0.03, 0.03, 0.15],
        )
        tip = builder.create_link_builder(lower)
        tip.set_name("tip")
        tip.set_joint_name("tool")
        tip.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose([0, 0, 0.30000001192092896], [0, 1, 0, 0]),
            pose_in_child=sapien.Pose([0, 0, 0], [0, 1, 0, 0]),
        )
        articulation = builder.build()
        articulation.name = "tumbling"
        joint = articulation.find_joint_by_name("shoulder")
        joint.friction = 0.5
        joint.max_velocity = 2
        joint = articulation.find_joint_by_name("elbow")
        joint.max_velocity = 3
        articulation.qpos = [0, 0.5]

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
