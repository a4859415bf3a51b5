# A script of plain SAPIEN calls, written by scenecc.
#
# include: one scene.
# A floor from an included file, and a table with four chairs from a prefab.
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

    shared_physical = physx.PhysxMaterial(
        static_friction=0.6,
        dynamic_friction=0.5,
        restitution=0.1,
    )

    if render:
        floor_look = sapien.render.RenderMaterial(
            base_color=[0.611764705882353, 0.5568627450980392, 0.49411764705882355, 1],
        )
        table_look = sapien.render.RenderMaterial(base_color=[0.62, 0.45, 0.26, 1])
        chair_chair_look = sapien.render.RenderMaterial(
            base_color=[0.7372549019607844, 0.2784313725490196, 0.28627450980392155, 1],
        )
        chair_chair_look_2 = sapien.render.RenderMaterial(
            base_color=[0.2196078431372549, 0.4, 0.2549019607843137, 1],
        )
        chair_chair_look_3 = sapien.render.RenderMaterial(
            base_color=[0.41568627450980394, 0.6, 0.3058823529411765, 1],
        )
        chair_chair_look_4 = sapien.render.RenderMaterial(
            base_color=[0.6549019607843137, 0.788235294117647, 0.3411764705882353, 1],
        )
        cushion_look = sapien.render.RenderMaterial(base_color=[1, 1, 1, 1])

    # floor
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_plane_collision(
        pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        material=shared_physical,
    )
    if render:
        builder.add_plane_visual(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            scale=[10, 3, 3],
            material=floor_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, 0])
    builder.build(name="floor")

    # table
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_cylinder_collision(
        pose=sapien.Pose([0, 0, 0.73], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        radius=0.5,
        half_length=0.02,
        material=shared_physical,
    )
    builder.add_cylinder_collision(
        pose=sapien.Pose([0, 0, 0.355], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        radius=0.05,
        half_length=0.355,
        material=shared_physical,
    )
    if render:
        builder.add_cylinder_visual(
            pose=sapien.Pose([0, 0, 0.73], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.5,
            half_length=0.02,
            material=table_look,
        )
        builder.add_cylinder_visual(
            pose=sapien.Pose([0, 0, 0.355], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.05,
            half_length=0.355,
            material=table_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, 0])
    builder.build(name="table")

    # chair_0/chair to chair_3/chair
    chair_chair_names = ["chair_0/chair", "chair_1/chair", "chair_2/chair", "chair_3/chair"]
    chair_chair_shape_pose = [
        sapien.Pose([0, 0, 0.40499999999999997]),
        sapien.Pose([0, 0, 0.425]),
        sapien.Pose([0, 0, 0.44499999999999995]),
        sapien.Pose([0, 0, 0.46499999999999997]),
    ]
    chair_chair_shape_pose_2 = [
        sapien.Pose([-0.185, 0, 0.6699999999999999]),
        sapien.Pose([-0.185, 0, 0.69]),
        sapien.Pose([-0.185, 0, 0.71]),
        sapien.Pose([-0.185, 0, 0.73]),
    ]
    chair_chair_shape_pose_3 = [
        sapien.Pose([-0.185, -0.185, 0.195]),
        sapien.Pose([-0.185, -0.185, 0.20500000000000002]),
        sapien.Pose([-0.185, -0.185, 0.21499999999999997]),
        sapien.Pose([-0.185, -0.185, 0.22499999999999998]),
    ]
    chair_chair_half_size = [
        [0.015, 0.015, 0.195],
        [0.015, 0.015, 0.20500000000000002],
        [0.015, 0.015, 0.21499999999999997],
        [0.015, 0.015, 0.22499999999999998],
    ]
    chair_chair_shape_pose_4 = [
        sapien.Pose([-0.185, 0.185, 0.195]),
        sapien.Pose([-0.185, 0.185, 0.20500000000000002]),
        sapien.Pose([-0.185, 0.185, 0.21499999999999997]),
        sapien.Pose([-0.185, 0.185, 0.22499999999999998]),
    ]
    chair_chair_shape_pose_5 = [
        sapien.Pose([0.185, -0.185, 0.195]),
        sapien.Pose([0.185, -0.185, 0.20500000000000002]),
        sapien.Pose([0.185, -0.185, 0.21499999999999997]),
        sapien.Pose([0.185, -0.185, 0.22499999999999998]),
    ]
    chair_chair_shape_pose_6 = [
        sapien.Pose([0.185, 0.185, 0.195]),
        sapien.Pose([0.185, 0.185, 0.20500000000000002]),
        sapien.Pose([0.185, 0.185, 0.21499999999999997]),
        sapien.Pose([0.185, 0.185, 0.22499999999999998]),
    ]
    chair_chair_pose = [
        sapien.Pose([0.7, 0, 0], [6.123233995736766e-17, 0, 0, 1]),
        sapien.Pose(
            [4.286263797015736e-17, 0.7, 0],
            [-0.7071067811865475, -0.0, 0, 0.7071067811865476],
        ),
        sapien.Pose([-0.7, 8.572527594031472e-17, 0], [-1, -0.0, 0, 1.2246467991473532e-16]),
        sapien.Pose(
            [-1.2858791391047207e-16, -0.7, 0],
            [-0.7071067811865477, 0, -0.0, -0.7071067811865475],
        ),
    ]
    if render:
        chair_chair_look_5 = [
            chair_chair_look,
            chair_chair_look_2,
            chair_chair_look_3,
            chair_chair_look_4,
        ]
    for k, name in enumerate(chair_chair_names):
        builder = scene.create_actor_builder()
        builder.add_box_collision(
            pose=chair_chair_shape_pose[k],
            half_size=[0.2, 0.2, 0.015],
            density=600,
        )
        builder.add_box_collision(
            pose=chair_chair_shape_pose_2[k],
            half_size=[0.015, 0.2, 0.25],
            density=600,
        )
        builder.add_box_collision(
            pose=chair_chair_shape_pose_3[k],
            half_size=chair_chair_half_size[k],
            density=600,
        )
        builder.add_box_collision(
            pose=chair_chair_shape_pose_4[k],
            half_size=chair_chair_half_size[k],
            density=600,
        )
        builder.add_box_collision(
            pose=chair_chair_shape_pose_5[k],
            half_size=chair_chair_half_size[k],
            density=600,
        )
        builder.add_box_collision(
            pose=chair_chair_shape_pose_6[k],
            half_size=chair_chair_half_size[k],
            density=600,
        )
        if render:
            builder.add_box_visual(
                pose=chair_chair_shape_pose[k],
                half_size=[0.2, 0.2, 0.015],
                material=chair_chair_look_5[k],
            )
            builder.add_box_visual(
                pose=chair_chair_shape_pose_2[k],
                half_size=[0.015, 0.2, 0.25],
                material=chair_chair_look_5[k],
            )
            builder.add_box_visual(
                pose=chair_chair_shape_pose_3[k],
                half_size=chair_chair_half_size[k],
                material=chair_chair_look_5[k],
            )
            builder.add_box_visual(
                pose=chair_chair_shape_pose_4[k],
                half_size=chair_chair_half_size[k],
                material=chair_chair_look_5[k],
            )
            builder.add_box_visual(
                pose=chair_chair_shape_pose_5[k],
                half_size=chair_chair_half_size[k],
                material=chair_chair_look_5[k],
            )
            builder.add_box_visual(
                pose=chair_chair_shape_pose_6[k],
                half_size=chair_chair_half_size[k],
                material=chair_chair_look_5[k],
            )
        builder.initial_pose = chair_chair_pose[k]
        builder.build(name=name)

    # cushion
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.15, 0.15, 0.025], density=50)
    if render:
        builder.add_box_visual(half_size=[0.15, 0.15, 0.025], material=cushion_look)
    builder.initial_pose = sapien.Pose(
        [0.7, 0, 0.44999999999999996],
        [6.123233995736766e-17, 0, 0, 1],
    )
    builder.build(name="cushion")

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
