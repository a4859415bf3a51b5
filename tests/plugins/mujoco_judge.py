"""MuJoCo as the judge of what is built of its files."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.testing import assert_allclose

FREE, BALL = 0, 1

_LENGTH, _WEIGHT = 1e-5, 1e-3
"""Greatest errors: of positions over the extent of the model, and of masses and moments."""


def number_of(mujoco: Any, model: Any, kind: str, name: str) -> int:
    """The number of a body or joint by the name that scenecc gives it; -1: it is none of the model's."""
    found = mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), name)
    unnamed = re.fullmatch(r"body_(\d+)", name)
    return int(unnamed[1]) if found < 0 and unnamed else found


def joint_of(mujoco: Any, model: Any, engine: Any) -> int:
    """The number of the joint that an engine's joint is."""
    found = number_of(mujoco, model, "JOINT", engine.name) if engine.name else -1
    if found < 0 and engine.name[-2:] in {"_x", "_y", "_z"}:
        found = number_of(mujoco, model, "JOINT", engine.name[:-2])
    if found >= 0:
        return found
    link = engine.child_link.name
    between = re.fullmatch(r"(.*)_dummy_(\d+)", link)
    body = number_of(mujoco, model, "BODY", between[1] if between else link)
    joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
    return joints[int(between[2])] if between and int(between[2]) < len(joints) else joints[-1]


def assert_same_machine(mujoco: Any, model: Any, batch: Any, seed: int = 0) -> None:
    """Compares positions of a random pose, limits, masses, moments and the number of colliding geoms."""
    rng, data = np.random.default_rng(seed), mujoco.MjData(model)
    for joint in range(model.njnt):
        address = model.jnt_qposadr[joint]
        if model.jnt_type[joint] > BALL:
            low, high = model.jnt_range[joint] if model.jnt_limited[joint] else model.qpos0[address] + np.array([-1, 1])
            data.qpos[address] = rng.uniform(low, high)
    mujoco.mj_kinematics(model, data)
    for held in batch.articulations.values():
        articulation = held.objs[0]
        articulation.qpos = np.array([_position(mujoco, model, data, one) for one in articulation.active_joints])
        for one in articulation.active_joints:
            _assert_limits(mujoco, model, one)
        for link in articulation.links:
            body = number_of(mujoco, model, "BODY", link.name)
            if body > 0:
                _assert_body(model, data, body, link, link.entity_pose.p)
    for name, held in batch.entities.items():
        body = number_of(mujoco, model, "BODY", name.rpartition("/")[2])
        component: Any = held.objs[0].components[-1] if hasattr(held.objs[0], "components") else None
        # What nothing moves weighs what it likes.
        if body > 0 and hasattr(component, "mass") and not component.kinematic:
            _assert_body(model, data, body, component, held.objs[0].pose.p)


def moving_bodies(model: Any) -> set[int]:
    """The bodies that joints connect with the world."""
    mocap = model.body_mocapid[model.body_weldid] >= 0
    return set(np.flatnonzero((model.body_weldid != 0) & ~mocap).tolist())


def _position(mujoco: Any, model: Any, data: Any, engine: Any) -> float:
    joint = joint_of(mujoco, model, engine)
    if model.jnt_type[joint] == BALL:
        return 0.0
    address = model.jnt_qposadr[joint]
    return float(data.qpos[address] - model.qpos0[address])


def _assert_limits(mujoco: Any, model: Any, engine: Any) -> None:
    joint = joint_of(mujoco, model, engine)
    if model.jnt_limited[joint] and model.jnt_type[joint] != BALL:
        wanted = model.jnt_range[joint] - model.qpos0[model.jnt_qposadr[joint]]
        assert_allclose(engine.limits[0], wanted, rtol=1e-6, atol=1e-6, err_msg=engine.name)


def _assert_body(model: Any, data: Any, body: int, component: Any, place: Any) -> None:
    name = component.name
    # PhysX computes in float32.
    atol = _LENGTH * max(model.stat.extent, 1e-3) + 1e-6 * np.abs(data.xpos).max()
    assert_allclose(place, data.xpos[body], rtol=0, atol=atol, err_msg=name)
    geoms = np.flatnonzero(model.geom_bodyid == body)
    collides = (model.geom_contype[geoms] | model.geom_conaffinity[geoms]) != 0
    assert len(component.collision_shapes) == collides.sum(), name
    if model.body_mass[body]:
        centre = component.cmass_local_pose.p
        assert_allclose(centre, model.body_ipos[body], rtol=0, atol=_LENGTH * max(model.stat.extent, 1), err_msg=name)
        assert_allclose(component.mass, model.body_mass[body], rtol=_WEIGHT, err_msg=name)
        has = model.body_inertia[body] > 0  # PhysX cannot represent a moment of 0, which is told (SC580)
        assert_allclose(component.inertia[has], model.body_inertia[body][has], rtol=_WEIGHT, err_msg=name)
