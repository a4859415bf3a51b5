# A script of plain SAPIEN calls, written by scenecc.
#
# knobs: 2 parallel scenes.
# Every key of a body, one example each.
#
# Run this file, or import it and call build_scenes(). It needs sapien, but not scenecc.
# It finds its files relative to its own folder: move it together with them, or emit it again.

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
MUG = HERE / "../../scenes/assets/mug.obj"
BOWL = HERE / "../../scenes/assets/bowl.obj"
BOWL_2 = HERE / "../../scenes/assets/bowl.glb"
FILES = [MUG, BOWL, BOWL_2]


@contextmanager
def physics_settings() -> Iterator[None]:
    """Sets process-wide defaults of SAPIEN, and restores them once the scenes are built."""
    scene_config = physx.get_scene_config()
    shape_config = physx.get_shape_config()
    body_config = physx.get_body_config()
    sdf_config = physx.get_sdf_config()
    config = physx.get_scene_config()
    config.gravity = [0, 0, -9.81]
    config.bounce_threshold = 0.2
    config.enable_pcm = True
    config.enable_tgs = True
    config.enable_ccd = False
    config.enable_enhanced_determinism = True
    config.enable_friction_every_iteration = True
    physx.set_scene_config(
        gravity=config.gravity,
        bounce_threshold=config.bounce_threshold,
        enable_pcm=config.enable_pcm,
        enable_tgs=config.enable_tgs,
        enable_ccd=config.enable_ccd,
        enable_enhanced_determinism=config.enable_enhanced_determinism,
        enable_friction_every_iteration=config.enable_friction_every_iteration,
        cpu_workers=0,
    )
    config = physx.get_shape_config()
    config.contact_offset = 0.01
    config.rest_offset = 0
    physx.set_shape_config(config)
    config = physx.get_body_config()
    config.solver_position_iterations = 10
    config.solver_velocity_iterations = 1
    config.sleep_threshold = 0.005
    physx.set_body_config(config)
    config = physx.get_sdf_config()
    config.spacing = 0.01
    config.subgridSize = 6
    config.num_threads_for_construction = 4
    physx.set_sdf_config(config)
    try:
        yield
    finally:
        physx.set_scene_config(scene_config)
        physx.set_shape_config(shape_config)
        physx.set_body_config(body_config)
        physx.set_sdf_config(sdf_config)


@physics_settings()
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
        scene.timestep = 0.005
        scenes.append(scene)

    default_material = physx.PhysxMaterial(
        static_friction=0.4,
        dynamic_friction=0.35,
        restitution=0.05,
    )

    if render:
        shape_keys_look = sapien.render.RenderMaterial(base_color=[0.2, 0.4, 0.8, 1])
        mug_look = sapien.render.RenderMaterial(
            base_color=[0.8148465722161012, 0.6866853124353135, 0.38132601143253014, 1],
        )
        poster_look = sapien.render.RenderMaterial(
            base_color=[0.003035269835488375, 0.29177064981753587, 0.3049873140698863, 1],
        )

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            material=default_material,
        )
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
                scale=[10, 4, 4],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # by_density
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(
            half_size=[0.05, 0.05, 0.05],
            material=default_material,
            density=400,
        )
        builder.add_sphere_collision(
            pose=sapien.Pose([0, 0, 0.07]),
            radius=0.03,
            material=default_material,
            density=2000,
        )
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.05])
            builder.add_sphere_visual(pose=sapien.Pose([0, 0, 0.07]), radius=0.03)
        builder.initial_pose = sapien.Pose([0, 0, 0.05])
        builder.build(name="by_density")

    # by_mass
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.05])
        builder.initial_pose = sapien.Pose([0.3, 0, 0.05])
        entity = builder.build(name="by_mass")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (0.25 / body.mass)
        body.mass = 0.25

    # by_inertial
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.05])
        builder.set_mass_and_inertia(0.5, sapien.Pose([0, 0, -0.02]), [0.0008, 0.0008, 0.0006])
        builder.initial_pose = sapien.Pose([0.6, 0, 0.05])
        builder.build(name="by_inertial")

    # shape_keys
    for scene in scenes:
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "shape_keys"
            shape = sapien.render.RenderShapeCapsule(
                radius=0.05,
                half_length=0.08,
                material=shape_keys_look,
            )
            shape.local_pose = sapien.Pose(
                [0, 0, 0],
                [0.7064337722128922, 0.0308435645972319, -0.0308435645972319, 0.7064337722128922],
            )
            shape.name = "body"
            shape.set_front_face("counterclockwise")
            look.attach(shape)
            entity.add_component(look)
        body = physx.PhysxRigidDynamicComponent()
        body.name = "shape_keys"
        shape = physx.PhysxCollisionShapeCapsule(
            radius=0.05,
            half_length=0.08,
            material=default_material,
        )
        shape.local_pose = sapien.Pose(
            [0, 0, 0],
            [0.7064337722128922, 0.0308435645972319, -0.0308435645972319, 0.7064337722128922],
        )
        shape.density = 500
        shape.patch_radius = 0.02
        shape.min_patch_radius = 0.005
        shape.contact_offset = 0.02
        shape.rest_offset = 0.001
        body.attach(shape)
        entity.add_component(body)
        entity.name = "shape_keys"
        entity.pose = sapien.Pose([0.9, 0, 0.06])
        scene.add_entity(entity)

    # thrown
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.04, material=default_material)
        if render:
            builder.add_sphere_visual(radius=0.04)
        builder.initial_pose = sapien.Pose([-0.6, 0.3, 0.5])
        entity = builder.build(name="thrown")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.linear_damping = 0.02
        body.angular_damping = 0.1
        body.max_linear_velocity = 20
        body.max_angular_velocity = 50
        body.max_depenetration_velocity = 3
        body.max_contact_impulse = 10
        body.sleep_threshold = 0.001
        body.solver_position_iterations = 15
        body.solver_velocity_iterations = 2
        body.linear_velocity = [1, 0, 2]
        body.angular_velocity = [0, 0, 6.28]

    # floating
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.03, 0.03, 0.03], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.03, 0.03, 0.03])
        builder.initial_pose = sapien.Pose([-0.6, -0.3, 0.5])
        entity = builder.build(name="floating")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.disable_gravity = True

    # slider
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.05])
        builder.initial_pose = sapien.Pose([-0.3, 0.6, 0.05])
        entity = builder.build(name="slider")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.set_locked_motion_axes([False, True, True, True, True, True])

    # shard_a
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.collision_groups = [2, 1, 0, 0]
        builder.add_box_collision(half_size=[0.03, 0.03, 0.03], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.03, 0.03, 0.03])
        builder.initial_pose = sapien.Pose([0.3, 0.6, 0.03])
        builder.build(name="shard_a")

    # shard_b
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.collision_groups = [2, 1, 0, 0]
        builder.add_box_collision(half_size=[0.03, 0.03, 0.03], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.03, 0.03, 0.03])
        builder.initial_pose = sapien.Pose([0.32, 0.6, 0.03])
        builder.build(name="shard_b")

    # ghost
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.collision_groups = [0, 0, 0, 0]
        builder.add_box_collision(half_size=[0.03, 0.03, 0.03], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.03, 0.03, 0.03])
        builder.initial_pose = sapien.Pose([0.5, 0.6, 0.03])
        entity = builder.build(name="ghost")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.disable_gravity = True

    # paddle
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        builder.add_box_collision(half_size=[0.1, 0.1, 0.01], material=default_material)
        if render:
            builder.add_box_visual(half_size=[0.1, 0.1, 0.01])
        builder.initial_pose = sapien.Pose(
            [2.7755575615628914e-17, 0.2, 0.5],
            [0.6532814871628069, -0.27059803866686, 0.27059803866686005, 0.6532814871628068],
        )
        builder.build(name="paddle")

    # mug
    scene = scenes[0]
    builder = scene.create_actor_builder()
    builder.add_multiple_convex_collisions_from_file(
        filename=str(MUG),
        scale=[1.2, 1.2, 1.2],
        material=default_material,
        density=1500,
    )
    if render:
        builder.add_visual_from_file(filename=str(MUG), scale=[1.2, 1.2, 1.2], material=mug_look)
    builder.initial_pose = sapien.Pose([0.6, -0.5, 0])
    builder.build(name="mug")

    # dish
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_nonconvex_collision_from_file(
            filename=str(BOWL),
            scale=[1.5, 1.5, 1],
            material=default_material,
        )
        if render:
            builder.add_visual_from_file(filename=str(BOWL), scale=[1.5, 1.5, 1])
        builder.initial_pose = sapien.Pose([0.9, -0.5, 0])
        builder.build(name="dish")

    # poster
    for scene in scenes:
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "poster"
            shape = sapien.render.RenderShapeBox(half_size=[0.3, 0.2, 0.005], material=poster_look)
            look.attach(shape)
            shape = sapien.render.RenderShapeTriangleMesh(filename=str(BOWL_2), scale=[-1, 1, 1])
            shape.local_pose = sapien.Pose([0, 0, 0.01])
            shape.set_front_face("clockwise")
            look.attach(shape)
            look.visibility = 0.9
            look.shading_mode = 0
            entity.add_component(look)
        entity.name = "poster"
        entity.pose = sapien.Pose([0, 0.99, 0.6], [0.7071067811865476, 0.7071067811865475, 0, 0])
        scene.add_entity(entity)

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
