"""What is told of articulations, and of what is fastened to entities."""

from __future__ import annotations

import dataclasses
import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.plan_parts import entity, indices, pose, solid
from plugins.robot_plans import arm, crawler, robots, statue
from plugins.sample_plans import SAMPLES

import scenecc
from scenecc import SummaryRow
from scenecc.backends.sapien import instantiate
from scenecc.diagnostics import Sink
from scenecc.inspect import summarize
from scenecc.plan import (
    AxisDrive,
    AxisLimit,
    Camera,
    Constraint,
    Drive,
    Entity,
    Environment,
    Light,
    Mount,
    Perspective,
    PointLight,
    ScenePlan,
    Sphere,
    constant,
    literal,
    per_scene,
    recalled,
)
from scenecc.plan.body import AssetFile
from scenecc.variation.nodes import Drawn, Key


def planned(plan: ScenePlan) -> dict[str, SummaryRow]:
    return {row.name: row for row in summarize(plan, None)}


def test_the_summary_counts_links_and_moving_joints() -> None:
    rows = planned(robots())
    assert (rows["arm_0"].body_type, rows["arm_0"].link_count, rows["arm_0"].dof) == ("articulation", 7, 4)
    assert (rows["arm_0"].shape_count, rows["arm_0"].size) == (6, None)
    assert (rows["statue or crawler"].link_count, rows["statue or crawler"].dof) == (2, 0)
    assert (rows["ball"].link_count, rows["ball"].dof, rows["ball"].section) == (0, 0, "entities")


def test_varying_fields_of_an_articulation_have_link_names() -> None:
    fields = {field.field: field.values for field in planned(robots())["crawler"].varying}
    assert fields["angular_velocity"] == "[0, 0, 1] | [0, 0, -1]"
    assert fields['links["leg 1"].mass'] == "0.1 | 0.2"
    assert fields["links.foot.joint.damping"] == "1 | 2"
    assert fields["links.tail.joint.force_limit"] == "1 | 2"
    fields = {field.field: field.values for field in planned(SAMPLES["links"]())["chest"].varying}
    assert fields["mimics.wheel.multiplier"] == "2 | -1"


def test_the_file_of_a_robot_is_shown_for_every_format() -> None:
    plan = robots()
    files = (AssetFile("one.xml", Path("one.xml")), AssetFile("two.xml", Path("two.xml")))
    structure = dataclasses.replace(crawler(), file=indices(0, 1))
    found = [dataclasses.replace(each, structures=(structure,)) for each in plan.entities if each.name == "crawler"]
    (row,) = summarize(dataclasses.replace(plan, entities=tuple(found), files=files), None)
    assert {field.field: field.values for field in row.varying}["file"] == "one.xml | two.xml"


def test_joint_fields_that_a_reset_draws_are_marked() -> None:
    node = Drawn("uniform", (0, 1), (), Key("entities", "robot", "qpos"))
    structure = arm(ids=constant([1, 1, 0, 0], np.int64), start=recalled(np.array([0.3, 0.4]), node))
    robot = Entity("robot", (0, 1), pose(0, 0, 0), (structure,))
    row = planned(dataclasses.replace(robots(), entities=(robot,)))["robot"]
    assert [(field.field, field.at_reset) for field in row.varying] == [
        ("links.upper.joint.qpos", True),
        ("links.upper.joint.drive_target", True),
    ]


def test_the_mass_of_a_built_articulation_is_the_sum_of_its_links() -> None:
    plan, sink = robots(), Sink()
    batch = instantiate(plan, sink, render=False)
    assert batch is not None, sink.diagnostics()
    with batch:
        rows = {row.name: row for row in summarize(plan, batch)}
        links = batch.articulations["crawler"].objs[0].get_links()
        assert rows["crawler"].mass == pytest.approx(sum(link.get_mass() for link in links))
    assert rows["crawler"].masses is not None
    assert rows["crawler"].masses[1] - rows["crawler"].masses[0] == pytest.approx(0.2)
    assert rows["arm_0"].link_count == 7


def test_the_size_of_a_built_body_is_that_of_its_collision_shapes() -> None:
    foot, head = statue().links
    structure = dataclasses.replace(statue(), links=(foot, dataclasses.replace(head, body=foot.body)))
    # A rod of 0.24 × 0.04 × 0.04 m, and another one 0.3 m above it; turned, it is as large.
    turned = pose(0, 0, 0, (0.7071068, 0, 0, 0.7071068))
    robot = Entity("robot", (0,), turned, (structure,))
    plan = dataclasses.replace(robots(), num_scenes=1, entities=(robot,), files=())
    batch = instantiate(plan, Sink(), render=False)
    assert batch is not None
    with batch:
        (row,) = summarize(plan, batch)
    assert row.size == pytest.approx((0.24, 0.04, 0.34), abs=1e-6)


def test_the_size_of_a_rotated_round_shape_is_exact() -> None:
    shapes = {"capsule": {"radius": 0.05}, "cylinder": {"radius": 0.05}, "box": {}}
    for kind, sizes in shapes.items():
        shape = {"type": kind, "half_size": [0.2, 0.05, 0.05]} if kind == "box" else {"type": kind, "half_length": 0.2}
        rod = {
            "name": "rod",
            "joint": {"name": "turn", "type": "revolute", "axis": [0, 1, 0], "limits": [-2, 2]},
            "shapes": [shape | sizes],
        }
        base = {"name": "base", "shapes": [{"type": "sphere", "radius": 0.1}], "children": [rod]}
        robot = {"root": base, "fix_root_link": True, "qpos": {"turn": math.pi / 4}}
        source = {"scenecc": 1, "entities": {"robot": robot}}
        with scenecc.load_scene(source, render=False) as batch:
            (row,) = summarize(batch.plan, batch)
        long = 0.2 * math.sqrt(2) + (0.1 if kind == "capsule" else 0.05 * math.sqrt(2))
        assert row.size == pytest.approx((long, 0.2, long), abs=1e-6), kind


def test_a_drive_that_is_a_ball_joint_is_shown_as_one() -> None:
    held = tuple(AxisLimit(axis, literal((0.0, 0.0))) for axis in ("x", "y", "z"))
    slerp = AxisDrive("slerp", literal(0), literal(2))
    twist = AxisDrive("twist", literal(0), literal(2))
    for drive, word in (
        (Drive(held), "ball"),
        (Drive((*held, AxisLimit("twist", per_scene([[0, 1], [0, 2]]))), (slerp,)), "ball"),
        (Drive(held[:2]), "drive"),
        (Drive(held, (twist,)), "drive"),
        (Drive(held, inv_mass_scales=literal((0.5, 1.0))), "drive"),
        (Drive((*held[:2], AxisLimit("z", literal((0.0, 0.0)), literal(10.0)))), "drive"),
    ):
        ball = entity("ball", pose(0, 0, 0), solid(Sphere(constant(0.1))))
        tie = Constraint("tie", (0, 1), drive, Mount("ball"))
        plan = dataclasses.replace(robots(), entities=(ball,), constraints=(tie,))
        assert [row.body_type for row in summarize(plan, None) if row.section == "constraints"] == [word]


def test_constraints_lights_and_cameras_have_summary_rows() -> None:
    here: dict[str, Any] = {"scene_idxs": (0,), "pose": pose(0, 0, 1)}
    drive = Drive((AxisLimit("x", per_scene([[0, 1], [0, 2]])),), (AxisDrive("slerp", literal(1), literal(2)),))
    plan = dataclasses.replace(
        robots(),
        entities=(
            Entity("robot", (0, 1), pose(0, 0, 0), (crawler(),)),
            entity("ball", pose(0, 0, 0), solid(Sphere(constant(0.1)))),
        ),
        constraints=(Constraint("tied", (0, 1), drive, Mount("ball"), Mount("robot", "foot")),),
        environment=Environment(ambient_light=per_scene([[0, 0, 0], [1, 1, 1]])),
        lights=(Light("lamp", light=PointLight(), color=constant([1, 1, 1]), **here),),
        cameras=(
            Camera(
                "eye",
                width=64,
                height=48,
                lens=Perspective(fovy=literal(1)),
                near=literal(0.01),
                far=literal(10),
                mount=Mount("robot", "foot"),
                **here,
            ),
        ),
    )
    rows = planned(plan)
    assert list(rows) == ["robot", "ball", "tied", "environment", "lamp", "eye"]
    told = [(row.section, row.body_type, row.mounts, row.scene_idxs) for row in list(rows.values())[2:]]
    assert told == [
        ("constraints", "drive", ("ball", "robot/foot"), (0, 1)),
        ("environment", "environment", (), (0, 1)),
        ("lights", "point", ("world",), (0,)),
        ("cameras", "camera", ("robot/foot",), (0,)),
    ]
    assert [field.field for field in rows["tied"].varying] == ["limits.x"]
    assert [field.field for field in rows["environment"].varying] == ["ambient_light"]
    assert [row.name for row in summarize(plan, None, (1,))] == ["robot", "ball", "tied", "environment"]


def test_a_joint_with_a_friction_force_shows_a_ratio_that_is_built_as_well() -> None:
    text = (
        "{scenecc: 1, entities: {door: {root: {name: frame, shapes: [{type: sphere, radius: 0.1}], children: ["
        "{name: a, shapes: [{type: sphere, radius: 0.1}], joint: {name: j, type: revolute, friction_force: 3}},"
        "{name: b, shapes: [{type: sphere, radius: 0.1}],"
        " joint: {name: k, type: revolute, friction: 0.2, friction_force: 3}}]}}}}"
    )
    (door,) = scenecc.inspect_scene(io.StringIO(text)).data()["entities"]
    first, second = (link["joint"] for link in door["links"][1:])
    assert (first["friction_force"], second["friction_force"]) == (3, 3)
    assert ("friction" in first, second["friction"]) == (False, 0.2)
