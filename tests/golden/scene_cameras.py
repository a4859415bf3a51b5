# A script of plain SAPIEN calls, written by scenecc.
#
# cameras: 4 parallel scenes.
# A table top with a crate, seen from outside, from above and from the crate itself.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# What a reset would draw anew is as the seed 0 draws it.

import sapien
from sapien import physx


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
        table_look = sapien.render.RenderMaterial(base_color=[0.8, 0.6, 0.4, 1])
        crate_look = sapien.render.RenderMaterial(base_color=[0.2, 0.4, 0.8, 1])
        goal_look = sapien.render.RenderMaterial(base_color=[0.2, 0.8, 0.2, 1])

    # What constraints, lights and cameras hold on to, by scene and name.
    held = {}

    # table
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=[0.5, 0.5, 0.02])
        if render:
            builder.add_box_visual(half_size=[0.5, 0.5, 0.02], material=table_look)
        builder.initial_pose = sapien.Pose([0, 0, -0.02])
        builder.build(name="table")

    # crate
    crate_pose = [
        sapien.Pose([0.020437215804062936, -0.07919374071082963, 0.05]),
        sapien.Pose([-0.12936613490408516, 0.1861811092777359, 0.05]),
        sapien.Pose([-0.17492331460205618, -0.04323406604939534, 0.05]),
        sapien.Pose([0.004073253270006433, -0.13490838407313493, 0.05]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05])
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.05], material=crate_look)
        builder.initial_pose = crate_pose[i]
        entity = builder.build(name="crate")
        held[scene, "crate"] = entity

    # goal
    # Only people see it: who takes pictures for sensors sets its visibility to 0 meanwhile.
    for scene in scenes:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("kinematic")
        if render:
            builder.add_sphere_visual(radius=0.02, material=goal_look)
        builder.initial_pose = sapien.Pose([0.3, 0.3, 0.02])
        builder.build(name="goal")

    if render:
        # Surroundings
        for scene in scenes:
            scene.set_ambient_light([0.2, 0.2, 0.25])

    if render:
        # sun
        for scene in scenes:
            light = sapien.render.RenderDirectionalLightComponent()
            light.color = [1.5, 1.5, 1.4]
            light.shadow = True
            light.shadow_near = -10
            light.shadow_far = 10
            light.shadow_half_size = 2
            light.shadow_map_size = 2048
            light.name = "sun"
            entity = sapien.Entity()
            entity.name = "sun"
            entity.add_component(light)
            entity.set_pose(
                sapien.Pose(
                    [0, 0, 0],
                    [0.8391210551713809, 0, 0.4865189449697256, 0.2432594724848628],
                ),
            )
            scene.add_entity(entity)

        # lamp
        lamp_color = [
            [1.404901653826792, 0.6110231077062672, 0.6212868990335573],
            [1.1848811232558787, 1.3522017168618703, 1.9250117838015834],
            [1.3936331421228054, 1.8088250724103654, 1.9065989737271232],
            [1.193220152180844, 0.6931180797362613, 1.9257038272820222],
        ]
        for i, scene in enumerate(scenes):
            light = sapien.render.RenderPointLightComponent()
            light.color = lamp_color[i]
            light.shadow = False
            light.shadow_near = 0.1
            light.shadow_far = 10
            light.shadow_map_size = 2048
            light.name = "lamp"
            entity = sapien.Entity()
            entity.name = "lamp"
            entity.add_component(light)
            entity.set_pose(sapien.Pose([0, 0, 1]))
            scene.add_entity(entity)

        # spot
        spot_pose = [
            sapien.Pose(
                [0.020437215804062936, -0.07919374071082963, 0.65],
                [0.7071067811865476, 0, 0.7071067811865475, 0],
            ),
            sapien.Pose(
                [-0.12936613490408516, 0.1861811092777359, 0.65],
                [0.7071067811865476, 0, 0.7071067811865475, 0],
            ),
            sapien.Pose(
                [-0.17492331460205618, -0.04323406604939534, 0.65],
                [0.7071067811865476, 0, 0.7071067811865475, 0],
            ),
            sapien.Pose(
                [0.004073253270006433, -0.13490838407313493, 0.65],
                [0.7071067811865476, 0, 0.7071067811865475, 0],
            ),
        ]
        for i, scene in enumerate(scenes):
            light = sapien.render.RenderSpotLightComponent()
            light.color = [3, 3, 3]
            light.shadow = False
            light.shadow_near = 0.1
            light.shadow_far = 10
            light.shadow_map_size = 2048
            light.inner_fov = 0.3490658503988659
            light.outer_fov = 0.6981317007977318
            light.name = "spot"
            entity = sapien.Entity()
            entity.name = "spot"
            entity.add_component(light)
            entity.set_pose(spot_pose[i])
            scene.add_entity(entity)

        # headlight
        for scene in scenes:
            light = sapien.render.RenderSpotLightComponent()
            light.color = [2, 0, 0]
            light.shadow = False
            light.shadow_near = 0.1
            light.shadow_far = 10
            light.shadow_map_size = 2048
            light.inner_fov = 0.5
            light.outer_fov = 0.9
            light.name = "headlight"
            held[scene, "crate"].add_component(light)
            light.local_pose = sapien.Pose([0, 0, 0])

    if render:
        # main
        for scene in scenes:
            camera = sapien.render.RenderCameraComponent(160, 120)
            camera.set_fovy(0.8726646259971648, compute_x=True)
            camera.near = 0.01
            camera.far = 100
            camera.name = "main"
            entity = sapien.Entity()
            entity.name = "main"
            entity.add_component(camera)
            entity.set_pose(
                sapien.Pose(
                    [1.2, 0.2, 0.8],
                    [
                        -0.0790164286769533,
                        -0.2857878796469034,
                        -0.0236525280481408,
                        0.954736743695873,
                    ],
                ),
            )
            scene.add_entity(entity)

        # above
        for scene in scenes:
            camera = sapien.render.RenderCameraComponent(128, 128)
            top = 0.6
            right = top * 128 / 128
            camera.set_orthographic_parameters(0.01, 100, -right, right, -top, top)
            camera.name = "above"
            entity = sapien.Entity()
            entity.name = "above"
            entity.add_component(camera)
            entity.set_pose(sapien.Pose([0, 0, 2], [0.7071067811865476, 0, 0.7071067811865475, 0]))
            scene.add_entity(entity)

        # eye
        for scene in scenes:
            camera = sapien.render.RenderCameraComponent(128, 96)
            camera.set_perspective_parameters(0.01, 100, 110, 110, 64, 48, 0)
            camera.name = "eye"
            held[scene, "crate"].add_component(camera)
            camera.local_pose = sapien.Pose(
                [0.06, 0, 0.02],
                [0.9961946980917455, 0, 0.08715574274765817, 0],
            )

        # side_0
        side_0_fovx = [0.899113590375211, 1.083962495302016]
        for i, scene in enumerate(scenes[0:3:2]):
            camera = sapien.render.RenderCameraComponent(128, 96)
            camera.set_fovx(side_0_fovx[i], compute_y=True)
            camera.near = 0.01
            camera.far = 100
            camera.name = "side_0"
            entity = sapien.Entity()
            entity.name = "side_0"
            entity.add_component(camera)
            entity.set_pose(
                sapien.Pose(
                    [0, -1, 0.4],
                    [
                        0.6943480198872284,
                        -0.13371921058204453,
                        0.13371921058204453,
                        0.6943480198872284,
                    ],
                ),
            )
            scene.add_entity(entity)

        # side_1
        side_1_fovx = [1.2207841076022177, 1.0160874318026747]
        for i, scene in enumerate(scenes[0:3:2]):
            camera = sapien.render.RenderCameraComponent(128, 96)
            camera.set_fovx(side_1_fovx[i], compute_y=True)
            camera.near = 0.01
            camera.far = 100
            camera.name = "side_1"
            entity = sapien.Entity()
            entity.name = "side_1"
            entity.add_component(camera)
            entity.set_pose(
                sapien.Pose(
                    [0, 1, 0.4],
                    [
                        0.6943480198872284,
                        0.13371921058204453,
                        0.13371921058204453,
                        -0.6943480198872284,
                    ],
                ),
            )
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
