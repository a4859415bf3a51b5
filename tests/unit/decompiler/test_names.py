"""Names of live scenes that a scene file does not take: the file builds all the same, and they are listed."""

from __future__ import annotations

from typing import Any

import pytest
import sapien
from sapien import physx

import scenecc


def physical_scene() -> Any:
    return sapien.Scene([physx.PhysxCpuSystem()])


def chain(scene: Any, links: list[str], joints: list[str]) -> Any:
    """An articulation named `arm` whose joints have drives of different stiffness; a name of "" is not set."""
    builder = scene.create_articulation_builder()
    parent = None
    for link_name, joint_name in zip(links, ["", *joints], strict=True):
        link = builder.create_link_builder(parent)
        if link_name:
            link.set_name(link_name)
        if parent is not None:
            if joint_name:
                link.set_joint_name(joint_name)
            link.set_joint_properties("revolute", [[-1, 1]], sapien.Pose([0, 0, 0.2]), sapien.Pose())
        link.add_box_collision(half_size=[0.05, 0.05, 0.05])
        parent = link
    arm = builder.build(fix_root_link=True)
    arm.set_name("arm")
    for number, joint in enumerate(arm.active_joints):
        joint.set_drive_properties(10 * (number + 1), 1)
    arm.set_qpos([0.1] * len(joints))
    return arm


def add_box(scene: Any, name: str | None, x: float = 0) -> Any:
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=[0.1, 0.1, 0.1])
    body = builder.build() if name is None else builder.build(name=name)
    body.set_pose(sapien.Pose([x, 0, 0]))
    return body


def names_of(root: dict[str, Any]) -> list[str]:
    """Names of the links and joints of a tree, depth first."""
    own = [root["name"], *([root["joint"]["name"]] if "joint" in root else [])]
    return own + [name for child in root.get("children", []) for name in names_of(child)]


@pytest.mark.parametrize(
    ("links", "joints", "names", "problems"),
    [
        (
            ["", "", ""],
            ["", ""],
            ["link_0", "link_1", "joint_0", "link_2", "joint_1"],
            [
                "3 links of `arm` without a name; they are named `link_0`, `link_1`, `link_2`",
                "2 joints of `arm` without a name; they are named `joint_0`, `joint_1`",
            ],
        ),
        (
            ["dup", "dup", "dup_0"],
            ["j", "j"],
            ["dup_0_2", "dup_1", "j_0", "dup_0", "j_1"],
            [
                "the name 'dup' of 2 links of `arm`; they are named `dup_0_2`, `dup_1`",
                "the name 'j' of 2 joints of `arm`; they are named `j_0`, `j_1`",
            ],
        ),
        (
            ["l/1", "l_1", "world"],
            ["j 1", "x-j"],
            ["l_1_2", "l_1", "j_1", "world", "_x-j"],
            [
                "the name 'l/1' of a link of `arm`; it is named `l_1_2`",
                "the name 'j 1' of a joint of `arm`; it is named `j_1`",
                "the name 'x-j' of a joint of `arm`; it is named `_x-j`",
            ],
        ),
    ],
    ids=["none", "equal", "odd"],
)
def test_links_and_joints_get_valid_names(
    links: list[str], joints: list[str], names: list[str], problems: list[str]
) -> None:
    scene = physical_scene()
    chain(scene, links, joints)
    found = scenecc.decompile(scene)
    assert found.is_equal, found.differences
    arm = found.document["entities"]["arm"]
    assert names_of(arm["root"]) == names
    assert sum("stiffness" in drive for drive in arm["drives"].values()) == 2
    assert list(found.problems) == problems


def test_mounts_refer_to_the_new_name_of_a_link() -> None:
    scene = physical_scene()
    arm = chain(scene, ["", "", ""], ["", ""])
    box = add_box(scene, "box", 1).find_component_by_type(physx.PhysxRigidDynamicComponent)
    scene.create_gear(arm.links[1], sapien.Pose(), box, sapien.Pose())
    found = scenecc.decompile(scene)
    assert found.is_equal, found.differences
    assert found.document["constraints"]["constraint"]["parent"] == "arm/link_1"


def test_invalid_body_names_are_replaced_and_listed_once() -> None:
    scene = physical_scene()
    for x, name in enumerate(["same", "same", "same", "same", None, None, "a\nb", "same_1"], 1):
        add_box(scene, name, x)
    found = scenecc.decompile(scene)
    assert found.is_equal, found.differences
    assert found.problems == (
        "the name 'same' of 4 entities; they are named `same_0`, `same_1_2`, `same_2` and 1 more",
        "2 entities without a name; they are named `body_0`, `body_1`",
        "the name 'a\\nb' of an entity; it is named `a_b`",
    )
    assert set(found.document["entities"]) == {
        *("same_0", "same_1_2", "same_2", "same_3", "body_0", "body_1", "a_b", "same_1")
    }


@pytest.mark.parametrize("name", ["cup", None])
def test_equal_bodies_with_one_name_become_a_repeat(name: str | None) -> None:
    scene = physical_scene()
    for x in (1, 2, 3):
        add_box(scene, name, x)
    found = scenecc.decompile(scene)
    assert found.is_equal, found.differences
    (entity,) = found.document["entities"].values()
    assert entity["repeat"] == {"x": [1.0, 2.0, 3.0]}
    assert len(found.problems) == 1


@pytest.mark.parametrize("recorded", [True, False])
def test_a_drive_without_effect_is_left_out_and_listed(recorded: bool) -> None:
    with scenecc.record() as recording:
        scene = physical_scene()
        first, second = add_box(scene, "first"), add_box(scene, "second", 1)
        scene.create_drive(first, sapien.Pose(), second, sapien.Pose())
    found = scenecc.decompile(scene, recording=recording if recorded else None)
    assert "constraints" not in found.document
    (problem,) = found.problems
    assert "between `first` and `second`, which has no effect" in problem
    assert ("scenecc.record()" in problem) is not recorded
    assert found.differences is not None
    assert not any("does not build" in line for line in found.differences)
