"""Runs in the compiler process: which bodies MuJoCo lets collide with their parent, and can touch it.

MuJoCo has no contacts between a body and its parent, except if the parent is fixed to the world, or with
`<flag filterparent="disable"/>`. PhysX has none between a link and its parent.
"""

from __future__ import annotations

import math
from typing import Any

_WORLD = 0
_HFIELD, _SDF = 1, 8
"""`mjtGeom` without distances."""

_SLIDE, _HINGE = 2, 3
"""`mjtJoint`."""

_APART = 1e-4
"""Least distance at the start of shapes that may collide [m]. Adjacent links often overlap, and would jam."""

_STEPS = 256
"""Largest number of positions of a joint that are tried."""

_WORK, _WORK_PER_PAIR = 2_000_000, 20
"""Limit of the work for a file, and that of a distance; the pose of a body is 1."""


def touching_bodies(mujoco: Any, model: Any, data: Any) -> list[list[int]]:
    """Returns [body, 1] for bodies that are apart from their parent, and touch it somewhere in their joint's range.

    [body, 0]: other shapes of the two overlap at the start, so that no contacts can be built.

    Args:
        mujoco: the package.
        model: the compiled model.
        data: at the start; it is the same afterwards.
    """
    excluded = {(int(each) >> 16, int(each) & 0xFFFF) for each in model.exclude_signature}
    filters = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    found: list[list[int]] = []
    work = _WORK
    for body in range(1, model.nbody):
        parent, joint = int(model.body_parentid[body]), int(model.body_jntadr[body])
        if parent == _WORLD or model.body_jntnum[body] != 1 or int(model.jnt_type[joint]) not in {_SLIDE, _HINGE}:
            continue
        if (filters and model.body_weldid[parent] != _WORLD) or {(parent, body), (body, parent)} & excluded:
            continue
        pairs = [(a, b) for a in _geoms(model, parent) for b in _geoms(model, body) if _collide(model, a, b)]
        work -= _STEPS * (model.nbody + _WORK_PER_PAIR * len(pairs)) if pairs else 0
        if not pairs or work < 0:
            continue
        apart = [pair for pair in pairs if _distance(mujoco, model, data, [pair]) > _APART]
        if apart and _touch(mujoco, model, data, joint, apart):
            found.append([body, int(len(apart) == len(pairs))])
    return found


def _geoms(model: Any, body: int) -> list[int]:
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    return [each for each in range(first, first + count) if int(model.geom_type[each]) not in {_HFIELD, _SDF}]


def _collide(model: Any, a: int, b: int) -> bool:
    types, affinities = model.geom_contype, model.geom_conaffinity
    return bool(types[a] & affinities[b] or types[b] & affinities[a])


def _distance(mujoco: Any, model: Any, data: Any, pairs: list[tuple[int, int]]) -> float:
    """Returns the least distance of the pairs [m]."""
    far = 10 * float(model.stat.extent)
    return min(float(mujoco.mj_geomDistance(model, data, a, b, far, None)) for a, b in pairs)


def _touch(mujoco: Any, model: Any, data: Any, joint: int, pairs: list[tuple[int, int]]) -> bool:
    """Returns whether any pair touches somewhere in the range of a joint, by conservative advancement."""
    turns = int(model.jnt_type[joint]) == _HINGE
    reach = math.pi if turns else 2 * float(model.stat.extent)
    place = model.jnt_qposadr[joint]
    start = float(data.qpos[place])
    low, high = model.jnt_range[joint] if model.jnt_limited[joint] else (start - reach, start + reach)
    lever = 1.0
    if turns:
        anchor = data.xanchor[joint]
        lever = max(float(math.dist(data.geom_xpos[b], anchor)) + float(model.geom_rbound[b]) for _, b in pairs)
    position, touches = float(low), False
    while position <= high and not touches:
        data.qpos[place] = position
        mujoco.mj_kinematics(model, data)
        gap = _distance(mujoco, model, data, pairs)
        touches = gap <= 0
        position += max(gap / max(lever, 1e-9), float(high - low) / _STEPS, 1e-9)
    data.qpos[place] = start
    mujoco.mj_kinematics(model, data)
    return touches
