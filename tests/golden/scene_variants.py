# A script of plain SAPIEN calls, written by scenecc.
#
# variants: 6 parallel scenes.
# A thing to grasp that is a box, a mug or a dumb-bell.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# What a reset would draw anew is as the seed 0 draws it.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
MUG = HERE / "../../scenes/assets/mug.obj"
FILES = [MUG]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 6 parallel scenes. `render`: build what is seen, too."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    scenes: list[sapien.Scene] = []
    for _ in range(6):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    if render:
        table_look = sapien.render.RenderMaterial(
            base_color=[0.8666666666666667, 0.7215686274509804, 0.5725490196078431, 1],
        )
        thing_look = sapien.render.RenderMaterial(
            base_color=[0.7372549019607844, 0.4235294117647059, 0.1450980392156863, 1],
        )
        thing_look_2 = sapien.render.RenderMaterial(
            base_color=[0.3764705882352941, 0.4235294117647059, 0.2196078431372549, 1],
        )
        thing_look_3 = sapien.render.RenderMaterial(
            base_color=[0.1568627450980392, 0.21176470588235294, 0.09411764705882353, 1],
        )

    # table
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(pose=sapien.Pose([0, 0, -0.02]), half_size=[0.5, 0.5, 0.02])
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, -0.02]),
                half_size=[0.5, 0.5, 0.02],
                material=table_look,
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="table")

    # thing, variant 0
    thing_half_size = [
        [0.028591835144619642, 0.029303191232723434, 0.030213815596112192],
        [0.027324407087736945, 0.026676915693912562, 0.024778436763409094],
    ]
    thing_pose = [
        sapien.Pose(
            [0.18579972398882577, 0.05051245938677207, 0.1],
            [0.9343189201183006, 0, 0, 0.3564381510290004],
        ),
        sapien.Pose(
            [-0.06871405422064347, 0.08444773186832832, 0.1],
            [0.670702119159898, 0, 0, 0.741726814504115],
        ),
    ]
    for i, scene in enumerate(scenes[0:4:3]):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=thing_half_size[i], density=500)
        if render:
            builder.add_box_visual(half_size=thing_half_size[i], material=thing_look)
        builder.initial_pose = thing_pose[i]
        builder.build(name="thing")

    # thing, variant 1
    thing_scale = [
        [0.9816064431629232, 0.9816064431629232, 0.9816064431629232],
        [1.0730862736789877, 1.0730862736789877, 1.0730862736789877],
    ]
    thing_pose_2 = [
        sapien.Pose(
            [0.051102688297933296, -0.15522822451788146, 0.1],
            [0.870732988933486, 0, 0, 0.49175610009735277],
        ),
        sapien.Pose(
            [0.04151363894317969, -0.09821442590883223, 0.1],
            [-0.9706072609948915, -0.0, 0, 0.240668952929111],
        ),
    ]
    for i, scene in enumerate(scenes[1:5:3]):
        builder = scene.create_actor_builder()
        builder.add_multiple_convex_collisions_from_file(
            filename=str(MUG),
            scale=thing_scale[i],
            density=500,
        )
        if render:
            builder.add_visual_from_file(
                filename=str(MUG),
                scale=thing_scale[i],
                material=thing_look_2,
            )
        builder.initial_pose = thing_pose_2[i]
        builder.build(name="thing")

    # thing, variant 2
    thing_pose_3 = [
        sapien.Pose(
            [-0.17479224656235748, 0.02404251767897153, 0.1],
            [-0.9243814952488026, -0.0, 0, 0.38146933198042005],
        ),
        sapien.Pose(
            [-0.1392036618699656, -0.1320249346940735, 0.1],
            [-0.5531779325040177, -0.0, 0, 0.8330631278544145],
        ),
    ]
    for i, scene in enumerate(scenes[2:6:3]):
        builder = scene.create_actor_builder()
        builder.add_capsule_collision(radius=0.01, half_length=0.05, density=500)
        builder.add_sphere_collision(pose=sapien.Pose([-0.05, 0, 0]), radius=0.025, density=500)
        builder.add_sphere_collision(pose=sapien.Pose([0.05, 0, 0]), radius=0.025, density=500)
        if render:
            builder.add_capsule_visual(radius=0.01, half_length=0.05, material=thing_look_3)
            builder.add_sphere_visual(
                pose=sapien.Pose([-0.05, 0, 0]),
                radius=0.025,
                material=thing_look_3,
            )
            builder.add_sphere_visual(
                pose=sapien.Pose([0.05, 0, 0]),
                radius=0.025,
                material=thing_look_3,
            )
        builder.initial_pose = thing_pose_3[i]
        builder.build(name="thing")

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
