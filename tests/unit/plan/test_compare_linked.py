"""What differs between two plans with articulations, and with what holds on to entities."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from plugins.plan_parts import entity, look, pose, rubbing, solid
from plugins.robot_plans import arm, linked, robots

from scenecc import Difference
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import (
    ArticulationStructure,
    AxisDrive,
    AxisLimit,
    Box,
    Camera,
    CollisionShape,
    Constraint,
    Drive,
    Entity,
    Environment,
    Joint,
    Light,
    Link,
    Mount,
    Perspective,
    Physics,
    PointLight,
    ScenePlan,
    Sphere,
    SpotLight,
    VisualShape,
    Weld,
    constant,
    literal,
    per_scene,
    recalled,
)
from scenecc.plan.diff import diff_plans
from scenecc.variation.nodes import Drawn, Key

ARM = arm(ids=constant([1, 1, 0, 0], np.int64), start=literal(0.3))


def of(*entities: Entity, **more: Any) -> ScenePlan:
    materials: Any = {"physical_materials": (rubbing(1, 1, 0),), "visual_materials": (look(ior=1.5),)}
    return ScenePlan("p", 2, entities, Physics(), **materials, **more)


def robot(structure: ArticulationStructure = ARM) -> Entity:
    return Entity("robot", (0, 1), pose(0, 0, 0), (structure,))


def with_link(number: int, **changed: Any) -> ArticulationStructure:
    links = list(ARM.links)
    links[number] = dataclasses.replace(links[number], **changed)
    return dataclasses.replace(ARM, links=tuple(links))


def with_joint(number: int, **changed: Any) -> ArticulationStructure:
    joint = ARM.links[number].joint
    assert joint is not None
    return with_link(number, joint=dataclasses.replace(joint, **changed))


def told(structure: ArticulationStructure) -> list[tuple[Any, ...]]:
    found = diff_plans(of(robot()), of(robot(structure)))
    back = diff_plans(of(robot(structure)), of(robot()))
    assert {(one.path, one.a, one.b) for one in found} == {(one.path, one.b, one.a) for one in back}
    return [(one.kind, one.path, one.a, one.b) for one in found]


def test_joints_and_links_are_told_by_the_names_of_links() -> None:
    assert told(with_joint(2, limits=constant([-1, float("inf")]))) == [
        ("changed", "links.lower.joint.limits", "[-1.5, 1.5]", "[-1, inf]")
    ]
    assert told(with_joint(2, friction=None)) == [("changed", "links.lower.joint.friction", "0.1", None)]
    body = dataclasses.replace(ARM.links[1].body, disable_gravity=None, mass=literal(2))
    assert told(with_link(1, body=body)) == [
        ("changed", "links.upper.gravity", "false", None),
        ("changed", "links.upper.mass", None, "2"),
    ]
    body = linked(CollisionShape(Box(constant([0.1, 0.2, 0.05]))), disable_gravity=ARM.links[0].body.disable_gravity)
    assert told(with_link(0, body=dataclasses.replace(body, collision_groups=ARM.links[0].body.collision_groups))) == [
        ("changed", "links.base.collisions[0].half_size", "[0.1, 0.1, 0.05]", "[0.1, 0.2, 0.05]")
    ]


def test_a_link_more_moves_no_other() -> None:
    base, upper, *rest = ARM.links
    between = Link("between", linked(), 0, Joint("fixed"))
    links = (base, between, *(dataclasses.replace(link, parent=(link.parent or 0) + 1) for link in (upper, *rest)))
    more = dataclasses.replace(ARM, links=links)
    # What hung on the base hangs on what is between now.
    assert told(more) == [
        ("changed", "links.upper.parent", '"base"', '"between"'),
        ("changed", "links.camera.parent", '"base"', '"between"'),
        ("added", "links.between", None, 'name "between", collisions 0, visuals 0, parent "base", joint.type "fixed"'),
    ]


def test_links_in_another_order_are_told() -> None:
    base, upper, lower, camera, *rest = ARM.links
    other = dataclasses.replace(
        ARM,
        links=(
            base,
            camera,
            dataclasses.replace(upper, parent=0),
            dataclasses.replace(lower, parent=2),
            *(dataclasses.replace(link, parent=3 if link.parent == 2 else link.parent) for link in rest),
        ),
    )
    (one,) = diff_plans(of(robot()), of(robot(other)))
    assert (one.kind, one.path, one.a, one.b) == ("moved", "links.camera", "number 4", "number 2")


def test_joints_that_follow_are_told_by_their_names() -> None:
    (mimic,) = ARM.mimics
    other = dataclasses.replace(ARM, mimics=(dataclasses.replace(mimic, multiplier=literal(1)),))
    assert told(other) == [("changed", 'mimics["right slide"].multiplier', "0.5", "1")]
    assert [(kind, path) for kind, path, *_ in told(dataclasses.replace(ARM, mimics=()))] == [
        ("removed", 'mimics["right slide"]')
    ]


def test_what_a_reset_draws_of_a_joint_is_told() -> None:
    def drawn(high: float) -> ArticulationStructure:
        node = Drawn("uniform", (0, high), (), Key("entities", "robot", "qpos"))
        return with_joint(1, qpos=recalled(np.array([0.3]), node))

    (one,) = diff_plans(of(robot(drawn(1))), of(robot(drawn(2))))
    assert (one.path, one.a, one.b) == ("links.upper.joint.qpos", "0 … 1 at reset", "0 … 2 at reset")


def test_a_body_that_becomes_an_articulation_is_told_in_a_word() -> None:
    ball = entity("robot", pose(0, 0, 0), solid(Sphere(constant(0.1))))
    assert [(one.path, one.a, one.b) for one in diff_plans(of(ball), of(robot()))] == [
        ("type", "dynamic", "articulation")
    ]
    (one,) = diff_plans(of(), of(robot()))
    assert (one.kind, one.b) == ("added", "articulation in every scene")


@pytest.mark.parametrize("keys", [("shapes", 1), ("collisions", 1)])
def test_shapes_of_a_tree_are_where_they_were_written(keys: tuple[str, int]) -> None:
    def plan(size: float) -> ScenePlan:
        origin = Origin("a.yaml", ("entities", "robot", "root", "children", 0, *keys))
        box = Box(constant([size, 1, 1]))
        shapes = (CollisionShape(box, origin=origin),)
        seen = (VisualShape(box, origin=origin),) if keys[0] == "shapes" else ()
        return of(robot(with_link(1, body=linked(*shapes, visuals=seen))))

    found = [one.path for one in diff_plans(plan(1), plan(2))]
    assert found == [f"links.upper.{keys[0]}[1].half_size"]


HERE = pose(0, 0, 1)


def scene(**more: Any) -> ScenePlan:
    drive = Drive((AxisLimit("x", constant([0, 1])),), (AxisDrive("x", literal(1), literal(2)),))
    made: dict[str, Any] = {
        "constraints": (
            Constraint("tied", (0, 1), Weld(), Mount("ball")),
            Constraint("driven", (0, 1), drive, Mount("ball"), Mount("robot", "hand")),
        ),
        "environment": Environment(ambient_light=per_scene([[0, 0, 0], [1, 1, 1]])),
        "lights": (Light("lamp", (0, 1), PointLight(), HERE, constant([1, 1, 1])),),
        "cameras": (Camera("eye", (0,), HERE, 64, 48, Perspective(fovy=literal(1)), literal(0.01), literal(10)),),
        **more,
    }
    ball = entity("ball", pose(0, 0, 0), solid(Sphere(constant(0.1))))
    return of(robot(), ball, **made)


def changes(**more: Any) -> list[Difference]:
    return diff_plans(scene(), scene(**more))


def test_what_holds_on_to_entities_is_told_in_its_section() -> None:
    tied, driven = scene().constraints
    assert changes(constraints=(tied,)) == [
        Difference("removed", "constraints", "driven", "", "drive in every scene", None)
    ]
    assert changes(constraints=(driven, tied))[0].kind == "moved"
    assert isinstance(driven.joint, Drive)
    joint = dataclasses.replace(
        driven.joint,
        limits=(AxisLimit("x", constant([0, 2])), AxisLimit("twist", constant([0, 1]))),
        drives=(AxisDrive("x", literal(3), literal(2)),),
    )
    found = changes(constraints=(tied, dataclasses.replace(driven, joint=joint, child=Mount("robot", "left"))))
    assert [(one.section, one.name, one.kind, one.path, one.a, one.b) for one in found] == [
        ("constraints", "driven", "changed", "limits.x", "[0, 1]", "[0, 2]"),
        ("constraints", "driven", "added", "limits.twist", None, 'axis "twist", [0, 1]'),
        ("constraints", "driven", "changed", "drives.x.stiffness", "1", "3"),
        ("constraints", "driven", "changed", "child.entity", '"ball"', '"robot"'),
        ("constraints", "driven", "changed", "child.link", None, '"left"'),
    ]


def test_lights_cameras_and_surroundings_are_told_field_by_field() -> None:
    (lamp,), (eye,) = scene().lights, scene().cameras
    (one,) = changes(lights=(dataclasses.replace(lamp, light=SpotLight(literal(1), literal(2))),))
    assert (one.section, one.name, one.path, one.a, one.b) == ("lights", "lamp", "type", "point", "spot")
    (one,) = changes(cameras=(dataclasses.replace(eye, lens=Perspective(fovy=literal(1.5))),))
    assert (one.section, one.name, one.path, one.a, one.b, one.scene_count) == ("cameras", "eye", "fovy", "1", "1.5", 1)
    (one,) = changes(cameras=())
    assert one.a == "64 × 48 px in scene 0"
    (one,) = changes(environment=Environment(ambient_light=constant([1, 1, 1])))
    assert (one.section, one.path, one.scene_count) == ("environment", "ambient_light", 1)
    (one,) = changes(environment=None)
    assert (one.path, one.b) == ("ambient_light", None)


def test_surroundings_are_compared_in_the_scenes_that_both_have() -> None:
    def plan(count: int, *rows: float) -> ScenePlan:
        light = per_scene([[row, 0, 0] for row in rows])
        return dataclasses.replace(of(), num_scenes=count, environment=Environment(ambient_light=light))

    assert [one.path for one in diff_plans(plan(2, 0, 1), plan(3, 0, 1, 2))] == ["num_scenes"]
    assert [one.path for one in diff_plans(plan(2, 0, 1), plan(3, 0, 2, 2))] == ["num_scenes", "ambient_light"]


def test_the_sample_is_equal_to_itself_link_by_link() -> None:
    changed = dataclasses.replace(robots(), description="other")
    assert [one.path for one in diff_plans(robots(), changed)] == ["description"]
