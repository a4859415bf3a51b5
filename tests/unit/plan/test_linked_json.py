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
from scenecc.source.limits import Limits

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
    ("path", "value", "code", "where"),
    [
        (LINKS, [], "SC706", f"{AT}.links"),
        ((*LINKS, 0, "parent"), 0, "SC714", f"{AT}.links[0].parent"),
        ((*LINKS, 0, "joint"), {"type": "fixed"}, "SC714", f"{AT}.links[0].joint"),
        ((*LINKS, 1, "parent"), ..., "SC714", f"{AT}.links[1]"),
        ((*LINKS, 2, "parent"), 2, "SC714", f"{AT}.links[2].parent"),
        ((*LINKS, 2, "parent"), 7, "SC714", f"{AT}.links[2].parent"),
        ((*LINKS, 2, "parent"), -1, "SC707", f"{AT}.links[2].parent"),
        ((*LINKS, 2, "name"), "arm", "SC710", f"{AT}.links[2].name"),
        ((*LINKS, 2, "joint", "name"), "hinge", "SC710", f"{AT}.links[2].joint.name"),
        ((*LINKS, 1, "body", "body_type"), "dynamic", "SC705", f"{AT}.links[1].body.body_type"),
        ((*LINKS, 1, "body", "linear_velocity"), [0, 0, 1], "SC703", f"{AT}.links[1].body.linear_velocity"),
        ((*LINKS, 1, "joint", "limits"), [1, 0], "SC707", f"{AT}.links[1].joint.limits"),
        ((*LINKS, 1, "joint", "limits"), [1e999, 1e999], "SC707", f"{AT}.links[1].joint.limits"),
        ((*LINKS, 1, "joint", "limits"), [0, 1e300], "SC707", f"{AT}.links[1].joint.limits[1]"),
        ((*LINKS, 1, "joint", "limits"), [0, float("nan")], "SC707", f"{AT}.links[1].joint.limits[1]"),
        ((*LINKS, 2, "joint"), {"type": "fixed", "friction": 1}, "SC703", f"{AT}.links[2].joint.friction"),
        ((*STRUCTURE, "mimics", 0, "source"), "base", "SC715", f"{AT}.mimics[0].source"),
        ((*STRUCTURE, "mimics", 0, "source"), "slide", "SC715", f"{AT}.mimics[0].source"),
        ((*STRUCTURE, "mimics", 0, "multiplier"), 0, "SC707", f"{AT}.mimics[0].multiplier"),
        (("entities", 1, "structures", 0, "body_type"), "link", "SC705", "entities[1].structures[0].body_type"),
        (("constraints", 0, "child", "entity"), "bal", "SC715", "constraints[0].child.entity"),
        (("constraints", 0, "child", "entity"), "alone", "SC709", "constraints[0].child.entity"),
        (("constraints", 0, "child", "link"), "hand", "SC715", "constraints[0].child.link"),
        (("constraints", 0, "parent", "link"), "foot", "SC715", "constraints[0].parent.link"),
        (("constraints", 0, "parent", "link"), ..., "SC704", "constraints[0].parent"),
        (("constraints", 1, "name"), "drawn", "SC710", "constraints[1].name"),
        (("constraints", 1, "joint", "limits"), [1, 0], "SC707", "constraints[1].joint.limits"),
        (
            ("constraints", 0, "joint", "limits"),
            [{"axis": "x", "limits": [0, 1]}] * 2,
            "SC710",
            "constraints[0].joint.limits[1].axis",
        ),
        (("cameras", 0, "name"), "ball", "SC710", "cameras[0].name"),
        (("cameras", 0, "mount", "entity"), "none", "SC715", "cameras[0].mount.entity"),
        (("lights", 0, "mount", "link"), "none", "SC715", "lights[0].mount.link"),
        (("lights", 0, "scene_idxs"), [3], "SC709", "lights[0].scene_idxs"),
        (("environment", "ambient_light"), {"per_scene": [[1, 1, 1]]}, "SC706", "environment.ambient_light.per_scene"),
    ],
)
def test_each_fault_is_told_at_its_place(path: tuple[Any, ...], value: Any, code: str, where: str) -> None:
    assert faults(edited((path, value)))[0] == (code, where)


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
    assert faults(chain(256)) == [("SC706", f"{AT}.links")]


def test_a_body_and_an_articulation_are_not_one_entity() -> None:
    data = json.loads(edited())
    structures = [*data["entities"][0]["structures"], *data["entities"][1]["structures"]]
    assert faults(edited((("entities", 0, "structures"), structures))) == [("SC705", "entities[0].structures")]


def test_links_have_rows_of_materials_for_all_their_scenes() -> None:
    text = edited((("physical_materials", 0, "static_friction"), {"per_scene": [1, 2, 3]}))
    assert faults(text) == [("SC706", f"{AT}.links[0].body.collisions[0].material")]


def test_shapes_of_links_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.source.limits._SCENES_PER_OBJECT", 1)
    # Three links in two scenes are six, two balls and the one that is alone three, and six of what holds on.
    assert faults(edited(), limits=Limits(objects=8)) == [("SC712", "entities[2].scene_idxs")]
    sink = Sink()
    assert plan_from_json(edited(), base=Path("/files"), sink=sink, limits=Limits(objects=15)) is not None
    assert faults(edited(), limits=Limits(objects=14)) == [("SC712", "cameras[0].scene_idxs")]
