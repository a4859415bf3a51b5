# A script of plain SAPIEN calls, written by scenecc.
#
# parameters: one scene.
# A table whose size, colour and load are given from outside.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

import sapien
from sapien import physx


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds one scene. `render`: build what is seen, too."""
    systems = [physx.PhysxCpuSystem()]
    if render:
        systems.append(sapien.render.RenderSystem())
    scene = sapien.Scene(systems)

    if render:
        table_look = sapien.render.RenderMaterial(base_color=[0.8, 0.6, 0.4, 1])

    # ground
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

    # table
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_box_collision(pose=sapien.Pose([0, 0, -0.025]), half_size=[0.5, 0.5, 0.025])
    builder.add_box_collision(
        pose=sapien.Pose([0, 0, -0.375]),
        half_size=[0.1, 0.1, 0.32499999999999996],
    )
    if render:
        builder.add_box_visual(
            pose=sapien.Pose([0, 0, -0.025]),
            half_size=[0.5, 0.5, 0.025],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0, 0, -0.375]),
            half_size=[0.1, 0.1, 0.32499999999999996],
            material=table_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, 0.7])
    builder.build(name="table")

    # block
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.05], density=700)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.05], name="a block of wood")
    builder.initial_pose = sapien.Pose([0, 0, 0.75])
    builder.build(name="block")

    # ball
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.04)
    if render:
        builder.add_sphere_visual(radius=0.04)
    builder.initial_pose = sapien.Pose([0.3333333333333333, 0, 0.74])
    builder.build(name="ball")

    return [scene]


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
