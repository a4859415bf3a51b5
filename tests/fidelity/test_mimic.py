"""Joints that mimic others do what URDF says, under load: measured in simulation, for every place in the tree.

Joints on different links are coupled by a soft tendon. Its forces are compared with virtual work, its motion with the
conservation of momentum, and both with MuJoCo.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from fidelity.hand import box_shape, built

from scenecc import load_scene, validate
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

if TYPE_CHECKING:
    from pathlib import Path

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
    """Its load is what tears it off, by less than 2e-3 rad or m at 0.5 kg where it does not move faster."""
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
        assert abs(found[joint] - (multiplier * found[source] + offset)) < (2e-3 if abs(multiplier) <= 1 else 4e-3)
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


@pytest.mark.parametrize(
    ("kinds", "masses", "multiplier", "stiffness"),
    [
        (("revolute", "revolute"), (0.05, 0.2), 1.0, 1.0),
        (("revolute", "revolute"), (0.2, 0.05), -1.0, 1.0),
        (("revolute", "revolute"), (0.2, 0.05), 2.0, 1.0),
        (("prismatic", "prismatic"), (0.1, 0.5), 1.0, 100.0),
        (("prismatic", "revolute"), (0.5, 0.05), 10.0, 200.0),
        (("revolute", "prismatic"), (0.05, 0.5), 0.05, 2.0),
    ],
)
@pytest.mark.parametrize("timestep", [0.01, 0.002])
def test_joints_of_unequal_inertia_on_one_link_rest_where_virtual_work_has_them(
    kinds: tuple[str, str], masses: tuple[float, float], multiplier: float, stiffness: float, timestep: float
) -> None:
    """The weights of both links are carried by the drive of the source."""
    children = ""
    for name, kind, mass, keys in zip(
        "sf", kinds, masses, ("", f", mimic: {{joint: s, multiplier: {multiplier}}}"), strict=True
    ):
        axis, moment = "z" if kind == "prismatic" else "y", mass * 4e-4 + 1e-6
        children += (
            f"{{name: l{name}, joint: {{name: {name}, type: {kind}, axis: {axis}, friction: 0{keys}}},"
            f" inertial: {{mass: {mass}, com: [0.03, 0, 0], inertia: [{moment}, {moment}, {moment}]}}}},"
        )
    batch = loaded(
        f"{{scenecc: 1, physics: {{timestep: {timestep}}}, entities: {{hand: {{fix_root_link: true, root: {{name: base,"
        f" shapes: [{{type: box, half_size: [0.01, 0.01, 0.01]}}], children: [{children}]}},"
        f" drives: {{s: {{stiffness: {stiffness}, damping: {stiffness / 10}}}}}}}}}}}"
    )
    batch.step(round(6 / timestep))
    hand = batch.articulations["hand"]
    place = dict(zip(hand.active_joint_names, hand.qpos[0].tolist(), strict=True))

    def load(kind: str, mass: float, position: float) -> float:
        return mass * 9.81 * (-1 if kind == "prismatic" else 0.03 * np.cos(position))

    expected = 0.0
    for _ in range(100):
        loads = [load(*one) for one in zip(kinds, masses, (expected, multiplier * expected), strict=True)]
        expected += 0.5 * ((loads[0] + multiplier * loads[1]) / stiffness - expected)
    assert place["s"] == pytest.approx(expected, abs=0.0025)
    assert place["f"] == pytest.approx(multiplier * place["s"], abs=0.0025)


@pytest.mark.parametrize("masses", [(0.02, 0.4), (0.3, 0.05)])
def test_joints_of_unequal_inertia_on_one_link_rest_without_substeps(masses: tuple[float, float]) -> None:
    """In the solver that is not temporal, large shares of a soft tendon would diverge."""
    links = [
        f"{{name: l{name}, joint: {{name: {name}, type: revolute, axis: y, friction: 0{keys}}},"
        f" inertial: {{mass: {mass}, com: [0.03, 0, 0], inertia: [{4e-4 * mass}, {4e-4 * mass}, {4e-4 * mass}]}}}}"
        for name, mass, keys in zip("sf", masses, ("", ", mimic: {joint: s, multiplier: -0.5}"), strict=True)
    ]
    batch = loaded(
        f"{{scenecc: 1, physics: {{enable_tgs: false}}, entities: {{hand: {{fix_root_link: true, root: {{name: base,"
        f" shapes: [{{type: box, half_size: [0.01, 0.01, 0.01]}}], children: [{', '.join(links)}]}},"
        f" drives: {{s: {{stiffness: 1, damping: 0.1}}}}}}}}}}"
    )
    batch.step(300)
    hand = batch.articulations["hand"]
    place = dict(zip(hand.active_joint_names, hand.qpos[0].tolist(), strict=True))
    assert place["s"] == pytest.approx(9.81 * 0.03 * (masses[0] - 0.5 * masses[1]), abs=0.01)
    assert place["f"] == pytest.approx(-0.5 * place["s"], abs=0.03)


def finger(
    joints: list[str], *, timestep: float = 0.01, free: bool = False, gravity: str = "0, 0, 0", drives: str = ""
) -> str:
    """A scene with a chain of links of 0.2 m whose joints about y have no friction. The keys of a joint are text."""
    text = "{name: palm, shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]"
    for number, keys in enumerate(joints):
        given = [
            f"name: j{number}",
            "friction: 0",
            f"origin: {{p: [{0.2 if number else 0}, 0, 0]}}",
            *filter(None, [keys]),
        ]
        given += [default for default in ("type: revolute", "axis: [0, 1, 0]") if default.split(":")[0] not in keys]
        text += f", children: [{{name: l{number}, joint: {{{', '.join(given)}}}, "
        text += "shapes: [{type: box, half_size: [0.1, 0.02, 0.02], pose: [0.1, 0, 0], density: 1000}]"
    root = text + "}]" * len(joints) + "}"
    return (
        f"{{scenecc: 1, physics: {{gravity: [{gravity}], timestep: {timestep}}}, entities: {{hand: {{pose: [0, 0, 1],"
        f" disable_self_collisions: true, fix_root_link: {str(not free).lower()}, root: {root},"
        f" links: {{'.*': {{linear_damping: 0, angular_damping: 0}}}}, drives: {{{drives}}}}}}}}}"
    )


def loaded(text: str) -> Any:
    return load_scene(io.StringIO(text), render=False)


def at_rest(batch: Any, forces: list[float]) -> list[float]:
    """Joint positions after 2 s under constant joint forces."""
    hand = batch.articulations["hand"].objs[0]
    for _ in range(round(2 / batch.timestep)):
        hand.set_qf(np.array(forces, np.float32))
        batch.step()
    return hand.qpos.tolist()


DRIVE = "j0: {stiffness: 10, damping: 1}"


@pytest.mark.parametrize("multiplier", [1.0, -1.0, 0.5, 2.0])
@pytest.mark.parametrize("timestep", [0.01, 0.002])
def test_a_chain_rests_where_virtual_work_has_it(multiplier: float, timestep: float) -> None:
    """A spring of 10 N·m/rad at the source carries what pushes either joint."""
    for forces, expected in (([0.5, 0.0], 0.05), ([0.0, 0.25], 0.025 * multiplier)):
        scene = finger(["", f"mimic: {{joint: j0, multiplier: {multiplier}}}"], timestep=timestep, drives=DRIVE)
        source, joint = at_rest(loaded(scene), forces)
        assert source == pytest.approx(expected, abs=5e-4)
        assert joint == pytest.approx(multiplier * source, abs=2e-3)


@pytest.mark.parametrize(
    ("joints", "drives", "forces", "expected"),
    [
        # Two followers of one source, and a follower of a follower.
        (["", "mimic: {joint: j0}", "mimic: {joint: j0, multiplier: 0.5}"], DRIVE, [0, 0.1, 0.2], [0.02, 0.02, 0.01]),
        (["", "mimic: {joint: j0}", "mimic: {joint: j1, multiplier: 0.5}"], DRIVE, [0, 0.1, 0.2], [0.02, 0.02, 0.01]),
        # The joint between the two feels nothing.
        (["", "", "mimic: {joint: j0}"], f"{DRIVE}, j1: {{stiffness: 5, damping: 1}}", [0, 0, 0.2], [0.02, 0, 0.02]),
        # The joint above the source feels nothing.
        (["", "", "mimic: {joint: j1}"], "'j[01]': {stiffness: 10, damping: 1}", [0, 0, 0.2], [0, 0.02, 0.02]),
    ],
)
def test_other_joints_do_not_feel_a_soft_tendon(
    joints: list[str], drives: str, forces: list[float], expected: list[float]
) -> None:
    scene = finger(joints, timestep=0.002, drives=drives)
    # PhysX applies forces at the start of a step, in which links move by up to a milliradian.
    assert at_rest(loaded(scene), forces) == pytest.approx(expected, abs=1.5e-3)


def momentum(hand: Any) -> tuple[float, float]:
    """Angular momentum about y at the world's origin, and kinetic energy."""
    found = np.zeros(2)
    for link in hand.links:
        pose = link.entity_pose * link.cmass_local_pose
        turn, spin, speed = pose.to_transformation_matrix()[:3, :3], link.angular_velocity, link.linear_velocity
        inertia = turn @ np.diag(link.inertia) @ turn.T
        found[0] += (inertia @ spin + link.mass * np.cross(pose.p, speed))[1]
        found[1] += 0.5 * (spin @ inertia @ spin + link.mass * speed @ speed)
    return float(found[0]), float(found[1])


@pytest.mark.parametrize("timestep", [0.01, 0.002])
def test_a_free_hand_keeps_momentum_and_energy(timestep: float) -> None:
    keys = "mimic: {joint: j0, multiplier: 0.5}"
    batch = loaded(finger(["", keys], timestep=timestep, free=True))
    hand = batch.articulations["hand"].objs[0]
    hand.set_qvel(np.array([1.0, 0.5], np.float32))
    batch.step()
    before = momentum(hand)
    batch.step(round(5 / timestep) - 1)
    after = momentum(hand)
    assert after[0] == pytest.approx(before[0], rel=0.002)
    assert after[1] == pytest.approx(before[1], rel=0.02)
    assert hand.qpos[1] == pytest.approx(0.5 * hand.qpos[0], abs=1e-3)


def test_a_finger_hangs_as_in_mujoco(tmp_path: Path) -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    from fidelity.test_export_mjcf import compiled

    keys = "mimic: {joint: j0, multiplier: 0.7, offset: 0.1}"
    scene = finger(["", keys], timestep=0.002, gravity="0, 0, -9.81", drives="j0: {stiffness: 10, damping: 1}")
    model, data, _ = compiled(io.StringIO(scene), tmp_path)
    mujoco.mj_step(model, data, 2000)
    source, joint = at_rest(loaded(scene), [0, 0])
    assert source == pytest.approx(data.qpos[0], abs=1e-3)
    # MuJoCo's equality is the softer one.
    assert abs(joint - 0.7 * source - 0.1) < 1e-3 < abs(data.qpos[1] - 0.7 * data.qpos[0] - 0.1)


@pytest.mark.parametrize(
    ("joints", "free", "exact"),
    [
        (["", "mimic: {joint: j0}"], True, True),
        (["", "", "mimic: {joint: j1}"], False, True),
        (["", "axis: [0, -1, 0], mimic: {joint: j0}"], True, False),
        (["", "axis: [0, -1, 0], mimic: {joint: j0}"], False, True),
        (["", "axis: [1, 0, 0], mimic: {joint: j0}"], False, True),
        (["", "axis: [1, 0, 0]", "mimic: {joint: j0}"], False, False),
        (["", "axis: [1, 0, 0]", "axis: [1, 0, 0], mimic: {joint: j1}"], True, True),
        (["", "type: prismatic, mimic: {joint: j0}"], False, False),
        (["type: prismatic", "type: prismatic, mimic: {joint: j0}"], False, True),
        (["type: prismatic", "type: prismatic, mimic: {joint: j0}"], True, False),
    ],
)
def test_an_inexact_coupling_is_a_warning(joints: list[str], free: bool, exact: bool) -> None:
    found = {diagnostic.code for diagnostic in validate(io.StringIO(finger(joints, free=free)))}
    assert ("SC578" not in found) == exact


GRIPPER = """
scenecc: 1
physics: {timestep: TIMESTEP}
entities:
  gripper:
    pose: [0, 0, 1]
    fix_root_link: true
    disable_self_collisions: true
    root:
      name: palm
      shapes: [{type: box, half_size: [0.03, 0.03, 0.03]}]
      children:
        - name: left_knuckle
          joint: {name: left, type: revolute, axis: [0, 1, 0], limits: [0, 0.8], origin: {p: [0, 0, -0.03]}}
          shapes: [{type: box, half_size: [0.01, 0.01, 0.02], pose: [0, 0, -0.02], density: 2000}]
          children:
            - name: left_pad
              joint:
                {name: left_inner, type: revolute, axis: [0, 1, 0], origin: {p: [0, 0, -0.05]},
                 mimic: {joint: left, multiplier: -1}}
              shapes: [{type: box, half_size: [0.006, 0.01, 0.02], pose: [0, 0, -0.02], density: 1500}]
        - name: right_knuckle
          joint:
            {name: right, type: revolute, axis: [0, -1, 0], origin: {p: [0.08, 0, -0.03]}, mimic: {joint: left}}
          shapes: [{type: box, half_size: [0.01, 0.01, 0.02], pose: [0, 0, -0.02], density: 2000}]
          children:
            - name: right_pad
              joint:
                {name: right_inner, type: revolute, axis: [0, -1, 0], origin: {p: [0, 0, -0.05]},
                 mimic: {joint: left, multiplier: -1}}
              shapes: [{type: box, half_size: [0.006, 0.01, 0.02], pose: [0, 0, -0.02], density: 1500}]
    joints: {'.*': {friction: 0}}
    drives: {left: {stiffness: 10, damping: 0.3, target: 0.4}}
"""


@pytest.mark.parametrize("timestep", [0.01, 0.002])
def test_a_gripper_of_five_bars_closes(timestep: float) -> None:
    """Its pads stay parallel, though the right one follows a joint on the other side."""
    batch = loaded(GRIPPER.replace("TIMESTEP", str(timestep)))
    batch.step(round(2 / timestep))
    gripper = batch.articulations["gripper"]
    found = dict(zip(gripper.active_joint_names, gripper.qpos[0].tolist(), strict=True))
    # MuJoCo has the left joint at 0.399, where the drive carries the weight of the links.
    expected = {"left": 0.399, "right": 0.399, "left_inner": -0.399, "right_inner": -0.399}
    assert found == pytest.approx(expected, abs=5e-4)
    assert abs(gripper.qvel).max() < 0.3


HANDS = {
    "inspire": "inspire_hand/RH56DFX-2LR/urdf/inspire_hand_left.urdf",
    "ability": "ability_hand/ability_hand_left.urdf",
}


@pytest.mark.maniskill
@pytest.mark.parametrize("name", HANDS)
@pytest.mark.parametrize("timestep", [0.01, 0.002])
@pytest.mark.parametrize("drives", ["", "'.*(index|ring)_(MCP_joint|q1)': {stiffness: 1, damping: 0.05, target: -0.4}"])
def test_hands_of_maniskill_stay_whole(name: str, timestep: float, drives: str) -> None:
    batch = load_scene(
        io.StringIO(
            f"{{scenecc: 1, physics: {{timestep: {timestep}}}, entities: {{hand: {{"
            f"urdf: 'pkg://mani_skill/assets/robots/{HANDS[name]}', pose: [0, 0, 1],"
            f" disable_self_collisions: true, drives: {{{drives}}}}}}}}}"
        ),
        render=False,
    )
    hand = batch.articulations["hand"]
    batch.step(round(5 / timestep))
    place = dict(zip(hand.active_joint_names, hand.qpos[0].tolist(), strict=True))
    assert abs(hand.qvel).max() < 5
    structure = batch.plan.entities[0].structures[0]
    assert isinstance(structure, ArticulationStructure)
    for mimic in structure.mimics:
        expected = float(mimic.multiplier.row(0)) * place[mimic.source] + float(mimic.offset.row(0))
        assert place[mimic.joint] == pytest.approx(expected, abs=0.02)
