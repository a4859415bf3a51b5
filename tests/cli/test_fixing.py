"""`--fix` and `--diff`: what is safe is corrected, and all else stays as it is written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scenecc.cli import corrections
from scenecc.cli.corrections import _check_text, corrected
from scenecc.diagnostics import Diagnostic
from scenecc.options import Options

BEFORE = """\
# a door   with its own layout
scenecc: 1
entities:
  door:   {pose: {p: [0,0,1], rpy: [0, 0, 90]},  # degrees
    mass:  1, shapes: [{type: box, half_sizes: [0.1, 0.1, 1]}]}
  cup: {pose: {q: [0.7, 0, 0, 0.72]}, mass: 1, shapes: [{type: sphere, radius: 0.1}]}
"""


def fixed(run, file: Path) -> str:
    """The file after `--fix`."""
    run("validate", "--fix", file)
    return file.read_text()


def test_fix_makes_only_safe_corrections(run, tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(BEFORE)
    after = fixed(run, file)
    lines = after.splitlines()
    assert lines[3] == "  door:   {pose: {p: [0,0,1], rpy_deg: [0, 0, 90]},  # degrees"
    assert lines[4] == "    mass:  1, shapes: [{type: box, half_size: [0.1, 0.1, 1]}]}"
    assert lines[5].startswith("  cup: {pose: {q: [0.697")
    assert [lines[i] for i in (0, 1, 2)] == BEFORE.splitlines()[:3]
    assert run("validate", "--strict", "--fix", file).returncode == 0
    assert file.read_text() == after


@pytest.mark.parametrize("form", ["text", "json"])
def test_corrections_are_listed_on_standard_error(run, tmp_path: Path, form: str) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(BEFORE.replace("[0.7, 0, 0, 0.72]", "[1.02, 0, 0, 0]"))
    done = run("validate", "--fix", "--format", form, file)
    assert [line for line in done.stderr.splitlines() if "checked" not in line] == [
        f"{file}:4:36: corrected SC526: 90 radians are 14.3 turns; wrote `rpy_deg`",
        f"{file}:5:36: corrected SC101: unknown key `half_sizes`; wrote `half_size`",
        f"{file}:6:19: corrected SC112: the quaternion's length is 1.02, not 1; wrote `[1.0, 0.0, 0.0, 0.0]`",
        "3 corrections",
    ]
    if form == "json":
        report = json.loads(done.stdout)
        assert report["diagnostics"] == []
        made = [(one["code"], one["line"], one["column"], one["wrote"]) for one in report["corrections"]]
        assert made == [
            ("SC526", 4, 36, "rpy_deg"),
            ("SC101", 5, 36, "half_size"),
            ("SC112", 6, 19, "[1.0, 0.0, 0.0, 0.0]"),
        ]
        assert "corrections" not in json.loads(run("validate", "--format", form, file).stdout)
        assert json.loads(run("validate", "--fix", "--format", form, file).stdout)["corrections"] == []
    else:
        assert done.stdout == ""
    assert "correct" not in run("validate", "--fix", file).stderr


def test_many_corrections_need_few_checks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Together where all of them do good, and those beside one that does not, too."""
    lines = [f"  a{i}: {{mas: 1, pose: [{3 * i}, 0, 5], shapes: [{{type: sphere, radus: 0.1}}]}}\n" for i in range(64)]
    file = tmp_path / "s.yaml"
    checks: list[str] = []

    def check(name: str, options: Options, text: str) -> list[Diagnostic]:
        checks.append(text)
        return _check_text(name, options, text)

    monkeypatch.setattr(corrections, "_check_text", check)
    for other, most in (("", 6), ("  b: {mas: 1, mass: 1, shapes: [{type: sphere, radius: 0.1}]}\n", 30)):
        checks.clear()
        file.write_text("scenecc: 1\nentities:\n" + "".join([*lines[:20], other, *lines[20:]]))
        found = corrected(str(file), Options())
        assert found is not None
        assert len(found.corrections) == 128
        assert len(checks) <= most


def test_fix_does_not_write_a_file_that_changed_meanwhile(tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(BEFORE)
    found = corrected(str(file), Options())
    assert found is not None
    file.write_text(BEFORE + "# more\n")
    fault = found.write()
    assert fault is not None
    assert fault.code == "SC904"
    assert file.read_text() == BEFORE + "# more\n"
    file.unlink()
    assert corrected(str(file), Options()) is None
    assert found.write() is not None
    assert not file.exists()


def test_another_spelling_of_a_word_is_corrected(run, tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    body = "{mass: 1, shapes: [{type: sphere, radius: 0.1, colour: [1, 0, 0]}]}"
    file.write_text(f"scenecc: 1\nphysics: {{time_step: 0.01}}\nentities: {{a: {body}}}\n")
    after = fixed(run, file)
    assert "color: [1, 0, 0]" in after
    assert "timestep: 0.01" in after


def test_another_notation_of_a_value_is_corrected(run, tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(
        "scenecc: 1\nentities:\n"
        "  a: {mass: 1kg, color: red, pose: {pos: [0, 0, 1]}, shapes: [{type: sphere, radius: 10cm}]}  # one\n"
        "  b:\n    gravity: yes\n    pose: '3 0 1'\n    shapes: [{type: sphere, radius: 0.1}]\n"
        "cameras: {c: {fovy: 60, width: 64, height: 64}}\n"
    )
    after = fixed(run, file)
    assert after.splitlines()[2:] == [
        '  a: {mass: 1, color: "#ff0000", pose: {p: [0, 0, 1]}, shapes: [{type: sphere, radius: 0.1}]}  # one',
        *("  b:", "    gravity: true", "    pose: [3, 0, 1]", "    shapes: [{type: sphere, radius: 0.1}]"),
        "cameras: {c: {fovy_deg: 60, width: 64, height: 64}}",
    ]
    assert run("validate", file).returncode == 0


@pytest.mark.parametrize(
    "line", ["mass: 1,000 kg", "mass: 2 cm", "mass: 5 Hz", "pose: [0, 0, 90deg]", "color: light red", "color: facade"]
)
def test_what_may_mean_something_else_is_not_corrected(tmp_path: Path, line: str) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(f"scenecc: 1\nentities:\n  a:\n    {line}\n    shapes: [{{type: sphere, radius: 0.1}}]\n")
    assert corrected(str(file), Options()) is None


def test_diff_option_changes_no_file(run, tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(BEFORE)
    done = run("validate", "--diff", file)
    assert done.returncode == 1
    assert "+    mass:  1, shapes: [{type: box, half_size: [0.1, 0.1, 1]}]}\n" in done.stderr
    assert file.read_text() == BEFORE


@pytest.mark.parametrize(
    "line",
    [
        "a: {mass: 1, masss: 2, shapes: [{type: sphere, radius: 0.1}]}",  # would be a duplicate
        "a: {mass: 1, shapes: [{type: box, size: [0.1, 0.1, 0.1]}]}",  # a half of it, or all
        "a: {quat: [1, 0, 0, 0], mass: 1, shapes: [{type: sphere, radius: 0.1}]}",
        "a: {pose: {q: [1, 1, 0, 0]}, shapes: [{type: sphere, radius: 0.1}]}",
        "a: {pose: [0, 0, 1, 0, 0, 0], shapes: [{type: sphere, radius: 0.1}]}",  # angles of a kind
        "a: {pose: {euler: [0, 0, 90]}, shapes: [{type: sphere, radius: 0.1}]}",
        "a: {shapes: [{type: box, half_size: 0.1}]}",
        "a: {box: [0.1, 0.1, 0.1]}",
        "a: {shapes: [{type: sphere, radius: 0.1}]}\nscenecc: 2",
    ],
)
def test_unsafe_corrections_are_not_made(run, tmp_path: Path, line: str) -> None:
    file = tmp_path / "s.yaml"
    file.write_text(f"scenecc: 1\nentities:\n  {line}\n")
    before = file.read_text()
    assert run("validate", "--fix", file).returncode == 1
    assert file.read_text() == before


def test_quoted_keys_and_several_mistakes_in_a_line_are_corrected(run, tmp_path: Path) -> None:
    file = tmp_path / "s.json"
    shapes = '"shapes": [{"type": "sphere", "radios": 1}]'
    scene = f'{{"scenecc": 1, "entities": {{"a": {{"pose": {{"rpy": [0, 0, 90]}}, {shapes}}}}}}}'
    file.write_text(scene)
    assert fixed(run, file) == scene.replace("rpy", "rpy_deg").replace("radios", "radius")


def test_several_mistakes_in_a_line_are_corrected_in_one_run(run, tmp_path: Path) -> None:
    file = tmp_path / "s.yaml"
    body = "{pose: {rpy: [0, 0, 90]}, shapes: [{type: sphere, radios: 0.1}, {type: box, half_sizes: [1, 1, 1]}]}"
    file.write_text(f"scenecc: 1\nentities: {{a: {body}, b: {body}}}\n")
    right = body.replace("rpy", "rpy_deg").replace("radios", "radius").replace("half_sizes", "half_size")
    assert f"+entities: {{a: {right}, b: {right}}}\n" in run("validate", "--diff", file).stderr
    assert run("validate", "--fix", file).returncode == 0
    assert file.read_text() == f"scenecc: 1\nentities: {{a: {right}, b: {right}}}\n"


@pytest.mark.parametrize("option", ["--fix", "--diff"])
def test_fix_refuses_standard_input(run, option: str) -> None:
    done = run("validate", option, "-", stdin=BEFORE)
    assert done.returncode == 2
    assert f"Invalid value for '{option}'" in done.stderr
    assert "standard input cannot be corrected" in done.stderr
