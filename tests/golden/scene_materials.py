# A script of plain SAPIEN calls, written by scenecc.
#
# materials: one scene.
# Surfaces that slide, bounce, shine and carry images.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
CHECKER = HERE / "../../scenes/assets/checker.png"
BUMPS = HERE / "../../scenes/assets/bumps.png"
WEAR = HERE / "../../scenes/assets/wear.png"
GEM = HERE / "../../scenes/assets/gem.stl"
FILES = [CHECKER, BUMPS, WEAR, GEM]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds one scene. `render`: build what is seen, too."""
    for file in FILES:
        if not file.is_file():
            raise FileNotFoundError(file)
    systems = [physx.PhysxCpuSystem()]
    if render:
        systems.append(sapien.render.RenderSystem())
    scene = sapien.Scene(systems)

    ground_physical = physx.PhysxMaterial(
        static_friction=0.8,
        dynamic_friction=0.7,
        restitution=0.6,
    )
    slide_physical = physx.PhysxMaterial(static_friction=0.02, dynamic_friction=0.01, restitution=0)
    bouncer_physical = physx.PhysxMaterial(
        static_friction=0.7,
        dynamic_friction=0.6,
        restitution=0.9,
    )
    crate_physical = physx.PhysxMaterial(
        static_friction=0.5,
        dynamic_friction=0.45,
        restitution=0.05,
    )

    if render:
        ground_look = sapien.render.RenderMaterial(base_color=[1, 1, 1, 1])
        ground_look.base_color_texture = sapien.render.RenderTexture2D(
            str(CHECKER),
            filter_mode="nearest",
            address_mode="repeat",
            srgb=True,
        )
        slide_look = sapien.render.RenderMaterial(
            base_color=[0.8, 0.9, 1, 0.5],
            specular=0.5,
            roughness=0.05,
        )
        puck_look = sapien.render.RenderMaterial(
            base_color=[0.91, 0.76, 0.38, 1],
            roughness=0.25,
            metallic=1,
        )
        bouncer_look = sapien.render.RenderMaterial(
            base_color=[1, 0.4666666666666667, 0, 1],
            roughness=0.9,
        )
        plate_look = sapien.render.RenderMaterial(base_color=[0.72, 0.45, 0.2, 1], metallic=1)
        plate_look.normal_texture = sapien.render.RenderTexture2D(
            str(BUMPS),
            mipmap_levels=4,
            srgb=False,
        )
        plate_look.roughness_texture = sapien.render.RenderTexture2D(str(WEAR))
        plate_look_2 = sapien.render.RenderMaterial(
            base_color=[0.18823529411764706, 0.18823529411764706, 0.18823529411764706, 1],
            metallic=1,
        )
        plate_look_2.normal_texture = sapien.render.RenderTexture2D(
            str(BUMPS),
            mipmap_levels=4,
            srgb=False,
        )
        plate_look_2.roughness_texture = sapien.render.RenderTexture2D(str(WEAR))
        gem_look = sapien.render.RenderMaterial(
            base_color=[1, 1, 1, 1],
            roughness=0.02,
            transmission=0.95,
            ior=1.5,
            transmission_roughness=0,
        )
        bulb_look = sapien.render.RenderMaterial(base_color=[0, 0, 0, 1], emission=[4, 3.6, 3, 1])
        crate_look = sapien.render.RenderMaterial(base_color=[0.6, 0.45, 0.3, 1], roughness=0.8)

    # ground
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_plane_collision(
        pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        material=ground_physical,
    )
    if render:
        builder.add_plane_visual(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            scale=[10, 10, 10],
            material=ground_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, 0])
    builder.build(name="ground")

    # slide
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_box_collision(half_size=[0.5, 0.3, 0.02], material=slide_physical)
    if render:
        builder.add_box_visual(half_size=[0.5, 0.3, 0.02], material=slide_look)
    builder.initial_pose = sapien.Pose([0, 0, 0.2], [0.9914448613738104, 0, 0.13052619222005157, 0])
    builder.build(name="slide")

    # puck
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        radius=0.04,
        half_length=0.015,
        density=8500,
    )
    if render:
        builder.add_cylinder_visual(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.04,
            half_length=0.015,
            material=puck_look,
        )
    builder.initial_pose = sapien.Pose(
        [-0.3, 0, 0.32],
        [0.9914448613738104, 0, 0.13052619222005157, 0],
    )
    builder.build(name="puck")

    # bouncer
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.05, material=bouncer_physical, density=80)
    if render:
        builder.add_sphere_visual(radius=0.05, material=bouncer_look)
    builder.initial_pose = sapien.Pose([0.8, 0, 0.6])
    builder.build(name="bouncer")

    # plate
    builder = scene.create_actor_builder()
    builder.add_cylinder_collision(
        pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        radius=0.08,
        half_length=0.005,
        density=8500,
    )
    builder.add_cylinder_collision(
        pose=sapien.Pose([0, 0, 0.02], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        radius=0.03,
        half_length=0.02,
        density=8500,
    )
    if render:
        builder.add_cylinder_visual(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.08,
            half_length=0.005,
            material=plate_look,
        )
        builder.add_cylinder_visual(
            pose=sapien.Pose([0, 0, 0.02], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.03,
            half_length=0.02,
            material=plate_look_2,
        )
    builder.initial_pose = sapien.Pose([0.8, 0.3, 0.1])
    builder.build(name="plate")

    # gem
    builder = scene.create_actor_builder()
    builder.add_convex_collision_from_file(filename=str(GEM), density=2500)
    if render:
        builder.add_visual_from_file(filename=str(GEM), material=gem_look)
    builder.initial_pose = sapien.Pose([0.8, -0.3, 0.02])
    builder.build(name="gem")

    # bulb
    entity = sapien.Entity()
    if render:
        look = sapien.render.RenderBodyComponent()
        look.name = "bulb"
        shape = sapien.render.RenderShapeSphere(radius=0.03, material=bulb_look)
        look.attach(shape)
        entity.add_component(look)
    entity.name = "bulb"
    entity.pose = sapien.Pose([0, 0, 1])
    scene.add_entity(entity)

    # crate
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.1, 0.1, 0.1], material=crate_physical, density=300)
    if render:
        builder.add_box_visual(half_size=[0.1, 0.1, 0.1], material=crate_look)
    builder.initial_pose = sapien.Pose([0.5, 0.6, 0.1])
    builder.build(name="crate")

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
