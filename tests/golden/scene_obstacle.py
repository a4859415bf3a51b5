# A script of plain SAPIEN calls, written by scenecc.
#
# obstacle: 4 parallel scenes.
# Four scenes, an obstacle in two of them.
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

    if render:
        ball_look = sapien.render.RenderMaterial(
            base_color=[0.9333333333333333, 0.4235294117647059, 0.30196078431372547, 1],
        )
        obstacle_look = sapien.render.RenderMaterial(
            base_color=[0.1607843137254902, 0.19607843137254902, 0.2549019607843137, 1],
        )
        cushion_look = sapien.render.RenderMaterial(
            base_color=[0.596078431372549, 0.7568627450980392, 0.8509803921568627, 1],
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

    # ramp
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=[0.4, 0.15, 0.01])
        if render:
            builder.add_box_visual(half_size=[0.4, 0.15, 0.01])
        builder.initial_pose = sapien.Pose(
            [0, 0, 0.15],
            [0.984807753012208, 0, 0.17364817766693033, 0],
        )
        builder.build(name="ramp")

    # ball
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.04)
        if render:
            builder.add_sphere_visual(radius=0.04, material=ball_look)
        builder.initial_pose = sapien.Pose([-0.3, 0, 0.32])
        builder.build(name="ball")

    # obstacle
    for scene in scenes[0:3:2]:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=[0.02, 0.15, 0.1])
        if render:
            builder.add_box_visual(half_size=[0.02, 0.15, 0.1], material=obstacle_look)
        builder.initial_pose = sapien.Pose([0.6, 0, 0.1])
        builder.build(name="obstacle")

    # cushion
    for scene in scenes[1:4:2]:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        builder.add_box_collision(half_size=[0.02, 0.15, 0.05])
        if render:
            builder.add_box_visual(half_size=[0.02, 0.15, 0.05], material=cushion_look)
        builder.initial_pose = sapien.Pose(
            [0.4134820086129933, 0, 0.05803463394644405],
            [0.984807753012208, 0, 0.17364817766693033, 0],
        )
        builder.build(name="cushion")

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
