"""`[tool.scenecc]`, `--select` and `--ignore`, counts, and the rules of a team's own package."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from cli.running import plain_environment
from plugins.expectations import ROOT

import scenecc
from scenecc.checks.house_rules import Report
from scenecc.cli.settings import SettingsFinder
from scenecc.diagnostics.formats import render
from scenecc.plan import ScenePlan

WARNS = """\
scenecc: 1
entities:
  door: {pose: {rpy: [0, 0, 90]}, mass: 1, shapes: [{type: box, half_size: [0.1, 0.1, 1]}]}
materials: {oak: {physical: {density: 700}}}
"""
RULES = '''\
"""Rules of the Acme lab."""

from scenecc.plan import ScenePlan


def light_bodies(plan: ScenePlan, report) -> None:
    """Bodies are weighed: nothing is below 2 kg."""
    for entity in plan.entities:
        for body in entity.bodies:
            if body.mass is not None and (body.mass.data < 2).any():
                report(f"`{entity.name}` is lighter than 2 kg", body, "mass", hint="weigh it")


def broken(plan: ScenePlan, report) -> None:
    1 / 0
'''


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "scenes" / "warns.yaml"
    path.parent.mkdir()
    path.write_text(WARNS)
    return path


@pytest.fixture
def acme(tmp_path: Path) -> str:
    """A folder for PYTHONPATH in which a package with rules is installed."""
    site = tmp_path / "site"
    info = site / "acme_rules-1.0.dist-info"
    info.mkdir(parents=True)
    (site / "acme_rules.py").write_text(RULES)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme-rules\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[scenecc.rules]\nACM001 = acme_rules:light_bodies\nACM002 = acme_rules:broken\n"
    )
    return str(site)


def fresh(folder: Path, site: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own, which finds the package."""
    command = [sys.executable, "-m", "scenecc", *arguments]
    environment = plain_environment(PYTHONPATH=site)
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


def settings(scene: Path, text: str) -> None:
    (scene.parent / "pyproject.toml").write_text(f"[tool.scenecc]\n{text}\n")


def codes(run, *arguments: str, **environment: str) -> list[str]:
    done = run("validate", "--format", "json", "scenes", *arguments, **environment)
    return sorted(found["code"] for found in json.loads(done.stdout)["diagnostics"])


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ([], ["SC313", "SC526"]),
        (["--ignore", "SC5"], ["SC313"]),
        (["--ignore", "SC5,SC313"], []),
        (["--select", "SC3"], ["SC313"]),
        (["--select", "SC3", "--ignore", "SC313"], []),
        (["--ignore", "SC", "--select", "SC526"], ["SC526"]),
    ],
)
def test_the_longest_prefix_of_select_and_ignore_counts(run, scene: Path, arguments: list[str], expected) -> None:
    assert codes(run, *arguments) == expected


@pytest.mark.parametrize(
    "arguments", [["--ignore", "SC101"], ["--ignore", "SC77"], ["--select", "rpy"], ["--select", ""]]
)
def test_unknown_codes_and_errors_cannot_be_ignored(run, scene: Path, arguments: list[str]) -> None:
    assert run("validate", "scenes", *arguments).returncode == 2


@pytest.mark.parametrize(
    ("text", "expected", "status"),
    [
        ('ignore = ["SC313"]', ["SC526"], 0),
        ('select = ["SC313"]', ["SC313"], 0),
        ("strict = true", ["SC313", "SC526"], 1),
        ('severity = {SC526 = "error"}\nignore = ["SC313"]', ["SC526"], 1),
        ('strict = true\nseverity = {SC = "note"}', ["SC313", "SC526"], 0),
        ('per-file-ignores = {"warns.*" = ["SC"]}', [], 0),
        ('per-file-ignores = {"other/*" = ["SC"]}', ["SC313", "SC526"], 0),
    ],
)
def test_the_nearest_pyproject_counts(run, scene: Path, text: str, expected: list[str], status: int) -> None:
    settings(scene, text)
    (scene.parents[1] / "pyproject.toml").write_text('[tool.scenecc]\nignore = ["SC"]\n')
    assert codes(run) == expected
    assert run("validate", "scenes").returncode == status


def test_errors_are_never_ignored(run, scene: Path) -> None:
    scene.write_text(WARNS.replace("mass", "mas"))
    settings(scene, 'ignore = ["SC"]\nper-file-ignores = {"*" = ["SC1"]}')
    assert codes(run) == ["SC101"]


def test_options_override_pyproject(run, scene: Path) -> None:
    settings(scene, 'ignore = ["SC313"]')
    assert codes(run, "--ignore", "SC526") == []
    assert codes(run, "--select", "SC313") == ["SC313"]


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('selct = ["SC4"]', 2, "unknown key `selct`"),
        ('strict = false\nignore = ["SC313",\n  "SC999"]', 4, "unknown code `SC999`"),
        ('ignore = ["SC101"]', 2, "SC101 is an error"),
        ('strict = "yes"', 2, "`strict` must be true or false"),
        ('select = "SC4"', 2, "`select` must be a list of strings"),
        ('[tool.scenecc.severity]\nSC526 = "fatal"', 3, "the severity of SC526 must be"),
        ('[tool.scenecc.per-file-ignores]\n"*" = ["SC0000"]', 3, "unknown code `SC0000`"),
        ('rules = ["XYZ001"]', 2, "no installed package has a rule `XYZ001`"),
        ("ignore = = 1", 2, "this is not TOML"),
    ],
)
def test_an_error_in_pyproject_is_reported_at_its_line(run, scene: Path, text: str, line: int, message: str) -> None:
    settings(scene, text)
    done = run("validate", "--format", "json", "scenes")
    (found,) = [one for one in json.loads(done.stdout)["diagnostics"] if one["code"] == "SC916"]
    assert done.returncode == 2
    assert message in found["message"]
    assert (found["file"], found["line"]) == ("scenes/pyproject.toml", line)


def test_findings_of_a_house_rule_are_reported(tmp_path: Path, scene: Path, acme: str) -> None:
    assert "ACM001" not in fresh(tmp_path, acme, "validate", "scenes").stdout  # installed, and not named
    settings(scene, 'rules = ["ACM001"]\nignore = ["SC"]')
    done = fresh(tmp_path, acme, "validate", "--format", "json", "scenes")
    (found,) = json.loads(done.stdout)["diagnostics"]
    assert (found["code"], found["severity"], found["line"], found["column"]) == ("ACM001", "warning", 3, 35)
    assert (found["message"], found["hint"]) == ("`door` is lighter than 2 kg", "weigh it")
    assert fresh(tmp_path, acme, "validate", "--strict", "scenes").returncode == 1
    assert "ACM001" in fresh(tmp_path, acme, "check", "--settle", "0", "scenes").stdout
    scene.write_text(WARNS.replace("]}\nmat", "]}  # scenecc: ignore ACM001 -- a toy\nmat"))
    assert fresh(tmp_path, acme, "validate", "--strict", "scenes").returncode == 0


def test_a_failing_house_rule_is_reported(tmp_path: Path, scene: Path, acme: str) -> None:
    settings(scene, 'rules = ["ACM"]')
    done = fresh(tmp_path, acme, "validate", "scenes")
    assert done.returncode == 2
    assert "SC917: the rule ACM002 failed: ZeroDivisionError" in done.stdout


@pytest.mark.parametrize("form", ["text", "json", "github", "gitlab", "junit", "sarif"])
def test_house_rules_work_in_the_api_and_every_format(form: str, scene: Path) -> None:
    def rule(plan: ScenePlan, report: Report) -> None:
        report("no lights", hint="add one")

    found = scenecc.validate(scene, rules={"ACM007": rule})
    assert [one.code for one in found if not one.code.startswith("SC")] == ["ACM007"]
    assert "ACM007" in render(found, form)


def test_statistics_count_the_most_frequent_first(run, scene: Path) -> None:
    (scene.parent / "more.yaml").write_text(WARNS.replace("door", "gate").partition("materials")[0])
    done = run("validate", "--statistics", "scenes")
    assert done.stdout.splitlines() == [
        "2  SC526  warning  angle in the wrong unit",
        "1  SC313  warning  unused material",
    ]
    rows = json.loads(run("validate", "--statistics", "--format", "json", "scenes").stdout)["statistics"]
    assert [(row["code"], row["count"]) for row in rows] == [("SC526", 2), ("SC313", 1)]
    assert run("validate", "--statistics", "--format", "sarif", "scenes").returncode == 2


@pytest.mark.maniskill
def test_our_own_settings_silence_warnings_of_a_maniskill_scene() -> None:
    finder = SettingsFinder(None, (), strict=True)
    for file in map(str, sorted((ROOT / "scenes" / "maniskill").glob("TriFinger*.yaml"))[:1]):
        assert any(one.severity == "warning" for one in scenecc.validate(file))
        found = finder.of(file).apply(scenecc.validate(file), file)
        assert [str(one) for one in found if one.severity != "note"] == []
    assert finder.faults == []
