"""Centres of mass far from their links: the engine's rounding is no fault of anybody, and what it loses is refused."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from scenecc import SceneError, load_scene

if TYPE_CHECKING:
    from pathlib import Path

URDF = """
<robot name="r">
  <link name="base">
    <inertial><origin xyz="{com} {com} 0" rpy="0.1 0.2 0.3"/><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="arm"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="j" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 1" rpy="0.3 0.2 0.1"/><limit lower="-1" upper="1"/>
  </joint>
</robot>
"""


def test_a_centre_of_mass_a_kilometre_away_is_built(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(URDF.format(com=1234.567))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: r.urdf, pose: {p: [1, 2, 3], rpy: [0.3, 0.2, 0.7]}}}\n")
    with load_scene(scene, render=False) as batch:
        base, arm = batch.scenes[0].get_all_articulations()[0].links
        assert base.cmass_local_pose.p == pytest.approx([1234.567, 1234.567, 0])
        assert base.entity_pose.p == pytest.approx([1, 2, 3], abs=5e-3)
        assert arm.mass == pytest.approx(1000)


def test_a_centre_of_mass_beyond_the_engines_range_is_refused(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(URDF.format(com=1e6))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: r.urdf}}\n")
    with pytest.raises(SceneError) as caught:
        load_scene(scene, render=False)
    assert [told.code for told in caught.value.diagnostics] == ["SC512"]


@pytest.mark.parametrize("scale", ["1e5 1 1", "1 -1e19 1", "1e30 1 1", "3e38 1 1"])
def test_a_mesh_beyond_the_engines_range_is_refused(scale: str, tmp_path: Path) -> None:
    """What is wrong with the mesh is told, and nothing of the poses that follow from it."""
    lines = ["v 0 0 0", "v 1 0 0", "v 0 1 0", "v 0 0 1", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (tmp_path / "wedge.obj").write_text("\n".join(lines))
    mesh = f'<mesh filename="wedge.obj" scale="{scale}"/>'
    (tmp_path / "r.urdf").write_text(URDF.format(com=0).replace('<box size="1 1 1"/>', mesh))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: r.urdf, pose: {p: [1, 2, 3], rpy: [0.3, 0.2, 0.7]}}}\n")
    with pytest.raises(SceneError) as caught:
        load_scene(scene, render=False)
    assert {told.code for told in caught.value.diagnostics} == {"SC512"}


def test_a_mesh_of_a_kilometre_is_built(tmp_path: Path) -> None:
    lines = ["v 0 0 0", "v 1000 0 0", "v 0 1000 0", "v 0 0 1000", "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"]
    (tmp_path / "wedge.obj").write_text("\n".join(lines))
    (tmp_path / "r.urdf").write_text(URDF.format(com=0).replace('<box size="1 1 1"/>', '<mesh filename="wedge.obj"/>'))
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: r.urdf, pose: {p: [1, 2, 3], rpy: [0.3, 0.2, 0.7]}}}\n")
    with load_scene(scene, render=False) as batch:
        assert batch.scenes[0].get_all_articulations()[0].links[1].mass == pytest.approx(1e12 / 6, rel=1e-3)
