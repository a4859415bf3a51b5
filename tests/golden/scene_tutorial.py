# A script of plain SAPIEN calls, written by scenecc.
#
# tutorial: one scene.
# The actors of SAPIEN's tutorial on a table.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
BOWL = HERE / "../../scenes/assets/bowl.obj"
BOWL_2 = HERE / "../../scenes/assets/bowl.glb"
FILES = [BOWL, BOWL_2]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds one scene. `render`: build what is seen, too."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    systems = [physx.PhysxCpuSystem()]
    if render:
        systems.append(sapien.render.RenderSystem())
    scene = sapien.Scene(systems)
    scene.timestep = 0.01

    if render:
        table_look = sapien.render.RenderMaterial(base_color=[0.8, 0.6, 0.4, 1])
        box_look = sapien.render.RenderMaterial(base_color=[1, 0, 0, 1])
        sphere_look = sapien.render.RenderMaterial(base_color=[0, 1, 0, 1])
        capsule_look = sapien.render.RenderMaterial(base_color=[0, 0, 1, 1])
        cylinder_look = sapien.render.RenderMaterial(base_color=[1, 0.8, 0, 1])

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
    builder.add_box_collision(pose=sapien.Pose([0, 0, -0.05]), half_size=[0.5, 0.5, 0.05])
    builder.add_box_collision(pose=sapien.Pose([-0.45, -0.45, -0.5]), half_size=[0.05, 0.05, 0.5])
    builder.add_box_collision(pose=sapien.Pose([-0.45, 0.45, -0.5]), half_size=[0.05, 0.05, 0.5])
    builder.add_box_collision(pose=sapien.Pose([0.45, -0.45, -0.5]), half_size=[0.05, 0.05, 0.5])
    builder.add_box_collision(pose=sapien.Pose([0.45, 0.45, -0.5]), half_size=[0.05, 0.05, 0.5])
    if render:
        builder.add_box_visual(
            pose=sapien.Pose([0, 0, -0.05]),
            half_size=[0.5, 0.5, 0.05],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([-0.45, -0.45, -0.5]),
            half_size=[0.05, 0.05, 0.5],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([-0.45, 0.45, -0.5]),
            half_size=[0.05, 0.05, 0.5],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.45, -0.45, -0.5]),
            half_size=[0.05, 0.05, 0.5],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.45, 0.45, -0.5]),
            half_size=[0.05, 0.05, 0.5],
            material=table_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, 1])
    builder.build(name="table")

    # box
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.05], material=box_look)
    builder.initial_pose = sapien.Pose([0, 0, 1.05])
    builder.build(name="box")

    # sphere
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.05)
    if render:
        builder.add_sphere_visual(radius=0.05, material=sphere_look)
    builder.initial_pose = sapien.Pose([0, -0.2, 1.05])
    builder.build(name="sphere")

    # capsule
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(radius=0.05, half_length=0.05)
    if render:
        builder.add_capsule_visual(radius=0.05, half_length=0.05, material=capsule_look)
    builder.initial_pose = sapien.Pose([0, 0.2, 1.05])
    builder.build(name="capsule")

    # cylinder
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        radius=0.05,
        half_length=0.05,
    )
    if render:
        builder.add_cylinder_visual(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.05,
            half_length=0.05,
            material=cylinder_look,
        )
    builder.initial_pose = sapien.Pose([0.2, 0, 1.05])
    builder.build(name="cylinder")

    # mesh
    builder = scene.create_actor_builder()
    builder.add_convex_collision_from_file(filename=str(BOWL))
    if render:
        builder.add_visual_from_file(filename=str(BOWL_2))
    builder.initial_pose = sapien.Pose([-0.2, 0, 1.05])
    builder.build(name="mesh")

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
