# A script of plain SAPIEN calls, written by scenecc.
#
# drawn: 3 parallel scenes.
#
# Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.
# It finds its files relative to its own folder: move it together with them, or emit it again.
# Values that a reset would draw again are those of seed 11.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
CHECKER = HERE / "../../scenes/assets/checker.png"
BUMPS = HERE / "../../scenes/assets/bumps.png"
FILES = [CHECKER, BUMPS]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 3 parallel scenes. `render`: also build visuals."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    scenes: list[sapien.Scene] = []
    for _ in range(3):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    drum_physical = physx.PhysxMaterial(static_friction=0.4, dynamic_friction=0.3, restitution=0.5)

    if render:
        drum_look = sapien.render.RenderMaterial(ior=1.5)

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]))
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]),
                scale=[10, 10, 10],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # crate
    crate_static_friction = [0.9, 0.5, 0.1]
    crate_restitution = [0.1, 0.2, 0.3]
    crate_half_size = [[0.05, 0.05, 0.05], [0.06, 0.05, 0.04], [0.03333333333333333, 0.02, 0.02]]
    crate_pose = [
        sapien.Pose(
            [0.1240835977102498, 0.12525253464476713, 0.4],
            [0.05874820113650113, -0.45784478806272155, 0.26117747178016554, -0.847769501186229],
        ),
        sapien.Pose(
            [0.27835544553376806, -0.06840107409854528, 0.4],
            [0.07779966393740058, 0.8990943154593302, -0.04621035870847936, 0.4283003933549205],
        ),
        sapien.Pose(
            [0.0821736011189906, 0.12282657999393272, 0.4],
            [0.16577272273796803, -0.8710046402199566, 0.4616107474351644, -0.02803281940322188],
        ),
    ]
    crate_angular_velocity = [
        [-0.322966533787834, 0.9991915935497637, 0.13840839527103999],
        [-0.19281487930825358, -1.5015306148718381, 1.037045830366064],
        [-0.1465805192599503, 0.28610564431707575, 0.9053206165923697],
    ]
    if render:
        crate_base_color = [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0.5]]
    for i, scene in enumerate(scenes):
        crate_physical = physx.PhysxMaterial(
            static_friction=crate_static_friction[i],
            dynamic_friction=0.05,
            restitution=crate_restitution[i],
        )
        if render:
            crate_look = sapien.render.RenderMaterial(
                base_color=crate_base_color[i],
                roughness=0.25,
            )
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=crate_half_size[i], material=crate_physical)
        if render:
            builder.add_box_visual(half_size=crate_half_size[i], material=crate_look)
        builder.initial_pose = crate_pose[i]
        entity = builder.build(name="crate")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.angular_velocity = crate_angular_velocity[i]

    # drum
    drum_static_friction = [0.9, 0.5, 0.1]
    drum_restitution = [0.1, 0.2, 0.3]
    drum_physical_number = [0, 1, 0]
    drum_pose = [
        sapien.Pose(
            [0.17687218414212524, -0.08498560364908009, 0.34510655458744094],
            [0.05874820113650113, -0.45784478806272155, 0.26117747178016554, -0.847769501186229],
        ),
        sapien.Pose(
            [0.32470526625409973, -0.28307403019478516, 0.3579617312428902],
            [0.07779966393740058, 0.8990943154593302, -0.04621035870847936, 0.4283003933549205],
        ),
        sapien.Pose(
            [-0.05660577211296615, 0.04534232309642282, 0.2427216623358895],
            [0.16577272273796803, -0.8710046402199566, 0.4616107474351644, -0.02803281940322188],
        ),
    ]
    if render:
        drum_metallic = [0, 0.5, 1]
        drum_base_color_texture = [CHECKER, BUMPS, CHECKER]
        drum_base_color = [[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 0.5]]
        drum_look_number = [0, 1, 2]
    for i, scene in enumerate(scenes):
        drum_physical_2 = physx.PhysxMaterial(
            static_friction=drum_static_friction[i],
            dynamic_friction=0.05,
            restitution=drum_restitution[i],
        )
        if render:
            drum_look_2 = sapien.render.RenderMaterial(metallic=drum_metallic[i])
            drum_look_2.base_color_texture = sapien.render.RenderTexture2D(
                str(drum_base_color_texture[i]),
                filter_mode="nearest",
            )
            drum_look_3 = sapien.render.RenderMaterial(
                base_color=drum_base_color[i],
                roughness=0.25,
            )
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            radius=0.05,
            half_length=0.04,
            material=(drum_physical, drum_physical_2)[drum_physical_number[i]],
        )
        builder.add_sphere_collision(
            pose=sapien.Pose([0, 0, 0.1]),
            radius=0.05,
            material=drum_physical,
        )
        if render:
            builder.add_cylinder_visual(
                radius=0.05,
                half_length=0.04,
                material=(drum_look, drum_look_2, drum_look_3)[drum_look_number[i]],
            )
        builder.initial_pose = drum_pose[i]
        builder.build(name="drum")

    # rock
    rock_pose = [
        sapien.Pose([0.5556413807546426, 0.5565383870660058, 0.4169089403977833]),
        sapien.Pose([0.505455107160803, 0.5776603714291422, 0.4668232225970685]),
    ]
    for i, scene in enumerate(scenes[0:3:2]):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.03)
        builder.initial_pose = rock_pose[i]
        builder.build(name="rock")

    # pebble, variant 1
    scene = scenes[1]
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.02)
    builder.initial_pose = sapien.Pose([0.5627399095625614, 0.577205341888613, 0.44608149446265544])
    entity = builder.build(name="pebble")
    body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
    body.linear_damping = 2

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
