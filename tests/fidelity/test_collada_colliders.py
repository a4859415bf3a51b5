"""COLLADA files that collide: PhysX gets the triangles of the file, in metres, whoever builds them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from fidelity.test_emit_python import assert_same
from trimesh.exchange.dae import export_collada
from unit.assets.test_mesh_dae import DAE

import scenecc
from scenecc import SceneError, compile_scene, load_scene

physx: Any = pytest.importorskip("sapien").physx

POINTS = np.array([[1, 0, 0], [11, 0, 0], [1, 20, 0], [1, 0, 30]]) * 0.01
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
TWO = DAE.replace('<node id="n">', '<node id="m"><instance_geometry url="#g"/></node><node id="n">').replace(
    "<translate>1 0 0", "<translate>50 0 0"
)
URDF = """
<robot name="r">
  <link name="base"><collision><geometry><mesh filename="wedge.dae" scale="1 -2 1"/></geometry></collision></link>
  <link name="arm"><collision><geometry><mesh filename="two.DAE"/></geometry></collision></link>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 0 1"/></joint>
</robot>
"""
SCENE = """
scenecc: 1
entities:
  hull: {shapes: [{type: convex_mesh, file: wedge.dae}]}
  one_of_two: {shapes: [{type: convex_mesh, file: {cycle: [wedge.dae, wedge.stl]}}], pose: [0, 0, 9]}
  parts: {shapes: [{type: convex_parts, file: two.DAE}], pose: [0, 0, 1]}
  ground: {body_type: static, shapes: [{type: triangle_mesh, file: two.DAE}], pose: [0, 0, -1]}
  robot: {urdf: r.urdf, load_multiple_collisions: true, pose: [3, 0, 1]}
"""


def write(folder: Path, scene: str = SCENE) -> Path:
    for name, text in (("wedge.dae", DAE), ("two.DAE", TWO), ("r.urdf", URDF), ("scene.yaml", scene)):
        (folder / name).write_text(text, encoding="utf-8")
    trimesh.Trimesh(POINTS, FACES, process=False).export(folder / "wedge.stl")
    return folder / "scene.yaml"


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def dynamic(batch: Any, name: str) -> list[Any]:
    return [body.find_component_by_type(physx.PhysxRigidDynamicComponent) for body in batch.entities[name].objs]


def test_a_collada_collider_has_the_mass_of_its_volume(tmp_path: Path) -> None:
    with load_scene(write(tmp_path), num_scenes=2, render=False) as batch:
        hull = dynamic(batch, "hull")[0]
        assert hull.mass == pytest.approx(trimesh.Trimesh(POINTS, FACES).volume * 1000, rel=1e-5)
        found = sorted(hull.collision_shapes[0].vertices.tolist())
        assert np.array(found) == pytest.approx(np.array(sorted(POINTS.tolist())), abs=1e-7)
        parts = dynamic(batch, "parts")[0]
        assert len(parts.collision_shapes) == 2
        assert parts.mass == pytest.approx(2 * hull.mass, rel=1e-5)
        assert [body.mass for body in dynamic(batch, "one_of_two")] == pytest.approx([hull.mass] * 2, rel=1e-5)
        links: Any = batch.articulations["robot"].objs[0].links
        assert [link.mass for link in links] == pytest.approx([2 * hull.mass] * 2, rel=1e-5)
        assert len(links[1].collision_shapes) == 2
        batch.step(10)


def test_triangles_of_a_collada_file_are_cached_until_it_changes(tmp_path: Path) -> None:
    scene = write(tmp_path)
    folder = tmp_path / "cache/scenecc/collada"
    load_scene(scene, render=False).close()
    assert len(list(folder.iterdir())) == 2
    (tmp_path / "wedge.dae").write_text(DAE.replace("0 0 30", "0 0 60"), encoding="utf-8")
    with load_scene(scene, render=False) as batch:
        hull = dynamic(batch, "hull")[0]
        assert hull.mass == pytest.approx(2 * trimesh.Trimesh(POINTS, FACES).volume * 1000, rel=1e-5)
    assert len(list(folder.iterdir())) == 3


def test_coacd_decomposes_a_collada_file_in_metres(tmp_path: Path) -> None:
    pytest.importorskip("coacd")
    cut = "scenecc: 1\nentities: {cut: {shapes: [{type: convex_parts, file: two.DAE, decomposition: coacd}]}}"
    with load_scene(write(tmp_path, cut), render=False) as batch:
        body = dynamic(batch, "cut")[0]
        assert body.mass == pytest.approx(2 * trimesh.Trimesh(POINTS, FACES).volume * 1000, rel=0.2)


def test_a_script_builds_a_collada_collider_bit_identically(tmp_path: Path) -> None:
    assert_same(compile_scene(write(tmp_path), num_scenes=2), tmp_path)


def test_a_script_builds_collada_vertices_in_the_same_order(tmp_path: Path) -> None:
    """The order in which PhysX gets them shows in how a hull of many vertices rolls."""
    ball = trimesh.creation.icosphere(subdivisions=2).apply_scale([0.1, 0.2, 0.3])
    (tmp_path / "ball.dae").write_bytes(export_collada(ball))
    text = (
        "scenecc: 1\nentities:\n  ball: {shapes: [{type: convex_mesh, file: ball.dae}], pose: [0, 0, 1]}\n"
        "  ground: {body_type: static, shapes: [{type: plane}]}\n"
    )
    assert_same(compile_scene(write(tmp_path, text)), tmp_path)


@pytest.mark.parametrize("target", ["mjcf", "urdf", "usd", "glb"])
def test_a_collada_collider_is_exported(tmp_path: Path, target: str) -> None:
    pytest.importorskip({"mjcf": "mujoco", "usd": "pxr"}.get(target, "trimesh"))
    robot = "scenecc: 1\nentities: {robot: {urdf: r.urdf}}"
    assert scenecc.export_scene(write(tmp_path, robot), target)


def test_an_unreadable_part_of_a_collada_file_is_an_error(tmp_path: Path) -> None:
    """pycollada would go on without it."""
    scene = write(tmp_path)
    normals = '<input semantic="VERTEX" source="#v" offset="0"/><input semantic="NORMAL" source="#n" offset="0"/>'
    text = TWO.replace('<input semantic="VERTEX" source="#v" offset="0"/>', normals)
    (tmp_path / "two.DAE").write_text(text, encoding="utf-8")
    with pytest.raises(SceneError, match=r"two\.DAE") as caught:
        load_scene(scene, render=False)
    assert {told.code for told in caught.value.diagnostics if told.severity == "error"} == {"SC412"}


LAMPS = """<node id="lamp"><instance_light url="#lamp-light"/><instance_camera url="#none"><extra/></instance_camera>
</node>"""


def test_lamps_and_cameras_without_a_library_are_ignored(tmp_path: Path) -> None:
    scene = write(tmp_path, "scenecc: 1\nentities: {robot: {urdf: r.urdf, load_multiple_collisions: true}}")
    for file in (tmp_path / "wedge.dae", tmp_path / "two.DAE"):
        file.write_text(file.read_text().replace('<node id="n">', f'{LAMPS}<node id="n">'), encoding="utf-8")
    assert_same(compile_scene(scene), tmp_path)
