# A script of plain SAPIEN calls, written by scenecc.
#
# reset: 4 parallel scenes.
# A ball is thrown at a can on a post.
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
        can_look = sapien.render.RenderMaterial(
            base_color=[0.7529411764705882, 0.7529411764705882, 0.7529411764705882, 1],
        )
        ball_look = sapien.render.RenderMaterial(
            base_color=[1, 0.4980392156862745, 0.054901960784313725, 1],
        )
        marker_look = sapien.render.RenderMaterial(base_color=[0, 1, 0, 1])

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

    # post
    post_half_size = [
        [0.05, 0.3, 0.16634303120857988],
        [0.05, 0.3, 0.1908305920143255],
        [0.05, 0.3, 0.1888225021991512],
        [0.05, 0.3, 0.1954868485340357],
    ]
    post_pose = [
        sapien.Pose([1, 0, 0.16634303120857988]),
        sapien.Pose([1, 0, 0.1908305920143255]),
        sapien.Pose([1, 0, 0.1888225021991512]),
        sapien.Pose([1, 0, 0.1954868485340357]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=post_half_size[i])
        if render:
            builder.add_box_visual(half_size=post_half_size[i])
        builder.initial_pose = post_pose[i]
        builder.build(name="post")

    # can
    can_pose = [
        sapien.Pose([1, 0.03956329872786088, 0.39368606241715975]),
        sapien.Pose([1, -0.0757540283013851, 0.442661184028651]),
        sapien.Pose([1, -0.08305662041379594, 0.4386450043983024]),
        sapien.Pose([1, 0.03990053875816202, 0.4519736970680714]),
    ]
    can_mass = [0.16256137460216807, 0.16728836573809408, 0.1537862662813232, 0.26434469353162093]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.033,
            half_length=0.06,
        )
        if render:
            builder.add_cylinder_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
                radius=0.033,
                half_length=0.06,
                material=can_look,
            )
        builder.initial_pose = can_pose[i]
        entity = builder.build(name="can")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (can_mass[i] / body.mass)
        body.mass = can_mass[i]

    # ball
    ball_pose = [
        sapien.Pose(
            [-0.5, 0, 0.8],
            [0.7953666737985181, 0.13708656537592373, -0.579603836832905, 0.11251008902622751],
        ),
        sapien.Pose(
            [-0.5, 0, 0.8],
            [-0.13498677094471076, 0.6302825772638462, -0.7419248834235245, 0.1845803668447805],
        ),
        sapien.Pose(
            [-0.5, 0, 0.8],
            [-0.7369488102348408, -0.14087686252576231, 0.27243842658928835, -0.6023599126899989],
        ),
        sapien.Pose(
            [-0.5, 0, 0.8],
            [-0.6321926450553962, -0.38033229891796266, 0.17982024753602055, -0.6506492761186504],
        ),
    ]
    ball_linear_velocity = [
        [4.665372124834319, 0.11868989618358264, 0.72176476276452],
        [4.7633223680573025, -0.22726208490415528, 0.9051978842632321],
        [4.755290008796605, -0.24916986124138782, 1.3943440324900567],
        [4.781947394136143, 0.11970161627448606, 0.5384061332187571],
    ]
    ball_angular_velocity = [
        [-0.2937094777764809, -1.9328744544887075, -3.898016895629884],
        [-11.015960476491816, -4.29513883579928, -6.2826569877358605],
        [-4.78298863175222, 0.6285101775586067, -8.2548924096127],
        [-8.160425829333313, 6.492167436248408, 4.625972283949663],
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05, density=300)
        if render:
            builder.add_sphere_visual(radius=0.05, material=ball_look)
        builder.initial_pose = ball_pose[i]
        entity = builder.build(name="ball")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.linear_velocity = ball_linear_velocity[i]
        body.angular_velocity = ball_angular_velocity[i]

    # marker
    marker_pose = [
        sapien.Pose([1, 0.03956329872786088, 0.5936860624171598]),
        sapien.Pose([1, -0.0757540283013851, 0.642661184028651]),
        sapien.Pose([1, -0.08305662041379594, 0.6386450043983024]),
        sapien.Pose([1, 0.03990053875816202, 0.6519736970680714]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        if render:
            builder.add_sphere_visual(radius=0.01, material=marker_look)
        builder.initial_pose = marker_pose[i]
        builder.build(name="marker")

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
