# A script of plain SAPIEN calls, written by scenecc.
#
# variation: 8 parallel scenes.
# Every form of variation, one object each.
#
# Run this file, or import it and call build_scenes(). It needs sapien, and no scenecc.
# What a reset would draw anew is as the seed 1 draws it.

import sapien
from sapien import physx


def build_scenes(render: bool = False) -> list[sapien.Scene]:
    """Builds 8 parallel scenes. `render`: build what is seen, too."""
    scenes: list[sapien.Scene] = []
    for _ in range(8):
        systems = [physx.PhysxCpuSystem()]
        if render:
            systems.append(sapien.render.RenderSystem())
        scene = sapien.Scene(systems)
        scenes.append(scene)

    puck_physical = physx.PhysxMaterial(static_friction=1, dynamic_friction=0.9, restitution=0.5)
    puck_physical_2 = physx.PhysxMaterial(
        static_friction=0.05,
        dynamic_friction=0.03,
        restitution=0,
    )

    if render:
        puck_look = sapien.render.RenderMaterial(
            base_color=[0.13333333333333333, 0.13333333333333333, 0.13333333333333333, 1],
        )
        puck_look_2 = sapien.render.RenderMaterial(
            base_color=[0.8156862745098039, 0.9411764705882353, 1, 1],
        )

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

    # box
    box_half_size = [
        [0.04984888028365011, 0.04503445740205379, 0.036360416735340295],
        [0.04101633371899245, 0.027825189834878604, 0.03857336939073197],
        [0.026635252695855847, 0.04415773563776485, 0.03865128596590566],
        [0.03435096520125144, 0.030990072601630045, 0.026804450540017257],
        [0.03458436224595713, 0.045575279230951456, 0.043016390254956835],
        [0.048405302511692436, 0.04002370059615936, 0.020912925674297318],
        [0.027036781212888748, 0.03472666829325895, 0.025841409881998473],
        [0.03281729722769086, 0.03439080301878132, 0.04832478902350565],
    ]
    box_pose = [
        sapien.Pose([-0.05917721356674981, 0.069501941654778, 0.06]),
        sapien.Pose([-0.056134713160466525, 0.011420630997884124, 0.06]),
        sapien.Pose([-0.07356238411878323, 0.0981424978342112, 0.06]),
        sapien.Pose([0.08285230973224775, 0.046848958564626925, 0.06]),
        sapien.Pose([-0.07303067752753756, 0.09304612653911842, 0.06]),
        sapien.Pose([-0.09942033001453349, -0.06341551577120992, 0.06]),
        sapien.Pose([-0.0886805560806055, -0.05442692544126507, 0.06]),
        sapien.Pose([0.02540548903699119, -0.0005622906400854777, 0.06]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=box_half_size[i])
        if render:
            builder.add_box_visual(half_size=box_half_size[i])
        builder.initial_pose = box_pose[i]
        builder.build(name="box")

    # puck
    puck_material = [
        puck_physical,
        puck_physical,
        puck_physical,
        puck_physical,
        puck_physical,
        puck_physical_2,
        puck_physical_2,
        puck_physical,
    ]
    if render:
        puck_look_3 = [
            puck_look,
            puck_look,
            puck_look,
            puck_look,
            puck_look,
            puck_look_2,
            puck_look_2,
            puck_look,
        ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_cylinder_collision(
            pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
            radius=0.04,
            half_length=0.02,
            material=puck_material[i],
        )
        if render:
            builder.add_cylinder_visual(
                pose=sapien.Pose([0, 0, 0], [0.7071067811865475, 0, -0.7071067811865475, 0]),
                radius=0.04,
                half_length=0.02,
                material=puck_look_3[i],
            )
        builder.initial_pose = sapien.Pose([0.3, 0, 0.02])
        builder.build(name="puck")

    # traffic_light
    if render:
        traffic_light_base_color = [
            [0.8156862745098039, 0, 0, 1],
            [1, 0.7294117647058823, 0.03137254901960784, 1],
            [0.17647058823529413, 0.41568627450980394, 0.30980392156862746, 1],
            [0.8156862745098039, 0, 0, 1],
            [1, 0.7294117647058823, 0.03137254901960784, 1],
            [0.17647058823529413, 0.41568627450980394, 0.30980392156862746, 1],
            [0.8156862745098039, 0, 0, 1],
            [1, 0.7294117647058823, 0.03137254901960784, 1],
        ]
    for i, scene in enumerate(scenes):
        if render:
            traffic_light_look = sapien.render.RenderMaterial(
                base_color=traffic_light_base_color[i],
            )
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_sphere_collision(radius=0.05)
        if render:
            builder.add_sphere_visual(radius=0.05, material=traffic_light_look)
        builder.initial_pose = sapien.Pose([0.6, 0, 0.1])
        builder.build(name="traffic_light")

    # weight
    weight_mass = [
        0.07753937783938113,
        0.9430422584575204,
        0.04292278104425139,
        0.012329466577181428,
        0.07236796603795592,
        0.06760711445121499,
        0.03594415443755365,
        0.11285767575782213,
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.05, 0.05, 0.05])
        if render:
            builder.add_box_visual(half_size=[0.05, 0.05, 0.05])
        builder.initial_pose = sapien.Pose([0.9, 0, 0.05])
        entity = builder.build(name="weight")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.inertia = body.inertia.astype(float) * (weight_mass[i] / body.mass)
        body.mass = weight_mass[i]

    # brake
    brake_linear_damping = [
        0.15114410537177964,
        0.1549699037472338,
        0.04681485354587533,
        0.06896897494008114,
        0.13523331289240864,
        0.15416138563732495,
        0.023285323227431154,
        0.09953243824257242,
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05)
        if render:
            builder.add_sphere_visual(radius=0.05)
        builder.initial_pose = sapien.Pose([1.2, 0, 0.05])
        entity = builder.build(name="brake")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.linear_damping = brake_linear_damping[i]

    # solver
    solver_solver_position_iterations = [12, 9, 9, 12, 14, 11, 8, 11]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_sphere_collision(radius=0.05)
        if render:
            builder.add_sphere_visual(radius=0.05)
        builder.initial_pose = sapien.Pose([1.5, 0, 0.05])
        entity = builder.build(name="solver")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.solver_position_iterations = solver_solver_position_iterations[i]

    # die
    die_pose = [
        sapien.Pose(
            [1.8, 0, 0.2],
            [-0.35855345950628803, 0.7240114773278525, 0.12150375411452972, -0.5766139393993946],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [0.050818927288997534, 0.22848764055002688, -0.44424908525616286, -0.8647852825957087],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [-0.05640391914049337, 0.7044994221879763, 0.21533311121239018, 0.6738922860947382],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [-0.2377284997360564, 0.7555977808535717, 0.19558145994135392, -0.5781911850846658],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [0.4754580068263076, 0.3023686111723038, -0.3354837993895093, 0.7549592883524692],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [0.58112231008134, 0.32739810314949386, 0.7386942214211124, -0.09715034749756092],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [-0.29027061950532257, -0.7335699844540984, -0.3238120356368595, -0.5222679493676817],
        ),
        sapien.Pose(
            [1.8, 0, 0.2],
            [-0.2865640798112241, -0.2863768228840198, -0.4360084855825014, -0.8035956346178436],
        ),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.03, 0.03, 0.03])
        if render:
            builder.add_box_visual(half_size=[0.03, 0.03, 0.03])
        builder.initial_pose = die_pose[i]
        builder.build(name="die")

    # signpost
    signpost_pose = [
        sapien.Pose([2.1, 0, 0.2], [0.6795147679115722, 0, 0, 0.7336618295850494]),
        sapien.Pose([2.1, 0, 0.2], [0.2785850157390535, 0, 0, -0.9604115727154017]),
        sapien.Pose([2.1, 0, 0.2], [0.5477443965365052, 0, 0, -0.8366457291248547]),
        sapien.Pose([2.1, 0, 0.2], [0.26121299594006864, 0, 0, -0.9652811874018957]),
        sapien.Pose([2.1, 0, 0.2], [0.3416192808837015, 0, 0, 0.9398384259693273]),
        sapien.Pose([2.1, 0, 0.2], [0.030754699935408882, 0, 0, -0.9995269623336246]),
        sapien.Pose([2.1, 0, 0.2], [0.7919005405222623, 0, 0, -0.6106500912310985]),
        sapien.Pose([2.1, 0, 0.2], [0.08314819191786157, 0, 0, 0.9965371935762309]),
    ]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.set_physx_body_type("static")
        builder.add_box_collision(half_size=[0.1, 0.01, 0.03])
        if render:
            builder.add_box_visual(half_size=[0.1, 0.01, 0.03])
        builder.initial_pose = signpost_pose[i]
        builder.build(name="signpost")

    # ghost
    ghost_density = [1896.3303222670927, 500, 500, 500, 500, 500, 500, 1714.0394482309998]
    ghost_pose = [
        sapien.Pose([2.4, 0, 0.1], [0.9238795325112867, 0, 0, 0.3826834323650898]),
        sapien.Pose([2.4, 0, 0.1], [0.9238795325112867, 0, 0, 0.3826834323650898]),
        sapien.Pose([2.4, 0, 0.1], [0.9238795325112867, 0, 0, 0.3826834323650898]),
        sapien.Pose([2.4, 0, 0.1]),
        sapien.Pose([2.4, 0, 0.1], [0.9238795325112867, 0, 0, 0.3826834323650898]),
        sapien.Pose([2.4, 0, 0.1], [0.9238795325112867, 0, 0, 0.3826834323650898]),
        sapien.Pose([2.4, 0, 0.1]),
        sapien.Pose([2.4, 0, 0.1]),
    ]
    ghost_disable_gravity = [False, True, False, True, True, False, False, True]
    for i, scene in enumerate(scenes):
        builder = scene.create_actor_builder()
        builder.add_box_collision(half_size=[0.03, 0.03, 0.03], density=ghost_density[i])
        if render:
            builder.add_box_visual(half_size=[0.03, 0.03, 0.03])
        builder.initial_pose = ghost_pose[i]
        entity = builder.build(name="ghost")
        body = entity.find_component_by_type(physx.PhysxRigidDynamicComponent)
        body.disable_gravity = ghost_disable_gravity[i]

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
