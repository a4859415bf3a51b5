"""The JSON of articulations and of what holds on to entities: what is no tree, and what names nothing, is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from plugins.plan_parts import solid

from scenecc.diagnostics import Sink
from scenecc.plan import (
    ArticulationStructure,
    AxisDrive,
    AxisLimit,
    BodyStructure,
    Box,
    Camera,
    CollisionShape,
    Constraint,
    Distance,
    Drive,
    Entity,
    Environment,
    Joint,
    Light,
    Link,
    Mimic,
    Mount,
    Perspective,
    Physics,
    PointLight,
    ScenePlan,
    Sphere,
    constant,
    literal,
    per_scene,
)
from scenecc.plan.body import PhysicalMaterial
from scenecc.plan.json_codec import plan_from_json, plan_to_json

INF = float("inf")
HERE = constant([0, 0, 0, 1, 0, 0, 0])


def link_body(*, material: int | None = None) -> BodyStructure:
    index = None if material is None else literal(material, "int64")
    return BodyStructure("link", (CollisionShape(Box(constant([0.1, 0.1, 0.1])), material=index),))


def robot() -> ScenePlan:
    """Three links, one joint without limits and one that follows it, and something of everything that holds on."""
    hinge = Joint("revolute", "hinge", limits=constant([-INF, INF]), stiffness=constant(10.0), qpos=constant(0.5))
    slide = Joint("prismatic", "slide", limits=per_scene([[0, 1], [0, INF]]))
    structure = ArticulationStructure(
        (
            Link("base", link_body(material=0)),
            Link("arm", link_body(), 0, hinge),
            Link("hand", link_body(), 1, slide),
        ),
        fix_root_link=True,
        mimics=(Mimic("slide", "hinge", constant(0.5), constant(0.1)),),
    )
    material = PhysicalMaterial(per_scene([0.4, 0.5]), literal(0.3), literal(0.1))
    drive = Drive((AxisLimit("x", constant([0, INF])),), (AxisDrive("slerp", constant(1.0), constant(2.0)),))
    constraints = (
        Constraint("drawn", (0, 1), drive, Mount("ball"), Mount("robot", "hand")),
        Constraint("tied", (1,), Distance(constant([0, 1])), Mount("robot", "arm")),
    )
    camera = Camera(
        "eye", (0,), HERE, 64, 48, Perspective(fovy=constant(1.0)), constant(0.01), constant(10.0), Mount("ball")
    )
    return ScenePlan(
        "robots",
        2,
        (
            Entity("robot", (0, 1), HERE, (structure,)),
            Entity("ball", (0, 1), HERE, (solid(Sphere(constant(0.1))),)),
            Entity("alone", (1,), HERE, (solid(Sphere(constant(0.1))),)),
        ),
        Physics(),
        physical_materials=(material,),
        constraints=constraints,
        environment=Environment(ambient_light=per_scene([[0, 0, 0], [1, 1, 1]])),
        lights=(Light("lamp", (0, 1), PointLight(), HERE, constant([1, 1, 1]), Mount("robot", "hand")),),
        cameras=(camera,),
    )


def edited(*edits: tuple[tuple[str | int, ...], Any]) -> str:
    data = json.loads(plan_to_json(robot()))
    for path, value in edits:
        node = data
        for key in path[:-1]:
            node = node[key]
        if value is ...:
            del node[path[-1]]
        else:
            node[path[-1]] = value
    return json.dumps(data)


def faults(text: str, **options: Any) -> list[tuple[str, str]]:
    sink = Sink()
    assert plan_from_json(text, base=Path("/files"), sink=sink, **options) is None
    return [(found.code, found.path) for found in sink.diagnostics()]


def test_it_comes_back() -> None:
    text, sink = plan_to_json(robot()), Sink()
    assert '"limits": [-1e999, 1e999]' in text
    assert '"limits": {"per_scene": [[0.0, 1.0], [0.0, 1e999]]}' in text
    assert plan_from_json(text, base=Path("/files"), sink=sink) == robot()
    assert not sink.diagnostics()


STRUCTURE = ("entities", 0, "structures", 0)
LINKS = (*STRUCTURE, "links")
AT = "entities[0].structures[0]"


@pytest.mark.parametrize(
    ("path", "value", "where"),
    [
        (LINKS, [], f"{AT}.links"),
        ((*LINKS, 0, "parent"), 0, f"{AT}.links[0].parent"),
        ((*LINKS, 0, "joint"), {"type": "fixed"}, f"{AT}.links[0].joint"),
        ((*LINKS, 1, "parent"), ..., f"{AT}.links[1]"),
        ((*LINKS, 2, "parent"), 2, f"{AT}.links[2].parent"),
        ((*LINKS, 2, "parent"), 7, f"{AT}.links[2].parent"),
        ((*LINKS, 2, "parent"), -1, f"{AT}.links[2].parent"),
        ((*LINKS, 2, "name"), "arm", f"{AT}.links[2].name"),
        ((*LINKS, 2, "joint", "name"), "hinge", f"{AT}.links[2].joint.name"),
        ((*LINKS, 1, "body", "body_type"), "dynamic", f"{AT}.links[1].body.body_type"),
        ((*LINKS, 1, "body", "linear_velocity"), [0, 0, 1], f"{AT}.links[1].body.linear_velocity"),
        ((*LINKS, 1, "joint", "limits"), [1, 0], f"{AT}.links[1].joint.limits"),
        ((*LINKS, 1, "joint", "limits"), [1e999, 1e999], f"{AT}.links[1].joint.limits"),
        ((*LINKS, 1, "joint", "limits"), [0, 1e300], f"{AT}.links[1].joint.limits[1]"),
        ((*LINKS, 1, "joint", "limits"), [0, float("nan")], f"{AT}.links[1].joint.limits[1]"),
        ((*LINKS, 2, "joint"), {"type": "fixed", "friction": 1}, f"{AT}.links[2].joint.friction"),
        ((*STRUCTURE, "mimics", 0, "source"), "base", f"{AT}.mimics[0].source"),
        ((*STRUCTURE, "mimics", 0, "source"), "slide", f"{AT}.mimics[0].source"),
        ((*STRUCTURE, "mimics", 0, "multiplier"), 0, f"{AT}.mimics[0].multiplier"),
        (("entities", 1, "structures", 0, "body_type"), "link", "entities[1].structures[0].body_type"),
        (("constraints", 0, "child", "entity"), "bal", "constraints[0].child.entity"),
        (("constraints", 0, "child", "entity"), "alone", "constraints[0].child.entity"),
        (("constraints", 0, "child", "link"), "hand", "constraints[0].child.link"),
        (("constraints", 0, "parent", "link"), "foot", "constraints[0].parent.link"),
        (("constraints", 0, "parent", "link"), ..., "constraints[0].parent"),
        (("constraints", 1, "name"), "drawn", "constraints[1].name"),
        (("constraints", 1, "joint", "limits"), [1, 0], "constraints[1].joint.limits"),
        (
            ("constraints", 0, "joint", "limits"),
            [{"axis": "x", "limits": [0, 1]}] * 2,
            "constraints[0].joint.limits[1].axis",
        ),
        (("cameras", 0, "name"), "ball", "cameras[0].name"),
        (("cameras", 0, "mount", "entity"), "none", "cameras[0].mount.entity"),
        (("lights", 0, "mount", "link"), "none", "lights[0].mount.link"),
        (("lights", 0, "scene_idxs"), [3], "lights[0].scene_idxs"),
        (("environment", "ambient_light"), {"per_scene": [[1, 1, 1]]}, "environment.ambient_light.per_scene"),
    ],
)
def test_what_is_invalid_is_reported_at_its_place(path: tuple[Any, ...], value: Any, where: str) -> None:
    ((code, found),) = faults(edited((path, value)))
    assert code == "SC701"
    assert found
    assert where.startswith(found) or found.startswith(where)


def test_no_more_links_are_read_than_the_engine_counts() -> None:
    def chain(count: int) -> str:
        data = json.loads(edited((("constraints",), []), (("cameras",), []), (("lights",), [])))
        structure = data["entities"][0]["structures"][0]
        body, joint = {"body_type": "link", "collisions": [], "visuals": []}, {"type": "fixed"}
        structure["links"] += [
            {"name": f"l{n}", "body": body, "parent": n - 1, "joint": joint} for n in range(3, count)
        ]
        return json.dumps(data)

    sink = Sink()
    assert plan_from_json(chain(255), base=Path("/files"), sink=sink) is not None, sink.diagnostics()
    assert faults(chain(256)) == [("SC701", f"{AT}.links")]


def test_a_body_and_an_articulation_are_not_one_entity() -> None:
    data = json.loads(edited())
    structures = [*data["entities"][0]["structures"], *data["entities"][1]["structures"]]
    assert faults(edited((("entities", 0, "structures"), structures))) == [("SC701", "entities[0].structures")]


def test_links_have_rows_of_materials_for_all_their_scenes() -> None:
    text = edited((("physical_materials", 0, "static_friction"), {"per_scene": [1, 2, 3]}))
    assert faults(text) == [("SC701", "entities[0]")]
