"""URDFs: what is described beyond what SAPIEN's loader records, and every fault at its own line."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import pytest
from plugins.nightly import assert_took

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan.articulation import MAX_LINKS
from scenecc.robots.description import (
    DescribedMaterial,
    DescribedRobot,
    DescribedTexture,
    MeshGeometry,
    RobotDescription,
)
from scenecc.robots.urdf import MAX_SHAPES, read_urdf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

LIMIT = '<limit lower="-1" upper="1"/>'
INERTIA = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
BOX = '<collision><geometry><box size="1 1 1"/></geometry></collision>'


def joint(name: str, kind: str, parent: str, child: str, inner: str = "") -> str:
    """A joint, on a line of its own."""
    return f'\n<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inner}</joint>'


def links(names: str) -> str:
    """Empty links, on one line."""
    return "".join(f'<link name="{name}"/>' for name in names)


class Folder:
    """A folder with a URDF in it."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def read(self, content: str, **options: object) -> tuple[RobotDescription | None, list[Diagnostic]]:
        """The description of a URDF of some content, which begins on line 1, and what was told."""
        file = self.path / "robot.urdf"
        file.write_text(f'<robot name="r">{content}</robot>', encoding="utf-8")
        sink = Sink()
        scope = AssetScope(self.path)
        origin = Origin("scene.yaml", ("entities", "arm", "urdf"))
        found = read_urdf(ResolvedFile(file, file.name), scope=scope, sink=sink, origin=origin, **options)  # type: ignore[arg-type]
        return found, sink.diagnostics()

    def robots(self, content: str, **options: object) -> tuple[DescribedRobot, ...]:
        """The robots of a URDF with which nothing is wrong."""
        found, told = self.read(content, **options)
        assert found is not None, [str(diagnostic) for diagnostic in told]
        assert not told
        return found.robots

    def told(self, content: str, **options: object) -> list[str]:
        """The line, column, code and message of all that is told."""
        return [f"{d.line}:{d.column} {d.code} {d.message}" for d in self.read(content, **options)[1]]


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path)


def test_values_that_the_loader_drops_are_described(folder: Folder) -> None:
    inner = (
        '<limit lower="-1" upper="2" effort="87" velocity="2.5"/><dynamics friction="0.25"/>'
        '<mimic joint="one" multiplier="-2" offset="0.5"/>'
    )
    (robot,) = folder.robots(
        links("abc") + joint("one", "continuous", "a", "b") + joint("two", "revolute", "a", "c", inner)
    )
    one, two = (link.joint for link in robot.links[1:])
    assert one is not None
    assert two is not None
    assert (one.friction, one.damping, one.effort, one.velocity, one.mimic) == (None, 0.0, None, None, None)
    assert one.limits == (-math.inf, math.inf)
    assert (two.friction_force, two.damping, two.effort, two.velocity) == (0.25, 0.0, 87.0, 2.5)
    assert two.mimic is not None
    assert (two.mimic.source, two.mimic.multiplier, two.mimic.offset) == ("one", -2.0, 0.5)
    assert two.location.line == 3


@pytest.mark.parametrize("nothing", ["0", "inf"])
def test_a_zero_or_infinite_effort_means_no_limit(folder: Folder, nothing: str) -> None:
    limit = f'<limit lower="-1" upper="2" effort="{nothing}" velocity="{nothing}"/>'
    (robot,) = folder.robots(links("ab") + joint("one", "revolute", "a", "b", limit))
    one = robot.links[1].joint
    assert one is not None
    assert (one.effort, one.velocity) == (None, None)


def test_the_scale_applies_to_prismatic_velocities_but_not_to_forces(folder: Folder) -> None:
    inner = (
        '<limit lower="-1" upper="2" effort="87" velocity="2.5"/><dynamics damping="0.125" friction="0.25"/>'
        '<axis xyz="0 0 1"/>'
    )
    (robot,) = folder.robots(
        links("abc") + joint("slides", "prismatic", "a", "b", inner) + joint("turns", "revolute", "a", "c", inner),
        scale=4.0,
    )
    slides, turns = (link.joint for link in robot.links[1:])
    assert slides is not None
    assert turns is not None
    assert (slides.limits, slides.velocity) == ((-4.0, 8.0), 10.0)
    assert (turns.limits, turns.velocity) == ((-1.0, 2.0), 2.5)
    assert {(one.effort, one.damping, one.friction_force) for one in (slides, turns)} == {(87.0, 0.125, 0.25)}


def test_links_below_a_floating_joint_become_a_separate_robot(folder: Folder) -> None:
    first, second, third = folder.robots(
        links("abcde")
        + joint("f", "floating", "a", "b", '<origin xyz="1 2 3"/>')
        + joint("bc", "continuous", "b", "c")
        + joint("g", "floating", "a", "d")
        + joint("ae", "fixed", "a", "e"),
        scale=2.0,
    )
    assert [[link.name for link in robot.links] for robot in (first, second, third)] == [["a", "e"], ["b", "c"], ["d"]]
    assert [robot.fixed for robot in (first, second, third)] == [None, False, False]
    assert [robot.body_type for robot in (first, second, third)] == [None, None, "dynamic"]
    assert second.pose == (2.0, 4.0, 6.0, 1.0, 0.0, 0.0, 0.0)
    assert second.links[0].joint is None
    assert second.links[1].parent == 0


@pytest.mark.parametrize(
    ("kind", "source", "multiplier", "offset"),
    [
        ("prismatic", "prismatic", -2.0, 2.0),
        ("prismatic", "revolute", -8.0, 2.0),
        ("revolute", "prismatic", -0.5, 0.5),
        ("revolute", "revolute", -2.0, 0.5),
    ],
)
def test_the_scale_applies_to_mimics(folder: Folder, kind: str, source: str, multiplier: float, offset: float) -> None:
    """Positions of prismatic joints are lengths: four times as far, where turns are what they were."""
    limit = '<limit lower="-1" upper="2"/>'
    inner = limit + '<mimic joint="one" multiplier="-2" offset="0.5"/>'
    content = links("abc") + joint("two", kind, "a", "c", inner) + joint("one", source, "a", "b", limit)
    (robot,) = folder.robots(content, scale=4.0)
    two = robot.links[1].joint
    assert two is not None
    assert two.mimic is not None
    assert (two.mimic.source, two.mimic.multiplier, two.mimic.offset) == ("one", multiplier, offset)


def test_a_robot_with_one_link_becomes_a_body(folder: Folder) -> None:
    (robot,) = folder.robots(f'<link name="a">{BOX}</link>')
    assert (robot.body_type, robot.fixed) == ("dynamic", None)


def test_files_are_listed_with_the_place_that_names_them(folder: Folder) -> None:
    for name in ("a.obj", "b.png", "robot.srdf"):
        (folder.path / name).write_text("<robot/>")
    visual = '<geometry><mesh filename="a.obj"/></geometry><material name="m"><texture filename="b.png"/></material>'
    found, _ = folder.read(f'\n<link name="a"><visual>{visual}</visual></link>')
    assert found is not None
    assert {(file.uri, file.location.line) for file in found.files} == {("a.obj", 2), ("b.png", 2), ("robot.srdf", 1)}
    (shape,) = found.robots[0].links[0].visuals
    assert shape.geometry == MeshGeometry("a.obj", folder.path / "a.obj", (1.0, 1.0, 1.0))
    assert shape.look == DescribedMaterial(base_color_texture=DescribedTexture("b.png", folder.path / "b.png"))


def test_collision_is_visual_adds_visuals(folder: Folder) -> None:
    (robot,) = folder.robots(f'<link name="a">{BOX}{BOX}</link>', collision_is_visual=True)
    assert [shape.geometry for shape in robot.links[0].visuals] == [c.geometry for c in robot.links[0].collisions]


def test_a_missing_mesh_is_reported_at_its_line_with_the_scene(folder: Folder) -> None:
    (folder.path / "hand.obj").write_text("")
    mesh = '<visual><geometry>\n  <mesh filename="hond.obj"/></geometry></visual>'
    description, (found,) = folder.read(f'\n<link name="a">{mesh}</link>')
    assert description is None
    assert (found.code, found.file, found.line, found.column) == ("SC401", "robot.urdf", 3, 19)
    assert found.location.text == '  <mesh filename="hond.obj"/></geometry></visual></link></robot>'
    assert found.hint is not None
    assert found.hint.startswith(f"looked for it in {folder.path}; did you mean `hand.obj`?")
    assert [(related.message, related.location.file) for related in found.related] == [("used from here", "scene.yaml")]


FAULTS: dict[str, tuple[str, list[str]]] = {
    "no links": ("", ["1:1 SC455 <robot> has no <link>"]),
    "no name": ("<link/>", ["1:17 SC455 <link> has no `name`"]),
    "empty name": ('<link name=" "/>', ["1:29 SC455 the `name` of <link> is empty"]),
    "two links": (links("a") + "\n" + links("a"), ["2:13 SC460 there are two links named `a`"]),
    "two joints": (
        links("abc") + joint("j", "fixed", "a", "b") + joint("j", "fixed", "a", "c"),
        ["3:14 SC460 there are two joints named `j`"],
    ),
    "two materials": (
        links("a") + '\n<material name="m"/>\n<material name="m"/>',
        ["3:17 SC460 there are two materials named `m`"],
    ),
    "no parent": (
        links("ab") + '\n<joint name="j" type="fixed"><child link="b"/></joint>',
        ["2:1 SC455 <joint> has no <parent>"],
    ),
    "unknown links": (
        links("ab") + joint("j", "fixed", "base", "c"),
        [
            "2:44 SC461 the parent of joint `j` is `base`, but there is no such link",
            "2:64 SC461 the child of joint `j` is `c`, but there is no such link",
        ],
    ),
    "itself": (links("a") + joint("j", "fixed", "a", "a"), ["2:1 SC461 joint `j` connects `a` to itself"]),
    "two parents": (
        links("abc") + joint("i", "fixed", "a", "c") + joint("j", "fixed", "b", "c"),
        ["3:1 SC462 the link `c` is the child of two joints, `i` and `j`"],
    ),
    "two roots": (
        links("ab") + "\n" + links("c") + joint("j", "fixed", "b", "c"),
        ["1:33 SC463 2 links have no parent, but a robot has one root: `a`, `b`"],
    ),
    "circle": (
        links("abcd") + joint("i", "fixed", "b", "c") + joint("j", "fixed", "c", "d") + joint("k", "fixed", "d", "b"),
        ["4:1 SC463 links form a cycle: `b` → `c` → `d` → `b`"],
    ),
    "floating": (
        links("abc") + joint("i", "fixed", "a", "b") + joint("j", "floating", "b", "c"),
        ["3:23 SC464 the floating joint `j` has the parent `b`, which is not the root"],
    ),
    "planar": (
        links("ab") + joint("j", "planar", "a", "b"),
        ["2:23 SC464 neither scenecc nor SAPIEN supports planar joints"],
    ),
    "type": (links("ab") + joint("j", "hinge", "a", "b"), ["2:23 SC464 `hinge` is not a joint type"]),
    "no limit": (links("ab") + joint("j", "revolute", "a", "b"), ["2:1 SC465 the revolute joint `j` has no <limit>"]),
    "half a limit": (
        links("ab") + joint("j", "prismatic", "a", "b", "\n<limit lower='1'/>"),
        ["3:1 SC465 <limit> has no `upper`, which SAPIEN requires"],
    ),
    "crossed limits": (
        links("ab") + joint("j", "prismatic", "a", "b", '\n<limit lower="1" upper="0.5"/>'),
        ["3:15 SC465 the lower limit 1 is above the upper 0.5"],
    ),
    "limits beyond": (
        links("ab") + joint("j", "prismatic", "a", "b", '\n<limit lower="inf" upper="inf"/>'),
        ["3:15 SC465 the limits exclude every position"],
    ),
    "friction": (
        links("ab") + joint("j", "continuous", "a", "b", '\n<dynamics friction="-1" damping="-2"/>'),
        [
            "3:21 SC466 the friction is -1, but cannot be negative",
            "3:34 SC466 the damping is -2, but cannot be negative",
        ],
    ),
    "mimic of none": (
        links("ab") + joint("j", "continuous", "a", "b", '\n<mimic joint="i"/>'),
        ["3:15 SC472 joint `j` mimics `i`, but its robot has no such joint"],
    ),
    "mimic of itself": (
        links("ab") + joint("j", "continuous", "a", "b", '\n<mimic joint="j"/>'),
        ["3:15 SC472 joint `j` mimics itself, through `j`"],
    ),
    "mimic by nothing": (
        links("abc")
        + joint("i", "continuous", "a", "b")
        + joint("j", "continuous", "a", "c", '\n<mimic joint="i" multiplier="0"/>'),
        ["4:30 SC472 the multiplier of <mimic> is 0, so the joint never moves"],
    ),
    "geometry": ('<link name="a"><visual/></link>', ["1:32 SC455 <visual> has no <geometry>"]),
    "shape": (
        '<link name="a"><visual><geometry><plane/></geometry></visual></link>',
        [
            "1:40 SC455 <geometry> contains none of <box>, <sphere>, <capsule>, <cylinder>, <mesh>",
            "1:50 SC454 <plane> in <geometry> is unknown and ignored",
        ],
    ),
    "two shapes": (
        '<link name="a"><visual><geometry><sphere radius="1"/>\n<sphere radius="1"/></geometry></visual></link>',
        ["2:1 SC455 <geometry> contains more than one of <box>, <sphere>, <capsule>, <cylinder>, <mesh>"],
    ),
    "sizes": (
        '<link name="a"><visual><geometry>\n<cylinder radius="0" length="-1"/></geometry></visual></link>',
        [
            "2:19 SC466 the `radius` of <cylinder> contains 0, which is not above 0",
            "2:30 SC466 the `length` of <cylinder> contains -1, which is not above 0",
        ],
    ),
    "numbers": (
        (
            '<link name="a"><visual><origin xyz="1 2" rpy="0 nan 0"/>'
            '<geometry>\n<box size="1,2,3"/></geometry></visual></link>'
        ),
        [
            "1:53 SC456 the `xyz` of <origin> must have 3 numbers separated by blanks, and has 2",
            "1:63 SC456 the `rpy` of <origin> contains `nan`, which is not a finite number",
            "2:12 SC456 the `size` of <box> must have 3 numbers separated by blanks, and has 1",
        ],
    ),
    "no numbers": (
        (
            '<link name="a"><visual><geometry>\n<sphere radius="1_0"/></geometry></visual>'
            '<visual><geometry>\n<sphere radius="1e39"/></geometry></visual></link>'
        ),
        [
            "2:17 SC456 the `radius` of <sphere> contains `1_0`, which is not a number",
            "3:17 SC456 the `radius` of <sphere> contains `1e39`, which does not fit in single precision",
        ],
    ),
    "color": (
        links("a")
        + '\n<link name="b"><visual><geometry><sphere radius="1"/></geometry>'
        + '<material name="m"><color rgba="1 0 0"/></material></visual></link>'
        + joint("j", "fixed", "a", "b"),
        ["2:97 SC456 the `rgba` of <color> must have 4 numbers separated by blanks, and has 3"],
    ),
    "mass": (
        f'<link name="a"><inertial>\n<mass value="-1"/>{INERTIA}</inertial></link>',
        ["2:14 SC467 the mass is -1 kg, but cannot be negative"],
    ),
    "inertia": (
        '<link name="a"><inertial>\n<mass value="1"/></inertial></link>',
        ["1:32 SC455 <inertial> has no <inertia>"],
    ),
    "mesh": (
        '<link name="a"><visual><geometry>\n<mesh scale="1 0 1"/></geometry></visual></link>',
        [
            "2:1 SC455 <mesh> has no `filename`",
            "2:14 SC466 the `scale` of <mesh> contains 0",
        ],
    ),
    "what is 0 in single precision": (
        (
            '<link name="a"><visual><geometry>\n<sphere radius="1e-40"/></geometry></visual><visual><geometry>\n'
            '<mesh scale="1 -1e-40 1"/></geometry></visual></link>'
        ),
        [
            "2:17 SC466 the `radius` of <sphere> contains 1e-40, which does not fit in single precision",
            "3:1 SC455 <mesh> has no `filename`",
            "3:14 SC466 the `scale` of <mesh> contains a number that does not fit in single precision",
        ],
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_urdf_error_is_reported_at_its_line(folder: Folder, name: str) -> None:
    content, expected = FAULTS[name]
    assert folder.read(content)[0] is None
    assert folder.told(content) == expected


def test_all_urdf_errors_are_reported_together(folder: Folder) -> None:
    content = "".join(content for content, _ in FAULTS.values() if "link>" in content)
    codes = {line.split()[1] for line in folder.told(content)}
    assert {"SC455", "SC456", "SC460", "SC466", "SC467"} <= codes


WARNINGS: dict[str, tuple[str, list[str]]] = {
    "misspelt": (
        '<link nam="x" name="a"><inertal/></link><link name="b"><inertal/></link>' + joint("j", "fixed", "a", "b"),
        [
            "1:28 SC454 `nam` of <link> is unknown and ignored",
            "1:72 SC454 <inertal> in <link> is unknown and ignored",
        ],
    ),
    "xacro": (links("a") + '<xacro:arm n="1"/>', ["1:33 SC454 <xacro:arm> in <robot> is unknown and ignored"]),
    "axis": (
        links("ab") + joint("j", "continuous", "a", "b", '\n<axis xyz="0 1e-6 0"/>'),
        ["3:12 SC469 the axis of joint `j` has zero length: x is used, as in SAPIEN"],
    ),
    "actuators below 0": (
        links("ab") + joint("j", "revolute", "a", "b", '\n<limit lower="-1" upper="2" effort="-1" velocity="-2"/>'),
        [
            "3:37 SC487 the effort is -1, but a limit cannot be negative: it is ignored",
            "3:51 SC487 the velocity is -2, but a limit cannot be negative: it is ignored",
        ],
    ),
    "degrees": (
        links("ab") + joint("j", "revolute", "a", "b", '\n<limit lower="-90" upper="45"/><origin rpy="0 720 0"/>'),
        [
            "3:15 SC526 a limit of 90 radians: that is 14.3 turns",
            "3:45 SC526 a rotation of 720 radians: that is 115 turns",
        ],
    ),
    "camera": (
        links("a") + '\n<gazebo reference="a"><sensor><camera/></sensor></gazebo><sensor><camera/></sensor>',
        ["2:23 SC470 cameras of a URDF are not built"],
    ),
    "inertial": (
        f'<link name="a"><inertial>\n<mass value="0"/>{INERTIA}</inertial></link>',
        ["1:32 SC475 the mass is 0, so SAPIEN ignores the whole <inertial>"],
    ),
}


@pytest.mark.parametrize("name", WARNINGS)
def test_a_urdf_with_warnings_is_read(folder: Folder, name: str) -> None:
    content, expected = WARNINGS[name]
    assert folder.read(content)[0] is not None
    assert folder.told(content) == expected


def test_elements_of_other_programs_are_ignored_silently(folder: Folder) -> None:
    plain = '\n<dynamics damping="1"/>'
    inner = '\n<safety_controller k_velocity="1"/><calibration rising="0"/><dynamics damping="1" D="2" K="3"/>'
    others = '\n<gazebo><x/></gazebo><transmission name="t"><y/></transmission><mujoco><compiler/></mujoco>'
    found, told = folder.read(links("ab") + joint("j", "continuous", "a", "b", inner) + others)
    assert told == []
    assert found is not None
    assert found == folder.read(links("ab") + joint("j", "continuous", "a", "b", plain))[0]


def test_a_robot_with_too_many_links_is_an_error(folder: Folder) -> None:
    def chain(count: int) -> str:
        names = [f'<link name="l{i}"/>' for i in range(count)]
        return "".join(names) + "".join(joint(f"j{i}", "fixed", f"l{i - 1}", f"l{i}") for i in range(1, count))

    assert len(folder.robots(chain(MAX_LINKS))[0].links) == MAX_LINKS
    assert [line.split()[1] for line in folder.told(chain(MAX_LINKS + 1))] == ["SC477"]


def test_a_long_cycle_and_many_errors_are_reported_quickly(folder: Folder) -> None:
    count = MAX_SHAPES
    names = "".join(f'<link name="l{i}"/>' for i in range(count))
    circle = "".join(joint(f"j{i}", "fixed", f"l{i}", f"l{(i + 1) % count}") for i in range(count))
    start = time.process_time()
    assert [line.split()[1] for line in folder.told(names + circle)] == ["SC463"]
    wrong = "".join(joint(f"j{i}", "fixed", f"l{i}", f"m{i}") for i in range(count))
    assert {line.split()[1] for line in folder.told(names + wrong)} == {"SC461", "SC016"}
    assert_took(time.process_time() - start, most=5)
    assert [line.split()[1] for line in folder.told(names + '<link name="more"/>' + circle)] == ["SC452"]


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("<mujoco/>", "give an MJCF with `mjcf:`"),
        ("<sdf version='1.9'/>", "make a scene of an SDF with `scenecc import`"),
        ("<html/>", None),
    ],
)
def test_a_file_of_another_format_is_reported_with_the_right_key(tmp_path: Path, text: str, hint: str | None) -> None:
    file = tmp_path / "hand.xml"
    file.write_text(text)
    sink = Sink()
    assert read_urdf(ResolvedFile(file, file.name), scope=AssetScope(tmp_path), sink=sink) is None
    assert [(d.code, d.hint) for d in sink.diagnostics()] == [("SC453", hint)]


def test_one_number_for_all_axes_is_written_three_times(tmp_path: Path) -> None:
    file = tmp_path / "r.urdf"
    for size, hint in (("0.2", 'write it 3 times: `size="0.2 0.2 0.2"`'), ("1,2,3", None)):
        box = f'<visual><geometry><box size="{size}"/></geometry></visual>'
        file.write_text(f'<robot name="r"><link name="a">{box}</link></robot>')
        sink = Sink()
        assert read_urdf(ResolvedFile(file, file.name), scope=AssetScope(tmp_path), sink=sink) is None
        assert [(d.code, d.hint) for d in sink.diagnostics()] == [("SC456", hint)]
