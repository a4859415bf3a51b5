# A script of plain SAPIEN calls, written by scenecc.
#
# robot_door: 4 parallel scenes.
# A door, ajar in each scene in its own way, and held there by a spring.
# A tree of links with a joint between each and its parent. A reset draws the hinge's position
# anew, and the
# drive's target with it.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# What a reset would draw anew is as the seed 0 draws it.

import sapien
from sapien import physx


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 4 parallel scenes. `render`: build what is seen, too."""
    scenes: list[sapien.Scene] = []
    for _ in range(4):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    door_physical = physx.PhysxMaterial(static_friction=0.2, dynamic_friction=0.2, restitution=0.1)

    if render:
        door_look = sapien.render.RenderMaterial(
            base_color=[0.6274509803921569, 0.4392156862745098, 0.23529411764705882, 1],
        )
        door_look_2 = sapien.render.RenderMaterial(
            base_color=[0.7529411764705882, 0.6274509803921569, 0.25098039215686274, 1],
            metallic=1,
        )

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

    # door
    door_qpos = [
        [0.4219425499420429],
        [0.6418264978455805],
        [0.4037599107008798],
        [0.33550805874614875],
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_articulation_builder()
        builder.initial_pose = sapien.Pose([0, 0, 1])
        frame = builder.create_link_builder()
        frame.set_name("frame")
        frame.add_box_collision(
            pose=sapien.Pose([0, -0.45, 0]),
            half_size=[0.04, 0.04, 1],
            density=600,
        )
        frame.add_box_collision(
            pose=sapien.Pose([0, 0.45, 0]),
            half_size=[0.04, 0.04, 1],
            density=600,
        )
        if render:
            frame.add_box_visual(
                pose=sapien.Pose([0, -0.45, 0]),
                half_size=[0.04, 0.04, 1],
                material=door_look,
            )
            frame.add_box_visual(
                pose=sapien.Pose([0, 0.45, 0]),
                half_size=[0.04, 0.04, 1],
                material=door_look,
            )
        panel = builder.create_link_builder(frame)
        panel.set_name("panel")
        panel.set_joint_name("hinge")
        panel.set_joint_properties(
            type="revolute",
            limits=[0, 1.5707963267948966],
            pose_in_parent=sapien.Pose(
                [0, -0.4, 0],
                [0.7071067811865475, 0, -0.7071067811865475, 0],
            ),
            pose_in_child=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        )
        panel.add_box_collision(
            pose=sapien.Pose([0, 0.4, 0]),
            half_size=[0.02, 0.39, 0.98],
            density=600,
        )
        if render:
            panel.add_box_visual(
                pose=sapien.Pose([0, 0.4, 0]),
                half_size=[0.02, 0.39, 0.98],
                material=door_look,
            )
        knob = builder.create_link_builder(panel)
        knob.set_name("knob")
        knob.set_joint_properties(
            type="fixed",
            limits=[],
            pose_in_parent=sapien.Pose([0.04, 0.7, 0]),
            pose_in_child=sapien.Pose(),
        )
        knob.add_sphere_collision(radius=0.03, material=door_physical)
        if render:
            knob.add_sphere_visual(radius=0.03, material=door_look_2)
        articulation = builder.build(fix_root_link=True)
        articulation.name = "door"
        body = articulation.find_link_by_name("panel")
        body.angular_damping = 0.5
        joint = articulation.find_joint_by_name("hinge")
        joint.set_drive_properties(stiffness=5, damping=1)
        joint.friction = 0.1
        articulation.qpos = door_qpos[i]
        targets = zip(articulation.active_joints, door_qpos[i])
        for joint, target in targets:
            joint.set_drive_target(target)

    return scenes


def main() -> None:
    """Simulates 100 steps and prints where everything in the first scene is."""
    scenes = build_scenes()
    for _ in range(100):
        for scene in scenes:
            scene.step()
    for entity in scenes[0].entities:
        print(entity.name, entity.pose.p, entity.pose.q)


if __name__ == "__main__":
    main()
