# A script of plain SAPIEN calls, written by scenecc.
#
# components: 2 parallel scenes.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

from pathlib import Path

import sapien
from sapien import physx

HERE = Path(__file__).resolve().parent
MUG = HERE / "../../assets/mug.obj"
BOWL = HERE / "../../assets/bowl.obj"
FILES = [MUG, BOWL]


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

    # slab
    for scene in scenes:
        entity = sapien.Entity()
        body = physx.PhysxRigidStaticComponent()
        body.name = "slab"
        shape = physx.PhysxCollisionShapePlane(material=physx.get_default_material())
        shape.local_pose = sapien.Pose([0, 0, 0], [0.7071068, 0, -0.7071068, 0])
        shape.density = 5
        body.attach(shape)
        entity.add_component(body)
        entity.name = "slab"
        entity.pose = sapien.Pose([0, 0, 0])
        scene.add_entity(entity)

    # moved
    for scene in scenes:
        entity = sapien.Entity()
        body = physx.PhysxRigidDynamicComponent()
        body.name = "moved"
        body.kinematic = True
        shape = physx.PhysxCollisionShapeTriangleMesh(
            filename=str(BOWL),
            scale=[2, 2, 2],
            material=physx.get_default_material(),
            sdf=True,
        )
        body.attach(shape)
        entity.add_component(body)
        entity.name = "moved"
        entity.pose = sapien.Pose([0, 0, 0.05])
        scene.add_entity(entity)

    # chair
    if render:
        chair_vertices = [
            [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
            [[-2, -1, 0], [2, -1, 0], [2, 1, 0], [-2, 1, 0]],
        ]
    for i, scene in enumerate(scenes):
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "chair"
            shape = sapien.render.RenderShapeBox(
                half_size=[0.1, 0.1, 0.1],
                material=sapien.render.RenderMaterial(),
            )
            shape.set_front_face("clockwise")
            look.attach(shape)
            shape = sapien.render.RenderShapeTriangleMesh(
                vertices=chair_vertices[i],
                triangles=[[0, 1, 2], [0, 2, 3]],
                normals=[[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1]],
                uvs=[[-1, -1], [2, -1], [2, 2], [-1, 2]],
                material=sapien.render.RenderMaterial(),
            )
            look.attach(shape)
            entity.add_component(look)
        body = physx.PhysxRigidDynamicComponent()
        body.name = "chair"
        parts = physx.PhysxCollisionShapeConvexMesh.load_multiple(
            filename=str(MUG),
            scale=[1, 1, 1],
            material=physx.get_default_material(),
        )
        for shape in parts:
            shape.local_pose = sapien.Pose([0, 0, 0.01])
            shape.set_collision_groups([1, 1, 2, 0])
            shape.density = 400
            shape.contact_offset = 0.02
            body.attach(shape)
        shape = physx.PhysxCollisionShapeBox(
            half_size=[0.02, 0.02, 0.02],
            material=physx.get_default_material(),
        )
        shape.local_pose = sapien.Pose([0.2, 0, 0])
        shape.set_collision_groups([1, 1, 2, 0])
        shape.rest_offset = 0.001
        body.attach(shape)
        body.inertia = body.inertia.astype(float) * (1.5 / body.mass)
        body.mass = 1.5
        body.linear_damping = 0.2
        entity.add_component(body)
        entity.name = "chair"
        entity.pose = sapien.Pose([0, 0, 0.6])
        scene.add_entity(entity)

    # whole
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_multiple_convex_collisions_from_file(filename=str(MUG), scale=[1, 1, 2])
        builder.initial_pose = sapien.Pose([1, 0, 0.6])
        builder.build(name="whole")

    # given
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_multiple_convex_collisions_from_file(filename=str(MUG))
        builder.add_sphere_collision(radius=0.1)
        builder.set_mass_and_inertia(1, sapien.Pose([0, 0, 0]), [0.01, 0.01, 0.01])
        builder.initial_pose = sapien.Pose([2, 0, 0.6])
        builder.build(name="given")

    # weighed
    for scene in scenes:
        entity = sapien.Entity()
        body = physx.PhysxRigidDynamicComponent()
        body.name = "weighed"
        parts = physx.PhysxCollisionShapeConvexMesh.load_multiple(
            filename=str(MUG),
            scale=[1, 1, 1],
            material=physx.get_default_material(),
        )
        for shape in parts:
            shape.rest_offset = 0.002
            body.attach(shape)
        body.mass = 1
        body.cmass_local_pose = sapien.Pose([0, 0, 0])
        body.inertia = [0.01, 0.01, 0.01]
        entity.add_component(body)
        entity.name = "weighed"
        entity.pose = sapien.Pose([3, 0, 0.6])
        scene.add_entity(entity)

    # fell
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.1, 0.1, 0.1])
        builder.add_sphere_collision(radius=0.11)
        builder.initial_pose = sapien.Pose([4, 0, 0.6])
        entity = builder.build(name="fell")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.angular_velocity = [1, 2, 3]

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
