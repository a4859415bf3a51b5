"""MJCF files: what is told of them, at which place, and what is described."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import Origin
from scenecc.robots.description import MeshGeometry
from scenecc.robots.maniskill_mjcf import read_mjcf
from scenecc.robots.mujoco import reader
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.codes import Code
    from scenecc.robots.description import RobotDescription

SCENE = Origin("scene.yaml", ("entities", "arm", "mjcf"))
GEOM = '<geom size=".1"/>'


def read(path: Path, root: Path | None = None) -> tuple[RobotDescription | None, list[Diagnostic]]:
    sink = Sink()
    scope = AssetScope(root or path.parent)
    found = read_mjcf(ResolvedFile(path, path.name), scope=scope, sink=sink, origin=SCENE)
    return found, sink.diagnostics()


def read_by_mujoco(path: Path) -> tuple[RobotDescription | None, list[Diagnostic]]:
    sink = Sink()
    found = reader.read_mjcf(ResolvedFile(path, path.name), scope=AssetScope(path.parent), sink=sink, origin=SCENE)
    return found, sink.diagnostics()


def told(text: str, folder: Path) -> list[tuple[str, int | None, str]]:
    """Code, line and message of all that is told of a file."""
    path = folder / "robot.xml"
    path.write_text(text)
    return [(one.code, one.line, one.message) for one in read(path)[1]]


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
def test_the_example_of_a_code_gives_it_and_no_other(row: Code, tmp_path: Path) -> None:
    content = row.example.split("# robot.xml: ")[1]
    path = tmp_path / "robot.xml"
    path.write_text(content)
    found, diagnostics = read_by_mujoco(path) if row.code == "SC490" else read(path)
    others = {"SC484"} if row.code == "SC480" else set()
    assert {one.code for one in diagnostics} - others == {row.code}
    assert (found is None) == (row.severity == "error")


WRONG: dict[str, tuple[str, str, str, str]] = {
    "no number": ('<geom size="a"/>', "", "SC481", "a"),
    "python's underscore": ('<geom size="1_0"/>', "", "SC481", "1_0"),
    "not a finite number": ('<geom size="inf"/>', "", "SC481", "inf"),
    "beyond single precision": ('<geom size="1e39"/>', "", "SC481", "1e39"),
    "too many numbers": ('<geom size="1 2 3 4"/>', "", "SC481", "1 2 3 4"),
    "too few numbers": ('<geom size=".1" pos="1 2"/>', "", "SC481", "1 2"),
    "no size": ("<geom/>", "", "SC481", "<geom"),
    "half a capsule": ('<geom type="capsule" size=".1"/>', "", "SC481", ".1"),
    "no radius": ('<geom size="0"/>', "", "SC481", "0"),
    "an inverted box": ('<geom type="box" size=".1 -.2 .1"/>', "", "SC481", ".1 -.2 .1"),
    "a point": ('<geom type="capsule" size=".1" fromto="1 1 1 1 1 1"/>', "", "SC481", "1 1 1 1 1 1"),
    "a sphere between points": ('<geom size=".1" fromto="0 0 0 1 1 1"/>', "", "SC481", "0 0 0 1 1 1"),
    "an unknown type": ('<geom type="banana" size=".1"/>', "", "SC481", "banana"),
    "no rotation": ('<geom size=".1" quat="0 0 0 0"/>', "", "SC481", "0 0 0 0"),
    "no rotation axis": ('<geom size=".1" axisangle="0 0 0 1"/>', "", "SC481", "0 0 0 1"),
    "axes in a line": ('<geom size=".1" xyaxes="1 0 0 2 0 0"/>', "", "SC481", "1 0 0 2 0 0"),
    "two rotations": ('<geom size=".1" quat="1 0 0 0" euler="1 2 3"/>', "", "SC481", "1 2 3"),
    "no axis": (f'<body><joint axis="0 0 0"/>{GEOM}</body>', "", "SC481", "0 0 0"),
    "a range downwards": (f'<body><joint axis="0 0 1" range="2 1"/>{GEOM}</body>', "", "SC481", "2 1"),
    "limited by nothing": (f'<body><joint axis="0 0 1" limited="true"/>{GEOM}</body>', "", "SC481", "true"),
    "limits not said": (
        f'<body><joint axis="0 0 1" range="1 2"/>{GEOM}</body>',
        '<compiler autolimits="false"/>',
        "SC481",
        "1 2",
    ),
    "negative damping": (f'<body><joint axis="0 0 1" damping="-1"/>{GEOM}</body>', "", "SC481", "-1"),
    "negative friction": ('<geom size=".1" friction="-1"/>', "", "SC481", "-1"),
    "negative density": ('<geom size=".1" density="-1"/>', "", "SC481", "-1"),
    "a condim of 2": ('<geom size=".1" condim="2"/>', "", "SC481", "2"),
    "a group between": ('<geom size=".1" group="1.5"/>', "", "SC481", "1.5"),
    "a glaring colour": ('<geom size=".1" rgba="2 0 0 1"/>', "", "SC481", "2 0 0 1"),
    "angles in turns": (GEOM, '<compiler angle="turn"/>', "SC481", "turn"),
    "two euler axes": (GEOM, '<compiler eulerseq="xy"/>', "SC481", "xy"),
    "global coordinates": (GEOM, '<compiler coordinate="global"/>', "SC481", "global"),
    "a mesh of no name": ('<geom type="mesh"/>', "", "SC481", "mesh"),
    "a class of no name": (GEOM, "<default><default/></default>", "SC481", "<default"),
    "an include of no file": (GEOM, "<include/>", "SC481", "<include"),
    "a mesh scaled to nothing": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" file="m.obj" scale="1 0 1"/></asset>',
        "SC481",
        "1 0 1",
    ),
    "an unknown class": ('<geom size=".1" class="c"/>', "", "SC482", "c"),
    "an unknown class of a body": (f'<body childclass="c">{GEOM}</body>', "", "SC482", "c"),
    "an unknown class of a joint": (f'<body><joint axis="0 0 1" class="c"/>{GEOM}</body>', "", "SC482", "c"),
    "an unknown material": ('<geom size=".1" material="m"/>', "", "SC482", "m"),
    "an unknown mesh": ('<geom type="mesh" mesh="m"/>', "", "SC482", "m"),
    "an unknown texture": (
        '<geom size=".1" material="m"/>',
        '<asset><material name="m" texture="t"/></asset>',
        "SC482",
        "t",
    ),
    "a ball joint": (f'<body><joint type="ball"/>{GEOM}</body>', "", "SC483", "ball"),
    "a free body inside": (
        f"<body><joint axis='0 0 1'/>{GEOM}<body><freejoint/>{GEOM}</body></body>",
        "",
        "SC483",
        "<freejoint",
    ),
    "a free body inside one that stands": (
        f"<body>{GEOM}<body><freejoint/>{GEOM}</body></body>",
        "",
        "SC483",
        "<freejoint",
    ),
    "a body free twice": (f"<body><freejoint/><freejoint/>{GEOM}</body>", "", "SC483", "<freejoint"),
    "a geom twice": ('<body><geom name="g" size=".1"/></body><geom name="g" size=".1"/>', "", "SC486", "g"),
    "a site twice": (f'<body><site name="s"/>{GEOM}</body><site name="s"/>', "", "SC486", "s"),
    "a free joint of a joint's name": (
        f'<body><freejoint name="j"/>{GEOM}</body><body><joint name="j" axis="0 0 1"/>{GEOM}</body>',
        "",
        "SC486",
        "j",
    ),
    "an axis too long": (f'<body><joint axis="0 1e30 0"/>{GEOM}</body>', "", "SC481", "0 1e30 0"),
    "a size that is 0 in the engine": ('<geom size="1e-40"/>', "", "SC481", "1e-40"),
    "planes alone": ('<geom type="plane" size="1 1 1"/><light/>', "", "SC480", "plane"),
    "a free body with a joint": (f"<body><freejoint/><joint axis='0 0 1'/>{GEOM}</body>", "", "SC483", "<joint"),
    "a height field": ('<geom type="hfield" hfield="h"/>', "", "SC483", "hfield"),
    "a frame": (f"<frame>{GEOM}</frame>{GEOM}", "", "SC483", "<frame"),
    "copies": (f'<replicate count="3">{GEOM}</replicate>{GEOM}', "", "SC483", "<replicate"),
    "a joint of the world": (f"<joint/>{GEOM}", "", "SC483", "<joint"),
    "a mesh of vertices": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>',
        "SC483",
        "<mesh",
    ),
    "a turned mesh": (
        '<geom type="mesh" mesh="m"/>',
        '<asset><mesh name="m" file="m.obj" refquat="0 1 0 0"/></asset>',
        "SC483",
        "0 1 0 0",
    ),
    "a body twice": (f'<body name="a">{GEOM}</body><body name="a">{GEOM}</body>', "", "SC486", "a"),
    "a joint twice": (
        f'<body><joint name="j" axis="0 0 1"/><joint name="j" axis="0 1 0"/>{GEOM}</body>',
        "",
        "SC486",
        "j",
    ),
    "a class twice": (
        GEOM,
        '<default><default class="c"/><default class="c"/></default>',
        "SC486",
        "c",
    ),
    "a material twice": (GEOM, '<asset><material name="m"/><material name="m"/></asset>', "SC486", "m"),
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
def test_a_mistake_is_told_where_it_stands(name: str, tmp_path: Path) -> None:
    world, rest, code, where = WRONG[name]
    assert errors(world, tmp_path, rest) == [(code, where)]


def test_a_name_that_is_not_defined_is_told_with_the_nearest_that_is(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(
        '<mujoco><default><default class="visual"/></default><asset><material name="steel"/></asset><worldbody>'
        '<geom size="1" class="visaul"/><geom size="1" material="stele"/></worldbody></mujoco>'
    )
    assert [one.hint for one in read(path)[1]] == ["did you mean `visual`?", "did you mean `steel`?"]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("<robot name='r'><link name='a'/></robot>", "give a URDF with `urdf:`"),
        ("<sdf version='1.9'/>", "make a scene of an SDF with `scenecc import`"),
    ],
)
def test_another_kind_of_file_is_reported_with_what_reads_it(tmp_path: Path, text: str, hint: str) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    found, (one,) = read(path)
    assert found is None
    assert (one.code, one.hint) == ("SC453", hint)


def test_all_mistakes_are_told_at_once_with_the_scene_that_led_there(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    path.write_text(
        '<mujoco>\n <worldbody>\n  <geom size="x"/>\n  <body childclass="c">\n   <joint type="ball"/>\n  </body>\n'
        " </worldbody>\n</mujoco>"
    )
    found, diagnostics = read(path)
    assert found is None
    assert [(one.code, one.line, one.column) for one in diagnostics] == [
        ("SC481", 3, 15),
        ("SC482", 4, 21),
        ("SC483", 5, 17),
    ]
    assert all(one.related[0].message == "used from here" for one in diagnostics)
    assert all(one.related[0].location.file == "scene.yaml" for one in diagnostics)


def test_a_mistake_in_an_included_file_is_told_there_with_what_led_to_it(tmp_path: Path) -> None:
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


def test_what_is_left_out_is_told_once_a_kind(tmp_path: Path) -> None:
    text = (
        '<mujoco>\n<option timestep=".005"/>\n<worldbody>\n<light/>\n<geom size=".1" mass="1" margin="2"/>\n'
        '<body><joint axis="0 0 1" armature="1"/><geom size=".1" mass="2"/><site name="s"/><site name="t"/></body>\n'
        "</worldbody>\n<actuator><motor/></actuator>\n<tendon/>\n<equality/>\n<sensor/>\n<contact/>\n<keyframe/>\n</mujoco>"
    )
    found = told(text, tmp_path)
    assert {code for code, *_ in found} == {"SC484"}
    assert [(line, message) for _, line, message in found] == [
        (2, "of `<option>`, `timestep` is not read"),
        (4, "`<light>` is not read"),
        (5, "of `<geom>`, `mass`, `margin` are not read"),
        (6, "of `<joint>`, `armature` is not read"),
        (6, "`<site>` is not read (there are 2)"),
        (8, "`<actuator>` is not read"),
        (9, "`<tendon>` is not read"),
        (10, "`<equality>` is not read"),
        (11, "`<sensor>` is not read"),
        (12, "`<contact>` is not read"),
        (13, "`<keyframe>` is not read"),
    ]


LEFT_OUT = {
    "another start": '<body name="b"><joint axis="0 0 1" ref="3"/><geom size=".1"/></body>',
    "plane": '<geom type="plane" size="1 1 1"/>',
    "ellipsoid": '<geom type="ellipsoid" size="1 1 1"/>',
    "group 1": '<geom size=".1" group="1"/>',
    "condim 4": '<geom size=".1" condim="4"/>',
    "bits of contype": '<geom size=".1" contype="2"/>',
    "bits of conaffinity": '<geom size=".1" conaffinity="0"/>',
    "conaffinity alone": '<geom size=".1" contype="0"/>',
    "motor class": '<geom size=".1" class="motor"/>',
    "empty body": '<body name="b"><site/></body>',
    "inertial": '<body name="b"><joint axis="0 0 1"/><inertial mass="1" pos="0 0 0"/><geom size=".1"/></body>',
    "fitted": '<geom type="box" mesh="m"/>',
}


@pytest.mark.parametrize("name", LEFT_OUT)
def test_what_the_engine_gets_otherwise_is_told(name: str, tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    rest = '<default><default class="motor"/></default><asset><mesh name="m" file="m.obj"/></asset>'
    text = f"<mujoco>{rest}<worldbody>{LEFT_OUT[name]}{GEOM}</worldbody></mujoco>"
    found = told(text, tmp_path)
    assert found
    assert {code for code, *_ in found} == {"SC484"}


def test_robots_come_first_and_names_are_no_others(tmp_path: Path) -> None:
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


def test_a_root_is_fixed_unless_its_body_is_free(tmp_path: Path) -> None:
    found = described(
        f'<body name="a"><freejoint/>{GEOM}</body><body name="b"><joint type="free"/>{GEOM}</body>'
        f'<body name="c"><joint axis="0 0 1"/>{GEOM}</body>',
        tmp_path,
    )
    assert [robot.fixed for robot in found.robots] == [False, False, True]
    assert [[link.joint and link.joint.type for link in robot.links] for robot in found.robots] == [
        [None, "fixed"],
        [None, "fixed"],
        [None, "revolute"],
    ]


def test_bonds_beyond_the_bits_are_those_that_the_engine_does_not_see_itself(tmp_path: Path) -> None:
    two = '<joint axis="0 0 1"/><joint axis="0 1 0"/><geom size=".1"/>'
    one = '<joint axis="0 0 1"/><geom size=".1"/>'
    bodies = "".join(f'<body name="b{i}">{two if i < 5 else one}</body>' for i in range(40))
    found = described(f'<body name="a">{one}{bodies}</body>', tmp_path)
    bits = {link.name: link.ignore_bits for link in found.robots[0].links}
    assert bits["a"] == 0b11111
    assert [bits[f"b{i}"] for i in range(6)] == [1, 2, 4, 8, 16, 0]
    assert bits["b0_dummy_0"] == 0
    many = "".join(f'<body name="b{i}">{two}</body>' for i in range(33))
    assert errors(f'<body name="a">{one}{many}</body>', tmp_path) == [("SC483", "<body")]


def test_files_are_those_that_are_used(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    (tmp_path / "part.xml").write_text('<mujoco><asset><mesh name="m" file="x/m.obj"/></asset></mujoco>')
    found = described(
        '<geom type="mesh" mesh="m"/>',
        tmp_path,
        '<compiler strippath="true"/><include file="part.xml"/><asset><mesh name="unused" file="no.obj"/></asset>',
    )
    assert [file.uri for file in found.files] == ["part.xml", "m.obj"]


def test_textures_have_a_folder_of_their_own(tmp_path: Path) -> None:
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
    assert look.texture_uri == "images/t.png"
    assert look.base_color == (1, 0, 0, 1)
    assert look.emission == (0.5, 0, 0, 1)


def test_classes_of_assets_hold(tmp_path: Path) -> None:
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    found = described(
        '<geom type="mesh" mesh="m" material="p"/>',
        tmp_path,
        '<default><mesh scale=".5 .5 .5"/><default class="shiny"><material shininess="1"/></default></default>'
        '<asset><mesh file="m.obj"/><material name="p" class="shiny"/></asset>',
    )
    visual = found.robots[0].links[0].visuals[0]
    assert isinstance(visual.geometry, MeshGeometry)
    assert visual.geometry.scale == (0.5, 0.5, 0.5)
    assert visual.look is not None
    assert visual.look.metallic == 1


def test_one_file_leaves_nothing_behind_for_the_next(tmp_path: Path) -> None:
    off = described(GEOM, tmp_path, '<option><flag contact="disable"/></option>')
    on = described(GEOM, tmp_path)
    assert off.robots[0].links[0].ignore_bits == 2
    assert on.robots[0].links[0].ignore_bits == 0


def test_limits_in_degrees_where_the_file_says_radians(tmp_path: Path) -> None:
    path = tmp_path / "robot.xml"
    world = f'<body><joint axis="0 0 1" range="-90 90"/>{GEOM}</body>'
    for unit, doubted in (("radian", [("SC526", "-90 90")]), ("degree", [])):
        path.write_text(f'<mujoco><compiler angle="{unit}"/><worldbody>{world}</worldbody></mujoco>')
        _, found = read(path)
        assert [(one.code, underlined(one)) for one in found if one.severity == "warning"] == doubted
