"""Articulations in plans: what is said of links and joints, where joints start, which links ignore one another."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from scenecc import compile_scene, validate
from scenecc.lower.articulations.overrides import PatternMatcher
from scenecc.plan import ArticulationStructure, Joint, Link
from scenecc.plan.properties import FLOAT32_MAX, property_fields
from scenecc.variation.nodes import AffineClamp

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.plan import ScenePlan, Value

BOX = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]


def tree(*joints: dict[str, Any], chain: bool = False) -> dict[str, Any]:
    """A root and a link for each joint, all on the root or each on the one before."""
    root: dict[str, Any] = {"name": "root", "shapes": BOX, "children": []}
    at = root
    for number, joint in enumerate(joints):
        link: dict[str, Any] = {"name": f"l{number}", "joint": joint, "shapes": BOX, "children": []}
        at["children"].append(link)
        at = link if chain else at
    return root


def hinge(name: str = "hinge", **keys: Any) -> dict[str, Any]:
    return {"name": name, "type": "revolute", **keys}


def scene(num_scenes: int = 1, **keys: Any) -> dict[str, Any]:
    return {"scenecc": 1, "num_scenes": num_scenes, "entities": {"door": {"root": tree(hinge()), **keys}}}


def structure(plan: ScenePlan, entity: int = 0) -> ArticulationStructure:
    found = plan.entities[entity].structures[0]
    assert isinstance(found, ArticulationStructure)
    return found


def joints(plan: ScenePlan, entity: int = 0) -> dict[str, Joint]:
    return {link.joint.name: link.joint for link in structure(plan, entity).links if link.joint is not None}


def links(plan: ScenePlan, entity: int = 0) -> dict[str, Link]:
    return {link.name: link for link in structure(plan, entity).links}


def rows(value: Value | None) -> list[Any]:
    assert value is not None
    return value.data.tolist()


def codes(data: dict[str, Any]) -> list[str]:
    return [found.code for found in validate(data)]


def test_links_stand_in_the_order_of_the_file_each_after_its_parent() -> None:
    root = tree(hinge("a"), hinge("b"))
    root["children"][0]["children"] = tree(hinge("c"))["children"]
    root["children"][0]["children"][0]["name"] = "below"
    found = structure(compile_scene({"scenecc": 1, "entities": {"door": {"root": root}}}))
    assert [(link.name, link.parent) for link in found.links] == [("root", None), ("l0", 0), ("below", 1), ("l1", 0)]


def test_a_list_of_positions_is_in_the_order_of_sapien() -> None:
    root = tree(hinge("a"), hinge("b"))
    root["children"][0]["children"] = [{**tree(hinge("c"))["children"][0], "name": "below"}]
    plan = compile_scene({"scenecc": 1, "entities": {"door": {"root": root, "qpos": [1, 2, 3]}}})
    assert {name: rows(joint.qpos) for name, joint in joints(plan).items()} == {"a": [1.0], "b": [2.0], "c": [3.0]}


def test_what_is_left_out_stays_out() -> None:
    joint = joints(compile_scene(scene()))["hinge"]
    assert joint.qpos is joint.qvel is joint.drive_target is joint.stiffness is joint.friction is joint.damping is None
    assert rows(joint.limits) == [[-np.inf, np.inf]]
    assert not structure(compile_scene(scene())).fix_root_link


def test_a_drive_holds_the_start_as_one_value_and_again_at_a_reset() -> None:
    data = scene(3, qpos=[{"uniform": [0.1, 0.2]}], drives={"hin.*": {"stiffness": 10}})
    joint = joints(compile_scene(data))["hinge"]
    assert joint.drive_target is joint.qpos
    assert joint.qpos is not None
    assert joint.qpos.recipe is not None
    assert (rows(joint.stiffness), rows(joint.damping), joint.force_limit) == ([10.0], [0.0], None)


def test_of_several_patterns_the_later_counts_key_by_key_and_what_a_link_says_itself_before_all() -> None:
    root = tree(hinge("a"), hinge("b"))
    root["children"][1]["linear_damping"] = 0.7
    data = {"scenecc": 1, "entities": {"door": {
        "root": root,
        "links": {".*": {"linear_damping": 0.1, "angular_damping": 0.2}, "l[01]": {"linear_damping": 0.3}},
        "joints": {"a|b": {"friction": 1}, "b": {"armature": 2}},
        "drives": {".*": {"stiffness": 1, "damping": 2}, "a": {"damping": 3}},
    }}}  # fmt: skip
    plan = compile_scene(data)
    bodies = [link.body for link in structure(plan).links]
    assert [rows(body.linear_damping) for body in bodies] == [[0.1], [0.3], [0.7]]
    assert bodies[0].angular_damping is bodies[1].angular_damping
    found = joints(plan)
    assert [rows(joint.damping) for joint in found.values()] == [[3.0], [2.0]]
    assert (rows(found["b"].friction), rows(found["b"].armature), found["a"].armature) == ([1.0], [2.0], None)


def test_a_joint_of_a_tree_says_its_own_speed() -> None:
    def tree(**keys: Any) -> dict[str, Any]:
        link = {"name": "l", "joint": {"name": "j", "type": "revolute", **keys}, "shapes": BOX}
        return {"root": {"name": "base", "children": [link]}}

    document = {"scenecc": 1, "num_scenes": 2, "entities": {
        "plain": tree(max_velocity=2),
        "drawn": tree(max_velocity={"cycle": [1, 3]}),
        "matched": {**tree(max_velocity=2), "joints": {"j": {"max_velocity": 5}}},
    }}  # fmt: skip
    plan = compile_scene(document)
    assert [rows(joints(plan, number)["j"].max_velocity) for number in range(3)] == [[2.0], [1.0, 3.0], [5.0]]
    assert codes({"scenecc": 1, "entities": {"a": tree(type="fixed", max_velocity=2)}}) == ["SC115"]


@pytest.mark.parametrize("field", property_fields("joint"))
def test_every_number_of_a_joint_is_a_key_of_a_tree(field: str) -> None:
    link = {"name": "l", "joint": {"name": "j", "type": "revolute", field: 2}, "shapes": BOX}
    plan = compile_scene({"scenecc": 1, "entities": {"a": {"root": {"name": "base", "children": [link]}}}})
    assert rows(getattr(joints(plan)["j"], field)) == [2.0]


def test_what_is_drawn_is_held_within_the_limits_and_so_is_its_recipe() -> None:
    data = scene(50, qpos=[{"uniform": [-3, 3]}], joints={"hinge": {"limits": [-1, {"per_scene": [1] * 49 + [2]}]}})
    joint = joints(compile_scene(data))["hinge"]
    assert joint.qpos is not None
    positions = joint.qpos.data
    assert positions.min() == -1
    assert (positions[:49] == 1).any()
    assert (positions[:49] <= 1).all()
    again = compile_scene(data, seed=7)
    drawn = joints(again)["hinge"].qpos
    assert drawn is not None
    assert (drawn.data[:49] <= 1).all()
    assert not np.array_equal(drawn.data, positions)


def test_a_position_beyond_a_limit_is_taken_as_it_is_where_the_file_says_so() -> None:
    limits = {"hinge": {"limits": [-1, 1]}}
    assert codes(scene(qpos=[1.5], joints=limits)) == ["SC517"]
    assert codes(scene(2, qpos=[{"per_scene": [0, -3]}], joints=limits)) == ["SC517"]
    written = joints(compile_scene(scene(qpos=[1.5], joints=limits, beyond_limits=True)))["hinge"]
    assert rows(written.qpos) == [1.5]
    by_scene = scene(2, qpos=[{"per_scene": [0, -3]}], joints=limits, beyond_limits=True)
    assert rows(joints(compile_scene(by_scene))["hinge"].qpos) == [0.0, -3.0]
    data = scene(50, qpos=[{"uniform": [-3, 3]}], joints=limits, beyond_limits=True)
    drawn = joints(compile_scene(data))["hinge"].qpos
    free = joints(compile_scene(scene(50, qpos=[{"uniform": [-3, 3]}])))["hinge"].qpos
    assert max(rows(drawn)) > 2
    assert rows(drawn) == rows(free)


def aimed(target: Any, limits: Any = (-1, 1), *, num_scenes: int = 2, **keys: Any) -> dict[str, Any]:
    drives = {"hinge": {"stiffness": 1, "target": target}}
    return scene(num_scenes, joints={"hinge": {"limits": limits}}, drives=drives, **keys)


BEYOND: dict[str, tuple[dict[str, Any], str | None]] = {
    "within": (aimed(1), None),
    "a rounded limit": (aimed(1.0000005), None),
    "above": (aimed(90), "pulls to 90, beyond its limits [-1, 1]"),
    "below": (aimed(-1.1), "pulls to -1.1, beyond its limits [-1, 1]"),
    "by scene": (aimed({"per_scene": [0, 2]}), "pulls to 2 in scene 1, beyond its limits [-1, 1]"),
    "limits by scene": (
        aimed(1, {"per_scene": [[-2, 2], [-2, 0.5]]}),
        "pulls to 1 in scene 1, beyond its limits [-2, 0.5]",
    ),
    "both by scene": (aimed({"per_scene": [2, 0]}, {"per_scene": [[-2, 2], [-1, 1]]}), None),
    "drawn": (aimed({"uniform": [0, 3]}), "may pull to 3, beyond its limits [-1, 1]"),
    "drawn within": (aimed({"uniform": [-1, 1]}), None),
    "one of several": (aimed({"choice": [0, -3]}), "may pull to -3, beyond its limits [-1, 1]"),
    "without bounds": (aimed({"normal": [0, 0.1]}), None),
    "limits that are drawn": (aimed(2.5, [-1, {"uniform": [1, 2]}]), "may pull to 2.5, beyond its limits [-1, 2]"),
    "between them": (aimed(1.5, [-1, {"uniform": [1, 2]}]), None),
    "an expression": (
        {**aimed("${2 * x}"), "draws": {"x": {"uniform": [0, 1]}}},
        "may pull to 1.99849, beyond its limits [-1, 1]",
    ),
    "meant": (aimed(90, beyond_limits=True), None),
    "no limits": (aimed(90, [-np.inf, np.inf]), None),
    "more scenes than could be drawn": (aimed({"cycle": [0, 2]}, num_scenes=65_536), "to 2"),
}


@pytest.mark.parametrize(("data", "words"), BEYOND.values(), ids=BEYOND)
def test_a_drive_that_pulls_beyond_a_limit_is_a_warning(data: dict[str, Any], words: str | None) -> None:
    found = [f for f in validate(data) if f.code != "SC518"]
    assert [(f.code, f.severity) for f in found] == [("SC523", "warning")] * (words is not None)
    for one in found:
        assert words is not None
        assert words in one.message
        assert one.path == "entities.door.drives.hinge.target"
        assert "beyond_limits: true" in str(one.hint)


def test_a_target_that_a_pattern_gives_to_several_joints_is_told_once() -> None:
    root = tree(hinge("a"), hinge("b"), hinge("c", limits=[-9, 9]))
    data = {"root": root, "joints": {"[ab]": {"limits": [0, 1]}}, "drives": {".": {"target": 5}}}
    found = validate({"scenecc": 1, "entities": {"door": data}})[0]
    assert found.message == "the drive of `a` pulls to 5, beyond its limits [0, 1]"
    # What a drive holds that says no target is where the joint starts, and of that `qpos` tells.
    held = scene(qpos=[2], joints={"hinge": {"limits": [0, 1]}}, drives={"hinge": {}}, beyond_limits=True)
    assert codes(held) == []


def test_a_joint_that_follows_starts_where_it_follows_the_other_at() -> None:
    root = tree(hinge("a"), hinge("b", mimic={"joint": "a", "multiplier": -2, "offset": 0.5}))
    found = joints(compile_scene({"scenecc": 1, "entities": {"door": {"root": root, "qpos": {"a": 0.1}}}}))
    assert rows(found["b"].qpos) == [-2 * 0.1 + 0.5]
    data = {"scenecc": 1, "num_scenes": 4, "entities": {"door": {"root": root, "qpos": {"a": {"uniform": [0, 1]}}}}}
    found = joints(compile_scene(data))
    a, b = found["a"].qpos, found["b"].qpos
    assert a is not None
    assert b is not None
    assert np.array_equal(b.data, -2 * a.data + 0.5)
    assert b.recipe is not None


@pytest.mark.parametrize(
    ("joint", "limits", "at"),
    [(hinge(limits=[0.2, 1]), [0.2, 1], 0.2), (hinge(limits_deg=[-90, -45]), None, -np.pi / 4)],
)
def test_a_joint_that_cannot_start_at_0_starts_at_the_nearest_limit_with_a_warning(
    joint: dict[str, Any], limits: list[float] | None, at: float
) -> None:
    data = {"scenecc": 1, "entities": {"door": {"root": tree(joint)}}}
    assert codes(data) == ["SC518"]
    found = joints(compile_scene(data))["hinge"]
    assert rows(found.qpos) == [at]
    assert limits is None or rows(found.limits) == [limits]


def test_the_axis_turns_the_joint_in_both_frames_by_the_shortest_rotation() -> None:
    data = {"scenecc": 1, "entities": {"door": {"root": tree(hinge(origin=[1, 0, 0], axis="y"))}}}
    joint = joints(compile_scene(data))["hinge"]
    half = np.sqrt(0.5)
    assert np.allclose(rows(joint.pose_in_parent), [[1, 0, 0, half, 0, 0, half]])
    assert np.allclose(rows(joint.pose_in_child), [[0, 0, 0, half, 0, 0, half]])
    varying = {"cycle": [[0, 1, 0], [1, 0, 0]]}
    data = {"scenecc": 1, "num_scenes": 2, "entities": {"door": {"root": tree(hinge(origin=[1, 0, 0], axis=varying))}}}
    joint = joints(compile_scene(data))["hinge"]
    assert np.allclose(rows(joint.pose_in_parent), [[1, 0, 0, half, 0, 0, half], [1, 0, 0, 1, 0, 0, 0]])


def test_each_articulation_whose_links_ignore_one_another_has_an_id_of_its_own() -> None:
    entities = {
        name: {"root": tree(hinge()), "disable_self_collisions": True, **keys}
        for name, keys in {"a": {}, "b": {}, "c": {"disable_self_collisions": False}, "d": {}}.items()
    }
    plan = compile_scene({"scenecc": 1, "entities": entities})
    ignoring = [links(plan, i)["root"].body.collision_groups for i in range(4)]
    assert [groups and rows(groups) for groups in ignoring] == [
        [[1, 1, 1 << 29, 0]], [[1, 1, 1 << 29, 1]], None, [[1, 1, 1 << 29, 2]],
    ]  # fmt: skip
    entities["b"]["sapien_bits"] = True
    plan = compile_scene({"scenecc": 1, "entities": entities})
    ids = [rows(links(plan, i)["root"].body.collision_groups)[0][3] for i in (0, 1, 3)]
    assert ids == [1, 0, 2]


def test_a_mass_scales_what_a_file_says_and_is_drawn_once_for_all_that_a_pattern_matches() -> None:
    data = scene(3, links={"l0|root": {"mass": {"uniform": [1, 2]}}})
    found = links(compile_scene(data))
    assert found["root"].body.mass is found["l0"].body.mass
    assert found["root"].body.inertial is None


def test_drawn_limits_hold_what_is_drawn_and_resets_are_held_by_those_that_they_draw() -> None:
    data = scene(20, qpos=[{"uniform": [0, 9]}], joints={"hinge": {"limits": [0, {"uniform": [1, 2]}]}})
    joint = joints(compile_scene(data))["hinge"]
    assert joint.qpos is not None
    assert joint.limits is not None
    assert (joint.qpos.data <= joint.limits.data[:, 1]).all()
    recipe: Any = joint.qpos.recipe
    assert recipe.high == AffineClamp(joint.limits.recipe, 1, -FLOAT32_MAX, FLOAT32_MAX)


def test_one_bound_stands_for_all_joints_of_which_each_is_drawn_by_itself() -> None:
    root = tree(hinge("a"), hinge("b"))
    data = {"scenecc": 1, "num_scenes": 3, "entities": {"door": {"root": root, "qpos": {"normal": [[0, 5], 0.02]}}}}
    found = joints(compile_scene(data))
    a, b = found["a"].qpos, found["b"].qpos
    assert a is not None
    assert b is not None
    assert (np.abs(a.data) < 0.2).all()
    assert (np.abs(b.data - 5) < 0.2).all()
    assert not np.allclose(a.data, b.data - 5)
    # The same numbers, written one by one.
    data["entities"]["door"]["qpos"] = [{"normal": [0, 0.02]}, {"normal": [5, 0.02]}]
    again = joints(compile_scene(data))["b"].qpos
    assert again is not None
    assert np.array_equal(again.data, b.data)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"qpos": {"uniform": [[0, 0], [1, 1]]}}, ["SC325"]),
        ({"qpos": {"per_scene": {"0": [1], "default": [1, 2]}}}, ["SC325"]),
        ({"qvel": {"hing": 1}}, ["SC325"]),
        ({"qpos": "${[0.1]}"}, []),
        ({"qpos": ["${scene + 0.5}"]}, []),
        ({"fix_root_link": True, "angular_velocity": [0, 0, 1]}, ["SC115"]),
        ({"drives": {"h.*": {"stiffness": -1}}}, ["SC104"]),
        ({"links": {"root": {"mass": 1, "inertial": {"mass": 1, "inertia": [1, 1, 1]}}}}, ["SC111"]),
    ],
)
def test_mistakes_are_told(keys: dict[str, Any], expected: list[str]) -> None:
    assert codes(scene(2, **keys)) == expected


def test_a_tree_inside_a_prefab_reads_its_parameters_and_stands_where_the_instance_does(tmp_path: Any) -> None:
    (tmp_path / "door.yaml").write_text(
        "scenecc: 1\nparams: {width: 0.4, stuff: {type: material, default: oak}}\n"
        "materials: {oak: {physical: {density: 100}}}\nentities:\n  leaf:\n    qpos: ['${width}']\n    root:\n"
        "      name: frame\n      shapes:\n"
        "        - {repeat: {i: [0, 1]}, type: sphere, radius: 0.1, pose: ['${i}', 0, 0]}\n"
        "      children:\n        - name: panel\n"
        "          joint: {name: hinge, type: revolute, origin: ['${width}', 0, 0]}\n"
        "          shapes: [{type: box, half_size: [0.1, 0.1, 0.1], material: '${stuff}'}]\n"
    )
    (tmp_path / "scene.yaml").write_text(
        "scenecc: 1\nnum_scenes: 2\nentities:\n  front:\n    use: door.yaml\n    pose: [1, 0, 0]\n    scene_idxs: [1]\n"
        "    with: {width: {uniform: [0.5, 0.6]}}\n"
    )
    plan = compile_scene(tmp_path / "scene.yaml")
    (entity,) = plan.entities
    assert (entity.name, entity.scene_idxs, rows(entity.pose)) == ("front/leaf", (1,), [[1, 0, 0, 1, 0, 0, 0]])
    found = links(plan)
    assert len(found["frame"].body.collisions) == 2
    joint = found["panel"].joint
    assert joint is not None
    assert rows(joint.qpos) == [rows(joint.pose_in_parent)[0][0]]
    assert rows(found["panel"].body.collisions[0].density) == [100.0]


def test_patterns_that_take_too_many_steps_together_are_an_error() -> None:
    joints = [hinge(f"j{number}_" + "a" * 250) for number in range(10)]
    drives = {f"j{number}_.*a.*a.*b": {"stiffness": 1} for number in range(10)}
    found = validate({"scenecc": 1, "entities": {"door": {"root": tree(*joints), "drives": drives}}})
    assert found[-1].code == "SC323"
    assert "1000000000 steps" in found[-1].message


def test_a_name_is_matched_with_a_pattern_once_however_many_copies_there_are() -> None:
    matching = PatternMatcher()
    for _ in range(10):
        assert matching.matches("j+", "j" * 1_000_000)
    assert not matching.exhausted


def test_of_a_centre_of_mass_and_an_inertial_the_later_pattern_wins() -> None:
    com, whole = {"com": [0.1, 0, 0]}, {"inertial": {"mass": 1, "inertia": [1, 1, 1]}}
    moved = links(compile_scene(scene(links={".*": whole, "l0": com})))["l0"].body
    assert rows(moved.com) == [[0.1, 0, 0]]
    assert moved.inertial is not None
    given = links(compile_scene(scene(links={".*": com, "l0": whole})))["l0"].body
    assert given.com is None
    assert given.inertial is not None


def test_a_robot_of_one_body_may_have_another_file_in_each_scene(tmp_path: Path) -> None:
    solid = "<collision><geometry><box size='1 1 1'/></geometry></collision>"
    lone = f"<link name='a'>{solid}</link>"
    joined = (
        f"{lone}<link name='b'>{solid}</link><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"
    )
    for name, text in (("one", lone), ("two", joined)):
        (tmp_path / f"{name}.urdf").write_text(f"<robot name='r'>{text}</robot>")
    data: dict[str, Any] = {"urdf": {"cycle": ["one.urdf", "two.urdf"]}, "body_type": "static"}
    file = tmp_path / "scene.yaml"
    file.write_text(json.dumps({"scenecc": 1, "num_scenes": 2, "entities": {"a": data}}))
    (entity,) = compile_scene(file).entities
    assert [(type(one).__name__, len(one.bodies[0].collisions)) for one in entity.structures] == [
        ("BodyStructure", 1),
        ("BodyStructure", 2),
    ]


def test_the_friction_of_a_robot_as_one_body_is_no_loss(tmp_path: Path) -> None:
    file = tmp_path / "cabinet.urdf"
    box = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
    joint = '<parent link="a"/><child link="b"/><axis xyz="1 0 0"/><dynamics friction="5" damping="10"/>'
    joint += '<limit lower="0" upper="1" effort="1" velocity="1"/>'
    links = f'<link name="a">{box}</link><link name="b">{box}</link>'
    file.write_text(f'<robot name="cabinet">{links}<joint name="slide" type="prismatic">{joint}</joint></robot>')
    for body_type, codes in (({}, ["SC494"]), ({"body_type": "static"}, [])):
        found = validate(
            {"scenecc": 1, "entities": {"cabinet": {"urdf": str(file), **body_type}}}, asset_roots=[tmp_path]
        )
        assert [one.code for one in found if one.code in {"SC494", "SC495"}] == codes
