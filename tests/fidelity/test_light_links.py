"""Joints of three freedoms as hinges with light links: MuJoCo's ball joints have the same period."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc.diagnostics.diagnostic import Location
from scenecc.geometry.rotations import AXES, IDENTITY, IDENTITY_POSE, Pose7
from scenecc.importers.writer import write_world
from scenecc.robots.description import DescribedInertial, DescribedJoint, DescribedLink, DescribedMotion, DescribedRobot
from scenecc.robots.poses import axis_pose, compose_poses
from scenecc.robots.rules import split_joint
from scenecc.robots.world import DescribedEntity, DescribedPhysics, DescribedWorld

mujoco: Any = pytest.importorskip("mujoco")

pytestmark = pytest.mark.slow

HERE = Location("chain.xml", 1, 1)
LENGTH, TILT, SECONDS, STEP = 0.2, 0.3, 5.0, 0.005
MASS, MOMENTS = 0.3, (1.1e-3, 1.1e-3, 6e-5)


def chain(count: int) -> DescribedRobot:
    """Rods that hang below one another on ball joints, tilted about x."""
    still = DescribedMotion(linear_damping=0.0, angular_damping=0.0)
    links = [DescribedLink("base", HERE, motion=still)]
    for number in range(count):
        hangs: Pose7 = (0.0, 0.0, -LENGTH if number else 0.0, *IDENTITY)
        inertial = DescribedInertial(MASS, (0.0, 0.0, -LENGTH / 2, *IDENTITY), MOMENTS, HERE)
        link = DescribedLink(f"rod_{number}", HERE, len(links) - 1, inertial=inertial, motion=still)
        freedoms = [
            DescribedJoint(
                f"{name}_{number}",
                "revolute",
                compose_poses(hangs if name == "x" else IDENTITY_POSE, axis_pose(axis)),
                axis_pose(axis),
                HERE,
                limits=(-math.inf, math.inf),
                friction=0.0,
                qpos=TILT if (name, number) == ("x", 0) else None,
            )
            for name, axis in AXES.items()
        ]
        links += split_joint(link, freedoms, [f"light_{number}_{k}" for k in range(2)], len(links))
    return DescribedRobot(tuple(links), fixed=True)


def period(places: np.ndarray[Any, Any]) -> float:
    """Mean time between crossings of 0 in one direction [s]. `places`: of each step."""
    at = np.flatnonzero((places[1:] > 0) & (places[:-1] <= 0))
    times = (at + 1 - places[at + 1] / (places[at + 1] - places[at])) * STEP
    return float(np.diff(times).mean())


@pytest.mark.parametrize("count", [1, 5])
def test_a_chain_of_ball_joints_has_mujocos_period(count: int) -> None:
    rods = "".join(
        f'<body pos="0 0 {-LENGTH if number else 0}"><joint type="ball"/><inertial pos="0 0 {-LENGTH / 2}" '
        f'mass="{MASS}" diaginertia="{" ".join(map(str, MOMENTS))}"/>'
        for number in range(count)
    )
    file = f'<mujoco><option timestep="{STEP / 10}"/><worldbody>{rods}{"</body>" * count}</worldbody></mujoco>'
    model = mujoco.MjModel.from_xml_string(file)
    data = mujoco.MjData(model)
    data.qpos[:4] = math.cos(TILT / 2), math.sin(TILT / 2), 0, 0
    wanted, built = [], []
    for _ in range(round(SECONDS / STEP)):
        mujoco.mj_step(model, data, 10)
        wanted.append(data.xpos[-1][1] if count > 1 else data.xipos[-1][1])
    world = DescribedWorld("c", (DescribedEntity("c", chain(count), HERE),), DescribedPhysics(STEP))
    with scenecc.load_scene(write_world(world).document, render=False) as batch:
        robot = batch.articulations["c"].objs[0]
        for _ in range(round(SECONDS / STEP)):
            batch.step()
            pose = robot.links[-1].entity_pose.to_transformation_matrix()
            built.append((pose @ [0, 0, 0 if count > 1 else -LENGTH / 2, 1])[1])
            assert np.abs(robot.qvel).max() < 20
    assert period(np.array(built)) == pytest.approx(period(np.array(wanted)), rel=0.01)
