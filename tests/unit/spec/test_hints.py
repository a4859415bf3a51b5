"""What is said of mistakes that newcomers make, once for each of them."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc import SceneError, compile_scene, validate

BALL: dict[str, Any] = {"type": "sphere", "radius": 1}
SHAPES = {"shapes": [BALL]}


def told(document: dict[str, Any]) -> list[tuple[str, str, str]]:
    found = validate({"scenecc": 1, "num_scenes": 2, **document})
    return [(one.code, one.path, one.hint or "") for one in found]


@pytest.mark.parametrize(
    ("entity", "code", "path", "hint"),
    [
        ("obj.yaml", "SC103", "", "`{use: obj.yaml}`"),
        ({"uses": "obj.yaml"}, "SC101", ".uses", "`use: obj.yaml`"),
        ({"variants": [SHAPES]}, "SC102", "", "`pick: {cycle: [0, 1]}`"),
        ({"mass": {"normal": {"mean": 0.1, "std": 0.01}}, **SHAPES}, "SC103", ".mass.normal", ""),
        ({"pose": {"uniform": [[0, 0], [1, 1]]}, **SHAPES}, "SC106", ".pose.uniform", ""),
        ({"mass": {"randint": [1, 2]}, **SHAPES}, "SC103", ".mass", "`{integers: [1, 2]}`"),
        ({"mass": {"gamma": [1, 2]}, **SHAPES}, "SC103", ".mass", "is a form: `{uniform: [low, high]}`"),
        ({"mass": "${1 > 2 ? 3 : 4}", **SHAPES}, "SC118", ".mass", "`a if condition else b`"),
        ({"mass": "${if 1 > 2 then 3}", **SHAPES}, "SC118", ".mass", "`3 if 1 > 2 else c`"),
        ({"linear_damping": "5 min", **SHAPES}, "SC103", ".linear_damping", "write it in 1/s"),
        ({"linear_velocity": ["1 m", 0, 0], **SHAPES}, "SC103", ".linear_velocity[0]", "write it in m/s"),
        ({"mass": {"uniform": ["1 m", 2]}, **SHAPES}, "SC103", ".mass.uniform[0]", "write a mass in kg"),
        ({"mass": {"uniform": ["1 g", 2]}, **SHAPES}, "SC103", ".mass.uniform[0]", "`0.001`"),
        ({"pose": "1,2 3", **SHAPES}, "SC103", ".pose", "points for decimals"),
        (
            {"place": {"on": "world", "region": {"x": [0, 1], "y": [2, 3]}}, **SHAPES},
            "SC103",
            ".place.region",
            "`region: [[0, 2], [1, 3]]`",
        ),
        (
            {"shapes": [{**BALL, "emission": [1, 0, 0]}]},
            "SC101",
            ".shapes[0].emission",
            "`material: {visual: {emission: [1, 0, 0]}}`",
        ),
        (
            {"shapes": [{**BALL, "visual": {"roughness": 0.5}}]},
            "SC101",
            ".shapes[0].visual",
            "`material: {visual: {roughness: 0.5}}`",
        ),
        ({"mass": "${2^3}", **SHAPES}, "SC118", ".mass", "`a ** b`"),
        ({"body_type": {"choice": ["static", "dynamic"]}, **SHAPES}, "SC116", ".body_type", "`variants`"),
        ({"shapes": [{**BALL, "type": {"choice": ["box", "sphere"]}}]}, "SC116", ".shapes[0].type", "`variants`"),
        ({"shapes": [{**BALL, "type": "${t}"}]}, "SC116", ".shapes[0].type", "`variants`"),
        ({"urdf": "a.urdf", "mjcf": "a.xml"}, "SC101", ".mjcf", "one of `urdf`, `mjcf` and `root`"),
        ({"urdf": "a.urdf", **SHAPES}, "SC101", ".shapes", "`root: {name: base, shapes: [{type: sphere, radius: 1}]}`"),
        ({"urdf": "a.urdf", "mass": 2}, "SC101", ".mass", "`links: {NAME: {mass: 2}}`"),
        (
            {"urdf": "a.urdf", "collision_is_visual": {"cycle": [True, False]}},
            "SC116",
            ".collision_is_visual",
            "an entity for each value, with `scene_idxs`",
        ),
        (
            {"root": {"name": "a"}, "disable_self_collisions": {"choice": [True, False]}},
            "SC116",
            ".disable_self_collisions",
            "`scene_idxs`",
        ),
        ({"urdf": "a.urdf", "static": True}, "SC101", ".static", "`body_type: static`"),
        ({"urdf": "a.urdf", "stiffness": 9}, "SC101", ".stiffness", '`drives: {".*": {stiffness: 9}}`'),
        (
            {"urdf": "a.urdf", "joints": {"j": {"stiffness": 9}}},
            "SC101",
            ".joints.j.stiffness",
            "`drives: {j: {stiffness: 9}}`",
        ),
        ({"place": {"on": "a", "beside": "a"}, **SHAPES}, "SC101", ".place.beside", "`next_to: {of: a, side: left"),
        ({"root": {"name": "a", "pose": [0, 0, 1]}}, "SC101", ".root.pose", "beside `root`"),
        (
            {"root": {"name": "a", "children": [{"name": "b", "pose": [0, 0, 1], "joint": {"type": "fixed"}}]}},
            "SC101",
            ".root.children[0].pose",
            "`joint: {origin: …}`",
        ),
        ({"uid": "panda"}, "SC101", ".uid", "`{use: scenecc:table_scene, with: {robot: panda}}`"),
        ({"urdf": "a.urdf", "position": [0, 0, 1]}, "SC101", ".position", "`pose`"),
        (
            {"shapes": [{"type": "cylinder", "radius": 1, "half_length": 1, "height": 2}]},
            "SC101",
            ".shapes[0].height",
            "`half_length: 1`, half of that",
        ),
    ],
    ids=str,
)
def test_a_mistake_in_an_entity_is_told_once(entity: Any, code: str, path: str, hint: str) -> None:
    draws = {"t": {"choice": ["box", "sphere"]}} if "${t}" in str(entity) else {}
    ((found_code, found_path, found_hint),) = told({"draws": draws, "entities": {"a": entity}})
    assert (found_code, found_path) == (code, f"entities.a{path}")
    assert hint in found_hint


@pytest.mark.parametrize(
    ("section", "written", "code", "key", "hint"),
    [
        ("cameras", {"look_at": [0, 0, 0]}, "SC101", "look_at", "`pose: {look_at: [0, 0, 0]}`"),
        ("cameras", {"fovy": -1}, "SC104", "fovy", "write `fovy: 1`, without the minus"),
        ("lights", {"type": "spot", "color": [1, 1, 1], "outer_fov": 60}, "SC104", "outer_fov", "`outer_fov_deg: 60`"),
        (
            "constraints",
            {"type": "hinge", "parent": "world", "child": "b", "damping": 1},
            "SC101",
            "damping",
            "`drive: {",
        ),
    ],
    ids=str,
)
def test_a_mistake_in_what_is_seen_is_told_once(section: str, written: Any, code: str, key: str, hint: str) -> None:
    ((found_code, path, found_hint),) = told({section: {"a": written}})
    assert (found_code, path) == (code, f"{section}.a.{key}")
    assert hint in found_hint if hint else not found_hint


@pytest.mark.parametrize("physics", [{"timestep": {"uniform": [0.01, 0.02]}}, {"sdf": {"choice": [{}, {}]}}], ids=str)
def test_nothing_under_physics_differs(physics: dict[str, Any]) -> None:
    ((code, _, hint),) = told({"physics": physics, "entities": {"a": {"body_type": "static", **SHAPES}}})
    assert code == "SC116"
    assert "`physics` are the same in all scenes" in hint


def test_what_is_included_stands_in_a_list() -> None:
    ((code, path, hint),) = told({"include": "obj.yaml", "entities": {}})
    assert (code, path) == ("SC103", "include")
    assert "`include: [obj.yaml]`" in hint


def test_a_list_that_is_multiplied_repeats() -> None:
    draws = {"v": {"uniform": [[0, 0, 0], [1, 1, 1]]}}
    with pytest.raises(SceneError, match=r"multiply each component"):
        compile_scene({"scenecc": 1, "draws": draws, "entities": {"a": {"pose": "${v * 2}", **SHAPES}}})


def test_the_bare_name_of_a_robot_in_maniskills_package_gives_its_path() -> None:
    for name in ("panda", "Panda.urdf"):
        (found,) = validate({"scenecc": 1, "entities": {"arm": {"urdf": name}}})
        assert found.hint is not None
        assert found.hint.startswith("write `pkg://mani_skill/assets/robots/panda/panda_v2.urdf`")
