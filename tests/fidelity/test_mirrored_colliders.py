"""Colliders that a robot's file mirrors: PhysX weighs them as the mirrored solid, whoever builds them."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
import trimesh
from fidelity.test_emit_python import assert_same
from plugins.sample_plans import ROOT

from scenecc import SceneError, compile_scene, load_scene
from scenecc.backends.sapien import geometry
from scenecc.backends.sapien.audit import masses
from scenecc.plan.json_codec import plan_to_json

if TYPE_CHECKING:
    from numpy.typing import NDArray

POINTS = np.array([[0, 0, 0], [0.4, 0, 0], [0, 0.2, 0], [0, 0, 0.3]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
SCALES = [tuple(np.multiply(signs, (1, 0.5, 2)).tolist()) for signs in product((1, -1), repeat=3) if min(signs) < 0]

URDF = """
<robot name="r">
  <link name="base"><collision><geometry><mesh filename="wedge.obj" scale="{scale}"/></geometry></collision></link>
  <link name="arm"><collision><geometry><mesh filename="mug.obj" scale="{scale}"/></geometry></collision></link>
  <joint name="j" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 1"/><limit lower="-1" upper="1"/>
  </joint>
</robot>
"""
MJCF = """
<mujoco>
  <asset><mesh name="wedge" file="wedge.obj" scale="{scale}"/></asset>
  <worldbody><body name="base" pos="0 0 1"><joint type="hinge"/><geom type="mesh" mesh="wedge"/></body></worldbody>
</mujoco>
"""
SCENE = """
scenecc: 1
entities:
  floor: {body_type: static, shapes: [{type: plane}]}
  hulls: {urdf: r.urdf, fix_root_link: false, pose: [0, 0, 1]}
  parts: {urdf: r.urdf, fix_root_link: false, load_multiple_collisions: true, pose: [3, 0, 1]}
  other: {mjcf: r.xml, pose: [6, 0, 1]}
"""


def write(folder: Path, scale: tuple[float, ...]) -> Path:
    words = " ".join(map(str, scale))
    (folder / "r.urdf").write_text(URDF.format(scale=words))
    (folder / "r.xml").write_text(MJCF.format(scale=words))
    (folder / "mug.obj").write_bytes((ROOT / "scenes/assets/mug.obj").read_bytes())
    lines = [f"v {x} {y} {z}" for x, y, z in POINTS] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in FACES]
    (folder / "wedge.obj").write_text("\n".join(lines))
    scene = folder / "scene.yaml"
    scene.write_text(SCENE)
    return scene


def links(scene: Any) -> dict[str, Any]:
    return {
        f"{number}/{link.name}": link
        for number, robot in enumerate(scene.get_all_articulations())
        for link in robot.links
        if link.collision_shapes
    }


def inertia(link: Any) -> NDArray[np.float64]:
    """About the centre of mass, along the axes of the link."""
    turn = link.cmass_local_pose.to_transformation_matrix()[:3, :3]
    return turn @ np.diag(link.inertia) @ turn.T


@pytest.mark.parametrize("scale", SCALES, ids=str)
def test_a_mirrored_collider_has_the_mass_of_the_mirrored_solid(scale: tuple[float, ...], tmp_path: Path) -> None:
    judge = trimesh.Trimesh(POINTS * scale, FACES if np.prod(scale) > 0 else FACES[:, ::-1], process=False)
    judge.density = 1000.0
    with load_scene(write(tmp_path, scale), render=False) as batch:
        made = links(batch.scenes[0])
        base = made["0/base"]
        assert base.mass == pytest.approx(judge.mass, rel=1e-5)
        assert base.cmass_local_pose.p == pytest.approx(judge.center_mass, abs=1e-6)
        assert inertia(base) == pytest.approx(judge.moment_inertia, rel=1e-3, abs=1e-5)
        assert made["1/base"].mass == base.mass
        assert made["2/base"].mass == pytest.approx(base.mass)  # which MuJoCo computes
        physics: Any = batch.scenes[0].physx_system
        touched = 0
        for _ in range(1000):
            batch.step()
            touched += len(physics.get_contacts())
        assert touched > 1000
        assert all(np.isfinite(link.entity_pose.p).all() for link in links(batch.scenes[0]).values())


def test_mirrored_convex_parts_have_the_mass_of_the_mirrored_solids(tmp_path: Path) -> None:
    found = []
    for scale in ((1, 1, 1), (1, -1, 1)):
        with load_scene(write(tmp_path, scale), render=False) as batch:
            arm = links(batch.scenes[0])["1/arm"]
            assert len(arm.collision_shapes) == 16
            found.append((arm.mass, arm.cmass_local_pose.p * scale, np.diag(inertia(arm))))
    for plain, mirrored in zip(*found, strict=True):
        assert mirrored == pytest.approx(plain, rel=1e-5, abs=1e-6)


def test_a_script_builds_a_mirrored_collider_bit_identically(tmp_path: Path) -> None:
    assert_same(compile_scene(write(tmp_path, (1, -2, 1))), tmp_path)


def test_a_plan_with_a_mirrored_collider_reads_back_from_json(tmp_path: Path) -> None:
    plan = compile_scene(write(tmp_path, (1, -2, 1)))
    path = tmp_path / "scene.plan.json"
    path.write_text(plan_to_json(plan))
    assert plan_to_json(compile_scene(path)) == path.read_text()


def test_the_audit_finds_a_wrong_mass_of_a_mirrored_collider(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As without the mending: the scale itself is given to PhysX."""
    monkeypatch.setattr(geometry, "mirror_meshes", lambda meshes, scale, *, parts: meshes)
    monkeypatch.setattr(geometry, "to_vectors", lambda scale: list(scale * (1, -1, 1)))
    with pytest.raises(SceneError, match="mass") as caught:
        load_scene(write(tmp_path, (1, -1, 1)), render=False)
    assert {told.code for told in caught.value.diagnostics if told.severity == "error"} == {"SC802"}


@pytest.mark.parametrize("body", ["body_type: static", "inertial: {mass: 1, inertia: [1, 1, 1]}"])
def test_the_mass_of_every_cooked_mesh_is_checked(body: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also those of bodies whose mass no shape gives: the process would end at the first contact."""
    write(tmp_path, (1, -1, 1))
    scene = tmp_path / "weighed.yaml"
    shape = "collisions: [{type: convex_mesh, file: wedge.obj}]"
    scene.write_text(f"scenecc: 1\nentities: {{a: {{{body}, {shape}}}}}\n")
    load_scene(scene, render=False).close()
    monkeypatch.setattr(masses, "enclosed_volume", lambda _: 0.0045)
    with pytest.raises(SceneError, match="volume of the cooked mesh") as caught:
        load_scene(scene, render=False)
    assert [told.code for told in caught.value.diagnostics if told.severity == "error"] == ["SC802"]


def test_an_unwritable_cache_folder_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = write(tmp_path, (1, -1, 1))
    monkeypatch.setenv("XDG_CACHE_HOME", str(scene))
    with pytest.raises(SceneError, match="XDG_CACHE_HOME") as caught:
        load_scene(scene, render=False)
    assert {told.code for told in caught.value.diagnostics if told.severity == "error"} == {"SC801"}


def test_a_mesh_below_a_milligram_is_refused(tmp_path: Path) -> None:
    write(tmp_path, (1, -1, 1))
    scene = tmp_path / "light.yaml"
    light = "{shapes: [{type: convex_mesh, file: wedge.obj, scale: 0.0005}]}"
    scene.write_text(f"scenecc: 1\nentities:\n  speck: {light}\n")
    with pytest.raises(SceneError, match="`speck` weighs 5e-10 kg") as caught:
        load_scene(scene, render=False)
    assert [told.code for told in caught.value.diagnostics] == ["SC511"]


def test_a_mesh_below_a_milligram_by_density_is_refused_despite_its_mass(tmp_path: Path) -> None:
    """SAPIEN gives it an inertia of its own, which the mass would scale."""
    write(tmp_path, (1, -1, 1))
    scene = tmp_path / "light.yaml"
    light = "{mass: 1, shapes: [{type: convex_mesh, file: wedge.obj, scale: 0.0005}]}"
    scene.write_text(f"scenecc: 1\nentities:\n  speck: {light}\n")
    with pytest.raises(SceneError, match="`speck` weighs 5e-10 kg") as caught:
        load_scene(scene, render=False)
    assert [told.code for told in caught.value.diagnostics] == ["SC511"]
