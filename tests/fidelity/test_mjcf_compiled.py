"""MJCF files read by MuJoCo's compiler, built, and judged by MuJoCo itself."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from plugins.mujoco_judge import assert_same_machine

import scenecc

if TYPE_CHECKING:
    from pathlib import Path

mujoco: Any = pytest.importorskip("mujoco")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def load(folder: Path, text: str, **keys: Any) -> tuple[Any, Any]:
    """The model as MuJoCo has it, and the built scene."""
    file = folder / "robot.xml"
    file.write_text(text)
    scene = {"scenecc": 1, "entities": {"robot": {"mjcf": str(file), **keys}}}
    return mujoco.MjModel.from_xml_path(str(file)), scenecc.load_scene(scene, render=False, asset_roots=[folder])


def robot_of(batch: Any) -> Any:
    """The only articulation."""
    (robot,) = batch.articulations.values()
    return robot


def mujoco_of(body: str, rest: str = "") -> str:
    return f"<mujoco>{rest}<worldbody>{body}</worldbody></mujoco>"


ARM = """
<body name="base" pos="0.1 0.2 0.3" euler="10 20 30">
  <inertial pos="0.01 0.02 0.03" mass="2.5" fullinertia="0.02 0.03 0.04 0.001 0.002 0.003"/>
  <geom type="box" size="0.1 0.1 0.1" mass="3"/>
  <body name="upper" pos="0 0 0.3" zaxis="1 1 0">
    <joint name="a" axis="0 1 1" pos="0.01 0 0.05" range="-60 80" ref="15" damping="0.3" armature="0.02"/>
    <joint name="b" type="slide" axis="1 0 0" range="-0.1 0.2" limited="true"/>
    <geom type="capsule" fromto="0 0 0 0.1 0.1 0.2" size="0.04" density="500"/>
    <geom type="ellipsoid" size="0.05 0.1 0.2" pos="0 0 0.2" euler="0 40 0"/>
    <body name="lower" pos="0 0.1 0.3"><joint type="ball" name="wrist"/>
      <geom type="cylinder" size="0.03 0.1" friction="0.7 0.1 0.1" contype="2" conaffinity="4"/>
      <body pos="0 0 0.1"><geom size="0.02" contype="0" conaffinity="0"/></body>
      <body pos="0 0 0.2" name="tip"><joint name="c" axis="0 0 1" type="hinge"/><geom size="0.02" mass="0.2"/></body>
    </body>
  </body>
</body>"""

CASES = {
    "arm": mujoco_of(ARM),
    "radians and defaults": mujoco_of(
        '<body name="a" childclass="big"><joint axis="0 1 0"/><geom/><body pos="0 0 1"><joint class="stiff"/><geom/>'
        "</body></body>",
        '<compiler angle="radian" eulerseq="zyx" autolimits="true"/><default><default class="big"><geom type="box" '
        'size="0.1 0.2 0.3" density="300"/></default><default class="stiff"><joint range="-1 2" damping="4" '
        'axis="1 2 3"/></default></default>',
    ),
    "replicate and frame": mujoco_of(
        '<body name="hub"><freejoint/><geom size="0.1"/><frame pos="0 0 0.5" euler="0 0 30"><replicate count="5" '
        'euler="0 0 40"><body name="spoke" pos="0.4 0 0"><joint name="turn" axis="1 0 0"/><geom size="0.02" '
        'type="capsule" fromto="0 0 0 0.2 0 0"/></body></replicate></frame></body>'
    ),
    "total mass and inertia from geoms": mujoco_of(
        '<body><joint type="slide" axis="0 0 1"/><geom type="box" size="0.1 0.1 0.1" group="3"/><geom type="mesh" '
        'mesh="tetra"/></body>',
        '<compiler boundmass="0.5" boundinertia="0.01"/><asset><mesh name="tetra" vertex="0 0 0 1 0 0 0 1 0 0 0 1" '
        'scale="0.3 0.4 -0.5" refpos="0.1 0 0"/></asset>',
    ),
    "gimbals without mass": mujoco_of(
        '<body name="outer"><joint axis="1 0 0"/><body name="inner"><geom size="0.1" mass="0.3"/></body>'
        '<body name="last"><joint axis="0 1 0"/><joint axis="0 0 1"/><geom size="0.1"/></body></body>'
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_kinematics_and_masses_of_an_mjcf_equal_mujocos(tmp_path: Path, name: str) -> None:
    model, batch = load(tmp_path, CASES[name])
    for seed in range(5):
        assert_same_machine(mujoco, model, batch, seed)
    for _ in range(100):
        batch.step()
    assert np.isfinite(robot_of(batch).qpos).all()


def tetrahedron_msh() -> bytes:
    """MuJoCo's own binary format: four counts, then vertices, no normals, no texture coordinates, faces."""
    vertices = [[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0], [0, 0, 0.5]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    return struct.pack("<4i", 4, 0, 0, 4) + np.array(vertices, "<f4").tobytes() + np.array(faces, "<i4").tobytes()


OBJ = "v 0 0 0\nv 0.3 0 0\nv 0 0.4 0\nv 0 0 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.parametrize("file", ["t.obj", "t.msh"])
def test_mjcf_meshes_keep_the_pose_of_their_files(tmp_path: Path, file: str) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes/t.obj").write_text("mtllib missing.mtl\n" + OBJ)
    (tmp_path / "meshes/t.msh").write_bytes(tetrahedron_msh())
    assets = f'<compiler meshdir="meshes"/><asset><mesh file="{file}"/></asset>'
    body = '<body pos="0 0 1"><freejoint/><geom type="mesh" mesh="t" pos="0.1 0 0" euler="20 30 40"/></body>'
    model, batch = load(tmp_path, mujoco_of(body, assets))
    assert_same_machine(mujoco, model, batch)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    entity = next(iter(batch.entities.values())).objs[0]
    (shape,) = entity.components[-1].collision_shapes
    points = shape.vertices * shape.scale
    place = (entity.pose * shape.local_pose).to_transformation_matrix()
    found = points @ place[:3, :3].T + place[:3, 3]
    mesh = model.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    assert_allclose(found[np.lexsort(found.T.round(4))], mesh[np.lexsort(mesh.T.round(4))], atol=2e-6)


SPHERE = '<geom size="0.5" {}/>'
TREE = f"""
<body name="base">{SPHERE.format("")}
  <body name="one"><joint axis="1 0 0"/><joint axis="0 1 0"/>{SPHERE.format("")}
    <body name="fixed">{SPHERE.format("")}
      <body name="two"><joint axis="1 0 0"/>{SPHERE.format('contype="2" conaffinity="1"')}
        <body name="three"><joint axis="1 0 0"/>{SPHERE.format('contype="4" conaffinity="2"')}</body>
        <body name="four"><joint axis="0 0 1"/>{SPHERE.format("")}</body>
        <body name="ghost"><joint axis="0 0 1"/>{SPHERE.format('contype="0" conaffinity="8"')}</body>
      </body>
    </body>
  </body>
</body>
<body name="ball"><freejoint/>{SPHERE.format("")}</body>
<body name="other"><freejoint/>{SPHERE.format('contype="8" conaffinity="0"')}</body>"""


@pytest.mark.parametrize(
    "rest",
    [
        "",
        '<contact><exclude body1="base" body2="ball"/><exclude body1="three" body2="one"/></contact>',
        '<option><flag contact="disable"/></option>',
        '<option><flag constraint="disable"/></option>',
        '<option><flag filterparent="disable"/></option>',
    ],
    ids=["plain", "excludes", "no contacts", "no constraints", "no filter"],
)
def test_colliding_pairs_are_those_of_mujoco(tmp_path: Path, rest: str) -> None:
    """All spheres are in one place, so that whoever may touch does."""
    model, batch = load(tmp_path, mujoco_of(TREE, f'{rest}<option gravity="0 0 0"/>'))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    names = [model.body(body).name for body in range(model.nbody)]
    wanted = {frozenset(names[model.geom_bodyid[geom]] for geom in contact.geom) for contact in data.contact}
    batch.step()
    touching = [
        frozenset(body.entity.name.rpartition("/")[2] for body in contact.bodies)
        for contact in batch.scenes[0].get_contacts()
    ]
    # PhysX keeps apart a link and the link that it hangs on, also where MuJoCo does not: on the world, or by the flag.
    neighbours = [("fixed", "two"), ("two", "three"), ("two", "four"), ("two", "ghost"), ("one", "fixed")]
    assert set(touching) == wanted - set(map(frozenset, neighbours))


def test_bodies_of_an_mjcf_collide_with_the_rest_of_the_scene(tmp_path: Path) -> None:
    file = tmp_path / "ball.xml"
    file.write_text(mujoco_of('<body name="ball"><freejoint/><geom size="0.1" contype="4" conaffinity="8"/></body>'))
    floor = {"body_type": "static", "shapes": [{"type": "box", "half_size": [1, 1, 0.1]}], "pose": [0, 0, -0.1]}
    entities = {"floor": floor, "ball": {"mjcf": str(file), "pose": [0, 0, 0.3]}}
    batch = scenecc.load_scene({"scenecc": 1, "entities": entities}, render=False, asset_roots=[tmp_path])
    for _ in range(200):
        batch.step()
    assert batch.entities["ball"].pose[0, 2] == pytest.approx(0.1, abs=0.005)


ACTUATED = mujoco_of(
    '<body name="a"><joint name="a" axis="0 1 0" ref="30" range="-90 90" damping="0.5"/><geom size="0.1"/>'
    '<body name="b" pos="0 0 1"><joint name="b" type="slide" axis="0 0 1" range="-1 1"/><geom size="0.1"/>'
    '<body name="c" pos="0 0 1"><joint name="c" axis="0 1 0" stiffness="7" springref="20"/><geom size="0.1"/>'
    '<body name="d" pos="0 0 1"><joint name="d" axis="0 1 0"/><geom size="0.1"/></body></body></body></body>',
    '<equality><joint joint1="d" joint2="c" polycoef="0.1 -2 0 0 0"/></equality>'
    '<actuator><position joint="a" kp="100" kv="3" gear="2" forcerange="-20 20"/><velocity joint="b" kv="5"/>'
    '<motor joint="c" gear="9"/></actuator>'
    '<keyframe><key name="home" qpos="0.7 0.25 0.1 -0.1" ctrl="1.5 0.2 0"/></keyframe>',
)


def drive(joint: Any) -> list[float]:
    return [joint.stiffness, joint.damping, joint.force_limit, float(joint.drive_target[0])]


def test_actuators_springs_and_keyframes_become_drives(tmp_path: Path) -> None:
    _, batch = load(tmp_path, ACTUATED)
    first = {joint.name: joint for joint in robot_of(batch).objs[0].active_joints}
    unlimited = float(np.finfo(np.float32).max)
    assert_allclose(drive(first["a"]), [400, 12.5, 40, 0], rtol=1e-6)
    assert_allclose(drive(first["b"]), [0, 5, unlimited, 0], rtol=1e-6)
    assert_allclose(drive(first["c"]), [7, 0, unlimited, float(np.radians(20))], rtol=1e-6)
    assert all(joint.friction == 0 for joint in first.values())
    _, batch = load(tmp_path, ACTUATED, keyframe="home")
    zero = float(np.radians(30))
    assert_allclose(robot_of(batch).qpos[0], [0.7 - zero, 0.25, 0.1, 0.1 - 0.2], rtol=1e-6)
    joints = {joint.name: joint for joint in robot_of(batch).objs[0].active_joints}
    # The control is a position of what the gear drives: twice the joint's.
    assert_allclose(drive(joints["a"]), [400, 12.5, 40, 0.75 - zero], rtol=1e-6)
    _, batch = load(tmp_path, ACTUATED, keyframe="home", qpos={"b": 0.5}, drives={"a": {"stiffness": 1}})
    assert_allclose(robot_of(batch).qpos[0], [0.7 - zero, 0.5, 0.1, -0.1], rtol=1e-6)
    joints = {joint.name: joint for joint in robot_of(batch).objs[0].active_joints}
    assert_allclose(drive(joints["a"])[:2], [1, 0], rtol=1e-6)


def test_attached_models_are_built(tmp_path: Path) -> None:
    (tmp_path / "hands/meshes").mkdir(parents=True)
    (tmp_path / "hands/meshes/t.obj").write_text(OBJ)
    (tmp_path / "t.obj").write_text(OBJ.replace("0.5", "5"))
    (tmp_path / "hands/finger.xml").write_text(
        '<mujoco model="finger"><worldbody><body name="tip"><joint name="j" axis="1 0 0" range="0 1"/>'
        '<geom size="0.02"/></body></worldbody></mujoco>'
    )
    (tmp_path / "hands/hand.xml").write_text(
        '<mujoco model="hand"><compiler angle="radian" meshdir="meshes"/><asset><mesh file="t.obj"/>'
        '<model name="f" file="finger.xml"/></asset><worldbody><body name="palm" pos="0 0 1"><joint name="j" '
        'axis="0 1 0" range="-0.5 2"/><geom type="mesh" mesh="t"/><attach model="f" body="tip" prefix="f_"/></body>'
        '</worldbody><actuator><position joint="j" kp="3"/></actuator></mujoco>'
    )
    body = (
        '<body name="arm"><freejoint/><geom type="mesh" mesh="t"/><replicate count="2" offset="1 0 0">'
        '<attach model="h" body="palm" prefix="h_"/></replicate></body>'
    )
    assets = '<asset><mesh file="t.obj"/><model name="h" file="hands/hand.xml"/></asset>'
    model, batch = load(tmp_path, mujoco_of(body, assets))
    assert model.nbody == 6
    for seed in range(3):
        assert_same_machine(mujoco, model, batch, seed)
    assert [joint.stiffness for joint in robot_of(batch).objs[0].active_joints].count(3) == model.nu


def test_gravcomp_1_disables_gravity(tmp_path: Path) -> None:
    text = mujoco_of(
        '<body name="free" gravcomp="1" pos="5 0 0"><freejoint/><geom size="0.1"/></body>'
        '<body name="a"><joint axis="0 1 0"/><geom size="0.1"/><body name="b" gravcomp="1" pos="1 0 0">'
        '<joint axis="0 1 0"/><joint axis="1 0 0"/><geom size="0.1"/></body></body>'
    )
    model, batch = load(tmp_path, text)
    assert_same_machine(mujoco, model, batch)
    robot_of(batch).qpos = np.zeros(3)
    floats = {link.name: link.disable_gravity for link in robot_of(batch).objs[0].links}
    assert floats == {"dummy_root_1": False, "a": False, "b_dummy_0": True, "b": True}
    for _ in range(100):
        batch.step()
    assert_allclose(robot_of(batch).qpos, 0, atol=1e-4)
    assert_allclose(batch.entities["robot/free"].pose[0, :3], [5, 0, 0], atol=1e-6)


@pytest.mark.parametrize("joint", ["", "<freejoint/>"], ids=["fixed", "free"])
def test_the_only_robot_of_an_mjcf_becomes_the_entity(tmp_path: Path, joint: str) -> None:
    text = mujoco_of(
        f'<body name="base" pos="0 0 1">{joint}<geom size="0.1"/><body name="tip" pos="0 0 0.3">'
        '<joint name="j" axis="0 1 0"/><geom size="0.1"/></body></body>'
    )
    (tmp_path / "arm.xml").write_text(text)
    ball = {"body_type": "static", "shapes": [{"type": "sphere", "radius": 0.01}]}
    scene = {
        "scenecc": 1,
        "entities": {
            "arm": {"mjcf": str(tmp_path / "arm.xml"), "pose": {"p": {"per_scene": [[1, 0, 0], [2, 0, 0]]}}},
            "at_file": {**ball, "pose": {"p": [0, 3, 0], "relative_to": "arm"}},
            "at_root": {**ball, "pose": {"p": [0, 3, 0], "relative_to": "arm/base"}},
        },
        "constraints": {"hold": {"type": "weld", "parent": "at_file", "child": "arm/tip"}},
    }
    with scenecc.load_scene(scene, num_scenes=2, render=False, asset_roots=[tmp_path]) as batch:
        assert list(batch.articulations) == ["arm"]
        assert_allclose(batch.articulations["arm"].pose[:, :3], [[1, 0, 1], [2, 0, 1]], atol=1e-6)
        assert_allclose(batch.entities["at_file"].pose[:, :3], [[1, 3, 0], [2, 3, 0]], atol=1e-6)
        assert_allclose(batch.entities["at_root"].pose[:, :3], [[1, 3, 1], [2, 3, 1]], atol=1e-6)


def test_the_only_body_of_an_mjcf_becomes_the_entity(tmp_path: Path) -> None:
    _, batch = load(tmp_path, mujoco_of('<body name="rail" pos="0 0 2"><geom size="1"/></body>'), pose=[1, 0, 0])
    assert list(batch.entities) == ["robot"]
    assert_allclose(batch.entities["robot"].pose[0, :3], [1, 0, 2])


def test_a_body_named_dummy_root_is_not_the_world(tmp_path: Path) -> None:
    body = '<body name="dummy_root_7"><freejoint/><geom size="0.1"/></body>'
    rest = '<equality><weld body1="dummy_root_7" body2="world"/></equality>'
    _, batch = load(tmp_path, mujoco_of(body, rest))
    assert not batch.constraints


def test_a_drive_holds_the_position_of_mujocos_servo(tmp_path: Path) -> None:
    text = mujoco_of(
        '<body pos="0 0 1"><joint name="j" axis="0 1 0" damping="1"/><geom type="capsule" fromto="0 0 0 0.5 0 0" '
        'size="0.05" mass="1"/></body>',
        '<option timestep="0.002"/><actuator><position joint="j" kp="60" kv="6"/></actuator>',
    )
    model, batch = load(tmp_path, text)
    data = mujoco.MjData(model)
    for _ in range(2000):
        mujoco.mj_step(model, data)
        batch.step()
    assert data.qpos[0] > 0.03
    assert robot_of(batch).qpos[0, 0] == pytest.approx(data.qpos[0], rel=0.015)


def test_a_ball_joint_starts_at_the_keyframe(tmp_path: Path) -> None:
    q = np.array([0.6, -0.3, 0.5, 0.2])
    q /= np.linalg.norm(q)
    key = f'<keyframe><key name="k" qpos="{" ".join(map(str, q))}"/></keyframe>'
    body = '<body name="a" euler="30 0 0"><joint type="ball" pos="0.1 0 0"/><geom size="0.1"/></body>'
    model, batch = load(tmp_path, mujoco_of(body, key), keyframe="k")
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_kinematics(model, data)
    pose = robot_of(batch).objs[0].links[-1].entity_pose
    assert_allclose(pose.p, data.xpos[1], atol=1e-6)
    assert abs(np.dot(pose.q, data.xquat[1])) == pytest.approx(1, abs=1e-6)


def test_mjcf_terrain_and_planes_are_static(tmp_path: Path) -> None:
    ground = '<geom type="plane" size="0 0 1" pos="0 0 -2"/><geom type="hfield" hfield="hill" pos="1 0 0.1"/>'
    hill = '<asset><hfield name="hill" nrow="2" ncol="3" size="2 1 0.5 0.1" elevation="0 1 2 4 3 0"/></asset>'
    body = '<body name="ball" pos="1.7 0.6 2"><freejoint/><geom size="0.05"/></body>'
    model, batch = load(tmp_path, mujoco_of(ground + body, hill))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    terrain = batch.entities["robot/geom_1"].objs[0]
    (shape,) = terrain.components[-1].collision_shapes
    groups = np.array([1, 0, 0, 0, 0, 0], np.uint8)
    place = (terrain.pose * shape.local_pose).p
    for vertex in shape.vertices:
        start = vertex * 0.999 + place + [0, 0, 3]
        distance = mujoco.mj_ray(model, data, start, np.array([0.0, 0, -1]), groups, 1, -1, np.zeros(1, np.int32))
        assert start[2] - distance == pytest.approx(vertex[2] + place[2], abs=3e-3)


BAR = '<geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.03"/>'
LOOP = f"""
<body name="crank" pos="0 0 1"><joint name="a" axis="0 1 0"/>{BAR}
  <body name="rod" pos="0.5 0 0"><joint name="b" axis="0 1 0"/>{BAR}</body>
</body>
<body name="rocker" pos="1.5 0 1" euler="0 0 180"><joint name="c" axis="0 1 0"/>{BAR}</body>
<body name="load" pos="2 0 1"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="0.2"/></body>"""
LOOPS = {
    "bodies": '<connect body1="rod" body2="rocker" anchor="0.5 0 0"/><weld name="grip" body1="rocker" body2="load"/>',
    "turned": '<connect body1="rocker" body2="rod" anchor="0.5 0 0"/><weld body1="load" body2="rocker" '
    'relpose="-0.5 0.02 0.05 0 0 0 1"/>',
    "world": '<connect body1="rod" body2="world" anchor="0.5 0 0"/><weld body1="world" body2="load"/>',
}


@pytest.mark.parametrize("name", LOOPS)
def test_welds_and_connections_hold_as_in_mujoco(tmp_path: Path, name: str) -> None:
    rest = f"<equality>{LOOPS[name]}</equality>"
    model, batch = load(tmp_path, mujoco_of(LOOP, rest), pose=[3, 4, 0])
    data = mujoco.MjData(model)
    assert len(batch.constraints) == 2
    for _ in range(3000):
        mujoco.mj_step(model, data)
    for _ in range(600):
        batch.step()
    offset = np.array([3, 4, 0])
    links = {link.name: link.entity_pose for held in batch.articulations.values() for link in held.objs[0].links}
    links["load"] = batch.entities["robot/load"].objs[0].pose
    if name == "world":
        # It hangs still from the start.
        assert_allclose(links["load"].p - offset, data.body("load").xpos, atol=0.01)
        return
    tip = (links["rod"].to_transformation_matrix() @ [0.5, 0, 0, 1])[:3]
    other = (links["rocker"].to_transformation_matrix() @ [0.5, 0, 0, 1])[:3]
    assert_allclose(tip, other, atol=0.01)
    between = (links["rocker"].inv() * links["load"]).to_transformation_matrix()
    wanted = np.eye(4)
    mujoco.mju_quat2Mat(turn := np.zeros(9), model.eq_data[1][6:10])
    wanted[:3, :3], wanted[:3, 3] = turn.reshape(3, 3), model.eq_data[1][3:6]
    # MuJoCo has the pose of the second body in the first, and its welds are softer than PhysX's.
    assert_allclose(between, wanted if name == "bodies" else np.linalg.inv(wanted), atol=0.02)


@pytest.mark.parametrize("moved", ["", 'refpos="0.1 0 0" refquat="1 1 0 0" scale="1 2 1"'])
def test_signed_distances_of_meshes_are_those_of_their_triangles(tmp_path: Path, moved: str) -> None:
    vertices = "0 0 0  0.3 0 0  0 0.2 0  0 0 0.4  0.3 0.2 0"
    faces = "0 2 1  1 2 4  0 1 3  0 3 2  1 4 3  2 3 4"
    geom = '<geom type="sdf" mesh="wedge" pos="0.1 0.2 0.3" euler="40 0 10"/>'
    model, batch = load(
        tmp_path,
        mujoco_of(
            f'<body name="free" euler="10 20 30"><freejoint/>{geom}</body><body name="still" pos="1 0 0">{geom}</body>'
            f'<body name="arm" pos="2 0 0"><joint axis="1 0 0"/>{geom}</body>',
            f'<asset><mesh name="wedge" vertex="{vertices}" face="{faces}" {moved}/></asset>',
        ),
    )
    assert_same_machine(mujoco, model, batch)
    mujoco.mj_kinematics(model, data := mujoco.MjData(model))
    arm = robot_of(batch).objs[0]
    arm.qpos = np.zeros(1)
    bodies = [batch.entities["robot/free"].objs[0], batch.entities["robot/still"].objs[0]]
    for geom, entity in enumerate([*bodies, arm.links[-1].entity]):
        (shape,) = (shape for part in entity.components for shape in getattr(part, "collision_shapes", ()))
        assert type(shape).__name__ == "PhysxCollisionShapeTriangleMesh"
        pose = (entity.pose * shape.local_pose).to_transformation_matrix()
        built = np.asarray(shape.vertices) * shape.scale @ pose[:3, :3].T + pose[:3, 3]
        wanted = model.mesh_vert @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
        assert np.linalg.norm(built[:, None] - wanted, axis=2).min(axis=0).max() < 1e-5
