from __future__ import annotations

import ast
import json
import os
from pathlib import Path

import pytest
from cli.running import CUBE
from jsonschema.validators import validator_for

from scenecc.cli.output import base_folder
from scenecc.files import replace_set


def test_emitted_python_is_valid(run, cube: Path) -> None:
    done = run("emit", cube, "--to", "python")
    assert (done.returncode, done.stderr) == (0, "")
    assert "scenecc" not in {
        alias.name for node in ast.walk(ast.parse(done.stdout)) if isinstance(node, ast.Import) for alias in node.names
    }
    assert "def build_scenes" in done.stdout


def test_emitted_json_equals_the_plan_of_build(run, cube: Path, tmp_path: Path) -> None:
    assert run("emit", cube, "--to", "json", "-o", "emitted.json").returncode == 0
    assert run("build", cube, "--dry-run", "-o", "built.json").returncode == 0
    assert (tmp_path / "emitted.json").read_text() == (tmp_path / "built.json").read_text()


def test_a_plan_written_to_another_folder_gets_copies_of_its_files(run, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "part.mtl").write_text("newmtl red\nKd 1 0 0\n")
    faces = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    (tmp_path / "parts" / "part.obj").write_text(
        f"mtllib part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl red\n{faces}"
    )
    shape = "{type: convex_mesh, file: parts/part.obj}"
    (tmp_path / "scene.yaml").write_text(CUBE.replace("{type: box, half_size: [0.1, 0.2, 0.3]}", shape))
    (tmp_path / "out").mkdir()
    done = run("emit", "scene.yaml", "--to", "json", "-o", "out/plan.json")
    assert (done.returncode, done.stderr) == (0, "out/plan.json needs `plan.assets/` (2 files copied)\n")
    done = run("build", "scene.yaml", "--dry-run", "-o", "out/built.json")
    assert (done.returncode, done.stderr) == (0, "out/built.json needs `built.assets/` (2 files copied)\n")
    plan = (tmp_path / "out" / "plan.json").read_text()
    assert plan == (tmp_path / "out" / "built.json").read_text().replace("built.assets", "plan.assets")
    (tmp_path / "link").symlink_to("out")
    done = run("emit", "scene.yaml", "--to", "json", "-o", "link/linked.json")
    assert (done.returncode, done.stderr) == (0, "link/linked.json needs `linked.assets/` (2 files copied)\n")
    assert (tmp_path / "out" / "linked.json").read_text() == plan.replace("plan.assets", "linked.assets")
    (tmp_path / "out").rename(tmp_path / "moved")
    (tmp_path / "parts" / "part.obj").unlink()
    done = run("build", "moved/plan.json")
    assert done.returncode == 0, done.stderr


def test_nothing_is_written_beside_a_pipe(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    assert base_folder(str(pipe)) is None
    with pytest.raises(OSError, match="a device or a pipe"):
        replace_set(pipe, {"a.xml": b"", "a.assets/b.obj": b""}, folder=False)
    assert [one.name for one in tmp_path.iterdir()] == ["pipe"]
    assert pipe.is_fifo()


def test_the_files_that_an_output_needs_are_listed(run, tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    shape = "{type: convex_mesh, file: part.obj}"
    (tmp_path / "scene.yaml").write_text(CUBE.replace("{type: box, half_size: [0.1, 0.2, 0.3]}", shape))
    done = run("emit", "scene.yaml", "--to", "python", "-o", "scene.py")
    assert (done.returncode, done.stderr) == (0, "scene.py needs `part.obj`\n")
    assert not (tmp_path / "scene.assets").exists()
    done = run("emit", "scene.yaml", "--to", "json")
    assert (done.returncode, done.stderr) == (0, "the output needs `part.obj`\n")


def test_num_scenes_and_seed_reach_the_plan(run, cube: Path) -> None:
    done = run("emit", cube, "--to", "json", "--num-scenes", "3", "--seed", "7")
    assert done.returncode == 0
    plan = json.loads(done.stdout)
    assert (plan["num_scenes"], plan["seed"]) == (3, 7)


def test_a_warning_of_emit_goes_to_standard_error(run, tmp_path: Path) -> None:
    (tmp_path / "warned.yaml").write_text(CUBE + "materials: {oak: {physical: {density: 700}}}\n")
    done = run("emit", "warned.yaml", "--to", "json")
    assert done.returncode == 0
    assert json.loads(done.stdout)
    assert ": warning SC" in done.stderr


def test_emit_keeps_the_old_file_for_a_bad_scene(run, tmp_path: Path) -> None:
    (tmp_path / "bad.yaml").write_text(CUBE.replace("half_size", "half_sizes"))
    (tmp_path / "out.py").write_text("old")
    done = run("emit", "bad.yaml", "--to", "python", "-o", "out.py")
    assert (done.returncode, done.stdout) == (1, "")
    assert "SC101" in done.stderr
    assert (tmp_path / "out.py").read_text() == "old"


def test_a_missing_scene_is_wrong_usage(run) -> None:
    done = run("emit", "gone.yaml", "--to", "python")
    assert (done.returncode, done.stdout) == (2, "")
    assert "SC901" in done.stderr


def test_the_printed_schema_is_valid_and_accepts_a_scene(run) -> None:
    done = run("schema")
    assert done.returncode == 0
    schema = json.loads(done.stdout)
    validator = validator_for(schema)
    validator.check_schema(schema)
    assert validator(schema).is_valid({"scenecc": 1, "entities": {}})
    assert not validator(schema).is_valid({"entities": {}})
