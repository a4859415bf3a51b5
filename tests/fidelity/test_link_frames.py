"""Poses in the frames of links, against the same chains computed by hand and against SAPIEN's own kinematics."""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.yaml_cases import load
from sapien import physx

from scenecc import SceneBatch, compile_scene, load_scene, validate

ARM = """
  arm:
    pose: {p: [0.5, POSE, 1], rpy: [0, 0, 0.4]}
    fix_root_link: true
    qpos: {turn: TURN, slide: SLIDE}
    root:
      name: base
      shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
      children:
        - name: fore
          joint:
            {name: turn, type: revolute, axis: z, limits: [-1, 1.5], origin: {p: [0, 0, 0.3], rpy: [0.1, 0.2, 0.3]}}
          shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
          children:
            - name: hand
              joint:
                {name: slide, type: prismatic, axis: y, limits: [0, 0.5], origin: {p: [0.6, 0, 0], rpy: [0.3, 0, 0]}}
              shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]
        - name: finger
          joint:
            name: follow
            type: revolute
            axis: x
            origin: [0, 0.4, 0]
            mimic: {joint: turn, multiplier: -0.5, offset: 0.1}
          shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]
"""
REST = """
  cup: {pose: {p: [0.1, 0.2, 0.3], rpy: [1, 0, 0], relative_to: arm/hand}, shapes: [{type: sphere, radius: 0.05}]}
  lid: {pose: {p: [0, 0, 0.2], relative_to: cup}, shapes: [{type: sphere, radius: 0.05}]}
  ring: {pose: {p: [0, 0.3, 0], relative_to: arm/finger}, shapes: [{type: sphere, radius: 0.05}]}
  tool: {pose: {p: [0, 0, 0.5], relative_to: arm/fore}, shapes: [{type: sphere, radius: 0.05}]}
"""
MOVED = ("cup", "lid", "ring", "tool")


def document(turn: str, slide: str, pose: str = "0", scenes: int = 3, rest: str = REST) -> str:
    arm = ARM.replace("TURN", turn).replace("SLIDE", slide).replace("POSE", pose)
    return f"scenecc: 1\nnum_scenes: {scenes}\nentities:{rest}{arm}"


def matrix(p: Any, rpy: Any = (0, 0, 0)) -> Any:
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    made = np.eye(4)
    made[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    made[:3, 3] = p
    return made


def by_hand(turn: float, slide: float, y: float) -> dict[str, Any]:
    """Where all is, by matrices: none of our quaternions."""
    arm = matrix([0.5, y, 1], [0, 0, 0.4])
    fore = arm @ matrix([0, 0, 0.3], [0.1, 0.2, 0.3]) @ matrix([0, 0, 0], [0, 0, turn])
    hand = fore @ matrix([0.6, 0, 0], [0.3, 0, 0]) @ matrix([0, slide, 0])
    finger = arm @ matrix([0, 0.4, 0]) @ matrix([0, 0, 0], [0.1 - 0.5 * turn, 0, 0])
    cup = hand @ matrix([0.1, 0.2, 0.3], [1, 0, 0])
    return {
        "cup": cup,
        "lid": cup @ matrix([0, 0, 0.2]),
        "ring": finger @ matrix([0, 0.3, 0]),
        "tool": fore @ matrix([0, 0, 0.5]),
    }


def assert_by_hand(batch: SceneBatch, y: Any) -> None:
    qpos = batch.articulations["arm"].qpos
    names = [joint.name for joint in batch.articulations["arm"].objs[0].active_joints]
    for scene, row in enumerate(qpos):
        position = dict(zip(names, row.tolist(), strict=True))
        wanted = by_hand(position["turn"], position["slide"], y[scene])
        for name, pose in wanted.items():
            found = sapien.Pose(*np.split(batch.entities[name].pose[scene], [3])).to_transformation_matrix()
            assert np.allclose(found, pose, atol=2e-6), name


@pytest.mark.parametrize("turn", ["0.7", "{per_scene: [0.7, -0.2, 1]}", "{uniform: [-3, 3]}", "'${2 * scene - 1.2}'"])
@pytest.mark.parametrize("slide", ["0.2", "{uniform: [-0.5, 1]}"])
def test_what_is_relative_to_a_link_starts_where_the_joints_put_it(turn: str, slide: str) -> None:
    if turn.startswith("'"):
        turn = turn.replace("2 * scene - 1.2", "scene - 0.9")
    batch = load(document(turn, slide, "{uniform: [0, 2]}"))
    assert_by_hand(batch, batch.articulations["arm"].pose[:, 1])
    for seed in (3, 4):
        batch.reset(seed=seed, exact=True)
        assert_by_hand(batch, batch.articulations["arm"].pose[:, 1])
        fresh = load(document(turn, slide, "{uniform: [0, 2]}"), seed=seed)
        for ours, theirs in zip(batch.scenes, fresh.scenes, strict=True):
            assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, fresh.scenes)  # pyright: ignore[reportPossiblyUnboundVariable]


def test_the_same_position_by_whatever_form_gives_the_same_bits() -> None:
    forms = [
        "0.7",
        "{per_scene: [0.7, 0.7, 0.7]}",
        "{uniform: [0.7, 0.7]}",
        "{choice: [0.7]}",
        "'${0.7}'",
        "'${0.7 + 0 * scene}'",
    ]
    found = [
        [entity.pose.data.tolist()[0] for entity in compile_scene_of(document(form, "0.2")).entities] for form in forms
    ]
    assert all(one == found[0] for one in found)


def compile_scene_of(text: str) -> Any:

    return compile_scene(io.StringIO(text))


def quaternion(axis: Any, angle: float) -> Any:
    return (math.cos(angle / 2), *(math.sin(angle / 2) * one for one in axis))


def hand_compose(a: Any, b: Any) -> Any:
    """Two poses p, q after one another in float64, as a person writes it."""
    p, (w, x, y, z) = a
    (bp, (bw, bx, by, bz)) = b
    length = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / length, x / length, y / length, z / length
    tx, ty, tz = 2 * (y * bp[2] - z * bp[1]), 2 * (z * bp[0] - x * bp[2]), 2 * (x * bp[1] - y * bp[0])
    moved = (
        bp[0] + w * tx + (y * tz - z * ty),
        bp[1] + w * ty + (z * tx - x * tz),
        bp[2] + w * tz + (x * ty - y * tx),
    )
    q = (
        w * bw - x * bx - y * by - z * bz,
        w * bx + x * bw + y * bz - z * by,
        w * by - x * bz + y * bw + z * bx,
        w * bz + x * by - y * bx + z * bw,
    )
    length = math.sqrt(sum(one * one for one in q))
    return tuple(c + d for c, d in zip(p, moved, strict=True)), tuple(one / length for one in q)


def test_a_scene_by_hand_in_sapien_to_the_bit() -> None:
    """A lever whose joint turns about x, as SAPIEN's own frames do."""
    text = """
scenecc: 1
entities:
  lever:
    pose: {p: [0, 0, 1], q: [0.8, 0, 0, 0.6]}
    fix_root_link: true
    qpos: [0.6]
    root:
      name: base
      shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]
      children:
        - name: arm
          joint:
            {name: turn, type: revolute, axis: x, limits: [-1, 1], origin: {p: [0.3, 0, 0.1], q: [0.6, 0, 0.8, 0]}}
          shapes: [{type: box, half_size: [0.05, 0.2, 0.05]}]
  ball:
    pose: {p: [0.02, 0.1, 0.2], q: [0.28, 0.96, 0, 0], relative_to: lever/arm}
    shapes: [{type: sphere, radius: 0.05}]
"""
    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    builder = scene.create_articulation_builder()
    builder.set_initial_pose(sapien.Pose([0, 0, 1], [0.8, 0, 0, 0.6]))
    base = builder.create_link_builder()
    base.set_name("base")
    base.add_box_collision(half_size=[0.1, 0.1, 0.1])
    arm = builder.create_link_builder(base)
    arm.set_name("arm")
    arm.set_joint_name("turn")
    origin = sapien.Pose([0.3, 0, 0.1], [0.6, 0, 0.8, 0])
    arm.set_joint_properties("revolute", [[-1, 1]], origin, sapien.Pose())
    arm.add_box_collision(half_size=[0.05, 0.2, 0.05])
    lever = builder.build(fix_root_link=True)
    lever.name = "lever"
    lever.set_qpos([0.6])
    at = ((0.3, 0.0, 0.1), (0.6, 0.0, 0.8, 0.0)), ((0.0, 0.0, 0.0), quaternion((1, 0, 0), 0.6))
    link = hand_compose(*at)
    ball = hand_compose(
        hand_compose(((0.0, 0.0, 1.0), (0.8, 0.0, 0.0, 0.6)), link), ((0.02, 0.1, 0.2), (0.28, 0.96, 0.0, 0.0))
    )
    body = scene.create_actor_builder()
    body.add_sphere_collision(radius=0.05)
    body.initial_pose = sapien.Pose(*ball)
    body.build(name="ball")
    batch = load(text)
    assert batch.entities["ball"].pose[0].tolist() == np.array([*ball[0], *ball[1]], np.float32).tolist()
    assert_same_trajectory(batch.scenes, [scene])


def test_a_static_body_keeps_the_joints_where_they_are_built() -> None:
    rest = REST.replace("  cup: {", "  cup: {body_type: static, ")
    text = document("{uniform: [-1, 1]}", "{uniform: [0, 0.5]}", "{uniform: [0, 2]}", rest=rest)
    found = validate_text(text)
    assert [one.code for one in found] == ["SC347"]
    batch = load(text)
    before = batch.articulations["arm"].qpos.copy(), {name: batch.entities[name].pose.copy() for name in MOVED}
    batch.reset(seed=9)
    assert np.array_equal(batch.articulations["arm"].qpos, before[0])
    for name in MOVED:
        assert np.array_equal(batch.entities[name].pose, before[1][name])


def validate_text(text: str) -> Any:

    return validate(io.StringIO(text))


ALTERNATIVES = """scenecc: 1
num_scenes: 4
draws: {which: {integers: [0, 1]}}
entities:
  arm: {urdf: "${'a.urdf' if which == 0 else 'b.urdf'}", qpos: {j: {uniform: [-1, 1]}}}
  ball: {pose: {p: [0, 0, 0.5], relative_to: arm/hand}, shapes: [{type: sphere, radius: 0.1}]}
"""


def robot(middle: str, z: float) -> str:
    ball = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
    inertial = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"
    return (
        f"<robot name='r'><link name='base'>{ball}{inertial}</link><link name='{middle}'>{ball}{inertial}</link>"
        f"<link name='hand'>{ball}{inertial}</link>"
        f"<joint name='j' type='revolute'><parent link='base'/><child link='{middle}'/><axis xyz='0 1 0'/>"
        f"<origin xyz='0 0 {z}'/><limit lower='-2' upper='2' effort='1' velocity='1'/></joint>"
        f"<joint name='k' type='fixed'><parent link='{middle}'/><child link='hand'/>"
        "<origin xyz='0 0 1'/></joint></robot>"
    )


def test_each_robot_that_an_entity_may_be_has_its_own_chain(tmp_path: Path) -> None:
    (tmp_path / "a.urdf").write_text(robot("upper", 1))
    (tmp_path / "b.urdf").write_text(robot("lower", 3))
    file = tmp_path / "scene.yaml"
    file.write_text(ALTERNATIVES)

    batch = load_scene(file, render=False)
    for seed in (None, 5):
        if seed is not None:
            batch.reset(seed=seed)
        for obj, ball in zip(batch.articulations["arm"].objs, batch.entities["ball"].pose, strict=True):
            (hand,) = [link for link in obj.links if link.name == "hand"]
            wanted = hand.entity.pose * sapien.Pose([0, 0, 0.5])
            assert np.allclose(ball[:3], wanted.p, atol=1e-5)
    file.write_text(ALTERNATIVES.replace("arm/hand", "arm/upper"))
    assert [one.code for one in validate(file)] == ["SC331"]


def test_the_gooseneck_that_ships_has_its_lamp_and_its_camera_where_the_head_is() -> None:
    file = Path(__file__).resolve().parents[2] / "scenes/gooseneck.yaml"
    for seed in (0, 3):
        plan, batch = compile_scene(file, seed=seed), load_scene(file, render=False)
        batch.reset(seed=seed)
        for scene in range(plan.num_scenes):
            links = {
                link.name: link.entity.pose
                for name in ("neck", "arm")
                for link in batch.articulations[name].objs[scene].links
            }
            for pose, link, p in (
                (plan.lights[0].pose.row(scene), "head", [0.1, 0, 0]),
                (plan.cameras[0].pose.row(scene), "head", [0.1, 0, 0]),
                (batch.entities["tool"].pose[scene], "tip", [0, 0, 0.08]),
            ):
                assert np.allclose(pose[:3], (links[link] * sapien.Pose(p)).p, atol=1e-5)
