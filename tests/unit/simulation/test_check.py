"""`check_scene`: every kind of finding, at its place and with its scene, and scenes in which there is none."""

from __future__ import annotations

import json
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenecc import Diagnostic, check_scene

GROUND = {"body_type": "static", "shapes": [{"type": "plane"}]}
BOX = {"shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]}


def scene(entities: dict[str, Any], **other: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": {"ground": GROUND, **entities}, **other}


def found(entities: dict[str, Any], settle: float = 1.0, **other: Any) -> list[Diagnostic]:
    return check_scene(scene(entities, **other), settle=settle)


def codes(diagnostics: list[Diagnostic]) -> list[str]:
    return [one.code for one in diagnostics]


def test_standing_and_upright_falling_bodies_have_no_findings() -> None:
    stack = {f"box_{i}": {"pose": [0, 0, 0.1 + 0.2 * i], **BOX} for i in range(3)}
    assert found({**stack, "falls": {"pose": [1, 0, 0.6], **BOX}}) == []


@pytest.mark.parametrize(
    ("shape", "depth"),
    [
        ({"type": "box", "half_size": [0.1, 0.1, 0.1]}, 0.02),
        ({"type": "sphere", "radius": 0.1}, 0.02),
        ({"type": "cylinder", "radius": 0.1, "half_length": 0.1}, 0.02),
    ],
)
def test_an_overlap_is_reported_with_its_depth(shape: dict[str, Any], depth: float) -> None:
    bodies = {"a": {"pose": [0, 0, 0.5], **BOX}, "b": {"pose": [0.2 - depth, 0, 0.5], "shapes": [shape]}}
    (one,) = found({name: {**body, "gravity": False} for name, body in bodies.items()}, settle=0)
    assert one.code == "SC850"
    assert one.message == "`a` and `b` overlap by 20 mm at the start, in scene 0"
    assert one.path == "entities.a"
    assert [related.message for related in one.related] == ["`b` is here"]


def test_an_overlap_with_a_plane_says_that_it_has_no_end() -> None:
    (one,) = found({"a": {"pose": [3, 0, -1], **BOX}}, settle=0)
    assert one.code == "SC850"
    assert "the plane of `ground` has no end, and all below it is solid" in str(one.hint)


def test_links_of_a_file_with_a_shape_twice_are_reported(tmp_path: Path) -> None:
    part = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
    joint = "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"
    inertial = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
    for given, expected in (("", ["SC546"]), (inertial, [])):
        links = f"<link name='a'>{part}</link><link name='b'>{given}{part}{part}</link>"
        (tmp_path / "r.urdf").write_text(f"<robot name='r'>{links}{joint}</robot>")
        (tmp_path / "s.yaml").write_text("scenecc: 1\nentities: {r: {urdf: r.urdf}}\n")
        assert [code for code in codes(check_scene(tmp_path / "s.yaml", settle=0)) if code == "SC546"] == expected


@pytest.mark.parametrize(
    ("keys", "expected"),
    [({}, ["SC589"]), ({"density": 0}, []), ({"density": 500}, []), ({"collision_bits": [0, 1, 0, 0]}, [])],
)
def test_a_shape_that_touches_nothing_has_no_mass_by_default(keys: dict[str, Any], expected: list[str]) -> None:
    handle = {
        "type": "box",
        "half_size": [0.02, 0.01, 0.03],
        "pose": [0.12, 0, 0],
        "collision_bits": [0, 0, 0, 0],
        **keys,
    }
    body = {"pose": [0, 0, 0.1], "shapes": [*BOX["shapes"], handle]}
    assert codes(found({"a": body}, settle=0)) == expected
    assert codes(found({"a": {**body, "mass": 1}}, settle=0)) == []


@pytest.mark.parametrize("gap", [-0.0004, 0, 0.001])
def test_touching_bodies_do_not_overlap(gap: float) -> None:
    assert found({"a": {"pose": [0, 0, 0.1 + gap], **BOX}}, settle=0) == []


def test_bodies_that_never_collide_do_not_overlap() -> None:
    a, b = ({"pose": [x, 0, 0.5], **BOX, "gravity": False, "collision_bits": [1, 1, 4, 7]} for x in (0, 0.01))
    assert found({"a": a, "b": b}, settle=0) == []
    assert codes(found({"a": a, "b": {**b, "collision_bits": [1, 1, 2, 7]}}, settle=0)) == ["SC850"]


def test_an_overlap_lists_its_scenes_and_shows_the_worst(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        "scenecc: 1\nnum_scenes: 4\nentities:\n"
        "  ground: {body_type: static, shapes: [{type: plane}]}\n"
        "  a: {pose: [0, 0, 0.1], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}\n"
        "  b:\n    pose: {per_scene: [[1, 0, 0.1], [0.19, 0, 0.1], [0.15, 0, 0.1], [0.5, 0, 0.1]]}\n"
        "    shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]\n"
    )
    (one,) = check_scene(file, settle=0)
    assert one.message == "`a` and `b` overlap by 50 mm at the start, in scenes 1, 2; worst in scene 2"
    assert one.line == 5
    assert one.hint == f"`scenecc view {file} --seed 0 --scene 2` shows it"


def test_each_seed_is_checked_and_named() -> None:
    moving = {"pose": {"p": [{"uniform": [0.1, 0.4]}, 0, 0.1]}, **BOX}
    document = scene({"a": {"pose": [0, 0, 0.1], **BOX}, "b": moving}, num_scenes=5)
    (one,) = check_scene(document, settle=0, seeds=range(4))
    text = one.message
    depths = {
        (seed, int(k)): 0.2 - abs(float(x)) for seed in range(4) for k, x in enumerate(_positions(document, seed))
    }
    deep = {key: depth for key, depth in depths.items() if depth > 0.0005}
    seed, index = max(deep, key=lambda key: deep[key])
    assert f"overlap by {deep[seed, index] * 1000:.3g} mm" in text
    assert text.endswith(f"in {len(deep)} scenes; worst in scene {index} with seed {seed}")


def _positions(document: dict[str, Any], seed: int) -> np.ndarray:
    from scenecc import compile_scene

    plan = compile_scene(document, seed=seed)
    return next(entity for entity in plan.entities if entity.name == "b").pose.data[:, 0]


def test_a_stream_is_checked_with_several_seeds() -> None:
    text = "scenecc: 1\nentities:\n  a: {shapes: [{type: sphere, radius: 0.1}]}\n"
    assert codes(check_scene(StringIO(text), settle=0, seeds=[0, 1])) == ["SC852"]


def test_a_body_above_nothing_falls_forever() -> None:
    shapes = [{"type": "sphere", "radius": 0.1}]
    table = {"body_type": "static", "pose": [0, 0, -1], "shapes": [{"type": "box", "half_size": [0.5, 0.5, 0.1]}]}
    document = {
        "scenecc": 1,
        "entities": {"table": table, "on": {"shapes": shapes}, "beside": {"pose": [2, 0, 0], "shapes": shapes}},
    }
    (one,) = check_scene(document, settle=0)
    assert (one.code, one.path) == ("SC852", "entities.beside")
    document["physics"] = {"gravity": [0, 0, 0]}
    assert check_scene(document) == []
    del document["physics"]
    document["entities"]["beside"]["gravity"] = False
    assert check_scene(document, settle=0) == []


def test_a_robot_is_not_supported_by_its_own_links() -> None:
    link = {"type": "box", "half_size": [0.1, 0.1, 0.1]}
    joint = {"type": "fixed", "origin": [0, 0, -0.5]}
    root = {"name": "top", "shapes": [link], "children": [{"name": "low", "joint": joint, "shapes": [link]}]}
    document = {"scenecc": 1, "entities": {"robot": {"root": root, "fix_root_link": False}}}
    assert codes(check_scene(document, settle=0)) == ["SC852"]
    document["entities"]["robot"]["fix_root_link"] = True
    assert check_scene(document, settle=0) == []


@pytest.mark.parametrize("weightless", [[], ["base"], ["base", "arm"]])
def test_a_robot_whose_root_has_no_shape_falls(weightless: list[str]) -> None:
    inertial = {"mass": 1, "inertia": [0.1, 0.1, 0.1]}
    arm: dict[str, Any] = {"name": "arm", "joint": {"type": "revolute", "limits": [-1, 1]}, **BOX}
    root: dict[str, Any] = {"name": "base", "inertial": inertial, "children": [arm]}
    for link in (root, arm):
        link.update({"gravity": False} if link["name"] in weightless else {})
    robot = {"root": root, "fix_root_link": False, "pose": [0, 0, 2]}
    expected = ["SC852"] if len(weightless) < 2 else []
    assert codes(check_scene({"scenecc": 1, "entities": {"robot": robot}}, settle=0)) == expected
    assert found({"robot": robot}, settle=0) == []


@pytest.mark.parametrize(
    ("constraint", "text"),
    [
        ({"type": "weld", "pose_in_child": [0, 0, 0], "pose_in_parent": [0, 0, 0.25]}, "its frames are 50 mm apart"),
        ({"type": "connection", "pose_in_child": [0, 0, 0], "pose_in_parent": [0, 0, 0.25]}, "50 mm apart"),
        ({"type": "distance", "limits": [0, 0.1], "pose_in_child": [0, 0, 0], "pose_in_parent": [0, 0, 0]}, "200 mm"),
        ({"type": "weld", "pose_in_child": {"rpy_deg": [0, 0, 30]}, "pose_in_parent": [0, 0, 0.3]}, "rotated by 30°"),
    ],
)
def test_a_constraint_violated_at_the_start_is_reported(constraint: dict[str, Any], text: str) -> None:
    entities = {"a": {"pose": [0, 0, 0.1], **BOX}, "b": {"pose": [0, 0, 0.4], **BOX}}
    tie = {"parent": "a", "child": "b", **constraint}
    diagnostics = found(entities, settle=0, constraints={"tie": tie})
    assert [(one.code, one.path) for one in diagnostics] == [("SC853", "constraints.tie")]
    assert text in diagnostics[0].message
    assert found(entities, settle=0, constraints={"tie": {"type": "weld", "parent": "a", "child": "b"}}) == []


def test_a_tilted_pole_topples_and_a_lying_pole_may_roll() -> None:
    pole = {"shapes": [{"type": "box", "half_size": [0.01, 0.01, 0.2]}]}
    roller = {"type": "cylinder", "radius": 0.1, "half_length": 0.2}
    tilted = {"pose": {"p": [0, 0, 0.201], "rpy_deg": [4, 0, 0]}, **pole}
    assert codes(found({"pole": tilted})) == ["SC854"]
    assert found({"roller": {"pose": [0, 0, 0.1], "linear_velocity": [0, 1, 0], "shapes": [roller]}}) == []


def test_a_body_pushed_out_of_another_is_thrown() -> None:
    light = {"pose": [0, 0, 0.15], "shapes": [{"type": "sphere", "radius": 0.1}], "mass": 0.01}
    heavy = {"pose": [0, 0, 0.1], **BOX, "mass": 100, "locked_axes": ["x", "y", "z", "rx", "ry", "rz"]}
    assert "SC850" in codes(found({"light": light, "heavy": heavy}))


def test_check_reports_the_errors_of_validate() -> None:
    assert codes(check_scene({"scenecc": 1, "entities": {"a": {"shape": []}}})) == ["SC101"]


def test_check_refuses_arguments_out_of_range() -> None:
    with pytest.raises(ValueError, match="settle must be 0 or more"):
        check_scene(scene({}), settle=-1)
    with pytest.raises(ValueError, match="seed cannot be combined with seeds"):
        check_scene(scene({}), seed=1, seeds=[2])


def test_progress_of_check_goes_from_zero_to_all_scenes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.simulation.check.SCENES_AT_ONCE", 2)
    calls: list[tuple[int, int]] = []
    check_scene(
        scene({}, num_scenes=3), settle=0, seeds=[0, 1], progress=lambda done, total: calls.append((done, total))
    )
    assert calls == [(0, 6), (2, 6), (3, 6), (5, 6), (6, 6)]


def test_a_thrown_body_is_found_for_any_duration() -> None:
    file = Path(__file__).parents[2] / "scenes" / "check" / "settled" / "grip_too_hard.yaml"
    assert all("SC856" in codes(check_scene(file, settle=settle)) for settle in (1, 10))


@pytest.mark.parametrize(
    ("gravity", "place", "falls"),
    [
        ([0, 0, -9.81], [0, 0, 1], False),
        ([0, 0, -9.81], [0, 3, 0], True),
        ([0, 0, 9.81], [0, 0, -1], False),
        ([0, 0, 9.81], [0, 0, 1], True),
        ([9.81, 0, 0], [-1, 0, 0], False),
        ([9.81, 0, 0], [1, 0, 0], True),
        ([9.81, 0, 0], [0, 0, 1], True),
        ([0, -7, -7], [0, 1, 1], False),
        ([0, -7, -7], [0, 1, -2], True),
        ([0, 0, 0], [0, 3, 0], False),
    ],
)
def test_below_is_along_gravity(gravity: list[float], place: list[float], *, falls: bool) -> None:
    block = {"body_type": "static", "shapes": [{"type": "box", "half_size": [0.5, 0.5, 0.5]}]}
    ball = {"pose": place, "shapes": [{"type": "sphere", "radius": 0.1}]}
    document = {"scenecc": 1, "physics": {"gravity": gravity}, "entities": {"block": block, "ball": ball}}
    found = [one.code for one in check_scene(document, settle=0) if one.code != "SC530"]
    assert found == (["SC852"] if falls else [])


@pytest.mark.parametrize(("gravity", "codes_"), [([0, 0, -9.81], []), ([9.81, 0, 0], ["SC530", "SC852"])])
def test_a_plane_along_gravity_supports_nothing(gravity: list[float], codes_: list[str]) -> None:
    physics = {"gravity": gravity}
    assert codes(found({"a": {"pose": [0, 0, 0.1], **BOX}}, settle=0, physics=physics)) == codes_


def test_without_gravity_nothing_topples() -> None:
    pole = {
        "pose": [0, 0, 1],
        "angular_velocity": [0, 0, 0],
        "shapes": [{"type": "box", "half_size": [0.01, 0.01, 0.2]}],
    }
    ball = {"pose": [0.5, 0, 1.15], "linear_velocity": [-2, 0, 0], "shapes": [{"type": "sphere", "radius": 0.05}]}
    assert found({"pole": pole, "ball": ball}, physics={"gravity": [0, 0, 0]}) == []


def arm(**drive: float) -> dict[str, Any]:
    joint = {"name": "j", "type": "revolute", "axis": [0, 1, 0], "limits": [-1.6, 1.6]}
    shape = {"type": "box", "half_size": [0.2, 0.05, 0.05], "pose": [0.3, 0, 0]}
    root = {"name": "base", **BOX, "children": [{"name": "beam", "joint": joint, "shapes": [shape]}]}
    return {"fix_root_link": True, "pose": [0, 0, 1], "root": root, "drives": {"j": drive}}


@pytest.mark.parametrize(
    ("entities", "code"),
    [
        ({"arm": arm(stiffness=50, target=0.5)}, "SC537"),
        ({"arm": arm(stiffness=50, velocity_target=1)}, "SC537"),
        ({"arm": arm(stiffness=500, damping=50, target=10)}, "SC523"),
        ({"floor": GROUND}, "SC546"),
        ({"floor": {**GROUND, "pose": [0, 0, -1]}}, "SC576"),
        ({"box": {"pose": [12, 0, 0.1], **BOX}}, "SC577"),
        ({"box": {"pose": [0, 0, 6000], **BOX}}, "SC534"),
    ],
)
def test_a_mistake_is_reported_once(entities: dict[str, Any], code: str) -> None:
    assert codes(found(entities)) == [code]


def test_the_undamped_drive_of_a_prefab_is_found_by_simulation(tmp_path: Path) -> None:
    (tmp_path / "arm.yaml").write_text(json.dumps(scene({"arm": arm(stiffness=50, target=0.5)})))
    (tmp_path / "scene.yaml").write_text("scenecc: 1\nentities:\n  robot: {use: arm.yaml}\n")
    assert codes(check_scene(tmp_path / "scene.yaml")) == ["SC858"]
