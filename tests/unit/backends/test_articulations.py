"""Articulations of a batch as a user handles them, what the backend refuses, and what the audit notices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fidelity.hand import box_shape
from fidelity.hand_articulations import Case, plan_of, with_body, with_joint
from plugins.plan_parts import pose as posed
from unit.backends.test_audit import audited
from unit.backends.test_audit import complaints as audit_complaints

from scenecc import ArticulationBatch
from scenecc.backends.sapien import SceneBatch, build, instantiate
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import (
    ArticulationStructure,
    BodyStructure,
    CollisionShape,
    ConvexMesh,
    Entity,
    Joint,
    Link,
    Mimic,
    Physics,
    ScenePlan,
    constant,
    per_scene,
)
from scenecc.plan.body import AssetFile

ROOT = Origin("scene.yaml")


KEPT: list[Any] = []
"""Batches whose articulations tests look at: the scenes of one that nobody holds go with it."""


def built(plan: ScenePlan, **options: Any) -> SceneBatch:
    sink = Sink()
    batch = instantiate(plan, sink, **{"render": False, **options})
    assert batch is not None, sink.diagnostics()
    KEPT.append(batch)
    return batch


def complaints(plan: ScenePlan, **options: Any) -> list[Diagnostic]:
    sink = Sink()
    assert instantiate(plan, sink, **{"render": False, **options}) is None
    return sink.diagnostics()


@pytest.fixture
def arm() -> ArticulationBatch:
    return built(plan_of(Case())).articulations["arm"]


def alone(structure: ArticulationStructure, *others: ArticulationStructure, **tables: Any) -> ScenePlan:
    """One articulation in three scenes; with several structures, one a scene."""
    structures = (structure, *others)
    pick = per_scene([n % len(structures) for n in range(3)], np.int64) if others else None
    entity = Entity("robot", (0, 1, 2), constant([0, 0, 1, 1, 0, 0, 0]), structures, pick)
    return ScenePlan("plan", 3, (entity,), Physics(), **tables)


def chain(count: int, **root: Any) -> ArticulationStructure:
    links = [Link("l0", BodyStructure("link", (box_shape(0.02, 0.02, 0.02),)))]
    for n in range(1, count):
        joint = Joint("revolute", f"j{n}", posed(0.05, 0, 0), limits=constant([-1.0, 1.0]))
        links.append(Link(f"l{n}", BodyStructure("link", (box_shape(0.02, 0.02, 0.02),)), n - 1, joint))
    return ArticulationStructure(tuple(links), **root)


def test_an_articulation_batch_has_its_names_links_and_joints(arm: ArticulationBatch) -> None:
    assert (len(arm), arm.name, arm.scene_idxs, arm.dof) == (3, "arm", (0, 1, 2), 4)
    assert repr(arm) == "ArticulationBatch('arm', dof=4, scene_idxs=[0, 1, 2])"
    assert {obj.name for obj in arm.objs} == {"arm"}
    assert list(arm.links) == ["base", "upper", "lower", "tool", "tip", "flap"]
    assert list(arm.joints) == ["shoulder", "slide", "mount", "elbow", "side"]
    assert [link.name for link in arm.links["tip"]] == ["tip"] * 3
    assert [joint.type for joint in arm.joints["slide"]] == ["prismatic"] * 3
    # Level after level: the flap hangs on the base, and the elbow three links further.
    assert arm.active_joint_names == ("shoulder", "side", "slide", "elbow")
    assert arm.qlimits.shape == (3, 4, 2)
    limits = [[-1.5, 1.5], [-np.inf, np.inf], [-0.2, 0.2], [-2, 2]]
    assert np.array_equal(arm.qlimits[0], np.array(limits, np.float32))
    assert np.array_equal(arm.qpos[0], np.array([0.1, 0.2, 0.05, -0.3], np.float32))
    assert [each.qpos.tolist() for each in arm.objs] == arm.qpos.tolist()


@pytest.mark.parametrize("name", ["qpos", "qvel", "qf", "drive_target", "drive_velocity_target"])
def test_numbers_of_joints_are_set_and_read(arm: ArticulationBatch, name: str) -> None:
    before = getattr(arm, name)
    numbers = np.array([[0.1, 0.2, 0.15, 0.4], [0.5, 0.6, 0.17, 0.8], [1, -1, 0, 0.1]], np.float32)
    setattr(arm, name, numbers)
    assert getattr(arm, name).tolist() == numbers.tolist()
    getattr(arm, f"set_{name}")(before[0], [2])
    assert getattr(arm, name).tolist() == [*numbers[:2].tolist(), before[0].tolist()]
    getattr(arm, f"set_{name}")([numbers[2], numbers[1]], scene_idxs=[1, 0])
    assert getattr(arm, name)[:2].tolist() == [numbers[1].tolist(), numbers[2].tolist()]
    setattr(arm, name, [0.0] * 4)
    assert not getattr(arm, name).any()
    for wrong in ([0.0] * 3, np.zeros((2, 4)), 0.0, np.zeros((3, 4, 1))):
        with pytest.raises(ValueError, match=rf"{name} must be \(4,\) or \(3, 4\)"):
            setattr(arm, name, wrong)
    with pytest.raises(ValueError, match=f"{name} must be finite"):
        setattr(arm, name, [0, 0, np.nan, 0])
    with pytest.raises(KeyError, match="'arm' is not in scene 7"):
        getattr(arm, f"set_{name}")([0.0] * 4, [7])
    assert not getattr(arm, name).any()


def test_a_fixed_root_has_a_pose_but_no_velocity(arm: ArticulationBatch) -> None:
    arm.set_pose([1, 2, 3, 1, 0, 0, 0], [1])
    assert arm.pose[1].tolist() == [1, 2, 3, 1, 0, 0, 0]
    upper: Any = arm.links["upper"][1]
    assert abs(upper.entity.pose.p - [1, 2, 3]).max() < 0.5
    for name in ("linear_velocity", "angular_velocity"):
        with pytest.raises(TypeError, match="the root of 'arm' is fixed"):
            setattr(arm, name, [1, 0, 0])
    free = built(plan_of(Case(fixed=False))).articulations["arm"]
    free.linear_velocity = [1, 2, 3]
    free.set_angular_velocity([[0, 0, 1], [0, 1, 0]], [0, 2])
    assert free.linear_velocity.tolist() == [[1, 2, 3]] * 3
    assert free.angular_velocity.tolist() == [[0, 0, 1], [0, 0, 0], [0, 1, 0]]


SETTERS: dict[str, list[float]] = {
    "qpos": [0.1, 0.2, 0.15, 0.4],
    "qvel": [0.5, 0.6, 0.17, 0.8],
    "qf": [1, -1, 0, 0.5],
    "drive_target": [0.1, 0.2, 0.15, 0.4],
    "drive_velocity_target": [0.5, 0.6, 0.17, 0.8],
    "pose": [1, 2, 3, 1, 0, 0, 0],
    "linear_velocity": [1, 0, 2],
    "angular_velocity": [0, 1, 2],
}


@pytest.mark.parametrize("name", SETTERS)
def test_an_articulation_removed_from_one_scene_can_be_set_in_the_others(name: str) -> None:
    batch = built(plan_of(Case(fixed=False)))
    arm = batch.articulations["arm"]
    for link in [row[1] for row in arm.links.values()]:
        batch.scenes[1].remove_entity(link.entity)
    numbers = np.array(SETTERS[name], np.float32)
    getattr(arm, f"set_{name}")(numbers, scene_idxs=[2, 0])
    state = batch.state([0, 2]).articulations["arm"]
    assert getattr(state, name).tolist() == [numbers.tolist()] * 2
    if name in {"qpos", "qvel", "qf"}:
        gone = "'arm' is removed in scene 1, so the engine has no values for its joints"
        with pytest.raises(RuntimeError, match=gone):
            getattr(arm, name)
        for asked in (None, [1], [0, 1]):
            with pytest.raises(RuntimeError, match=gone):
                getattr(arm, f"set_{name}")(numbers * 2, asked)
        assert getattr(arm.objs[0], name).tolist() == numbers.tolist()


def test_links_are_at_their_poses_before_the_first_step(arm: ArticulationBatch) -> None:
    before = [link.entity.pose.p.tolist() for link in arm.links["tip"]]
    assert len({*map(tuple, before)}) == 3
    fixed = Joint("fixed", "weld", posed(0.5, 0, 0))
    still = ArticulationStructure((Link("a", BodyStructure("link")), Link("b", BodyStructure("link"), 0, fixed)))
    robot = built(alone(still)).articulations["robot"]
    assert robot.dof == 0
    assert robot.qpos.shape == (3, 0)
    found: Any = robot.links["b"][0]
    assert found.entity.pose.p.tolist() == [0.5, 0, 1]


def test_robots_with_different_joint_counts_are_padded_with_nan() -> None:
    batch = built(alone(chain(4), chain(2)))
    robot = batch.articulations["robot"]
    assert robot.dof == 3
    assert np.isnan(robot.qpos).tolist() == [[False] * 3, [False, True, True], [False] * 3]
    robot.qpos = [[0.1, 0.2, 0.3], [0.4, np.nan, 7], [0.5, 0.6, 0.7]]
    assert robot.objs[1].qpos.tolist() == [np.float32(0.4)]
    assert robot.links["l3"][1] is None
    assert robot.links["l1"][1] is not None
    with pytest.raises(ValueError, match="different joints in different scenes"):
        _ = robot.active_joint_names
    state = batch.state()
    batch.step(20)
    batch.reset()
    assert not robot.qpos[~np.isnan(robot.qpos)].any()
    batch.set_state(state)
    assert batch.state().articulations["robot"].qpos.tobytes() == state.articulations["robot"].qpos.tobytes()


def test_a_closed_articulation_batch_refuses_access() -> None:
    batch = built(plan_of(Case()))
    arm = batch.articulations["arm"]
    batch.close()
    for name in ("qpos", "qf", "objs", "links", "pose", "active_joint_names"):
        with pytest.raises(RuntimeError, match="the scenes of 'arm' are closed"):
            getattr(arm, name)


STATES: dict[str, tuple[Callable[[Any], Any], str]] = {
    "joints": (lambda s: replace(s, qpos=s.qpos[:, :3]), r"qpos of 'arm' must be \(3, 4\), not \(3, 3\)"),
    "not finite": (lambda s: replace(s, qvel=s.qvel * np.nan), "qvel of 'arm' must be finite"),
    "rest": (lambda s: replace(s, asleep=s.asleep[:1]), r"asleep of 'arm' must be \(3,\)"),
    "rotation": (lambda s: replace(s, pose=s.pose * np.float32(2)), "quaternions of 'arm'"),
}


@pytest.mark.parametrize("change", STATES)
def test_a_state_that_does_not_fit_changes_nothing(change: str) -> None:
    batch = built(plan_of(Case()))
    make, message = STATES[change]
    batch.step(3)
    before = batch.state()
    wrong = replace(before, articulations={"arm": make(before.articulations["arm"])})
    with pytest.raises(ValueError, match=message):
        batch.set_state(wrong)
    assert batch.state() == before
    with pytest.raises(ValueError, match="'arm' is a body there, and an articulation here"):
        batch.set_state(replace(before, entities={**before.entities, "arm": before.entities["box"]}, articulations={}))


def test_an_articulation_with_more_than_255_links_is_refused() -> None:
    assert built(alone(chain(255))).articulations["robot"].dof == 254
    found = complaints(alone(chain(256, origin=ROOT.child("entities", "robot"))))
    assert [(d.code, d.message) for d in found] == [
        ("SC808", "an articulation has 256 links; PhysX on the CPU supports at most 255")
    ]
    assert found[0].path == "entities.robot"


REFUSED: dict[str, tuple[ArticulationStructure, str]] = {
    "velocity": (chain(2, fix_root_link=True, linear_velocity=constant([1, 0, 0])), "a fixed root has no"),
    "damping": (
        ArticulationStructure((Link("l", BodyStructure("link", sleep_threshold=constant(1))),)),
        "a link has no sleep_threshold",
    ),
    "mimic": (chain(3, mimics=(Mimic("j1", "j9", constant(1), constant(0)),)), "there is no joint 'j9'"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_unsupported_articulation_fields_are_refused(what: str) -> None:
    structure, message = REFUSED[what]
    (found,) = complaints(alone(structure))
    assert found.code == "SC808"
    assert message in found.message


def test_a_link_mesh_that_cannot_be_cooked_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "words.obj"
    path.write_text("these are words, no mesh\n")
    place = ROOT.child("entities", "robot", "root", "shapes", 0)
    shape = CollisionShape(ConvexMesh(constant(0, int), constant([1, 1, 1])), origin=place)
    structure = chain(2)
    broken = replace(structure.links[1], body=BodyStructure("link", (shape,)))
    plan = alone(replace(structure, links=(structure.links[0], broken)), files=(AssetFile("words.obj", path),))
    (found,) = complaints(plan)
    assert (found.code, found.path) == ("SC801", "entities.robot.root.shapes[0].file")


def link(name: str, scene: int, do: Callable[[Any], object]) -> Callable[[list[Any]], object]:
    return lambda scenes: do(next(e for e in scenes[scene].entities if e.name == name).components[0])


SABOTAGE: dict[str, tuple[Any, str]] = {
    "mass": (link("tip", 2, lambda c: c.set_mass(9.0)), "link 'tip' of 'arm' in scene 2: the engine holds mass = 9"),
    "qpos": (link("base", 1, lambda c: c.articulation.set_qpos([0, 0, 0, 1.0])), "pose"),
    "place": (
        link("base", 2, lambda c: c.entity.set_pose(type(c.entity.pose)([9, 9, 9]))),
        "'base' of 'arm' in scene 2",
    ),
    "frame": (
        link(
            "lower",
            0,
            lambda c: (
                c.joint.set_pose_in_parent(type(c.entity.pose)([1, 0, 0])),
                c.articulation.set_qpos(c.articulation.qpos),
            ),
        ),
        "link 'lower' of 'arm' in scene 0: the engine holds pose",
    ),
}


@pytest.mark.parametrize("what", SABOTAGE)
def test_the_audit_reports_a_manipulated_articulation(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    sabotage, words = SABOTAGE[what]
    found = audited(plan_of(Case()), monkeypatch, sabotage)
    assert any(words in d.message for d in found), [d.message for d in found]


def test_links_and_joints_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """The articulations of two entities are handed out for one another."""
    plan = plan_of(Case())
    arm = plan.entities[1]
    whole = arm.structures[0]
    assert isinstance(whole, ArticulationStructure)
    short = replace(whole, links=whole.links[:-1])
    other = replace(arm, name="other", pose=constant([5, 0, 1, 1, 0, 0, 0]), structures=(short,))
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        fill(scenes, turns, progress)
        turns[1].objs[:], turns[-1].objs[:] = turns[-1].objs[:], turns[1].objs[:]

    monkeypatch.setattr(build, "fill_scenes", filled)
    messages = [d.message for d in audit_complaints(replace(plan, entities=(*plan.entities, other)))]
    for words in ("links = 5, but the plan asks for 6", "dof = 3, but the plan asks for 4"):
        assert f"'arm' in scene 0 (and in 2 more): the engine holds {words}" in messages


def test_solver_iterations_of_the_scene_are_those_of_articulations() -> None:
    physics = Physics(solver_position_iterations=17, solver_velocity_iterations=3, sleep_threshold=0.25)
    arm = built(plan_of(Case(), physics=physics)).articulations["arm"]
    assert {obj.solver_position_iterations for obj in arm.objs} == {17}
    assert {obj.sleep_threshold for obj in arm.objs} == {0.25}


def test_link_masses_and_joint_limits_may_vary_by_scene() -> None:
    change = with_body("tip", mass=per_scene([0.1, 0.2, 0.4]))
    arm = built(plan_of(Case(change))).articulations["arm"]
    assert [float(tip.mass) for tip in arm.links["tip"]] == pytest.approx([0.1, 0.2, 0.4])
    wide = built(plan_of(Case(with_joint("elbow", limits=per_scene([[-1, 1], [-0.9, 0.9], [-0.7, 0.7]])))))
    assert wide.articulations["arm"].qlimits[:, 3, 1].tolist() == np.array([1, 0.9, 0.7], np.float32).tolist()
