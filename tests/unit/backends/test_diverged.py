"""Simulations that diverge, as PhysX really lets them: `step(check=True)` says who, where and by which step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import scenecc

BOX = {"shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.05]}]}


def arm(count: int, **keys: Any) -> dict[str, Any]:
    """A chain of links on hinges."""
    link: dict[str, Any] = {}
    for number in range(count, 0, -1):
        hinge = {"name": f"hinge_{number}", "type": "revolute", "origin": [0.2, 0, 0], "axis": "y"}
        below = {"children": [link]} if link else {}
        link = {"name": f"link_{number}", "joint": hinge, **BOX, **below}
    return {"root": {"name": "base", **BOX, "children": [link]}, "disable_self_collisions": True, **keys}


def scene(num_scenes: int = 1, physics: dict[str, Any] | None = None, **entities: Any) -> scenecc.SceneBatch:
    source = {"scenecc": 1, "num_scenes": num_scenes, "physics": physics or {}, "entities": entities}
    return scenecc.load_scene(source, render=False)


def told(batch: scenecc.SceneBatch, steps: int) -> scenecc.Diagnostic:
    with pytest.raises(scenecc.SceneError) as caught:
        batch.step(steps, check=True)
    assert caught.value.at_fault == "scene"
    (found,) = caught.value.diagnostics
    assert (found.code, found.severity) == ("SC820", "error")
    return found


FAST_WHEELS = {
    "fix_root_link": True,
    "joints": {".*": {"max_velocity": 1e30}},
    "drives": {".*": {"stiffness": 0, "damping": 1e30, "velocity_target": 1e30}},
}
UNLIKE_MASSES = {"links": {"base": {"mass": 1e-9}, "link_5": {"mass": 1e9}}}


def test_a_robot_diverges_even_if_its_root_stays() -> None:
    with scene(arm=arm(5, **FAST_WHEELS)) as batch:
        assert told(batch, 1).message == "link `link_1` of `arm` is not finite in scene 0 by step 1"
        assert np.isfinite(batch.articulations["arm"].pose).all(), "its root alone is where it was"
        assert told(batch, 0).path == "entities.arm"


def test_a_robot_with_too_different_masses_diverges() -> None:
    with scene(physics={"timestep": 0.1}, arm=arm(5, **UNLIKE_MASSES)) as batch:
        assert told(batch, 100).message == "link `base` of `arm` is not finite in scene 0 by step 10"


def test_mimics_that_physx_couples_inexactly_are_named() -> None:
    robot: Any = arm(2, **{**FAST_WHEELS, "fix_root_link": False})
    (first,) = robot["root"]["children"]
    first["children"][0]["joint"] |= {"axis": "x", "mimic": {"joint": "hinge_1"}}
    with scene(arm=robot) as batch:
        found = told(batch, 1)
    assert found.message.endswith("; PhysX couples `hinge_2` (source `hinge_1`) inexactly (SC578)")
    assert found.hint == "remove `mimic`, and drive both joints"


def test_a_joint_that_turns_too_fast_is_reported_at_its_link() -> None:
    with scene(arm=arm(2, fix_root_link=True)) as batch:
        joints = batch.articulations["arm"]
        joints.set_qvel([0, 2e6])
        assert (
            told(batch, 0).message == "link `link_2` of `arm` is beyond 1e6 m, m/s, rad or rad/s in scene 0 by step 0"
        )


@pytest.mark.parametrize("what", ["linear_velocity", "angular_velocity"])
def test_a_body_that_is_too_fast_has_diverged(what: str) -> None:
    with scene(cube={**BOX, "max_angular_velocity": 1e9, what: [0, 2e6, 0]}) as batch:
        assert told(batch, 0).message == "`cube` is beyond 1e6 m, m/s, rad or rad/s in scene 0 by step 0"


def test_a_body_that_fell_too_far_has_diverged() -> None:
    with scene(physics={"gravity": [0, 0, -2e5], "timestep": 1}, cube=BOX) as batch:
        batch.step(2, check=True)
        told(batch, 1)
        assert batch.entities["cube"].linear_velocity[0, 2] > -1e6, "it is its place that is beyond"


def test_divergence_is_reported_for_the_first_scene_with_a_count_of_others() -> None:
    speeds = {"per_scene": [[0, 0, 0], [0, 0, 0], [2e6, 0, 0], [0, 0, 0], [3e6, 0, 0]]}
    with scene(5, still=BOX, cube={**BOX, "pose": [0, 1, 0], "linear_velocity": speeds}) as batch:
        found = told(batch, 25)
        assert "`cube`" in found.message
        assert found.message.endswith("in scene 2 by step 10, and others are in 1 more scene")
        batch.reset(scene_idxs=[2])
        batch.remove("cube")
        batch.step(25, check=True)
        batch.add("cube")
        assert "in scene 2 by step 35, and" in told(batch, 10).message


def test_steps_until_divergence_are_counted_from_the_last_reset() -> None:
    with scene(arm=arm(5, **FAST_WHEELS)) as batch:
        for exact in (False, True):
            assert told(batch, 30).message.endswith("by step 10"), "it stops there"
            batch.reset(exact=exact)
            batch.step(0, check=True)
        batch.step(2)
        assert told(batch, 1).message.endswith("by step 3")


def test_divergence_is_only_checked_on_request() -> None:
    with scene(physics={"gravity": [0, 0, -1e6], "timestep": 1}, cube=BOX) as batch:
        batch.step(20)
        assert batch.entities["cube"].pose[0, 2] < -1e6


def test_static_and_kinematic_bodies_may_be_anywhere() -> None:
    far = {**BOX, "pose": [0, 0, 2e6]}
    with scene(post={**far, "body_type": "static"}, lift={**far, "body_type": "kinematic"}) as batch:
        batch.step(5, check=True)


def test_the_divergence_check_changes_no_bit() -> None:
    falling = {**BOX, "pose": [0, 0, 0.2], "angular_velocity": [1, 2, 3]}
    floor = {"body_type": "static", "shapes": [{"type": "plane"}]}
    entities = {"floor": floor, "cube": falling, "arm": arm(3, pose=[1, 0, 0.3])}
    with scene(2, **entities) as looked, scene(2, **entities) as bare:
        looked.step(137, check=True)
        bare.step(137)
        assert looked.state() == bare.state()
