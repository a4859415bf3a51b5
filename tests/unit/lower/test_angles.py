"""Angles in radians that look like degrees: where they are told, and how one says that they are meant."""

from __future__ import annotations

import math
from typing import Any

import pytest

from scenecc import compile_scene, validate
from scenecc.plan import ArticulationStructure

BALL = [{"type": "sphere", "radius": 0.1}]


def told(**document: Any) -> list[tuple[str, str | None]]:
    return [(one.code, one.path) for one in validate({"scenecc": 1, "num_scenes": 2, **document})]


def body(pose: Any) -> dict[str, Any]:
    return {"entities": {"it": {"shapes": BALL, "pose": pose}}}


def arm(joint: dict[str, Any], **keys: Any) -> dict[str, Any]:
    hand = {"name": "hand", "joint": {"name": "elbow", **joint}, "shapes": BALL}
    return {"entities": {"arm": {"root": {"name": "base", "shapes": BALL, "children": [hand]}, **keys}}}


DRAWN = {"uniform": [-180, 180]}


@pytest.mark.parametrize(
    ("pose", "key"),
    [
        ({"rpy": [0, 0, 90]}, "rpy"),
        ({"rpy": [0, -45, 0]}, "rpy"),
        ({"rpy": [0, 0, DRAWN]}, "rpy"),
        ({"rpy": {"choice": [[0, 0, 90], [0, 0, 180]]}}, "rpy"),
        ({"rpy": {"per_scene": [[0, 0, 90], [0, 0, -90]]}}, "rpy"),
        ({"rpy": {"per_scene": {0: [0, 0, 90], "default": [0, 0, -90]}}}, "rpy"),
        ({"axis_angle": {"axis": "z", "angle": 90}}, "axis_angle.angle"),
        ({"axis_angle": {"axis": "z", "angle": DRAWN}}, "axis_angle.angle"),
    ],
    ids=str,
)
def test_a_rotation_beyond_two_turns_is_told(pose: Any, key: str) -> None:
    assert told(**body(pose)) == [("SC526", f"entities.it.pose.{key}")]


@pytest.mark.parametrize(
    "pose",
    [
        {"rpy": [0, 0, 12.56]},
        {"rpy_deg": [0, 0, 5400]},
        {"rpy": [0, 0, {"uniform": [0, 90]}]},
        {"rpy": [0, 0, {"normal": [0, 90]}]},
        {"rpy": {"cycle": [[0, 0, 90], [0, 0, 0]]}},
        {"rpy": {"cycle": [[0, 90, 0], [0, 0, 90]]}},
        {"axis_angle": {"axis": "z", "angle_deg": 90}},
    ],
    ids=str,
)
def test_a_rotation_that_may_be_meant_is_not_told(pose: Any) -> None:
    assert told(**body(pose)) == []


def test_the_pose_of_a_shape_is_told_too() -> None:
    shapes = [{**BALL[0], "pose": {"rpy": [0, 0, 90]}}]
    assert told(entities={"it": {"shapes": shapes}}) == [("SC526", "entities.it.shapes[0].pose.rpy")]


@pytest.mark.parametrize("type_", ["revolute", "revolute_unwrapped"])
@pytest.mark.parametrize("limits", [[-90, 90], [0, 90], [-float("inf"), 90], {"cycle": [[-90, 0], [-45, 0]]}], ids=str)
def test_limits_beyond_two_turns_are_told(type_: str, limits: Any) -> None:
    where = "entities.arm.root.children[0].joint.limits"
    assert told(**arm({"type": type_, "limits": limits})) == [("SC526", where)]
    said = arm({"type": type_}, joints={"el.*": {"limits": limits}})
    assert told(**said) == [("SC526", 'entities.arm.joints["el.*"].limits')]


@pytest.mark.parametrize(
    ("type_", "keys"),
    [
        ("revolute", {"limits": [-12.5, 12.5]}),
        ("revolute", {"limits_deg": [0, 3600]}),
        ("revolute", {"limits": [-float("inf"), float("inf")]}),
        ("prismatic", {"limits": [-90, 90]}),
    ],
    ids=str,
)
def test_limits_that_are_meant_are_not_told(type_: str, keys: Any) -> None:
    assert told(**arm({"type": type_, **keys})) == []
    assert told(**arm({"type": type_}, joints={"elbow": keys})) == []


def test_limits_of_joints_may_be_in_degrees() -> None:
    document = {"scenecc": 1, **arm({"type": "revolute"}, joints={".*": {"limits_deg": [-90, 180]}})}
    structure = compile_scene(document).entities[0].structures[0]
    assert isinstance(structure, ArticulationStructure)
    joint = structure.links[1].joint
    assert joint is not None
    assert joint.limits is not None
    assert joint.limits.numbers() == (-math.pi / 2, math.pi)


def test_limits_of_joints_are_written_once_and_in_degrees_where_they_are_angles() -> None:
    both = {"elbow": {"limits": [0, 1], "limits_deg": [0, 90]}}
    assert told(**arm({"type": "revolute"}, joints=both)) == [("SC111", "entities.arm.joints.elbow.limits_deg")]
    degrees = {"elbow": {"limits_deg": [0, 90]}}
    assert told(**arm({"type": "prismatic"}, joints=degrees)) == [("SC111", "entities.arm.joints.elbow.limits_deg")]


@pytest.mark.parametrize("qpos", [{"elbow": 45}, [45], {"elbow": DRAWN}, {"choice": [[90], [180]]}], ids=str)
def test_a_position_beyond_two_turns_is_told_where_no_limits_tell(qpos: Any) -> None:
    joint = {"type": "continuous"}
    ((code, path),) = told(**arm(joint, qpos=qpos))
    assert (code, str(path).startswith("entities.arm.qpos")) == ("SC526", True)
    assert told(**arm(joint, qpos=qpos, beyond_limits=True)) == []


def test_a_position_that_may_be_meant_is_not_told() -> None:
    assert told(**arm({"type": "continuous"}, qpos=[-12.5])) == []
    assert told(**arm({"type": "prismatic"}, qpos=[45])) == []
    assert told(**arm({"type": "revolute", "limits_deg": [0, 3600]}, qpos=[45])) == []
