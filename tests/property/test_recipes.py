"""What the scenes of the recipes promise, whatever is drawn, and that the page shows what they say."""

from __future__ import annotations

import math
import re
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from plugins.structures import bodies_of, body_of
from unit.lower.scenes import entity

from scenecc import ScenePlan, compile_scene, load_scene

ROOT = Path(__file__).resolve().parents[2]
RECIPES = ROOT / "scenes/recipes"
SEEDS = st.integers(0, 2**32)


def recipe(name: str, num_scenes: int, seed: int = 0, **params: Any) -> ScenePlan:
    return compile_scene(RECIPES / f"{name}.yaml", num_scenes=num_scenes, seed=seed, params=params)


def places(plan: ScenePlan, name: str) -> NDArray[np.float64]:
    """Where an entity is (B, 3)."""
    return entity(plan, name).pose.data[:, :3]


@pytest.mark.parametrize(("half", "play"), [(0.02, 0.002), (0.005, 0.0), (0.05, 0.01)])
def test_stacked_cubes_are_apart_in_512_scenes(half: float, play: float) -> None:
    plan = recipe("stack_cube", 512, half=half, play=play)
    gaps = np.linalg.norm(places(plan, "cubeA") - places(plan, "cubeB"), axis=1)
    least = 2 * math.sqrt(2) * half + play
    assert least <= gaps.min() + 1e-12
    assert gaps.min() < least + 0.01
    assert least + 0.09 < gaps.max() <= least + 0.1 + 1e-12
    # Even over the ring, half of the pairs are beyond the circle that halves its area.
    median = math.sqrt((least**2 + (least + 0.1) ** 2) / 2)
    assert abs((gaps > median).mean() - 0.5) < 0.08
    assert (places(plan, "cubeA")[:, 2] == half).all()


def test_stacked_cubes_are_apart_after_every_reset() -> None:
    least = 2 * math.sqrt(2) * 0.02 + 0.002
    with load_scene(RECIPES / "stack_cube.yaml", num_scenes=16, render=False) as batch:
        for seed in range(5):
            batch.reset(seed=seed)
            gaps = batch.entities["cubeA"].pose[:, :2] - batch.entities["cubeB"].pose[:, :2]
            assert np.linalg.norm(gaps, axis=1).min() > least - 1e-7


@settings(max_examples=15)
@given(SEEDS, st.floats(0, 0.004))
def test_a_peg_has_its_clearance_on_every_side(seed: int, clearance: float) -> None:
    plan = recipe("peg_insertion", 32, seed, clearance=clearance)
    [peg] = body_of(entity(plan, "peg")).collisions
    length, radius, height = sizes(peg).T
    assert (radius == height).all()
    walls = body_of(entity(plan, "box_with_hole")).collisions
    half = np.array([sizes(wall) for wall in walls])  # (4, B, 3)
    middle = np.array([offset(wall, 32) for wall in walls])
    for axis, (above, below) in ((1, (0, 1)), (2, (2, 3))):
        top = middle[above, :, axis] - half[above, :, axis]
        bottom = middle[below, :, axis] + half[below, :, axis]
        assert np.allclose(top - bottom, 2 * (radius + clearance), rtol=0, atol=1e-12)
        # Outside, the box is a cube about its origin, and the hole is in it.
        assert np.allclose(middle[above, :, axis] + half[above, :, axis], length, rtol=0, atol=1e-12)
        assert np.allclose(middle[below, :, axis] - half[below, :, axis], -length, rtol=0, atol=1e-12)
        assert (top < length).all()
        assert (bottom > -length).all()
    assert (half > 0).all()
    assert (places(plan, "peg")[:, 2] == radius).all()
    assert (places(plan, "box_with_hole")[:, 2] == length).all()


def sizes(shape: Any) -> NDArray[np.float64]:
    return shape.geometry.half_size.data


def offset(shape: Any, num_scenes: int) -> NDArray[np.float64]:
    return np.broadcast_to(shape.pose.data, (num_scenes, 7))[:, :3]


@settings(max_examples=10)
@given(SEEDS, st.floats(0.005, 0.05), st.floats(0, 0.3))
def test_a_cube_lies_on_the_table_with_its_goal_above(seed: int, half: float, spawn: float) -> None:
    plan = recipe("pick_cube", 64, seed, half=half, spawn=spawn)
    cube, goal = places(plan, "cube"), places(plan, "goal_site")
    assert (cube[:, 2] == half).all()
    assert (np.abs(cube[:, :2]) <= spawn).all()
    assert (np.abs(goal[:, :2]) <= spawn).all()
    assert ((goal[:, 2] >= half) & (goal[:, 2] <= half + 0.3)).all()


def test_every_bin_is_clear_of_the_largest_ball() -> None:
    plan = recipe("place_sphere", 256, radius=0.022)
    bins = entity(plan, "bin")
    assert bins.pick is not None
    assert set(bins.pick.data.tolist()) == {0, 1, 2}
    shapes = [shape for body in bodies_of(bins) for shape in body.collisions]
    assert len(shapes) == 3 + 4 + 8 + 1
    # The ring's corners reach farthest.
    reach = math.hypot(0.025, 0.01)
    assert (places(plan, "bin")[:, 0] - places(plan, "sphere")[:, 0]).min() > 0.022 + reach


def test_a_heap_falls_into_its_bin() -> None:
    with load_scene(RECIPES / "clutter.yaml", num_scenes=2, render=False) as batch:
        things = [one for name, one in batch.entities.items() if name.startswith("things/")]
        assert len(things) == 12
        batch.step(200)
        assert all((np.abs(one.pose[:, :2]) < 0.24).all() for one in things)
        assert all((one.pose[:, 2] > 0.01).all() for one in things)


YAML = re.findall(r"^```yaml\n(.*?)^```$", (ROOT / "docs/recipes.md").read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("block", YAML, ids=lambda block: block.partition("\n")[0])
def test_the_page_shows_what_a_recipe_says(block: str) -> None:
    files = [file.read_text() for file in RECIPES.glob("*.yaml")]
    assert any(block in text or indent(block, "  ") in text for text in files)
