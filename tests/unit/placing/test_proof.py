"""What is placed does not overlap, by an independent proof from the final poses: separating directions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from plugins.placing_proof import find_overlap

from scenecc import ScenePlan, compile_scene, load_scene
from scenecc.variation.evaluation import Batch

ROOT = Path(__file__).parents[3]
TABLE = {"body_type": "static", "shapes": [{"type": "box", "half_size": [0.4, 0.3, 0.02]}]}
SHAPES: list[dict[str, Any]] = [
    {"type": "box", "half_size": [0.03, {"uniform": [0.01, 0.03]}, 0.015]},
    {"type": "sphere", "radius": 0.025},
    {"type": "cylinder", "radius": 0.025, "half_length": 0.03, "axis": "z"},
    {"type": "capsule", "radius": 0.018, "half_length": 0.03},
    {"type": "cone", "radius": 0.03, "half_length": 0.03, "axis": "z"},
    {"type": "convex_mesh", "file": "tetra.obj"},
    {"type": "triangle_mesh", "file": "tetra.obj"},
]
TETRAHEDRON = "v 0 0 0\nv 0.06 0 0\nv 0 0.06 0\nv 0 0 0.06\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def mixed(folder: Path) -> Path:
    """Seven shapes on a small table, turned at random, at a distance or touching."""
    (folder / "tetra.obj").write_text(TETRAHEDRON, encoding="utf-8")
    things = {
        f"thing_{i}": {
            "body_type": "kinematic" if shape["type"] == "triangle_mesh" else "dynamic",
            "place": {"on": "table", "q": "uniform", "apart": 0.01 * (i % 2)},
            "collisions": [shape],
        }
        for i, shape in enumerate(SHAPES)
    }
    file = folder / "mixed.yaml"
    file.write_text(repr({"scenecc": 1, "num_scenes": 60, "entities": {"table": TABLE, **things}}), encoding="utf-8")
    return file


def overlap(plan: ScenePlan, poses: dict[str, Any]) -> str | None:
    scenes = np.arange(plan.num_scenes)
    by_scene: dict[str, Any] = {}
    for entity in plan.entities:
        by_scene[entity.name] = np.tile((0.0, 0, 0, 1, 0, 0, 0), (plan.num_scenes, 1))
        by_scene[entity.name][list(entity.scene_idxs)] = poses[entity.name]
    return find_overlap(plan, Batch(scenes, plan.seed, plan.num_scenes, {}, {}), by_scene)


def built(plan: ScenePlan) -> dict[str, Any]:
    return {entity.name: entity.pose.data for entity in plan.entities}


@pytest.mark.parametrize("name", ["mixed", "placing", "recipes/heap", "recipes/regions", "recipes/stack_cube"])
def test_placed_bodies_do_not_overlap(name: str, tmp_path: Path) -> None:
    file = mixed(tmp_path) if name == "mixed" else ROOT / "scenes" / f"{name}.yaml"
    plan = compile_scene(file, num_scenes=60)
    assert overlap(plan, built(plan)) is None


def test_bodies_placed_at_a_reset_do_not_overlap(tmp_path: Path) -> None:
    plan = compile_scene(mixed(tmp_path))
    with load_scene(plan, render=False) as batch:
        batch.reset(seed=5)
        poses = {name: one.pose.astype(float) for name, one in batch.entities.items()}
    assert not np.array_equal(poses["thing_0"], built(plan)["thing_0"])
    assert overlap(plan, poses) is None


@pytest.mark.parametrize("broken", ["trial.are_apart", "distances._bounds"])
def test_the_proof_detects_a_broken_sampler(broken: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def all_apart(a: Any, b: Any, _least: Any) -> Any:
        far = np.full(len(a.p), 1.0)
        return far > 0 if broken == "trial.are_apart" else (far, far, a.p - b.p)

    place = {"on": "table", "region": [[-0.05, -0.05], [0.05, 0.05]]}
    things = {f"thing_{i}": {"place": place, "shapes": [SHAPES[1 + i % 4]]} for i in range(6)}
    monkeypatch.setattr(f"scenecc.placing.{broken}", all_apart)
    plan = compile_scene({"scenecc": 1, "num_scenes": 20, "entities": {"table": TABLE, **things}})
    monkeypatch.undo()
    found = overlap(plan, built(plan))
    assert found is not None
    assert found.startswith("in scene 0 `thing_")
