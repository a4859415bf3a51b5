"""What the scenes of the recipes promise, whatever is drawn, and that the page shows what they say."""

from __future__ import annotations

import io
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
from plugins.nightly import examples
from plugins.structures import bodies_of, body_of
from unit.lower.scenes import entity

from scenecc import ScenePlan, compile_scene, load_scene, validate

ROOT = Path(__file__).resolve().parents[2]
RECIPES = ROOT / "scenes/recipes"
SEEDS = st.integers(0, 2**32)


def recipe(name: str, num_scenes: int, seed: int = 0, **params: Any) -> ScenePlan:
    return compile_scene(RECIPES / f"{name}.yaml", num_scenes=num_scenes, seed=seed, params=params)


def places(plan: ScenePlan, name: str) -> NDArray[np.float64]:
    """Where an entity is (B, 3)."""
    return entity(plan, name).pose.data[:, :3]


def gaps(a: NDArray[np.float64], b: NDArray[np.float64], half: float) -> NDArray[np.float64]:
    """Distances (B,) between upright cubes at poses (B, 7): the least of a corner of one from the other."""
    corners = half * np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)])
    found = np.full(len(a), np.inf)
    for one, other in ((a, b), (b, a)):
        turn = 2 * np.arctan2(one[:, 6], one[:, 3]), 2 * np.arctan2(other[:, 6], other[:, 3])
        for x, y in corners:
            c, s = np.cos(turn[0]), np.sin(turn[0])
            away = one[:, :2] + np.stack([c * x - s * y, s * x + c * y], axis=1) - other[:, :2]
            c, s = np.cos(turn[1]), np.sin(turn[1])
            local = np.abs(np.stack([c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]], axis=1))
            found = np.minimum(found, np.linalg.norm(np.maximum(local - half, 0), axis=1))
    return found


@pytest.mark.parametrize(("half", "play"), [(0.02, 0.002), (0.005, 0.0), (0.05, 0.01)])
def test_cubes_are_apart_in_a_region_that_moves(half: float, play: float) -> None:
    plan = recipe("stack_cube", 2048, half=half, play=play)
    a, b = (entity(plan, name).pose.data for name in ("cubeA", "cubeB"))
    found = gaps(a, b, half)
    assert play - 1e-6 <= found.min() < play + 0.002
    assert np.allclose(a[:, 2], half, atol=1e-6)
    assert (np.abs(a[:, :2] - b[:, :2]) <= [0.2, 0.4]).all()
    # The place of each is the sum of two uniform ones, of which both share the first, as in ManiSkill.
    assert np.allclose(a[:, :2].std(axis=0), np.sqrt([0.2**2 / 6, (0.2**2 + 0.4**2) / 12]), rtol=0.06)


def test_cubes_are_apart_after_every_reset() -> None:
    with load_scene(RECIPES / "stack_cube.yaml", num_scenes=16, render=False) as batch:
        for seed in range(5):
            batch.reset(seed=seed)
            a, b = (batch.entities[name].pose.astype(float) for name in ("cubeA", "cubeB"))
            assert gaps(a, b, 0.02).min() > 0.002 - 1e-6


@settings(max_examples=examples(15))
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


@settings(max_examples=examples(10))
@given(SEEDS, st.floats(0.005, 0.05), st.floats(0, 0.3))
def test_a_cube_lies_on_the_table_with_its_goal_above(seed: int, half: float, spawn: float) -> None:
    plan = recipe("pick_cube", 64, seed, half=half, spawn=spawn)
    cube, goal = places(plan, "cube"), places(plan, "goal_site")
    assert (cube[:, 2] == half).all()
    assert (np.abs(cube[:, :2]) <= spawn).all()
    assert (np.abs(goal[:, :2]) <= spawn).all()
    assert ((goal[:, 2] >= half) & (goal[:, 2] <= half + 0.3)).all()


@pytest.mark.parametrize("seed", [0, 2])
def test_a_kit_has_one_free_recess_and_its_piece_lies_beside(seed: int) -> None:
    plan = recipe("assembling_kits", 64, seed)
    kit = entity(plan, "kit").pose.data
    c, s = 2 * kit[:, 3] ** 2 - 1, 2 * kit[:, 3] * kit[:, 6]

    def local(name: str) -> NDArray[np.float64]:
        x, y, z = (places(plan, name) - kit[:, :3]).T
        return np.stack([c * x + s * y, c * y - s * x, z], axis=1)

    filled = np.stack([local(f"filler_{i}") for i in range(5)])
    assert np.allclose(filled[..., 2], 0.005 + 0.012, atol=1e-6)
    cells = np.round(np.concatenate([filled, local("goal_site")[None]]) / 0.06 + [1, 0.5, 0])
    assert (np.sort(cells[..., 0] + 3 * cells[..., 1], axis=0) == np.arange(6)[:, None]).all()
    x, y, _ = np.abs(local("piece")).T
    assert (np.hypot(np.maximum(x - 0.095, 0), np.maximum(y - 0.065, 0)) > 0.02).all()
    assert not np.array_equal(cells[:, 0], cells[:, 1])


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


YAML = re.findall(r"^```yaml\n(.*?)^```$", (ROOT / "docs/how-to/recipes.md").read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("block", YAML, ids=lambda block: block.partition("\n")[0])
def test_the_page_shows_what_a_recipe_says(block: str) -> None:
    if block.startswith("scenecc:"):
        # A whole scene.
        assert not validate(io.StringIO(block))
        return
    files = [file.read_text() for file in RECIPES.glob("*.yaml")]
    assert any(block in text or indent(block, "  ") in text for text in files)
