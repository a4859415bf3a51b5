"""MJCF files from strangers that MuJoCo compiles: nothing is opened outside the roots, and nothing takes too much."""

from __future__ import annotations

import os
import signal
import struct
import time
import zlib
from typing import TYPE_CHECKING, Any

import pytest
from plugins.nightly import assert_took

from scenecc.diagnostics import Diagnostic, Sink
from scenecc.robots.mujoco import compiler
from scenecc.robots.mujoco.reader import read_mjcf
from scenecc.source.limits import Limits
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
        ('<mujoco><worldbody><body><plugin plugin="a"/></body></worldbody></mujoco>', "plugins are code"),
        (
            '<mujoco><worldbody><composite type="cable"><plugin plugin="a"/></composite></worldbody></mujoco>',
            "SC483 `<plugin>` cannot be built: plugins are code",
        ),
        ('<mujoco><asset><mesh name="a"><plugin instance="a"/></mesh></asset></mujoco>', "plugins are code"),
        ('<mujoco><worldbody><flexcomp name="f"/></worldbody></mujoco>', "soft bodies"),
        (f'<mujoco><worldbody><replicate count="2000000">{BALL}</replicate></worldbody></mujoco>', "SC452"),
        (
            f'<mujoco><worldbody><replicate count="10001">{BALL}</replicate></worldbody></mujoco>',
            "SC452 the model is too large: it has 10001 bodies, and the limit is 10000",
        ),
        (f'<mujoco><worldbody><replicate count="inf">{BALL}</replicate></worldbody></mujoco>', "SC"),
        (
            "<mujoco><worldbody>" + '<replicate count="999">' * 5 + BALL + "</replicate>" * 5 + "</worldbody></mujoco>",
            "SC452 the model is too large: it has 4e+15 elements, and the limit is 100000",
        ),
        ('<mujoco><worldbody><composite prefix="a" type="cable" count="99999999 1 1"/></worldbody></mujoco>', "SC452"),
        (
            '<mujoco><asset><texture name="t" type="2d" builtin="flat" width="99999" height="99999"/></asset></mujoco>',
            "cells",
        ),
        ('<mujoco><asset><hfield name="t" nrow="99999" ncol="99999" size="1 1 1 1"/></asset></mujoco>', "cells"),
        ('<mujoco><worldbody><body pos="nan 0 0"><freejoint/><geom size="1"/></body></worldbody></mujoco>', "SC481"),
        ('<mujoco><worldbody><body pos="1e300 0 0"><geom size="1"/></body></worldbody></mujoco>', "becomes 1e+300"),
        (
            (
                "<mujoco><worldbody><body><joint name='j'/><geom size='1'/></body></worldbody><actuator>"
                "<position joint='j' kp='3' gear='1e200'/></actuator></mujoco>"
            ),
            "`actuator_gear` becomes 1e+200, and the limit is 1e+12",
        ),
        ('<mujoco><worldbody><geom size="-1"/></worldbody></mujoco>', "SC481 MuJoCo refuses the file: "),
        ('<mujoco><worldbody><geom sise="1"/></worldbody></mujoco>', "SC481 MuJoCo refuses the file: "),
        (
            '<mujoco><worldbody><body><joint armature="-1"/><geom size="1"/></body></worldbody></mujoco>',
            "SC481 `armature` is -1, but cannot be negative",
        ),
        ("<mujoco/>", "SC480"),
    ],
)
def test_a_bad_file_is_an_error_with_a_place(tmp_path: Path, text: str, expected: str) -> None:
    (tmp_path.parent / "secret.obj").write_text("v 0 0 0\n")
    started = time.process_time()
    (first, *_) = errors(tmp_path, text)
    assert expected in first
    assert first.startswith("1:")
    assert_took(time.process_time() - started, most=5)


def test_mujoco_errors_are_reported_at_their_lines_even_in_included_files(tmp_path: Path) -> None:
    (tmp_path / "in.xml").write_text(
        '<x>\n  <body>\n    <joint type="slide"/>\n    <geom type="box" size="1"/>\n  </body></x>'
    )
    text = '<mujoco>\n  <worldbody>\n    <include file="in.xml"/></worldbody></mujoco>'
    (tmp_path / "robot.xml").write_text(text)
    found, (fault,) = read(tmp_path / "robot.xml")
    assert found is None
    assert (fault.code, str(fault.file), fault.line) == ("SC481", "in.xml", 4)
    assert "file0" not in fault.message


def test_warnings_of_a_kind_are_reported_once_with_a_count(tmp_path: Path) -> None:
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
    assert "actuators on tendons, sites or bodies are not built (there are 1)" in shown["SC484", 10]


def test_a_compiler_that_takes_too_long_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_SECONDS", 0.0)
    # A new one, which does not answer before MuJoCo is imported.
    monkeypatch.setattr(compiler, "_COMPILER", compiler._CompilerProcess())
    (fault,) = errors(tmp_path, f'<mujoco model="slow"><worldbody>{BALL}</worldbody></mujoco>')
    assert "SC458 MuJoCo's compiler took more than 0 s" in fault
    monkeypatch.undo()
    (tmp_path / "robot.xml").write_text(f'<mujoco model="again"><worldbody>{BALL}</worldbody></mujoco>')
    assert read(tmp_path / "robot.xml")[0] is not None


def test_a_compiler_without_enough_memory_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "_MEMORY", 2**20)
    own = compiler._CompilerProcess()
    monkeypatch.setattr(compiler, "_COMPILER", own)
    (fault,) = errors(tmp_path, f'<mujoco model="small"><worldbody>{BALL}</worldbody></mujoco>')
    own._worker.stop()
    assert "SC458" in fault or "SC481" in fault


def test_the_compiler_is_restarted_after_it_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernel ends it with the thread that started it, perhaps while another thread asks."""
    own = compiler._CompilerProcess()
    monkeypatch.setattr(compiler, "_COMPILER", own)
    for number in range(2):
        (tmp_path / "robot.xml").write_text(f'<mujoco model="{number}"><worldbody>{BALL}</worldbody></mujoco>')
        found, told = read(tmp_path / "robot.xml")
        assert found is not None, told
        assert own._worker._process is not None
        own._worker._process.kill()
        # It looks alive still, as it does to a thread that asks at this moment.
        monkeypatch.setattr(own._worker._process, "poll", lambda: None)
    own._worker.stop()


def test_a_forked_process_starts_its_own_compiler(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(f'<mujoco model="before"><worldbody>{BALL}</worldbody></mujoco>')
    assert read(tmp_path / "robot.xml")[0] is not None
    (tmp_path / "robot.xml").write_text(f'<mujoco model="after"><worldbody>{BALL}</worldbody></mujoco>')
    # Another thread may be compiling at this moment.
    with compiler._COMPILER._worker._lock:
        child = os.fork()
        if child == 0:
            signal.alarm(50)
            os._exit(0 if read(tmp_path / "robot.xml")[0] is not None else 1)
    assert os.waitpid(child, 0)[1] == 0
    assert read(tmp_path / "robot.xml")[0] is not None


def model_of(rest: str, body: str = BALL) -> str:
    return f"<mujoco>{rest}<worldbody>{body}</worldbody></mujoco>"


ATTACH = '<attach model="m" prefix="{}"/>'


@pytest.mark.parametrize(
    ("inner", "expected"),
    [
        ('<mujoco>\n<asset><mesh file="/etc/hostname"/></asset></mujoco>', "2:20 SC402"),
        ('<mujoco>\n<asset><model name="x" file="robot.xml"/></asset></mujoco>', "2:30 SC486"),
        ('<mujoco>\n<worldbody><geom sise="1"/></worldbody></mujoco>', "2:12 SC481"),
        ('<mujoco>\n<worldbody><geom size="-1"/></worldbody></mujoco>', "2:12 SC481"),
        ("<mujoco>\n<deformable/></mujoco>", "2:1 SC483"),
        ("<mujoco>\n<asset></mujoco>", "SC450"),
    ],
)
def test_errors_in_attached_models_are_reported_in_their_files(tmp_path: Path, inner: str, expected: str) -> None:
    (tmp_path / "inner.xml").write_text(inner)
    asset = '<asset><model name="m" file="inner.xml"/></asset>'
    (first, *_) = errors(tmp_path, model_of(asset, BALL.replace("<geom", ATTACH.format("a_") + "<geom")))
    assert expected in first


def test_elements_of_attached_models_are_counted(tmp_path: Path) -> None:
    many = "".join(f"<body>{ATTACH.format(number)}</body>" for number in range(30))
    for number in range(5):
        asset = f'<asset><model name="m" file="{number + 1}.xml"/></asset>'
        (tmp_path / f"{number}.xml").write_text(model_of(asset, many))
    (tmp_path / "5.xml").write_text(model_of("", BALL))
    (fault, *_) = errors(tmp_path, model_of('<asset><model name="m" file="0.xml"/></asset>', ATTACH.format("a")))
    assert "SC452 the model is too large" in fault


def test_memory_for_simulation_is_not_allocated(tmp_path: Path) -> None:
    (tmp_path / "robot.xml").write_text(f'<mujoco><size memory="6G"/><worldbody>{BALL}</worldbody></mujoco>')
    found, told = read(tmp_path / "robot.xml")
    assert found is not None, told


def test_absolute_paths_must_be_inside_the_roots(tmp_path: Path) -> None:
    for folder in ("models", "meshes"):
        (tmp_path / folder).mkdir()
    (tmp_path / "meshes/a.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    asset = f'<asset><mesh name="a" file="{tmp_path}/meshes/../meshes/a.obj"/></asset>'
    path = tmp_path / "models/robot.xml"
    path.write_text(f'<mujoco>{asset}<worldbody><geom type="mesh" mesh="a"/></worldbody></mujoco>')
    sink = Sink()
    scope = AssetScope(path.parent, (tmp_path,))
    assert read_mjcf(ResolvedFile(path, path.name), scope=scope, sink=sink) is not None, sink.diagnostics()
    assert read(path)[0] is None


def test_a_folder_called_mujoco_is_not_mujoco(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mujoco").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(compiler.importlib.metadata, "version", _not_installed)
    compiler.mujoco_version.cache_clear()
    (fault,) = errors(tmp_path, f"<mujoco><worldbody>{BALL}</worldbody></mujoco>")
    compiler.mujoco_version.cache_clear()
    assert "SC457" in fault
    assert "not installed" in fault


def _not_installed(name: str) -> str:
    raise compiler.importlib.metadata.PackageNotFoundError(name)


def chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width: int, height: int, unpacked: int = 0) -> bytes:
    """A grey picture, whatever its header says. `unpacked`: so many bytes of pixels [MiB]."""
    pack = zlib.compressobj(9)
    data = b"".join([*(pack.compress(bytes(2**20)) for _ in range(unpacked)), pack.flush()])
    head = chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 0, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", data) + chunk(b"IEND", b"")


CORNERS = struct.pack("<12f", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1)
BOMBS = {
    "header.png": (png(2**31 - 1, 2**31 - 1), "SC452 the model is too large"),
    "wide.png": (png(16384, 12000), "SC452 the model is too large"),
    "inflates.png": (png(2, 2, unpacked=100), "SC4"),
    "chunk.png": (png(2, 2)[:33] + struct.pack(">I", 2**32 - 5) + b"IDAT", "SC481"),
    "short.png": (png(2, 2)[:20], "SC481"),
    "count.bin": (struct.pack("<2i", 2**31 - 1, 2**31 - 1) + bytes(99), "SC481"),
    "negative.bin": (struct.pack("<2i", -2, -2) + bytes(16), "SC481"),
    "heights.bin": (struct.pack("<2i", 520, 520) + bytes(4 * 520**2), "SC452 a height field has more than 262144"),
    "count.stl": (bytes(80) + struct.pack("<I", 2**31 - 1) + bytes(99), "SC481"),
    "none.stl": (bytes(84), "SC481"),
    "nan.stl": (bytes(80) + struct.pack("<I", 4) + struct.pack("<12fH", *[float("nan")] * 12, 0) * 4, "SC481"),
    "count.msh": (struct.pack("<4i", 2**31 - 1, 0, 0, 2**31 - 1) + CORNERS, "SC481"),
    "negative.msh": (struct.pack("<4i", -4, -1, -1, -4) + CORNERS, "SC481"),
    "index.msh": (struct.pack("<4i", 4, 0, 0, 4) + CORNERS + struct.pack("<12i", *[2**31 - 1] * 12), "SC481"),
    "index.obj": (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 999999999\nf -9 -8 -7\n", "SC481"),
    "nan.obj": (b"v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "SC481"),
}


@pytest.mark.parametrize("name", BOMBS)
def test_a_bad_asset_is_an_error_at_the_element_that_names_it(tmp_path: Path, name: str) -> None:
    data, expected = BOMBS[name]
    (tmp_path / name).write_bytes(data)
    kind = "mesh" if name.endswith(("stl", "msh", "obj")) else "hfield"
    size = "" if kind == "mesh" else 'size="1 1 1 1"'
    asset = f'\n<asset><{kind} name="a" file="{name}" {size}/></asset>'
    started = time.process_time()
    (first, *_) = errors(tmp_path, model_of(asset, f'<geom type="{kind}" {kind}="a"/>'))
    assert expected in first
    assert first.startswith("2:")
    assert_took(time.process_time() - started, most=5)


@pytest.mark.parametrize("attribute", ["file", "fileright"])
def test_images_are_not_decoded_by_the_compiler(tmp_path: Path, attribute: str) -> None:
    """The scene's own checks read those that are shown."""
    (tmp_path / "t.png").write_bytes(png(2**31 - 1, 2**31 - 1))
    asset = f'<asset><texture name="t" {attribute}="t.png"/><material name="m" texture="t"/></asset>'
    (tmp_path / "robot.xml").write_text(model_of(asset, '<geom size="1" material="m"/>'))
    found, told = read(tmp_path / "robot.xml")
    assert found is not None, told
    look = found.robots[0].links[0].visuals[0].look
    assert (look.base_color_texture and look.base_color_texture.uri) == ("t.png" if attribute == "file" else None)
    assert [one.code for one in told] == ([] if attribute == "file" else ["SC484"])


def test_the_total_size_of_a_models_files_is_limited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(3):
        (tmp_path / f"{number}.stl").write_bytes(bytes(600))
    asset = "<asset>" + "".join(f'\n<mesh file="{number}.stl"/>' for number in range(3)) + "</asset>"
    path, sink = tmp_path / "robot.xml", Sink()
    path.write_text(model_of(asset))
    monkeypatch.setattr("scenecc.robots.mujoco.source.MAX_READ_MEMORY", 1500)
    file = ResolvedFile(path, path.name)
    assert read_mjcf(file, scope=AssetScope(tmp_path), sink=sink, limits=Limits()) is None
    (fault,) = sink.diagnostics()
    assert (fault.code, fault.line) == ("SC452", 4)
    assert fault.message == "the model's files have more than 1500 bytes together"


def test_a_large_answer_of_the_compiler_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.worker.MAX_ANSWER", 10_000)
    body = "".join(f"<body pos='{number} 0 0'><freejoint/><geom size='1'/></body>" for number in range(99))
    (fault,) = errors(tmp_path, model_of("", body))
    assert "SC458 the answer of MuJoCo's compiler has more than 10000 bytes" in fault


HINGE = '<body name="a"><joint name="a"/><geom size="1"/>{}</body>'
MORE = '<body pos="1 0 0"><joint name="b"/><geom size="1"/></body><body><joint name="c"/><geom size="1"/></body>'


@pytest.mark.parametrize(
    ("body", "rest", "expected"),
    [
        (HINGE.replace("<body", '<body gravcomp="0.5"', 1).format(""), "", "`gravcomp` other than 0 and 1"),
        ('<body><joint type="ball" range="0 9"/><geom size="1"/></body>', "", "limits and the spring of a ball joint"),
        (
            '<body><joint type="free" damping="1"/><geom size="1"/></body>',
            "",
            "a free joint is built without its `damping`",
        ),
        (HINGE.format(""), '<option><flag limit="disable"/></option>', "`<flag limit"),
        (HINGE.replace("<joint", '<joint stiffness="-3"').format(""), "", "negative `stiffness` and `damping`"),
        (HINGE.replace("<joint", '<joint damping="-3"').format(""), "", "negative `stiffness` and `damping`"),
        (
            HINGE.format(MORE),
            '<equality><joint joint1="a" joint2="b"/><joint joint1="a" joint2="c"/></equality>',
            "`a` can follow only one other joint",
        ),
        (
            HINGE.format(MORE),
            '<equality><joint joint1="a" joint2="b" polycoef="0 0 1 0 0"/></equality>',
            "`a` is free: it follows `b` by a polynomial",
        ),
        (
            HINGE.format(""),
            '<actuator><general joint="a" biastype="affine" biasprm="3 0 -1"/></actuator>',
            "a velocity actuator with a nonzero target",
        ),
    ],
)
def test_unbuilt_features_are_reported(tmp_path: Path, body: str, rest: str, expected: str) -> None:
    (tmp_path / "robot.xml").write_text(f"<mujoco>{rest}<worldbody>{body}</worldbody></mujoco>")
    found, told = read(tmp_path / "robot.xml")
    assert found is not None, told
    assert any(one.code == "SC484" and expected in one.message for one in told), told


def test_frictions_and_colours_are_clamped_to_their_ranges(tmp_path: Path) -> None:
    geom = '<body><joint damping="-3"/><geom size="1" friction="-2 0 0" rgba="-3 1e11 0.5 9"/></body>'
    (tmp_path / "robot.xml").write_text(model_of("", geom))
    found, told = read(tmp_path / "robot.xml")
    assert found is not None, told
    link = found.robots[0].links[1]
    assert (link.collisions[0].friction, link.joint.damping) == ((0, 0, 0), 0)
    assert link.visuals[0].look.base_color == pytest.approx((0, 1, 0.214041, 1))


def test_nonlinear_springs_are_reported(tmp_path: Path) -> None:
    if int(str(compiler.mujoco_version()).partition(".")[0]) < 4:
        pytest.skip("of MuJoCo 4")
    body = '<body><joint stiffness="3 1" damping="1"/><geom size="1"/></body>'
    (tmp_path / "robot.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    _, told = read(tmp_path / "robot.xml")
    assert [one.message for one in told] == ["only the first number of stiffness and damping is built"]


@pytest.mark.parametrize(
    ("bodies", "expected"),
    [
        (f'{BALL}<body name="body_2"><freejoint/><geom size="1"/></body><body><freejoint/><geom size="1"/></body>', 3),
        (HINGE.format('<body name="body_3"/><body/>'), 4),
        (HINGE.replace('"a"', '"dummy_root_0"', 1).format(""), 2),
        (
            HINGE.format('<body name="b_dummy_0"/><body name="b"><joint/><joint axis="1 0 0"/><geom size="1"/></body>'),
            5,
        ),
    ],
)
def test_generated_names_avoid_names_in_the_file(tmp_path: Path, bodies: str, expected: int) -> None:
    (tmp_path / "robot.xml").write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    found, told = read(tmp_path / "robot.xml")
    assert found is not None, told
    names = [link.name for robot in found.robots for link in robot.links]
    assert len(set(names)) == len(names) == expected


def test_one_model_is_compiled_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "robot.xml").write_text(f'<mujoco model="once"><worldbody>{BALL}</worldbody></mujoco>')
    assert read(tmp_path / "robot.xml")[0] is not None

    def fail(*_: Any) -> Any:
        raise AssertionError

    monkeypatch.setattr(compiler._COMPILER._worker, "ask", fail)
    assert read(tmp_path / "robot.xml")[0] is not None


@pytest.mark.parametrize(("version", "words"), [(None, "not installed"), ("3.4.9", "from 3.5"), ("5.0.0", "below 5.0")])
def test_a_missing_or_unsupported_mujoco_is_one_error(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, version: str | None, words: str
) -> None:
    monkeypatch.setattr(compiler, "mujoco_version", lambda: version)
    (fault,) = errors(tmp_path, f"<mujoco><worldbody>{BALL}</worldbody></mujoco>")
    assert "SC457" in fault
    assert words in fault


def test_too_many_links_that_ignore_one_another_are_an_error_with_a_fitting_hint(tmp_path: Path) -> None:
    joints = '<joint axis="1 0 0"/><joint axis="0 1 0"/>'
    body = '<body pos="0 0 -1"><freejoint/><geom size="0.1"/>'
    body += "".join(f'<body pos="0 0 -0.3">{joints}<geom size="0.2"/>' for _ in range(40)) + "</body>" * 41
    (tmp_path / "robot.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
    _, (told, *_) = read(tmp_path / "robot.xml")
    assert told.code == "SC483"
    assert "give each body of a chain one hinge" in (told.hint or "")
