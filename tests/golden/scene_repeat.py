# A script of plain SAPIEN calls, written by scenecc.
#
# repeat: one scene.
# A table with four legs, a row of dominoes, and a pyramid.
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
        shared_look = sapien.render.RenderMaterial(
            base_color=[0.9019607843137255, 0.2235294117647059, 0.27450980392156865, 1],
        )
        shared_look_2 = sapien.render.RenderMaterial(
            base_color=[0.9450980392156862, 0.9803921568627451, 0.9333333333333333, 1],
        )
        shared_look_3 = sapien.render.RenderMaterial(
            base_color=[0.7098039215686275, 0.396078431372549, 0.11372549019607843, 1],
        )

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
    builder.add_box_collision(pose=sapien.Pose([0, 0, -0.025]), half_size=[0.4, 0.4, 0.025])
    builder.add_box_collision(
        pose=sapien.Pose([-0.375, -0.375, -0.275]),
        half_size=[0.025, 0.025, 0.225],
    )
    builder.add_box_collision(
        pose=sapien.Pose([-0.375, 0.375, -0.275]),
        half_size=[0.025, 0.025, 0.225],
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.375, -0.375, -0.275]),
        half_size=[0.025, 0.025, 0.225],
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.375, 0.375, -0.275]),
        half_size=[0.025, 0.025, 0.225],
    )
    if render:
        builder.add_box_visual(pose=sapien.Pose([0, 0, -0.025]), half_size=[0.4, 0.4, 0.025])
        builder.add_box_visual(
            pose=sapien.Pose([-0.375, -0.375, -0.275]),
            half_size=[0.025, 0.025, 0.225],
        )
        builder.add_box_visual(
            pose=sapien.Pose([-0.375, 0.375, -0.275]),
            half_size=[0.025, 0.025, 0.225],
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.375, -0.375, -0.275]),
            half_size=[0.025, 0.025, 0.225],
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.375, 0.375, -0.275]),
            half_size=[0.025, 0.025, 0.225],
        )
    builder.initial_pose = sapien.Pose([0, 0, 0.5])
    builder.build(name="table")

    # domino_0
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look)
    builder.initial_pose = sapien.Pose([1, 0, 0.05])
    builder.build(name="domino_0")

    # domino_1
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look_2)
    builder.initial_pose = sapien.Pose([1.04, 0, 0.05])
    builder.build(name="domino_1")

    # domino_2
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look)
    builder.initial_pose = sapien.Pose([1.08, 0, 0.05])
    builder.build(name="domino_2")

    # domino_3
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look_2)
    builder.initial_pose = sapien.Pose([1.12, 0, 0.05])
    builder.build(name="domino_3")

    # domino_4
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look)
    builder.initial_pose = sapien.Pose([1.16, 0, 0.05])
    builder.build(name="domino_4")

    # domino_5
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look_2)
    builder.initial_pose = sapien.Pose([1.2, 0, 0.05])
    builder.build(name="domino_5")

    # domino_6
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look)
    builder.initial_pose = sapien.Pose([1.24, 0, 0.05])
    builder.build(name="domino_6")

    # domino_7
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look_2)
    builder.initial_pose = sapien.Pose([1.28, 0, 0.05])
    builder.build(name="domino_7")

    # domino_8
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look)
    builder.initial_pose = sapien.Pose([1.32, 0, 0.05])
    builder.build(name="domino_8")

    # domino_9
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look_2)
    builder.initial_pose = sapien.Pose([1.3599999999999999, 0, 0.05])
    builder.build(name="domino_9")

    # domino_10
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look)
    builder.initial_pose = sapien.Pose([1.4, 0, 0.05])
    builder.build(name="domino_10")

    # domino_11
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
    if render:
        builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=shared_look_2)
    builder.initial_pose = sapien.Pose([1.44, 0, 0.05])
    builder.build(name="domino_11")

    # brick_0_0
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-1, 0, 0.025])
    builder.build(name="brick_0_0")

    # brick_0_1
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.899, 0, 0.025])
    builder.build(name="brick_0_1")

    # brick_0_2
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.798, 0, 0.025])
    builder.build(name="brick_0_2")

    # brick_0_3
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.697, 0, 0.025])
    builder.build(name="brick_0_3")

    # brick_1_0
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.9495, 0, 0.07500000000000001])
    builder.build(name="brick_1_0")

    # brick_1_1
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.8485, 0, 0.07500000000000001])
    builder.build(name="brick_1_1")

    # brick_1_2
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.7475, 0, 0.07500000000000001])
    builder.build(name="brick_1_2")

    # brick_2_0
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.899, 0, 0.125])
    builder.build(name="brick_2_0")

    # brick_2_1
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.798, 0, 0.125])
    builder.build(name="brick_2_1")

    # brick_3_0
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
    if render:
        builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=shared_look_3)
    builder.initial_pose = sapien.Pose([-0.8485, 0, 0.17500000000000002])
    builder.build(name="brick_3_0")

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
