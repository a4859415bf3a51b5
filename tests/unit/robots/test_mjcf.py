"""MJCF files: what is told of them, at which place, and what is described."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

import scenecc
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import Origin
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.codes import Code
    from scenecc.robots.description import RobotDescription

pytest.importorskip("mujoco")

SCENE = Origin("scene.yaml", ("entities", "arm", "mjcf"))
GEOM = '<geom size=".1"/>'


def read(path: Path, root: Path | None = None) -> tuple[RobotDescription | None, list[Diagnostic]]:
    sink = Sink()
    scope = AssetScope(root or path.parent)
    found = read_mjcf(ResolvedFile(path, path.name), scope=scope, sink=sink, origin=SCENE)
    return found, sink.diagnostics()


def errors(world: str, folder: Path, rest: str = "") -> list[tuple[str, str]]:
    """Code and underlined text of the errors of a file."""
    path = folder / "robot.xml"
    path.write_text(f"<mujoco>{rest}<worldbody>{world}</worldbody></mujoco>")
    found, diagnostics = read(path)
    wrong = [one for one in diagnostics if one.severity == "error"]
    assert (found is None) == bool(wrong)
    return [(one.code, underlined(one)) for one in wrong]


def underlined(one: Diagnostic) -> str:
    place = one.location
    assert place.text is not None
    assert place.column is not None
    assert place.end_column is not None
    return place.text[place.column - 1 : place.end_column - 1]


def described(world: str, folder: Path, rest: str = "") -> RobotDescription:
    path = folder / "robot.xml"
    path.write_text(f"<mujoco>{rest}<worldbody>{world}</worldbody></mujoco>")
    found, diagnostics = read(path)
    assert found is not None, [str(one) for one in diagnostics]
    return found


EXAMPLES = [row for row in CODES.values() if "# robot.xml: " in row.example]


@pytest.mark.parametrize("row", EXAMPLES, ids=lambda row: row.code)
def test_each_mjcf_example_of_a_code_reports_only_that_code(row: Code, tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(row.example.split("# robot.xml: ")[1])
    found, diagnostics = read(path)
    assert {one.code for one in diagnostics} == {row.code}
    assert (found is None) == (row.severity == "error")


WRONG: dict[str, tuple[str, str, str, str]] = {
    "no size": ("<geom/>", "", "SC481", "<geom"),
    "a class of no name": (GEOM, "<default><default/></default>", "SC481", "<default"),
    "an include of no file": (GEOM, "<include/>", "SC481", "<include"),
    "contacts of bit 31": ('<geom size=".1" contype="-1"/>', "", "SC483", "<geom"),
    "more sets of links than bits": (
        "".join(f'<body name="{name}{i}"><freejoint/>{GEOM}</body>' for i in range(33) for name in "ab"),
        "<contact>" + "".join(f'<exclude body1="a{i}" body2="b{i}"/>' for i in range(33)) + "</contact>",
        "SC483",
        "<exclude",
    ),
    "a missing mesh": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" file="no.obj"/></asset>',
        "SC401",
        "no.obj",
    ),
    "a mesh elsewhere": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" file="../../secret.obj"/></asset>',
        "SC402",
        "../../secret.obj",
    ),
    "an absolute mesh": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" file="/etc/passwd"/></asset>',
        "SC402",
        "/etc/passwd",
    ),
    "a folder elsewhere": (
        '<geom type="mesh" mesh="m"/>',
        '<compiler meshdir="/etc"/><asset><mesh name="m" file="passwd"/></asset>',
        "SC402",
        "passwd",
    ),
    "an include elsewhere": (GEOM, '<include file="../../secret.xml"/>', "SC402", "../../secret.xml"),
    "a missing include": (GEOM, '<include file="no.xml"/>', "SC401", "no.xml"),
    "a missing image": (
        '<geom size=".1" material="m"/>',
        '<asset><texture name="t" type="2d" file="no.png"/><material name="m" texture="t"/></asset>',
        "SC401",
        "no.png",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_an_mjcf_error_is_reported_at_its_line(name: str, tmp_path: Path) -> None:
    world, rest, code, where = WRONG[name]
    assert errors(world, tmp_path, rest) == [(code, where)]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("<robot name='r'><link name='a'/></robot>", "write `urdf: FILE` for a URDF"),
        ("<sdf version='1.9'/>", "make a scene of an SDF with `scenecc import`"),
    ],
)
def test_a_file_of_another_format_is_reported_with_the_right_key(tmp_path: Path, text: str, hint: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    found, (one,) = read(path)
    assert found is None
    assert (one.code, one.hint) == ("SC453", hint)


def test_an_error_in_an_included_file_is_reported_there_with_the_include(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "one.xml").write_text('<mujocoinclude>\n<include file="deep/two.xml"/></mujocoinclude>')
    (tmp_path / "deep" / "two.xml").write_text('<x>\n\n<worldbody><geom size="-1"/></worldbody></x>')
    path = tmp_path / "robot.xml"
    path.write_text('<mujoco>\n<include file="deep/one.xml"/>\n</mujoco>')
    found, (one,) = read(path)
    assert found is None
    assert (one.file, one.line, one.code) == ("deep/two.xml", 3, "SC481")
    places = [(related.location.file, related.location.line) for related in one.related]
    assert places == [("deep/one.xml", 2), ("robot.xml", 2), ("scene.yaml", None)]


def test_robots_come_first_and_names_are_unique(tmp_path: Path) -> None:
    found = described(
        f'{GEOM}<geom name="s" size="1"/><body name="s">{GEOM}</body><body>{GEOM}</body>'
        f'<body name="a"><joint axis="0 0 1"/>{GEOM}</body><body><joint axis="0 0 1"/>{GEOM}</body>',
        tmp_path,
    )
    assert [(robot.links[0].name, robot.body_type) for robot in found.robots] == [
        ("dummy_root_2", None),
        ("dummy_root_3", None),
        ("s", "static"),
        ("body_2", "static"),
        ("geom_0", "static"),
        ("s_2", "static"),
    ]
    assert [link.name for link in found.robots[1].links] == ["dummy_root_3", "body_4"]


def test_textures_are_read_from_texturedir(tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "t.png").write_bytes(b"")
    found = described(
        '<geom size=".1" material="m" rgba="1 0 0 1"/>',
        tmp_path,
        '<compiler meshdir="meshes" texturedir="images"/><asset><texture type="2d" file="t.png"/>'
        '<material name="m" texture="t" rgba="0 1 0 1" emission=".5"/></asset>',
    )
    look = found.robots[0].links[0].visuals[0].look
    assert look is not None
    assert look.base_color_texture is not None
    assert look.base_color_texture.uri == "images/t.png"
    assert look.base_color == (1, 0, 0, 1)
    assert look.emission == (0.5, 0, 0, 1)


def test_each_robot_of_a_file_has_its_own_bits_if_one_set_is_too_small(tmp_path: Path) -> None:
    """Two joints per leg need a bit each; 33 such robots need 33, and SAPIEN has 32."""
    leg = '<body pos="0 0 -1"><joint axis="1 0 0"/><joint axis="0 1 0"/><geom size="0.4"/></body>'
    robot = f'<replicate count="33" offset="5 0 0"><body><freejoint/><geom size="0.4"/>{leg}</body></replicate>'
    (tmp_path / "robots.xml").write_text(f"<mujoco><worldbody>{robot}</worldbody></mujoco>")
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {mjcf: robots.xml}}\n")
    ids = set[int]()
    with scenecc.load_scene(scene, render=False) as batch:
        for held in batch.articulations.values():
            shapes = [shape for link in held.objs[0].links for shape in link.collision_shapes]
            first, second = (shape.collision_groups for shape in shapes)
            assert first[2:] == second[2:]
            assert first[2] == 1
            ids.add(first[3])
    assert len(ids) == 33


def test_an_obj_without_faces_is_the_hull_that_mujoco_makes(tmp_path: Path) -> None:
    (tmp_path / "cloud.obj").write_text("".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1)))
    (tmp_path / "cloud.xml").write_text(
        '<mujoco><asset><mesh name="m" file="cloud.obj"/></asset><worldbody><body><freejoint/>'
        '<geom type="mesh" mesh="m"/></body></worldbody></mujoco>'
    )
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {mjcf: cloud.xml}}\n")
    with scenecc.load_scene(scene, render=False) as batch:
        body: Any = batch.entities["r"].objs[0].components[-1]
        assert body.mass == pytest.approx(1000, rel=1e-5)
        assert len(body.collision_shapes) == 1


def test_a_free_body_with_a_mass_and_no_shape_is_built(tmp_path: Path) -> None:
    inertial = '<inertial pos="0 0 1" mass="2" diaginertia="1 1 1"/>'
    (tmp_path / "mass.xml").write_text(f"<mujoco><worldbody><body><freejoint/>{inertial}</body></worldbody></mujoco>")
    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\nentities: {r: {mjcf: mass.xml}}\n")
    with scenecc.load_scene(scene, render=False) as batch:
        body: Any = batch.entities["r"].objs[0].components[-1]
        assert body.mass == 2


def test_actuators_of_plugins_keep_the_places_of_controls_in_keyframes(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(
        f"""<mujoco><extension><plugin plugin="a.b"><instance name="i"/></plugin></extension>
        <default><general gainprm="9" biasprm="0 -9" biastype="affine" dyntype="integrator"/></default>
        <worldbody><body><joint name="j"/>{GEOM}<body pos="1 0 0"><joint name="k"/>{GEOM}</body></body></worldbody>
        <actuator><plugin name="p" plugin="a.b" instance="i" joint="j" actdim="2" class="main"/>
        <position name="q" joint="k" kp="8"/></actuator>
        <sensor><actuatorpos actuator="p"/><plugin plugin="a.c" objtype="body" objname="x"/></sensor>
        <keyframe><key name="up" ctrl="5 0.5" act="1 2"/></keyframe></mujoco>"""
    )
    found = read_mjcf(
        ResolvedFile(path, path.name), scope=AssetScope(tmp_path), sink=(sink := Sink()), keyframe=("up", SCENE)
    )
    assert found is not None, sink.diagnostics()
    drives = {link.joint.name: link.joint.drive for link in found.robots[0].links if link.joint is not None}
    assert drives["j"] is None
    assert drives["k"] is not None
    assert (drives["k"].stiffness, drives["k"].target) == (8, 0.5)


@pytest.mark.parametrize("ends", ["still other", "still post", "held still", "held part", "arm hand", "still", "held"])
def test_equalities_that_move_nothing_are_noted_and_not_built(tmp_path: Path, ends: str) -> None:
    first, _, second = ends.partition(" ")
    path = tmp_path / "robot.xml"
    path.write_text(
        f"""<mujoco><worldbody><body name="still">{GEOM}<body name="post" pos="1 0 0">{GEOM}</body></body>
        <body name="other" pos="2 0 0">{GEOM}</body>
        <body name="held" mocap="true" pos="3 0 0">{GEOM}<body name="part" pos="0 0 1">{GEOM}</body></body>
        <body name="arm" pos="4 0 0"><joint name="j"/>{GEOM}<body name="hand" pos="0 0 1">{GEOM}</body></body>
        </worldbody><equality>
        <weld name="w" body1="{first}" {f'body2="{second}"' * bool(second)}/></equality></mujoco>"""
    )
    found, told = read(path)
    assert found is not None
    assert not found.constraints
    assert [(one.code, one.line, one.message) for one in told] == [
        ("SC490", 6, "the equality `w` is not built: no force moves one of its bodies against the other")
    ]


def test_a_closing_tag_after_the_root_ends_the_file_as_in_mujoco(tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text(f"<x><body>{GEOM}</body></x>\n</x><body/>")
    path = tmp_path / "robot.xml"
    path.write_text('<mujoco><worldbody><include file="in.xml"/></worldbody></mujoco>\n  </mujoco>\n')
    found, told = read(path)
    assert found is not None
    message = "what follows the end of the root element is ignored"
    assert [(one.code, one.file, one.line, one.message) for one in told] == [("SC484", "robot.xml", 2, message)]
    path.write_text(f"<mujoco><worldbody>{GEOM}</worldbody></mujoco><worldbody/>")
    assert read(path)[0] is None
