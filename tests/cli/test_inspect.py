"""`scenecc inspect`: the tree that people read, the same for programs, and what is refused."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import sys
import termios
from hashlib import sha256
from pathlib import Path

import pytest
from cli.running import CUBE, plain_environment

SCENE = """\
scenecc: 1
name: desk
num_scenes: 3
include: [parts.yaml]
params:
  edge: {type: number, default: 0.1, min: 0, description: "of the cube [m]"}
materials:
  steel: {physical: {static_friction: 0.5, dynamic_friction: 0.4, restitution: 0.1}, visual: {base_color: "#102030"}}
entities:
  cube:
    pose: [{uniform: [-1, 1]}, 0, 0.5]
    mass: {choice: [1, 2]}
    shapes: [{type: box, half_size: "${edge}", material: steel}]
  rod:
    scene_idxs: [0, 2]
    pose: {p: [0, 0, 2], rpy_deg: [0, 0, 90]}
    shapes: [{type: capsule, radius: 0.01, half_length: 0.1, density: 500}]
  marker:
    body_type: none
    visuals: [{type: sphere, radius: 0.02, color: "#00ff00"}]
"""
PARTS = "scenecc: 1\nentities: {ground: {body_type: static, shapes: [{type: plane}]}}\n"

TREE = """\
desk  scene  scenes 3 · seed 0
├── physics  SAPIEN's defaults
├── parameters (1)
│   └── edge  number  default 0.1 · range at least 0 · of the cube [m]
├── entities (4)
│   ├── ground  static  at [0, 0, 0] m · size 20 × 20 × 0 m
│   │   └── shapes[0]  plane  collides, seen · turned 90° about -y · half_size [10, 10] m
│   ├── cube  dynamic  at [-1 … 1, 0, 0.5] m · mass 1 | 2 kg · size 0.2 × 0.2 × 0.2 m
│   │   └── shapes[0]  box  collides, seen · half_size [0.1, 0.1, 0.1] m · static_friction 0.5 · \
dynamic_friction 0.4 · restitution 0.1 · base_color #102030
│   ├── rod  dynamic  scenes 0, 2 of 3 · at [0, 0, 2] m · turned 90° about z · mass 0.03351 kg · \
size 0.22 × 0.02 × 0.02 m
│   │   └── shapes[0]  capsule  collides, seen · radius 0.01 m · half_length 0.1 m · density 500 kg/m³
│   └── marker  none  at [0, 0, 0] m · size 0.04 × 0.04 × 0.04 m
│       └── visuals[0]  sphere  seen · radius 0.02 m · base_color #00ff00
├── materials (3)
│   ├── physical  0 · static_friction 0.5 · dynamic_friction 0.4 · restitution 0.1 · used_by cube
│   ├── visual  0 · base_color #102030 · used_by cube
│   └── visual  1 · base_color #00ff00 · used_by marker
├── variation (1)
│   └── cube  at [-1 … 1, 0, 0.5] at reset · mass 1 | 2 at reset
└── files (2)
    ├── scene.yaml  scene  {scene} B · sha256 {scene_hash}
    └── parts.yaml  include  {parts} B · sha256 {parts_hash} · named_by scene.yaml
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    (tmp_path / "parts.yaml").write_text(PARTS)
    (tmp_path / "scene.yaml").write_text(SCENE.replace('"${edge}"', '["${edge}", "${edge}", "${edge}"]'))
    return tmp_path / "scene.yaml"


def test_inspect_prints_a_tree(run, scene: Path) -> None:
    done = run("inspect", "scene.yaml")
    parts = scene.with_name("parts.yaml")
    told = TREE
    for name, path in (("scene", scene), ("parts", parts)):
        size = path.stat().st_size
        told = told.replace(f"{{{name}}} B", f"{size} B" if size < 1000 else f"{size / 1000:.4g} kB")
        told = told.replace(f"{{{name}_hash}}", sha256(path.read_bytes()).hexdigest()[:16])
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == told


def test_inspect_prints_the_tree_as_json(run, scene: Path) -> None:
    found = json.loads(run("inspect", "scene.yaml", "--format", "json").stdout)
    assert list(found) == [
        *("name", "type", "num_scenes", "seed", "physics", "parameters", "entities", "materials", "variation", "files"),
        "diagnostics",
    ]
    cube = found["entities"][1]
    assert cube["mass"] == {"alternatives": [1.0, 2.0], "at_reset": True}
    assert cube["pose.p"] == {"low": [-1.0, 0.0, 0.5], "high": [1.0, 0.0, 0.5], "at_reset": True}
    assert cube["shapes"][0]["roles"] == ["collides", "seen"]
    assert cube["shapes"][0]["physical_material"] == 0
    assert found["entities"][2]["scene_idxs"] == [0, 2]
    assert found["parameters"] == [
        {
            "name": "edge",
            "type": "number",
            "default": 0.1,
            "min": 0,
            "range": "at least 0",
            "description": "of the cube [m]",
        }
    ]
    file = found["files"][0]
    assert (file["path"], file["type"]) == (str(scene), "scene")
    assert file["sha256"] == sha256(scene.read_bytes()).hexdigest()


def test_inspect_shows_the_values_of_one_scene(run, scene: Path) -> None:
    whole = json.loads(run("inspect", "scene.yaml", "--format", "json", "--scene", 1).stdout)
    assert whole["scene"] == 1
    assert [one["name"] for one in whole["entities"]] == ["ground", "cube", "marker"]
    plan = json.loads(run("emit", "scene.yaml", "--to", "json").stdout)
    (cube,) = (one for one in plan["entities"] if one["name"] == "cube")
    assert whole["entities"][1]["pose.p"] == cube["pose"]["per_scene"][1][:3]
    assert whole["entities"][1]["mass"] in (1.0, 2.0)


def test_inspect_shows_only_selected_entities(run, scene: Path) -> None:
    assert run("inspect", "scene.yaml", "--entity", "r*", "--depth", "1").stdout == (
        "desk  scene  scenes 3\n"
        "└── entities (1)\n"
        "    └── rod  dynamic  scenes 0, 2 of 3 · at [0, 0, 2] m · turned 90° about z · mass 0.03351 kg · "
        "size 0.22 × 0.02 × 0.02 m  … 1 more below\n"
    )


def test_without_the_engine_only_written_masses_are_shown(run, scene: Path) -> None:
    found = json.loads(run("inspect", "scene.yaml", "--no-build", "--format", "json").stdout)
    masses = {one["name"]: one.get("mass") for one in found["entities"]}
    assert masses == {
        "ground": None,
        "cube": {"alternatives": [1.0, 2.0], "at_reset": True},
        "rod": None,
        "marker": None,
    }


def test_inspect_reads_a_plan_and_standard_input(run, scene: Path) -> None:
    run("emit", "scene.yaml", "--to", "json", "-o", "plan.json")
    done = run("inspect", "plan.json")
    assert (done.returncode, done.stderr) == (0, "")
    assert "mass 0.03351 kg" in done.stdout
    assert "plan.json  scene" in done.stdout
    assert "parameters" not in done.stdout
    done = run("inspect", "-", stdin=CUBE)
    assert done.returncode == 0
    assert "cube  dynamic" in done.stdout
    assert "files" not in done.stdout


@pytest.mark.parametrize(
    ("arguments", "code", "status"),
    [
        (("scene.yaml", "--entity", "cuba"), "SC910", 2),
        (("scene.yaml", "--entity", "rod", "--scene", "1"), "SC910", 2),
        (("scene.yaml", "--scene", "3"), "SC908", 2),
        (("nosuch.yaml",), "SC901", 2),
        ((".",), "SC901", 2),
        (("parts.yaml", "--set", "n=1"), "SC", 2),
        (("broken.yaml",), "SC101", 1),
    ],
)
def test_inspect_reports_a_missing_scene_or_entity(
    run, scene: Path, arguments: tuple[str, ...], code: str, status: int
) -> None:
    scene.with_name("broken.yaml").write_text(CUBE.replace("half_size", "half_sizes"))
    done = run("inspect", *arguments)
    assert (done.returncode, done.stdout) == (status, "")
    assert code in done.stderr


def test_inspect_suggests_a_similar_entity_name(run, scene: Path) -> None:
    assert "did you mean `cube`?" in run("inspect", "scene.yaml", "--entity", "cuba").stderr


def test_inspect_escapes_names(run, tmp_path: Path) -> None:
    text = 'scenecc: 1\nname: "[red]\\e[2J"\ndescription: "\\e]0;x\\a::error::y"\nentities:\n'
    text += '  cube: {shapes: [{type: box, half_size: [1, 1, 1], name: "\\e[31m[bold]:smile:\\u202E"}]}\n'
    (tmp_path / "scene.yaml").write_text(text)
    done = run("inspect", "scene.yaml", FORCE_COLOR="1")
    assert (done.returncode, done.stderr) == (0, "")
    assert "\u202e" not in done.stdout
    assert set(re.findall(r"\x1b(?:\[[0-9;]*m|.)", done.stdout)) <= {
        *("\x1b[0m", "\x1b[1m", "\x1b[2m", "\x1b[36m"),
    }, "colours of ours alone"
    assert "[red]" in done.stdout
    assert "[bold]:smile:" in done.stdout


def test_inspect_wraps_lines_to_the_terminal(scene: Path) -> None:
    width = 50
    main, other = pty.openpty()
    fcntl.ioctl(other, termios.TIOCSWINSZ, struct.pack("HHHH", 40, width, 0, 0))
    done = subprocess.Popen(
        [sys.executable, "-m", "scenecc", "inspect", "scene.yaml"],
        cwd=scene.parent,
        stdout=other,
        stderr=subprocess.DEVNULL,
        env=plain_environment(),
    )
    os.close(other)
    read = b""
    while True:
        try:
            part = os.read(main, 4096)
        except OSError:  # the other end is closed
            break
        read += part
    assert done.wait(60) == 0
    os.close(main)
    text = read.decode()
    assert "\x1b[1m" in text
    lines = [re.sub(r"\x1b\[[0-9;]*m", "", line).rstrip("\r") for line in text.split("\n")]
    assert max(map(len, lines)) <= width
    assert "".join(re.sub(r"[│├└─\s]", "", line) for line in lines).count("static_friction0.5") == 2
