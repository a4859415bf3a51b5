"""Articulations made by hand: what their builder takes and what it does not, and ways to differ by scene."""

from __future__ import annotations

from typing import Any

from plugins.plan_parts import FLAG, INT, ONE, entity, files, ground, indices, look, pose, poses, rubbing, solid

from scenecc.plan import (
    ArticulationStructure,
    BodyStructure,
    Box,
    Capsule,
    CollisionShape,
    ConvexMesh,
    ConvexParts,
    Entity,
    Inertial,
    Joint,
    Link,
    Mesh,
    Mimic,
    Physics,
    ScenePlan,
    Sphere,
    TiledPlane,
    TriangleMesh,
    Value,
    VisualShape,
    constant,
    literal,
    per_scene,
)

INF = float("inf")
FRAME = pose(0.1, 0, 0, (0.7071068, 0, 0.7071068, 0))


def linked(*shapes: CollisionShape, visuals: tuple[VisualShape, ...] = (), **knobs: Any) -> BodyStructure:
    return BodyStructure("link", shapes, visuals, **knobs)


def rod(length: float, **knobs: Any) -> BodyStructure:
    shape = Capsule(constant(0.02), constant(length))
    return linked(
        CollisionShape(shape, pose(length, 0, 0), material=literal(0, "int64"), density=constant(500)),
        visuals=(VisualShape(shape, pose(length, 0, 0), material=literal(0, "int64")),),
        **knobs,
    )


def hinge(name: str, **knobs: Any) -> Joint:
    given: dict[str, Any] = {
        "pose_in_parent": pose(0.2, 0, 0, (0.7071068, 0, 0, 0.7071068)),
        "pose_in_child": pose(0, 0, 0, (0.7071068, 0, 0, 0.7071068)),
        "limits": constant([-1.5, 1.5]),
        **knobs,
    }
    return Joint("revolute", name, **given)


def arm(*, ids: Value, start: Value, file: Value | None = None) -> ArticulationStructure:
    """Seven links, in an order that is not the engine's; fingers of which one follows the other."""
    drive: dict[str, Any] = {"stiffness": literal(200), "damping": literal(20), "force_limit": literal(50)}
    light: dict[str, Any] = {"disable_gravity": constant(True, FLAG), "collision_groups": ids}
    finger = linked(CollisionShape(Box(constant([0.03, 0.01, 0.01])), patch_radius=constant(0.1)), **light)

    def slide(name: str, side: float, **knobs: Any) -> Joint:
        return Joint(
            "prismatic",
            name,
            pose(0.1, side, 0, (0.7071068, 0, 0, 0.7071068)),
            pose(0, 0, 0, (0.7071068, 0, 0, 0.7071068)),
            limits=constant([0, 0.04]),
            **knobs,
        )

    first: dict[str, Any] = {"qpos": start, "drive_target": start, **drive}
    second: dict[str, Any] = {"qpos": literal(-0.4), "drive_target": literal(-0.4), **drive}
    gripped: dict[str, Any] = {"qpos": literal(0.03), "drive_target": literal(0.03), "drive_mode": "acceleration"}
    elbow = hinge("elbow", friction=literal(0.1), armature=literal(0.05), max_velocity=literal(3), **second)
    links = (
        Link("base", linked(CollisionShape(Box(constant([0.1, 0.1, 0.05]))), **light)),
        Link("upper", rod(0.1, **light), 0, hinge("shoulder", friction=literal(0.1), armature=literal(0.05), **first)),
        Link("lower", rod(0.08, **light), 1, elbow),
        Link("camera", linked(inertial=small(), **light), 0, Joint("fixed", pose_in_parent=FRAME)),
        Link("hand", linked(CollisionShape(Box(constant([0.02, 0.06, 0.02]))), **light), 2, Joint("fixed", "wrist")),
        Link("left", finger, 4, slide("left slide", 0.01, **gripped, **{**drive, "force_limit": None})),
        Link("right", finger, 4, slide("right slide", -0.01, damping=literal(5), qpos=literal(0.015))),
    )
    follows = Mimic("right slide", "left slide", literal(0.5), literal(0))
    return ArticulationStructure(
        links, fix_root_link=True, mimics=(follows,), solver_position_iterations=literal(15, "int64"), file=file
    )


def small() -> Inertial:
    return Inertial(literal(0.05), pose(0, 0, 0), constant([1e-4, 1e-4, 1e-4]))


def crawler() -> ArticulationStructure:
    """A free root, joints without names and limits, and knobs of links, by scene."""
    legs = [
        Link(
            f"leg {side}",
            rod(0.1, mass=per_scene([0.1, 0.2]), linear_damping=per_scene([0.1, 0.5])),
            0,
            Joint("revolute", "", pose(0, side * 0.1, 0, (0.7071068, 0, 0, 0.7071068)), qvel=literal(side)),
        )
        for side in (-1, 1)
    ]
    foot = Joint("prismatic", "", pose(0.2, 0, 0), limits=constant([-0.01, INF]), damping=per_scene([1, 2]))
    trunk = linked(
        CollisionShape(Box(constant([0.1, 0.05, 0.05])), contact_offset=constant(0.02), rest_offset=constant(0.001)),
        visuals=(VisualShape(Box(constant([0.1, 0.05, 0.05]))),),
        max_linear_velocity=literal(5),
        visibility=literal(0.5),
    )
    driven = Joint(
        "revolute_unwrapped",
        "tail",
        pose(-0.1, 0, 0),
        drive_velocity_target=literal(2),
        damping=literal(1),
        stiffness=literal(0),
        force_limit=per_scene([1, 2]),
    )
    return ArticulationStructure(
        (
            Link("trunk", trunk),
            *legs,
            Link("foot", linked(CollisionShape(Sphere(constant(0.03)))), 2, foot),
            Link("tail", rod(0.05, angular_damping=literal(0.2)), 0, driven),
        ),
        sleep_threshold=literal(0.001),
        solver_velocity_iterations=literal(2, "int64"),
        linear_velocity=constant([0.2, 0, 1]),
        angular_velocity=per_scene([[0, 0, 1], [0, 0, -1]]),
    )


def statue() -> ArticulationStructure:
    """Nothing of it moves."""
    head = linked(CollisionShape(ConvexMesh(literal(0, "int64"), ONE)))
    return ArticulationStructure(
        (Link("foot", rod(0.1)), Link("head", head, 0, Joint("fixed", "neck", pose(0, 0, 0.3)))), fix_root_link=True
    )


def robots() -> ScenePlan:
    """What `ArticulationBuilder` builds: copies in a loop, a joint that follows another, and much that is by scene."""
    starts = (per_scene([0.3, 0.5]), literal(0.2), literal(0.1))
    arms = [
        Entity(
            f"arm_{index}",
            (0, 1),
            pose(0, index, 0.05),
            (arm(ids=constant([1, 1, 2**29, index], INT), start=start, file=literal(2, "int64")),),
        )
        for index, start in enumerate(starts)
    ]
    entities = (
        ground(2),
        *arms,
        Entity("crawler", (0, 1), poses((2, 0, 0.3), (2, 0, 0.4)), (crawler(),)),
        Entity("statue or crawler", (0, 1), pose(3, 0, 0.3), (statue(), crawler()), indices(0, 1)),
        entity("ball", pose(0.3, 0, 0.3), solid(Sphere(constant(0.03)))),
    )
    return ScenePlan(
        "robots",
        2,
        entities,
        Physics(),
        files=files("mug.obj", "bowl.obj", "checker.png"),
        physical_materials=(rubbing(0.9, 0.8, 0.05),),
        visual_materials=(look(base_color=(0.8, 0.1, 0.1, 1), roughness=0.4),),
    )


def links() -> ScenePlan:
    """What `ArticulationBuilder` cannot build."""
    parts = CollisionShape(ConvexParts(literal(0, "int64"), ONE), contact_offset=constant(0.02))
    lid = linked(
        CollisionShape(TriangleMesh(literal(1, "int64"), ONE, sdf=False), pose(0.1, 0, 0)),
        visuals=(
            VisualShape(Mesh(literal(1, "int64"), constant([1, -1, 1]))),
            VisualShape(TiledPlane(constant([0.1, 0.1]), constant([2, 2])), front_face="clockwise"),
        ),
        inertial=Inertial(literal(0.5), pose(0.1, 0, 0), constant([0.01, 0.01, 0.01])),
        visibility=literal(0.7),
    )
    turned = Joint("revolute", "lid", FRAME, pose(0, 0, 0), constant([0, 1]), damping=per_scene([0.1, 0.5]))
    driven = hinge("knob", stiffness=literal(5), damping=literal(1), qpos=literal(0.2), drive_target=literal(0.2))
    follows = Mimic("wheel", "knob", per_scene([2, -1]), per_scene([0, 0.1]))
    wheel = hinge("wheel", limits=None, qpos=per_scene([0.4, -0.1]))
    chest = ArticulationStructure(
        (
            Link("box", linked(parts, mass=literal(2), linear_damping=literal(0.1))),
            Link("lid", lid, 0, turned),
            Link("knob", rod(0.03), 0, driven),
            Link("wheel", rod(0.04), 0, wheel),
            Link("mark", linked(inertial=small()), 1, Joint("fixed")),
        ),
        mimics=(follows,),
    )
    still = ArticulationStructure((Link("only", linked(parts, collision_groups=constant([1, 1, 2, 0], INT))),), True)
    entities = (
        ground(2),
        Entity("chest", (0, 1), poses((0, 0, 0.4), (0, 0, 0.5)), (chest,)),
        Entity("still", (1,), pose(1, 0, 0.4), (still,)),
    )
    return ScenePlan(
        "links",
        2,
        entities,
        Physics(),
        files=files("mug.obj", "bowl.obj"),
        physical_materials=(rubbing(0.5, 0.4, 0.1),),
        visual_materials=(look(base_color=(0.1, 0.1, 0.8, 1)),),
    )
