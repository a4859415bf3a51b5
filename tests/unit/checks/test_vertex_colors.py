"""Colours at vertices, which SAPIEN does not render."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import scenecc

COLLADA = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common>
<accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<source id="c"><float_array id="ca" count="12">1 0 0 1 0 0 1 0 0 1 0 0</float_array><technique_common>
<accessor source="#ca" count="4" stride="3"><param name="R" type="float"/><param name="G" type="float"/>
<param name="B" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"{material}><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="COLOR" source="#c" offset="1"/><p>0 0 2 2 1 1 0 0 1 1 3 3 0 0 3 3 2 2 1 1 2 2 3 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def box(suffix: str, color: tuple[int, int, int] | None = (255, 0, 0)) -> bytes:
    mesh: Any = trimesh.creation.box((0.2, 0.2, 0.2))
    if color is not None:
        mesh.visual.vertex_colors = np.array([*color, 255], np.uint8)
    content: Any = mesh.export(file_type=suffix)
    return content.encode() if isinstance(content, str) else content


def codes(folder: Path, file: str, **keys: Any) -> list[str]:
    body = {
        "pose": [0, 0, 0.1],
        "collisions": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}],
        "visuals": [{"type": "mesh", "file": str(folder / file), **keys}],
    }
    return [one.code for one in scenecc.validate({"scenecc": 1, "entities": {"a": body}}, asset_roots=[folder])]


@pytest.mark.parametrize("suffix", ["ply", "glb", "obj"])
def test_colours_without_a_material_are_reported(suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"red.{suffix}").write_bytes(box(suffix))
    (tmp_path / f"plain.{suffix}").write_bytes(box(suffix, None))
    (tmp_path / f"white.{suffix}").write_bytes(box(suffix, (255, 255, 255)))
    assert codes(tmp_path, f"red.{suffix}") == ["SC587"]
    assert codes(tmp_path, f"red.{suffix}", color=[1, 0, 0]) == []
    assert codes(tmp_path, f"plain.{suffix}") == []
    assert codes(tmp_path, f"white.{suffix}") == []


def test_colours_beside_a_material_are_not_reported(tmp_path: Path) -> None:
    (tmp_path / "a.mtl").write_text("newmtl m\nKd 1 0 0\n")
    (tmp_path / "red.obj").write_bytes(b"mtllib a.mtl\nusemtl m\n" + box("obj"))
    assert codes(tmp_path, "red.obj") == []


def test_colours_of_faces_and_of_a_collada_are_reported(tmp_path: Path) -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    header += "element face 4\nproperty list uchar int vertex_indices\n"
    header += "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    faces = "".join(f"3 {face} 0 0 255\n" for face in ("0 2 1", "0 1 3", "0 3 2", "1 2 3"))
    (tmp_path / "faces.ply").write_text(f"{header}end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n{faces}")
    (tmp_path / "red.dae").write_text(COLLADA.format(material=""))
    (tmp_path / "bound.dae").write_text(COLLADA.format(material=' material="m"'))
    assert codes(tmp_path, "faces.ply") == ["SC587"]
    assert codes(tmp_path, "red.dae") == ["SC587"]
    assert codes(tmp_path, "bound.dae") == []


def test_colours_in_robot_files_are_reported_at_their_line(tmp_path: Path) -> None:
    (tmp_path / "red.ply").write_bytes(box("ply"))
    visual = '<visual><geometry><mesh filename="red.ply"/></geometry>{}</visual>'
    urdf = '<robot name="r"><link name="l"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
    urdf += 'izz="1"/></inertial>\n{}</link></robot>'

    def told(content: str) -> list[tuple[str, int | None]]:
        (tmp_path / "r.urdf").write_text(content)
        (tmp_path / "s.yaml").write_text("scenecc: 1\nentities: {r: {urdf: r.urdf}}\n")
        return [(one.code, one.line) for one in scenecc.validate(tmp_path / "s.yaml") if one.code == "SC587"]

    assert told(urdf.format(visual.format(""))) == [("SC587", 2)]
    assert told(urdf.format(visual.format('<material name="m"><color rgba="1 0 0 1"/></material>'))) == []


@pytest.mark.parametrize(("rgba", "found"), [("", ["SC587"]), ('rgba="1 0 0 1"', [])])
def test_colours_of_an_mjcf_are_reported_unless_it_has_a_colour(rgba: str, found: list[str], tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "red.obj").write_bytes(box("obj"))
    geom = f'<geom type="mesh" mesh="m" contype="0" conaffinity="0" mass="0" {rgba}/><geom size="0.1"/>'
    mjcf = f'<mujoco><asset><mesh name="m" file="red.obj"/></asset><worldbody><body>{geom}</body></worldbody></mujoco>'
    (tmp_path / "m.xml").write_text(mjcf)
    (tmp_path / "s.yaml").write_text("scenecc: 1\nentities: {m: {mjcf: m.xml}}\n")
    assert [one.code for one in scenecc.validate(tmp_path / "s.yaml") if one.code == "SC587"] == found
