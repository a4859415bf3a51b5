"""A joint that follows another starts where it follows that one at, whatever differs from scene to scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc import compile_scene, emit_scene, load_scene
from scenecc.plan.articulation import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan, Value

BOX = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]
DRAWN = {"uniform": [0.5, 1]}
NARROW = {"per_scene": [[0.01, 0.1], [0.02, 0.2], [0.03, 2]]}
"""Limits."""


def scene(qpos: Any, *joints: dict[str, Any]) -> dict[str, Any]:
    """Joints `a`, `b` and `c`, each of which but the first follows the one before; `qpos`: of `a`."""
    links: list[dict[str, Any]] = []
    for number, (name, joint) in enumerate(zip("abc", (*joints, {}, {}), strict=False)):
        mimic = {"joint": "abc"[number - 1], **joint.get("mimic", {})}
        keys = {**joint, "mimic": mimic} if number else joint
        links.append({"name": f"link_{name}", "joint": {"name": name, "type": "revolute", **keys}, "shapes": BOX})
    arm: dict[str, Any] = {
        "fix_root_link": True,
        "root": {"name": "base", "shapes": BOX, "children": links},
        **({} if qpos is None else {"qpos": {"a": qpos}}),
    }
    return {"scenecc": 1, "num_scenes": 3, "entities": {"arm": arm}}


def structure(plan: ScenePlan) -> ArticulationStructure:
    (found,) = plan.entities[0].structures
    assert isinstance(found, ArticulationStructure)
    return found


def rows(plan: ScenePlan, name: str) -> Any:
    """Numbers (3, …) of each of the three joints."""
    joints = [link.joint for link in structure(plan).links[1:]]
    values: list[Value | None] = [getattr(joint, name) for joint in joints]
    return [None if value is None else np.broadcast_to(value.data, (3, *value.data.shape[1:])) for value in values]


CASES = [
    pytest.param(DRAWN, ({},), id="what follows one that follows what is drawn"),
    pytest.param(DRAWN, ({"limits": NARROW},), id="drawn within limits that differ"),
    pytest.param({"uniform": [0.5, 0.5]}, ({"limits": NARROW},), id="drawn alike within limits that differ"),
    pytest.param({"per_scene": [0.1, 0.2, 0.3]}, ({},), id="known by scene"),
    pytest.param(DRAWN, ({}, {"mimic": {"multiplier": {"uniform": [1, 2]}, "offset": 0.5}}), id="a factor is drawn"),
    pytest.param(0.4, ({}, {"mimic": {"multiplier": {"per_scene": [1, 2, 3]}}}), id="a factor differs"),
    pytest.param(DRAWN, ({}, {"limits": NARROW}), id="within its own limits, which differ"),
    pytest.param(None, ({"limits": NARROW},), id="what follows one that starts at its limit"),
    pytest.param(None, ({"limits": {"uniform": [[0.1, 1], [0.2, 2]]}},), id="at a limit that is drawn"),
]


@pytest.mark.parametrize(("qpos", "joints"), CASES)
def test_it_starts_where_it_follows(qpos: Any, joints: tuple[dict[str, Any], ...]) -> None:
    plan = compile_scene(scene(qpos, *joints))
    at, limits = rows(plan, "qpos"), rows(plan, "limits")
    assert all(start is not None and start.all() for start in at)
    for number, mimic in enumerate(structure(plan).mimics, 1):
        moved = mimic.multiplier.data * at[number - 1] + mimic.offset.data
        assert np.array_equal(at[number], np.clip(moved, limits[number][:, 0], limits[number][:, 1]))
    assert compile_scene(emit_scene(plan, "json")) == plan


@pytest.mark.parametrize(("qpos", "joints"), CASES)
def test_and_again_at_every_reset(qpos: Any, joints: tuple[dict[str, Any], ...]) -> None:
    """A reset by a seed gives what a batch that is built with that seed starts with, as far as it is drawn anew."""
    with load_scene(scene(qpos, *joints), render=False) as batch:
        arm = batch.articulations["arm"]
        built = arm.qpos
        batch.reset(seed=0)
        assert np.array_equal(arm.qpos, built)
        batch.reset(seed=5)
        later, mimics, limits = arm.qpos, structure(batch.plan).mimics, arm.qlimits
        assert (qpos is not DRAWN) == np.array_equal(later, built)
        for number, mimic in enumerate(mimics, 1):
            moved = mimic.multiplier.data * later[:, number - 1] + mimic.offset.data
            held = np.clip(moved, limits[:, number, 0], limits[:, number, 1])
            assert np.allclose(later[:, number], held, rtol=0, atol=2e-7)
