# A script of plain SAPIEN calls, written by scenecc.
#
# shapes: 2 parallel scenes.
# Every shape that there is.
# Two scenes, both the same.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
MUG = HERE / "../../assets/mug.obj"
BOWL = HERE / "../../assets/bowl.obj"
CHECKER = HERE / "../../assets/checker.png"
GEM = HERE / "../../assets/gem.stl"
FILES = [MUG, BOWL, CHECKER, GEM]


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 2 parallel scenes. `render`: build what is seen, too."""
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

    table_physical = physx.PhysxMaterial(static_friction=0.4, dynamic_friction=0.3, restitution=0.5)
    shared_physical = physx.PhysxMaterial(
        static_friction=0.9,
        dynamic_friction=0.8,
        restitution=0.05,
    )

    if render:
        shared_look = sapien.render.RenderMaterial()
        shared_look.base_color_texture = sapien.render.RenderTexture2D(
            str(CHECKER),
            mipmap_levels=4,
            filter_mode="nearest",
            srgb=True,
        )
        shared_look_2 = sapien.render.RenderMaterial(base_color=[0.8, 0.1, 0.1, 1], roughness=0.4)

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

    # table
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(
            pose=sapien.Pose([0, 0, 0.2]),
            half_size=[0.5, 0.5, 0.02],
            material=table_physical,
        )
        builder.add_box_collision(
            pose=sapien.Pose([0.4, 0.4, 0.1]),
            half_size=[0.02, 0.02, 0.1],
            material=table_physical,
        )
        builder.add_box_collision(
            pose=sapien.Pose([-0.4, 0.4, 0.1]),
            half_size=[0.02, 0.02, 0.1],
            material=table_physical,
        )
        if render:
            builder.add_box_visual(
                pose=sapien.Pose([0, 0, 0.2]),
                half_size=[0.5, 0.5, 0.02],
                material=shared_look,
                name="top",
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="table")

    # box
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.04, 0.03], material=shared_physical)
        if render:
            builder.add_box_visual(half_size=[0.05, 0.04, 0.03], material=shared_look_2)
        builder.initial_pose = sapien.Pose([0, 0, 0.4], [0.9238795, 0.3826834, 0, 0])
        builder.build(name="box")

    # ball
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05, material=shared_physical)
        if render:
            builder.add_sphere_visual(radius=0.05, material=shared_look_2)
        builder.initial_pose = sapien.Pose([0.02, 0, 0.55])
        builder.build(name="ball")

    # capsule
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_capsule_collision(radius=0.03, half_length=0.06, material=shared_physical)
        if render:
            builder.add_capsule_visual(radius=0.03, half_length=0.06, material=shared_look_2)
        builder.initial_pose = sapien.Pose([0, 0.02, 0.7])
        builder.build(name="capsule")

    # cylinder
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(radius=0.04, half_length=0.05, material=shared_physical)
        if render:
            builder.add_cylinder_visual(radius=0.04, half_length=0.05, material=shared_look_2)
        builder.initial_pose = sapien.Pose([-0.01, 0, 0.85])
        builder.build(name="cylinder")

    # mug
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_convex_collision_from_file(filename=str(MUG), density=700)
        if render:
            builder.add_visual_from_file(filename=str(MUG))
        builder.initial_pose = sapien.Pose([0.2, 0.2, 0.5])
        entity = builder.build(name="mug")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (0.3 / body.mass)
        body.mass = 0.3

    # gem
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_convex_collision_from_file(filename=str(GEM), scale=[2, 2, 1.5])
        builder.initial_pose = sapien.Pose([0.22, 0.2, 0.7])
        builder.build(name="gem")

    # bowl
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_nonconvex_collision_from_file(filename=str(BOWL))
        builder.initial_pose = sapien.Pose([1, 1, 0])
        builder.build(name="bowl")

    # dropped in the bowl
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.02)
        builder.initial_pose = sapien.Pose([1, 1.01, 0.3])
        builder.build(name="dropped in the bowl")

    # sign
    for scene in scenes:
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "sign"
            shape = sapien.render.RenderShapeTriangleMesh(filename=str(BOWL), scale=[1, -1, 1])
            shape.set_front_face("clockwise")
            look.attach(shape)
            shape = sapien.render.RenderShapeTriangleMesh(filename=str(BOWL), scale=[1, -1, 2])
            shape.set_front_face("clockwise")
            look.attach(shape)
            shape = sapien.render.RenderShapeTriangleMesh(
                vertices=[[-2, -1, 0], [2, -1, 0], [2, 1, 0], [-2, 1, 0]],
                triangles=[[0, 1, 2], [0, 2, 3]],
                normals=[[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]],
                uvs=[[-1.5, -0.5], [2.5, -0.5], [2.5, 1.5], [-1.5, 1.5]],
                material=shared_look,
            )
            shape.name = "tiles"
            look.attach(shape)
            look.visibility = 0.5
            look.shading_mode = 1
            entity.add_component(look)
        entity.name = "sign"
        entity.pose = sapien.Pose([0, 0, 1])
        scene.add_entity(entity)

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
