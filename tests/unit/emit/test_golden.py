"""What is emitted for known plans, in tests/golden. SCENECC_UPDATE_GOLDEN=1 writes it anew; read the diff."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from plugins.sample_plans import ROOT, SAMPLES

from scenecc.diagnostics import Sink
from scenecc.emit import emit
from scenecc.emit.python.source import WIDTH
from scenecc.plan.json_codec import plan_from_json

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

GOLDEN = ROOT / "tests" / "golden"
SUFFIXES = {"json": ".json", "python": ".py"}
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))
UPDATE = bool(os.environ.get("SCENECC_UPDATE_GOLDEN"))


def plan_of(name: str) -> ScenePlan:
    if name in SAMPLES:
        return SAMPLES[name]()
    from scenecc import compile_scene

    return compile_scene(ROOT / "scenes" / f"{name.removeprefix('scene_')}.yaml")


NAMES = [*SAMPLES, *(f"scene_{path.stem}" for path in SCENES)]


REVIEWED = {
    "json": ("drawn", "knobs", "scene_robot_door"),
    "python": (
        *("decomposed", "drawn", "fastened", "links"),
        *("scene_knobs", "scene_prefabs", "scene_robot_arm"),
    ),
}
"""Plans whose texts are kept: between them they lead through every branch of both writers, but for a few that only fill
a line. Of all others tests hold what matters: what is built is the same, the text is formatted, JSON is read again."""


@pytest.mark.parametrize(("name", "target"), [(name, target) for target in REVIEWED for name in REVIEWED[target]])
def test_emitted_files_equal_the_golden_files(name: str, target: str) -> None:
    text = emitted(name, target)
    file = GOLDEN / f"{name}{SUFFIXES[target]}"
    if UPDATE:
        file.write_text(text, encoding="utf-8")
    assert_same(text, file.read_text(encoding="utf-8"))


def emitted(name: str, target: str) -> str:
    sink = Sink()
    text = emit(plan_of(name), target, sink, base=GOLDEN)
    assert text is not None, sink.diagnostics()
    return text


def assert_same(text: str, golden: str) -> None:
    """To the byte, but for the last bits of numbers: a logarithm or a sine is not the same on every processor."""
    if text != golden:
        for line, expected in zip(words_of(text), words_of(golden), strict=True):
            assert line == expected


def words_of(text: str) -> list[object]:
    """Words, signs, and numbers as near as they are compared; line breaks and the commas ahead of them say nothing."""
    text = re.sub(r"packed_file\(\n.*?\n\)", "", text, flags=re.DOTALL)  # compression is not the same everywhere
    found = re.findall(r"-?\d+\.\d+(?:e[-+]?\d+)?|\w+|[^\w\s]", re.sub(r",?\s+", " ", text).replace(",]", "]"))
    return [pytest.approx(float(word), rel=1e-12, abs=1e-15) if "." in word[1:] else word for word in found]


def test_every_golden_file_has_a_test() -> None:
    kept = {file.name for file in GOLDEN.iterdir() if file.suffix in SUFFIXES.values()}
    assert kept == {f"{name}{SUFFIXES[target]}" for target, names in REVIEWED.items() for name in names}


def found_at(uri: str) -> Path:
    return ROOT / uri.removeprefix("pkg://") if uri.startswith("pkg://scenecc/") else GOLDEN / uri


@pytest.mark.parametrize("name", NAMES)
def test_an_emitted_json_plan_can_be_read_again(name: str) -> None:
    sink = Sink()
    text = emitted(name, "json")
    found = plan_from_json(text, base=GOLDEN, sink=sink, resolve=lambda uri, _: found_at(uri))
    assert found is not None, sink.diagnostics()
    assert emit(found, "json", sink) == text
    assert [file.path.resolve() for file in found.files] == [file.path.resolve() for file in plan_of(name).files]


@pytest.mark.parametrize(
    "arguments", [["format", "--check"], ["check", "--select", "E,F,I,W"]], ids=["format", "check"]
)
def test_golden_scripts_are_formatted_and_clean(arguments: list[str], tmp_path: Path) -> None:
    pytest.importorskip("ruff")
    files = [tmp_path / f"{name}.py" for name in NAMES]
    for file in files:
        file.write_text(emitted(file.stem, "python"), encoding="utf-8")
    command = [sys.executable, "-m", "ruff", *arguments, "--isolated", "--line-length", str(WIDTH), *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 0, done.stdout
