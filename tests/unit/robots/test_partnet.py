"""A PartNet-Mobility object as it is downloaded: `mobility.urdf`, a mesh for each small part in `textured_objs`, images
beside them, no mass anywhere, and some of the files that it names missing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from unit.assets.test_assets import png

import scenecc

if TYPE_CHECKING:
    from pathlib import Path

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
FACES = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")

PARTS = {
    # Link: (name of the visual, centre, size) of each part.
    "link_0": [("door-5", (0.2, 0, 0.31), (0.4, 0.6, 0.02)), ("handle-9", (0.35, 0, 0.335), (0.02, 0.2, 0.03))],
    "link_1": [("drawer_front-12", (0, -0.5, 0.3), (0.8, 0.2, 0.02)), ("drawer_box-14", (0, -0.5, 0), (0.7, 0.1, 0.5))],
    "link_2": [("knob-21", (0, 0.55, 0.33), (0.05, 0.05, 0.04))],
    "link_3": [
        ("vertical_side_panel-2", (-0.41, 0, 0), (0.02, 1.2, 0.6)),
        ("vertical_side_panel-2", (0.41, 0, 0), (0.02, 1.2, 0.6)),
        ("back_panel-3", (0, 0, -0.31), (0.8, 1.2, 0.02)),
    ],
}
JOINTS = """
	<joint name="joint_0" type="revolute">
		<origin xyz="-0.4 0 0.3"/><axis xyz="0 1 0"/><child link="link_0"/><parent link="link_3"/>
		<limit lower="-1.5707963267948966" upper="0"/>
	</joint>
	<joint name="joint_1" type="prismatic">
		<origin xyz="0 0 0"/><axis xyz="0 0 1"/><child link="link_1"/><parent link="link_3"/>
		<limit lower="0" upper="0.48000000000000004"/>
	</joint>
	<joint name="joint_2_helper" type="prismatic">
		<origin xyz="0 0.55 0.33"/><axis xyz="0 0 1"/><child link="link_2_helper"/><parent link="link_3"/>
		<limit lower="-0.01" upper="0"/>
	</joint>
	<joint name="joint_2" type="continuous">
		<origin xyz="0 0 0"/><axis xyz="0 0 1"/><child link="link_2"/><parent link="link_2_helper"/>
	</joint>
	<joint name="joint_3" type="fixed">
		<origin rpy="1.570796326794897 0 -1.570796326794897" xyz="0 0 0"/><child link="link_3"/><parent link="base"/>
	</joint>
"""
MATERIALS = "newmtl material_0\nKd 0.5 0.4 0.3\nmap_Kd ../images/texture_{}.png\n"


def write_partnet(folder: Path) -> dict[str, float]:
    """Writes the object without its image 3 and the materials of its last part. Returns each link's volume [m³]."""
    objs = folder / "textured_objs"
    objs.mkdir()
    (folder / "images").mkdir()
    origins = {"link_0": (0.4, 0, -0.3), "link_2": (0, -0.55, -0.33)}
    links, number, volumes = ['<link name="base"/>', '<link name="link_2_helper"/>'], 0, {}
    for link, parts in PARTS.items():
        origin = '<origin xyz="{} {} {}"/>'.format(*origins.get(link, (0, 0, 0)))
        shapes: list[str] = []
        for name, centre, size in parts:
            mesh = f'{origin}<geometry><mesh filename="textured_objs/original-{number}.obj"/></geometry>'
            shapes.append(f'<visual name="{name}">{mesh}</visual><collision>{mesh}</collision>')
            lines = [f"mtllib original-{number}.mtl", f"o object_{number}"]
            lines += ["v {} {} {}".format(*corner) for corner in CORNERS * size + centre]
            lines += ["usemtl material_0", *(f"f {face}" for face in FACES)]
            (objs / f"original-{number}.obj").write_text("\n".join(lines) + "\n")
            (objs / f"original-{number}.mtl").write_text(MATERIALS.format(number))
            (folder / "images" / f"texture_{number}.png").write_bytes(png())
            number += 1
        links.append(f'<link name="{link}">{"".join(shapes)}</link>')
        volumes[link] = sum(float(np.prod(size)) for _, _, size in parts)
    (folder / "images" / "texture_3.png").unlink()
    (objs / f"original-{number - 1}.mtl").unlink()
    content = "\n".join(links) + JOINTS
    (folder / "mobility.urdf").write_text(f'<?xml version="1.0" ?>\n<robot name="partnet_0a1b2c">{content}</robot>\n')
    return volumes


@pytest.fixture
def cabinet(tmp_path: Path) -> tuple[Path, dict[str, float]]:
    volumes = write_partnet(tmp_path)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {cabinet: {urdf: mobility.urdf, repair: [inertia, limits, files]}}\n")
    return scene, volumes


def test_a_partnet_robot_builds_with_repair(cabinet: tuple[Path, dict[str, float]]) -> None:
    scene, volumes = cabinet
    told = scenecc.validate(scene)
    assert [(d.code, d.message) for d in told] == [
        ("SC488", "textured_objs/original-3.obj references `../images/texture_3.png`, which is missing; it is ignored"),
        ("SC488", "textured_objs/original-7.obj references `original-7.mtl`, which is missing; it is ignored"),
    ]
    with scenecc.load_scene(scene, render=False) as batch:
        robot: Any = batch.articulations["cabinet"].objs[0]
        masses = {link.name: link.mass for link in robot.links}
        assert {name: masses[name] for name in volumes} == pytest.approx({n: 1000 * v for n, v in volumes.items()})
        limits = {joint.name: joint.limits[0].tolist() for joint in robot.active_joints}
        assert limits["joint_0"] == pytest.approx([-np.pi / 2, 0])
        assert limits["joint_1"] == pytest.approx([0, 0.48])
        assert limits["joint_2"] == [-np.inf, np.inf]
        robot.qpos = np.array([{"joint_1": 0.2}.get(joint.name, 0) for joint in robot.active_joints], np.float32)
        drawer = next(link for link in robot.links if link.name == "link_1")
        # Turned as PartNet turns everything: its z axis is x of the world.
        assert np.abs(drawer.entity.pose.p) == pytest.approx([0.2, 0, 0], abs=1e-6)
        batch.step(100)
        assert np.isfinite(robot.qpos).all()


def test_without_repair_each_missing_file_is_an_error(cabinet: tuple[Path, dict[str, float]]) -> None:
    scene, _ = cabinet
    scene.write_text("scenecc: 1\nentities: {cabinet: {urdf: mobility.urdf}}\n")
    told = scenecc.validate(scene)
    assert [d.code for d in told] == ["SC418", "SC418"]
    assert all("`repair: [files]`" in (d.hint or "") for d in told)
