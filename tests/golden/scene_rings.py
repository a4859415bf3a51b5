# A script of plain SAPIEN calls, written by scenecc.
#
# rings: 4 parallel scenes.
# Rings of falling size are dropped over a peg that ends in a cone; how far off they begin differs
# by scene.
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
        stand_look = sapien.render.RenderMaterial(base_color=[0.8, 0.65, 0.4, 1])
        ring_look = sapien.render.RenderMaterial(base_color=[0.9, 0.3, 0.2, 1])
        ring_look_2 = sapien.render.RenderMaterial(base_color=[0.7, 0.3, 0.4, 1])
        ring_look_3 = sapien.render.RenderMaterial(base_color=[0.5, 0.3, 0.6000000000000001, 1])
        ring_look_4 = sapien.render.RenderMaterial(base_color=[0.29999999999999993, 0.3, 0.8, 1])

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

    # stand
    for scene in scenes:
        entity = sapien.Entity()
        if render:
            look = sapien.render.RenderBodyComponent()
            look.name = "stand"
            shape = sapien.render.RenderShapeCylinder(
                radius=0.1,
                half_length=0.01,
                material=stand_look,
            )
            shape.local_pose = sapien.Pose(
                [0, 0, 0.01],
                [0.7071067811865475, 0, -0.7071067811865475, 0],
            )
            look.attach(shape)
            shape = sapien.render.RenderShapeCylinder(
                radius=0.02,
                half_length=0.1,
                material=stand_look,
            )
            shape.local_pose = sapien.Pose(
                [0, 0, 0.12],
                [0.7071067811865475, 0, -0.7071067811865475, 0],
            )
            look.attach(shape)
            shape = revolved_visual(
                profile=[[-0.02, 0], [-0.02, 0.02], [0.02, 0]],
                material=stand_look,
            )
            shape.local_pose = sapien.Pose(
                [0, 0, 0.24],
                [0.7071067811865475, 0, -0.7071067811865475, 0],
            )
            look.attach(shape)
            entity.add_component(look)
        body = physx.PhysxRigidStaticComponent()
        body.name = "stand"
        shape = physx.PhysxCollisionShapeCylinder(
            radius=0.1,
            half_length=0.01,
            material=physx.get_default_material(),
        )
        shape.local_pose = sapien.Pose(
            [0, 0, 0.01],
            [0.7071067811865475, 0, -0.7071067811865475, 0],
        )
        body.attach(shape)
        shape = physx.PhysxCollisionShapeCylinder(
            radius=0.02,
            half_length=0.1,
            material=physx.get_default_material(),
        )
        shape.local_pose = sapien.Pose(
            [0, 0, 0.12],
            [0.7071067811865475, 0, -0.7071067811865475, 0],
        )
        body.attach(shape)
        parts = revolved_shapes(
            profile=[[-1, 0], [-1, 1], [1, 0]],
            scale=[0.02, 0.02, 0.02],
            material=physx.get_default_material(),
        )
        for shape in parts:
            shape.local_pose = sapien.Pose(
                [0, 0, 0.24],
                [0.7071067811865475, 0, -0.7071067811865475, 0],
            )
            body.attach(shape)
        entity.add_component(body)
        entity.name = "stand"
        entity.pose = sapien.Pose([0, 0, 0])
        scene.add_entity(entity)

    # ring_0 to ring_3
    ring_names = [f"ring_{k}" for k in range(4)]
    ring_profile_2 = [
        [[-1, 0.3333333333333333], [-1, 1], [1, 1], [1, 0.3333333333333333]],
        [[-1, 0.3846153846153846], [-1, 1], [1, 1], [1, 0.3846153846153846]],
        [[-1, 0.45454545454545453], [-1, 1], [1, 1], [1, 0.45454545454545453]],
        [[-1, 0.5555555555555556], [-1, 1], [1, 1], [1, 0.5555555555555556]],
    ]
    ring_scale = [
        [0.015, 0.09, 0.09],
        [0.015, 0.078, 0.078],
        [0.015, 0.066, 0.066],
        [0.015, 0.05399999999999999, 0.05399999999999999],
    ]
    ring_pose = [
        [
            sapien.Pose([-0.0009474190067125113, 0.005263910727109973, 0.3]),
            sapien.Pose([0.00300808941825427, 0.00737928153464097, 0.3]),
            sapien.Pose([0.002811031996105825, 0.0059050212303812, 0.3]),
            sapien.Pose([0.00029054262397685236, 0.004589911140367239, 0.3]),
        ],
        [
            sapien.Pose([0.0026051940084770332, 0.00759889460506063, 0.36]),
            sapien.Pose([0.001406558497658316, 0.0022272428389847783, 0.36]),
            sapien.Pose([0.00092707894634147, 0.004784805790136154, 0.36]),
            sapien.Pose([-0.0006156391270666665, -0.006579272130038597, 0.36]),
        ],
        [
            sapien.Pose([0.003298528827542023, 0.006766197299558806, 0.42]),
            sapien.Pose([0.003808066670108981, 0.002452202403232408, 0.42]),
            sapien.Pose([0.0008297407086302767, -0.003903611185016205, 0.42]),
            sapien.Pose([0.0065629668052539485, -0.0014976962112635498, 0.42]),
        ],
        [
            sapien.Pose([-0.0073565333352195806, 0.0034594918620849645, 0.48]),
            sapien.Pose([-0.0015890266311734177, 0.002661373361308686, 0.48]),
            sapien.Pose([0.006760627456045195, -0.004855803871068411, 0.48]),
            sapien.Pose([-0.0006551262401071267, -0.002477258090225684, 0.48]),
        ],
    ]
    if render:
        ring_profile = [
            [[-0.015, 0.03], [-0.015, 0.09], [0.015, 0.09], [0.015, 0.03]],
            [[-0.015, 0.03], [-0.015, 0.078], [0.015, 0.078], [0.015, 0.03]],
            [[-0.015, 0.03], [-0.015, 0.066], [0.015, 0.066], [0.015, 0.03]],
            [
                [-0.015, 0.03],
                [-0.015, 0.05399999999999999],
                [0.015, 0.05399999999999999],
                [0.015, 0.03],
            ],
        ]
        ring_look_5 = [ring_look, ring_look_2, ring_look_3, ring_look_4]
    for k, name in enumerate(ring_names):
        for i, scene in enumerate(scenes):
            entity = sapien.Entity()
            if render:
                look = sapien.render.RenderBodyComponent()
                look.name = name
                shape = revolved_visual(profile=ring_profile[k], material=ring_look_5[k])
                shape.local_pose = sapien.Pose(
                    [0, 0, 0],
                    [0.7071067811865475, 0, -0.7071067811865475, 0],
                )
                look.attach(shape)
                entity.add_component(look)
            body = physx.PhysxRigidDynamicComponent()
            body.name = name
            parts = revolved_shapes(
                profile=ring_profile_2[k],
                scale=ring_scale[k],
                material=physx.get_default_material(),
            )
            for shape in parts:
                shape.local_pose = sapien.Pose(
                    [0, 0, 0],
                    [0.7071067811865475, 0, -0.7071067811865475, 0],
                )
                shape.density = 600
                body.attach(shape)
            entity.add_component(body)
            entity.name = name
            entity.pose = ring_pose[k][i]
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
