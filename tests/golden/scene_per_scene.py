# A script of plain SAPIEN calls, written by scenecc.
#
# per_scene: 4 parallel scenes.
# Four scenes with four tasks.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

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

    # cube
    cube_pose = [
        sapien.Pose([0, 0, 0.02]),
        sapien.Pose([0.1, 0, 0.02]),
        sapien.Pose([0.2, 0, 0.02], [0.9238795325112867, 0, 0, 0.3826834323650898]),
        sapien.Pose([0.3, 0, 0.02]),
    ]
    if render:
        cube_base_color = [
            [0.9019607843137255, 0.2235294117647059, 0.27450980392156865, 1],
            [0.9568627450980393, 0.6352941176470588, 0.3803921568627451, 1],
            [0.16470588235294117, 0.615686274509804, 0.5607843137254902, 1],
            [0.14901960784313725, 0.27450980392156865, 0.3254901960784314, 1],
        ]
    for i, scene in enumerate(scenes):
        if render:
            cube_look = sapien.render.RenderMaterial(base_color=cube_base_color[i])
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.02, 0.02, 0.02])
        if render:
            builder.add_box_visual(half_size=[0.02, 0.02, 0.02], material=cube_look)
        builder.initial_pose = cube_pose[i]
        builder.build(name="cube")

    # wall
    wall_half_size = [[0.02, 0.2, 0.2], [0.02, 0.4, 0.2]]
    for i, scene in enumerate(scenes[1:4:2]):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=wall_half_size[i])
        if render:
            builder.add_box_visual(half_size=wall_half_size[i])
        builder.initial_pose = sapien.Pose([0.5, 0, 0.2])
        builder.build(name="wall")

    # ball
    ball_mass = [0.1, 0.1, 1.5, 0.1]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05)
        if render:
            builder.add_sphere_visual(radius=0.05)
        builder.initial_pose = sapien.Pose([-0.2, 0, 0.1])
        entity = builder.build(name="ball")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (ball_mass[i] / body.mass)
        body.mass = ball_mass[i]

    # ramp
    ramp_pose = [
        sapien.Pose([0, 0.5, 0.1]),
        sapien.Pose([0, 0.5, 0.1], [0.9961946980917455, 0, 0.08715574274765817, 0]),
        sapien.Pose([0, 0.5, 0.1], [0.984807753012208, 0, 0.17364817766693033, 0]),
        sapien.Pose([0, 0.5, 0.1], [0.9659258262890683, 0, 0.25881904510252074, 0]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=[0.3, 0.1, 0.01])
        if render:
            builder.add_box_visual(half_size=[0.3, 0.1, 0.01])
        builder.initial_pose = ramp_pose[i]
        builder.build(name="ramp")

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
