"""Overlaps that `check` finds, against two libraries of collision detection: Coal and MuJoCo."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest

from scenecc import load_scene
from scenecc.geometry.rotations import Quat, normalized, rotate
from scenecc.simulation.check import batch_findings

coal = pytest.importorskip("coal")
mujoco = pytest.importorskip("mujoco")

PAIRS = 40
"""Of each two shapes, a scene each."""

DEPTHS = (0.004, 0.002, 0.001, 0.0, -0.001, -0.003)
"""[m] How deep the shapes are in each other, negative where they are apart; 0.5 mm is the most that is no finding."""

SURE = 0.0002
"""[m] By how much the libraries may differ from the depth that was aimed at for a pair to be asked of us."""

SHAPES: dict[str, dict[str, Any]] = {
    "box": {"type": "box", "half_size": [0.05, 0.03, 0.08]},
    "sphere": {"type": "sphere", "radius": 0.06},
    "capsule": {"type": "capsule", "radius": 0.04, "half_length": 0.06},
}


def of_coal(shape: dict[str, Any]) -> Any:
    match shape["type"]:
        case "box":
            return coal.Box(*(2 * side for side in shape["half_size"]))
        case "sphere":
            return coal.Sphere(shape["radius"])
        case _:
            return coal.Capsule(shape["radius"], 2 * shape["half_length"])


def of_mujoco(shape: dict[str, Any]) -> str:
    match shape["type"]:
        case "box":
            size = shape["half_size"]
        case "sphere":
            size = [shape["radius"]]
        case _:
            size = [shape["radius"], shape["half_length"]]
    return f'type="{shape["type"]}" size="{" ".join(map(str, size))}"'


def along_x(shape: dict[str, Any], q: Quat) -> Quat:
    """The turn for libraries whose capsules are along z, where SAPIEN's are along x: first a quarter about y."""
    if shape["type"] != "capsule":
        return q
    w, x, y, z = q
    half = 0.5**0.5
    return half * (w - y), half * (x - z), half * (w + y), half * (x + z)


def matrix(q: Quat) -> Any:
    """(3, 3)"""
    return np.array([rotate(q, axis) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]).T


def coal_distance(a: dict[str, Any], pose_a: Any, b: dict[str, Any], pose_b: Any) -> tuple[float, Any]:
    """[m], negative where they overlap, and the direction from a to b."""
    frames = [
        coal.Transform3s(matrix(along_x(shape, q)), np.array(p, float)) for shape, (p, q) in ((a, pose_a), (b, pose_b))
    ]
    result = coal.DistanceResult()
    distance = coal.distance(of_coal(a), frames[0], of_coal(b), frames[1], coal.DistanceRequest(), result)
    return float(distance), np.array(result.normal)


def mujoco_distances(a: dict[str, Any], b: dict[str, Any], poses: list[Any]) -> list[float]:
    geoms = "".join(f'<body mocap="true"><geom {of_mujoco(shape)}/></body>' for shape in (a, b))
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    found: list[float] = []
    for pair in poses:
        for number, (shape, (p, q)) in enumerate(zip((a, b), pair, strict=True)):
            data.mocap_pos[number], data.mocap_quat[number] = p, along_x(shape, q)
        mujoco.mj_kinematics(model, data)
        found.append(float(mujoco.mj_geomDistance(model, data, 0, 1, 1.0, None)))
    return found


def turned(random: Random) -> Quat:
    w, x, y, z = (random.gauss(0, 1) for _ in range(4))
    return normalized((w, x, y, z))


@pytest.mark.parametrize(("one", "other"), [(a, b) for a in SHAPES for b in SHAPES if a <= b])
def test_an_overlap_is_found_where_two_libraries_see_it(one: str, other: str) -> None:
    random, a, b = Random(f"{one} {other}"), SHAPES[one], SHAPES[other]
    poses, depths = [], []
    while len(poses) < PAIRS:
        direction = np.array(rotate(turned(random), (1.0, 0.0, 0.0)))
        first, second = ([0.0, 0.0, 1.0], turned(random)), ((direction * 0.2 + (0, 0, 1)).tolist(), turned(random))
        distance, normal = coal_distance(a, first, b, second)
        depth = random.choice(DEPTHS)
        second = ((np.array(second[0]) - normal * (distance + depth)).tolist(), second[1])
        if abs(coal_distance(a, first, b, second)[0] + depth) < SURE:
            poses.append((first, second))
            depths.append(depth)
    theirs = mujoco_distances(a, b, poses)
    agreed = [i for i, (depth, distance) in enumerate(zip(depths, theirs, strict=True)) if abs(depth + distance) < SURE]
    assert len(agreed) > 0.8 * PAIRS
    entities = {
        name: {
            "gravity": False,
            "pose": {"per_scene": [{"p": pair[number][0], "q": pair[number][1]} for pair in poses]},
            "shapes": [shape],
        }
        for number, (name, shape) in enumerate((("a", a), ("b", b)))
    }
    with load_scene({"scenecc": 1, "num_scenes": PAIRS, "entities": entities}, render=False) as batch:
        found = {
            finding.scene: finding.amount for finding in batch_findings(batch, 0.0, set()) if finding.code == "SC850"
        }
    assert [i in found for i in agreed] == [depths[i] > 0.0005 for i in agreed]
    for i in {*agreed} & {*found}:
        # Two edges that cross are pushed apart along the normal of a face, which is a little longer.
        assert found[i] == pytest.approx(depths[i], rel=0.25)
