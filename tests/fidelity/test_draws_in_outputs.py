"""Orders, values that stay as built, bounds of meshes and drawn constraints in what a plan is written to."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import pytest
from fidelity.compare import assert_same_scene, assert_same_trajectory
from plugins.expectations import GOOD

from scenecc import compile_scene, emit_scene, load_scene, open_scene

TEXT = """
scenecc: 1
num_scenes: 4
draws: {order: {shuffle: [0.1, 0.2, 0.3]}, tied: {choice: [true, false]}}
entities:
  mesh:
    pose: {p: ["${order[0]}", 0, 1]}
    mass: {once: {uniform: [1, 2]}}
    shapes: [{type: convex_mesh, file: tetra.obj, pose: [0, 0, "${-bounds('tetra.obj')[1][2]}"]}]
  ball: {pose: {p: {once: {shuffle: [1, 2, 3]}}}, shapes: [{type: sphere, radius: 0.1}]}
constraints:
  hinge: {type: hinge, parent: world, child: mesh, pose_in_parent: [0, 0, 1], limits: [-1, 1], enabled: "${tied}"}
  rope: {type: distance, parent: mesh, child: ball, limits: [0, 4], enabled: {once: {choice: [true, false]}}}
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    shutil.copy(GOOD / "assets/tetra.obj", tmp_path)
    (tmp_path / "scene.yaml").write_text(TEXT)
    return tmp_path / "scene.yaml"


@pytest.mark.parametrize("seed", [0, 5])
@pytest.mark.filterwarnings("ignore:.*SC343")
def test_a_script_and_a_plan_build_the_same(file: Path, seed: int) -> None:
    plan = compile_scene(file, seed=seed)
    assert compile_scene(emit_scene(plan, "json")) == plan
    module: dict[str, Any] = {"__name__": "scenes", "__file__": str(file.with_name("scenes.py"))}
    exec(compile(emit_scene(plan, "python"), "scenes.py", "exec"), module)
    scripted = module["build_scenes"](render=False)
    with load_scene(file, seed=seed, render=False) as batch:
        for ours, theirs in zip(batch.scenes, scripted, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, scripted)


def test_a_difference_names_what_is_drawn(file: Path) -> None:
    changed = file.with_name("changed.yaml")
    changed.write_text(TEXT.replace("0.2, 0.3]", "0.2, 0.4]").replace("uniform: [1, 2]", "uniform: [5, 6]"))
    found = open_scene(file).diff(open_scene(changed)).differences
    # The rope's frame follows from where its bodies start.
    assert {(one.name, one.path) for one in found if one.name != "rope"} == {("mesh", "pose.p"), ("mesh", "mass")}
    assert not open_scene(file).diff(open_scene(file)).differences


def test_the_tree_of_a_scene_tells_what_a_reset_draws_anew(file: Path) -> None:
    data: Any = open_scene(file).inspect(build=False).item.data()
    told = {
        (row["name"], field): value["at_reset"]
        for row in data["variation"]
        for field, value in row.items()
        if field != "name"
    }
    assert {key: at_reset for key, at_reset in told.items() if not key[1].startswith("pose_in_parent")} == {
        ("mesh", "pose.p"): True,
        ("mesh", "mass"): False,
        ("ball", "pose.p"): False,
        ("hinge", "enabled"): True,
        ("rope", "enabled"): False,
    }
