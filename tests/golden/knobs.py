# A script of plain SAPIEN calls, written by scenecc.
#
# knobs: 2 parallel scenes.
# Every knob, on a small moon.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# Scene spacing and GPU memory are left out: they concern scenes that share a GPU simulation.

from collections.abc import Iterator
from contextlib import contextmanager

import sapien
from sapien import physx


@contextmanager
def physics_settings() -> Iterator[None]:
    """SAPIEN keeps these for the whole process: they are put back once the scenes are built."""
    scene_config = physx.get_scene_config()
    shape_config = physx.get_shape_config()
    body_config = physx.get_body_config()
    sdf_config = physx.get_sdf_config()
    config = physx.get_scene_config()
    config.gravity = [0.1, 0, -3.7]
    config.bounce_threshold = 0.5
    config.enable_pcm = False
    config.enable_tgs = False
    config.enable_ccd = True
    config.enable_enhanced_determinism = True
    config.enable_friction_every_iteration = False
    physx.set_scene_config(
        gravity=config.gravity,
        bounce_threshold=config.bounce_threshold,
        enable_pcm=config.enable_pcm,
        enable_tgs=config.enable_tgs,
        enable_ccd=config.enable_ccd,
        enable_enhanced_determinism=config.enable_enhanced_determinism,
        enable_friction_every_iteration=config.enable_friction_every_iteration,
        cpu_workers=1,
    )
    config = physx.get_shape_config()
    config.contact_offset = 0.015
    config.rest_offset = 0.001
    physx.set_shape_config(config)
    config = physx.get_body_config()
    config.solver_position_iterations = 15
    config.solver_velocity_iterations = 2
    config.sleep_threshold = 0.002
    physx.set_body_config(config)
    config = physx.get_sdf_config()
    config.spacing = 0.02
    config.subgridSize = 4
    config.num_threads_for_construction = 1
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
    """Builds 2 parallel scenes. `render`: build what is seen, too."""
    scenes: list[sapien.Scene] = []
    for _ in range(2):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scene.timestep = 0.005
        scenes.append(scene)

    default_material = physx.PhysxMaterial(
        static_friction=0.7,
        dynamic_friction=0.6,
        restitution=0.3,
    )

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(
            pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]),
            material=default_material,
        )
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0]),
                scale=[10, 10, 10],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # busy
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.collision_groups = [3, 1, 0, 7]
        builder.add_box_collision(
            pose=sapien.Pose([0, 0, 0.01]),
            half_size=[0.1, 0.1, 0.1],
            material=default_material,
            density=300,
            patch_radius=0.1,
            min_patch_radius=0.01,
        )
        builder.add_sphere_collision(
            pose=sapien.Pose([0, 0, 0.2]),
            radius=0.1,
            material=default_material,
        )
        builder.initial_pose = sapien.Pose([0, 0, 0.5])
        entity = builder.build(name="busy")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (2.5 / body.mass)
        body.mass = 2.5
        body.collision_shapes[0].contact_offset = 0.03
        body.collision_shapes[0].rest_offset = 0.005
        body.collision_shapes[1].contact_offset = 0.05
        body.set_locked_motion_axes([False, False, False, True, False, True])
        body.linear_damping = 0.1
        body.angular_damping = 0.3
        body.max_linear_velocity = 3
        body.max_angular_velocity = 20
        body.max_depenetration_velocity = 1.5
        body.max_contact_impulse = 1000
        body.sleep_threshold = 0.001
        body.solver_position_iterations = 20
        body.solver_velocity_iterations = 3
        body.linear_velocity = [0.5, 0, 1]
        body.angular_velocity = [0, 3, 0]

    # heavy
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.1, 0.1, 0.1], material=default_material)
        builder.set_mass_and_inertia(
            4,
            sapien.Pose([0.01, 0, -0.02], [0.7071068, 0.7071068, 0, 0]),
            [0.1, 0.2, 0.15],
        )
        builder.initial_pose = sapien.Pose([0.05, 0, 1.1])
        builder.build(name="heavy")

    # floating
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.2, material=default_material)
        builder.initial_pose = sapien.Pose([1, 0, 1])
        entity = builder.build(name="floating")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.disable_gravity = True
        body.linear_velocity = [0.1, 0, 0]

    # pusher
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        builder.collision_groups = [1, 3, 0, 0]
        builder.add_box_collision(half_size=[0.1, 0.1, 0.1], material=default_material)
        builder.initial_pose = sapien.Pose([0.2, 0.1, 0.1])
        entity = builder.build(name="pusher")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.max_contact_impulse = 5

    # seen
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(
            pose=sapien.Pose([0, 0, 0.01]),
            half_size=[0.1, 0.1, 0.1],
            material=default_material,
            density=300,
            patch_radius=0.1,
            min_patch_radius=0.01,
        )
        builder.add_box_collision(
            pose=sapien.Pose([0, 0, 0.01]),
            half_size=[0.1, 0.1, 0.1],
            material=default_material,
            density=300,
            patch_radius=0.1,
            min_patch_radius=0.01,
        )
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.01]),
                half_size=[0.1, 0.1, 0.1],
                name="lid",
            )
        builder.initial_pose = sapien.Pose([-1, 0, 0.5])
        entity = builder.build(name="seen")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        for shape in body.collision_shapes:
            shape.contact_offset = 0.03
            shape.rest_offset = 0.005
        if render:
            look = entity.find_component_by_type(sapien.render.RenderBodyComponent)
            look.visibility = 0.3

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
