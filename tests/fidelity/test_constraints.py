"""Constraints from YAML, every type, property by property and 300 steps, against hand-written SAPIEN."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import STEPS, assert_same_scene, assert_same_trajectory
from sapien import Pose, physx

from scenecc import SceneBatch, compile_scene, emit_scene, load_scene

Scene = dict[str, Any]
By = Callable[[sapien.Scene, Any, Any, int], Any]
SCENES = 3
START = [[0.5, 0.0, 1.0], [0.25, 0.5, 1.25], [0.5, -0.25, 0.75]]
"""Where `bob` starts; `post` stands at (0, 0, 1) and does not turn, so that the difference is exact."""


@dataclass(frozen=True)
class Case:
    """A constraint as it is written, and the same by hand: (scene, post, bob, number of the scene) to its component."""

    written: Scene
    by_hand: By
    kind: str = "dynamic"


def apart(number: int) -> Pose:
    """Where bob is, seen from post."""
    x, y, z = START[number]
    return Pose([x, y, z - 1.0])


def locked(drive: Any, *axes: str) -> Any:
    for axis in axes:
        getattr(drive, f"set_limit_{axis}")(0, 0)
    return drive


def weld(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    drive = locked(scene.create_drive(post, apart(number), bob, Pose()), "x", "y", "z", "twist")
    drive.set_drive_property_swing(1e10, 1e4, mode="acceleration")
    return drive


def connection(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    return scene.create_connection(None, Pose([0, 0, 1.5]), bob, Pose([0, 0, 0.25]))


def distance(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    joint = physx.PhysxDistanceJointComponent(bob.components[0])
    joint.parent = post.components[0]
    joint.pose_in_child = Pose([0, 0, 0.1])
    joint.pose_in_parent = Pose()
    bob.add_component(joint)
    joint.set_limit(0.1, [0.4, 0.5, 0.6][number], 20, 1)
    return joint


def gear(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    joint = scene.create_gear(post, Pose(), bob, Pose())
    joint.gear_ratio = [2, -0.5, 3][number]
    return joint


def slider(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    drive = scene.create_drive(post, Pose(), bob, Pose([0.1, 0, 0], [0.5, 0.5, 0.5, 0.5]))
    drive.set_limit_x(-0.5, 0.75, 100, 2)
    drive.set_limit_y(0, 0)
    drive.set_limit_z(float("-inf"), [0.1, 0.2, 0.3][number])
    drive.set_limit_twist(-1, 1)
    drive.set_drive_property_x(50, [1, 2, 3][number], 30, "acceleration")
    drive.set_drive_property_twist(5, 1)
    drive.set_drive_property_swing(7, 2)
    drive.set_drive_target(Pose([0.2, 0, 0]))
    drive.set_drive_velocity_target([0.5, 0, 0], [0, 0.25, 0])
    drive.set_inv_mass_scales(1, 0.5)
    drive.set_inv_inertia_scales(0.25, 1)
    return drive


def turner(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    drive = locked(scene.create_drive(post, apart(number), bob, Pose()), "x", "y", "z")
    drive.set_drive_property_slerp(10, 1)
    drive.set_drive_target(Pose([0, 0, 0], [0.8, 0, 0.6, 0]))
    return drive


def held_but(scene: sapien.Scene, free: str, *ends: Any) -> Any:
    """A drive of which one axis is free, the swing aside."""
    return locked(scene.create_drive(*ends), *(axis for axis in ("x", "y", "z", "twist") if axis != free))


def ball(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    drive = locked(scene.create_drive(post, apart(number), bob, Pose()), "x", "y", "z")
    drive.set_limit_twist(np.deg2rad(-30), np.deg2rad([20, 30, 40][number]))
    drive.set_drive_property_slerp(2, 0.5, mode="acceleration")
    return drive


def hinge_about_z(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    del number
    turned = [0.7071067811865476, 0, -0.7071067811865475, 0]
    drive = held_but(scene, "twist", post, Pose([0.5, 0, 0], turned), bob, Pose([0.1, 0, 0], turned))
    drive.set_limit_twist(-0.5, 1.5)
    drive.set_drive_property_swing(1e10, 1e4, mode="acceleration")
    return drive


def slider_along_a_vector(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    # The shortest rotations of +x to (1, 1, 0), (0, 0, 1) and (0, 3, 0).
    halves = [[np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)], [np.sqrt(0.5), 0, -np.sqrt(0.5), 0]]
    turned = [*halves, [np.sqrt(0.5), 0, 0, np.sqrt(0.5)]][number]
    drive = held_but(scene, "x", post, Pose(apart(number).p, turned), bob, Pose([0, 0, 0], turned))
    drive.set_limit_x(-0.1, 0.1)
    drive.set_drive_property_swing(1e10, 1e4, mode="acceleration")
    return drive


def hinge(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    x, y, z = START[number]
    drive = held_but(scene, "twist", post, Pose([x, y, z - 0.75]), bob, Pose([0, 0, 0.25]))
    drive.set_drive_property_swing(1e10, 1e4, mode="acceleration")
    return drive


def driven_hinge(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    ends = post, Pose([0.5, 0, 0], [0.70710678, 0, 0, 0.70710678]), bob, Pose()
    drive = held_but(scene, "twist", *ends)
    drive.set_limit_twist(np.deg2rad(-90), np.deg2rad([45, 60, 90][number]))
    drive.set_drive_property_twist(50, 5, 40)
    scene.create_drive(*ends).set_drive_property_swing(1e10, 1e4, mode="acceleration")
    drive.set_drive_target(Pose([0, 0, 0], [np.cos(0.3), np.sin(0.3), 0, 0]))
    drive.set_drive_velocity_target([0, 0, 0], [-0.5, 0, 0])
    return drive


def one_way(scene: sapien.Scene, post: Any, bob: Any, number: int) -> Any:
    drive = held_but(scene, "x", post, apart(number), bob, Pose())
    drive.set_limit_x(-0.1, 0.3)
    drive.set_drive_property_x(80, 4, mode="acceleration")
    drive.set_drive_property_swing(1e10, 1e4, mode="acceleration")
    drive.set_drive_target(Pose([[0.1, 0.2, -0.05][number], 0, 0]))
    drive.set_drive_velocity_target([0.25, 0, 0], [0, 0, 0])
    return drive


CASES = {
    "weld": Case({"type": "weld"}, weld),
    "weld to what stands": Case({"type": "weld"}, weld, "static"),
    "connection": Case(
        {"type": "connection", "parent": "world", "pose_in_parent": [0, 0, 1.5], "pose_in_child": [0, 0, 0.25]},
        connection,
    ),
    "distance": Case(
        {
            "type": "distance",
            "limits": [0.1, {"per_scene": [0.4, 0.5, 0.6]}],
            "stiffness": 20,
            "damping": 1,
            "pose_in_parent": [0, 0, 0],
            "pose_in_child": [0, 0, 0.1],
        },
        distance,
    ),
    "gear": Case(
        {"type": "gear", "ratio": {"cycle": [2, -0.5, 3]}, "pose_in_parent": [0, 0, 0], "pose_in_child": [0, 0, 0]},
        gear,
    ),
    "drive": Case(
        {
            "type": "drive",
            "pose_in_parent": [0, 0, 0],
            "pose_in_child": {"p": [0.1, 0, 0], "q": [0.5, 0.5, 0.5, 0.5]},
            "limits": {
                "x": [-0.5, 0.75],
                "y": [0, 0],
                "z": [float("-inf"), {"per_scene": [0.1, 0.2, 0.3]}],
                "twist": [-1, 1],
            },
            "limit_springs": {"x": {"stiffness": 100, "damping": 2}},
            "drive": {
                "x": {
                    "stiffness": 50,
                    "damping": {"per_scene": [1, 2, 3]},
                    "force_limit": 30,
                    "mode": "acceleration",
                },
                "twist": {"stiffness": 5, "damping": 1},
                "swing": {"stiffness": 7, "damping": 2},
            },
            "target": [0.2, 0, 0],
            "velocity_target": {"linear": [0.5, 0, 0], "angular": [0, 0.25, 0]},
            "inv_mass_scales": [1, 0.5],
            "inv_inertia_scales": [0.25, 1],
        },
        slider,
    ),
    "drive about all axes": Case(
        {
            "type": "drive",
            "limits": {"x": [0, 0], "y": [0, 0], "z": [0, 0]},
            "drive": {"slerp": {"stiffness": 10, "damping": 1}},
            "target": {"p": [0, 0, 0], "q": [0.8, 0, 0.6, 0]},
        },
        turner,
    ),
    "ball": Case(
        {
            "type": "ball",
            "limits_deg": [-30, {"per_scene": [20, 30, 40]}],
            "drive": {"stiffness": 2, "damping": 0.5, "mode": "acceleration"},
        },
        ball,
    ),
    "hinge about z": Case(
        {
            "type": "hinge",
            "axis": "z",
            "pose_in_parent": [0.5, 0, 0],
            "pose_in_child": [0.1, 0, 0],
            "limits": [-0.5, 1.5],
        },
        hinge_about_z,
    ),
    "slider along a vector": Case(
        {"type": "slider", "axis": {"per_scene": [[1, 1, 0], "z", [0, 3, 0]]}, "limits": [-0.1, 0.1]},
        slider_along_a_vector,
    ),
    "hinge": Case({"type": "hinge", "pose_in_child": [0, 0, 0.25]}, hinge),
    "hinge that is driven": Case(
        {
            "type": "hinge",
            "pose_in_parent": {"p": [0.5, 0, 0], "rpy_deg": [0, 0, 90]},
            "limits_deg": [-90, {"per_scene": [45, 60, 90]}],
            "drive": {"stiffness": 50, "damping": 5, "force_limit": 40, "target": 0.6, "velocity_target": 0.5},
        },
        driven_hinge,
    ),
    "slider": Case(
        {
            "type": "slider",
            "pose_in_parent": {"per_scene": [[x, y, z - 1] for x, y, z in START]},
            "limits": [-0.1, 0.3],
            "drive": {
                "stiffness": 80,
                "damping": 4,
                "mode": "acceleration",
                "target": {"per_scene": [0.1, 0.2, -0.05]},
                "velocity_target": 0.25,
            },
        },
        one_way,
    ),
}


def file_of(case: Case, **changed: Any) -> Scene:
    return {
        "scenecc": 1,
        "num_scenes": SCENES,
        "entities": {
            "ground": {"body_type": "static", "collisions": [{"type": "plane"}]},
            "post": {
                "body_type": case.kind,
                "pose": [0, 0, 1],
                "collisions": [{"type": "box", "half_size": [0.05, 0.05, 0.2]}],
            },
            "bob": {
                "pose": {"per_scene": START},
                "collisions": [{"type": "box", "half_size": [0.1, 0.05, 0.05]}],
                "angular_velocity": [1, 2, 0],
                **changed,
            },
        },
        "constraints": {"tie": {"parent": "post", "child": "bob", **case.written}},
    }


def by_hand(case: Case) -> list[tuple[sapien.Scene, Any]]:
    """Scenes as somebody would write them, and their constraints."""
    made: list[tuple[sapien.Scene, Any]] = []
    for number in range(SCENES):
        scene = sapien.Scene([physx.PhysxCpuSystem()])
        ground = scene.create_actor_builder()
        # The shortest rotation of SAPIEN's own +x to +z.
        up = Pose([0, 0, 0], [0.7071067811865476, 0, -0.7071067811865475, 0])
        ground.add_plane_collision(up)
        ground.set_physx_body_type("static")
        ground.initial_pose = Pose()
        ground.build(name="ground")
        post = scene.create_actor_builder()
        post.add_box_collision(half_size=(0.05, 0.05, 0.2))
        post.set_physx_body_type(case.kind)
        post.initial_pose = Pose([0, 0, 1])
        bob = scene.create_actor_builder()
        bob.add_box_collision(half_size=(0.1, 0.05, 0.05))
        bob.initial_pose = Pose(START[number])
        bodies = post.build(name="post"), bob.build(name="bob")
        moving = bodies[1].components[0]
        assert isinstance(moving, physx.PhysxRigidDynamicComponent)
        moving.set_angular_velocity([1, 2, 0])
        made.append((scene, case.by_hand(scene, *bodies, number)))
    return made


def ties_of(component: Any) -> list[Any]:
    """All constraints of a scene by hand, in one entity: a driven hinge has two components."""
    return [each for each in component.get_entity().components if isinstance(each, physx.PhysxJointComponent)]


def parent_of(component: Any) -> str | None:
    parent = component.get_parent()
    return None if parent is None else parent.get_entity().name


@pytest.mark.parametrize("name", CASES)
def test_it_is_what_hand_written_code_builds(name: str) -> None:
    case = CASES[name]
    hand = by_hand(case)
    with load_scene(file_of(case), render=False) as batch:
        (tie,) = batch.constraints.values()
        assert tie.scene_idxs == tuple(range(SCENES))
        for ours, (_, theirs) in zip(tie.objs, hand, strict=True):
            assert ours.get_entity().name == theirs.get_entity().name == "bob"
            for component in ties_of(theirs):
                component.name = "tie"
        scenes = [scene for scene, _ in hand]
        for one, other in zip(batch.scenes, scenes, strict=True):
            assert_same_scene(one, other)
        assert_same_trajectory(batch.scenes, scenes)


@pytest.mark.parametrize("name", CASES)
def test_it_does_something(name: str) -> None:
    case = CASES[name]
    alone = {key: section for key, section in file_of(case).items() if key != "constraints"}
    with load_scene(file_of(case), render=False) as tied, load_scene(alone, render=False) as free:
        tied.step(50)
        free.step(50)
        assert not np.allclose(tied.entities["bob"].pose, free.entities["bob"].pose, atol=1e-3)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("exact", [False, True])
def test_a_reset_starts_as_it_was_built(name: str, exact: bool) -> None:
    with load_scene(file_of(CASES[name]), render=False) as batch, load_scene(file_of(CASES[name]), render=False) as new:
        batch.step(37)
        batch.reset(exact=exact)
        # Without `exact`, PhysX solves two joints of the same bodies in another order.
        steps = STEPS if exact or name != "hinge that is driven" else 0
        assert_same_trajectory(batch.scenes, new.scenes, steps)


def test_a_state_is_restored_with_constraints_there() -> None:
    with load_scene(file_of(CASES["weld"]), render=False) as batch:
        batch.step(20)
        state = batch.state()
        batch.set_state(state, exact=True)
        batch.step(30)
        first = batch.entities["bob"].pose
        batch.set_state(state, exact=True)
        assert batch.state() == state
        batch.step(30)
        assert np.array_equal(batch.entities["bob"].pose, first)


def test_targets_are_drawn_anew_at_a_reset_and_set_again() -> None:
    written = {**CASES["drive about all axes"].written, "target": {"p": {"uniform": [[0, 0, 0], [0.1, 0.1, 0.1]]}}}
    file = file_of(Case(written, turner))

    def targets(batch: SceneBatch) -> list[list[Any]]:
        return [drive.drive_target.p.tolist() for drive in batch.constraints["tie"].objs]

    with load_scene(file, render=False) as batch, load_scene(file, render=False, seed=5) as other:
        first = targets(batch)
        for drive in batch.constraints["tie"].objs:
            drive.set_drive_target(Pose([9, 9, 9]))
        batch.reset()
        assert targets(batch) == first
        batch.reset(seed=5)
        assert targets(batch) == targets(other) != first
        batch.reset(seed=0, scene_idxs=[1])
        assert targets(batch)[1] == first[1]
        assert targets(batch)[0] == targets(other)[0]


def test_left_out_the_frame_is_where_the_child_stands() -> None:
    scene: Scene = {
        "scenecc": 1,
        "entities": {
            "a": {"pose": {"p": [1, 2, 3], "rpy_deg": [10, 20, 30]}, "collisions": [{"type": "sphere", "radius": 0.1}]},
            "b": {"pose": {"p": [3, 1, 2], "rpy_deg": [50, -20, 5]}, "collisions": [{"type": "sphere", "radius": 0.1}]},
        },
        "constraints": {
            "tie": {
                "type": "weld",
                "parent": "a",
                "child": "b",
                "pose_in_child": {"p": [0.5, 0, 0], "rpy_deg": [0, 0, 90]},
            }
        },
    }
    (tie,) = compile_scene(scene).constraints
    a, b = (matrix(entity.pose.numbers()) for entity in compile_scene(scene).entities)
    assert tie.pose_in_parent is not None
    assert tie.pose_in_child is not None
    expected = np.linalg.inv(a) @ b @ matrix(tie.pose_in_child.numbers())
    assert np.allclose(matrix(tie.pose_in_parent.numbers()), expected, rtol=0, atol=1e-14)
    with load_scene(scene, render=False) as batch:
        relative = batch.constraints["tie"].objs[0].relative_pose
        assert np.allclose(relative.p, 0, atol=1e-6)
        assert np.allclose(np.abs(relative.q), [1, 0, 0, 0], atol=1e-6)


def matrix(pose: tuple[float, ...]) -> Any:
    p, (w, x, y, z) = pose[:3], pose[3:]
    made = np.eye(4)
    made[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    made[:3, 3] = p
    return made


def test_a_link_is_tied_where_it_starts() -> None:
    scene: Scene = {
        "scenecc": 1,
        "num_scenes": 2,
        "entities": {
            "door": {
                "fix_root_link": True,
                "pose": {"p": [1, 0, 1], "rpy_deg": [0, 0, 30]},
                "qpos": {"per_scene": [[0.5, 0.1], [0.25, 0.2]]},
                "root": {
                    "name": "frame",
                    "shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.5]}],
                    "children": [
                        {
                            "name": "panel",
                            "joint": {
                                "name": "hinge",
                                "type": "revolute",
                                "origin": {"p": [0.1, 0, 0]},
                                "axis": [0, 0, 1],
                                "limits": [-1, 1],
                            },
                            "shapes": [{"type": "box", "half_size": [0.2, 0.02, 0.4], "pose": [0.3, 0, 0]}],
                            "children": [
                                {
                                    "name": "handle",
                                    "joint": {
                                        "name": "slide",
                                        "type": "prismatic",
                                        "origin": {"p": [0.4, 0, 0]},
                                        "axis": [0, 1, 0],
                                        "limits": [0, 1],
                                    },
                                    "shapes": [{"type": "sphere", "radius": 0.03}],
                                }
                            ],
                        }
                    ],
                },
            },
            "ball": {"pose": [2, 0, 1], "shapes": [{"type": "sphere", "radius": 0.1}]},
        },
        "constraints": {"grip": {"type": "weld", "parent": "door/handle", "child": "ball"}},
    }
    with load_scene(scene, render=False) as batch:
        for component in batch.constraints["grip"].objs:
            assert parent_of(component) == "handle"
            assert np.allclose(component.relative_pose.p, 0, atol=1e-6)
            assert np.allclose(np.abs(component.relative_pose.q), [1, 0, 0, 0], atol=1e-6)


@pytest.mark.parametrize("name", CASES)
def test_what_is_not_enabled_does_nothing_until_it_is(name: str) -> None:
    case = CASES[name]
    off = replace(case, written={**case.written, "enabled": {"per_scene": [False, True, False]}})
    hand = by_hand(case)
    for number in (0, 2):
        for component in ties_of(hand[number][1]):
            component.disable()
    with load_scene(file_of(off), render=False) as batch:
        tie = batch.constraints["tie"]
        assert tie.enabled.tolist() == [False, True, False]
        scenes = [scene for scene, _ in hand]
        assert_same_trajectory(batch.scenes, scenes, 100)
        tie.enabled = [True, False, False]
        for (_, component), flag in zip(hand, (True, False, False), strict=True):
            if flag != component.is_enabled:
                for each in ties_of(component):
                    (each.enable if flag else each.disable)()
                component.get_entity().components[0].wake_up()
                if case.kind == "dynamic" and component.get_parent() is not None:
                    component.get_parent().wake_up()
        assert_same_trajectory(batch.scenes, scenes, 100)
        # A reset leaves it as a person set it.
        batch.reset(exact=True)
        assert tie.enabled.tolist() == [True, False, False]
        tie.enabled = True
        assert tie.enabled.all()


@pytest.mark.parametrize("flags", [1, "yes", [True, False], [[True, False, True]], [0, 1, 0]])
def test_what_is_no_flag_of_a_constraint(flags: Any) -> None:
    with (
        load_scene(file_of(CASES["weld"]), render=False) as batch,
        pytest.raises(ValueError, match="enabled must be true or"),
    ):
        batch.constraints["tie"].enabled = flags


def test_a_body_that_sleeps_falls_once_it_is_let_go() -> None:
    with load_scene(file_of(CASES["hinge"], angular_velocity=[0, 0, 0]), render=False) as batch:
        batch.constraints["tie"].enabled = True
        for body in batch.entities["bob"].objs:
            component: Any = body.components[0]
            component.put_to_sleep()
        before = batch.entities["bob"].pose[:, 2]
        batch.constraints["tie"].enabled = False
        batch.step(20)
        assert (batch.entities["bob"].pose[:, 2] < before - 0.05).all()


@pytest.mark.parametrize(
    ("drive", "sign"),
    [
        ({"stiffness": 5, "damping": 1, "target": 0.4}, 1),
        ({"stiffness": 5, "damping": 1, "target": {"uniform": [-0.4, -0.3]}}, -1),
        ({"damping": 1, "velocity_target": 0.5}, 1),
        ({"damping": 1, "velocity_target": {"uniform": [-0.5, -0.4]}}, -1),
    ],
)
def test_a_hinge_turns_and_a_slider_goes_the_way_that_its_drive_says(drive: dict[str, Any], sign: int) -> None:
    for kind in ("hinge", "slider"):
        scene = file_of(Case({"type": kind, "parent": "world", "drive": drive}, hinge), angular_velocity=[0, 0, 0])
        scene["entities"]["bob"]["gravity"] = False
        with load_scene(scene, render=False) as batch:
            start = batch.entities["bob"].pose
            batch.step(50)
            pose = batch.entities["bob"].pose
            moved = pose[:, 4] * np.sign(pose[:, 3]) if kind == "hinge" else pose[:, 0] - start[:, 0]
            assert (sign * moved > 0.02).all()
            assert np.allclose(pose[:, 1:3], start[:, 1:3], atol=1e-3)


@pytest.mark.parametrize("parent", ["world", "post"])
@pytest.mark.parametrize("target", [1.5, -3.0])
def test_a_hinge_holds_its_axis_at_any_target(parent: str, target: float) -> None:
    """PhysX rotates the torques of a swing by the target: with both in one component, the plate tips over."""
    plate = {"type": "box", "half_size": [0.4, 0.02, 0.5], "pose": [0.4, 0, 0]}
    scene = {
        "scenecc": 1,
        "entities": {
            "post": {"pose": [-0.1, 0, 1], "gravity": False, "shapes": [{"type": "box", "half_size": [0.05] * 3}]},
            "plate": {"pose": [0, 0, 1], "shapes": [plate]},
        },
        "constraints": {
            "tie": {
                "type": "hinge",
                "parent": parent,
                "child": "plate",
                "axis": "z",
                "drive": {"stiffness": 100, "damping": 10, "target": target},
            }
        },
    }
    with load_scene(scene, render=False) as batch:
        bodies = batch.entities["post"].objs[0], batch.entities["plate"].objs[0]
        for _ in range(40):
            batch.step(10)
            up, other = (body.pose.to_transformation_matrix()[:3, 2] for body in bodies)
            assert np.degrees(np.arccos(min(1.0, float(other @ (up if parent == "post" else [0, 0, 1]))))) < 0.1
        turn = (bodies[0].pose.inv() if parent == "post" else Pose()) * bodies[1].pose
        angle = 2 * np.arctan2(turn.q[3], turn.q[0])
        assert abs((angle - target + np.pi) % (2 * np.pi) - np.pi) < 0.1
        batch.constraints["tie"].enabled = False
        moving: Any = bodies[1].components[0]
        moving.angular_velocity = [3, 0, 0]
        batch.step(20)
        assert bodies[1].pose.to_transformation_matrix()[2, 2] < 0.9


BRIDGE = Path(__file__).resolve().parents[2] / "scenes/rope_bridge.yaml"


def bridge_by_hand(planks: int, *, rope: bool) -> sapien.Scene:
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    scene.add_ground(0, render=False)

    def box(name: str, at: list[float], half_size: Any, density: float, kind: str) -> Any:
        builder = scene.create_actor_builder()
        builder.set_physx_body_type(kind)
        builder.add_box_collision(half_size=half_size, density=density)
        builder.initial_pose = Pose(at)
        return builder.build(name=name)

    cliffs = [
        box(f"{side}", [side * (planks * 0.08 + 0.25), 0, 0.5], [0.25, 0.5, 0.5], 1000, "static") for side in (-1, 1)
    ]
    at = [(i - (planks - 1) / 2) * 0.16 for i in range(planks)]
    bodies = [box(f"plank_{i}", [x, 0, 0.98], [0.075, 0.3, 0.02], 600, "dynamic") for i, x in enumerate(at)]
    turn = [0.70710678, 0, 0, 0.70710678]

    def tied(parent: Any, here: list[float], child: Any, side: float) -> Any:
        drive = scene.create_drive(parent, Pose(here, turn), child, Pose([side, 0, 0], turn))
        return locked(drive, "x", "y", "z")

    def swing(drive: Any) -> Any:
        drive.set_drive_property_swing(1e10, 1e4, mode="acceleration")
        return drive

    edge = planks * 0.08 + 0.25
    swing(tied(cliffs[0], [edge + at[0] - 0.08, 0, 0.98 - 0.5], bodies[0], -0.08))
    for i in range(planks - 1):
        drive = tied(bodies[i], [at[i + 1] - at[i] - 0.08, 0, 0], bodies[i + 1], -0.08)
        drive.set_limit_twist(np.deg2rad(-60), np.deg2rad(60))
        drive.set_drive_property_twist(0, 0.2)
        swing(drive)
    last = swing(tied(cliffs[1], [at[-1] - edge + 0.08, 0, 0.98 - 0.5], bodies[-1], 0.08))
    if not rope:
        last.disable()
    return scene


@pytest.mark.parametrize("planks", [2, 12])
def test_the_rope_bridge_that_ships_is_what_hand_written_code_builds(planks: int) -> None:
    hand = [bridge_by_hand(planks, rope=scene != 2) for scene in range(4)]
    with load_scene(BRIDGE, params={"planks": planks}, render=False) as batch:
        assert_same_trajectory(batch.scenes, hand)


RAIL = {"type": "box", "half_size": [0.05, 0.05, 0.05], "pose": [0.5, 0, 0]}


def railed(*constraints: Scene, kind: str = "dynamic", link: bool = False) -> Scene:
    """A cart that gravity pulls along x against the end of a rail, which holds it by constraints."""
    rail: Scene = {"body_type": kind, "collisions": [RAIL]}
    if link:
        rail = {"fix_root_link": True, "root": {"name": "rail", "collisions": [RAIL]}}
    elif kind == "dynamic":
        rail |= {"mass": 1e6, "gravity": False}
    cart = {"collisions": [{"type": "box", "half_size": [0.05, 0.05, 0.05]}]}
    ends = {"parent": "rail/rail" if link else "rail", "child": "cart", "pose_in_parent": [0, 0, 0]}
    return {
        "scenecc": 1,
        "physics": {"gravity": [9.81, 0, 0]},
        "entities": {"rail": rail, "cart": cart},
        "constraints": {f"tie{number}": {**ends, **each} for number, each in enumerate(constraints)},
    }


SLIDER: Scene = {"type": "slider"}
COLLIDING: Scene = {"type": "slider", "collide": True}
FAR: Scene = {"type": "distance", "limits": [0, 50], "collide": True}


@pytest.mark.parametrize(
    ("scene", "stops"),
    [
        (railed(SLIDER), False),
        (railed(COLLIDING, kind="static"), True),
        (railed(COLLIDING, kind="kinematic"), True),
        (railed(COLLIDING), True),
        (railed(COLLIDING, link=True), True),
        (railed(FAR, kind="kinematic"), True),
        (railed(COLLIDING, FAR, kind="kinematic"), True),
    ],
)
@pytest.mark.parametrize("exact", [False, True])
def test_bodies_of_a_constraint_collide_if_it_says_so(scene: Scene, stops: bool, exact: bool) -> None:
    with load_scene(scene, render=False) as batch:
        for _ in range(2):
            batch.step(100)
            x = batch.entities["cart"].pose[0, 0]
            assert x == pytest.approx(0.4, abs=0.01) if stops else x > 4
            batch.reset(exact=exact)
        for name in scene["constraints"]:
            batch.constraints[name].enabled = False
            batch.constraints[name].enabled = True
        batch.step(100)
        assert (batch.entities["cart"].pose[0, 0] < 0.41) == stops


def test_emitted_scripts_let_the_same_bodies_collide() -> None:
    script = emit_scene(railed(COLLIDING, FAR, kind="kinematic"), "python")
    space: dict[str, Any] = {"__name__": "emitted"}
    exec(script, space)
    (scene,) = space["build_scenes"]()
    for _ in range(100):
        scene.step()
    (cart,) = (entity for entity in scene.entities if entity.name == "cart")
    assert cart.pose.p[0] == pytest.approx(0.4, abs=0.01)


def test_bodies_collide_in_the_scenes_where_all_constraints_say_so() -> None:
    ties = [COLLIDING | {"scene_idxs": [0, 2]}, FAR | {"scene_idxs": [1, 2]}, SLIDER | {"scene_idxs": [2, 3]}]
    scene = railed(*ties, kind="kinematic") | {"num_scenes": 4}
    space: dict[str, Any] = {"__name__": "emitted"}
    exec(emit_scene(scene, "python"), space)
    with load_scene(scene, render=False) as batch:
        for made in (batch.scenes, space["build_scenes"]()):
            for one in made:
                for _ in range(100):
                    one.step()
            carts = [next(each for each in one.entities if each.name == "cart") for one in made]
            assert [bool(cart.pose.p[0] < 0.41) for cart in carts] == [True, True, False, False]
