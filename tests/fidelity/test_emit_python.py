"""An emitted script builds what the SAPIEN backend builds, to the last bit, where scenecc cannot be imported."""

from __future__ import annotations

import io
import pickle
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from plugins.sample_plans import ROOT, SAMPLES
from plugins.slow import mostly_slow
from sapien import physx

from scenecc import compile_scene
from scenecc.backends.sapien import instantiate
from scenecc.diagnostics import Sink
from scenecc.emit import emit

if TYPE_CHECKING:
    from scenecc.plan import ScenePlan

STEPS = 300
SCENES = sorted((ROOT / "scenes").glob("*.yaml"))

# Runs a script as a stranger would, and pickles all that can be read of its scenes before and while they move.
RUN = """
import importlib.util, pickle, sys, warnings
warnings.simplefilter("ignore")
sys.modules["scenecc"] = None

def load(name, path):
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module

if __name__ == "__main__":
    compare, script = load("compare", sys.argv[1]), load("script", sys.argv[2])
    scenes = script.build_scenes(render=sys.argv[4] == "render")
    facts = [compare.scene_facts(scene) for scene in scenes]
    moves = []
    for scene in scenes:
        for _ in range(int(sys.argv[5])):
            scene.step()
            moves.append(scene.pack_poses())
        moves.append(scene.physx_system.pack())
    from sapien import physx
    configs = [x.__getstate__() for x in (physx.get_shape_config(), physx.get_body_config(), physx.get_sdf_config())]
    pickle.dump((facts, moves, configs), open(sys.argv[3], "wb"))
    assert not [name for name in sys.modules if name.startswith("scenecc.")]
"""


def run_script(plan: ScenePlan, folder: Path, *, render: bool = False) -> tuple[Any, Any, Any]:
    sink = Sink()
    text = emit(plan, "python", sink, base=folder)
    assert text is not None
    assert not sink.diagnostics()
    script, runner, out = folder / "scenes.py", folder / "run.py", folder / "out.pickle"
    script.write_text(text, encoding="utf-8")
    runner.write_text(RUN, encoding="utf-8")
    compare = Path(__file__).with_name("compare.py")
    mode = "render" if render else "physics"
    command = [sys.executable, str(runner), str(compare), str(script), str(out), mode, str(STEPS)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=100, cwd=folder)
    assert done.returncode == 0, done.stderr
    return pickle.loads(out.read_bytes())


def run_backend(plan: ScenePlan, *, render: bool = False) -> tuple[Any, Any]:
    from fidelity import compare

    sink = Sink()
    batch = instantiate(plan, sink, render=render)
    assert batch is not None, sink.diagnostics()
    facts, moves = [compare.scene_facts(scene) for scene in batch.scenes], []
    for scene in batch.scenes:
        for _ in range(STEPS):
            scene.step()
            moves.append(scene.pack_poses())
        system = scene.physx_system
        assert isinstance(system, physx.PhysxCpuSystem)
        moves.append(system.pack())
    batch.close()
    return facts, moves


def assert_same(plan: ScenePlan, folder: Path, *, render: bool = False) -> None:
    from fidelity import compare

    facts, moves, _ = run_script(plan, folder, render=render)
    expected, expected_moves = run_backend(plan, render=render)
    assert len(facts) == len(expected) == plan.num_scenes
    for left, right in zip(expected, facts, strict=True):
        assert [name for name, _ in left["entities"]] == [name for name, _ in right["entities"]]
        assert not compare._differences("scene", left, right)
    assert moves == expected_moves


def by_absolute_paths(plan: ScenePlan) -> ScenePlan:
    """A render shape remembers how its file was spelled."""
    return replace(plan, files=tuple(replace(file, uri=str(file.path)) for file in plan.files))


@pytest.mark.parametrize("name", [name for name in SAMPLES if name != "decomposed"])
def test_the_script_builds_what_the_backend_builds(name: str, tmp_path: Path) -> None:
    assert_same(SAMPLES[name](), tmp_path)


@pytest.mark.parametrize("file", mostly_slow(SCENES, 6), ids=lambda file: file.stem)
def test_so_do_the_scenes_that_ship(file: Path, tmp_path: Path) -> None:
    assert_same(compile_scene(file, num_scenes=4), tmp_path)


@pytest.mark.render
@pytest.mark.parametrize("name", [name for name in SAMPLES if name != "decomposed"])
def test_and_what_is_seen_with_a_renderer(name: str, tmp_path: Path) -> None:
    assert_same(by_absolute_paths(SAMPLES[name]()), tmp_path, render=True)


@pytest.mark.render
@pytest.mark.parametrize("file", SCENES, ids=lambda file: file.stem)
def test_and_in_the_scenes_that_ship(file: Path, tmp_path: Path) -> None:
    assert_same(by_absolute_paths(compile_scene(file, num_scenes=4)), tmp_path, render=True)


def test_coacd_writes_nothing_beside_the_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("coacd")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    plan = SAMPLES["decomposed"]()
    folder = tmp_path / "script"
    folder.mkdir()
    before = set(plan.files[0].path.parent.iterdir())
    assert_same(plan, folder)
    assert set(plan.files[0].path.parent.iterdir()) == before
    assert {path.name for path in folder.iterdir()} <= {"scenes.py", "run.py", "out.pickle", "__pycache__"}


def test_the_settings_of_the_process_are_put_back(tmp_path: Path) -> None:
    from sapien import physx

    defaults = [x.__getstate__() for x in (physx.get_shape_config(), physx.get_body_config(), physx.get_sdf_config())]
    _, _, after = run_script(SAMPLES["knobs"](), tmp_path)
    assert after == defaults


def test_a_missing_mesh_is_an_error_and_not_an_empty_body(tmp_path: Path) -> None:
    plan = SAMPLES["varied"]()
    plan = replace(
        plan,
        files=tuple(replace(file, uri=f"gone/{i}.obj", path=tmp_path / "gone") for i, file in enumerate(plan.files)),
    )
    text = emit(plan, "python", Sink())
    script = tmp_path / "scenes.py"
    script.write_text(text or "", encoding="utf-8")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 1
    assert "FileNotFoundError" in done.stderr
    assert "gone" in done.stderr


def test_the_script_runs_by_itself(tmp_path: Path) -> None:
    script = tmp_path / "scenes.py"
    script.write_text(emit(SAMPLES["varied"](), "python", Sink(), base=tmp_path) or "", encoding="utf-8")
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False, timeout=100)
    assert done.returncode == 0, done.stderr
    assert "obstacle" in done.stdout


COPIES = """
scenecc: 1
num_scenes: 3
materials:
  slippery: {physical: {static_friction: {uniform: [0.1, 0.3]}, dynamic_friction: 0.1, restitution: 0}}
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  fence:                                # the same in every scene
    repeat: {i: {count: 4}}
    body_type: static
    pose: ["${i - 2}", 1, 0.1]
    shapes: [{type: box, half_size: [0.4, 0.05, "${0.1 + i / 100}"]}]
  stone:                                # everything differs, by copy and by scene
    repeat: {i: {count: 3}, j: {count: 2}}
    name: "stone_${i}_${j}"
    pose: {p: ["${i * 0.3}", "${j * 0.3}", {uniform: [0.1, 0.3]}], q: uniform}
    mass: {uniform: [0.1, 1]}
    linear_velocity: [{uniform: [-1, 1]}, 0, 0]
    color: {choice: ["#ff0000", "#00ff00"]}
    material: slippery
    shapes: [{type: box, half_size: {uniform: [[0.02, 0.02, 0.02], [0.1, 0.1, 0.1]]}, rest_offset: 0.001}]
  pebble:                               # in one scene
    repeat: {i: {count: 3}}
    scene_idxs: [1]
    pose: ["${i / 10}", -0.5, 0.5]
    shapes: [{type: sphere, radius: "${0.02 + i / 100}"}]
  marble:                               # in some, by scene and the same for all copies
    repeat: {i: {count: 3}}
    scene_idxs: [0, 2]
    pose: {p: ["${i / 10}", -0.7, 0.5]}
    density: "${1000 + scene}"
    shapes: [{type: sphere, radius: 0.03}]
"""


def test_so_do_copies(tmp_path: Path) -> None:
    assert_same(compile_scene(io.StringIO(COPIES)), tmp_path)


ROBOTS = """
scenecc: 1
num_scenes: 2
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  panda:                                # a file, of which one joint follows another
    repeat: {i: {count: 2}}
    urdf: pkg://mani_skill/assets/robots/panda/panda_v2.urdf
    pose: [-0.615, "${i}", 0]
    gravity: false
    qpos: [{uniform: [-0.1, 0.1]}, 0.39, 0, -1.96, 0, 2.36, 0.79, 0.04, 0.04]
    drives: {"panda_joint.*": {stiffness: 1000, damping: 100, force_limit: 100}}
    links: {"panda_.*finger": {patch_radius: 0.1, min_patch_radius: 0.1}}
  humanoid:
    mjcf: pkg://mani_skill/assets/robots/humanoid/humanoid.xml
    fix_root_link: false
    pose: [2, 0, 0]
  cube: {pose: [0, 0, 0.5], shapes: [{type: box, half_size: [0.02, 0.02, 0.02]}]}
"""


@pytest.mark.maniskill
def test_so_do_robots_of_files(tmp_path: Path) -> None:
    plan = compile_scene(io.StringIO(ROBOTS))
    text = emit(plan, "python", Sink(), base=tmp_path)
    assert text is not None
    assert text.count("create_fixed_tendon") == 2
    assert_same(plan, tmp_path)


TREE = """
scenecc: 1
num_scenes: 2
entities:
  ground: {body_type: static, shapes: [{type: plane}]}
  door:
    pose: [0, 0, 1.1]
    fix_root_link: true
    root:
      name: frame
      shapes: [{type: box, half_size: [0.05, 0.05, 1]}]
      children:
        - name: panel
          joint:
            {name: hinge, type: revolute, origin: {p: [0.1, 0, 0]}, axis: [0, 0, 1], limits_deg: [0, 90], friction: 0.1,
             damping: {uniform: [1, 2]}}
          shapes: [{type: box, half_size: [0.3, 0.02, 0.9], pose: [0.3, 0, 0]}]
          children:
            - name: handle
              joint: {name: turn, type: revolute, origin: {p: [0.5, 0.05, 0]}, axis: [0, 1, 0], limits: [-1, 1]}
              mass: 0.3
              shapes: [{type: capsule, radius: 0.02, half_length: 0.05}]
    drives: {turn: {stiffness: 5, damping: 1, target: {uniform: [0, 0.5]}}}
    qpos: {hinge: {uniform: [0.1, 1]}}
  ball: {pose: [0.3, 0.3, 1], linear_velocity: [0, -2, 0], shapes: [{type: sphere, radius: 0.05}]}
"""


FINGERS = """
scenecc: 1
num_scenes: 2
entities:
  hand:
    pose: [0, 0, 1]
    solver_position_iterations: 14
    root:
      name: palm
      shapes: [{type: box, half_size: [0.05, 0.05, 0.05]}]
      children:
        - name: upper
          joint: {name: bend, type: revolute, axis: [0, 1, 0], armature: 0.001}
          mass: {uniform: [0.1, 0.3]}
          shapes: [{type: box, half_size: [0.1, 0.02, 0.02], pose: [0.1, 0, 0]}]
          children:
            - name: lower
              joint:
                {name: curl, type: revolute, axis: [0, 1, 0], origin: {p: [0.2, 0, 0]},
                 mimic: {joint: bend, offset: 0.1}}
              shapes: [{type: box, half_size: [0.1, 0.02, 0.02], pose: [0.1, 0, 0]}]
              children:
                - name: tip
                  joint:
                    {name: slide, type: prismatic, origin: {p: [0.2, 0, 0]}, limits: [-0.1, 0.1],
                     mimic: {joint: bend, multiplier: {uniform: [0.05, 0.1]}}}
                  shapes: [{type: box, half_size: [0.05, 0.01, 0.01]}]
    qpos: {bend: 0.3}
    drives: {bend: {stiffness: 20, damping: 1}}
physics: {timestep: 0.004, solver_position_iterations: 12}
"""


def test_so_do_soft_tendons(tmp_path: Path) -> None:
    plan = compile_scene(io.StringIO(FINGERS))
    text = emit(plan, "python", Sink(), base=tmp_path)
    assert text is not None
    assert text.count("= soft_tendon(") == 2
    assert_same(plan, tmp_path)


def test_so_do_trees_of_links(tmp_path: Path) -> None:
    assert_same(compile_scene(io.StringIO(TREE)), tmp_path)


def test_so_do_robots_that_are_read_otherwise_in_each_scene(tmp_path: Path) -> None:
    robot = {
        "urdf": str(ROOT / "tests/scenes/good/articulations/arm.urdf"),
        "scale": {"cycle": [1, 0.5]},
        "fix_root_link": "${scene != 2}",
        "qpos": {"elbow": 0.5},
        "pose": [0, 0, 1],
    }
    assert_same(compile_scene({"scenecc": 1, "num_scenes": 4, "entities": {"arm": robot}}), tmp_path)


SEEN_FIRST = """
scenecc: 1
num_scenes: 2
materials: {shiny: {visual: {roughness: {per_scene: [0.1, 0.2]}}}}
entities:
  ball:
    linear_damping: {per_scene: [0.1, 0.2]}
    shapes: [{type: sphere, radius: {per_scene: [0.1, 0.2]}, material: shiny}]
  weight:
    pose: [0, 1, 0]
    mass: {per_scene: [0.3, 0.4]}
    visuals: [{type: sphere, radius: {per_scene: [0.3, 0.4]}}]
    collisions: [{type: sphere, radius: 0.1}]
"""


def test_what_is_seen_has_no_list_to_itself_that_others_read(tmp_path: Path) -> None:
    """Without rendering there would be none: the numbers of a look, or of what is seen, are those of all else too."""
    plan = compile_scene(io.StringIO(SEEN_FIRST))
    assert_same(plan, tmp_path)
    text = (tmp_path / "scenes.py").read_text()
    assert text.count("[0.1, 0.2]") == text.count("[0.3, 0.4]") == 1
