"""Starts that are drawn anew, in some environments."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from plugins.maniskill_scenes import new_scene
from sapien import physx

import scenecc

pytestmark = pytest.mark.quick

DRAWN = {
    "scenecc": 1,
    "num_scenes": 3,
    "draws": {"height": {"uniform": [0.5, 1.5]}},
    "entities": {
        "table": {
            "body_type": "static",
            "shapes": [{"type": "box", "half_size": [1, 1, 0.1]}],
            "pose": {"p": [0, 0, {"uniform": [-1, -0.5]}]},
        },
        "cube": {
            "shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}],
            "pose": {"p": [{"uniform": [-1, 1]}, 0, "${height}"]},
            "linear_velocity": [0, 0, {"uniform": [1, 2]}],
        },
        "goal": {
            "body_type": "kinematic",
            "visuals": [{"type": "sphere", "radius": 0.02}],
            "pose": [0, 0, "${height}"],
        },
    },
}


@pytest.fixture
def loaded() -> Any:
    return scenecc.load_scene(DRAWN, scene=new_scene(3))


def starts(loaded: Any) -> np.ndarray:
    """(environment, number): pose and velocity of the cube, pose of the goal, pose of the table."""
    cube, goal, table = (loaded.actors[name] for name in ("cube", "goal", "table"))
    velocity = np.array([body.linear_velocity for body in cube._bodies])
    return np.hstack([cube.pose.raw_pose, velocity, goal.pose.raw_pose, table.pose.raw_pose])


def test_a_start_is_what_bare_sapien_resets_to(loaded: Any) -> None:
    loaded.initialize(seed=[5, 6, 7])
    found = starts(loaded)
    with scenecc.load_scene(DRAWN, render=False) as batch:
        batch.reset(seed=[5, 6, 7])
        wanted = [batch.entities[name] for name in ("cube", "goal", "table")]
        assert (found[:, :7] == wanted[0].pose).all()
        assert (found[:, 7:10] == wanted[0].linear_velocity).all()
        assert (found[:, 10:17] == wanted[1].pose).all()
        assert (found[:, 17:] == wanted[2].pose).all()


def test_the_same_seeds_give_the_same_again_and_others_do_not(loaded: Any) -> None:
    loaded.initialize(seed=5)
    first = starts(loaded)
    loaded.initialize(seed=6)
    other = starts(loaded)
    loaded.initialize(seed=5)
    assert (starts(loaded) == first).all()
    assert (other[:, 0] != first[:, 0]).all()
    # Static bodies stay where they were built.
    assert (other[:, 17:] == first[:, 17:]).all()


def test_initialize_changes_only_the_given_environments(loaded: Any) -> None:
    import torch

    loaded.initialize(seed=5)
    before = starts(loaded)
    loaded.initialize(torch.tensor([2, 0]), seed=[8, 9])
    after = starts(loaded)
    assert (after[1] == before[1]).all()
    assert (after[[0, 2], 0] != before[[0, 2], 0]).all()
    loaded.initialize([0], seed=9)
    loaded.initialize([2], seed=8)
    assert (starts(loaded) == after).all()


def test_without_a_seed_it_is_the_start_that_was_built(loaded: Any) -> None:
    built = starts(loaded)
    loaded.initialize(seed=5)
    loaded.initialize()
    assert (starts(loaded) == built).all()


def test_initialize_restores_moved_objects(loaded: Any) -> None:
    loaded.initialize(seed=5)
    first = starts(loaded)
    for scene in loaded.scene.sub_scenes:
        for _ in range(20):
            scene.step()
    assert (starts(loaded) != first).any()
    loaded.initialize(seed=5)
    assert (starts(loaded) == first).all()


def test_initialize_takes_given_draws(loaded: Any) -> None:
    loaded.initialize([1, 2], seed=5, draws={"height": [0.25, 0.75]})
    assert starts(loaded)[1:, [2, 12]].tolist() == [[0.25, 0.25], [0.75, 0.75]]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((3,),), r"0 to 2, not \[3\]"),
        (((0, 0),), "twice"),
        (((0,), [1, 2]), "2 seeds for 1"),
    ],
)
def test_initialize_refuses_invalid_arguments(loaded: Any, arguments: tuple[Any, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        loaded.initialize(*arguments)


def test_initialize_accepts_an_empty_list_of_environments(loaded: Any) -> None:
    before = starts(loaded)
    loaded.initialize([], seed=[])
    assert (starts(loaded) == before).all()


def test_targets_of_constraints_are_what_bare_sapien_resets_to() -> None:
    ball = {"shapes": [{"type": "sphere", "radius": 0.1}], "pose": [0, 0, 1]}
    lift = {
        "type": "drive",
        "parent": "world",
        "child": "ball",
        "pose_in_parent": [0, 0, 0],
        "drive": {"x": {"stiffness": 10}},
        "target": {"p": [{"uniform": [1, 2]}, 0, 0]},
        "velocity_target": {"linear": [{"uniform": [1, 2]}, 0, 0]},
    }
    scene = {"scenecc": 1, "num_scenes": 3, "entities": {"ball": ball}, "constraints": {"lift": lift}}
    loaded = scenecc.load_scene(scene, scene=new_scene(3))
    drives = [obj.find_component_by_type(physx.PhysxDriveComponent) for obj in loaded.actors["ball"]._objs]

    def targets(held: list[Any]) -> list[Any]:
        return [
            (drive.drive_target.p.tolist(), [side.tolist() for side in drive.get_drive_velocity_target()])
            for drive in held
        ]

    built = targets(drives)
    loaded.initialize([0, 2], seed=[5, 7])
    with scenecc.load_scene(scene, render=False) as batch:
        batch.reset(seed=[5, 7], scene_idxs=[0, 2])
        assert targets(drives) == targets(batch.constraints["lift"].objs)
    assert targets(drives)[1] == built[1]
    assert all(now != then for now, then in zip(targets(drives)[::2], built[::2], strict=True))


def test_values_that_a_gpu_keeps_as_built_are_named_in_a_warning() -> None:
    cube = {"mass": {"uniform": [1, 2]}, "shapes": [{"type": "sphere", "radius": 0.1}]}
    tie = {"type": "connection", "child": "a", "parent": "b", "pose_in_parent": [0, 0, 0]}
    scene: dict[str, Any] = {
        "scenecc": 1,
        "entities": {"a": cube, "b": {**cube, "mass": {"once": cube["mass"]}, "pose": [1, 0, 0]}},
        "constraints": {"tie": {**tie, "enabled": {"choice": [True, False]}}},
        "cameras": {"eye": {"fovy": {"uniform": [1, 2]}, "pose": [{"uniform": [0, 1]}, 0, 0]}},
    }
    loaded = scenecc.load_scene(scene, scene=new_scene())
    loaded.scene = SimpleNamespace(gpu_sim_enabled=True)
    with pytest.warns(UserWarning, match="on a GPU they stay as built") as caught:
        assert len(loaded._drawn_fields) == 0
    told = str(caught[0].message).partition(": ")[2].partition(". ")[0].split(", ")
    assert sorted(told) == ["a.mass", "cameras/eye.lens.fovy", "cameras/eye.pose", "constraints/tie.enabled"]
