from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from scenecc.cli import output
from scenecc.cli.output import folder_refusal, refusal, write_files, write_output


def test_a_file_is_written_completely_with_default_permissions(tmp_path: Path) -> None:
    target = tmp_path / "plan.json"
    assert write_output(str(target), "{}\n") is None
    other = tmp_path / "other"
    other.touch()
    assert target.read_text() == "{}\n"
    assert target.stat().st_mode == other.stat().st_mode


def test_a_failed_write_leaves_only_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "plan.json"
    target.write_text("old")

    def full(descriptor: int) -> None:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr(output.os, "fsync", full)
    reason = write_output(str(target), "new")
    assert reason is not None
    assert reason[0] == "SC818"
    assert "No space left" in reason[1]
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]
    assert target.read_text() == "old"


def test_an_interrupted_write_leaves_only_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "plan.json"
    target.write_text("old")

    def interrupted(descriptor: int) -> None:
        raise SystemExit(130)

    monkeypatch.setattr(output.os, "fsync", interrupted)
    with pytest.raises(SystemExit):
        write_output(str(target), "new")
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]
    assert target.read_text() == "old"


def test_an_overwritten_file_keeps_its_permissions(tmp_path: Path) -> None:
    target = tmp_path / "plan.json"
    target.write_text("old")
    target.chmod(0o640)
    write_output(str(target), "new")
    assert stat.S_IMODE(target.stat().st_mode) == 0o640


def test_writing_to_a_link_changes_its_target(tmp_path: Path) -> None:
    target, link = tmp_path / "plan.json", tmp_path / "link"
    target.write_text("old")
    link.symlink_to(target)
    assert write_output(str(link), "new") is None
    assert link.is_symlink()
    assert target.read_text() == "new"


def test_output_can_go_to_a_device(tmp_path: Path) -> None:
    assert write_output("/dev/null", "text") is None
    reason = write_output("/dev/full", "text")
    assert reason is not None
    assert reason[0] == "SC818"
    assert "No space left" in reason[1]
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


def test_a_folder_and_a_missing_folder_are_refused_as_output(tmp_path: Path) -> None:
    assert refusal(str(tmp_path)) == f"`{tmp_path}` is a folder"
    assert refusal(str(tmp_path / "no" / "plan.json")) == f"there is no folder `{tmp_path / 'no'}`"
    assert refusal(str(tmp_path / "plan.json")) is None
    assert refusal("-") is None


def test_refused_targets_are_not_written_either(tmp_path: Path) -> None:
    assert write_output(str(tmp_path), "text") is not None
    assert write_output(str(tmp_path / "no" / "plan.json"), "text") is not None
    assert list(tmp_path.iterdir()) == []


def test_a_scene_is_not_written_over_itself(tmp_path: Path) -> None:
    from scenecc.cli.paths import path_faults

    scene = tmp_path / "scene.yaml"
    scene.write_text("scenecc: 1\n", encoding="utf-8")
    (tmp_path / "link.yaml").symlink_to(scene)
    for name in ("scene.yaml", "link.yaml"):
        (fault,) = path_faults(str(scene), str(tmp_path / name))
        assert fault.code == "SC904"
    assert path_faults(str(scene), str(tmp_path / "plan.json")) == []


def test_several_files_are_written_all_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "scene.xml"
    files = {"any.xml": b"main", "scene.assets/a.obj": b"a", "scene.assets/b.obj": b"b"}
    assert write_files(str(target), files, folder=False) is None
    assert target.read_bytes() == b"main"
    assert sorted(path.name for path in (tmp_path / "scene.assets").iterdir()) == ["a.obj", "b.obj"]

    sound = os.fsync
    left = [2]

    def full(descriptor: int) -> None:
        left[0] -= 1
        if left[0] == 0:
            raise OSError(28, os.strerror(28))
        sound(descriptor)

    monkeypatch.setattr(output.os, "fsync", full)
    reason = write_files(str(target), {"any.xml": b"new", "other.assets/c.obj": b"c"}, folder=False)
    assert reason is not None
    assert reason[0] == "SC818"
    assert "No space left" in reason[1]
    assert target.read_bytes() == b"main"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scene.assets", "scene.xml"]


@pytest.mark.parametrize("failing", range(1, 7))
def test_old_files_are_restored_after_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failing: int) -> None:
    """Two files are put aside, and four take their places: each of these renamings fails once."""
    names = ["scene.xml", "a.obj", "b.obj", "new.obj"]
    old = {name: f"old {name}".encode() for name in names[:3]}
    for name, content in old.items():
        (tmp_path / name).write_bytes(content)
    sound, left = Path.replace, [failing]

    def failing_once(source: Path, target: Path) -> None:
        left[0] -= 1
        if left[0] == 0:
            raise OSError(5, os.strerror(5))
        sound(source, target)

    monkeypatch.setattr(Path, "replace", failing_once)
    reason = write_files(str(tmp_path / "scene.xml"), dict.fromkeys(names, b"new"), folder=False)
    assert reason is not None
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == old


def test_a_folder_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    (tmp_path / "a.obj").mkdir()
    reason = write_files(str(tmp_path / "scene.xml"), {"scene.xml": b"new", "a.obj": b"new"}, folder=False)
    assert reason == ("SC904", f"`{tmp_path / 'a.obj'}` cannot be written: Is a directory")
    assert [path.name for path in tmp_path.iterdir()] == ["a.obj"]


def test_writing_works_without_unnamed_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.files.os.O_TMPFILE", os.O_DIRECTORY)  # a folder cannot be opened to be written
    assert write_output(str(tmp_path / "plan.json"), "new") is None
    assert [path.name for path in tmp_path.iterdir()] == ["plan.json"]
    assert (tmp_path / "plan.json").read_text() == "new"


_INTERRUPTED = """
import os, signal, sys
from pathlib import Path
from scenecc import files
from scenecc.interrupt import end_at_signals

end_at_signals()
step, number = sys.argv[1], int(sys.argv[2])
owner = Path if step == "replace" else os  # Python 3.10 keeps os.replace in pathlib by itself
sound, left = getattr(owner, step), [2]

def struck(*given, **named):
    left[0] -= 1
    if left[0] == 0:
        os.kill(os.getpid(), number)
    return sound(*given, **named)

setattr(owner, step, struck)
files.replace_all({Path(name): b"new" for name in ("scene.xml", "a.obj", "new/b.obj")}, [Path("new")])
print("not ended")
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
@pytest.mark.parametrize(("step", "content"), [("fsync", "old"), ("link", "old"), ("replace", "new")])
def test_a_signal_during_a_write_leaves_all_files_or_none(
    tmp_path: Path, step: str, content: str, number: signal.Signals
) -> None:
    for name in ("scene.xml", "a.obj"):
        (tmp_path / name).write_text("old")
    done = subprocess.run(
        [sys.executable, "-c", _INTERRUPTED, step, str(int(number))],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (done.returncode, done.stdout, done.stderr) == (128 + number, "", "")
    expected = dict.fromkeys(["a.obj", "scene.xml"] + ["new/b.obj"] * (content == "new"), content)
    found = {str(path.relative_to(tmp_path)): path.read_text() for path in tmp_path.rglob("*") if path.is_file()}
    assert found == expected
    assert (tmp_path / "new").exists() == (content == "new")


def test_files_are_written_to_a_new_or_empty_folder(tmp_path: Path) -> None:
    target = tmp_path / "robots"
    assert folder_refusal(str(target)) is None
    assert write_files(str(target), {"arm.urdf": b"arm", "arm.assets/a.obj": b"a"}, folder=True) is None
    assert (target / "arm.urdf").read_bytes() == b"arm"
    assert (target / "arm.assets/a.obj").read_bytes() == b"a"
    assert folder_refusal(str(target)) == f"the folder `{target}` is not empty"
    assert folder_refusal(str(target / "arm.urdf")) == f"`{target / 'arm.urdf'}` is a file"
    assert folder_refusal(str(tmp_path / "no" / "robots")) == f"there is no folder `{tmp_path / 'no'}`"


def test_standard_output_can_hold_only_one_file() -> None:
    reason = write_files("-", {"a": b"", "b": b""}, folder=False)
    assert reason == ("SC904", "standard output can hold only one file, but there are 2")


def test_bytes_are_written_unchanged(tmp_path: Path, capfdbinary: pytest.CaptureFixture[bytes]) -> None:
    assert write_output(str(tmp_path / "a.glb"), b"\x00\xff\r\n") is None
    assert (tmp_path / "a.glb").read_bytes() == b"\x00\xff\r\n"
    assert write_output("-", b"\x00\xff\r\n") is None
    assert capfdbinary.readouterr().out == b"\x00\xff\r\n"
