"""Surroundings in the plan: ambient light, one file or six, what differs between scenes, and what is wrong."""

from __future__ import annotations

import struct
from io import StringIO
from pathlib import Path
from shutil import copyfile
from typing import Any

import pytest

from scenecc import compile_scene, validate
from scenecc.plan import CubeMap, ScenePlan, SkyMap, Value

PICTURE = Path(__file__).parents[2] / "scenes" / "good" / "assets" / "checker.png"
FACES = ("px", "nx", "py", "ny", "pz", "nz")


def plan_of(folder: Path, environment: dict[str, Any], **top: Any) -> ScenePlan:
    # 4 × 2 pixels: a map of all directions is twice as wide as it is high.
    sky = struct.pack("<2sIHHIIiiHHIIiiII", b"BM", 78, 0, 0, 54, 40, 4, 2, 1, 24, 0, 24, 0, 0, 0, 0) + bytes(24)
    for name in ("a", "b"):
        (folder / f"{name}.bmp").write_bytes(sky)
    for name in FACES:
        copyfile(PICTURE, folder / f"{name}.png")
    return compile_scene({"scenecc": 1, "environment": environment, **top}, asset_roots=[folder])


def file(name: str) -> str:
    return f"asset://{name}.png" if name in FACES else f"asset://{name}.bmp"


def names(plan: ScenePlan, value: Value) -> list[str]:
    return [plan.files[index].path.stem for index in value.data.tolist()]


def test_nothing_is_said_of_what_is_left_out(tmp_path: Path) -> None:
    assert compile_scene({"scenecc": 1}).environment is None
    environment = plan_of(tmp_path, {"map": file("a")}).environment
    assert environment is not None
    assert environment.ambient_light is None


def test_ambient_light_differs_from_scene_to_scene(tmp_path: Path) -> None:
    given = {"ambient_light": {"per_scene": [[0.1, 0.2, 0.3], "#ffffff"]}}
    environment = plan_of(tmp_path, given, num_scenes=2).environment
    assert environment is not None
    assert environment.ambient_light is not None
    assert environment.ambient_light.data.tolist() == [[0.1, 0.2, 0.3], [1, 1, 1]]
    assert environment.map is None


def test_one_file_is_a_sky_and_may_differ(tmp_path: Path) -> None:
    plan = plan_of(tmp_path, {"map": {"per_scene": [file("a"), file("b")]}}, num_scenes=2)
    assert plan.environment is not None
    assert isinstance(plan.environment.map, SkyMap)
    assert names(plan, plan.environment.map.file) == ["a", "b"]


def test_six_files_are_a_cube_and_each_may_differ(tmp_path: Path) -> None:
    faces: dict[str, Any] = {face: file(face) for face in FACES}
    faces["ny"] = {"per_scene": [file("px"), file("ny")]}
    plan = plan_of(tmp_path, {"map": faces}, num_scenes=2)
    assert plan.environment is not None
    found = plan.environment.map
    assert isinstance(found, CubeMap)
    assert [names(plan, getattr(found, face)) for face in FACES] == [
        ["px"],
        ["nx"],
        ["py"],
        ["px", "ny"],
        ["pz"],
        ["nz"],
    ]


@pytest.mark.parametrize(
    ("text", "code", "line", "path"),
    [
        ("environment:\n  ambient_light: [1, 2]\n", "SC106", 3, "environment.ambient_light"),
        ("environment:\n  ambient_light: [1, 2, -1]\n", "SC104", 3, "environment.ambient_light[2]"),
        ("environment:\n  map: sky.png\n", "SC401", 3, "environment.map"),
        ("environment:\n  map: {px: a.png}\n", "SC102", 3, "environment.map"),
        (
            "num_scenes: 2\nenvironment:\n  map:\n    choice: [a.png, {px: a, nx: a, py: a, ny: a, pz: a, nz: a}]\n",
            "SC321",
            5,
            "environment.map",
        ),
    ],
)
def test_a_mistake_is_told_at_its_line(text: str, code: str, line: int, path: str) -> None:
    found = [(one.code, one.line, one.path) for one in validate(StringIO("scenecc: 1\n" + text))]
    assert (code, line, path) in found, found
