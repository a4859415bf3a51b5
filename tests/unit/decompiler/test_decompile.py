"""Live scenes as scene files."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import sapien
import yaml
from sapien import physx
from sapien.wrapper.urdf_loader import URDFLoader

import scenecc
from scenecc.decompiler import record as record_module
from scenecc.decompiler.prefabs import use_lights
from scenecc.decompiler.values import aimed_pose_value

ROOT = Path(__file__).parents[3]
ASSETS = ROOT / "scenes" / "assets"


def physical_scene() -> Any:
    return sapien.Scene([physx.PhysxCpuSystem()])


def add_box(scene: Any, name: str, half_size: list[float], pose: Any, **options: Any) -> Any:
    builder = scene.create_actor_builder()
    builder.add_box_collision(half_size=half_size, **options)
    body = builder.build(name=name)
    body.set_pose(pose)
    return body


def test_a_body_with_all_kinds_of_properties_is_decompiled() -> None:
    scene = physical_scene()
    scene.set_timestep(1 / 240)
    scene.add_ground(-1, render=False)
    rough = physx.PhysxMaterial(1.5, 1.25, 0.5)
    add_box(scene, "plain", [0.1, 0.2, 0.3], sapien.Pose([0, 0, 1]))
    body = add_box(
        scene, "heavy", [0.1, 0.1, 0.1], sapien.Pose([1, 0, 1], [0.5, 0.5, 0.5, 0.5]), material=rough, density=20
    )
    component = body.find_component_by_type(physx.PhysxRigidDynamicComponent)
    component.linear_damping = 0.5
    component.disable_gravity = True
    component.set_locked_motion_axes([True, False, False, False, False, True])
    component.linear_velocity = [1, 2, 3]
    found = scenecc.decompile(scene)
    assert found.is_equal, (found.problems, found.differences)
    assert found.document["physics"] == {"timestep": pytest.approx(1 / 240)}
    assert found.document["entities"]["ground"] == {
        "body_type": "static",
        "collisions": [{"type": "plane", "offset": -1.0}],
    }
    heavy = found.document["entities"]["heavy"]
    assert heavy["pose"]["p"] == [1.0, 0.0, 1.0]
    assert (heavy["gravity"], heavy["locked_axes"], heavy["linear_damping"]) == (False, ["x", "rz"], 0.5)


def test_mesh_files_are_known_only_if_recorded() -> None:
    def build() -> Any:
        scene = physical_scene()
        builder = scene.create_actor_builder()
        builder.add_convex_collision_from_file(str(ASSETS / "mug.obj"), scale=[2, 2, 2])
        builder.build(name="hull")
        builder = scene.create_actor_builder()
        builder.add_multiple_convex_collisions_from_file(str(ASSETS / "mug.obj"))
        builder.build_kinematic(name="parts").set_pose(sapien.Pose([1, 0, 0]))
        builder = scene.create_actor_builder()
        builder.add_nonconvex_collision_from_file(str(ASSETS / "mug.obj"))
        builder.build_static(name="triangles")
        return scene

    with scenecc.record() as recording:
        scene = build()
    found = scenecc.decompile(scene, recording=recording, base=ROOT / "scenes")
    assert found.is_equal, (found.problems, found.differences)
    shapes = {name: body["collisions"] for name, body in found.document["entities"].items()}
    assert shapes == {
        "hull": [{"type": "convex_mesh", "file": "assets/mug.obj", "scale": 2.0}],
        "parts": [{"type": "convex_parts", "file": "assets/mug.obj"}],
        "triangles": [{"type": "triangle_mesh", "file": "assets/mug.obj"}],
    }
    unknown = scenecc.decompile(build(), check=False)
    assert len(unknown.problems) == 3
    assert all("scenecc.record()" in problem for problem in unknown.problems)


UNLIMITED = pytest.approx(3.4028235e38)

ARM = """\
<robot name="arm">
  <link name="base"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
  <link name="upper"><collision><geometry><box size="0.1 0.1 0.4"/></geometry></collision></link>
  <link name="lower"><collision><geometry><box size="0.1 0.1 0.4"/></geometry></collision></link>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="100" velocity="5"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><origin xyz="0 0 0.5"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="5"/>
  </joint>
</robot>
"""


def test_a_robot_is_decompiled_as_its_urdf_with_differences(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    with scenecc.record() as recording:
        scene = physical_scene()
        loader = URDFLoader()
        loader.set_scene(scene)
        robot: Any = loader.load(str(tmp_path / "arm.urdf"))
        robot.set_name("arm")
        robot.set_qpos([0.25, 0.5])
        for joint in robot.active_joints:
            joint.set_drive_properties(200, 20)
        robot.links[-1].disable_gravity = True
    found = scenecc.decompile(scene, recording=recording, base=tmp_path)
    assert found.is_equal, (found.problems, found.differences)
    assert found.document["entities"]["arm"] == {
        "urdf": "arm.urdf",
        "qpos": [0.25, 0.5],
        "links": {"lower": {"gravity": False}},
        # SAPIEN's loader drops the file's efforts and velocities.
        "joints": {".*": {"max_velocity": 100.0}},
        "drives": {
            ".*": {"stiffness": 200.0, "damping": 20.0, "force_limit": pytest.approx(3.4028235e38), "target": 0.0}
        },
    }


def test_a_drive_that_is_a_ball_joint_is_decompiled_as_one() -> None:
    with scenecc.record() as recording:
        scenes = [physical_scene() for _ in range(2)]
        for number, scene in enumerate(scenes):
            builder = scene.create_actor_builder()
            builder.add_sphere_collision(radius=0.1)
            body: Any = builder.build(name="bob")
            for name, axes in (("ball", "xyz"), ("rail", "xy")):
                drive = scene.create_drive(None, sapien.Pose(), body, sapien.Pose())
                drive.name = name
                for axis in axes:
                    getattr(drive, f"set_limit_{axis}")(0, 0)
                drive.set_limit_twist(-1, 0.5 + number)
                drive.set_drive_property_slerp(0, 0.1)
    found = scenecc.decompile(scenes, recording=recording)
    assert found.is_equal, (found.problems, found.differences)
    constraints = found.document["constraints"]
    assert constraints["ball"] == {
        "type": "ball",
        "parent": "world",
        "child": "bob",
        "pose_in_parent": [0, 0, 0],
        "limits": {"per_scene": [[-1, 0.5], [-1, 1.5]]},
        "drive": {"damping": pytest.approx(0.1)},
    }
    assert constraints["rail"]["type"] == "drive"


def test_a_link_tree_is_decompiled() -> None:
    with scenecc.record() as recording:
        scene = physical_scene()
        builder = scene.create_articulation_builder()
        case = builder.create_link_builder()
        case.set_name("case")
        case.add_box_collision(half_size=[0.2, 0.2, 0.02])
        drawer = builder.create_link_builder(case)
        drawer.set_name("drawer")
        drawer.set_joint_name("slide")
        drawer.set_joint_properties("prismatic", [[0, 0.3]], sapien.Pose([0, 0, 0.06]), sapien.Pose(), 0.2, 3.0)
        drawer.add_box_collision(half_size=[0.1, 0.1, 0.03])
        articulation: Any = builder.build(fix_root_link=True)
        articulation.set_name("cabinet")
        articulation.set_qpos([0.1])
    found = scenecc.decompile(scene, recording=recording)
    assert found.is_equal, (found.problems, found.differences)
    cabinet = found.document["entities"]["cabinet"]
    assert cabinet["qpos"] == [pytest.approx(0.1)]
    assert cabinet["root"]["children"][0]["joint"]["limits"] == [0.0, pytest.approx(0.3)]


def test_quaternions_of_almost_unit_length_are_kept_exactly() -> None:
    """What a loader gives of an MJCF: PhysX normalises such quaternions in single precision, and once more."""
    with scenecc.record() as recording:
        scene = physical_scene()
        builder = scene.create_articulation_builder()
        torso = builder.create_link_builder()
        torso.set_name("torso")
        torso.add_box_collision(half_size=[0.1, 0.1, 0.1])
        arm = builder.create_link_builder(torso)
        arm.set_name("arm")
        arm.set_joint_name("shoulder")
        parent = sapien.Pose([0.1, 0, 0], [0, 1, 0, 0.002])
        child = sapien.Pose(q=[0.8804763, -0.3647052, -0.27984816, 0.1159169])
        arm.set_joint_properties("revolute", [[-1, 1]], parent, child)
        arm.add_capsule_collision(sapien.Pose([0.1, 0, 0], [0.8880738, 0, 0.3250576, -0.3250576]), 0.05, 0.2)
        robot: Any = builder.build(fix_root_link=True)
        robot.set_name("robot")
        robot.set_qpos([0.25])
    found = scenecc.decompile(scene, recording=recording)
    assert found.is_equal, (found.problems, found.differences)


def test_constraints_are_decompiled() -> None:
    with scenecc.record() as recording:
        scene = physical_scene()
        first = add_box(scene, "first", [0.1, 0.1, 0.1], sapien.Pose([0, 0, 1]))
        second = add_box(scene, "second", [0.1, 0.1, 0.1], sapien.Pose([0.5, 0, 1]))
        bodies = [each.find_component_by_type(physx.PhysxRigidDynamicComponent) for each in (first, second)]
        drive = scene.create_drive(bodies[0], sapien.Pose(), bodies[1], sapien.Pose([-0.5, 0, 0]))
        drive.set_limit_x(-0.1, 0.1, 0, 0)
        drive.set_drive_property_y(10, 1, 5, "acceleration")
        scene.create_connection(None, sapien.Pose([0, 0, 1.5]), bodies[0], sapien.Pose([0, 0, 0.5]))
    found = scenecc.decompile(scene, recording=recording)
    assert found.is_equal, (found.problems, found.differences)
    connection, held = found.document["constraints"].values()
    assert held["limits"] == {"x": [pytest.approx(-0.1), pytest.approx(0.1)]}
    assert (connection["type"], connection["limits"], connection["parent"]) == ("distance", [0.0, 0.0], "world")


CONNECTED = """
scenecc: 1
entities:
  post: {body_type: static, pose: [0, 0, 1], shapes: [{type: box, half_size: [0.1, 0.1, 0.1]}]}
  arm: {pose: [0.1, 0, 1], shapes: [{type: box, half_size: [0.1, 0.05, 0.05]}]}
  tip: {pose: [0.25, 0, 1], shapes: [{type: box, half_size: [0.1, 0.05, 0.05]}]}
constraints:
  first: {parent: post, child: arm, KEYS}
  second: {parent: arm, child: tip, type: weld}
  third: {parent: tip, child: arm, type: distance, limits: [0, 1]}
"""


def load_connected(keys: str) -> Any:
    return scenecc.load_scene(yaml.safe_load(CONNECTED.replace("KEYS", keys)), render=False)


@pytest.mark.parametrize(
    "keys",
    [
        "type: ball, collide: true",
        "type: ball, limits: [-0.5, 0.5], drive: {damping: 0.001}",
        "type: hinge, axis: y, limits_deg: [-30, 60], drive: {stiffness: 10, damping: 1, target: 0.2}, collide: true",
        "type: slider, axis: [1, 1, 0], limits: [0, 0.3], pose_in_child: {p: [0, 0, 0.1], rpy_deg: [0, 0, 30]}",
    ],
)
def test_constraints_of_scenecc_are_decompiled(keys: str) -> None:
    with scenecc.record() as recording, load_connected(keys) as batch:
        found = scenecc.decompile(batch.scenes, recording=recording)
        unrecorded = scenecc.decompile(batch.scenes, check=False)
    assert (found.problems, found.differences) == ((), ())
    collide = {name: each.get("collide", False) for name, each in found.document["constraints"].items()}
    # A hinge with a spring consists of two components.
    names = {"first", "second", "third", *(["first_2"] if "hinge" in keys else [])}
    assert collide == {name: "collide" in keys and name.startswith("first") for name in names}
    unknown = [each for each in unrecorded.problems if "collide" in each]
    assert len(unknown) == len(unrecorded.document["constraints"])
    assert all("scenecc.record()" in each for each in unknown)


def test_contacts_decide_whether_connected_bodies_collide() -> None:
    contacts: dict[bool, list[int]] = {}
    for collide in (True, False):
        keys = f"type: ball, collide: {str(collide).lower()}"
        with scenecc.record() as recording, load_connected(keys) as batch:
            found = scenecc.decompile(batch.scenes, recording=recording)
            batch.step()
            contacts[collide] = [len(batch.scenes[0].get_contacts())]
        with scenecc.load_scene(found.document, render=False) as batch:
            batch.step()
            contacts[collide].append(len(batch.scenes[0].get_contacts()))
    assert contacts == {True: [1, 1], False: [0, 0]}


def test_parallel_scenes_are_decompiled_to_one_file() -> None:
    def scene(index: int) -> Any:
        made = physical_scene()
        add_box(made, "box", [0.1, 0.1, 0.1 + 0.1 * index], sapien.Pose([0, 0, 1 + index]))
        return made

    found = scenecc.decompile([scene(index) for index in range(3)])
    assert found.is_equal, (found.problems, found.differences)
    assert found.document["num_scenes"] == 3


def test_differences_of_the_rebuilt_scene_are_listed() -> None:
    scene = physical_scene()
    builder = scene.create_actor_builder()
    builder.add_convex_collision_from_file(str(ASSETS / "mug.obj"))  # not recorded, so that a box stands for it
    builder.build(name="mug")
    assert scenecc.decompile(scene, check=False).differences is None
    found = scenecc.decompile(scene)
    assert not found.is_equal
    assert any("entity(mug)" in line for line in found.differences or ())


def test_decompile_refuses_other_objects() -> None:
    for source in ({"scenecc": 1}, [], [physical_scene(), 3]):
        with pytest.raises(TypeError, match=r"sapien\.Scene"):
            scenecc.decompile(source)


def test_decompile_refuses_a_gpu_simulation() -> None:
    system = type("PhysxGpuSystem", (), {})()
    with pytest.raises(TypeError, match="sim_backend"):
        scenecc.decompile(SimpleNamespace(physx_system=system, entities=[]))


def test_comparing_a_decompiled_scene_writes_no_file(tmp_path: Path) -> None:
    (tmp_path / "cube.obj").write_bytes((ASSETS / "mug.obj").read_bytes())
    with scenecc.record() as recording:
        scene = physical_scene()
        builder = scene.create_actor_builder()
        builder.add_convex_collision_from_file(str(tmp_path / "cube.obj"))
        builder.build(name="cube")
    before = tmp_path.stat().st_mtime_ns
    found = scenecc.decompile(scene, recording=recording, base=tmp_path)
    assert tmp_path.stat().st_mtime_ns == before  # a file that was made and removed would have changed it
    assert found.is_equal, found.differences
    assert found.document["entities"]["cube"]["collisions"][0]["file"] == "cube.obj"
    scene = physical_scene()
    assert scenecc.decompile(scene, base=tmp_path / "none").is_equal


def test_a_camera_is_decompiled_with_look_at() -> None:
    pose = sapien.Pose([0.6, 0.7, 0.6], [0.41419983, 0.11993399, 0.05516183, -0.9005618])
    aimed = aimed_pose_value(pose, mounted=False)
    assert aimed == {"p": pytest.approx([0.6, 0.7, 0.6]), "look_at": [0, 0, 0.35]}
    # Mounted, the other quaternion of the rotation would be a difference.
    assert set(aimed_pose_value(pose, mounted=True)) == {"p", "q"}
    assert aimed_pose_value(sapien.Pose([0, 0, 1]), mounted=False) == [0, 0, 1]
    turned = sapien.Pose([0, 0, 1], [0.5**0.5, 0, 0, 0.5**0.5])
    assert set(aimed_pose_value(turned, mounted=False)) == {"p", "rpy_deg"}


def test_lights_of_maniskill_become_an_include() -> None:
    white = [1.0, 1.0, 1.0]
    lights = {
        "a": {"type": "directional", "direction": [1.0, 1.0, -1.0], "color": white},
        "b": {"type": "directional", "direction": [0.0, 0.0, -1.0], "color": white},
    }
    document = {"environment": {"ambient_light": [0.30000001192092896] * 3}, "entities": {}, "lights": lights}
    (included,) = use_lights(document)["include"]
    assert len(scenecc.compile_scene({"scenecc": 1, "include": [included], "entities": {}}).lights) == 2
    for other in ({"environment": {}}, {"entities": {"sun": {}}}, {"lights": {"a": lights["a"]}}):
        assert use_lights(document | other) == document | other


def test_sapien_is_restored_after_a_recording() -> None:
    shape, loader = physx.PhysxCollisionShapeConvexMesh, URDFLoader
    before = shape.__init__, shape.load_multiple, loader.parse
    with pytest.raises(RuntimeError), record_module.record():
        shape("none.obj", [1, 1, 1], physx.get_default_material())
    assert (shape.__init__, shape.load_multiple, loader.parse) == before


@pytest.mark.render
def test_a_plain_sapien_script_is_decompiled() -> None:
    """SAPIEN's own tutorial on actors."""
    scene: Any = sapien.Scene()
    scene.add_ground(0)
    size, thickness, color = 1.0, 0.1, [0.8, 0.6, 0.4]
    builder = scene.create_actor_builder()
    top = sapien.Pose([0, 0, -thickness / 2])
    builder.add_box_collision(pose=top, half_size=[size / 2, size / 2, thickness / 2])
    builder.add_box_visual(pose=top, half_size=[size / 2, size / 2, thickness / 2], material=color)
    for i in (-1, 1):
        for j in (-1, 1):
            leg = sapien.Pose([i * (size - thickness) / 2, j * (size - thickness) / 2, -0.5])
            builder.add_box_collision(pose=leg, half_size=[0.05, 0.05, 0.5])
            builder.add_box_visual(pose=leg, half_size=[0.05, 0.05, 0.5], material=color)
    builder.build(name="table").set_pose(sapien.Pose([0, 0, 1]))
    builder = scene.create_actor_builder()
    builder.add_sphere_collision(radius=0.05)
    builder.add_sphere_visual(radius=0.05, material=[0, 1, 0])
    builder.build(name="sphere").set_pose(sapien.Pose([0, -0.2, 1.05]))
    scene.set_ambient_light([0.5, 0.5, 0.5])
    scene.add_directional_light([0, 1, -1], [0.5, 0.5, 0.5])
    found = scenecc.decompile(scene)
    assert found.is_equal, (found.problems, found.differences)
    assert found.text == (Path(__file__).with_name("create_actors.yaml")).read_text("utf-8")


def test_a_body_that_became_kinematic_is_read_again() -> None:
    scene = physical_scene()
    body = add_box(scene, "box", [0.1, 0.1, 0.1], sapien.Pose([0, 0, 1]))
    assert "body_type" not in scenecc.decompile(scene).document["entities"]["box"]
    body.find_component_by_type(physx.PhysxRigidDynamicComponent).kinematic = True
    found = scenecc.decompile(scene)
    assert found.document["entities"]["box"]["body_type"] == "kinematic"
    assert found.is_equal, found.differences


TRIANGLE = "mtllib cloth.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl cloth\nf 1/1 2/2 3/3\n"


@pytest.mark.render
def test_mesh_materials_equal_the_files_for_any_base(tmp_path: Path) -> None:
    (tmp_path / "textures").mkdir()
    (tmp_path / "textures" / "checker.png").write_bytes((ASSETS / "checker.png").read_bytes())
    (tmp_path / "cloth.obj").write_text(TRIANGLE)
    (tmp_path / "cloth.mtl").write_text("newmtl cloth\nmap_Kd textures/checker.png\n")
    scene: Any = sapien.Scene()
    builder = scene.create_actor_builder()
    builder.add_visual_from_file(str(tmp_path / "cloth.obj"))
    builder.build_kinematic(name="cloth")
    for base in (tmp_path, tmp_path / "textures"):  # the texture's path in the document depends on it
        found = scenecc.decompile(scene, base=base, check=False)
        assert "material" not in found.document["entities"]["cloth"]
