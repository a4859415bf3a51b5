"""Robots that are written as URDF, read again by SAPIEN's own loader and by scenecc, against those in their scenes."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
from sapien import physx

import scenecc
from scenecc import export_scene, open_scene
from scenecc.diagnostics import Diagnostic

ROOT = Path(__file__).parents[2]
BOX = {"type": "box", "half_size": [0.1, 0.2, 0.05]}
ROBOTS = [("robot_arm", "arm"), ("robot_arm", "tumbling"), ("robot_door", "door"), ("robot_gripper", "arm")]
TASKS = [("PickCube-v1", "panda"), ("RotateValveLevel2-v1", None), ("MS-HumanoidRun-v1", None), ("MS-AntRun-v1", None)]


def written(source: Any, folder: Path, entity: str | None = None, **options: Any) -> tuple[Path, list[Diagnostic]]:
    opened = source if isinstance(source, scenecc.Scene) else open_scene(source, **options)
    made = opened.emit("urdf", name="robot", entity=entity)
    files, found = made.files, made.diagnostics
    for name, content in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
    assert next(iter(files)) == "robot.urdf"
    return folder / "robot.urdf", found


def by_sapien(path: Path, *, fixed: bool) -> Any:
    """What SAPIEN's loader makes of a file, without anything seen, and the scene that holds it."""
    tree = ET.parse(path)
    for link in tree.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    bare = path.with_name("bare.urdf")
    tree.write(bare)
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    loader = scene.create_urdf_loader()
    loader.fix_root_link = fixed
    return scene, loader.load(str(bare))


def by_scenecc(path: Path, *, fixed: bool) -> Any:
    entity = {"urdf": str(path), "fix_root_link": fixed, "srdf": "none"}
    batch = scenecc.load_scene({"scenecc": 1, "entities": {"robot": entity}}, render=False, allow_outside_assets=True)
    return batch, batch.articulations["robot"].objs[0]


def tensor(link: Any) -> tuple[Any, np.ndarray]:
    """Where the centre of mass of a link is, and its inertia, in the world."""
    frame = link.entity.pose * link.cmass_local_pose
    turned = frame.to_transformation_matrix()[:3, :3].astype(np.float64)
    return frame.p, turned @ np.diag(link.inertia.astype(np.float64)) @ turned.T


def axis(joint: Any) -> np.ndarray:
    pose = joint.child_link.entity.pose * joint.pose_in_child
    return pose.to_transformation_matrix()[:3, 0]


def compare(ours: Any, theirs: Any, *, meshes: bool = True) -> None:
    """Asserts that two articulations have the same links, joints, masses and places, wherever they are moved."""
    joints = {joint.name or f"{joint.child_link.name}_joint": joint for joint in ours.active_joints}
    found = {joint.name: joint for joint in theirs.active_joints}
    assert joints.keys() == found.keys()
    links = {link.name: link for link in theirs.links}
    assert {link.name for link in ours.links} == links.keys()
    theirs.set_root_pose(ours.root_pose)
    moves = np.random.default_rng(3).uniform(-0.6, 0.6, len(joints))
    by_name = dict(zip(joints, moves, strict=True))
    for articulation in (ours, theirs):
        names = [joint.name or f"{joint.child_link.name}_joint" for joint in articulation.active_joints]
        if names:
            articulation.set_qpos(np.array([by_name[name] for name in names], np.float32))
        else:
            articulation.set_root_pose(articulation.root_pose)
    for name, joint in joints.items():
        np.testing.assert_allclose(found[name].limits, joint.limits, rtol=1e-6, atol=1e-6, err_msg=name)
        np.testing.assert_allclose(axis(found[name]), axis(joint), atol=2e-5, err_msg=name)
        assert (found[name].type == "prismatic") == (joint.type == "prismatic")
    for link in ours.links:
        other = links[link.name]
        assert other.mass == pytest.approx(link.mass, rel=1e-5)
        (place, inertia), (there, wanted) = tensor(other), tensor(link)
        np.testing.assert_allclose(place, there, atol=2e-5, err_msg=link.name)
        np.testing.assert_allclose(inertia, wanted, rtol=1e-4, atol=2e-5 * link.inertia.max(), err_msg=link.name)
        shapes = [each for each in link.collision_shapes if not isinstance(each, physx.PhysxCollisionShapePlane)]
        assert len(other.collision_shapes) == len(shapes)
        for a, b in zip(other.collision_shapes, shapes, strict=True):
            here, at = (each.entity.pose * shape.local_pose for each, shape in ((other, a), (link, b)))
            np.testing.assert_allclose(here.p, at.p, atol=2e-5)
            for size in ("half_size", "radius", "half_length"):
                if hasattr(b, size):
                    np.testing.assert_allclose(getattr(a, size), getattr(b, size), rtol=1e-5)
            if meshes and hasattr(b, "vertices"):
                assert (a.vertices * a.scale).min(axis=0) == pytest.approx((b.vertices * b.scale).min(axis=0), abs=1e-5)


def check(source: Any, name: str | None, folder: Path, **options: Any) -> list[Diagnostic]:
    """`name`: None is the first articulation."""
    opened = open_scene(source, **options)
    with opened.build(render=False, scene_idxs=[0]) as batch:
        name = name or next(iter(batch.articulations))
        path, found = written(opened, folder, name)
        ours = batch.articulations[name].objs[0]
        fixed = ours.links[0].joint.type == "fixed"
        for read in (by_sapien, by_scenecc):
            held, theirs = read(path, fixed=fixed)
            compare(ours, theirs)
            assert held is not None
    return found


@pytest.mark.parametrize(("scene", "name"), ROBOTS)
def test_a_robot_is_read_again_as_it_was(scene: str, name: str, tmp_path: Path) -> None:
    check(ROOT / f"scenes/{scene}.yaml", name, tmp_path)


@pytest.mark.maniskill
@pytest.mark.parametrize(("task", "name"), TASKS)
def test_a_robot_of_maniskill_is_read_again_as_it_was(task: str, name: str | None, tmp_path: Path) -> None:
    check(ROOT / f"scenes/maniskill/{task}.yaml", name, tmp_path, num_scenes=1)


def tree(joint: dict[str, Any], tip: dict[str, Any] | None = None) -> dict[str, Any]:
    children = [] if tip is None else [{"name": "tip", "joint": tip, "shapes": [BOX | {"pose": [0, 0.3, 0]}]}]
    rod = {"name": "rod", "joint": joint, "shapes": [BOX | {"pose": [0.3, 0, 0]}], "children": children}
    arm = {"root": {"name": "base", "shapes": [BOX], "children": [rod]}, "fix_root_link": True}
    return {"scenecc": 1, "entities": {"arm": arm}}


TURNED = {"p": [0.1, -0.2, 0.3], "rpy_deg": [40, 90, -20]}
INSIDE = {"p": [0.05, 0.1, -0.2], "rpy_deg": [10, -50, 70]}


@pytest.mark.parametrize("kind", ["revolute", "prismatic", "continuous", "fixed"])
def test_joints_anywhere_in_both_links_move_alike(kind: str, tmp_path: Path) -> None:
    joint: dict[str, Any] = {"type": kind, "name": "first", "pose_in_parent": TURNED, "pose_in_child": INSIDE}
    if kind in {"revolute", "prismatic"}:
        joint["limits"] = [-1, 2]
    tip = {"type": "revolute", "name": "second", "pose_in_parent": INSIDE, "pose_in_child": TURNED, "limits": [-3, 3]}
    found = check(tree(joint, tip), "arm", tmp_path)
    moved = [each.message for each in found if "frame of the link" in each.message]
    assert len(moved) == (2 if kind in {"revolute", "continuous"} else 1)


def test_what_a_joint_has_is_in_the_file(tmp_path: Path) -> None:
    joint = {"type": "revolute", "name": "first", "axis": [0, 1, 0], "limits": [-1, 2], "damping": 0.5, "friction": 0.2}
    follows = {"joint": "first", "multiplier": -0.5, "offset": 0.1}
    tip = {"type": "revolute", "name": "second", "axis": [0, 0, 1], "mimic": follows}
    path, found = written(tree(joint, tip), tmp_path)
    read = {element.get("name"): element for element in ET.parse(path).iter("joint")}
    dynamics, mimic = read["first"].find("dynamics"), read["second"].find("mimic")
    assert dynamics is not None
    assert mimic is not None
    assert dynamics.attrib == {"damping": "0.5", "friction": "0"}
    assert mimic.attrib == {"joint": "first", "multiplier": "-0.5", "offset": "0.1"}
    assert [each.message for each in found if "`friction` of a joint, a ratio" in each.message]


def test_drives_are_told(tmp_path: Path) -> None:
    source = tree({"type": "revolute", "name": "first", "limits": [-1, 2]})
    source["entities"]["arm"]["drives"] = {"first": {"stiffness": 10, "damping": 1, "force_limit": 7}}
    path, found = written(source, tmp_path)
    assert [(each.code, each.message) for each in found] == [
        ("SC740", "`arm`: left out: the drive of a joint, except its `force_limit`")
    ]
    limit = next(ET.parse(path).iter("limit"))
    assert limit.get("effort") == "7"


def test_a_body_is_a_robot_of_one_link(tmp_path: Path) -> None:
    body = {"pose": [1, 2, 3], "mass": 4, "shapes": [BOX | {"pose": [0.3, 0, 0]}, {"type": "sphere", "radius": 0.1}]}
    source = {"scenecc": 1, "entities": {"crate": body}}
    path, found = written(source, tmp_path, "crate")
    assert found == []
    with scenecc.load_scene(source, render=False) as batch:
        entity = {"urdf": str(path), "fix_root_link": False}
        again = scenecc.load_scene(
            {"scenecc": 1, "entities": {"crate": entity}}, render=False, allow_outside_assets=True
        )
        bodies: list[Any] = [
            each.entities["crate"].objs[0].find_component_by_type(physx.PhysxRigidDynamicComponent)
            for each in (batch, again)
        ]
        ours, theirs = bodies
        assert theirs.mass == pytest.approx(ours.mass)
        assert len(theirs.collision_shapes) == 2
        np.testing.assert_allclose(theirs.cmass_local_pose.p, ours.cmass_local_pose.p, atol=1e-6)
        np.testing.assert_allclose(sorted(theirs.inertia), sorted(ours.inertia), rtol=1e-5)


def test_what_is_seen_of_an_image_and_by_whom_is_told(tmp_path: Path) -> None:
    paint = {"base_color_texture": str(ROOT / "scenes" / "assets" / "checker.png")}
    body = {"body_type": "none", "hidden": True, "material": "paint", "visibility": 0.5}
    source = {
        "scenecc": 1,
        "materials": {"paint": {"visual": paint}},
        "entities": {"goal": {**body, "visuals": [{"type": "sphere", "radius": 0.1}]}},
    }
    path, found = written(source, tmp_path, "goal", allow_outside_assets=True)
    assert [each.message for each in found] == [
        "`goal`: left out: `hidden`, which hides it from sensors",
        "`goal`: left out: `visibility`",
    ]
    (texture,) = ET.parse(path).iter("texture")
    name = texture.attrib["filename"]
    assert name.startswith("robot.assets/checker-")
    assert (tmp_path / name).read_bytes() == (ROOT / "scenes" / "assets" / "checker.png").read_bytes()


def test_a_folder_has_a_file_for_each_articulation() -> None:
    files = export_scene(ROOT / "scenes/robot_arm.yaml", "urdf", folder=True)
    assert list(files) == ["arm.urdf", "tumbling.urdf"]


@pytest.mark.parametrize(
    ("scene", "entity", "words"),
    [
        ("robot_arm", None, "a file holds one robot, but scene 0 has `arm`, `tumbling`"),
        ("robot_arm", "leg", "there is no entity `leg` in scene 0; its articulations: `arm`, `tumbling`"),
        ("tabletop", None, "scene 0 has no articulation"),
    ],
)
def test_what_is_no_robot_is_refused(scene: str, entity: str | None, words: str) -> None:
    with pytest.raises(scenecc.SceneError) as error:
        export_scene(ROOT / f"scenes/{scene}.yaml", "urdf", entity=entity)
    assert [(each.code, each.message) for each in error.value.diagnostics if each.severity == "error"] == [
        ("SC915", words)
    ]


@pytest.mark.parametrize(
    "degrees", [(0, 0, 0), (10, 20, 30), (0, 90, 0), (30, -90, 10), (180, 45, -170), (5, 89.99999, 3)]
)
def test_turns_are_those_of_the_quaternion(degrees: tuple[float, float, float]) -> None:
    from scenecc.emit.urdf import roll_pitch_yaw

    def turned(angles: tuple[float, ...]) -> Any:
        pose: Any = sapien.Pose()
        pose.set_rpy(np.array(angles, np.float32))
        return pose.q.astype(np.float64)

    given = turned(tuple(math.radians(each) for each in degrees))
    w, x, y, z = (given / np.linalg.norm(given)).tolist()
    again = turned(roll_pitch_yaw((0.0, 0.0, 0.0, w, x, y, z)))
    assert abs(float(again @ given)) == pytest.approx(1, abs=1e-6)
