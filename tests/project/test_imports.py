"""What is loaded, and so paid for, by those who only check a scene."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

HEAVY = ("sapien", "trimesh", "numpy", "coacd", "mani_skill", "jsonschema", "PIL")
"""None of these is needed to check a scene without meshes: an engine, a mesh library, arrays."""

_SECTIONS = {
    "plan": "articulation constraint rendering json_codec",
    "robots": "urdf mujoco",
    "lower": "articulations constraints rendering resets",
    "checks": "joints render_objects",
    "spec": "articulation constraint rendering",
    "expand": "expand",
    "backends": "sapien maniskill",
    "maniskill": "load",
}
NOT_HERE = tuple(f"scenecc.{folder}.{name}" for folder, names in _SECTIONS.items() for name in names.split())
"""Ours, of what `SCENE` has nothing of: robots, constraints, lights, cameras, draws, expansion."""

SCENE = """\
scenecc: 1
num_scenes: 4
materials:
  wood: {physical: {static_friction: 0.6, dynamic_friction: 0.5}, visual: {base_color: [0.6, 0.4, 0.3]}}
entities:
  table:
    body_type: static
    scene_idxs: [0, "2:"]
    shapes:
      - {type: plane}
      - {type: box, half_size: [1, 1, 0.1], material: wood}
  ball:
    scene_idxs: [0, "2:"]
    pose: {p: [0, 0, 1], rpy_deg: [0, 30, 0], relative_to: table}
    mass: 0.5
    linear_velocity: [1, 0, 0]
    shapes:
      - {type: sphere, radius: 0.1, density: 500}
      - {type: capsule, radius: 0.05, half_length: 0.1, axis: z}
"""

BROKEN = SCENE + "      - {type: box, half_size: [1, 1]}\n"


def loaded(code: str, *arguments: str, among: tuple[str, ...] = HEAVY) -> set[str]:
    """Those packages that are loaded once a program has run."""
    report = f"\nimport sys\nprint(*({set(among)!r} & set(sys.modules)))\n"
    ran = subprocess.run([sys.executable, "-c", code + report, *arguments], capture_output=True, text=True, check=True)
    return set(ran.stdout.splitlines()[-1].split()) if ran.stdout.strip() else set()


def test_importing_the_package_loads_nothing_heavy() -> None:
    assert loaded("import scenecc, scenecc.scene, scenecc.cli") == set()


def test_the_help_loads_no_reader() -> None:
    code = "from scenecc.cli.app import application\napplication()"
    assert loaded(code, among=(*HEAVY, "yaml", "pydantic", "scenecc.cli.build")) == {"scenecc.cli.build"}


@pytest.mark.quick
@pytest.mark.parametrize("text", [SCENE, BROKEN], ids=["valid", "broken"])
def test_validating_a_scene_without_meshes_loads_nothing_heavy(tmp_path: Path, text: str) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(text)
    code = "import sys, scenecc\nfound = scenecc.validate(sys.argv[1])\nassert len(found) == int(sys.argv[2]), found"
    assert loaded(code, str(file), "0" if text is SCENE else "1") == set()


@pytest.mark.parametrize("name", NOT_HERE)
def test_what_must_not_be_loaded_is_a_module(name: str) -> None:
    """So that none of these names is one that nothing has."""
    assert find_spec(name) is not None


def test_a_scene_pays_for_nothing_that_it_does_not_have(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    code = "import sys, scenecc\nassert not scenecc.validate(sys.argv[1])"
    assert loaded(code, str(file), among=NOT_HERE) == set()


def test_what_a_scene_has_is_loaded(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE + "cameras: {eye: {width: 4, height: 4, fovy: 1, pose: [0, 0, 1]}}\n")
    code = "import sys, scenecc\nfound = scenecc.validate(sys.argv[1])\nassert not found, found"
    found = loaded(code, str(file), among=NOT_HERE)
    assert found >= {"scenecc.spec.rendering", "scenecc.plan.rendering", "scenecc.lower.rendering"}
    assert not found & {"scenecc.lower.constraints", "scenecc.lower.articulations"}


def test_the_command_that_validates_loads_nothing_heavy(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(SCENE)
    code = (
        "import sys\nfrom scenecc.cli.app import main\nsys.argv = ['scenecc', 'validate', sys.argv[1]]\n"
        "try:\n    main()\nexcept SystemExit as ended:\n    assert not ended.code, ended.code\n"
    )
    assert loaded(code, str(file)) == set()


def test_building_a_scene_does_load_an_engine() -> None:
    """The test itself sees what is loaded."""
    scene = {"scenecc": 1, "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 0.1}]}}}
    code = (
        f"import warnings\nwarnings.simplefilter('ignore')\nimport scenecc\nscenecc.load_scene({scene!r}, render=False)"
    )
    assert loaded(code) >= {"sapien", "numpy"}
