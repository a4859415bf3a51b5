"""What is drawn takes part in what is computed of it: what is the same in every scene, and what nothing bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from plugins.expectations import GOOD

from scenecc import compile_scene, emit_scene
from scenecc.plan.articulation import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

BOX = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]


def scene(joint: dict[str, Any], **keys: Any) -> dict[str, Any]:
    panel = {"name": "panel", "joint": {"name": "hinge", "type": "revolute", **joint}, "shapes": BOX}
    door = {"root": {"name": "frame", "shapes": BOX, "children": [panel]}, **keys}
    return {"scenecc": 1, "num_scenes": 3, "entities": {"door": door}}


def structure(plan: ScenePlan) -> ArticulationStructure:
    (found,) = plan.entities[0].structures
    assert isinstance(found, ArticulationStructure)
    return found


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
