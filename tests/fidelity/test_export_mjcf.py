"""Models that are written for MuJoCo, compiled by it, against the same scenes in SAPIEN."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien

import scenecc
from scenecc.backends.sapien import SceneBatch
from scenecc.diagnostics import Diagnostic
from scenecc.plan import Mount

mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed")

ROOT = Path(__file__).parents[2]
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))
TASKS = [
    "PickCube-v1",
    "RotateValveLevel4-v1",
    "TriFingerRotateCubeLevel4-v1",
    "MS-AntRun-v1",
    "MS-HumanoidRun-v1",
    "MS-CartpoleBalance-v1",
]
"""With a robot of meshes, drawn parts, three fingers, and free, walking and sliding roots of MJCF files."""


pytestmark = pytest.mark.usefixtures("other_folder")


def compiled(source: Any, folder: Path, **options: Any) -> tuple[Any, Any, list[Diagnostic]]:
    """MuJoCo's model and data of a scene, where it starts, and the warnings."""
    return written(scenecc.open_scene(source, **options), folder)


def written(opened: scenecc.Scene, folder: Path, *, scene: int = 0) -> tuple[Any, Any, list[Diagnostic]]:
    """As `compiled`, of a scene that is opened."""
    made = opened.emit("mjcf", name="model", scene=scene)
    files, found = made.files, made.diagnostics
    assert next(iter(files)) == "model.xml"
    for name, content in files.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data, found


def bodies(batch: SceneBatch, row: int = 0) -> Iterator[tuple[str, Any, Any]]:
    """Names in the model, entities and components of all bodies in a scene of the batch."""
    index = batch.scene_idxs[row]
    for name, each in batch.entities.items():
        if index in each.scene_idxs:
            entity = each.objs[each.scene_idxs.index(index)]
            yield name, entity, entity.find_component_by_type(sapien.physx.PhysxRigidBaseComponent)
    for name, each in batch.articulations.items():
        if index in each.scene_idxs:
            for word, links in each.links.items():
                link = links[each.scene_idxs.index(index)]
                if link is not None:
                    yield f"{name}/{word}", link.entity, link


def matrix(quaternion: Any) -> np.ndarray:
    found = np.zeros(9)
    mujoco.mju_quat2Mat(found, np.array(quaternion, np.float64))
    return found.reshape(3, 3)


def compare(source: Any, folder: Path, *, scene: int = 0, **options: Any) -> None:
    """Asserts that a model has the bodies of SAPIEN: places, masses, inertias, shapes; joints and how they move."""
    opened = scenecc.open_scene(source, **options)
    model, data, _ = written(opened, folder, scene=scene)
    with opened.build(render=False, scene_idxs=[scene]) as batch:
        assert model.opt.timestep == pytest.approx(batch.timestep, rel=1e-6)
        np.testing.assert_allclose(model.opt.gravity, batch.scenes[0].physx_system.config.gravity, rtol=1e-6)
        compare_bodies(model, data, batch)
        compare_bits(model, batch)
        for name, articulation in batch.articulations.items():
            if scene in articulation.scene_idxs:
                compare_joints(model, data, batch, name)


def compare_bodies(model: Any, data: Any, batch: SceneBatch) -> None:
    count = 0
    for name, entity, component in bodies(batch):
        count += 1
        body = model.body(name)
        np.testing.assert_allclose(data.xpos[body.id], entity.pose.p, atol=1e-5, err_msg=name)
        np.testing.assert_allclose(matrix(data.xquat[body.id]), matrix(entity.pose.q), atol=1e-5, err_msg=name)
        assert (body.mocapid[0] >= 0) == (
            isinstance(component, sapien.physx.PhysxRigidDynamicComponent) and component.kinematic
        )
        if isinstance(component, sapien.physx.PhysxRigidBodyComponent):
            compare_mass(model, data, body.id, entity, component)
            if not (isinstance(component, sapien.physx.PhysxRigidDynamicComponent) and component.kinematic):
                compare_velocity(model, data, body.id, component)
        shapes = [] if component is None else component.collision_shapes
        geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body.id and model.geom_group[g] == 3]
        assert len(geoms) == len(shapes)
        for geom, shape in zip(geoms, shapes, strict=True):
            compare_shape(model, data, geom, shape, entity.pose * shape.local_pose)
    assert count == model.nbody - 1


def compare_mass(model: Any, data: Any, body: int, entity: Any, component: Any) -> None:
    assert model.body_mass[body] == pytest.approx(component.mass, rel=1e-5)
    frame = entity.pose * component.cmass_local_pose
    np.testing.assert_allclose(data.xipos[body], frame.p, atol=1e-5)
    theirs = matrix(frame.q) @ np.diag(component.inertia.astype(np.float64)) @ matrix(frame.q).T
    axes = data.ximat[body].reshape(3, 3)
    ours = axes @ np.diag(model.body_inertia[body]) @ axes.T
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-5 * component.inertia.max())
    assert model.body_gravcomp[body] == component.disable_gravity


def compare_velocity(model: Any, data: Any, body: int, component: Any) -> None:
    """A body's six numbers are about its centre of mass, the turn first."""
    found = np.zeros(6)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, found, 0)
    np.testing.assert_allclose(found[:3], component.angular_velocity, atol=1e-4)
    np.testing.assert_allclose(found[3:], component.linear_velocity, atol=1e-4)


KINDS = {
    sapien.physx.PhysxCollisionShapeBox: "BOX",
    sapien.physx.PhysxCollisionShapeSphere: "SPHERE",
    sapien.physx.PhysxCollisionShapeCapsule: "CAPSULE",
    sapien.physx.PhysxCollisionShapeCylinder: "CYLINDER",
    sapien.physx.PhysxCollisionShapePlane: "PLANE",
    sapien.physx.PhysxCollisionShapeConvexMesh: "MESH",
    sapien.physx.PhysxCollisionShapeTriangleMesh: "MESH",
}


def compare_shape(model: Any, data: Any, geom: int, shape: Any, pose: Any) -> None:
    kind = KINDS[type(shape)]
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_HFIELD:
        assert kind == "MESH"
        compare_height_field(model, data, geom, shape, pose)
        return
    assert model.geom_type[geom] == getattr(mujoco.mjtGeom, f"mjGEOM_{kind}")
    assert model.geom_friction[geom][0] == pytest.approx(shape.physical_material.dynamic_friction)
    axes, turned = data.geom_xmat[geom].reshape(3, 3), matrix(pose.q)
    if kind == "MESH":
        compare_mesh(model, data, geom, shape, pose)
        return
    np.testing.assert_allclose(data.geom_xpos[geom], pose.p, atol=1e-5)
    if kind == "BOX":
        np.testing.assert_allclose(axes, turned, atol=1e-5)
        np.testing.assert_allclose(model.geom_size[geom], shape.half_size, rtol=1e-6)
    elif kind == "SPHERE":
        assert model.geom_size[geom][0] == pytest.approx(shape.radius)
    else:
        np.testing.assert_allclose(axes[:, 2], turned[:, 0], atol=1e-5)
        if kind != "PLANE":
            np.testing.assert_allclose(model.geom_size[geom][:2], (shape.radius, shape.half_length), rtol=1e-6)


def compare_mesh(model: Any, data: Any, geom: int, shape: Any, pose: Any) -> None:
    """The vertices in the world: as they were cooked and scaled."""
    mesh = model.geom_dataid[geom]
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    ours = data.geom_xpos[geom] + model.mesh_vert[start : start + count] @ data.geom_xmat[geom].reshape(3, 3).T
    theirs = pose.p + (shape.vertices * shape.scale) @ matrix(pose.q).T
    apart = np.linalg.norm(ours[:, None] - theirs[None], axis=2)
    assert apart.min(axis=0).max() < 1e-5
    assert apart.min(axis=1).max() < 1e-5


def compare_height_field(model: Any, data: Any, geom: int, shape: Any, pose: Any) -> None:
    """The grid in the world: MuJoCo's rows run from -y to +y, and its heights from 0 to 1."""
    field = model.geom_dataid[geom]
    rows, columns, first = model.hfield_nrow[field], model.hfield_ncol[field], model.hfield_adr[field]
    x, y, top, _ = model.hfield_size[field]
    heights = model.hfield_data[first : first + rows * columns].reshape(rows, columns) * top
    along_y, along_x = np.meshgrid(np.linspace(-y, y, rows), np.linspace(-x, x, columns), indexing="ij")
    grid = np.stack([along_x, along_y, heights], axis=-1).reshape(-1, 3)
    ours = data.geom_xpos[geom] + grid @ data.geom_xmat[geom].reshape(3, 3).T
    theirs = pose.p + (shape.vertices * shape.scale) @ matrix(pose.q).T
    np.testing.assert_allclose(ours[np.lexsort(ours.T.round(3))], theirs[np.lexsort(theirs.T.round(3))], atol=1e-5)


def compare_bits(model: Any, batch: SceneBatch) -> None:
    """Whether two bodies collide by their bits: SAPIEN's rule, and MuJoCo's."""
    groups = {
        name: component.collision_shapes[0].collision_groups
        for name, _, component in bodies(batch)
        if component is not None and component.collision_shapes
    }
    excluded = {tuple(sorted((signature >> 16, signature & 0xFFFF))) for signature in model.exclude_signature.tolist()}
    tied = {tuple(sorted((model.body(a).id, model.body(b).id))) for a, b in tied_pairs(batch)}
    kept = [name for name in groups if model.body_weldid[model.body(name).id] != 0]
    for a, b in combinations(kept, 2):
        i, j = groups[a], groups[b]
        meet = bool(i[0] & j[1] or i[1] & j[0])
        ignored = bool(i[2] & j[2]) and i[3] & 0xFFFF == j[3] & 0xFFFF
        ids = tuple(sorted((model.body(a).id, model.body(b).id)))
        geoms = [
            next(g for g in range(model.ngeom) if model.geom_bodyid[g] == n and model.geom_group[g] == 3) for n in ids
        ]
        types, masks = model.geom_contype[geoms], model.geom_conaffinity[geoms]
        assert bool(types[0] & masks[1] or types[1] & masks[0]) == meet, (a, b)
        assert (ids in excluded) == (ignored or ids in tied), (a, b)


def tied_pairs(batch: SceneBatch) -> Iterator[tuple[str, str]]:
    """Bodies that PhysX keeps apart by themselves, and MuJoCo does not."""
    for constraint in batch.plan.constraints:
        if constraint.parent is not None:
            yield named(constraint.parent), named(constraint.child)


def named(mount: Mount) -> str:
    return mount.entity if mount.link is None else f"{mount.entity}/{mount.link}"


def compare_joints(model: Any, data: Any, batch: SceneBatch, name: str) -> None:
    """Axes, limits and the rest; then where all links are at other positions."""
    articulation = batch.articulations[name].objs[0]
    joints = {}
    for joint in articulation.active_joints:
        found = model.joint(f"{name}/{joint.name or joint.child_link.name}")
        joints[joint] = found
        frame = joint.child_link.entity.pose * joint.pose_in_child
        np.testing.assert_allclose(data.xaxis[found.id], matrix(frame.q)[:, 0], atol=1e-5)
        if joint.type != "prismatic":
            apart = data.xanchor[found.id] - frame.p
            np.testing.assert_allclose(np.cross(apart, data.xaxis[found.id]), 0, atol=1e-5)
        low, high = joint.limits[0]
        if low != high:
            assert model.jnt_limited[found.id] == (math.isfinite(low) or math.isfinite(high))
            for wanted, actual in zip((low, high), model.jnt_range[found.id], strict=True):
                if math.isfinite(wanted):
                    assert actual == pytest.approx(wanted, abs=1e-6)
                elif model.jnt_limited[found.id]:
                    assert abs(actual) == 1e10
        assert model.dof_armature[found.dofadr[0]] == pytest.approx(joint.armature[0], rel=1e-5)
    qpos = [float(data.qpos[found.qposadr[0]]) for found in joints.values()]
    np.testing.assert_allclose(qpos, articulation.qpos, atol=1e-6)
    rng = np.random.default_rng(7)
    moved = rng.uniform(-0.7, 0.7, len(joints)).astype(np.float32)
    other = mujoco.MjData(model)
    other.qpos[:], other.mocap_pos[:], other.mocap_quat[:] = data.qpos, data.mocap_pos, data.mocap_quat
    other.qpos[[found.qposadr[0] for found in joints.values()]] = moved
    mujoco.mj_kinematics(model, other)
    articulation.set_qpos(moved)
    for link in articulation.links:
        body = model.body(f"{name}/{link.name}").id
        np.testing.assert_allclose(other.xpos[body], link.entity.pose.p, atol=2e-5, err_msg=link.name)
        np.testing.assert_allclose(matrix(other.xquat[body]), matrix(link.entity.pose.q), atol=2e-5)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_scene_compiles_to_the_same_bodies(path: Path, tmp_path: Path) -> None:
    compare(path, tmp_path)


def test_any_scene_of_several_can_be_written(tmp_path: Path) -> None:
    compare(ROOT / "scenes/variation.yaml", tmp_path, scene=3)


@pytest.mark.maniskill
@pytest.mark.parametrize("name", TASKS)
def test_a_task_of_maniskill_compiles_to_the_same_bodies(name: str, tmp_path: Path) -> None:
    compare(ROOT / f"scenes/maniskill/{name}.yaml", tmp_path, num_scenes=1)
