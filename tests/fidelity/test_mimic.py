"""Joints that mimic others do what URDF says, under load: measured in simulation, for every place in the tree."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from fidelity.hand import box_shape, built

from scenecc.plan import (
    ArticulationStructure,
    BodyStructure,
    Entity,
    Joint,
    JointType,
    Link,
    Mimic,
    Physics,
    ScenePlan,
    constant,
)

AXIS = [0.7071068, 0, 0.7071068, 0]
TARGET = 0.3

TREES: dict[str, list[tuple[str, int]]] = {
    "siblings": [("s", 0), ("j", 0)],
    "child of the source": [("s", 0), ("j", 1)],
    "over a joint": [("s", 0), ("x", 1), ("j", 2)],
    "cousins": [("x", 0), ("y", 0), ("s", 1), ("j", 2)],
}
"""Links by name and number of the parent, from the second on."""


def robot(where: str, kind: JointType, multiplier: float, offset: float) -> ScenePlan:
    """Arms of 0.5 kg that hang down sideways; the source is driven, and what lies between holds still."""
    links = [Link("base", BodyStructure("link", (box_shape(0.05, 0.05, 0.05),)))]
    for number, (name, parent) in enumerate(TREES[where]):
        turn = AXIS if kind == "revolute" else [1, 0, 0, 0]
        drive: dict[str, Any] = {}
        if name != "j":
            drive = {"stiffness": constant(2000), "damping": constant(200)}
        if name == "s":
            drive |= {"qpos": constant(TARGET), "drive_target": constant(TARGET)}
        if name == "j":
            drive = {"qpos": constant(multiplier * TARGET + offset)}
        joint = Joint(
            kind,
            f"j{name}",
            constant([0.2, 0.1 * number, 0, *turn]),
            constant([0, 0, 0, *turn]),
            **drive,
        )
        shape = box_shape(0.1, 0.02, 0.02, pose=constant([0.1, 0, 0, 1, 0, 0, 0]))
        body = BodyStructure("link", (shape,), mass=constant(0.5), collision_groups=constant([0, 0, 0, 0], np.int64))
        links.append(Link(name, body, parent, joint))
    mimic = Mimic("jj", "js", constant(multiplier), constant(offset))
    structure = ArticulationStructure(tuple(links), fix_root_link=True, mimics=(mimic,))
    tilted = constant([0, 0, 1, 0.9238795, 0.3826834, 0, 0])
    return ScenePlan("mimic", 1, (Entity("robot", (0,), tilted, (structure,)),), Physics())


@pytest.mark.parametrize("where", TREES)
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
@pytest.mark.parametrize(("multiplier", "offset"), [(0.5, 0.1), (-1.0, 0.2), (1.0, 0.0), (2.0, -0.2), (-0.3, 0.0)])
def test_a_joint_follows(where: str, kind: JointType, multiplier: float, offset: float) -> None:
    """Its load is what tears it off, by less than 1e-3 rad or m at 0.5 kg where it does not move faster."""
    batch = built(robot(where, kind, multiplier, offset))
    arm = batch.articulations["robot"]
    names = arm.active_joint_names
    source, joint = names.index("js"), names.index("jj")
    for target in (TARGET, -0.2):
        numbers = [target if name == "js" else 0.0 for name in names]
        arm.drive_target = numbers
        batch.step(600)
        found = arm.qpos[0]
        assert abs(found[source] - target) < 0.05
        assert abs(found[joint] - (multiplier * found[source] + offset)) < (1e-3 if abs(multiplier) <= 1 else 3e-3)
        assert abs(arm.qvel).max() < 1


def test_the_source_feels_its_load() -> None:
    """The tendon works both ways: what pushes the mimicking joint moves the source, in proportion."""
    batch = built(robot("siblings", "revolute", 0.5, 0.0))
    arm = batch.articulations["robot"]
    for drives in arm.joints.values():
        for joint in drives:
            joint.set_drive_properties(0.0, 0.5)
    before = arm.qpos[0]
    numbers = [3.0 if name == "jj" else 0.0 for name in arm.active_joint_names]
    for _ in range(30):
        arm.objs[0].set_qf(np.array(numbers, np.float32))
        batch.step()
    moved = dict(zip(arm.active_joint_names, (arm.qpos[0] - before).tolist(), strict=True))
    assert abs(moved["js"]) > 0.05
    assert moved["jj"] == pytest.approx(0.5 * moved["js"], abs=2e-3)
