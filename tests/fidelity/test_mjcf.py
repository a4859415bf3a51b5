"""MJCF files against what ManiSkill's loader gives its builders, to the bit."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from fidelity.mjcf_cases import CASES, COMMON
from fidelity.mjcf_records import assert_same, read
from fidelity.mjcf_strategy import mjcf_files
from hypothesis import given, settings
from plugins.nightly import examples

pytestmark = pytest.mark.maniskill


def _package() -> Path:
    spec = importlib.util.find_spec("mani_skill")
    return Path("mani_skill") if spec is None or spec.origin is None else Path(spec.origin).parent


def shipped() -> list[Path]:
    """Every MJCF of ManiSkill's wheel that holds a world; the others are included by these."""
    files = sorted(_package().rglob("*.xml"))
    return [file for file in files if "<worldbody" in file.read_text(encoding="utf-8")]


@pytest.mark.parametrize("path", shipped(), ids=lambda path: path.stem)
def test_a_file_of_maniskill_is_what_its_loader_builds(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    description = assert_same(path, monkeypatch)
    assert sum(robot.body_type is None for robot in description.robots) == 1


def test_the_wheel_holds_the_files_of_its_control_tasks() -> None:
    assert {file.stem for file in shipped()} == {"ant", "cartpole", "hopper", "humanoid"}


@pytest.fixture
def folder(tmp_path: Path, meshes: dict[str, Path], image: Path) -> Path:
    """A folder with the files that the cases name."""
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "rock.obj").write_bytes(meshes["rock"].read_bytes())
    (tmp_path / "wood.png").write_bytes(image.read_bytes())
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "common.xml").write_text(COMMON)
    return tmp_path


@pytest.mark.parametrize("name", CASES)
def test_a_feature_is_what_maniskills_loader_builds(name: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = folder / "robot.xml"
    path.write_text(CASES[name])
    assert_same(path, monkeypatch)


@settings(max_examples=examples(60))
@given(text=mjcf_files(["none", "quat", "euler x", "axisangle"]))
def test_any_file_that_both_read_alike_is_the_same_to_the_bit(
    text: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("mjcf") / "robot.xml"
    path.write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        assert_same(path, patch)


def _gymnasium() -> list[Path]:
    """The MJCF files of Gymnasium, which ManiSkill brings with it."""
    spec = importlib.util.find_spec("gymnasium")
    folder = None if spec is None or spec.origin is None else Path(spec.origin).parent / "envs" / "mujoco" / "assets"
    return [] if folder is None else sorted(folder.glob("*.xml"))


@pytest.mark.parametrize("path", _gymnasium(), ids=lambda path: path.stem)
def test_files_of_gymnasium_are_read_and_are_the_same_where_nothing_else_is_told(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    description, told = read(path)
    assert description is not None, [str(one) for one in told]
    text = path.read_text(encoding="utf-8")
    # The loader asks each body for a name, and knows no free joint but `freejoint`.
    is_read_by_both = 'type="free"' not in text and path.stem != "ant"
    if is_read_by_both and "SC485" not in {one.code for one in told}:
        assert_same(path, monkeypatch)
