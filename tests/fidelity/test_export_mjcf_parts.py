"""What holds bodies together and moves them, in the models that are written for MuJoCo, and what these have not."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fidelity.test_export_mjcf import compare, compiled
from plugins.plan_parts import ROOT

import scenecc

mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed")

BOX = {"type": "box", "half_size": [0.1, 0.1, 0.1]}
BALL_APART = {"type": "sphere", "radius": 0.1, "pose": [2, 0, 0]}
FIXED = {"body_type": "static", "shapes": [BOX]}


pytestmark = pytest.mark.usefixtures("other_folder")


def scene(entities: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"scenecc": 1, "entities": entities, **more}


def arm(tip: Any = None, **more: Any) -> dict[str, Any]:
    rod = {
        "name": "rod",
        "joint": {"type": "revolute", "name": "turn", "axis": [0, 1, 0], "limits": [-2, 2]},
        "shapes": [BOX | {"pose": [0.3, 0, 0]}],
        "children": [] if tip is None else [tip],
    }
    return {"root": {"name": "base", "shapes": [BOX], "children": [rod]}, "fix_root_link": True, **more}


def residual(data: Any) -> np.ndarray:
    """How far the equalities are from being met."""
    return data.efc_pos[: data.ne]


def test_a_drive_pulls_by_its_numbers(tmp_path: Path) -> None:
    drive = {"stiffness": 30, "damping": 4, "force_limit": 20, "target": 0.4, "velocity_target": 0.5}
    model, data, _ = compiled(scene({"arm": arm(drives={"turn": drive})}), tmp_path)
    for position, speed in ((0.0, 0.0), (0.3, -0.7), (-1.5, 0.0)):
        data.qpos[0], data.qvel[0] = position, speed
        mujoco.mj_forward(model, data)
        force = 30 * (0.4 - position) + 4 * (0.5 - speed)
        assert data.qfrc_actuator[0] == pytest.approx(min(max(force, -20), 20), rel=1e-5)


def test_a_drive_without_stiffness_is_a_damper(tmp_path: Path) -> None:
    model, _, found = compiled(scene({"arm": arm(drives={"turn": {"damping": 4}})}), tmp_path)
    assert model.nu == 0
    assert model.dof_damping[0] == 4
    assert found == []


def test_a_joint_that_follows_another_is_where_it_is_to_be(tmp_path: Path) -> None:
    mimic = {"joint": "turn", "multiplier": -0.5, "offset": 0.1}
    bend = {"type": "revolute", "name": "bend", "axis": [0, 1, 0], "mimic": mimic}
    robot = arm({"name": "tip", "joint": bend, "shapes": [BOX]}, qpos={"turn": 0.25})
    model, data, _ = compiled(scene({"arm": robot}), tmp_path)
    for position in (0.25, -0.4, 1.1):
        data.qpos[:] = position, -0.5 * position + 0.1
        mujoco.mj_forward(model, data)
        assert data.ne == 1
        np.testing.assert_allclose(residual(data), 0, atol=1e-6)


@pytest.mark.parametrize("kind", ["weld", "connection"])
def test_frames_that_meet_are_held_together_wherever_the_bodies_are(kind: str, tmp_path: Path) -> None:
    tie = {
        "type": kind,
        "parent": "a",
        "child": "b",
        "pose_in_parent": {"p": [0.2, 0.1, 0], "rpy_deg": [0, 30, 0]},
        "pose_in_child": {"p": [0, 0, 0.15], "rpy_deg": [20, 0, 0]},
    }
    entities = {
        "a": {"pose": {"p": [0, 0, 1], "rpy_deg": [10, 0, 40]}, "shapes": [BOX]},
        "b": {"pose": [2, 0, 1], "shapes": [BOX]},
    }
    source = scene(entities, constraints={"tie": tie})
    model, data, found = compiled(source, tmp_path)
    assert found == []
    assert np.abs(residual(data)).max() > 1
    # Where SAPIEN puts the child so that both frames meet.
    import sapien

    in_parent = sapien.Pose([0.2, 0.1, 0]) * sapien.Pose(q=_rpy(0, 30, 0))
    in_child = sapien.Pose([0, 0, 0.15]) * sapien.Pose(q=_rpy(20, 0, 0))
    place = sapien.Pose(data.qpos[:3], data.qpos[3:7]) * in_parent * in_child.inv()
    data.qpos[7:10], data.qpos[10:14] = place.p, place.q
    mujoco.mj_forward(model, data)
    assert len(residual(data)) == (6 if kind == "weld" else 3)
    np.testing.assert_allclose(residual(data), 0, atol=1e-5)
    assert model.nexclude == 1


def _rpy(*degrees: float) -> Any:
    from transforms3d.euler import euler2quat

    return euler2quat(*np.deg2rad(degrees))


@pytest.mark.parametrize(("ignoring", "contacts", "codes"), [("none", 1, []), ("both", 0, []), ("one", 1, ["SC731"])])
def test_bits_of_shapes_say_which_bodies_meet(ignoring: str, contacts: int, codes: list[str], tmp_path: Path) -> None:
    """The first shape of each body meets nothing, so the others decide. Read by SAPIEN and by MuJoCo."""
    bits = {"none": ([1, 1, 0, 0],) * 2, "both": ([1, 1, 4, 0],) * 2, "one": ([1, 1, 4, 0], [1, 1, 0, 0])}[ignoring]
    far = {"type": "sphere", "radius": 0.01, "pose": [0, 0, 5], "collision_bits": [0, 0, 0, 0]}
    ball = {"type": "sphere", "radius": 0.1}
    other = [BALL_APART | {"collision_bits": [1, 1, 4, 0]}] if ignoring == "one" else []
    entities = {
        "a": {"shapes": [far, ball | {"collision_bits": [1, 1, 4, 0] if ignoring == "one" else bits[0]}]},
        "b": {"pose": [0.19, 0, 0], "shapes": [far, *other, ball | {"collision_bits": bits[1]}]},
        "empty": {"body_type": "static", "shapes": []},
    }
    source = scene(entities, physics={"gravity": [0, 0, 0]})
    _, data, found = compiled(source, tmp_path)
    assert [one.code for one in found] == codes
    assert data.ncon == contacts
    with scenecc.load_scene(source, render=False) as batch:
        batch.step()
        assert len(batch.contacts().separation) == contacts


def test_a_distance_is_a_tendon(tmp_path: Path) -> None:
    entities = {"a": {"pose": [0, 0, 1], "shapes": [BOX]}}
    ties = {
        "rope": {"type": "distance", "parent": "world", "child": "a", "pose_in_parent": [0, 0, 0], "limits": [0.2, 3]},
        "rod": {"type": "distance", "parent": "world", "child": "a", "pose_in_parent": [0, 0, 3], "limits": [1.5, 1.5]},
        "spring": {
            "type": "distance",
            "parent": "world",
            "child": "a",
            "limits": [0.2, 0.5],
            "stiffness": 10,
            "damping": 2,
        },
    }
    model, data, _ = compiled(scene(entities, constraints=ties), tmp_path)
    rope, rod, spring = (model.tendon(name) for name in ("rope", "rod", "spring"))
    assert [data.ten_length[each.id] for each in (rope, rod)] == pytest.approx([1, 2])
    np.testing.assert_allclose(model.tendon_range[rope.id], (0.2, 3))
    np.testing.assert_allclose(residual(data), [0.5], atol=1e-6)
    assert float(np.ravel(model.tendon_stiffness[spring.id])[0]) == 10
    assert float(np.ravel(model.tendon_damping[spring.id])[0]) == 2
    assert model.tendon_lengthspring[spring.id].tolist() == pytest.approx([0.2, 0.5])


def test_axes_that_are_locked_are_no_joints(tmp_path: Path) -> None:
    pose = {"p": [0, 0, 1], "rpy_deg": [10, 20, 30]}
    entities = {
        "flat": {
            "pose": pose,
            "shapes": [BOX],
            "locked_axes": ["z"],
            "linear_velocity": [1, 2, 0],
            "angular_velocity": [1, 2, 3],
        },
        "top": {"pose": pose, "shapes": [BOX], "locked_axes": ["x", "y", "rx", "ry"], "angular_velocity": [0, 0, 3]},
        "still": {"pose": pose, "shapes": [BOX], "locked_axes": ["x", "y", "z", "rx", "ry", "rz"]},
        "odd": {"pose": pose, "shapes": [BOX], "locked_axes": ["rx"]},
    }
    compare(scene(entities), tmp_path)
    model, _, found = compiled(scene(entities), tmp_path)
    assert [model.body(name).dofnum[0] for name in entities] == [5, 2, 0, 6]
    assert [(each.code, each.message) for each in found] == [
        ("SC730", "`odd`: left out: `locked_axes` that leave two axes of rotation")
    ]


def test_velocities_at_the_start_are_those_of_the_centre_of_mass(tmp_path: Path) -> None:
    shapes = [BOX, BOX | {"pose": [0.6, 0, 0], "density": 4000}]
    body = {
        "pose": {"p": [0, 0, 1], "rpy_deg": [10, 20, 30]},
        "shapes": shapes,
        "linear_velocity": [1, 2, 3],
        "angular_velocity": [4, -5, 6],
    }
    compare(scene({"thrown": body}), tmp_path)
    model, data, _ = compiled(scene({"thrown": body}), tmp_path)
    found = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, 1, found, 0)
    np.testing.assert_allclose(found, [4, -5, 6, 1, 2, 3], atol=1e-5)


def test_a_camera_sees_what_it_sees_in_sapien(tmp_path: Path) -> None:
    lens = {"intrinsic": {"fx": 300, "fy": 320, "cx": 150, "cy": 130}}
    cameras = {
        "wide": {"pose": {"p": [1, 2, 3], "look_at": [0, 0, 0]}, "width": 640, "height": 480, "fovy_deg": 50},
        "pixels": {"pose": {"p": [1, 2, 3], "look_at": [0, 0, 0]}, "width": 320, "height": 240, **lens},
    }
    model, data, found = compiled(scene({"a": {"shapes": [BOX]}}, cameras=cameras), tmp_path)
    assert found == []
    wide, pixels = model.camera("wide"), model.camera("pixels")
    forward = -np.array([1, 2, 3]) / math.sqrt(14)
    for camera in (wide, pixels):
        axes = data.cam_xmat[camera.id].reshape(3, 3)
        np.testing.assert_allclose(-axes[:, 2], forward, atol=1e-6)
        assert axes[2, 1] > 0
        assert axes[2, 0] == pytest.approx(0, abs=1e-6)
    assert wide.fovy[0] == pytest.approx(50)
    assert model.cam_resolution[pixels.id].tolist() == [320, 240]
    seen = mujoco.MjvScene(model, 100)
    view = mujoco.MjvCamera()
    view.type, view.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, pixels.id
    mujoco.mjv_updateScene(model, data, mujoco.MjvOption(), None, view, mujoco.mjtCatBit.mjCAT_ALL, seen)
    # The middle of MuJoCo's two eyes; its frustum is what is seen at the distance `near`.
    eye = seen.camera[0]
    width, height = 2 * eye.frustum_width, eye.frustum_top - eye.frustum_bottom
    left = eye.frustum_center - eye.frustum_width
    assert [-left / width * 320, eye.frustum_top / height * 240] == pytest.approx([150, 130], rel=1e-4)
    assert [eye.frustum_near / width * 320, eye.frustum_near / height * 240] == pytest.approx([300, 320], rel=1e-4)


def test_a_camera_without_perspective_sees_as_much(tmp_path: Path) -> None:
    cameras = {"flat": {"pose": [0, 0, 3], "width": 640, "height": 480, "orthographic": {"top": 0.7}}}
    model, _, _ = compiled(scene({"a": {"shapes": [BOX]}}, cameras=cameras), tmp_path)
    assert model.cam_projection.tolist() == [int(mujoco.mjtProjection.mjPROJ_ORTHOGRAPHIC)]
    assert model.cam_fovy.tolist() == pytest.approx([1.4])


def test_lights_shine_as_they_do_in_sapien(tmp_path: Path) -> None:
    lights = {
        "sun": {"type": "directional", "direction": [1, 1, -1], "color": [0.5, 0.6, 0.7]},
        "bulb": {"type": "point", "position": [1, 2, 3], "color": [1, 2, 3]},
    }
    source = scene({"a": {"shapes": [BOX]}}, lights=lights, environment={"ambient_light": [0.1, 0.2, 0.3]})
    model, data, _ = compiled(source, tmp_path)
    np.testing.assert_allclose(data.light_xdir[model.light("sun").id], np.array([1, 1, -1]) / math.sqrt(3), atol=1e-6)
    np.testing.assert_allclose(data.light_xpos[model.light("bulb").id], [1, 2, 3], atol=1e-6)
    np.testing.assert_allclose(model.light_diffuse, [[0.5, 0.6, 0.7], [1, 2, 3]], rtol=1e-6)
    np.testing.assert_allclose(model.vis.headlight.ambient, [0.1, 0.2, 0.3], rtol=1e-6)
    assert model.vis.headlight.diffuse.tolist() == [0, 0, 0]


def test_a_spot_light_that_is_as_bright_up_to_its_edge_loses_nothing(tmp_path: Path) -> None:
    spot = {"type": "spot", "position": [0, 0, 3], "direction": [0, 0, -1], "color": [1, 1, 1], "outer_fov_deg": 60}
    lights = {"hard": spot | {"inner_fov_deg": 60}, "soft": spot | {"inner_fov_deg": 40}}
    model, _, found = compiled(scene({"a": {"shapes": [BOX]}}, lights=lights), tmp_path)
    assert model.light_cutoff.tolist() == pytest.approx([30, 30])
    assert model.light_exponent[model.light("hard").id] == 0
    assert [(each.code, each.message) for each in found] == [("SC730", "`soft`: left out: `inner_fov` of a light")]


@pytest.mark.parametrize("thin", [0.02, 0.0003, 0.00001])
def test_a_flat_body_has_moments_that_mujoco_takes(thin: float, tmp_path: Path) -> None:
    sizes = [[0.1 + 0.0137 * i, 0.07 + 0.0091 * i, thin] for i in range(20)]
    entities = {f"b{i}": {"shapes": [BOX | {"half_size": size}]} for i, size in enumerate(sizes)}
    compare(scene(entities), tmp_path)


def test_moments_that_no_body_has_are_lowered_with_a_warning(tmp_path: Path) -> None:
    inertial = '<inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".4" ixy="0" ixz="0" iyz="0"/></inertial>'
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    (tmp_path / "arm.urdf").write_text(
        f'<robot name="r"><link name="a"/><link name="b">{inertial}</link>{joint}</robot>'
    )
    source = scene({"arm": {"urdf": str(tmp_path / "arm.urdf")}})
    model, _, found = compiled(source, tmp_path, allow_outside_assets=True)
    assert model.body("arm/b").inertia.tolist() == pytest.approx([0.1, 0.1, 0.2])
    assert [each.code for each in found if "moment of inertia" in each.message] == ["SC731"]


def test_a_plane_that_is_seen_may_move(tmp_path: Path) -> None:
    seen = {"type": "plane", "half_size": [0.3, 0.2]}
    entities = {
        "still": {"body_type": "static", "visuals": [seen]},
        "moved": {"body_type": "kinematic", "collisions": [BOX], "visuals": [seen]},
        "thrown": {"collisions": [BOX], "visuals": [seen]},
    }
    model, _, _ = compiled(scene(entities), tmp_path)
    geoms = [g for g in range(model.ngeom) if model.geom_group[g] == 0]
    kinds = [mujoco.mjtGeom(model.geom_type[g]).name for g in geoms]
    assert kinds == ["mjGEOM_PLANE", "mjGEOM_PLANE", "mjGEOM_MESH"]
    mesh = model.geom_dataid[geoms[2]]
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    assert sorted(np.ptp(vertices, axis=0).tolist()) == pytest.approx([0, 0.4, 0.6], abs=1e-6)


def test_a_joint_that_cannot_move_is_held(tmp_path: Path) -> None:
    robot = arm(qpos={"turn": 0.5}, joints={"turn": {"limits": [0.5, 0.5]}})
    model, data, _ = compiled(scene({"arm": robot}), tmp_path)
    assert (data.ne, model.jnt_limited[0]) == (1, 0)
    np.testing.assert_allclose(residual(data), 0, atol=1e-6)
    data.qpos[0] = 0.7
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(residual(data), 0.2, atol=1e-6)


def test_colours_are_those_of_the_materials(tmp_path: Path) -> None:
    entities = {"a": {"shapes": [BOX | {"material": "red"}]}}
    materials = {"red": {"visual": {"base_color": [0.8, 0.1, 0.2, 0.5], "roughness": 0.3, "metallic": 0.7}}}
    model, _, _ = compiled(scene(entities, materials=materials), tmp_path)
    seen = next(g for g in range(model.ngeom) if model.geom_group[g] == 0)
    material = model.geom_matid[seen]
    # sRGB of linear 0.8, 0.1 and 0.2 (IEC 61966-2-1).
    np.testing.assert_allclose(model.mat_rgba[material], [0.906332, 0.349190, 0.484529, 0.5], rtol=1e-6)
    assert (model.mat_roughness[material], model.mat_metallic[material]) == pytest.approx((0.3, 0.7))
    assert model.geom_contype[seen] == model.geom_conaffinity[seen] == 0


def test_an_image_stands_in_place_of_the_colour_and_is_seen_through_as_its_body(tmp_path: Path) -> None:
    (tmp_path / "checker.png").write_bytes((ROOT / "scenes" / "assets" / "checker.png").read_bytes())
    path = tmp_path / "scene.yaml"
    path.write_text(
        "scenecc: 1\n"
        "materials: {paint: {visual: {base_color: [1, 0, 0, 0.2], base_color_texture: checker.png}}}\n"
        "entities: {a: {body_type: static, material: paint, visibility: 0.5, "
        "shapes: [{type: box, half_size: [1, 1, 1]}]}}\n"
    )
    (tmp_path / "out").mkdir()
    model, _, _ = compiled(path, tmp_path / "out")
    (seen,) = (g for g in range(model.ngeom) if model.geom_group[g] == 0)
    np.testing.assert_allclose(model.mat_rgba[model.geom_matid[seen]], [1, 1, 1, 0.5])


def test_what_mujoco_has_not_is_told_where_it_is(tmp_path: Path) -> None:
    text = """\
scenecc: 1
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  ball:
    pose: [0, 0, 1]
    linear_damping: 0.5
    max_angular_velocity: 3
    shapes: [{type: sphere, radius: 0.1, contact_offset: 0.01}]
"""
    path = tmp_path / "scene.yaml"
    path.write_text(text)
    (tmp_path / "out").mkdir()
    _, _, found = compiled(path, tmp_path / "out")
    assert [(each.code, each.severity, each.location.line, each.message) for each in found] == [
        ("SC730", "warning", 5, "`ball`: left out: `linear_damping`, `max_angular_velocity`"),
        ("SC730", "warning", 8, "`ball`: left out: `contact_offset` of a shape"),
    ]
