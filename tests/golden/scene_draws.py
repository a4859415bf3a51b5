# A script of plain SAPIEN calls, written by scenecc.
#
# draws: 4 parallel scenes.
# A square peg and a block with a hole, both of random size, that fit.
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
        block_look = sapien.render.RenderMaterial(
            base_color=[0.5529411764705883, 0.6, 0.6823529411764706, 1],
        )
        peg_look = sapien.render.RenderMaterial(
            base_color=[0.9372549019607843, 0.13725490196078433, 0.23529411764705882, 1],
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

    # block
    block_shape_pose = [
        sapien.Pose([-0.031810288652841315, 0, 0]),
        sapien.Pose([-0.03436386168475447, 0, 0]),
        sapien.Pose([-0.03726435485625705, 0, 0]),
        sapien.Pose([-0.041026333330364956, 0, 0]),
    ]
    block_half_size = [
        [0.014962790115734967, 0.04677307876857628, 0.05],
        [0.01380483447693282, 0.04816869616168729, 0.05],
        [0.010065785875718691, 0.04733014073197574, 0.05],
        [0.0169274979082035, 0.05795383123856846, 0.05],
    ]
    block_shape_pose_2 = [
        sapien.Pose([0.031810288652841315, 0, 0]),
        sapien.Pose([0.03436386168475447, 0, 0]),
        sapien.Pose([0.03726435485625705, 0, 0]),
        sapien.Pose([0.041026333330364956, 0, 0]),
    ]
    block_shape_pose_3 = [
        sapien.Pose([0, -0.031810288652841315, 0]),
        sapien.Pose([0, -0.03436386168475447, 0]),
        sapien.Pose([0, -0.03726435485625705, 0]),
        sapien.Pose([0, -0.041026333330364956, 0]),
    ]
    block_half_size_2 = [
        [0.016847498537106348, 0.014962790115734967, 0.05],
        [0.020559027207821653, 0.01380483447693282, 0.05],
        [0.027198568980538358, 0.010065785875718691, 0.05],
        [0.024098835422161458, 0.0169274979082035, 0.05],
    ]
    block_shape_pose_4 = [
        sapien.Pose([0, 0.031810288652841315, 0]),
        sapien.Pose([0, 0.03436386168475447, 0]),
        sapien.Pose([0, 0.03726435485625705, 0]),
        sapien.Pose([0, 0.041026333330364956, 0]),
    ]
    block_pose = [
        sapien.Pose([0.3, 0, 0.05], [0.9774488838306922, 0, 0, 0.21117215606735218]),
        sapien.Pose([0.3, 0, 0.05], [0.7744793134973017, 0, 0, 0.632599235665637]),
        sapien.Pose([0.3, 0, 0.05], [0.9348910732098522, 0, 0, 0.35493475630393084]),
        sapien.Pose([0.3, 0, 0.05], [0.9569579393641323, 0, 0, 0.2902266395215188]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        builder.add_box_collision(pose=block_shape_pose[i], half_size=block_half_size[i])
        builder.add_box_collision(pose=block_shape_pose_2[i], half_size=block_half_size[i])
        builder.add_box_collision(pose=block_shape_pose_3[i], half_size=block_half_size_2[i])
        builder.add_box_collision(pose=block_shape_pose_4[i], half_size=block_half_size_2[i])
        if render:
            builder.add_box_visual(
                pose=block_shape_pose[i],
                half_size=block_half_size[i],
                material=block_look,
            )
            builder.add_box_visual(
                pose=block_shape_pose_2[i],
                half_size=block_half_size[i],
                material=block_look,
            )
            builder.add_box_visual(
                pose=block_shape_pose_3[i],
                half_size=block_half_size_2[i],
                material=block_look,
            )
            builder.add_box_visual(
                pose=block_shape_pose_4[i],
                half_size=block_half_size_2[i],
                material=block_look,
            )
        builder.initial_pose = block_pose[i]
        builder.build(name="block")

    # peg
    peg_half_size = [
        [0.015847498537106347, 0.015847498537106347, 0.06],
        [0.019559027207821652, 0.019559027207821652, 0.06],
        [0.026198568980538357, 0.026198568980538357, 0.06],
        [0.023098835422161457, 0.023098835422161457, 0.06],
    ]
    peg_pose = [
        sapien.Pose([0.3, 0, 0.25], [0.9774488838306922, 0, 0, 0.21117215606735218]),
        sapien.Pose([0.3, 0, 0.25], [0.7744793134973017, 0, 0, 0.632599235665637]),
        sapien.Pose([0.3, 0, 0.2], [0.9348910732098522, 0, 0, 0.35493475630393084]),
        sapien.Pose([0.3, 0, 0.2], [0.9569579393641323, 0, 0, 0.2902266395215188]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=peg_half_size[i])
        if render:
            builder.add_box_visual(half_size=peg_half_size[i], material=peg_look)
        builder.initial_pose = peg_pose[i]
        builder.build(name="peg")

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
