# A script of plain SAPIEN calls, written by scenecc.
#
# prefabs: 2 parallel scenes.
# A workspace, a bin, a shelf and stairs, with a few objects, all from prefabs.
#
# Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.
# Values that a reset would draw again are those of seed 0.

import atexit
import base64
import shutil
import tempfile
import zlib
from pathlib import Path

import sapien
from sapien import physx


def packed_file(name: str, lines: list[str]) -> Path:
    """Returns a file that is embedded in this script and deleted at exit."""
    folder = Path(tempfile.mkdtemp())
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    (folder / name).write_bytes(zlib.decompress(base64.b64decode("".join(lines))))
    return folder / name


TILES = packed_file(
    "tiles.png",
    [
        "eNrt3bEJwkAYgNGLlQgpLXQZUSIakCBiaeEYWhntREdwBiewyAIO4RKWYsQVIofwPkjSJT88uCrHHefF",
        "JO30OyGENJ9mi/pZfq52q77PVs9LCNUpz4bLTZKU1W4QzoraB+Dxs77fuP+s7/v/en4AAAAAAAAAAAAA",
        "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA0CKDIv6crMoAlIuL8AAAAAAAAAAAA",
        "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAaBBA9gc4P8ASEWl+AAAAAAAAAAAA",
        "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAANAgg+wOcH2CJiDQ/AAAAAAAAAAAA",
        "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAGgRQxF7d7eS27yWhLh8X2XW0PrwB",
        "8+aKaQ==",
    ],
)
FILES = [TILES]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 2 parallel scenes. `render`: also build visuals."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    scenes: list[sapien.Scene] = []
    for _ in range(2):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    if render:
        table_workspace_look = sapien.render.RenderMaterial(
            base_color=[0.3419144249086609, 0.1714411007328226, 0.05448027644244237, 1],
        )
        ground_look = sapien.render.RenderMaterial()
        ground_look.base_color_texture = sapien.render.RenderTexture2D(str(TILES), mipmap_levels=4)
        red_cube_look = sapien.render.RenderMaterial(base_color=[1, 0, 0, 1])
        peg_twocolor_peg_look = sapien.render.RenderMaterial(
            base_color=[0.7156935005064807, 0.003676507324047436, 0.003676507324047436, 1],
        )
        peg_twocolor_peg_look_2 = sapien.render.RenderMaterial(
            base_color=[0, 0.02518685962736163, 0.5332764040105052, 1],
        )
        goal_red_white_target_look = sapien.render.RenderMaterial(
            base_color=[0.7607843, 0.07450981, 0.08627451, 1],
        )
        goal_red_white_target_look_2 = sapien.render.RenderMaterial(base_color=[1, 1, 1, 1])
        tray_bin_look = sapien.render.RenderMaterial(
            base_color=[0.042311410620809675, 0.1559264637078274, 0.3762621229909065, 1],
        )
        ball_sphere_look = sapien.render.RenderMaterial(
            base_color=[0.047058824, 0.16470589, 0.627451, 1],
        )
        rack_shelf_look = sapien.render.RenderMaterial(
            base_color=[0.21223075741405523, 0.26225065752969623, 0.26635560480286247, 1],
        )
        flight_stairs_look = sapien.render.RenderMaterial(
            base_color=[0.26635560480286247, 0.26635560480286247, 0.26635560480286247, 1],
        )

    # table-workspace
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        builder.add_box_collision(
            pose=sapien.Pose([0, 0, 0.45982145]),
            half_size=[1.209, 0.6045, 0.45982145],
        )
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.8996429]),
                half_size=[1.209, 0.6045, 0.02],
                material=table_workspace_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([-1.1, -0.5, 0.43982145]),
                half_size=[0.04, 0.04, 0.43982145],
                material=table_workspace_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([-1.1, 0.5, 0.43982145]),
                half_size=[0.04, 0.04, 0.43982145],
                material=table_workspace_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([1.1, -0.5, 0.43982145]),
                half_size=[0.04, 0.04, 0.43982145],
                material=table_workspace_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([1.1, 0.5, 0.43982145]),
                half_size=[0.04, 0.04, 0.43982145],
                material=table_workspace_look,
            )
        builder.initial_pose = sapien.Pose(
            [-0.12, 0, -0.9196429],
            [0.7071067811865476, 0, 0, 0.7071067811865475],
        )
        builder.build(name="table-workspace")

    # ground
    for scene in scenes:
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "ground"
            shape = sapien.render.RenderShapeTriangleMesh(
                vertices=[[-50, -50, 0], [50, -50, 0], [50, 50, 0], [-50, 50, 0]],
                triangles=[[0, 1, 2], [0, 2, 3]],
                normals=[[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]],
                uvs=[[-12, -12], [13, -12], [13, 13], [-12, 13]],
                material=ground_look,
            )
            shape.local_pose = sapien.Pose([0, 0, -0.9196429])
            look.attach(shape)
            entity.add_component(look)
        body = physx.PhysxRigidStaticComponent()
        body.name = "ground"
        shape = physx.PhysxCollisionShapePlane(material=physx.get_default_material())
        shape.local_pose = sapien.Pose(
            [0, 0, -0.9196429],
            [0.7071067811865475, 0, -0.7071067811865475, 0],
        )
        shape.density = 0
        body.attach(shape)
        entity.add_component(body)
        entity.name = "ground"
        entity.pose = sapien.Pose([0, 0, 0])
        scene.add_entity(entity)

    # red/cube
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.02, 0.02, 0.02])
        if render:
            builder.add_box_visual(half_size=[0.02, 0.02, 0.02], material=red_cube_look)
        builder.initial_pose = sapien.Pose(
            [-0.1, 0, 0.02],
            [0.9659258262890683, 0, 0, 0.25881904510252074],
        )
        builder.build(name="red/cube")

    # parcel/box
    parcel_box_half_size = [
        [0.030035827929383193, 0.05031400798336824, 0.026414194239040525],
        [0.03805425749900664, 0.04593712391244645, 0.02319180977763922],
    ]
    if render:
        parcel_box_base_color = [
            [0.3564001441459435, 0.24620132670783548, 0.21223075741405523, 1],
            [0.15292615199615017, 0.07227185068231748, 0.052860647023180246, 1],
        ]
    for i, scene in enumerate(scenes):
        if render:
            parcel_box_look = sapien.render.RenderMaterial(base_color=parcel_box_base_color[i])
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=parcel_box_half_size[i])
        if render:
            builder.add_box_visual(half_size=parcel_box_half_size[i], material=parcel_box_look)
        builder.initial_pose = sapien.Pose([-0.1, 0.2, 0.031])
        builder.build(name="parcel/box")

    # peg/twocolor_peg
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.1, 0.02, 0.02])
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([-0.05, 0, 0]),
                half_size=[0.05, 0.02, 0.02],
                material=peg_twocolor_peg_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0.05, 0, 0]),
                half_size=[0.05, 0.02, 0.02],
                material=peg_twocolor_peg_look_2,
            )
        builder.initial_pose = sapien.Pose(
            [-0.1, -0.2, 0.021],
            [0.7071067811865476, 0, 0, 0.7071067811865475],
        )
        builder.build(name="peg/twocolor_peg")

    # goal/red_white_target
    goal_red_white_target_pose = [
        sapien.Pose(
            [0.1430017778454319, -0.04709093113073615, 0.001],
            [0.7071067811865476, 0, 0.7071067811865475, 0],
        ),
        sapien.Pose(
            [0.17092119857065008, 0.0448494435401981, 0.001],
            [0.7071067811865476, 0, 0.7071067811865475, 0],
        ),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        if render:
            builder.add_cylinder_visual(
                radius=0.08,
                half_length=5e-06,
                material=goal_red_white_target_look,
            )
            builder.add_cylinder_visual(
                radius=0.064,
                half_length=1.5000000000000002e-05,
                material=goal_red_white_target_look_2,
            )
            builder.add_cylinder_visual(
                radius=0.048,
                half_length=2.5e-05,
                material=goal_red_white_target_look,
            )
            builder.add_cylinder_visual(
                radius=0.032,
                half_length=3.5000000000000004e-05,
                material=goal_red_white_target_look_2,
            )
            builder.add_cylinder_visual(
                radius=0.016,
                half_length=4.5e-05,
                material=goal_red_white_target_look,
            )
        builder.initial_pose = goal_red_white_target_pose[i]
        builder.build(name="goal/red_white_target")

    # tray/bin
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(pose=sapien.Pose([0, 0, 0.0025]), half_size=[0.1, 0.1, 0.0025])
        builder.add_box_collision(
            pose=sapien.Pose([0, -0.0975, 0.0325]),
            half_size=[0.1, 0.0025, 0.0275],
        )
        builder.add_box_collision(
            pose=sapien.Pose([0, 0.0975, 0.0325]),
            half_size=[0.1, 0.0025, 0.0275],
        )
        builder.add_box_collision(
            pose=sapien.Pose([-0.0975, 0, 0.0325]),
            half_size=[0.0025, 0.095, 0.0275],
        )
        builder.add_box_collision(
            pose=sapien.Pose([0.0975, 0, 0.0325]),
            half_size=[0.0025, 0.095, 0.0275],
        )
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.0025]),
                half_size=[0.1, 0.1, 0.0025],
                material=tray_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, -0.0975, 0.0325]),
                half_size=[0.1, 0.0025, 0.0275],
                material=tray_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0.0975, 0.0325]),
                half_size=[0.1, 0.0025, 0.0275],
                material=tray_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([-0.0975, 0, 0.0325]),
                half_size=[0.0025, 0.095, 0.0275],
                material=tray_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0.0975, 0, 0.0325]),
                half_size=[0.0025, 0.095, 0.0275],
                material=tray_bin_look,
            )
        builder.initial_pose = sapien.Pose([-0.1, 0.5, 0])
        builder.build(name="tray/bin")

    # ball/sphere
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.02)
        if render:
            builder.add_sphere_visual(radius=0.02, material=ball_sphere_look)
        builder.initial_pose = sapien.Pose([-0.1, 0.5, 0.026000000000000002])
        builder.build(name="ball/sphere")

    # rack/shelf
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(pose=sapien.Pose([0, -0.39, 0.6]), half_size=[0.15, 0.01, 0.6])
        builder.add_box_collision(pose=sapien.Pose([0, 0.39, 0.6]), half_size=[0.15, 0.01, 0.6])
        builder.add_box_collision(pose=sapien.Pose([0, 0, 0.01]), half_size=[0.15, 0.38, 0.01])
        builder.add_box_collision(pose=sapien.Pose([0, 0, 0.305]), half_size=[0.15, 0.38, 0.01])
        builder.add_box_collision(pose=sapien.Pose([0, 0, 0.6]), half_size=[0.15, 0.38, 0.01])
        builder.add_box_collision(pose=sapien.Pose([0, 0, 0.895]), half_size=[0.15, 0.38, 0.01])
        builder.add_box_collision(pose=sapien.Pose([0, 0, 1.19]), half_size=[0.15, 0.38, 0.01])
        builder.add_box_collision(pose=sapien.Pose([-0.16, 0, 0.6]), half_size=[0.01, 0.4, 0.6])
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, -0.39, 0.6]),
                half_size=[0.15, 0.01, 0.6],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0.39, 0.6]),
                half_size=[0.15, 0.01, 0.6],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.01]),
                half_size=[0.15, 0.38, 0.01],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.305]),
                half_size=[0.15, 0.38, 0.01],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.6]),
                half_size=[0.15, 0.38, 0.01],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.895]),
                half_size=[0.15, 0.38, 0.01],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 1.19]),
                half_size=[0.15, 0.38, 0.01],
                material=rack_shelf_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([-0.16, 0, 0.6]),
                half_size=[0.01, 0.4, 0.6],
                material=rack_shelf_look,
            )
        builder.initial_pose = sapien.Pose([1.5, 0, -0.9196429], [6.123233995736766e-17, 0, 0, 1])
        builder.build(name="rack/shelf")

    # flight/stairs
    scene = scenes[0]
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_box_collision(
        pose=sapien.Pose([0.14, 0, 0.1149553625]),
        half_size=[0.14, 0.4, 0.1149553625],
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.42000000000000004, 0, 0.229910725]),
        half_size=[0.14, 0.4, 0.229910725],
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.7000000000000001, 0, 0.34486608750000003]),
        half_size=[0.14, 0.4, 0.34486608750000003],
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.9800000000000001, 0, 0.45982145]),
        half_size=[0.14, 0.4, 0.45982145],
    )
    if render:
        builder.add_box_visual(
            pose=sapien.Pose([0.14, 0, 0.1149553625]),
            half_size=[0.14, 0.4, 0.1149553625],
            material=flight_stairs_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.42000000000000004, 0, 0.229910725]),
            half_size=[0.14, 0.4, 0.229910725],
            material=flight_stairs_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.7000000000000001, 0, 0.34486608750000003]),
            half_size=[0.14, 0.4, 0.34486608750000003],
            material=flight_stairs_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.9800000000000001, 0, 0.45982145]),
            half_size=[0.14, 0.4, 0.45982145],
            material=flight_stairs_look,
        )
    builder.initial_pose = sapien.Pose([-3, 0, -0.9196429])
    builder.build(name="flight/stairs")

    return scenes


def main() -> None:
    """Simulates 100 steps and prints the poses of all entities in the first scene."""
    scenes = build_scenes()
    for _ in range(100):
        for scene in scenes:
            scene.step()
    for entity in scenes[0].entities:
        print(entity.name, entity.pose.p, entity.pose.q)


if __name__ == "__main__":
    main()
