"""MJCF files from strangers that MuJoCo compiles: nothing is opened outside the roots, and nothing takes too much."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import pytest

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.robots.mujoco import compiler
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.source.paths import AssetScope, ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

pytest.importorskip("mujoco")

BALL = '<body name="ball"><freejoint/><geom size="0.1"/></body>'


def read(path: Path) -> tuple[Any, list[Diagnostic]]:
    sink = Sink()
    found = read_mjcf(ResolvedFile(path, path.name), scope=AssetScope(path.parent), sink=sink)
    return found, sink.diagnostics()


def errors(folder: Path, text: str) -> list[str]:
    path = folder / "robot.xml"
    path.write_text(text)
    found, told = read(path)
    assert found is None
    return [f"{one.line}:{one.column} {one.code} {one.message}" for one in told if one.severity == "error"]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('<mujoco><asset><mesh file="/etc/hostname"/></asset></mujoco>', "SC402"),
        ('<mujoco><asset><mesh file="../secret.obj"/></asset></mujoco>', "SC402"),
        ('<mujoco><asset><hfield file="/etc/hostname"/></asset></mujoco>', "SC402"),
        ('<mujoco><asset><texture type="2d" file="/etc/hostname"/></asset></mujoco>', "SC402"),
        ('<mujoco><asset><texture type="cube" fileright="/etc/hostname"/></asset></mujoco>', "SC402"),
        ('<mujoco><asset><model name="m" file="/etc/hostname"/></asset></mujoco>', "SC402"),
        ('<mujoco><include file="/etc/hostname"/></mujoco>', "SC402"),
        ('<mujoco><extension><plugin plugin="a"/></extension></mujoco>', "a plugin is code"),
        ('<mujoco><worldbody><flexcomp name="f"/></worldbody></mujoco>', "soft bodies"),
        (f'<mujoco><worldbody><replicate count="2000000">{BALL}</replicate></worldbody></mujoco>', "SC452"),
        (f'<mujoco><worldbody><replicate count="inf">{BALL}</replicate></worldbody></mujoco>', "SC"),
        (
            "<mujoco><worldbody>" + '<replicate count="999">' * 5 + BALL + "</replicate>" * 5 + "</worldbody></mujoco>",
            "SC452 the model is too large: it makes 4e+15 elements, and 100000 are built",
        ),
        ('<mujoco><worldbody><composite prefix="a" type="cable" count="99999999 1 1"/></worldbody></mujoco>', "SC452"),
        (
            '<mujoco><asset><texture name="t" type="2d" builtin="flat" width="99999" height="99999"/></asset></mujoco>',
            "cells",
        ),
        ('<mujoco><asset><hfield name="t" nrow="99999" ncol="99999" size="1 1 1 1"/></asset></mujoco>', "cells"),
        ('<mujoco><worldbody><geom size="-1"/></worldbody></mujoco>', "SC481 MuJoCo refuses the file: "),
        ('<mujoco><worldbody><geom sise="1"/></worldbody></mujoco>', "SC481 MuJoCo refuses the file: "),
        ("<mujoco/>", "SC480"),
    ],
)
def test_a_bad_file_is_an_error_with_a_place(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path.parent / "secret.obj").write_text("v 0 0 0\n")
    started = time.process_time()
    (first, *_) = errors(tmp_path, text)
    assert expected in first
    assert first.startswith("1:")
    assert time.process_time() - started < 5


def test_mujocos_own_errors_stand_at_their_lines_in_included_files_too(tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text(
        '<x>\n  <body>\n    <joint type="slide"/>\n    <geom type="box" size="1"/>\n  </body></x>'
    )
    text = '<mujoco>\n  <worldbody>\n    <include file="in.xml"/></worldbody></mujoco>'
    (tmp_path / "robot.xml").write_text(text)
    found, (fault,) = read(tmp_path / "robot.xml")
    assert found is None
    assert (fault.code, str(fault.file), fault.line) == ("SC481", "in.xml", 4)
    assert "file0" not in fault.message


def test_warnings_stand_at_the_first_of_their_kind_with_a_count(tmp_path: Path) -> None:
    text = f"""<mujoco>
  <worldbody>
    {BALL}
    <camera name="eye"/>
    <camera name="other"/>
    <site name="a"/>
    <site name="b" pos="1 0 0"/>
  </worldbody>
  <tendon><spatial name="t"><site site="a"/><site site="b"/></spatial></tendon>
  <actuator><position tendon="t"/></actuator>
</mujoco>"""
    (tmp_path / "robot.xml").write_text(text)
    found, told = read(tmp_path / "robot.xml")
    assert found is not None
    shown = {(one.code, one.line): one.message for one in told}
    assert shown["SC490", 4].endswith("(there are 2)")
    assert shown["SC490", 6].endswith("(there are 2)")
    assert shown["SC484", 9] == "tendons are not built"
    assert "actuators that pull on tendons, sites or bodies are not built (there are 1)" in shown["SC484", 10]


def test_a_process_that_takes_too_long_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_SECONDS", 0.0)
    (fault,) = errors(tmp_path, f'<mujoco model="slow"><worldbody>{BALL}</worldbody></mujoco>')
    assert "SC458 MuJoCo's compiler takes more than 0 s" in fault
    monkeypatch.undo()
    (tmp_path / "robot.xml").write_text(f'<mujoco model="again"><worldbody>{BALL}</worldbody></mujoco>')
    assert read(tmp_path / "robot.xml")[0] is not None


def test_a_process_that_ends_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_MEMORY", 2**20)
    own = compiler._Compiler()
    monkeypatch.setattr(compiler, "_COMPILER", own)
    (fault,) = errors(tmp_path, f'<mujoco model="small"><worldbody>{BALL}</worldbody></mujoco>')
    own.stop()
    assert "SC458" in fault or "SC481" in fault


def test_one_model_is_compiled_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "robot.xml").write_text(f'<mujoco model="once"><worldbody>{BALL}</worldbody></mujoco>')
    assert read(tmp_path / "robot.xml")[0] is not None

    def fail(*_: Any) -> Any:
        raise AssertionError

    monkeypatch.setattr(compiler._Compiler, "_ask", fail)
    assert read(tmp_path / "robot.xml")[0] is not None


@pytest.mark.parametrize(("version", "words"), [(None, "not installed"), ("3.4.9", "from 3.5"), ("5.0.0", "below 5.0")])
def test_without_a_fitting_mujoco_there_is_one_clear_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: str | None, words: str
) -> None:
    monkeypatch.setattr(compiler, "mujoco_version", lambda: version)
    (fault,) = errors(tmp_path, f"<mujoco><worldbody>{BALL}</worldbody></mujoco>")
    assert "SC457" in fault
    assert words in fault
