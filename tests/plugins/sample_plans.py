"""Plans made by hand: between them every shape, body type, knob and way to differ from scene to scene."""

from __future__ import annotations

from plugins.drawn_plan import drawn
from plugins.held_plans import fastened
from plugins.plan_parts import (
    FLAG,
    INT,
    ONE,
    ROOT,
    UP,
    entity,
    files,
    ground,
    indices,
    look,
    pose,
    poses,
    rubbing,
    solid,
)
from plugins.robot_plans import links, robots

from scenecc.plan import (
    BodyStructure,
    Box,
    Capsule,
    CoacdParams,
    CollisionShape,
    Cone,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Entity,
    GpuMemory,
    Heightfield,
    Inertial,
    Mesh,
    Physics,
    Plane,
    Ring,
    ScenePlan,
    SdfConfig,
    Sphere,
    TiledPlane,
    TriangleMesh,
    VisualShape,
    constant,
    per_scene,
)
from scenecc.plan.body import Friction, Texture

__all__ = [
    "FLAG",
    "INT",
    "ROOT",
    "SAMPLES",
    "entity",
    "indices",
    "look",
    "pose",
    "rubbing",
    "solid",
]


RING = Ring(per_scene([0.03, 0.02]), constant(0.05), constant(0.02))


def shapes() -> ScenePlan:
    """Every geometry, fallen in a heap."""
    file = files("mug.obj", "bowl.obj", "checker.png", "gem.stl")
    red, looks = constant(0, INT), constant(1, INT)
    box, ball = Box(constant([0.05, 0.04, 0.03])), Sphere(constant(0.05))
    rod, can = Capsule(constant(0.03), constant(0.06)), Cylinder(constant(0.04), constant(0.05))
    table = BodyStructure(
        "static",
        collisions=tuple(
            CollisionShape(Box(constant(size)), pose(*at), material=constant(1, INT))
            for size, at in (
                ((0.5, 0.5, 0.02), (0, 0, 0.2)),
                ((0.02, 0.02, 0.1), (0.4, 0.4, 0.1)),
                ((0.02, 0.02, 0.1), (-0.4, 0.4, 0.1)),
            )
        ),
        visuals=(VisualShape(Box(constant([0.5, 0.5, 0.02])), pose(0, 0, 0.2), material=looks, name="top"),),
    )
    solids = (box, ball, rod, can, Cone(constant(0.05), per_scene([0.04, 0.05])), RING)
    toys = [
        BodyStructure("dynamic", (CollisionShape(g, material=red),), (VisualShape(g, material=red),)) for g in solids
    ]
    seen = BodyStructure(
        "none",
        visuals=(
            VisualShape(Mesh(constant(1, INT), constant([1, -1, 1])), front_face="clockwise"),
            VisualShape(Mesh(constant(1, INT), constant([1, -1, 2]))),
            VisualShape(TiledPlane(constant([2, 1]), constant([4, 2])), material=looks, name="tiles"),
        ),
        visibility=constant(0.5),
        shading_mode=constant(1, INT),
    )
    mug = BodyStructure(
        "dynamic",
        (CollisionShape(ConvexMesh(constant(0, INT), ONE), density=constant(700)),),
        (VisualShape(Mesh(constant(0, INT), ONE)),),
        mass=constant(0.3),
    )
    gem = BodyStructure("dynamic", (CollisionShape(ConvexMesh(constant(3, INT), constant([2, 2, 1.5]))),))
    bowl = solid(TriangleMesh(constant(1, INT), ONE), body_type="static")
    field = Heightfield(constant([0.5, 0.4, 0.1]), ((0.0, 0.5, 0.25), (1.0, 0.0, -0.5)))
    terrain = BodyStructure("static", (CollisionShape(field),), (VisualShape(field, material=red),))
    entities = (
        ground(2),
        entity("table", pose(0, 0, 0), table),
        entity("box", pose(0, 0, 0.4, (0.9238795, 0.3826834, 0, 0)), toys[0]),
        entity("ball", pose(0.02, 0, 0.55), toys[1]),
        entity("capsule", pose(0, 0.02, 0.7), toys[2]),
        entity("cylinder", pose(-0.01, 0, 0.85), toys[3]),
        entity("cone", pose(-0.3, 0.2, 0.6), toys[4]),
        entity("ring", pose(-0.3, -0.2, 0.6), toys[5]),
        entity("mug", pose(0.2, 0.2, 0.5), mug),
        entity("gem", pose(0.22, 0.2, 0.7), gem),
        entity("bowl", pose(1, 1, 0), bowl),
        entity("terrain", pose(-1, -1, 0), terrain),
        entity("dropped in the bowl", pose(1, 1.01, 0.3), solid(Sphere(constant(0.02)))),
        entity("sign", pose(0, 0, 1), seen),
    )
    return ScenePlan(
        "shapes",
        2,
        entities,
        Physics(),
        files=file,
        physical_materials=(rubbing(0.9, 0.8, 0.05), rubbing(0.4, 0.3, 0.5)),
        visual_materials=(
            look(base_color=(0.8, 0.1, 0.1, 1), roughness=0.4),
            look(base_color_texture=Texture(constant(2, INT), mipmap_levels=4, filter_mode="nearest", srgb=True)),
        ),
        description="Every shape that there is.\nTwo scenes, both the same.",
    )


def knobs() -> ScenePlan:
    """Every knob of a body, a shape and the simulation."""
    box = Box(constant([0.1, 0.1, 0.1]))
    shape = CollisionShape(
        box,
        pose=pose(0, 0, 0.01),
        density=constant(300),
        contact_offset=constant(0.03),
        rest_offset=constant(0.005),
        patch_radius=constant(0.1),
        min_patch_radius=constant(0.01),
    )
    busy = BodyStructure(
        "dynamic",
        collisions=(
            shape,
            CollisionShape(
                Sphere(constant(0.1)),
                pose(0, 0, 0.2),
                contact_offset=constant(0.05),
                collision_groups=constant([5, 4, 0, 0], INT),
            ),
        ),
        mass=constant(2.5),
        locked_motion_axes=constant([False, False, False, True, False, True], FLAG),
        linear_velocity=constant([0.5, 0, 1]),
        angular_velocity=constant([0, 3, 0]),
        linear_damping=constant(0.1),
        angular_damping=constant(0.3),
        max_linear_velocity=constant(3),
        max_angular_velocity=constant(20),
        max_depenetration_velocity=constant(1.5),
        max_contact_impulse=constant(1000),
        sleep_threshold=constant(0.001),
        solver_position_iterations=constant(20, INT),
        solver_velocity_iterations=constant(3, INT),
        collision_groups=constant([3, 1, 0, 7], INT),
    )
    heavy = solid(
        box,
        inertial=Inertial(constant(4), pose(0.01, 0, -0.02, (0.7071068, 0.7071068, 0, 0)), constant([0.1, 0.2, 0.15])),
    )
    floating = solid(Sphere(constant(0.2)), disable_gravity=constant(True, FLAG), linear_velocity=constant([0.1, 0, 0]))
    pusher = solid(
        box, body_type="kinematic", collision_groups=constant([1, 3, 0, 0], INT), max_contact_impulse=constant(5)
    )
    seen = BodyStructure(
        "dynamic", (shape, shape), (VisualShape(box, pose(0, 0, 0.01), name="lid"),), visibility=constant(0.3)
    )
    physics = Physics(
        timestep=0.005,
        gravity=(0.1, 0, -3.7),
        bounce_threshold=0.5,
        enable_pcm=False,
        enable_tgs=False,
        enable_ccd=True,
        enable_enhanced_determinism=True,
        enable_friction_every_iteration=False,
        cpu_workers=1,
        default_material=Friction(0.7, 0.6, 0.3),
        contact_offset=0.015,
        rest_offset=0.001,
        solver_position_iterations=15,
        solver_velocity_iterations=2,
        sleep_threshold=0.002,
        sdf=SdfConfig(spacing=0.02, subgrid_size=4, num_threads_for_construction=1),
        scene_spacing=10,
        gpu_memory=GpuMemory(heap_capacity=2**26),
    )
    entities = (
        ground(2),
        entity("busy", pose(0, 0, 0.5), busy),
        entity("heavy", pose(0.05, 0, 1.1), heavy),
        entity("floating", pose(1, 0, 1), floating),
        entity("pusher", pose(0.2, 0.1, 0.1), pusher),
        entity("seen", pose(-1, 0, 0.5), seen),
    )
    return ScenePlan("knobs", 2, entities, physics, description="Every knob, on a small moon.")


def varied() -> ScenePlan:
    """Pose, size, file, material, structure, mass and knobs that differ from scene to scene."""
    everywhere = (0, 1, 2, 3)
    size = per_scene([[0.05, 0.05, 0.05], [0.06, 0.05, 0.04], [0.1, 0.02, 0.02], [0.05, 0.05, 0.05]])
    crate = BodyStructure(
        "dynamic",
        collisions=(CollisionShape(Box(size), material=indices(0, 1, 1, 0), density=per_scene([100, 200, 300, 400])),),
        visuals=(VisualShape(Box(size), material=indices(0, 1, 1, 0)),),
        mass=per_scene([0.1, 0.2, 0.3, 0.4]),
        linear_damping=per_scene([0, 0.5, 1, 2]),
        linear_velocity=per_scene([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    )
    thing = BodyStructure(
        "dynamic",
        collisions=(
            CollisionShape(
                ConvexMesh(indices(0, 1), per_scene([[1, 1, 1], [1.5, 1.5, 1.5]])),
                contact_offset=per_scene([0.01, 0.02]),
            ),
        ),
        visuals=(VisualShape(Mesh(indices(0, 1), per_scene([[1, 1, 1], [-1, 1, 1]]))),),
    )
    light = solid(Sphere(per_scene([0.05, 0.06, 0.07, 0.08])))
    block = BodyStructure("kinematic", collisions=(CollisionShape(Box(size)),))
    lone = BodyStructure("none", visuals=(VisualShape(Sphere(per_scene([0.05, 0.06, 0.07, 0.08]))),))
    four = poses((0, 0, 0.5), (0.01, 0, 0.6), (0.02, 0, 0.7), (0.03, 0, 0.8))
    entities = (
        ground(4),
        Entity("crate", everywhere, poses((0, 0, 0.1), (0, 0, 0.2), (0, 0, 0.3), (0, 0, 0.4)), (crate,)),
        Entity("bin", everywhere, four, (light, block, lone), pick=indices(0, 1, 0, 2)),
        Entity("obstacle", (0, 2), poses((0.3, 0, 0.3), (0.3, 0.1, 0.3)), (thing,)),
        Entity(
            "pin", (0, 1, 3), poses((0.5, 0, 0.1), (0.6, 0, 0.1), (0.7, 0, 0.1)), (solid(Box(constant([0.02] * 3))),)
        ),
        Entity("only once", (2,), pose(-0.5, 0, 0.5), (solid(Sphere(constant(0.05)), mass=constant(1)),)),
        Entity("peg", (1, 2), pose(1, 0, 0.5), (solid(Capsule(constant(0.02), constant(0.1))),)),
    )
    return ScenePlan(
        "varied",
        4,
        entities,
        Physics(timestep=1 / 240),
        files=files("mug.obj", "gem.stl"),
        physical_materials=(rubbing(0.9, 0.8, 0.05), rubbing(0.1, 0.05, 0.6)),
        visual_materials=(look(base_color=(1, 0, 0, 1)), look(base_color=(0, 0, 1, 0.5))),
        seed=7,
    )


def components() -> ScenePlan:
    """What `ActorBuilder` cannot build."""
    parts = ConvexParts(constant(0, INT), ONE)
    chair = BodyStructure(
        "dynamic",
        collisions=(
            CollisionShape(parts, pose(0, 0, 0.01), contact_offset=constant(0.02), density=constant(400)),
            CollisionShape(Box(constant([0.02] * 3)), pose(0.2, 0, 0), rest_offset=constant(0.001)),
        ),
        visuals=(
            VisualShape(Box(constant([0.1] * 3)), front_face="clockwise"),
            VisualShape(TiledPlane(per_scene([[1, 1], [2, 1]]), constant([3, 3]))),
        ),
        mass=constant(1.5),
        linear_damping=constant(0.2),
        collision_groups=constant([1, 1, 2, 0], INT),
    )
    moved = BodyStructure(
        "kinematic",
        collisions=(CollisionShape(TriangleMesh(constant(1, INT), constant([2, 2, 2]), sdf=True)),),
    )
    slab = BodyStructure("static", collisions=(CollisionShape(Plane(), pose(0, 0, 0, UP), density=constant(5)),))
    whole = solid(ConvexParts(constant(0, INT), constant([1, 1, 2])))
    given = solid(
        parts,
        Sphere(constant(0.1)),
        inertial=Inertial(constant(1), pose(0, 0, 0), constant([0.01, 0.01, 0.01])),
    )
    soft = CollisionShape(parts, rest_offset=constant(0.002))
    weighed = BodyStructure("dynamic", (soft,), inertial=given.inertial)
    entities = (
        entity("slab", pose(0, 0, 0), slab),
        entity("moved", pose(0, 0, 0.05), moved),
        entity("chair", pose(0, 0, 0.6), chair),
        entity("whole", pose(1, 0, 0.6), whole),
        entity("given", pose(2, 0, 0.6), given),
        entity("weighed", pose(3, 0, 0.6), weighed),
        entity(
            "fell",
            pose(4, 0, 0.6),
            solid(Box(constant([0.1] * 3)), Sphere(constant(0.11)), angular_velocity=constant([1, 2, 3])),
        ),
    )
    return ScenePlan("components", 2, entities, Physics(), files=files("mug.obj", "bowl.obj"))


def decomposed() -> ScenePlan:
    """CoACD's parts, with a search a third as long as that of its defaults."""
    asked = CoacdParams(
        threshold=0.3,
        max_convex_hull=4,
        preprocess_mode="off",
        resolution=1000,
        mcts_nodes=10,
        mcts_iterations=60,
        mcts_max_depth=2,
        seed=1,
    )
    cut = ConvexParts(constant(0, INT), ONE, asked)
    entities = (
        ground(2),
        entity("bowl", pose(0, 0, 0.3), solid(cut)),
        entity("ball", pose(0, 0, 0.5), solid(Sphere(constant(0.02)))),
    )
    return ScenePlan("decomposed", 2, entities, Physics(), files=files("bowl.obj"))


SAMPLES = {
    make.__name__: make for make in (shapes, knobs, varied, drawn, components, decomposed, robots, links, fastened)
}
