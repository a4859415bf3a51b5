"""MJCF files from strangers: bounded, inside the scene's folders, and never a traceback."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plugins.nightly import assert_took, examples

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.source import Limits
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.robots.description import RobotDescription

pytest.importorskip("mujoco")


def read(path: Path, limits: Limits | None = None) -> tuple[RobotDescription | None, list[Diagnostic]]:
    sink = Sink()
    scope = AssetScope(path.parent)
    found = read_mjcf(ResolvedFile(path, path.name), scope=scope, sink=sink, limits=limits or Limits())
    return found, sink.diagnostics()


def codes(path: Path, text: str) -> list[str]:
    path.write_text(text)
    found, told = read(path)
    assert found is None
    return [one.code for one in told]


def test_a_file_that_includes_itself_is_refused(tmp_path: Path) -> None:
    assert codes(tmp_path / "a.xml", '<mujoco><include file="a.xml"/></mujoco>') == ["SC486"]
    (tmp_path / "b.xml").write_text('<mujoco><include file="./x/../c.xml"/></mujoco>')
    (tmp_path / "x").mkdir()
    assert codes(tmp_path / "c.xml", '<mujoco><include file="b.xml"/></mujoco>') == ["SC486"]


def test_a_long_chain_of_includes_is_refused(tmp_path: Path) -> None:
    for number in range(110):
        (tmp_path / f"{number}.xml").write_text(f'<mujoco><include file="{number + 1}.xml"/></mujoco>')
    (tmp_path / "110.xml").write_text('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
    found, told = read(tmp_path / "0.xml")
    assert found is None
    assert [(one.code, one.file) for one in told] == [("SC452", "99.xml")]
    assert read(tmp_path / "0.xml", Limits(depth=120))[0] is not None


def test_nesting_through_includes_is_limited(tmp_path: Path) -> None:
    deep = "<body>" * 60 + "{}" + "</body>" * 60
    (tmp_path / "in.xml").write_text(f"<x>{deep.format('')}</x>")
    whole = (
        f"<mujoco><worldbody>{deep.format('<include file=' + chr(34) + 'in.xml' + chr(34) + '/>')}</worldbody></mujoco>"
    )
    assert codes(tmp_path / "a.xml", whole) == ["SC452"]


def test_the_total_size_of_included_files_is_limited(tmp_path: Path) -> None:
    for name in "ab":
        (tmp_path / f"{name}.xml").write_text("<x>" + " " * (9 * 2**20) + "</x>")
    assert codes(tmp_path / "r.xml", '<mujoco><include file="a.xml"/><include file="b.xml"/></mujoco>') == ["SC452"]


def test_a_document_type_is_refused_in_an_included_file_too(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text('<!DOCTYPE x [<!ENTITY a SYSTEM "/etc/passwd">]><x>&a;</x>')
    assert codes(tmp_path / "r.xml", '<mujoco><include file="a.xml"/></mujoco>') == ["SC451"]


def test_a_symbolic_link_out_of_the_roots_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "scene").mkdir()
    (tmp_path / "secret.xml").write_text("<x/>")
    (tmp_path / "scene" / "in.xml").symlink_to(tmp_path / "secret.xml")
    assert codes(tmp_path / "scene" / "r.xml", '<mujoco><include file="in.xml"/></mujoco>') == ["SC402"]


@pytest.mark.parametrize(
    "text",
    [
        "<mujoco><worldbody>" + '<geom name="g" size=".1"/>' * 20_000 + "</worldbody></mujoco>",
        "<mujoco><worldbody>" + '<body><joint axis="0 0 1"/><geom size=".1"/></body>' * 2_000 + "</worldbody></mujoco>",
        "<mujoco><worldbody><geom " + " ".join(f'a{i}="1"' for i in range(20_000)) + ' size="1"/></worldbody></mujoco>',
        "<mujoco><worldbody>" + '<geom size="x" class="y"/>' * 20_000 + "</worldbody></mujoco>",
        "<mujoco>"
        + "".join(f'<default class="c{i}">' for i in range(80))
        + "".join(f'<geom size="{i + 1}"/>' for i in range(20_000))
        + "</default>" * 80
        + "<worldbody>"
        + '<geom class="c79"/>' * 20_000
        + "</worldbody></mujoco>",
    ],
    ids=["one name", "robots", "attributes", "mistakes", "classes"],
)
def test_a_large_file_is_read_quickly(text: str, tmp_path: Path) -> None:
    path = tmp_path / "r.xml"
    path.write_text(text)
    start = time.process_time()
    read(path)
    assert_took(time.process_time() - start, most=8)


TAGS = [
    *("worldbody", "body", "geom", "joint", "freejoint", "default", "asset", "mesh", "material", "texture", "include"),
    *("compiler", "option", "flag", "site", "actuator", "frame", "inertial"),
]
VALUES = [
    *(
        "",
        " ",
        "0",
        "1",
        "-1",
        "1 0 0",
        "0 0 0",
        "1 2 3 4",
        "1 0 0 0 1 0",
        "nan",
        "inf",
        "1e400",
        "1e-40",
        "9" * 500,
        "x",
    ),
    *("true", "false", "auto", "disable", "hinge", "slide", "ball", "free", "fixed", "box", "capsule", "mesh", "plane"),
    *(
        "sphere",
        "c",
        "main",
        "motor",
        "m",
        "r.xml",
        "no.obj",
        "../x",
        "/",
        "\u202e",
        "radian",
        "zyx",
        "XyZ",
        ".1 .2 .3",
    ),
]
NAMES = [
    *("name", "class", "childclass", "type", "pos", "quat", "euler", "axisangle", "xyaxes", "zaxis", "size", "fromto"),
    *("mesh", "material", "texture", "file", "scale", "refquat", "range", "limited", "axis", "damping", "friction"),
    *(
        "condim",
        "contype",
        "conaffinity",
        "group",
        "rgba",
        "density",
        "angle",
        "eulerseq",
        "meshdir",
        "contact",
        "other",
    ),
]


@st.composite
def elements(draw: st.DrawFn, depth: int = 0) -> str:
    tag = draw(st.sampled_from(TAGS))
    given = draw(st.dictionaries(st.sampled_from(NAMES), st.sampled_from(VALUES), max_size=4))
    attributes = "".join(f' {name}="{value}"' for name, value in given.items())
    inner = "".join(draw(st.lists(elements(depth + 1), max_size=3))) if depth < 3 else ""
    return f"<{tag}{attributes}>{inner}</{tag}>"


@settings(max_examples=examples(60))
@given(sections=st.lists(elements(), max_size=3), world=st.lists(elements(1), max_size=4))
def test_no_file_raises_and_refusals_are_reported(
    sections: list[str], world: list[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "r.xml"
    path.write_text(f"<mujoco>{''.join(sections)}<worldbody>{''.join(world)}</worldbody></mujoco>")
    found, told = read(path)
    assert (found is None) == any(one.severity == "error" for one in told)
    assert all(one.line is not None for one in told)
