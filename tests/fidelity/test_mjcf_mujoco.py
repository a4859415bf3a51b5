"""MJCF files against MuJoCo itself: where bodies, shapes and axes are, limits and masses."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.mjcf_cases import CASES, COMMON
from fidelity.mjcf_strategy import mjcf_files
from hypothesis import given, settings
from numpy.testing import assert_allclose
from plugins.mujoco_judge import assert_same_machine
from plugins.nightly import examples

from scenecc import load_scene
from scenecc.diagnostics import Sink
from scenecc.robots.description import DescribedRobot, SolidGeometry
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.source.paths import AssetScope, ResolvedFile

mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed")

WAYS = ["none", "quat", "euler", "axisangle", "xyaxes", "zaxis"]
SEQUENCES = ["xyz", "XYZ", "zyx", "zXy", "xyx"]


def matrix(pose: Any) -> np.ndarray:
    w, x, y, z = np.array(pose[3:], np.float64) / np.linalg.norm(pose[3:])
    found = np.eye(4)
    found[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    found[:3, 3] = pose[:3]
    return found


def frames(robot: DescribedRobot) -> list[np.ndarray]:
    """Where each link is when all joints are at 0."""
    found: list[np.ndarray] = []
    for link in robot.links:
        if link.joint is None or link.parent is None:
            found.append(matrix(robot.pose))
        else:
            between = matrix(link.joint.pose_in_parent) @ np.linalg.inv(matrix(link.joint.pose_in_child))
            found.append(found[link.parent] @ between)
    return found


def compare(path: Path) -> None:
    """Asserts that a file's description is the model that MuJoCo makes of it."""
    sink = Sink()
    description = read_mjcf(ResolvedFile(path, path.name), scope=AssetScope(path.parent), sink=sink)
    assert description is not None, [str(one) for one in sink.diagnostics()]
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    seen = 0
    for robot in description.robots:
        for link, frame in zip(robot.links, frames(robot), strict=True):
            if link.joint is not None and link.joint.type != "fixed" and link.joint.name:
                compare_joint(model, data, link.joint, frame)
            found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link.name)
            if robot.body_type is None and link.parent is not None and "_dummy_" not in link.name:
                assert found > 0
                np.testing.assert_allclose(frame[:3, 3], data.xpos[found], atol=2e-6)
                np.testing.assert_allclose(frame[:3, :3].flatten(), data.xmat[found], atol=2e-6)
                assert link.inertial is not None
                assert link.inertial.mass == pytest.approx(model.body_mass[found])
                seen += compare_geoms(model, data, link, frame, found)
            elif robot.body_type is not None:
                body = max(0, mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link.name))
                mine = [g for g in range(model.ngeom) if model.body_rootid[model.geom_bodyid[g]] == body]
                seen += compare_geoms(model, data, link, frame, body, mine)
    assert seen == model.ngeom


def compare_joint(model: Any, data: Any, joint: Any, frame: np.ndarray) -> None:
    found = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, joint.name)
    assert found >= 0
    axis = frame @ matrix(joint.pose_in_child)
    np.testing.assert_allclose(axis[:3, 0], data.xaxis[found], atol=2e-6)
    np.testing.assert_allclose(axis[:3, 3], data.xanchor[found], atol=3e-6)
    # Its positions count from `ref`, ours from where the file puts the body.
    start = model.qpos0[model.jnt_qposadr[found]]
    limits = model.jnt_range[found] - start if model.jnt_limited[found] else (-math.inf, math.inf)
    np.testing.assert_allclose(joint.limits, limits, rtol=1e-6, atol=1e-7)
    assert joint.damping == pytest.approx(float(np.ravel(model.dof_damping[model.jnt_dofadr[found]])[0]))


def compare_geoms(
    model: Any, data: Any, link: Any, frame: np.ndarray, body: int, geoms: list[int] | None = None
) -> int:
    """Asserts that a link's shapes are the geoms of a body; how many there are."""
    geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body] if geoms is None else geoms
    assert len(geoms) == len(link.collisions)
    for number, made in zip(geoms, link.collisions, strict=True):
        place = frame @ matrix(made.pose)
        np.testing.assert_allclose(place[:3, 3], data.geom_xpos[number], atol=3e-6)
        theirs = data.geom_xmat[number].reshape(3, 3)
        if not isinstance(made.geometry, SolidGeometry):
            continue
        if made.geometry.kind == "box":
            np.testing.assert_allclose(place[:3, :3], theirs, atol=3e-6)
            np.testing.assert_allclose(made.geometry.sizes, model.geom_size[number], rtol=1e-6)
        elif made.geometry.kind in {"capsule", "cylinder"}:
            # Ours lie along x, MuJoCo's along z, and neither end is the first.
            assert abs(place[:3, 0] @ theirs[:, 2]) == pytest.approx(1, abs=2e-6)
            np.testing.assert_allclose(made.geometry.sizes, model.geom_size[number][:2], rtol=2e-6)
        else:
            assert made.geometry.sizes[0] == pytest.approx(model.geom_size[number][0])
    return len(geoms)


pytestmark = pytest.mark.usefixtures("other_folder")


@settings(max_examples=examples(100))
@given(text=mjcf_files(WAYS, SEQUENCES))
def test_a_random_mjcf_is_built_as_mujoco_compiles_it(text: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("mjcf") / "robot.xml"
    path.write_text(text)
    compare(path)


@pytest.mark.parametrize("name", CASES)
def test_an_mjcf_feature_is_built_as_mujoco_compiles_it(
    name: str, tmp_path: Path, meshes: dict[str, Path], image: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for folder in ("meshes", "parts"):
        (tmp_path / folder).mkdir()
    (tmp_path / "meshes" / "rock.obj").write_bytes(meshes["rock"].read_bytes())
    (tmp_path / "wood.png").write_bytes(image.read_bytes())
    (tmp_path / "parts" / "common.xml").write_text(COMMON)
    path = tmp_path / "robot.xml"
    path.write_text(CASES[name])
    scene = {"scenecc": 1, "entities": {"robot": {"mjcf": str(path)}}}
    with load_scene(scene, render=False, asset_roots=[tmp_path]) as batch:
        assert_same_machine(mujoco, mujoco.MjModel.from_xml_path(str(path)), batch)


PINNED = """<mujoco><compiler angle="radian"/><worldbody><body><geom size=".1"/>
  <body pos="0 0 1"><joint name="a" type="slide" axis="0 0 1" {range}/><geom size=".1" contype="0"/></body>
  <body pos="1 0 1"><joint name="b" axis="0 1 0" ref="0.1"/><geom pos="0.5 0 0" size=".1" contype="0"/></body>
</body></worldbody><equality>{equality}</equality>
<keyframe><key name="k" qpos="0.125 0.1"/></keyframe>
<actuator><position joint="a" kp="10"/></actuator></mujoco>"""

PIN_B = '<joint joint1="b" polycoef="0.25 1 0 0 0"/>'


@pytest.mark.parametrize(
    ("equality", "ends", "expected"),
    [
        ('<joint joint1="a" polycoef="0.25 1 0 0 0"/>', "", {"a": 0.25}),
        (PIN_B, "", {"b": 0.25}),
        ('<joint joint1="a" joint2="b" polycoef="0.25 0 0 0 0"/>', 'range="-1 0.5"', {"a": 0.25}),
        (f'<joint joint1="a" joint2="b" polycoef="0 2 1 0 0"/>{PIN_B}', "", {"a": 0.5625, "b": 0.25}),
    ],
)
@pytest.mark.parametrize("keyframe", [{}, {"keyframe": "k"}])
def test_pinned_joints_rest_where_mujoco_holds_them(
    tmp_path: Path, equality: str, ends: str, expected: dict[str, float], keyframe: dict[str, str]
) -> None:
    (tmp_path / "a.xml").write_text(PINNED.format(equality=equality, range=ends))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 1500)
    scene = {"scenecc": 1, "entities": {"r": {"mjcf": str(tmp_path / "a.xml"), **keyframe}}}
    with load_scene(scene, render=False, asset_roots=[tmp_path]) as batch:
        robot = batch.articulations["r"]
        for steps in (0, 100):
            batch.step(steps)
            found = dict(zip([joint.name for joint in robot.objs[0].active_joints], robot.qpos[0], strict=True))
            for name, position in expected.items():
                assert found[name] == pytest.approx(position, abs=1e-5)
                judged = data.joint(name).qpos[0] - model.qpos0[model.joint(name).qposadr[0]]
                assert judged == pytest.approx(position, abs=2e-2)


BLOCK = 'type="box" size="0.05 0.05 0.05"'
CART = f'<body name="cart"><joint name="x" type="slide" axis="1 0 0" {{ends}}/><geom {BLOCK} mass="1"/></body>'
FLAG = '<flag filterparent="disable"/>'


@pytest.mark.parametrize(
    ("flag", "rail", "cart", "links"),
    [
        ("", f'<geom {BLOCK} pos="0.5 0 0"/>', CART.format(ends=""), 3),
        ("", f'<geom {BLOCK} pos="0.5 0 0"/>', CART.format(ends='range="-1 3"'), 3),
        (FLAG, f'<joint type="slide" axis="0 1 0"/><geom {BLOCK} pos="0.5 0 0"/>', CART.format(ends=""), 4),
        # Filtered; out of reach; on a body that moves.
        ("", f'<geom {BLOCK} pos="0.5 0 0" contype="2" conaffinity="2"/>', CART.format(ends='range="0 0.8"'), 2),
        ("", f'<geom {BLOCK} pos="0.5 0 0"/>', CART.format(ends='range="-1 0.3"'), 2),
        ("", f'<joint type="slide" axis="0 1 0"/><geom {BLOCK} pos="0.5 0 0"/>', CART.format(ends='range="0 0.8"'), 3),
    ],
)
def test_bodies_collide_with_a_fixed_parent(tmp_path: Path, flag: str, rail: str, cart: str, links: int) -> None:
    option = f'<compiler autolimits="true"/><option gravity="9.81 0 0">{flag}</option>'
    text = f'<mujoco>{option}<worldbody><body name="rail">{rail}{cart}</body></worldbody></mujoco>'
    (tmp_path / "a.xml").write_text(text)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 500)
    scene = {"scenecc": 1, "physics": {"gravity": [9.81, 0, 0]}, "entities": {"r": {"mjcf": str(tmp_path / "a.xml")}}}
    with load_scene(scene, render=False, asset_roots=[tmp_path]) as batch:
        robot = batch.articulations["r"]
        batch.step(100)
        assert len(robot.objs[0].links) == links
        assert robot.qpos[0, -1] == pytest.approx(data.qpos[-1], abs=0.02)


def test_bodies_that_overlap_their_parent_from_the_start_do_not_collide(tmp_path: Path) -> None:
    body = f'<body name="rail"><geom {BLOCK}/>{CART.format(ends="")}</body>'
    (tmp_path / "a.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    sink = Sink()
    found = read_mjcf(ResolvedFile(tmp_path / "a.xml", "a.xml"), scope=AssetScope(tmp_path), sink=sink)
    assert found is not None
    assert len(found.robots[0].links) == 2
    assert not sink.diagnostics()


def test_contacts_with_a_parent_that_cannot_be_built_are_reported(tmp_path: Path) -> None:
    rail = f'<geom {BLOCK} pos="0.5 0 0"/><geom {BLOCK}/>'
    body = f'<body name="rail">{rail}{CART.format(ends="")}</body>'
    (tmp_path / "a.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    sink = Sink()
    assert read_mjcf(ResolvedFile(tmp_path / "a.xml", "a.xml"), scope=AssetScope(tmp_path), sink=sink)
    (found,) = sink.diagnostics()
    assert (found.code, found.message) == (
        "SC484",
        "`cart` and `rail` do not collide, as they do in MuJoCo: other shapes of them overlap",
    )


def test_a_mocap_body_without_shapes_moves_the_hand_that_is_welded_to_it(tmp_path: Path) -> None:
    hand = f'<body name="hand"><joint type="slide" axis="0 0 1"/><geom {BLOCK} mass="1"/></body>'
    arm = f'<body><joint name="x" type="slide" axis="1 0 0"/><geom {BLOCK} mass="1"/>{hand}</body>'
    held = '<body name="mocap" mocap="true" pos="0 0 0.5"/><body name="unused" mocap="true"/>'
    weld = '<equality><weld body1="hand" body2="mocap" relpose="0 0 0.5 1 0 0 0"/></equality>'
    (tmp_path / "a.xml").write_text(f"<mujoco><worldbody>{held}{arm}</worldbody>{weld}</mujoco>")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    data = mujoco.MjData(model)
    data.mocap_pos[0] = 0.2, 0, 0.4
    mujoco.mj_step(model, data, 500)
    scene = {"scenecc": 1, "entities": {"r": {"mjcf": str(tmp_path / "a.xml")}}}
    with load_scene(scene, render=False, asset_roots=[tmp_path]) as batch:
        assert [*batch.entities] == ["r/mocap"]
        mocap: Any = batch.entities["r/mocap"].objs[0].find_component_by_type(sapien.physx.PhysxRigidDynamicComponent)
        mocap.set_kinematic_target(sapien.Pose([0.2, 0, 0.4]))
        batch.step(500)
        (robot,) = batch.articulations.values()
        assert_allclose(robot.objs[0].links[-1].entity_pose.p, [0.2, 0, -0.1], atol=1e-3)
        assert_allclose(robot.objs[0].links[-1].entity_pose.p, data.body("hand").xpos, atol=5e-3)
