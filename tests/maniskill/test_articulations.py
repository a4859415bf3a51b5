"""Articulations in ManiSkill's scenes: against the same by ManiSkill's own builder and loader."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plugins.maniskill_scenes import new_scene
from plugins.trajectory import first_difference, trajectory

import scenecc
from scenecc.decompiler.reading import LiveObject, read_scene
from scenecc.decompiler.verify import differences
from scenecc.maniskill import load_into

STEPS = 200

DOOR = {
    "fix_root_link": True,
    "pose": [0, 0, 1],
    "root": {
        "name": "frame",
        "shapes": [{"type": "box", "half_size": [0.05, 0.05, 0.5]}],
        "children": [
            {
                "name": "panel",
                "shapes": [{"type": "box", "half_size": [0.3, 0.02, 0.4], "pose": [0.35, 0, 0]}],
                "joint": {
                    "type": "revolute",
                    "name": "hinge",
                    "pose_in_parent": {"p": [0.05, 0, 0], "q": [0.7071067811865476, 0, -0.7071067811865476, 0]},
                    "pose_in_child": {"q": [0.7071067811865476, 0, -0.7071067811865476, 0]},
                    "limits": [-1, 2],
                },
            }
        ],
    },
    "drives": {"hinge": {"stiffness": 5, "damping": 2, "force_limit": 100, "target": 1.5}},
    "joints": {"hinge": {"friction": 0.1}},
    "qpos": [0.3],
}


def _door(scene: Any) -> None:
    import sapien

    builder = scene.create_articulation_builder()
    frame = builder.create_link_builder()
    frame.set_name("frame")
    frame.add_box_collision(half_size=[0.05, 0.05, 0.5])
    panel = builder.create_link_builder(frame)
    panel.set_name("panel")
    panel.add_box_collision(sapien.Pose([0.35, 0, 0]), half_size=[0.3, 0.02, 0.4])
    panel.set_joint_name("hinge")
    upright = [0.7071067811865476, 0, -0.7071067811865476, 0]
    panel.set_joint_properties("revolute", [[-1, 2]], sapien.Pose([0.05, 0, 0], upright), sapien.Pose(q=upright))
    builder.initial_pose = sapien.Pose([0, 0, 1])
    door = builder.build("door", fix_root_link=True)
    hinge = door.joints_map["hinge"]
    hinge.set_drive_properties(5, 2, force_limit=100, mode="force")
    hinge.set_friction(0.1)
    for joint in hinge._objs:
        joint.set_drive_target(1.5)
    door.set_qpos(np.array([0.3], np.float32))


def _facts(scene: Any) -> LiveObject:
    return read_scene(scene.sub_scenes[0])


def test_a_tree_of_links_is_that_of_maniskills_own_builder_and_moves_as_it_does() -> None:
    scene, by_hand = new_scene(), new_scene()
    loaded = scenecc.load_scene({"scenecc": 1, "entities": {"door": DOOR}}, scene=scene)
    _door(by_hand)
    assert differences(_facts(by_hand), _facts(scene)) == []
    ours, theirs = loaded.articulations["door"], by_hand.articulations["door"]
    assert scene.articulations == {"door": ours}
    assert list(scene.state_dict_registry.articulations) == ["door"]
    assert [link.name for link in ours.links] == [link.name for link in theirs.links] == ["frame", "panel"]
    assert list(ours.joints_map) == list(theirs.joints_map)
    assert list(ours.active_joints_map) == ["hinge"]
    assert (ours.get_state() == theirs.get_state()).all()
    assert first_difference(trajectory(by_hand.sub_scenes[0], STEPS), trajectory(scene.sub_scenes[0], STEPS)) is None


PANDA = {
    "urdf": "pkg://mani_skill/assets/robots/panda/panda_v2.urdf",
    "sapien_bits": True,
    "pose": [-0.615, 0, 0],
    "qpos": [0, 0.4, 0, -2, 0, 2.4, 0.8, 0.04, 0.04],
    "drives": {"panda_.*": {"stiffness": 1000, "damping": 100, "force_limit": 100, "target": 0}},
    "joints": {"panda_.*": {"friction": 0, "max_velocity": 100}},  # the URDF's limits are what SAPIEN drops
    "gravity": False,
    "links": {"panda_.*finger": {"material": "gripper", "patch_radius": 0.1, "min_patch_radius": 0.1}},
}
MATERIALS = {"gripper": {"physical": {"static_friction": 2, "dynamic_friction": 2, "restitution": 0}}}


def test_a_robot_of_a_file_is_what_maniskills_agent_loads_and_moves_as_it_does() -> None:
    import sapien
    from mani_skill.agents.robots.panda.panda import Panda

    scene, by_hand = new_scene(), new_scene()
    document = {"scenecc": 1, "entities": {"panda": PANDA}, "materials": MATERIALS}
    loaded = scenecc.load_scene(document, scene=scene)
    agent = Panda(by_hand, 20, initial_pose=sapien.Pose([-0.615, 0, 0]))
    agent.robot.set_qpos(np.array(PANDA["qpos"], np.float32))
    assert differences(_facts(by_hand), _facts(scene)) == []
    ours, theirs = loaded.articulations["panda"], agent.robot
    assert [link.name for link in ours.links] == [link.name for link in theirs.links]
    assert [joint.name for joint in ours.active_joints] == [joint.name for joint in theirs.active_joints]
    assert first_difference(trajectory(by_hand.sub_scenes[0], STEPS), trajectory(scene.sub_scenes[0], STEPS)) is None


def test_starts_are_drawn_again_only_in_reset_environments() -> None:
    door = {**DOOR, "qpos": [{"uniform": [-0.5, 0.5]}], "pose": [0, 0, {"uniform": [1, 2]}]}
    document = {"scenecc": 1, "num_scenes": 3, "entities": {"door": door}}
    loaded = scenecc.load_scene(document, scene=new_scene(3))
    robots = loaded.articulations["door"]._objs

    def starts() -> np.ndarray:
        return np.array(
            [[*robot.qpos, robot.root_pose.p[2], robot.get_active_joints()[0].drive_target[0]] for robot in robots]
        )

    loaded.initialize(seed=[5, 6, 7])
    first = starts()
    with scenecc.load_scene(document, render=False) as batch:
        batch.reset(seed=[5, 6, 7])
        assert (first[:, :1] == batch.articulations["door"].qpos).all()
    loaded.initialize([1], seed=8)
    second = starts()
    assert (second[[0, 2]] == first[[0, 2]]).all()
    assert (second[1, :2] != first[1, :2]).all()
    assert (second[:, 2] == 1.5).all()


def test_links_that_differ_are_one_merged_view_in_scene_order() -> None:
    files = ["panda_v2.urdf", "panda_stick.urdf", "panda_v2.urdf"]
    urdf = {"per_scene": [f"pkg://mani_skill/assets/robots/panda/{file}" for file in files]}
    loaded = scenecc.load_scene({"scenecc": 1, "entities": {"arm": {"urdf": urdf}}}, scene=new_scene(3))
    view, scene = loaded.articulations["arm"], loaded.scene
    assert view.merged
    assert view is scene.articulation_views["arm"]
    assert list(scene.state_dict_registry.articulations) == ["arm"]
    assert list(scene.articulations) == ["arm-0", "arm-1", "arm-2"]
    assert view.dof.tolist() == [9, 7, 9]
    assert view._scene_idxs.tolist() == [0, 1, 2]


def test_a_robot_that_differs_between_scenes_is_one_merged_view() -> None:
    urdf = "pkg://mani_skill/assets/robots/panda/panda_v2.urdf"
    arm = {"urdf": urdf, "scale": {"cycle": [1, 0.5]}, "fix_root_link": "${scene < 3}", "qpos": {"panda_joint4": -2}}
    loaded = scenecc.load_scene({"scenecc": 1, "entities": {"arm": arm}}, scene=new_scene(4))
    view = loaded.articulations["arm"]
    assert view.merged
    roots = [articulation.links[0].get_joint().type for articulation in view._objs]
    assert roots == ["fixed", "fixed", "fixed", "undefined"]
    heights = view.links_map["panda_link2"].pose.p[:, 2].tolist()
    assert heights == pytest.approx([0.333, 0.1665, 0.333, 0.1665])


def test_constraints_hold_in_an_environment() -> None:
    weld = {"type": "weld", "parent": "door/panel", "child": "knob"}
    entities = {"door": DOOR, "knob": {"shapes": [{"type": "sphere", "radius": 0.02}], "pose": [0.7, 0, 1]}}
    document = {"scenecc": 1, "entities": entities, "constraints": {"bond": weld}}
    loaded = scenecc.load_scene(document, scene=new_scene())
    panel = loaded.articulations["door"].links_map["panel"]._objs[0]
    knob = loaded.actors["knob"]._objs[0]
    apart = (panel.entity_pose.inv() * knob.pose).p
    for _ in range(100):
        loaded.scene.sub_scenes[0].step()
    assert panel.entity_pose.p[2] == pytest.approx(1, abs=1e-3)
    assert (panel.entity_pose.inv() * knob.pose).p == pytest.approx(apart, abs=2e-3)


def test_a_finger_is_coupled_for_the_substeps_of_the_environment() -> None:
    """ManiSkill's settings make the same tendon as a scene of its own with the same settings."""

    def link(name: str, joint: dict[str, Any], children: list[Any]) -> dict[str, Any]:
        shapes = [{"type": "box", "half_size": [0.1, 0.02, 0.02], "pose": [0.1, 0, 0]}]
        full = {"type": "revolute", "axis": [0, 1, 0], "friction": 0, **joint}
        return {"name": name, "joint": full, "shapes": shapes, "children": children}

    tip = link("tip", {"name": "curl", "origin": {"p": [0.2, 0, 0]}, "mimic": {"joint": "bend"}}, [])
    palm = {
        "name": "palm",
        "shapes": [{"type": "sphere", "radius": 0.02}],
        "children": [link("upper", {"name": "bend"}, [tip])],
    }
    hand = {"fix_root_link": True, "root": palm, "drives": {"bend": {"stiffness": 50, "damping": 2}}}
    scene = new_scene()
    ours = scenecc.load_scene({"scenecc": 1, "entities": {"hand": hand}}, scene=scene)
    iterations = ours.articulations["hand"]._objs[0].solver_position_iterations
    physics = {"timestep": scene.timestep, "solver_position_iterations": iterations}
    alone = scenecc.load_scene({"scenecc": 1, "physics": physics, "entities": {"hand": hand}}, render=False)
    assert first_difference(trajectory(alone.scenes[0], STEPS), trajectory(scene.sub_scenes[0], STEPS)) is None


def test_a_joint_rests_beyond_a_turn_and_another_has_a_friction_force() -> None:
    inertial = {"mass": 1, "inertia": [0.02, 0.02, 0.02]}
    joints = [{"name": "far", "type": "continuous"}, {"name": "rough", "type": "prismatic", "friction_force": 5}]
    children = [{"name": joint["name"], "inertial": inertial, "joint": joint | {"axis": "z"}} for joint in joints]
    entity = {
        "fix_root_link": True,
        "gravity": False,
        "root": {"name": "base", "inertial": inertial, "children": children},
        "drives": {"far": {"stiffness": 20, "damping": 2, "target": 7}},
    }
    scene = new_scene()
    load_into(scene, {"scenecc": 1, "entities": {"rig": entity}})
    rig = scene.articulations["rig"]._objs[0]
    names = [joint.name.rpartition("_")[2] for joint in rig.active_joints]
    for _ in range(STEPS):
        rig.qf = np.where(np.array(names) == "rough", 4.9, 0.0).astype(np.float32)
        scene.sub_scenes[0].step()
    found = dict(zip(names, rig.qpos.tolist(), strict=True))
    assert found == {"far": pytest.approx(7, abs=0.01), "rough": pytest.approx(0, abs=1e-5)}
