"""`scenecc doctor`, and how extras are installed."""

from __future__ import annotations

import json
import re
from importlib.metadata import metadata
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import typer

from scenecc import extras
from scenecc.cli import doctor
from scenecc.cli.doctor import _assets as assets_check  # pyright: ignore[reportPrivateUsage]
from scenecc.cli.doctor import _cache as cache_check  # pyright: ignore[reportPrivateUsage]
from scenecc.extras import EXTRAS, Extra, install_hint
from scenecc.files import cache_folder


def test_doctor_lists_present_and_missing_items(run, tmp_path: Path) -> None:
    done = run("doctor", "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    checks = {check["name"]: check for check in json.loads(done.stdout)["checks"]}
    assert {"scenecc", "packages", "pictures", "GPU", *(f"[{name}]" for name in EXTRAS)} <= {*checks}
    for check in checks.values():
        assert check["hint"] is not None or check["state"] == "ok"
    assert checks["SAPIEN"]["state"] == "ok"
    assert checks["cache"]["found"].startswith(str(cache_folder("")))
    text = run("doctor").stdout
    for check in checks.values():
        assert check["found"] in text
        assert all(line in text for line in (check["hint"] or "").splitlines())
    assert text.splitlines()[-1].endswith("To start: `scenecc init demo`")


@pytest.mark.render
def test_doctor_names_the_render_device(run) -> None:
    checks = {check["name"]: check for check in json.loads(run("doctor", "--format", "json").stdout)["checks"]}
    assert checks["pictures"]["state"] == "ok"
    assert checks["pictures"]["found"]


def test_doctor_lists_all_extras_of_the_package() -> None:
    ours = set(metadata("scenecc").get_all("Provides-Extra") or ()) - {"all", "dev", "docs", "test"}
    assert set(EXTRAS) == ours


def test_hints_name_existing_extras() -> None:
    files = Path(extras.__file__).parent.rglob("*.py")
    named = {name for file in files for name in re.findall(r'install_hint\("(\w+)"\)', file.read_text())}
    assert named
    assert named <= EXTRAS.keys()


def test_an_extra_without_one_of_its_modules_is_missing() -> None:
    assert Extra("", ("json", "no_such_module_there_is")).missing == ["no_such_module_there_is"]
    assert Extra("", ("json",)).missing == []


def test_doctor_ends_with_status_3_without_sapien(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(doctor, "_ASK_ENGINE", "import no_such_module_there_is")
    with pytest.raises(typer.Exit) as ended:
        doctor.doctor()
    assert ended.value.exit_code == 3
    assert "missing  SAPIEN" in (text := capsys.readouterr().out)
    assert "ModuleNotFoundError: No module named 'no_such_module_there_is'" in text


ORIGINS = [
    ({}, "'scenecc[mjcf]'"),
    ({"url": "file://FOLDER", "dir_info": {}}, "'FOLDER[mjcf]'"),
    ({"url": "file://FOLDER", "dir_info": {"editable": True}}, "-e 'FOLDER[mjcf]'"),
    (
        {"url": "https://a.org/b.git", "vcs_info": {"vcs": "git", "commit_id": "f0", "requested_revision": "v1"}},
        "'scenecc[mjcf] @ git+https://a.org/b.git@v1'",
    ),
    ({"url": "https://a.org/scenecc.whl", "archive_info": {}}, "'scenecc[mjcf] @ https://a.org/scenecc.whl'"),
    ({"url": "file://FOLDER/gone.whl", "archive_info": {}}, "'mujoco>=3.5,<5'"),
]


@pytest.mark.parametrize(("origin", "requirement"), ORIGINS, ids=lambda value: value if isinstance(value, str) else "")
def test_the_install_hint_names_where_scenecc_came_from(
    origin: dict[str, Any], requirement: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    text = json.dumps(origin).replace("FOLDER", str(tmp_path))
    monkeypatch.setattr(extras, "__file__", str(tmp_path / "scenecc/extras.py"))
    monkeypatch.setattr(extras, "distribution", lambda name: SimpleNamespace(read_text=lambda file: text))
    monkeypatch.setattr(extras, "requires", lambda name: ["numpy", "mujoco>=3.5,<5; extra == 'mjcf'"])
    assert install_hint("mjcf") == f"run `pip install {requirement.replace('FOLDER', str(tmp_path))}`"


def test_the_install_hint_in_a_clone_is_editable(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(extras, "__file__", str(tmp_path / "scenecc/extras.py"))
    (tmp_path / "pyproject.toml").touch()
    (tmp_path / ".git").mkdir()
    assert install_hint("maniskill", "torch") == f"run `pip install torch -e '{tmp_path}[maniskill]'`"


def test_without_a_home_and_with_a_cache_that_cannot_be_written_doctor_says_so(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    cache = cache_check()
    assert (cache.state, cache.found) == ("missing", f"{tmp_path / 'file' / 'scenecc'} cannot be written")

    def homeless(_: type[Path]) -> Path:
        raise RuntimeError

    monkeypatch.setattr(Path, "home", classmethod(homeless))
    monkeypatch.setenv("MS_ASSET_DIR", str(tmp_path))
    assert all(str(tmp_path) in one.found for one in assets_check())
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache_check().state == "missing"
