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
        domino_look = sapien.render.RenderMaterial(
            base_color=[0.9019607843137255, 0.2235294117647059, 0.27450980392156865, 1],
        )
        domino_look_2 = sapien.render.RenderMaterial(
            base_color=[0.9450980392156862, 0.9803921568627451, 0.9333333333333333, 1],
        )
        brick_look = sapien.render.RenderMaterial(
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

    # domino_0 to domino_11
    domino_names = [f"domino_{k}" for k in range(12)]
    domino_pose = [
        sapien.Pose([1, 0, 0.05]),
        sapien.Pose([1.04, 0, 0.05]),
        sapien.Pose([1.08, 0, 0.05]),
        sapien.Pose([1.12, 0, 0.05]),
        sapien.Pose([1.16, 0, 0.05]),
        sapien.Pose([1.2, 0, 0.05]),
        sapien.Pose([1.24, 0, 0.05]),
        sapien.Pose([1.28, 0, 0.05]),
        sapien.Pose([1.32, 0, 0.05]),
        sapien.Pose([1.3599999999999999, 0, 0.05]),
        sapien.Pose([1.4, 0, 0.05]),
        sapien.Pose([1.44, 0, 0.05]),
    ]
    if render:
        domino_look_3 = [
            domino_look,
            domino_look_2,
            domino_look,
            domino_look_2,
            domino_look,
            domino_look_2,
            domino_look,
            domino_look_2,
            domino_look,
            domino_look_2,
            domino_look,
            domino_look_2,
        ]
    for k, name in enumerate(domino_names):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.005, 0.025, 0.05])
        if render:
            builder.add_box_visual(half_size=[0.005, 0.025, 0.05], material=domino_look_3[k])
        builder.initial_pose = domino_pose[k]
        builder.build(name=name)

    # brick_0_0 to brick_3_0
    brick_names = [
        "brick_0_0",
        "brick_0_1",
        "brick_0_2",
        "brick_0_3",
        "brick_1_0",
        "brick_1_1",
        "brick_1_2",
        "brick_2_0",
        "brick_2_1",
        "brick_3_0",
    ]
    brick_pose = [
        sapien.Pose([-1, 0, 0.025]),
        sapien.Pose([-0.899, 0, 0.025]),
        sapien.Pose([-0.798, 0, 0.025]),
        sapien.Pose([-0.697, 0, 0.025]),
        sapien.Pose([-0.9495, 0, 0.07500000000000001]),
        sapien.Pose([-0.8485, 0, 0.07500000000000001]),
        sapien.Pose([-0.7475, 0, 0.07500000000000001]),
        sapien.Pose([-0.899, 0, 0.125]),
        sapien.Pose([-0.798, 0, 0.125]),
        sapien.Pose([-0.8485, 0, 0.17500000000000002]),
    ]
    for k, name in enumerate(brick_names):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.025], density=600)
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.025], material=brick_look)
        builder.initial_pose = brick_pose[k]
        builder.build(name=name)

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
