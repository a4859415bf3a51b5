"""What a training loop reads of a batch: links, columns, contacts, read-only arrays, and near names."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from unit.backends.test_articulations import alone, built, chain

import scenecc
from scenecc import SceneBatch

JOINT = {"name": "hinge", "type": "revolute", "axis": [0, 1, 0], "limits": [-1, 1]}
TIP = {"name": "tip", "joint": JOINT, "shapes": [{"type": "sphere", "radius": 0.05}]}
PAD = {"name": "pad", "joint": {"name": "mount", "type": "fixed"}, "shapes": [{"type": "sphere", "radius": 0.01}]}
ROOT = {"name": "base", "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]}
SCENE = {
    "scenecc": 1,
    "num_scenes": 3,
    "entities": {
        "floor": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "cube": {"pose": [1, 0, 0.019], "shapes": [{"type": "box", "half_size": [0.02, 0.02, 0.02]}]},
        "arm": {"root": {**ROOT, "children": [TIP, PAD]}, "pose": [0, 0, 0.1], "fix_root_link": True},
    },
}


@pytest.fixture
def batch() -> Iterator[SceneBatch]:
    with scenecc.load_scene(SCENE, render=False) as built:
        yield built


def test_joint_index_returns_columns_of_moving_joints(batch: SceneBatch) -> None:
    arm = batch.articulations["arm"]
    assert arm.joint_index(["hinge"]).tolist() == arm.joint_index("hinge").tolist() == [0]
    assert arm.joint_index([]).shape == (0,)
    with pytest.raises(KeyError, match=r"no moving joint 'hing' of 'arm'; did you mean `hinge`\?"):
        arm.joint_index("hing")
    with pytest.raises(KeyError, match="no moving joint 'mount'"):
        arm.joint_index(["hinge", "mount"])


def test_link_poses_and_velocities_are_read_by_name(batch: SceneBatch) -> None:
    arm = batch.articulations["arm"]
    assert arm.link_pose(["tip", "base"]).shape == (3, 2, 7)
    assert (arm.link_pose("base")[:, 0] == arm.pose).all()
    assert arm.link_pose([]).shape == (3, 0, 7)
    assert arm.link_velocity("tip").shape == (3, 1, 6)
    arm.qvel = [0.5]
    assert arm.link_velocity("tip")[:, 0, 4] == pytest.approx(0.5)
    links: Any = arm.links
    with pytest.raises(KeyError, match=r"no link -1 of 'arm' \(objects are found by name, not by number\); known here"):
        links[-1]
    for read in (arm.link_pose, arm.link_velocity):
        with pytest.raises(KeyError, match=r"no link 'tpi' of 'arm'; did you mean `tip`\?"):
            read(["tpi"])
    batch.remove("arm")
    with pytest.raises(RuntimeError, match="'arm' is removed"):
        arm.link_pose("tip")


def test_a_link_that_some_scenes_lack_is_nan_there() -> None:
    batch = built(alone(chain(2), chain(1)))
    batch.step()
    robot = batch.articulations["robot"]
    pose, velocity = robot.link_pose(["l0", "l1"]), robot.link_velocity(["l0", "l1"])
    assert np.isnan(pose).all(axis=2).tolist() == [[False, False], [False, True], [False, False]]
    assert (np.isnan(velocity).all(axis=2) == np.isnan(pose).all(axis=2)).all()
    assert np.isnan(batch.net_contact_force("robot/l1")).all(axis=1).tolist() == [False, True, False]
    assert not batch.net_contact_force("robot").any()
    with pytest.raises(ValueError, match="different joints in different scenes"):
        robot.joint_index("j1")


def test_contacts_of_unknown_names_suggest_the_closest(batch: SceneBatch) -> None:
    for name, near in {"cub": "cube", "rm": "arm"}.items():
        for read in (batch.contacts, batch.net_contact_force):
            with pytest.raises(KeyError, match=rf"no entity '{name}'; did you mean `{near}`\?"):
                read(name)
    with pytest.raises(KeyError, match=r"no link 'tap' of 'arm'; did you mean `tip`\?"):
        batch.contacts("floor", "arm/tap")
    with pytest.raises(KeyError, match="no entity 'cube/tip'"):
        batch.net_contact_force("cube/tip")
    with pytest.raises(KeyError, match=r"no body 'cubes'; did you mean `cube`\?"):
        batch.entities["cubes"]
    with pytest.raises(KeyError, match=r"no articulation 'arms'; did you mean `arm`\?"):
        batch.articulations["arms"]
    with pytest.raises(KeyError, match="no camera 'eye'"):
        batch.cameras["eye"]
    with pytest.raises(KeyError, match="no light 'lamp'"):
        batch.lights["lamp"]
    with pytest.raises(KeyError, match="no constraint 'weld'; there are none"):
        batch.constraints["weld"]
    with pytest.raises(KeyError, match="no link 'tpi' of 'arm'"):
        batch.articulations["arm"].links["tpi"]
    assert batch.entities.get("cubes") is None


def test_a_link_name_with_a_slash_is_found() -> None:
    arm = chain(2)
    batch = built(alone(replace(arm, links=(arm.links[0], replace(arm.links[1], name="pad/left")))))
    batch.step()
    assert batch.net_contact_force("robot/pad/left").shape == (3, 3)
    with pytest.raises(KeyError, match=r"no link 'pad/lift' of 'robot'; did you mean `pad/left`"):
        batch.contacts("robot/pad/lift")


READ: list[Callable[[SceneBatch], Any]] = [
    lambda batch: batch.entities["cube"].pose,
    lambda batch: batch.entities["cube"].linear_velocity,
    lambda batch: batch.articulations["arm"].qpos,
    lambda batch: batch.articulations["arm"].qlimits,
    lambda batch: batch.articulations["arm"].drive_target,
    lambda batch: batch.articulations["arm"].joint_index("hinge"),
    lambda batch: batch.articulations["arm"].link_pose("tip"),
    lambda batch: batch.articulations["arm"].link_velocity("tip"),
    lambda batch: batch.net_contact_force("cube"),
    *(lambda batch, name=name: getattr(batch.contacts(), name) for name in ("scene", "point", "impulse", "a")),
]


@pytest.mark.parametrize("read", READ)
def test_arrays_of_a_batch_are_read_only(read: Callable[[SceneBatch], Any], batch: SceneBatch) -> None:
    batch.step()
    with pytest.raises(ValueError, match="read-only"):
        read(batch)[..., 0] = read(batch)[..., 0]


def test_a_pose_can_be_assigned(batch: SceneBatch) -> None:
    cube = batch.entities["cube"]
    cube.pose = [1, 2, 3, 0, 1, 0, 0]
    assert (cube.pose == [1, 2, 3, 0, 1, 0, 0]).all()
    with pytest.raises(ValueError, match="a pose must be"):
        cube.pose = [1, 2]


def test_contacts_are_those_of_the_last_step(batch: SceneBatch) -> None:
    assert len(batch.contacts().scene) == 0
    batch.step(5)
    assert set(batch.contacts("cube").scene) == {0, 1, 2}
    assert batch.net_contact_force("cube")[:, 2].min() > 0
    batch.reset(scene_idxs=[1])
    assert set(batch.contacts("cube").scene) == {0, 2}
    assert not batch.net_contact_force("cube")[1].any()
    batch.step()
    assert set(batch.contacts("cube").scene) == {0, 1, 2}
    batch.close()
    for read in (batch.contacts, lambda: batch.net_contact_force("cube")):
        with pytest.raises(RuntimeError, match="the batch is closed"):
            read()


def test_contacts_name_bodies_that_were_added_by_hand(batch: SceneBatch) -> None:
    builder = batch.scenes[0].create_actor_builder()
    builder.add_box_collision(half_size=[0.1, 0.1, 0.1])  # pyright: ignore[reportArgumentType]
    box = builder.build("crate")
    box.set_pose(box.pose.__class__([3, 0, 0.099]))
    batch.step()
    assert "crate" in set(batch.contacts("floor").b)
    with pytest.raises(KeyError, match="no entity 'crate'"):
        batch.contacts("crate")


def test_a_pose_can_be_assigned_from_a_tensor(batch: SceneBatch) -> None:
    torch = pytest.importorskip("torch")
    cube, arm = batch.entities["cube"], batch.articulations["arm"]
    cube.pose = torch.tensor([1.0, 2, 3, 0, 1, 0, 0])
    assert (cube.pose == [1, 2, 3, 0, 1, 0, 0]).all()
    arm.set_qpos(torch.full((2, 1), 0.25), scene_idxs=[0, 2])
    assert torch.tensor(arm.qpos)[::2, 0].tolist() == [0.25, 0.25]
