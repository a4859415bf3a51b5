"""`repair` of a URDF: what each repair makes of a file, that it is told, and that nothing is repaired unasked."""

from __future__ import annotations

import base64
import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import scenecc
from scenecc.backends.sapien.assets import visual_file
from scenecc.diagnostics import Sink
from scenecc.robots.files import MAX_MISSING
from scenecc.robots.urdf import read_urdf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.robots.description import DescribedLink

BOX = '<collision><geometry><box size="1 2 0.5"/></geometry></collision>'
ZEROS = 'ixy="0" ixz="0" iyz="0"'

IMPOSSIBLE = {
    "zero moment": f'<inertia ixx="0" iyy="1" izz="1" {ZEROS}/>',
    "negative moment": f'<inertia ixx="-1" iyy="1" izz="1" {ZEROS}/>',
    "triangle": f'<inertia ixx="1" iyy="1" izz="3" {ZEROS}/>',
    "all zero": f'<inertia ixx="0" iyy="0" izz="0" {ZEROS}/>',
    "none": "",
}


BUILT: list[Any] = []
"""Scenes whose robots are looked at: without its scene a robot has no numbers."""


def joint(kind: str, inner: str = "", name: str = "j", ends: str = "ab") -> str:
    return f'<joint name="{name}" type="{kind}"><parent link="{ends[0]}"/><child link="{ends[1]}"/>{inner}</joint>'


def write(folder: Path, content: str) -> Path:
    file = folder / "robot.urdf"
    file.write_text(f'<robot name="r">{content}</robot>', encoding="utf-8")
    return file


def read(folder: Path, content: str, *repair: str) -> tuple[tuple[DescribedLink, ...] | None, list[str]]:
    """The links of the first robot, and the codes and messages of what is told."""
    file, sink = write(folder, content), Sink()
    found = read_urdf(ResolvedFile(file, file.name), scope=AssetScope(folder), sink=sink, repair=frozenset(repair))
    return None if found is None else found.robots[0].links, [f"{d.code} {d.message}" for d in sink.diagnostics()]


def build(folder: Path, content: str, *repair: str) -> Any:
    write(folder, content)
    entity = {"urdf": "robot.urdf", "repair": list(repair)}
    scene = folder / "scene.yaml"
    scene.write_text(f"scenecc: 1\nentities: {{r: {entity}}}\n", encoding="utf-8")
    built = scenecc.load_scene(scene, render=False)
    BUILT.append(built)
    return built.articulations["r"].objs[0]


@pytest.mark.parametrize("inertia", IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_an_impossible_inertia_is_computed_from_the_collision_shapes(tmp_path: Path, inertia: str) -> None:
    content = f'<link name="a"><inertial><mass value="3"/>{inertia}</inertial>{BOX}</link><link name="b"/>'
    links, told = read(tmp_path, content + joint("fixed"), "inertia")
    assert links is not None
    assert [line[:5] for line in told] == ["SC488"]
    assert "of its 1 collision shape, scaled to 3 kg" in told[0]
    base = build(tmp_path, content + joint("fixed"), "inertia").links[0]
    # A solid box: m / 12 · (b² + c²).
    expected = [3 / 12 * (2**2 + 0.5**2), 3 / 12 * (1 + 0.5**2), 3 / 12 * (1 + 2**2)]
    assert base.mass == pytest.approx(3, rel=1e-6)
    assert sorted(base.inertia) == pytest.approx(sorted(expected), rel=1e-5)


def test_a_repaired_inertia_keeps_the_centre_of_mass(tmp_path: Path) -> None:
    inertial = '<inertial><origin xyz="0.1 0 0.3" rpy="0 1 0"/><mass value="3"/></inertial>'
    base = build(tmp_path, f'<link name="a">{inertial}{BOX}</link><link name="b"/>' + joint("fixed"), "inertia").links[
        0
    ]
    assert base.mass == pytest.approx(3, rel=1e-6)
    assert base.cmass_local_pose.p == pytest.approx([0.1, 0, 0.3])
    assert sorted(base.inertia) == pytest.approx([0.3125, 1.0625, 1.25], rel=1e-5)


def test_a_link_without_collision_shapes_gets_the_inertia_of_a_water_sphere(tmp_path: Path) -> None:
    inertial = '<inertial><origin xyz="0 0 0.3"/><mass value="2"/></inertial>'
    content = f'<link name="a">{BOX}</link><link name="b">{inertial}</link>' + joint("fixed")
    links, told = read(tmp_path, content, "inertia")
    assert links is not None
    assert links[1].inertial is not None
    radius = (3 * 2 / (4 * math.pi * 1000)) ** (1 / 3)
    assert links[1].inertial.inertia == pytest.approx([0.4 * 2 * radius**2] * 3)
    assert links[1].inertial.com[:3] == pytest.approx((0, 0, 0.3))
    assert any("a sphere of water of 2 kg" in one for one in told)


def test_an_inertial_without_mass_is_left_out(tmp_path: Path) -> None:
    content = f'<link name="a"><inertial><inertia ixx="1" iyy="1" izz="1" {ZEROS}/></inertial>{BOX}</link>'
    content += f'<link name="b">{BOX}</link>' + joint("fixed")
    links, told = read(tmp_path, content, "inertia")
    assert links is not None
    assert told == ["SC488 <inertial> of `a` has no <mass>: it is left out"]
    assert links[0].inertial is None
    assert build(tmp_path, content, "inertia").links[0].mass == pytest.approx(1000)
    links, told = read(tmp_path, content, "limits", "files")
    assert (links, told) == (None, ["SC455 <inertial> has no <mass>"])


def shape(tag: str, what: str) -> str:
    return f"<{tag}><geometry><{what}/></geometry></{tag}>"


UNSEEN = ['sphere radius="0"', 'cylinder radius="0" length="1"', 'capsule radius="-0.0" length="0"', 'box size="0 1 0"']
SEEN_ONLY = ['cylinder radius="1" length="0"', 'box size="1 0 1"']


@pytest.mark.parametrize("what", UNSEEN)
def test_an_invisible_visual_is_left_out(tmp_path: Path, what: str) -> None:
    seen = BOX.replace("collision", "visual")
    content = f'<link name="foot">{shape("visual", what)}{seen}{BOX}</link>'
    links, told = read(tmp_path, content)
    assert links is not None
    assert len(links[0].visuals) == 1
    assert [line[:5] for line in told] == ["SC491"]
    assert f"<{what.split(maxsplit=1)[0]}> of `foot` has size" in told[0]


@pytest.mark.parametrize("what", SEEN_ONLY)
def test_a_visual_with_a_partly_zero_size_is_an_error(tmp_path: Path, what: str) -> None:
    links, told = read(tmp_path, f'<link name="a">{shape("visual", what)}{BOX}</link>', "shapes")
    assert (links, [line[:5] for line in told]) == (None, ["SC466"])


@pytest.mark.parametrize("what", [*UNSEEN, *SEEN_ONLY])
def test_a_collision_without_volume_is_left_out_with_repair_shapes(tmp_path: Path, what: str) -> None:
    inertial = '<inertial><mass value="3"/></inertial>'
    content = f'<link name="foot">{shape("collision", what)}{BOX}{inertial}</link>'
    links, told = read(tmp_path, content, "inertia", "shapes")
    assert links is not None
    assert len(links[0].collisions) == 1
    assert told[0].endswith("and no volume: the <collision> is left out")
    assert "that of its 1 collision shape," in told[1]
    alone, told = read(tmp_path, content.replace(BOX, ""), "inertia", "shapes")
    assert alone is not None
    assert "that of a sphere of water" in told[1]
    write(tmp_path, content)
    (tmp_path / "scene.yaml").write_text(
        "scenecc: 1\nentities: {r: {urdf: robot.urdf, repair: [inertia, limits, files]}}\n", encoding="utf-8"
    )
    found = [each for each in scenecc.validate(tmp_path / "scene.yaml") if each.severity == "error"]
    assert {each.code for each in found} == {"SC466"}
    assert all("set `repair: [shapes]` in the scene" in (each.hint or "") for each in found)


@pytest.mark.parametrize("what", ['sphere radius="-1"', 'box size="0 -1 1"', 'capsule radius="1" length="0"'])
def test_invalid_sizes_stay_errors_with_repair_shapes(tmp_path: Path, what: str) -> None:
    links, told = read(tmp_path, f'<link name="a">{shape("collision", what)}{BOX}</link>', "shapes")
    assert (links, {line[:5] for line in told}) == (None, {"SC466"})


def test_a_pair_of_unknown_links_is_left_out_with_repair_files(tmp_path: Path) -> None:
    content = "".join(f'<link name="{name}">{BOX}</link>' for name in "abc")
    content += joint("fixed") + joint("continuous", name="c", ends="bc")
    pairs = "".join(f'<disable_collisions link1="a" link2="{name}" reason="Default"/>' for name in ("c", "x", "y"))
    (tmp_path / "robot.srdf").write_text(f'<robot name="r">{pairs}</robot>', encoding="utf-8")
    links, told = read(tmp_path, content, "files")
    assert links is not None
    assert told == ["SC488 2 pairs with links that the robot does not have are left out"]
    assert [link.ignore_bits for link in links] == [1, 0, 1]
    links, told = read(tmp_path, content, "inertia", "limits")
    assert links is None
    assert [line[:5] for line in told] == ["SC471", "SC471"]


def test_a_repaired_mass_is_scaled(tmp_path: Path) -> None:
    content = f'<link name="a"><inertial><mass value="3"/></inertial>{BOX}</link>'
    file, sink = write(tmp_path, content), Sink()
    scope = AssetScope(tmp_path)
    found = read_urdf(ResolvedFile(file, file.name), scope=scope, sink=sink, scale=2.0, repair=frozenset({"inertia"}))
    assert found is not None
    inertial = found.robots[0].links[0].inertial
    assert inertial is not None
    assert (inertial.mass, inertial.inertia) == (24, None)


@pytest.mark.parametrize(
    ("kind", "limit", "type_", "limits"),
    [
        ("revolute", "", "revolute", (-math.inf, math.inf)),
        ("revolute", '<limit effort="1" velocity="1"/>', "revolute", (-math.inf, math.inf)),
        ("revolute", '<limit lower="-1"/>', "revolute_unwrapped", (-1, math.inf)),
        ("prismatic", "", "prismatic", (-math.inf, math.inf)),
        ("prismatic", '<limit upper="0.5"/>', "prismatic", (-math.inf, 0.5)),
    ],
)
def test_a_missing_limit_means_no_limit_with_repair_limits(
    tmp_path: Path, kind: str, limit: str, type_: str, limits: tuple[float, float]
) -> None:
    content = f'<link name="a">{BOX}</link><link name="b">{BOX}</link>' + joint(kind, limit)
    links, told = read(tmp_path, content, "limits")
    assert links is not None
    assert links[1].joint is not None
    assert (links[1].joint.type, links[1].joint.limits) == (type_, limits)
    assert {line[:5] for line in told} == {"SC488"}
    made = build(tmp_path, content, "limits").active_joints[0]
    assert made.limits[0] == pytest.approx(np.array(limits, np.float32))


def test_files_that_are_not_needed_to_collide_may_be_missing(tmp_path: Path) -> None:
    (tmp_path / "there.obj").write_text("mtllib gone.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
    meshes = "".join(
        f'<visual><geometry><mesh filename="{name}.obj"/></geometry></visual>' for name in ("gone", "there")
    )
    material = '<material name="m"><texture filename="gone.png"/></material>'
    texture = f'<visual><geometry><box size="1 1 1"/></geometry>{material}</visual>'
    content = f'<link name="a">{meshes}{texture}{BOX}</link><link name="b"/>' + joint("fixed")
    links, told = read(tmp_path, content, "files")
    assert links is not None
    assert told == [
        "SC488 there is no file `gone.obj`: the <visual> is left out",
        "SC488 there is no file `gone.png`: the texture is left out",
    ]
    assert len(links[0].visuals) == 2
    built = build(tmp_path, content, "files")
    assert len(built.links) == 2
    found = [f"{d.code} {d.message}" for d in scenecc.validate(tmp_path / "scene.yaml")]
    assert "SC488 there.obj references `gone.mtl`, which is missing; it is ignored" in found
    # A plan that is written out knows of the repair, too.
    plan = tmp_path / "plan.json"
    plan.write_text(scenecc.emit_scene(tmp_path / "scene.yaml", "json"), encoding="utf-8")
    assert len(scenecc.load_scene(plan, render=False).articulations["r"].objs[0].links) == 2


def test_files_that_meshes_refer_to_and_that_are_left_out_are_counted(tmp_path: Path) -> None:
    shapes = ""
    for name in ("one", "two", "three"):
        (tmp_path / f"{name}.obj").write_text(f"mtllib {name}.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n")
        shapes += shape("visual", f'mesh filename="{name}.obj"')
    build(tmp_path, f'<link name="a">{shapes}{BOX}</link><link name="b"/>' + joint("fixed"), "files")
    (found,) = [d for d in scenecc.validate(tmp_path / "scene.yaml") if d.code == "SC488"]
    assert found.message == "one.obj references `one.mtl`, which is missing; it is ignored (and 2 others like it)"


def test_an_image_that_a_gltf_lacks_is_an_error(tmp_path: Path) -> None:
    """SAPIEN opens it at the first picture, and raises."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32).tobytes()
    content = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 36, "uri": "data:;base64," + base64.b64encode(points).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
        "images": [{"uri": "gone.png"}],
        "textures": [{"source": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    (tmp_path / "m.gltf").write_text(json.dumps(content), encoding="utf-8")
    mesh = shape("visual", 'mesh filename="m.gltf"')
    with pytest.raises(scenecc.SceneError):
        build(tmp_path, f'<link name="a">{mesh}{BOX}</link><link name="b"/>' + joint("fixed"), "files")
    (error,) = scenecc.validate(tmp_path / "scene.yaml")
    assert "gone.png" in error.message
    assert "ignores only images of OBJ meshes" in (error.hint or "")


def test_a_visual_with_an_unknown_uri_scheme_may_be_left_out(tmp_path: Path) -> None:
    mesh = shape("visual", 'mesh filename="file:///usr/arm.obj"')
    content = f'<link name="a">{mesh}{BOX}</link>'
    links, told = read(tmp_path, content, "files")
    assert links is not None
    assert told == ["SC488 `file://` is not supported, in `file:///usr/arm.obj`: the <visual> is left out"]
    assert read(tmp_path, content)[1] == ["SC403 `file://` is not supported, in `file:///usr/arm.obj`"]
    links, told = read(tmp_path, content.replace("visual", "collision"), "files")
    assert (links, [line[:5] for line in told]) == (None, ["SC403"])
    # What is there and may not be read stays an error.
    links, told = read(tmp_path, content.replace("file:///usr/arm.obj", "../arm.obj"), "files")
    assert (links, [line[:5] for line in told]) == (None, ["SC402"])


def test_the_number_of_missing_files_searched_for_is_limited(tmp_path: Path) -> None:
    names = [f"gone{number}.obj" for number in range(MAX_MISSING + 1)]
    visuals = [f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in [*names[:-1], names[0]]]
    links, told = read(tmp_path, f'<link name="a">{BOX}{"".join(visuals)}</link>', "files")
    assert links is not None
    visuals.append(f'<visual><geometry><mesh filename="{names[-1]}"/></geometry></visual>')
    links, told = read(tmp_path, f'<link name="a">{BOX}{"".join(visuals)}</link>', "files")
    assert links is None
    assert [line for line in told if line.startswith("SC452")] == [
        f"SC452 more than {MAX_MISSING} of its files are missing; the rest are not checked"
    ]


def test_a_missing_collision_mesh_is_an_error(tmp_path: Path) -> None:
    content = '<link name="a"><collision><geometry><mesh filename="gone.obj"/></geometry></collision></link>'
    links, told = read(tmp_path, content, "inertia", "limits", "files")
    assert links is None
    assert [line[:5] for line in told] == ["SC401"]


def test_an_error_hints_at_the_repair_that_accepts_the_file(tmp_path: Path) -> None:
    inertial = f'<inertial><mass value="1"/><inertia ixx="0" iyy="1" izz="1" {ZEROS}/></inertial>'
    visual = '<visual><geometry><mesh filename="gone.obj"/></geometry></visual>'
    write(tmp_path, f'<link name="a">{inertial}{visual}</link><link name="b"/>' + joint("revolute"))
    found = scenecc.validate(
        {"scenecc": 1, "entities": {"r": {"urdf": str(tmp_path / "robot.urdf")}}}, allow_outside_assets=True
    )
    hints = {d.code: d.hint or "" for d in found if d.severity == "error"}
    assert "repair: [inertia]" in hints["SC467"]
    assert "repair: [files]" in hints["SC401"]
    assert "repair: [limits]" in hints["SC465"]


@pytest.mark.parametrize("repair", ["inertia", ["inertia", "inertia"], ["everything"]], ids=str)
def test_an_invalid_list_of_repairs_is_refused(repair: object) -> None:
    found = scenecc.validate({"scenecc": 1, "entities": {"r": {"urdf": "r.urdf", "repair": repair}}})
    assert any(d.severity == "error" and "repair" in str(d.path) for d in found)


def test_a_joint_that_mimics_a_fixed_joint_stays_at_its_offset(tmp_path: Path) -> None:
    content = "".join(f'<link name="{name}">{BOX}</link>' for name in "abc")
    content += joint("fixed", name="f") + joint("continuous", '<mimic joint="f" offset="0.5"/>', ends="bc")
    robot = build(tmp_path, content)
    assert robot.active_joints[0].limits[0] == pytest.approx([0.5, 0.5])
    assert robot.qpos == pytest.approx([0.5])


def test_the_mimic_of_a_fixed_joint_is_ignored(tmp_path: Path) -> None:
    content = "".join(f'<link name="{name}">{BOX}</link>' for name in "abc")
    content += joint("continuous", name="c") + joint("fixed", '<mimic joint="c"/>', ends="bc")
    links, told = read(tmp_path, content)
    assert links is not None
    assert links[2].joint is not None
    assert links[2].joint.mimic is None
    assert told == ["SC489 joint `j` is fixed, so its <mimic> is ignored"]


ARM = '<collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.04 0.04"/></geometry></collision>'
SMALL = f'<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" {ZEROS}/>'


def test_a_joint_mimics_across_a_fixed_joint(tmp_path: Path) -> None:
    axis, far = '<axis xyz="0 1 0"/>', '<origin xyz="0.4 0 0.1" rpy="0.2 0.3 0.4"/>'
    content = "".join(f'<link name="{name}">{ARM}</link>' for name in "abcd")
    content += joint("continuous", axis + '<dynamics damping="5"/>', name="s")
    content += joint("fixed", '<axis xyz="0 0 1"/>' + far, name="f", ends="bc")
    content += joint("continuous", f'<mimic joint="s" multiplier="-2"/>{axis}{far}', ends="cd")
    links, told = read(tmp_path, content)
    assert links is not None
    message = (
        "SC489 a fixed joint lies between `j` and `s`, which it mimics: link `d` becomes a child of `b` instead of `c`,"
        " at the same pose"
    )
    assert told == [message]
    assert [link.parent for link in links] == [None, 0, 1, 1]
    assert [link.ignore_bits for link in links] == [0, 0, 1, 1], "what the file connects does not collide"
    poses: list[list[float]] = []
    for written in (content, content.replace('<mimic joint="s" multiplier="-2"/>', "")):
        robot = build(tmp_path, written)
        robot.qpos = np.array([0.3, -0.6], np.float32)
        poses.append([number for link in robot.links for number in (*link.entity_pose.p, *link.entity_pose.q)])
    assert poses[0] == pytest.approx(poses[1], abs=1e-6)


def test_joints_of_links_fixed_together_may_mimic_each_other(tmp_path: Path) -> None:
    """The tendon hangs on the link that both are fixed to. One arm falls, and the other one with it."""
    content = "".join(f'<link name="{name}"/>' for name in "abc")
    content += f'<link name="d">{ARM}</link><link name="e"><inertial><mass value="0.01"/>{SMALL}</inertial></link>'
    content += joint("fixed", name="f", ends="ab") + joint("fixed", name="g", ends="ac")
    for mimic, name, ends in (("", "s", "bd"), ('<mimic joint="s" multiplier="0.5"/>', "j", "ce")):
        content += joint("continuous", f'<axis xyz="0 1 0"/>{mimic}', name, ends)
    write(tmp_path, content)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: robot.urdf, fix_root_link: true}}\n", encoding="utf-8")
    with scenecc.load_scene(scene, render=False) as built:
        robot = built.articulations["r"].objs[0]
        assert [link.parent and link.parent.name for link in robot.links] == [None, "a", "a", "a", "a"]
        built.step(20)
        turned, followed = robot.qpos
    assert turned > 0.1
    assert followed == pytest.approx(turned / 2, abs=2e-3)


PNG = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg=="
)
TRIANGLE = "mtllib {0}.mtl\nusemtl m\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"


@pytest.fixture
def pictured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A robot with two meshes: the materials of one name an image that is no image, and one that is missing."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "moving.gif").write_bytes(b"GIF89a")
    for name in ("whole", "part"):
        (tmp_path / f"{name}.obj").write_text(TRIANGLE.format(name), encoding="utf-8")
    (tmp_path / "whole.mtl").write_text("newmtl m\nKd 0 0 1\n", encoding="utf-8")
    lines = "newmtl m\nKd 0 1 0\nmap_Kd moving.gif\nmap_Ks -s 1 1 1 gone.png\n"
    (tmp_path / "part.mtl").write_text(lines, encoding="utf-8")
    meshes = "".join(shape("visual", f'mesh filename="{name}.obj"') for name in ("whole", "part"))
    return f'<link name="a">{BOX}{meshes}</link><link name="b"/>{joint("fixed")}'


def test_an_image_that_cannot_be_read_is_left_out(tmp_path: Path, pictured: str) -> None:
    assert len(build(tmp_path, pictured, "files").links) == 2
    found = {each.message for each in scenecc.validate(tmp_path / "scene.yaml") if each.code == "SC488"}
    why = "cannot be used (`.gif` is not an image format that SAPIEN reads)"
    assert found == {
        f"part.obj references `moving.gif`, which {why}; it is ignored",
        "part.obj references `gone.png`, which is missing; it is ignored",
    }
    (tmp_path / "scene.yaml").write_text("scenecc: 1\nentities: {r: {urdf: robot.urdf}}\n", encoding="utf-8")
    errors = [each for each in scenecc.validate(tmp_path / "scene.yaml") if each.severity == "error"]
    assert [each.code for each in errors] == ["SC410", "SC418"]
    assert all("add `repair: [files]` to ignore it" in (each.hint or "") for each in errors)


def test_a_copy_without_the_unreadable_image_is_rendered(tmp_path: Path, pictured: str) -> None:
    write(tmp_path, pictured)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: robot.urdf, repair: [files]}}\n", encoding="utf-8")
    (tmp_path / "picture.png").write_bytes(PNG)
    (tmp_path / "part.mtl").write_text("map_Ks -s 1 1 1 gone.png\n map_Kd -o 0 0 0 picture.png\r\n", encoding="utf-8")
    whole, part = (visual_file(file) for file in scenecc.compile_scene(scene).files if file.path.suffix == ".obj")
    assert whole == tmp_path / "whole.obj"
    first, *rest = part.read_text(encoding="utf-8").splitlines()
    assert rest == ["", *TRIANGLE.splitlines()[1:]]
    material = part.parent / first.removeprefix("mtllib ")
    assert material.read_text(encoding="utf-8") == f" map_Kd -o 0 0 0 {tmp_path / 'picture.png'}\n"


def test_an_image_is_left_out_of_a_file_with_windows_line_ends(tmp_path: Path, pictured: str) -> None:
    write(tmp_path, pictured)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: robot.urdf, repair: [files]}}\n", encoding="utf-8")
    mesh = tmp_path / "part.obj"
    mesh.write_bytes(mesh.read_bytes().replace(b"\n", b"\r\n"))
    (copy,) = (visual_file(file) for file in scenecc.compile_scene(scene).files if file.path == mesh)
    first, *rest = copy.read_bytes().splitlines()
    assert rest == [b"", *mesh.read_bytes().splitlines()[1:]]
    material = copy.parent / first.decode().removeprefix("mtllib ")
    assert material.read_text(encoding="utf-8") == "newmtl m\nKd 0 1 0\n"


@pytest.mark.render
@pytest.mark.usefixtures("held_renderer")
def test_a_robot_with_left_out_files_is_rendered(tmp_path: Path, pictured: str) -> None:
    write(tmp_path, pictured)
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {urdf: robot.urdf, repair: [files]}}\n", encoding="utf-8")
    with scenecc.load_scene(scene, render=True) as built:
        link = built.articulations["r"].objs[0].links[0]
        seen: Any = link.entity.components[1]
        assert [each.parts[0].material.base_color[:3] for each in seen.render_shapes] == [[0, 0, 1], [0, 1, 0]]
