# A script of plain SAPIEN calls, written by scenecc.
#
# cones: 4 parallel scenes.
# A ball is rolled into a row of traffic cones; its size and speed differ by scene.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# What a reset would draw anew is as the seed 0 draws it.

from typing import Any

import numpy as np
import sapien
from numpy.typing import NDArray
from sapien import physx


def revolved_points(profile: Any, turn: float = 0.0) -> NDArray[Any]:
    """The corners of a profile turned about x, (corners, 32, 3) [m].

    `turn`: where the circles begin, in steps from one of their corners to the next.
    """
    x, radius = np.array(profile, np.float64).T[:, :, None]
    angle = (np.arange(32) + turn) * (2 * np.pi / 32)
    y, z = radius * np.cos(angle), radius * np.sin(angle)
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)


def revolved_parts(profile: Any) -> list[NDArray[Any]]:
    """Convex parts of a solid of revolution, each (V, 3) [m]: 1 if it touches x, 32 otherwise."""
    circles = revolved_points(profile)
    radii = [radius for _, radius in profile]
    if min(radii) == 0:
        corners = zip(circles, radii, strict=True)
        return [np.concatenate([circle if radius else circle[:1] for circle, radius in corners])]
    return [np.concatenate([circles[:, side - 1], circles[:, side]]) for side in range(32)]


def revolved_shapes(profile: Any, scale: Any, material: physx.PhysxMaterial) -> list[Any]:
    """Convex shapes of a profile (x, radius) that is turned about x, and scaled."""
    make = physx.PhysxCollisionShapeConvexMesh
    return [make(part, scale, material) for part in revolved_parts(profile)]


def revolved_surface(profile: Any) -> tuple[NDArray[Any], ...]:
    """What is seen of a solid of revolution: round about x, an edge at each corner of its profile.

    Returns:
        Vertices (V, 3) [m], triangles (T, 3) counterclockwise from outside, normals (V, 3), and
        texture coordinates (V, 2), which are all (0, 0).
    """
    vertices: list[NDArray[Any]] = []
    normals: list[NDArray[Any]] = []
    triangles: list[NDArray[Any]] = []
    here = np.arange(32)
    there = (here + 1) % 32
    for start, end in zip(profile, (*profile[1:], profile[0]), strict=True):
        if not start[1] and not end[1]:
            continue
        along, away = end[0] - start[0], end[1] - start[1]
        normal = np.array([-away, along]) / np.hypot(along, away)
        first = 32 * len(vertices)
        for (x, radius), half in ((start, -0.5), (end, 0.5)):
            turn = 0.0 if radius else half  # a tip has the normals of the middles of its triangles
            vertices.append(revolved_points([(x, radius)], turn)[0])
            normals.append(revolved_points([normal], turn)[0])
        if start[1]:
            triangles.append(first + np.stack([here, there, 32 + here], axis=1))
        if end[1]:
            triangles.append(first + np.stack([there, 32 + there, 32 + here], axis=1))
    points = np.concatenate(vertices)
    uvs = np.zeros((len(points), 2))
    return points, np.concatenate(triangles), np.concatenate(normals), uvs


def revolved_visual(profile: Any, material: sapien.render.RenderMaterial) -> Any:
    """What is seen of a profile (x, radius) that is turned about x."""
    return sapien.render.RenderShapeTriangleMesh(*revolved_surface(profile), material)


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 4 parallel scenes. `render`: build what is seen, too."""
    scenes: list[sapien.Scene] = []
    for _ in range(4):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    if render:
        cone_look = sapien.render.RenderMaterial(base_color=[0.1, 0.1, 0.1, 1])
        cone_look_2 = sapien.render.RenderMaterial(base_color=[1, 0.4, 0.05, 1])
        ball_look = sapien.render.RenderMaterial(base_color=[0.1, 0.3, 0.9, 1])

    # ground
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_plane_collision(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
        )
        if render:
            builder.add_plane_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
                scale=[10, 10, 10],
            )
        builder.initial_pose = sapien.Pose([0, 0, 0])
        builder.build(name="ground")

    # cone_0 to cone_4
    cone_names = [f"cone_{k}" for k in range(5)]
    cone_pose = [
        sapien.Pose([-0.6, 0, 0]),
        sapien.Pose([-0.3, 0, 0]),
        sapien.Pose([0, 0, 0]),
        sapien.Pose([0.29999999999999993, 0, 0]),
        sapien.Pose([0.6, 0, 0]),
    ]
    for k, name in enumerate(cone_names):
        for scene in scenes:
            entity = sapien.Entity()
            if render:
                look = sapien.render.RenderBodyComponent()
                look.name = name
                shape = sapien.render.RenderShapeBox(half_size=[0.1, 0.1, 0.01], material=cone_look)
                shape.local_pose = sapien.Pose([0, 0, 0.01])
                look.attach(shape)
                shape = revolved_visual(
                    profile=[[-0.15, 0], [-0.15, 0.08], [0.15, 0]],
                    material=cone_look_2,
                )
                shape.local_pose = sapien.Pose(
                    [0, 0, 0.17],
                    [0.7071067811865475, 0, -0.7071067811865475, 0],
                )
                look.attach(shape)
                entity.add_component(look)
            body = physx.PhysxRigidDynamicComponent()
            body.name = name
            shape = physx.PhysxCollisionShapeBox(
                half_size=[0.1, 0.1, 0.01],
                material=physx.get_default_material(),
            )
            shape.local_pose = sapien.Pose([0, 0, 0.01])
            shape.density = 150
            body.attach(shape)
            parts = revolved_shapes(
                profile=[[-1, 0], [-1, 1], [1, 0]],
                scale=[0.15, 0.08, 0.08],
                material=physx.get_default_material(),
            )
            for shape in parts:
                shape.local_pose = sapien.Pose(
                    [0, 0, 0.17],
                    [0.7071067811865475, 0, -0.7071067811865475, 0],
                )
                shape.density = 150
                body.attach(shape)
            entity.add_component(body)
            entity.name = name
            entity.pose = cone_pose[k]
            scene.add_entity(entity)

    # ball
    ball_radius = [
        0.11277198180639078,
        0.0968304794395126,
        0.08300648734213167,
        0.10091705720640634,
    ]
    ball_linear_velocity = [
        [0, 2.6498841351982776, 0],
        [0, 3.5901644433604085, 0],
        [0, 2.089669832139565, 0],
        [0, 3.7884472871533017, 0],
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=ball_radius[i])
        if render:
            builder.add_sphere_visual(radius=ball_radius[i], material=ball_look)
        builder.initial_pose = sapien.Pose([-0.3, -1, 0.12])
        entity = builder.build(name="ball")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.linear_velocity = ball_linear_velocity[i]

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
