# A script of plain SAPIEN calls, written by scenecc.
#
# clutter: 4 parallel scenes.
# Random objects that fall on a table of random height, some of them into a bin.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# What a reset would draw anew is as the seed 7 draws it.

import atexit
import base64
import shutil
import tempfile
import zlib
from pathlib import Path

import sapien
from sapien import physx


def packed_file(name: str, lines: list[str]) -> Path:
    """A file that this script brings with it; gone when the script ends."""
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
    """Builds 4 parallel scenes. `render`: build what is seen, too."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    scenes: list[sapien.Scene] = []
    for _ in range(4):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    if render:
        floor_ground_look = sapien.render.RenderMaterial()
        floor_ground_look.base_color_texture = sapien.render.RenderTexture2D(
            str(TILES),
            mipmap_levels=4,
        )
        desk_table_look = sapien.render.RenderMaterial(base_color=[0.8, 0.6, 0.4, 1])

    # floor/ground
    for scene in scenes:
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "floor/ground"
            shape = sapien.render.RenderShapeTriangleMesh(
                vertices=[[-5, -5, 0], [5, -5, 0], [5, 5, 0], [-5, 5, 0]],
                triangles=[[0, 1, 2], [0, 2, 3]],
                normals=[[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]],
                uvs=[[-0.75, -0.75], [1.75, -0.75], [1.75, 1.75], [-0.75, 1.75]],
                material=floor_ground_look,
            )
            look.attach(shape)
            entity.add_component(look)
        body = physx.PhysxRigidStaticComponent()
        body.name = "floor/ground"
        shape = physx.PhysxCollisionShapePlane(material=physx.get_default_material())
        shape.local_pose = sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0])
        shape.density = 0
        body.attach(shape)
        entity.add_component(body)
        entity.name = "floor/ground"
        entity.pose = sapien.Pose([0, 0, 0])
        scene.add_entity(entity)

    # desk/table
    desk_table_shape_pose = [
        sapien.Pose([-0.47, -0.47, -0.44699081880059943]),
        sapien.Pose([-0.47, -0.47, -0.4423875538870047]),
        sapien.Pose([-0.47, -0.47, -0.34056104655889485]),
        sapien.Pose([-0.47, -0.47, -0.31542788356753804]),
    ]
    desk_table_half_size = [
        [0.03, 0.03, 0.44699081880059943],
        [0.03, 0.03, 0.4423875538870047],
        [0.03, 0.03, 0.34056104655889485],
        [0.03, 0.03, 0.31542788356753804],
    ]
    desk_table_shape_pose_2 = [
        sapien.Pose([-0.47, 0.47, -0.44699081880059943]),
        sapien.Pose([-0.47, 0.47, -0.4423875538870047]),
        sapien.Pose([-0.47, 0.47, -0.34056104655889485]),
        sapien.Pose([-0.47, 0.47, -0.31542788356753804]),
    ]
    desk_table_shape_pose_3 = [
        sapien.Pose([0.47, -0.47, -0.44699081880059943]),
        sapien.Pose([0.47, -0.47, -0.4423875538870047]),
        sapien.Pose([0.47, -0.47, -0.34056104655889485]),
        sapien.Pose([0.47, -0.47, -0.31542788356753804]),
    ]
    desk_table_shape_pose_4 = [
        sapien.Pose([0.47, 0.47, -0.44699081880059943]),
        sapien.Pose([0.47, 0.47, -0.4423875538870047]),
        sapien.Pose([0.47, 0.47, -0.34056104655889485]),
        sapien.Pose([0.47, 0.47, -0.31542788356753804]),
    ]
    desk_table_pose = [
        sapien.Pose([0, 0, 0.8939816376011989]),
        sapien.Pose([0, 0, 0.8847751077740094]),
        sapien.Pose([0, 0, 0.6811220931177897]),
        sapien.Pose([0, 0, 0.6308557671350761]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(pose=sapien.Pose([0, 0, -0.03]), half_size=[0.5, 0.5, 0.03])
        builder.add_box_collision(pose=desk_table_shape_pose[i], half_size=desk_table_half_size[i])
        builder.add_box_collision(
            pose=desk_table_shape_pose_2[i],
            half_size=desk_table_half_size[i],
        )
        builder.add_box_collision(
            pose=desk_table_shape_pose_3[i],
            half_size=desk_table_half_size[i],
        )
        builder.add_box_collision(
            pose=desk_table_shape_pose_4[i],
            half_size=desk_table_half_size[i],
        )
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, -0.03]),
                half_size=[0.5, 0.5, 0.03],
                material=desk_table_look,
            )
            builder.add_box_visual(
                pose=desk_table_shape_pose[i],
                half_size=desk_table_half_size[i],
                material=desk_table_look,
            )
            builder.add_box_visual(
                pose=desk_table_shape_pose_2[i],
                half_size=desk_table_half_size[i],
                material=desk_table_look,
            )
            builder.add_box_visual(
                pose=desk_table_shape_pose_3[i],
                half_size=desk_table_half_size[i],
                material=desk_table_look,
            )
            builder.add_box_visual(
                pose=desk_table_shape_pose_4[i],
                half_size=desk_table_half_size[i],
                material=desk_table_look,
            )
        builder.initial_pose = desk_table_pose[i]
        builder.build(name="desk/table")

    # bin/bin
    bin_bin_pose = [
        sapien.Pose([0, 0, 0.8939816376011989], [0.9988742599986524, 0, 0, 0.04743640703241137]),
        sapien.Pose([0, 0, 0.8847751077740094], [0.49884774892095024, 0, 0, 0.8666896349885007]),
        sapien.Pose([0, 0, 0.6811220931177897], [0.05054606347077529, 0, 0, 0.9987217307476635]),
        sapien.Pose([0, 0, 0.6308557671350761], [0.43243659871342166, 0, 0, 0.9016643433635196]),
    ]
    if render:
        bin_bin_base_color = [
            [0.6078431372549019, 0.13333333333333333, 0.14901960784313725, 1],
            [0.6078431372549019, 0.13333333333333333, 0.14901960784313725, 1],
            [0.22745098039215686, 0.43137254901960786, 0.6470588235294118, 1],
            [0.6078431372549019, 0.13333333333333333, 0.14901960784313725, 1],
        ]
    for i, scene in enumerate(scenes):
        if render:
            bin_bin_look = sapien.render.RenderMaterial(base_color=bin_bin_base_color[i])
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(pose=sapien.Pose([0, 0, 0.005]), half_size=[0.2, 0.15, 0.005])
        builder.add_box_collision(
            pose=sapien.Pose([0, -0.145, 0.08]),
            half_size=[0.2, 0.005, 0.06999999999999999],
        )
        builder.add_box_collision(
            pose=sapien.Pose([0, 0.145, 0.08]),
            half_size=[0.2, 0.005, 0.06999999999999999],
        )
        builder.add_box_collision(
            pose=sapien.Pose([-0.195, 0, 0.08]),
            half_size=[0.005, 0.13999999999999999, 0.06999999999999999],
        )
        builder.add_box_collision(
            pose=sapien.Pose([0.195, 0, 0.08]),
            half_size=[0.005, 0.13999999999999999, 0.06999999999999999],
        )
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.005]),
                half_size=[0.2, 0.15, 0.005],
                material=bin_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, -0.145, 0.08]),
                half_size=[0.2, 0.005, 0.06999999999999999],
                material=bin_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0, 0.145, 0.08]),
                half_size=[0.2, 0.005, 0.06999999999999999],
                material=bin_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([-0.195, 0, 0.08]),
                half_size=[0.005, 0.13999999999999999, 0.06999999999999999],
                material=bin_bin_look,
            )
            builder.add_box_visual(
                pose=sapien.Pose([0.195, 0, 0.08]),
                half_size=[0.005, 0.13999999999999999, 0.06999999999999999],
                material=bin_bin_look,
            )
        builder.initial_pose = bin_bin_pose[i]
        builder.build(name="bin/bin")

    # things/object_0, variant 0
    scene = scenes[3]
    if render:
        things_object_0_look = sapien.render.RenderMaterial(
            base_color=[0.8276092622868186, 0.6017513579104569, 0.9517771379140247, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.025309369579487193, 0.0158832675926628, 0.015971502068323037],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.025309369579487193, 0.0158832675926628, 0.015971502068323037],
            material=things_object_0_look,
        )
    builder.initial_pose = sapien.Pose(
        [-0.1966037169286792, -0.1931300316603678, 1.1828172913621424],
        [0.43977624314948277, 0.8637469212193719, -0.24534720420412726, -0.018516517885429098],
    )
    builder.build(name="things/object_0")

    # things/object_0, variant 1
    scene = scenes[0]
    if render:
        things_object_0_look_2 = sapien.render.RenderMaterial(
            base_color=[0.18115514448878645, 0.6245196532629324, 0.9421994479838239, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.021052563570952018, density=1000)
    if render:
        builder.add_sphere_visual(radius=0.021052563570952018, material=things_object_0_look_2)
    builder.initial_pose = sapien.Pose(
        [-0.19220578974651012, -0.18148183058264947, 1.4459431618282652],
        [0.40360098438017156, 0.7496600067425492, -0.5149703143985851, -0.09960770545665598],
    )
    builder.build(name="things/object_0")

    # things/object_0, variant 2
    things_object_0_radius = [0.02026876383929386, 0.02449434538008345]
    things_object_0_half_length = [0.022830670312840962, 0.01621096517089749]
    things_object_0_pose = [
        sapien.Pose(
            [-0.17984078569663883, -0.18033214175363615, 1.4367366320010757],
            [-0.1918547383305744, 0.42538451759700135, -0.8573349169296155, 0.21729383742334374],
        ),
        sapien.Pose(
            [-0.19727290341333434, -0.1819670279816706, 1.233083617344856],
            [0.48931782156205283, 0.22428552554872433, -0.08285475604586655, 0.8386889542206214],
        ),
    ]
    if render:
        things_object_0_base_color = [
            [0.32854997018835985, 0.6024131461284196, 0.20045164565337867, 1],
            [0.4189535788395957, 0.6363887797817732, 0.6708536417034079, 1],
        ]
    for i, scene in enumerate(scenes[1:3]):
        if render:
            things_object_0_look_3 = sapien.render.RenderMaterial(
                base_color=things_object_0_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            radius=things_object_0_radius[i],
            half_length=things_object_0_half_length[i],
            density=1000,
        )
        if render:
            builder.add_cylinder_visual(
                radius=things_object_0_radius[i],
                half_length=things_object_0_half_length[i],
                material=things_object_0_look_3,
            )
        builder.initial_pose = things_object_0_pose[i]
        builder.build(name="things/object_0")

    # things/object_1, variant 0
    scene = scenes[1]
    if render:
        things_object_1_look = sapien.render.RenderMaterial(
            base_color=[0.8502653041668563, 0.8220729770559826, 0.16001838120494521, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.02245933081971689, 0.02891081667988535, 0.01864584688400962],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.02245933081971689, 0.02891081667988535, 0.01864584688400962],
            material=things_object_1_look,
        )
    builder.initial_pose = sapien.Pose(
        [-0.055109774739229185, -0.18283001938865107, 1.4367366320010757],
        [-0.03952480941148875, 0.8115496993478017, 0.5798838219245056, -0.05966261810972312],
    )
    builder.build(name="things/object_1")

    # things/object_1, variant 2
    scene = scenes[0]
    if render:
        things_object_1_look_2 = sapien.render.RenderMaterial(
            base_color=[0.8633002587013376, 0.8251114606529976, 0.16188106887294018, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.02672664023869266,
        half_length=0.029422096763765546,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.02672664023869266,
            half_length=0.029422096763765546,
            material=things_object_1_look_2,
        )
    builder.initial_pose = sapien.Pose(
        [-0.06611933524771411, -0.19782244341902103, 1.4459431618282652],
        [0.19990145311342897, -0.050008309597965324, 0.6939464191810866, 0.6899108241795032],
    )
    builder.build(name="things/object_1")

    # things/object_1, variant 3
    things_object_1_radius = [0.011142679639087948, 0.007803097417328461]
    things_object_1_half_length = [0.010455670224222247, 0.008649818642126663]
    things_object_1_pose = [
        sapien.Pose(
            [-0.06042186912716672, -0.1976620878998266, 1.233083617344856],
            [0.34606471796936883, -0.4734910038942083, -0.22281030428733561, 0.7787175665871555],
        ),
        sapien.Pose(
            [-0.06886250412261005, -0.19761024402503627, 1.1828172913621424],
            [-0.061064268307670956, -0.12648797735381925, -0.977503557781603, -0.157349106274223],
        ),
    ]
    if render:
        things_object_1_base_color = [
            [0.302522175571699, 0.48608846295450125, 0.8200015557298805, 1],
            [0.5230827397303295, 0.3028533138206322, 0.9440170145419443, 1],
        ]
    for i, scene in enumerate(scenes[2:4]):
        if render:
            things_object_1_look_3 = sapien.render.RenderMaterial(
                base_color=things_object_1_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_capsule_collision(
            radius=things_object_1_radius[i],
            half_length=things_object_1_half_length[i],
            density=1000,
        )
        if render:
            builder.add_capsule_visual(
                radius=things_object_1_radius[i],
                half_length=things_object_1_half_length[i],
                material=things_object_1_look_3,
            )
        builder.initial_pose = things_object_1_pose[i]
        builder.build(name="things/object_1")

    # things/object_2, variant 0
    scene = scenes[0]
    if render:
        things_object_2_look = sapien.render.RenderMaterial(
            base_color=[0.571384940587286, 0.2091460941796565, 0.5870459007205833, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.022402198756137463, 0.01789274250395615, 0.017673463293086868],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.022402198756137463, 0.01789274250395615, 0.017673463293086868],
            material=things_object_2_look,
        )
    builder.initial_pose = sapien.Pose(
        [0.05452722612154623, -0.1916621437058672, 1.4459431618282652],
        [-0.20333743471760363, -0.4405292904912177, 0.8714171904523846, -0.07224895878724433],
    )
    builder.build(name="things/object_2")

    # things/object_2, variant 2
    things_object_2_radius = [0.024006845578220685, 0.023245624365962045]
    things_object_2_half_length = [0.018107277531747425, 0.015539961562202173]
    things_object_2_pose = [
        sapien.Pose(
            [0.061030574914958925, -0.19525102292292978, 1.4367366320010757],
            [-0.38370196669934886, 0.05652754623261612, 0.8646390376739638, -0.31933802122236116],
        ),
        sapien.Pose(
            [0.057412425017314625, -0.18265139196256827, 1.1828172913621424],
            [-0.5604491040900124, -0.5451949099824752, 0.37934506560759057, 0.49472884800977196],
        ),
    ]
    if render:
        things_object_2_base_color = [
            [0.8232429023972961, 0.9239227960909614, 0.5459140575471485, 1],
            [0.23421339927175394, 0.5247519362630576, 0.574936948191149, 1],
        ]
    for i, scene in enumerate(scenes[1:4:2]):
        if render:
            things_object_2_look_2 = sapien.render.RenderMaterial(
                base_color=things_object_2_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            radius=things_object_2_radius[i],
            half_length=things_object_2_half_length[i],
            density=1000,
        )
        if render:
            builder.add_cylinder_visual(
                radius=things_object_2_radius[i],
                half_length=things_object_2_half_length[i],
                material=things_object_2_look_2,
            )
        builder.initial_pose = things_object_2_pose[i]
        builder.build(name="things/object_2")

    # things/object_2, variant 3
    scene = scenes[2]
    if render:
        things_object_2_look_3 = sapien.render.RenderMaterial(
            base_color=[0.774638776703992, 0.3618212553699225, 0.8024475090601934, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(
        radius=0.009570929372550826,
        half_length=0.013394378607875696,
        density=1000,
    )
    if render:
        builder.add_capsule_visual(
            radius=0.009570929372550826,
            half_length=0.013394378607875696,
            material=things_object_2_look_3,
        )
    builder.initial_pose = sapien.Pose(
        [0.062330410104848175, -0.19316025956986896, 1.233083617344856],
        [-0.2927645704216363, -0.7978028227825036, 0.17223682990611952, 0.49813054181609306],
    )
    builder.build(name="things/object_2")

    # things/object_3, variant 0
    scene = scenes[0]
    if render:
        things_object_3_look = sapien.render.RenderMaterial(
            base_color=[0.39578156065649805, 0.9740133354323449, 0.5447951089709726, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.01909414023846967, 0.019235677028523378, 0.029227092198916876],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.01909414023846967, 0.019235677028523378, 0.029227092198916876],
            material=things_object_3_look,
        )
    builder.initial_pose = sapien.Pose(
        [0.18592540470083974, -0.18274463032486307, 1.4459431618282652],
        [0.5403493865794547, -0.1583792242775177, 0.11814129078705114, -0.8179127075376861],
    )
    builder.build(name="things/object_3")

    # things/object_3, variant 1
    things_object_3_radius = [0.02311920919373382, 0.021118855430946215]
    things_object_3_pose = [
        sapien.Pose(
            [0.18623374728141656, -0.1898333603653244, 1.4367366320010757],
            [-0.5105683002867313, 0.06500467750882499, -0.7529951430009201, 0.4099911185151646],
        ),
        sapien.Pose(
            [0.18289334769851198, -0.18177238847669716, 1.1828172913621424],
            [0.4954474885117906, 0.5910832954996916, 0.21344564798675095, 0.5996609702691174],
        ),
    ]
    if render:
        things_object_3_base_color = [
            [0.6495511899495128, 0.7460701367571261, 0.6374955204729184, 1],
            [0.12071351889856392, 0.3082909249976041, 0.47524225558802413, 1],
        ]
    for i, scene in enumerate(scenes[1:4:2]):
        if render:
            things_object_3_look_2 = sapien.render.RenderMaterial(
                base_color=things_object_3_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=things_object_3_radius[i], density=1000)
        if render:
            builder.add_sphere_visual(
                radius=things_object_3_radius[i],
                material=things_object_3_look_2,
            )
        builder.initial_pose = things_object_3_pose[i]
        builder.build(name="things/object_3")

    # things/object_3, variant 2
    scene = scenes[2]
    if render:
        things_object_3_look_3 = sapien.render.RenderMaterial(
            base_color=[0.4989620998440284, 0.694425555910257, 0.609632779621241, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.021340560134476536,
        half_length=0.017588895112139354,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.021340560134476536,
            half_length=0.017588895112139354,
            material=things_object_3_look_3,
        )
    builder.initial_pose = sapien.Pose(
        [0.18853819807317027, -0.18055954752798659, 1.233083617344856],
        [-0.3800150423470307, -0.6735250705357135, 0.5681675238323769, -0.2813151467874276],
    )
    builder.build(name="things/object_3")

    # things/object_4, variant 0
    scene = scenes[3]
    if render:
        things_object_4_look = sapien.render.RenderMaterial(
            base_color=[0.46879314452669496, 0.22910257269009032, 0.8692284736324215, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.017495669857795423, 0.020489980750992284, 0.015867151378437985],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.017495669857795423, 0.020489980750992284, 0.015867151378437985],
            material=things_object_4_look,
        )
    builder.initial_pose = sapien.Pose(
        [-0.1789408497075484, -0.06807992632055153, 1.1828172913621424],
        [-0.6900588910170163, 0.23150007731511626, -0.654344787059784, 0.2050837408941689],
    )
    builder.build(name="things/object_4")

    # things/object_4, variant 2
    things_object_4_radius = [0.024759706422929476, 0.015899756634390524, 0.01759615127174761]
    things_object_4_half_length = [0.02393284474410524, 0.02192637995744594, 0.022964203508652328]
    things_object_4_pose = [
        sapien.Pose(
            [-0.17998138236167704, -0.05904623427304355, 1.4459431618282652],
            [0.698681798416723, 0.48776029151986267, 0.5097569999728035, 0.11866525842199749],
        ),
        sapien.Pose(
            [-0.18863168868862168, -0.0681925852950617, 1.4367366320010757],
            [0.002804976001518078, -0.5739281324538982, -0.584646288259565, 0.5733998155841395],
        ),
        sapien.Pose(
            [-0.17965626058303022, -0.0674199575715278, 1.233083617344856],
            [-0.8723579209534373, -0.4346025191000389, -0.10991290511258546, 0.19501656706907866],
        ),
    ]
    if render:
        things_object_4_base_color = [
            [0.6619206275437381, 0.2625144446052784, 0.4713835653550119, 1],
            [0.23623984604159093, 0.9205985204070498, 0.9183019937362326, 1],
            [0.8510126632350811, 0.5458453283630491, 0.4692744713461555, 1],
        ]
    for i, scene in enumerate(scenes[0:3]):
        if render:
            things_object_4_look_2 = sapien.render.RenderMaterial(
                base_color=things_object_4_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            radius=things_object_4_radius[i],
            half_length=things_object_4_half_length[i],
            density=1000,
        )
        if render:
            builder.add_cylinder_visual(
                radius=things_object_4_radius[i],
                half_length=things_object_4_half_length[i],
                material=things_object_4_look_2,
            )
        builder.initial_pose = things_object_4_pose[i]
        builder.build(name="things/object_4")

    # things/object_5, variant 0
    things_object_5_half_size = [
        [0.022750183532170364, 0.025168890250151132, 0.02594785832147039],
        [0.01758730892715264, 0.021540000079517514, 0.019339673130359843],
    ]
    things_object_5_pose = [
        sapien.Pose(
            [-0.07239841535518729, -0.07169606022759109, 1.4367366320010757],
            [0.024257123867841367, -0.4013307391945442, -0.21032588529214624, 0.8911275170789509],
        ),
        sapien.Pose(
            [-0.06686062204789597, -0.057278598790522925, 1.233083617344856],
            [-0.07386583284247683, 0.8807038706467095, 0.40040959163654094, 0.24202621736466884],
        ),
    ]
    if render:
        things_object_5_base_color = [
            [0.5459795192826032, 0.517193674013617, 0.9457181048685832, 1],
            [0.830710030291782, 0.6963264169677431, 0.9573342725035788, 1],
        ]
    for i, scene in enumerate(scenes[1:3]):
        if render:
            things_object_5_look = sapien.render.RenderMaterial(
                base_color=things_object_5_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=things_object_5_half_size[i], density=1000)
        if render:
            builder.add_box_visual(
                half_size=things_object_5_half_size[i],
                material=things_object_5_look,
            )
        builder.initial_pose = things_object_5_pose[i]
        builder.build(name="things/object_5")

    # things/object_5, variant 1
    scene = scenes[3]
    if render:
        things_object_5_look_2 = sapien.render.RenderMaterial(
            base_color=[0.3333762043547971, 0.5142831542125093, 0.808489564807186, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.023887096572709307, density=1000)
    if render:
        builder.add_sphere_visual(radius=0.023887096572709307, material=things_object_5_look_2)
    builder.initial_pose = sapien.Pose(
        [-0.055810768668746194, -0.060185925948209346, 1.1828172913621424],
        [0.3551346811686152, -0.03415909154444598, -0.8845704893118441, -0.3004123235400451],
    )
    builder.build(name="things/object_5")

    # things/object_5, variant 2
    scene = scenes[0]
    if render:
        things_object_5_look_3 = sapien.render.RenderMaterial(
            base_color=[0.2432338606783513, 0.5784756499415756, 0.6521331438856902, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.018606719370711913,
        half_length=0.01684042106894741,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.018606719370711913,
            half_length=0.01684042106894741,
            material=things_object_5_look_3,
        )
    builder.initial_pose = sapien.Pose(
        [-0.05520231851840163, -0.07272647275141886, 1.4459431618282652],
        [-0.17564896708893438, -0.7434854263917485, -0.5990610147322474, -0.23979733470503853],
    )
    builder.build(name="things/object_5")

    # things/object_6, variant 1
    things_object_6_radius = [0.027768357478643375, 0.024780357014642318]
    things_object_6_pose = [
        sapien.Pose(
            [0.05807084149952061, -0.06700179479859107, 1.4459431618282652],
            [0.5827696809721925, -0.6741165346217589, 0.16811683459302226, -0.4215247639410315],
        ),
        sapien.Pose(
            [0.05251831765054567, -0.06924033575923155, 1.233083617344856],
            [0.04204081362184879, -0.9301459354605643, 0.35211621463538856, 0.09526426469064735],
        ),
    ]
    if render:
        things_object_6_base_color = [
            [0.9344111740058787, 0.8025922570342929, 0.13641765469520892, 1],
            [0.6435435457739099, 0.30942793719508654, 0.13365125070817746, 1],
        ]
    for i, scene in enumerate(scenes[0:3:2]):
        if render:
            things_object_6_look = sapien.render.RenderMaterial(
                base_color=things_object_6_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=things_object_6_radius[i], density=1000)
        if render:
            builder.add_sphere_visual(
                radius=things_object_6_radius[i],
                material=things_object_6_look,
            )
        builder.initial_pose = things_object_6_pose[i]
        builder.build(name="things/object_6")

    # things/object_6, variant 2
    scene = scenes[1]
    if render:
        things_object_6_look_2 = sapien.render.RenderMaterial(
            base_color=[0.9424269283138332, 0.2044332667561346, 0.852332238869458, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.02717903352488157,
        half_length=0.029677343447892045,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.02717903352488157,
            half_length=0.029677343447892045,
            material=things_object_6_look_2,
        )
    builder.initial_pose = sapien.Pose(
        [0.057859280591981754, -0.05777815496138103, 1.4367366320010757],
        [0.8808312327420348, -0.32943637419910654, -0.010358999352318956, -0.33985394791455975],
    )
    builder.build(name="things/object_6")

    # things/object_6, variant 3
    scene = scenes[3]
    if render:
        things_object_6_look_3 = sapien.render.RenderMaterial(
            base_color=[0.4937644827963876, 0.657751873603391, 0.2870650489712909, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(
        radius=0.010764234715479491,
        half_length=0.00829701346191295,
        density=1000,
    )
    if render:
        builder.add_capsule_visual(
            radius=0.010764234715479491,
            half_length=0.00829701346191295,
            material=things_object_6_look_3,
        )
    builder.initial_pose = sapien.Pose(
        [0.05691635850643428, -0.06527062414617729, 1.1828172913621424],
        [0.2997661049490655, 0.5011681971228629, -0.03814542032123088, -0.8108733855694128],
    )
    builder.build(name="things/object_6")

    # things/object_7, variant 0
    scene = scenes[0]
    if render:
        things_object_7_look = sapien.render.RenderMaterial(
            base_color=[0.4155142440631652, 0.33859750325010535, 0.9848603358162862, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.023689907197044904, 0.016396819221682075, 0.025776364326236624],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.023689907197044904, 0.016396819221682075, 0.025776364326236624],
            material=things_object_7_look,
        )
    builder.initial_pose = sapien.Pose(
        [0.1815676913306622, -0.061860313278793606, 1.4459431618282652],
        [0.488671969012335, -0.832054627298944, 0.1905264507615948, 0.1805117044742872],
    )
    builder.build(name="things/object_7")

    # things/object_7, variant 1
    scene = scenes[2]
    if render:
        things_object_7_look_2 = sapien.render.RenderMaterial(
            base_color=[0.8551820923253253, 0.888868364409749, 0.11614232286075597, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.021923420200392004, density=1000)
    if render:
        builder.add_sphere_visual(radius=0.021923420200392004, material=things_object_7_look_2)
    builder.initial_pose = sapien.Pose(
        [0.18893261357515714, -0.06183545833314514, 1.233083617344856],
        [0.2919146724994528, -0.061524997355725766, -0.6505351858874328, 0.6984300040822404],
    )
    builder.build(name="things/object_7")

    # things/object_7, variant 2
    things_object_7_radius = [0.028420347296509496, 0.015892189092556686]
    things_object_7_half_length = [0.018097032296100303, 0.015382467296010708]
    things_object_7_pose = [
        sapien.Pose(
            [0.18707417031701107, -0.056526828025195874, 1.4367366320010757],
            [0.48070994467680683, 0.5229560830445705, -0.5246967991255903, 0.46917816795207057],
        ),
        sapien.Pose(
            [0.17753749858037882, -0.06249899992010849, 1.1828172913621424],
            [-0.5352330392488734, 0.72360556823051, -0.054504406632447946, 0.43237697091757693],
        ),
    ]
    if render:
        things_object_7_base_color = [
            [0.8597506596618014, 0.5344014718546999, 0.4984036108292027, 1],
            [0.7685322458813971, 0.3037985227889528, 0.19516436979432739, 1],
        ]
    for i, scene in enumerate(scenes[1:4:2]):
        if render:
            things_object_7_look_3 = sapien.render.RenderMaterial(
                base_color=things_object_7_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            radius=things_object_7_radius[i],
            half_length=things_object_7_half_length[i],
            density=1000,
        )
        if render:
            builder.add_cylinder_visual(
                radius=things_object_7_radius[i],
                half_length=things_object_7_half_length[i],
                material=things_object_7_look_3,
            )
        builder.initial_pose = things_object_7_pose[i]
        builder.build(name="things/object_7")

    # things/object_8, variant 0
    scene = scenes[2]
    if render:
        things_object_8_look = sapien.render.RenderMaterial(
            base_color=[0.6273630966171555, 0.8305655948635923, 0.47455586146884043, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_box_collision(
        half_size=[0.019047486445677636, 0.02365125045309871, 0.01781609507270823],
        density=1000,
    )
    if render:
        builder.add_box_visual(
            half_size=[0.019047486445677636, 0.02365125045309871, 0.01781609507270823],
            material=things_object_8_look,
        )
    builder.initial_pose = sapien.Pose(
        [-0.19647673713690406, 0.07176637938048856, 1.233083617344856],
        [0.6221966364038112, -0.032879983306555956, -0.11990363990828627, -0.7729252030321487],
    )
    builder.build(name="things/object_8")

    # things/object_8, variant 2
    scene = scenes[0]
    if render:
        things_object_8_look_2 = sapien.render.RenderMaterial(
            base_color=[0.7918345304866192, 0.3668811986519044, 0.6824951995912341, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.01948318163117977,
        half_length=0.02866738566423374,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.01948318163117977,
            half_length=0.02866738566423374,
            material=things_object_8_look_2,
        )
    builder.initial_pose = sapien.Pose(
        [-0.19502743051521043, 0.055177144704159374, 1.4459431618282652],
        [-0.10739872552749692, 0.2213986156227539, -0.9689505156193524, 0.024146739663742894],
    )
    builder.build(name="things/object_8")

    # things/object_8, variant 3
    things_object_8_radius = [0.010839739370853793, 0.01135194852683324]
    things_object_8_half_length = [0.014604013950845565, 0.010363614378988462]
    things_object_8_pose = [
        sapien.Pose(
            [-0.1830378736739568, 0.06754708410764576, 1.4367366320010757],
            [0.4975235370152063, -0.37456880426275396, 0.003153848149510925, 0.7824056455770876],
        ),
        sapien.Pose(
            [-0.18842986724899274, 0.06490362610121679, 1.1828172913621424],
            [-0.591829187686264, -0.23213446781724592, 0.33157865023156874, 0.6970705847792116],
        ),
    ]
    if render:
        things_object_8_base_color = [
            [0.48970779936370024, 0.9562759385740999, 0.9978490367001017, 1],
            [0.6682471660458661, 0.1988414098925018, 0.1636426850067259, 1],
        ]
    for i, scene in enumerate(scenes[1:4:2]):
        if render:
            things_object_8_look_3 = sapien.render.RenderMaterial(
                base_color=things_object_8_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_capsule_collision(
            radius=things_object_8_radius[i],
            half_length=things_object_8_half_length[i],
            density=1000,
        )
        if render:
            builder.add_capsule_visual(
                radius=things_object_8_radius[i],
                half_length=things_object_8_half_length[i],
                material=things_object_8_look_3,
            )
        builder.initial_pose = things_object_8_pose[i]
        builder.build(name="things/object_8")

    # things/object_9, variant 0
    things_object_9_half_size = [
        [0.024642333258141226, 0.017790913660253736, 0.020380037297919262],
        [0.027440544536133142, 0.016522671897678146, 0.025413532136612772],
    ]
    things_object_9_pose = [
        sapien.Pose(
            [-0.06481902358815497, 0.06981971459533412, 1.4367366320010757],
            [0.8432008327685248, 0.49344419785279753, -0.14957868123031667, 0.15215583243922928],
        ),
        sapien.Pose(
            [-0.05571313990723638, 0.06284155040429519, 1.1828172913621424],
            [0.0825584651036225, -0.5976022658043214, -0.31688841588575606, -0.7318725050325987],
        ),
    ]
    if render:
        things_object_9_base_color = [
            [0.8097625114417644, 0.8269691684069564, 0.9951486462734375, 1],
            [0.5919825521066898, 0.7184948815386211, 0.3161946410535319, 1],
        ]
    for i, scene in enumerate(scenes[1:4:2]):
        if render:
            things_object_9_look = sapien.render.RenderMaterial(
                base_color=things_object_9_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=things_object_9_half_size[i], density=1000)
        if render:
            builder.add_box_visual(
                half_size=things_object_9_half_size[i],
                material=things_object_9_look,
            )
        builder.initial_pose = things_object_9_pose[i]
        builder.build(name="things/object_9")

    # things/object_9, variant 2
    scene = scenes[2]
    if render:
        things_object_9_look_2 = sapien.render.RenderMaterial(
            base_color=[0.577522183094646, 0.41322780778865975, 0.18710287241223764, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.02945660789920755,
        half_length=0.02181997145898532,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.02945660789920755,
            half_length=0.02181997145898532,
            material=things_object_9_look_2,
        )
    builder.initial_pose = sapien.Pose(
        [-0.06587723286052108, 0.05811027613256192, 1.233083617344856],
        [-0.7514401180738143, -0.31560496009482314, -0.4144391772500646, 0.404933854441743],
    )
    builder.build(name="things/object_9")

    # things/object_9, variant 3
    scene = scenes[0]
    if render:
        things_object_9_look_3 = sapien.render.RenderMaterial(
            base_color=[0.545078724408172, 0.7236709774156602, 0.33982517135191287, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(
        radius=0.01482592826882162,
        half_length=0.010573238063824134,
        density=1000,
    )
    if render:
        builder.add_capsule_visual(
            radius=0.01482592826882162,
            half_length=0.010573238063824134,
            material=things_object_9_look_3,
        )
    builder.initial_pose = sapien.Pose(
        [-0.05312108967671819, 0.0630618979248726, 1.4459431618282652],
        [0.21642517327738342, 0.8856459998630133, -0.25219087220878345, -0.3243317302902558],
    )
    builder.build(name="things/object_9")

    # things/object_10, variant 0
    things_object_10_half_size = [
        [0.01883646629333603, 0.02800506046103759, 0.02193527958826132],
        [0.023629776246368514, 0.01870493699529333, 0.01854256750100448],
    ]
    things_object_10_pose = [
        sapien.Pose(
            [0.07075972250611995, 0.05303197875237604, 1.4459431618282652],
            [0.357746429963885, -0.9334044272345993, -0.014033997955734772, 0.02401486973362684],
        ),
        sapien.Pose(
            [0.055614122766758256, 0.06867023372026357, 1.4367366320010757],
            [0.7693453524025983, -0.4842906659322075, -0.20474019923048534, -0.3628384357348625],
        ),
    ]
    if render:
        things_object_10_base_color = [
            [0.928693358782487, 0.6965241702395009, 0.45457017140788814, 1],
            [0.31068299534349875, 0.34483581153237597, 0.49405993689956484, 1],
        ]
    for i, scene in enumerate(scenes[0:2]):
        if render:
            things_object_10_look = sapien.render.RenderMaterial(
                base_color=things_object_10_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=things_object_10_half_size[i], density=1000)
        if render:
            builder.add_box_visual(
                half_size=things_object_10_half_size[i],
                material=things_object_10_look,
            )
        builder.initial_pose = things_object_10_pose[i]
        builder.build(name="things/object_10")

    # things/object_10, variant 2
    scene = scenes[3]
    if render:
        things_object_10_look_2 = sapien.render.RenderMaterial(
            base_color=[0.3705155469484295, 0.9305246905840869, 0.7014336505552438, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        radius=0.02932875661552757,
        half_length=0.017026254554051948,
        density=1000,
    )
    if render:
        builder.add_cylinder_visual(
            radius=0.02932875661552757,
            half_length=0.017026254554051948,
            material=things_object_10_look_2,
        )
    builder.initial_pose = sapien.Pose(
        [0.0631164245726099, 0.06807027989505242, 1.1828172913621424],
        [0.2029134915484102, 0.11476890518180455, -0.715960275352292, 0.6580692193595392],
    )
    builder.build(name="things/object_10")

    # things/object_10, variant 3
    scene = scenes[2]
    if render:
        things_object_10_look_3 = sapien.render.RenderMaterial(
            base_color=[0.3411107405694207, 0.7955221395253259, 0.22262975347249941, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_capsule_collision(
        radius=0.012015685262394962,
        half_length=0.010279333041544809,
        density=1000,
    )
    if render:
        builder.add_capsule_visual(
            radius=0.012015685262394962,
            half_length=0.010279333041544809,
            material=things_object_10_look_3,
        )
    builder.initial_pose = sapien.Pose(
        [0.07163668421669472, 0.06071918941499102, 1.233083617344856],
        [0.6989032686502273, 0.020549407590609664, 0.07030492865806091, 0.7114556626551567],
    )
    builder.build(name="things/object_10")

    # things/object_11, variant 0
    things_object_11_scenes = [0, 1, 3]
    things_object_11_half_size = [
        [0.015852336779142686, 0.017870743265242118, 0.023439240471706244],
        [0.015098395444113928, 0.023032522644782637, 0.02372778237069647],
        [0.023381024215623027, 0.02014869831379955, 0.016910301936162116],
    ]
    things_object_11_pose = [
        sapien.Pose(
            [0.1808480847668776, 0.06416149650177719, 1.4459431618282652],
            [0.42785718566118675, -0.6427121663787351, -0.5681995862993773, 0.28461997469618755],
        ),
        sapien.Pose(
            [0.18198155932148605, 0.06774007395192357, 1.4367366320010757],
            [-0.54025393152294, -0.1759600500702108, 0.8076543956763739, 0.15766460413779154],
        ),
        sapien.Pose(
            [0.18471426502552846, 0.06664127183084355, 1.1828172913621424],
            [-0.5529803579499994, -0.3667017145534675, 0.6711804632596269, 0.3305440394314053],
        ),
    ]
    if render:
        things_object_11_base_color = [
            [0.41567453844842006, 0.7542158705352315, 0.7212387564396168, 1],
            [0.4327827860740402, 0.6720667089834914, 0.629543364696107, 1],
            [0.8821545134453538, 0.1835527198951599, 0.4436596747067141, 1],
        ]
    for i, scene in enumerate([scenes[k] for k in things_object_11_scenes]):
        if render:
            things_object_11_look = sapien.render.RenderMaterial(
                base_color=things_object_11_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=things_object_11_half_size[i], density=1000)
        if render:
            builder.add_box_visual(
                half_size=things_object_11_half_size[i],
                material=things_object_11_look,
            )
        builder.initial_pose = things_object_11_pose[i]
        builder.build(name="things/object_11")

    # things/object_11, variant 1
    scene = scenes[2]
    if render:
        things_object_11_look_2 = sapien.render.RenderMaterial(
            base_color=[0.18774131876477196, 0.249168622943024, 0.41122483600846627, 1],
        )
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.022859889452870846, density=1000)
    if render:
        builder.add_sphere_visual(radius=0.022859889452870846, material=things_object_11_look_2)
    builder.initial_pose = sapien.Pose(
        [0.17780427331170492, 0.05294408025366402, 1.233083617344856],
        [0.8843317482147346, 0.2871895679321966, 0.02638940819171603, 0.36712819328632407],
    )
    builder.build(name="things/object_11")

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
