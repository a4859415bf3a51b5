"""Where joints start: mimics, limits, and what varies from scene to scene."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from plugins.expectations import GOOD

from scenecc import compile_scene, emit_scene, load_scene, validate
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan, Value


BOX = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]
DRAWN = {"uniform": [0.5, 1]}
NARROW = {"per_scene": [[0.01, 0.1], [0.02, 0.2], [0.03, 2]]}
"""Limits."""


def mimic_scene(qpos: Any, *joints: dict[str, Any]) -> dict[str, Any]:
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
    plan = compile_scene(mimic_scene(qpos, *joints))
    at, limits = rows(plan, "qpos"), rows(plan, "limits")
    assert all(start is not None and start.all() for start in at)
    for number, mimic in enumerate(structure(plan).mimics, 1):
        moved = mimic.multiplier.data * at[number - 1] + mimic.offset.data
        assert np.array_equal(at[number], np.clip(moved, limits[number][:, 0], limits[number][:, 1]))
    assert compile_scene(emit_scene(plan, "json")) == plan


@pytest.mark.parametrize(("qpos", "joints"), CASES)
def test_and_again_at_every_reset(qpos: Any, joints: tuple[dict[str, Any], ...]) -> None:
    """A reset by a seed gives what a batch that is built with that seed starts with, as far as it is drawn anew."""
    with load_scene(mimic_scene(qpos, *joints), render=False) as batch:
        arm = batch.articulations["arm"]
        built = arm.qpos
        batch.reset(seed=0)
        assert np.array_equal(arm.qpos, built)
        batch.reset(seed=5)
        later, mimics, limits = arm.qpos, structure(batch.plan).mimics, arm.qlimits
        drawn = qpos is DRAWN or "uniform" in joints[0].get("limits", {})
        assert drawn != np.array_equal(later, built)
        for number, mimic in enumerate(mimics, 1):
            moved = mimic.multiplier.data * later[:, number - 1] + mimic.offset.data
            held = np.clip(moved, limits[:, number, 0], limits[:, number, 1])
            assert np.allclose(later[:, number], held, rtol=0, atol=2e-7)


BALL = [{"type": "sphere", "radius": 0.1}]


def leg(name: str) -> dict[str, Any]:
    return {"name": name, "joint": {"name": f"to_{name}", "type": "revolute", "limits": [0.5, 1]}, "shapes": BALL}


def test_several_joints_that_start_at_a_limit_are_one_warning() -> None:
    entities = {
        "spider": {"root": {"name": "base", "shapes": BALL, "children": [leg("a"), leg("b"), leg("c")]}},
        "crab": {"root": {"name": "base", "shapes": BALL, "children": [leg("a"), leg("b")]}, "qpos": {"to_a": 0.6}},
    }
    found = validate({"scenecc": 1, "entities": entities})
    starts = "starts at its limit 0.5, because 0 is outside the limits"
    assert [(one.code, one.path, one.message) for one in found] == [
        ("SC518", "entities.spider", f"`to_a` {starts} (and 2 others like it)"),
        ("SC518", "entities.crab.qpos", f"`to_b` {starts}"),
    ]


def scene(joint: dict[str, Any], **keys: Any) -> dict[str, Any]:
    panel = {"name": "panel", "joint": {"name": "hinge", "type": "revolute", **joint}, "shapes": BOX}
    door = {"root": {"name": "frame", "shapes": BOX, "children": [panel]}, **keys}
    return {"scenecc": 1, "num_scenes": 3, "entities": {"door": door}}


@pytest.mark.parametrize("qpos", [{}, {"qpos": {"hinge": {"uniform": [2, 2]}}}, {"qpos": {"choice": [[2], [2]]}}])
def test_limits_that_are_drawn_alike(qpos: dict[str, Any]) -> None:
    plan = compile_scene(scene({"limits": {"choice": [[0.5, 1]]}}, **qpos))
    joint = structure(plan).links[1].joint
    assert joint is not None
    assert joint.qpos is not None
    assert joint.qpos.data.tolist() == [1.0 if qpos else 0.5]
    assert compile_scene(emit_scene(plan, "json")) == plan


def test_a_mass_that_is_drawn_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """The file says 1.5 kg and 0.02, 0.02, 0.002 kg·m²."""
    monkeypatch.chdir(GOOD)
    arm = {"urdf": "articulations/arm.urdf", "links": {"upper": {"mass": {"choice": [3]}}}}
    plan = compile_scene({"scenecc": 1, "num_scenes": 3, "entities": {"arm": arm}})
    upper = next(link for link in structure(plan).links if link.name == "upper")
    assert upper.body.inertial is not None
    assert upper.body.inertial.inertia.data.tolist() == [[0.04, 0.04, 0.004]]


def test_an_inertia_is_known_as_far_as_the_mass_that_scales_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(GOOD)
    arm = {"urdf": "articulations/arm.urdf", "links": {"upper": {"mass": {"uniform": [3, 6]}}}}
    plan = compile_scene({"scenecc": 1, "num_scenes": 3, "entities": {"arm": arm}})
    upper = next(link for link in structure(plan).links if link.name == "upper")
    assert upper.body.inertial is not None
    found = upper.body.inertial.inertia.bounds
    assert not found.exact
    assert found.low == pytest.approx((0.04, 0.04, 0.004), rel=0.01)
    assert found.high == pytest.approx((0.08, 0.08, 0.008), rel=0.01)


def test_a_robots_velocity_target_is_drawn_anew_at_a_reset(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(GOOD)
    drive = {"damping": 1, "velocity_target": {"uniform": [0, 1]}}
    arm = {"urdf": "articulations/arm.urdf", "drives": {"elbow": drive}}
    plan = compile_scene({"scenecc": 1, "num_scenes": 3, "entities": {"arm": arm}})
    (elbow,) = [link.joint for link in structure(plan).links if link.joint is not None and link.joint.name == "elbow"]
    assert elbow.drive_velocity_target is not None
    assert elbow.drive_velocity_target.recipe is not None


@pytest.mark.parametrize("key", ["qpos", "qvel"])
def test_alternatives_of_positions_come_back_from_json(key: str) -> None:
    plan = compile_scene(scene({}, **{key: {"choice": [[0.1], [0.2]]}}))
    assert compile_scene(emit_scene(plan, "json")) == plan


def test_a_mass_of_which_nothing_is_known_before_it_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(GOOD)
    arm = {"urdf": "articulations/arm.urdf", "links": {"upper": {"mass": "${pair[round(pair[0]) - 1]}"}}}
    draws = {"pair": {"uniform": [[1, 1], [2, 3]]}}
    plan = compile_scene({"scenecc": 1, "num_scenes": 3, "draws": draws, "entities": {"arm": arm}})
    upper = next(link for link in structure(plan).links if link.name == "upper")
    assert upper.body.inertial is not None
    mass, inertia = upper.body.inertial.mass.data, upper.body.inertial.inertia.data
    assert len(set(mass.tolist())) == 3
    assert inertia == pytest.approx(mass[:, None] / 1.5 * [0.02, 0.02, 0.002])
