# A script of plain SAPIEN calls, written by scenecc.
#
# constraints: 4 parallel scenes.
# A chain, a hammer, two cogs, a leash and a lift.
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

    if render:
        chain_look = sapien.render.RenderMaterial(
            base_color=[1, 0.4980392156862745, 0.054901960784313725, 1],
        )
        handle_look = sapien.render.RenderMaterial(
            base_color=[0.5490196078431373, 0.33725490196078434, 0.29411764705882354, 1],
        )
        head_look = sapien.render.RenderMaterial(
            base_color=[0.4980392156862745, 0.4980392156862745, 0.4980392156862745, 1],
        )
        cabin_look = sapien.render.RenderMaterial(
            base_color=[0.12156862745098039, 0.4666666666666667, 0.7058823529411765, 1],
        )

    # What constraints, lights and cameras hold on to, by scene and name.
    held = {}

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

    # chain_0 to chain_4
    chain_names = [f"chain_{k}" for k in range(5)]
    chain_pose = [
        sapien.Pose([0, 0, 1]),
        sapien.Pose([0, 0, 0.92]),
        sapien.Pose([0, 0, 0.84]),
        sapien.Pose([0, 0, 0.76]),
        sapien.Pose([0, 0, 0.6799999999999999]),
    ]
    for k, name in enumerate(chain_names):
        for scene in scenes:
            builder = scene.create_actor_builder()
            builder.add_sphere_collision(radius=0.03)
            if render:
                builder.add_sphere_visual(radius=0.03, material=chain_look)
            builder.initial_pose = chain_pose[k]
            entity = builder.build(name=name)
            held[scene, name] = entity

    # handle
    handle_pose = [
        sapien.Pose([0.5, 0, 0.44690318232457926], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.5, 0, 0.323294327529215], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.5, 0, 0.6388621537358581], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.5, 0, 0.6698865024672269], [0.7071067811865476, 0, 0.7071067811865475, 0]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(radius=0.01, half_length=0.15)
        if render:
            builder.add_cylinder_visual(radius=0.01, half_length=0.15, material=handle_look)
        builder.initial_pose = handle_pose[i]
        entity = builder.build(name="handle")
        held[scene, "handle"] = entity

    # head
    head_pose = [
        sapien.Pose([0.5, 0, 0.29690318232457924], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.5, 0, 0.173294327529215], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.5, 0, 0.48886215373585806], [0.7071067811865476, 0, 0.7071067811865475, 0]),
        sapien.Pose([0.5, 0, 0.5198865024672269], [0.7071067811865476, 0, 0.7071067811865475, 0]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.02, 0.06, 0.02], density=7800)
        if render:
            builder.add_box_visual(half_size=[0.02, 0.06, 0.02], material=head_look)
        builder.initial_pose = head_pose[i]
        entity = builder.build(name="head")
        held[scene, "head"] = entity

    # cog_0
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(radius=0.14, half_length=0.02)
        if render:
            builder.add_cylinder_visual(radius=0.14, half_length=0.02)
        builder.initial_pose = sapien.Pose([1, 0, 0.5])
        entity = builder.build(name="cog_0")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.angular_velocity = [0, 0, 0]
        held[scene, "cog_0"] = entity

    # cog_1
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(radius=0.07, half_length=0.02)
        if render:
            builder.add_cylinder_visual(radius=0.07, half_length=0.02)
        builder.initial_pose = sapien.Pose([1, 0.21, 0.5])
        entity = builder.build(name="cog_1")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.angular_velocity = [5, 0, 0]
        held[scene, "cog_1"] = entity

    # dog
    dog_linear_velocity = [
        [0, 1.7936143870498527, 0],
        [0, 1.9748587177647088, 0],
        [0, 0.8726289421326883, 0],
        [0, 0.7907681345628457, 0],
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05)
        if render:
            builder.add_sphere_visual(radius=0.05)
        builder.initial_pose = sapien.Pose([1.5, 0.2, 0.05])
        entity = builder.build(name="dog")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.linear_velocity = dog_linear_velocity[i]
        held[scene, "dog"] = entity

    # cabin
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.1, 0.1, 0.1])
        if render:
            builder.add_box_visual(half_size=[0.1, 0.1, 0.1], material=cabin_look)
        builder.initial_pose = sapien.Pose([2, 0, 0.2])
        entity = builder.build(name="cabin")
        held[scene, "cabin"] = entity

    # sky
    for scene in scenes:
        constraint = scene.create_connection(
            None,
            sapien.Pose([0, 0, 1.04]),
            held[scene, "chain_0"],
            sapien.Pose([0, 0, 0.04]),
        )
        constraint.name = "sky"

    # bead_0
    for scene in scenes:
        constraint = scene.create_drive(
            held[scene, "chain_0"],
            sapien.Pose([0, 0, -0.03999999999999996]),
            held[scene, "chain_1"],
            sapien.Pose([0, 0, 0.04]),
        )
        constraint.name = "bead_0"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)

    # bead_1
    for scene in scenes:
        constraint = scene.create_drive(
            held[scene, "chain_1"],
            sapien.Pose([0, 0, -0.04000000000000007]),
            held[scene, "chain_2"],
            sapien.Pose([0, 0, 0.04]),
        )
        constraint.name = "bead_1"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)

    # bead_2
    for scene in scenes:
        constraint = scene.create_drive(
            held[scene, "chain_2"],
            sapien.Pose([0, 0, -0.03999999999999996]),
            held[scene, "chain_3"],
            sapien.Pose([0, 0, 0.04]),
        )
        constraint.name = "bead_2"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)

    # bead_3
    for scene in scenes:
        constraint = scene.create_drive(
            held[scene, "chain_3"],
            sapien.Pose([0, 0, -0.04000000000000007]),
            held[scene, "chain_4"],
            sapien.Pose([0, 0, 0.04]),
        )
        constraint.name = "bead_3"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)

    # hammer
    hammer_pose_in_parent = [
        sapien.Pose([0.15000000000000002, 0, -1.1102230246251565e-16]),
        sapien.Pose([0.14999999999999997, 0, -1.1102230246251565e-16]),
        sapien.Pose([0.15000000000000002, 0, -1.1102230246251565e-16]),
        sapien.Pose([0.15000000000000002, 0, 1.1102230246251565e-16]),
    ]
    for i, scene in enumerate(scenes):
        constraint = scene.create_drive(
            held[scene, "handle"],
            hammer_pose_in_parent[i],
            held[scene, "head"],
            sapien.Pose(),
        )
        constraint.name = "hammer"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)
        constraint.set_limit_twist(0, 0)
        # A drive's limits of the swing do nothing: a spring that gives way to nothing holds it.
        constraint.set_drive_property_swing(10000000000.0, 10000, mode="acceleration")

    # axle_0
    for scene in scenes:
        constraint = scene.create_drive(
            None,
            sapien.Pose([1, 0, 0.5]),
            held[scene, "cog_0"],
            sapien.Pose(),
        )
        constraint.name = "axle_0"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)
        constraint.set_drive_property_swing(100000000.0, 10000, mode="acceleration")

    # axle_1
    for scene in scenes:
        constraint = scene.create_drive(
            None,
            sapien.Pose([1, 0.21, 0.5]),
            held[scene, "cog_1"],
            sapien.Pose(),
        )
        constraint.name = "axle_1"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 0)
        constraint.set_drive_property_swing(100000000.0, 10000, mode="acceleration")

    # cogs
    for scene in scenes:
        constraint = scene.create_gear(
            held[scene, "cog_0"],
            sapien.Pose([0, 0.21, 0]),
            held[scene, "cog_1"],
            sapien.Pose(),
        )
        constraint.name = "cogs"
        constraint.set_gear_ratio(2)

    # leash
    leash_high = [0.6224778064348171, 0.8549533872061714, 0.7242478698457349, 0.6689027223947701]
    for i, scene in enumerate(scenes):
        constraint = scene.create_connection(
            None,
            sapien.Pose([1.5, 0, 0]),
            held[scene, "dog"],
            sapien.Pose(),
        )
        constraint.name = "leash"
        constraint.set_limit(0, leash_high[i])

    # lift
    lift_target = [
        sapien.Pose([0, 0, 1.2]),
        sapien.Pose([0, 0, 0.4]),
        sapien.Pose([0, 0, 0.4]),
        sapien.Pose([0, 0, 0.8]),
    ]
    for i, scene in enumerate(scenes):
        constraint = scene.create_drive(
            None,
            sapien.Pose([2, 0, 0.2]),
            held[scene, "cabin"],
            sapien.Pose(),
        )
        constraint.name = "lift"
        constraint.set_limit_x(0, 0)
        constraint.set_limit_y(0, 0)
        constraint.set_limit_z(0, 1.5)
        constraint.set_limit_twist(0, 0)
        constraint.set_drive_property_z(500, 100, 500)
        constraint.set_drive_property_swing(100000000.0, 10000, mode="acceleration")
        constraint.set_drive_target(lift_target[i])

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
