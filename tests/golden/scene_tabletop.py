# A script of plain SAPIEN calls, written by scenecc.
#
# tabletop: one scene.
# A table top, a cube and a goal that is only seen.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.

import sapien
from sapien import physx


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds one scene. `render`: build what is seen, too."""
    systems = [physx.PhysxCpuSystem()]
    if render:
        systems.append(sapien.render.RenderSystem())
    scene = sapien.Scene(systems)

    table_physical = physx.PhysxMaterial(static_friction=0.6, dynamic_friction=0.5, restitution=0)
    cube_physical = physx.PhysxMaterial(static_friction=1, dynamic_friction=1, restitution=0.1)

    if render:
        ground_look = sapien.render.RenderMaterial(base_color=[0.5, 0.5, 0.5, 1])
        table_look = sapien.render.RenderMaterial(base_color=[0.62, 0.45, 0.26, 1], roughness=0.7)
        cube_look = sapien.render.RenderMaterial(
            base_color=[0.8392156862745098, 0.1568627450980392, 0.1568627450980392, 1],
            roughness=0.9,
        )
        goal_look = sapien.render.RenderMaterial(base_color=[0.1, 0.8, 0.2, 0.6])

    # ground
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("static")
    builder.add_plane_collision(
        pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
    )
    if render:
        builder.add_plane_visual(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            scale=[10, 5, 5],
            material=ground_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, -0.92])
    builder.build(name="ground")

    # table
    builder = scene.create_actor_builder()
    builder.set_physx_body_type("kinematic")
    builder.add_box_collision(
        pose=sapien.Pose([0, 0, -0.02]),
        half_size=[0.6, 1.2, 0.02],
        material=table_physical,
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.55, 1.15, -0.48]),
        half_size=[0.03, 0.03, 0.44],
        material=table_physical,
    )
    builder.add_box_collision(
        pose=sapien.Pose([0.55, -1.15, -0.48]),
        half_size=[0.03, 0.03, 0.44],
        material=table_physical,
    )
    builder.add_box_collision(
        pose=sapien.Pose([-0.55, 1.15, -0.48]),
        half_size=[0.03, 0.03, 0.44],
        material=table_physical,
    )
    builder.add_box_collision(
        pose=sapien.Pose([-0.55, -1.15, -0.48]),
        half_size=[0.03, 0.03, 0.44],
        material=table_physical,
    )
    if render:
        builder.add_box_visual(
            pose=sapien.Pose([0, 0, -0.02]),
            half_size=[0.6, 1.2, 0.02],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.55, 1.15, -0.48]),
            half_size=[0.03, 0.03, 0.44],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([0.55, -1.15, -0.48]),
            half_size=[0.03, 0.03, 0.44],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([-0.55, 1.15, -0.48]),
            half_size=[0.03, 0.03, 0.44],
            material=table_look,
        )
        builder.add_box_visual(
            pose=sapien.Pose([-0.55, -1.15, -0.48]),
            half_size=[0.03, 0.03, 0.44],
            material=table_look,
        )
    builder.initial_pose = sapien.Pose([0, 0, 0])
    builder.build(name="table")

    # cube
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.02, 0.02, 0.02], material=cube_physical, density=1100)
    if render:
        builder.add_box_visual(half_size=[0.02, 0.02, 0.02], material=cube_look)
    builder.initial_pose = sapien.Pose(
        [-0.1, 0, 0.02],
        [0.9659258262890683, 0, 0, 0.25881904510252074],
    )
    builder.build(name="cube")

    # goal
    entity = sapien.Entity()
    if render:
        look = sapien.render.RenderBodyComponent()
        look.name = "goal"
        shape = sapien.render.RenderShapeCylinder(
            radius=0.05,
            half_length=0.001,
            material=goal_look,
        )
        shape.local_pose = sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0])
        look.attach(shape)
        entity.add_component(look)
    entity.name = "goal"
    entity.pose = sapien.Pose([0.15, 0.1, 0.001])
    scene.add_entity(entity)

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
