# A script of plain SAPIEN calls, written by scenecc.
#
# varied: 4 parallel scenes.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
MUG = HERE / "../../assets/mug.obj"
GEM = HERE / "../../assets/gem.stl"
FILES = [MUG, GEM]


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
        scene.timestep = 0.004166666666666667
        scenes.append(scene)

    crate_physical = physx.PhysxMaterial(
        static_friction=0.9,
        dynamic_friction=0.8,
        restitution=0.05,
    )
    crate_physical_2 = physx.PhysxMaterial(
        static_friction=0.1,
        dynamic_friction=0.05,
        restitution=0.6,
    )

    if render:
        crate_look = sapien.render.RenderMaterial(base_color=[1, 0, 0, 1])
        crate_look_2 = sapien.render.RenderMaterial(base_color=[0, 0, 1, 0.5])

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
    crate_half_size = [
        [0.05, 0.05, 0.05],
        [0.06, 0.05, 0.04],
        [0.1, 0.02, 0.02],
        [0.05, 0.05, 0.05],
    ]
    crate_material = [crate_physical, crate_physical_2, crate_physical_2, crate_physical]
    crate_density = [100, 200, 300, 400]
    crate_pose = [
        sapien.Pose([0, 0, 0.1]),
        sapien.Pose([0, 0, 0.2]),
        sapien.Pose([0, 0, 0.3]),
        sapien.Pose([0, 0, 0.4]),
    ]
    crate_mass = [0.1, 0.2, 0.3, 0.4]
    crate_linear_damping = [0, 0.5, 1, 2]
    crate_linear_velocity = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    if render:
        crate_look_3 = [crate_look, crate_look_2, crate_look_2, crate_look]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(
            half_size=crate_half_size[i],
            material=crate_material[i],
            density=crate_density[i],
        )
        if render:
            builder.add_box_visual(half_size=crate_half_size[i], material=crate_look_3[i])
        builder.initial_pose = crate_pose[i]
        entity = builder.build(name="crate")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (crate_mass[i] / body.mass)
        body.mass = crate_mass[i]
        body.linear_damping = crate_linear_damping[i]
        body.linear_velocity = crate_linear_velocity[i]

    # bin, variant 0
    bin_radius = [0.05, 0.07]
    bin_pose = [sapien.Pose([0, 0, 0.5]), sapien.Pose([0.02, 0, 0.7])]
    for i, scene in enumerate(scenes[0:3:2]):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=bin_radius[i])
        builder.initial_pose = bin_pose[i]
        builder.build(name="bin")

    # bin, variant 1
    scene = scenes[1]
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("kinematic")
    builder.add_box_collision(half_size=[0.06, 0.05, 0.04])
    builder.initial_pose = sapien.Pose([0.01, 0, 0.6])
    builder.build(name="bin")

    # bin, variant 2
    scene = scenes[3]
    entity = sapien.Entity()
    if render:
        look = sapien.render.RenderBodyComponent()
        look.name = "bin"
        shape = sapien.render.RenderShapeSphere(
            radius=0.08,
            material=sapien.render.RenderMaterial(),
        )
        look.attach(shape)
        entity.add_component(look)
    entity.name = "bin"
    entity.pose = sapien.Pose([0.03, 0, 0.8])
    scene.add_entity(entity)

    # obstacle
    obstacle_file = [MUG, GEM]
    obstacle_scale = [[1, 1, 1], [1.5, 1.5, 1.5]]
    obstacle_pose = [sapien.Pose([0.3, 0, 0.3]), sapien.Pose([0.3, 0.1, 0.3])]
    obstacle_contact_offset = [0.01, 0.02]
    if render:
        obstacle_scale_2 = [[1, 1, 1], [-1, 1, 1]]
    for i, scene in enumerate(scenes[0:3:2]):
        builder = scene.create_actor_builder()
        builder.add_convex_collision_from_file(
            filename=str(obstacle_file[i]),
            scale=obstacle_scale[i],
        )
        if render:
            builder.add_visual_from_file(filename=str(obstacle_file[i]), scale=obstacle_scale_2[i])
        builder.initial_pose = obstacle_pose[i]
        entity = builder.build(name="obstacle")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.collision_shapes[0].contact_offset = obstacle_contact_offset[i]

    # pin
    pin_scenes = [0, 1, 3]
    pin_pose = [sapien.Pose([0.5, 0, 0.1]), sapien.Pose([0.6, 0, 0.1]), sapien.Pose([0.7, 0, 0.1])]
    for i, scene in enumerate([scenes[k] for k in pin_scenes]):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.02, 0.02, 0.02])
        builder.initial_pose = pin_pose[i]
        builder.build(name="pin")

    # only once
    scene = scenes[2]
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.05)
    builder.initial_pose = sapien.Pose([-0.5, 0, 0.5])
    entity = builder.build(name="only once")
    body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
    body.inertia = body.inertia.astype(float) * (1 / body.mass)
    body.mass = 1

    # peg
    for scene in scenes[1:3]:
        builder = scene.create_actor_builder()
        builder.add_capsule_collision(radius=0.02, half_length=0.1)
        builder.initial_pose = sapien.Pose([1, 0, 0.5])
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
