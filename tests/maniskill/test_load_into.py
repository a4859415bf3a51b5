"""What is refused when a scene is loaded into an environment, and at which line."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from plugins.maniskill_scenes import new_scene
from plugins.mesh_files import POINTS, TETRA, ply

import scenecc
from scenecc import SceneError
from scenecc.maniskill import load_into

pytestmark = pytest.mark.quick

SCENE = """\
scenecc: 1
entities:
  cube: {shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]}
"""


def refused(text: str, tmp_path: Path, num_envs: int = 1, loads: int = 1) -> list[tuple[str, int | None, str]]:
    file = tmp_path / "scene.yaml"
    file.write_text(text)
    scene = new_scene(num_envs)
    for _ in range(loads - 1):
        load_into(scene, file)
    before = [len(each.entities) for each in scene.sub_scenes]
    with pytest.raises(SceneError) as caught:
        load_into(scene, file)
    assert [len(each.entities) for each in scene.sub_scenes] == before
    return [(d.code, d.location.line, d.message) for d in caught.value.diagnostics]


def test_a_name_that_the_environment_has_is_refused(tmp_path: Path) -> None:
    found = refused(SCENE, tmp_path, loads=2)
    assert found == [("SC809", 3, "the environment already has an object 'cube'")]


def test_a_robot_with_the_name_of_the_agents_robot_is_refused() -> None:
    """As in a task with `robot_uids="panda"`, whose file brings a `panda`."""
    robot = {"root": {"name": "base", "shapes": [{"type": "sphere", "radius": 0.1}]}}
    document = {"scenecc": 1, "entities": {"panda": robot}}
    scene = new_scene()
    load_into(scene, document)
    with pytest.raises(SceneError) as caught:
        load_into(scene, document)
    (told,) = caught.value.diagnostics
    assert (told.code, told.message) == ("SC809", "the environment already has an object 'panda'")
    assert told.hint is not None
    assert "derive the task from the class that `register_env` returns" in told.hint


@pytest.mark.parametrize(
    ("key", "path", "told"),
    [
        ("timestep: 0.005", "timestep", "0.005, but the environment has 0.01"),
        ("gravity: [0, 0, -1.62]", "gravity", "[0.0, 0.0, -1.62], but the environment has [0.0, 0.0, -9.81]"),
        ("enable_ccd: true", "enable_ccd", "true, but the environment has false"),
        ("contact_offset: 0.03", "contact_offset", "0.03, but the environment has 0.02"),
        ("sleep_threshold: 0.1", "sleep_threshold", "0.1, but the environment has 0.005"),
        ("cpu_workers: 2", "cpu_workers", "2, but the environment has 0"),
        ("scene_spacing: 7", "scene_spacing", "7.0, but the environment has 5"),
        (
            "gpu_memory: {heap_capacity: 1048576}",
            "gpu_memory.heap_capacity",
            "1048576, but the environment has 67108864",
        ),
        (
            "default_material: {static_friction: 1, dynamic_friction: 0.3, restitution: 0}",
            "default_material.static_friction",
            "1.0, but the environment has 0.3",
        ),
    ],
)
def test_settings_that_contradict_the_environment_are_reported(key: str, path: str, told: str, tmp_path: Path) -> None:
    assert refused(f"{SCENE}physics:\n  {key}\n", tmp_path) == [("SC810", 5, f"`{path}` is {told}")]


def test_settings_that_equal_those_of_the_environment_are_accepted(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(f"{SCENE}physics: {{timestep: 0.01, contact_offset: 0.02, solver_position_iterations: 15}}\n")
    assert list(load_into(new_scene(), file).actors) == ["cube"]


def test_arguments_that_the_environment_determines_are_refused() -> None:
    with pytest.raises(ValueError, match="cannot be combined with scene"):
        scenecc.load_scene({"scenecc": 1}, scene=new_scene(), num_scenes=3)  # pyright: ignore[reportCallIssue]


def test_an_environment_reports_a_mesh_that_cannot_be_cooked(tmp_path: Path) -> None:
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    text = "scenecc: 1\nentities:\n  a:\n    collisions:\n      - {type: convex_mesh, file: flat.obj}\n"
    found = refused(text, tmp_path)
    assert [line for _, line, _ in found] == [5]


@pytest.mark.parametrize(
    ("content", "code"), [(ply(POINTS * [0.003, 0.003, 3]), "SC423"), ((TETRA + "p 9\n").encode(), "SC801")]
)
def test_an_environment_reports_a_mesh_that_sapien_misreads_or_refuses(
    content: bytes, code: str, tmp_path: Path
) -> None:
    name = "a.ply" if code == "SC423" else "a.obj"
    (tmp_path / name).write_bytes(content)
    text = f"scenecc: 1\nentities:\n  a:\n    collisions:\n      - type: convex_mesh\n        file: {name}\n"
    ((found, line, message),) = refused(text, tmp_path)
    assert (found, line) == (code, 6)
    assert name in message


def test_without_maniskill_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = new_scene()
    monkeypatch.setitem(sys.modules, "mani_skill", None)
    with pytest.raises(SceneError, match=r"pip install .*\[maniskill\]") as caught:
        load_into(scene, {"scenecc": 1})
    assert [d.code for d in caught.value.diagnostics] == ["SC805"]


@pytest.mark.parametrize("installed", ["3.0.0", "3.0.0b21", "4.0.0a1", "4.1", "unknown"])
def test_a_version_of_maniskill_that_is_not_tested_is_refused(installed: str) -> None:
    from scenecc.backends.maniskill import compat

    with pytest.raises(ImportError, match=r"3\.0\.1 to 3\.x, and .* is installed: pip install"):
        compat.check_version(installed)


@pytest.mark.parametrize("installed", ["3.0.1", "3.0.1.post2", "3.1.0"])
def test_a_version_of_maniskill_that_is_tested_is_taken(installed: str) -> None:
    from scenecc.backends.maniskill import compat

    compat.check_version(installed)
