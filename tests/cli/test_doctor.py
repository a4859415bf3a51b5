"""`scenecc doctor`, and how extras are installed."""

from __future__ import annotations

import json
import re
from importlib.metadata import metadata
from pathlib import Path

import pytest

from scenecc import extras
from scenecc.extras import EXTRAS, Extra, install_hint


def test_doctor_lists_present_and_missing_items(run, tmp_path: Path) -> None:
    done = run("doctor", "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    checks = {check["name"]: check for check in json.loads(done.stdout)["checks"]}
    assert {"scenecc", "packages", "pictures", "GPU", *(f"[{name}]" for name in EXTRAS)} <= {*checks}
    for check in checks.values():
        assert check["state"] == ("ok" if check["hint"] is None else "missing")
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


def test_the_install_hint_fits_a_clone_or_an_index(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "scenecc").mkdir()
    monkeypatch.setattr(extras, "__file__", str(tmp_path / "scenecc/extras.py"))
    assert install_hint("mjcf") == 'run `pip install "scenecc[mjcf]"`'
    (tmp_path / "pyproject.toml").touch()
    (tmp_path / ".git").mkdir()
    assert install_hint("mjcf") == "run `pip install -e '.[mjcf]'` in the clone"
    assert install_hint("maniskill", "torch") == "run `pip install torch -e '.[maniskill]'` in the clone"
