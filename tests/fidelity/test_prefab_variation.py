"""The prefabs that ship, given parameters that differ from scene to scene; and random clutter."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from fidelity.compare import scene_facts
from fidelity.prefab_cases import ALIKE, NAMES, VARIED

from scenecc import SceneError, compile_scene, load_scene

FLOOR = {"body_type": "static", "collisions": [{"type": "plane"}]}
BIN = {"use": "scenecc:bin", "with": {"length": 0.4, "width": 0.4}, "pose": {"p": [1, 0, 0.3], "rpy_deg": [0, 0, 30]}}


@pytest.mark.parametrize("name", NAMES)
def test_a_parameter_may_differ_from_scene_to_scene(name: str) -> None:
    """Scene by scene it builds what the plain value builds."""
    for parameter, values in VARIED[name].items():
        with used(name, {parameter: {"cycle": values}}) as varied:
            assert facts(varied, 0) != facts(varied, 1), parameter
            for index, value in enumerate(values):
                with used(name, {parameter: value}) as plain:
                    assert facts(varied, index) == facts(plain, index), f"{parameter}: {value}"


@pytest.mark.parametrize("name", NAMES)
def test_what_differs_from_scene_to_scene_may_be_drawn(name: str) -> None:
    given: dict[str, Any] = {}
    for parameter, (low, high) in VARIED[name].items():
        numbers = not isinstance(low, str) and np.shape(low) == np.shape(high)
        bounds = np.sort([low, high], axis=0).tolist() if numbers else None
        given[parameter] = {"choice": [low, high]} if bounds is None else {"uniform": bounds}
    with used(name, given, num_scenes=8) as batch, used(name, given, num_scenes=3) as fewer:
        assert [facts(batch, scene) for scene in range(3)] == [facts(fewer, scene) for scene in range(3)]
        assert any(facts(batch, 0) != facts(batch, scene) for scene in range(1, 8))


def used(name: str, given: dict[str, Any], *, num_scenes: int = 2) -> Any:
    """Live scenes of one prefab."""
    thing = {"use": f"scenecc:{name}", "with": ALIKE.get(name, {}) | given, "pose": [0.1, 0.2, 0.3]}
    scene = {"scenecc": 1, "num_scenes": num_scenes, "entities": {"floor": FLOOR, "thing": thing}}
    return load_scene(scene, render=False)


def facts(batch: Any, scene: int) -> tuple[Any, Any]:
    """What the engine has built in a scene, and what would be seen there, which only a device can build."""
    plan = batch.plan
    seen: list[Any] = []
    for entity in plan.entities:
        pick = 0 if entity.pick is None else int(at(entity.pick, scene))
        for shape in entity.structures[pick].visuals:
            geometry = [at(value, scene).tolist() for value in vars_of(shape.geometry)]
            pose = [0, 0, 0, 1, 0, 0, 0] if shape.pose is None else at(shape.pose, scene).tolist()
            look = plan.visual_materials[int(at(shape.material, scene))]
            color = None if look.base_color is None else at(look.base_color, scene).tolist()
            seen.append((type(shape.geometry), geometry, pose, color))
    return scene_facts(batch.scenes[scene]), seen


def vars_of(geometry: Any) -> list[Any]:
    return [getattr(geometry, field.name) for field in dataclasses.fields(geometry)]


def at(value: Any, scene: int) -> Any:
    """A value of a batch in which every entity is in every scene."""
    return value.data[scene if len(value.data) > 1 else 0]


def test_a_drawn_size_is_the_same_wherever_the_prefab_reads_it() -> None:
    thing = {"use": "scenecc:twocolor_peg", "with": {"length": {"uniform": [0.05, 0.2]}}, "prefix": ""}
    plan: Any = compile_scene({"scenecc": 1, "num_scenes": 8, "entities": {"peg": thing}})
    (structure,) = plan.entities[0].structures
    collision, left, right = structure.collisions[0], *structure.visuals
    length = collision.geometry.half_size.data[:, 0]
    assert len(set(length.tolist())) == 8
    for shape, sign in ((left, -1), (right, 1)):
        assert shape.pose is not None
        assert np.array_equal(shape.pose.data[:, 0], sign * length / 2)
        assert np.array_equal(shape.geometry.half_size.data[:, 0], length / 2)


def clutter(num_scenes: int, pose: Any = None, **given: Any) -> dict[str, Any]:
    things = {"use": "scenecc:random_clutter", "with": {"target": "floor", **given}, "pose": pose or [0, 0, 0]}
    return {"scenecc": 1, "num_scenes": num_scenes, "entities": {"floor": FLOOR, "bin": BIN, "things": things}}


def starts(document: dict[str, Any]) -> Any:
    """The poses of the objects (objects, scenes, 7)."""
    things = [one for one in compile_scene(document).entities if one.name.startswith("things/")]
    assert [one.name for one in things] == [f"things/object_{i}" for i in range(len(things))]
    return np.stack([one.pose.data for one in things])


def test_clutter_is_uniform_over_its_area_and_turned_about_z() -> None:
    size = {"boxes": 0, "cylinders": 0, "capsules": 0, "min_size": 0.02, "max_size": 0.02}
    at = starts(clutter(400, {"p": [3, 1, 5], "rpy_deg": [0, 0, 90]}, n=3, length=0.6, width=0.3, apart=0.01, **size))
    along, across = at[..., 1] - 1, 3 - at[..., 0]
    assert np.abs(along).max() <= 0.3
    assert np.abs(across).max() <= 0.15
    counts, *_ = np.histogram2d(along[0] / 0.6, across[0] / 0.3, bins=4, range=[[-0.5, 0.5]] * 2)
    assert ((counts - 25) ** 2 / 25).sum() < 37.7, "chi-squared with 15 degrees of freedom, at 0.001"
    assert np.allclose(at[..., 2], 0.001 + 0.02)
    assert (at[..., 4:6] == 0).all()
    between = np.linalg.norm((at[:, None] - at[None])[..., :3], axis=-1)[np.triu_indices(3, 1)]
    assert between.min() >= 0.04 + 0.01 - 1e-6


@pytest.mark.parametrize(("start", "n"), [("inside", 3), ("above", 25)])
def test_clutter_in_and_above_a_box(start: str, n: int) -> None:
    found = starts(clutter(4, {"relative_to": "bin"}, target="bin/bin", start=start, n=n))
    reach = np.linalg.norm(found[..., :2] - [1, 0], axis=-1)
    assert reach.max() < 0.2 * np.sqrt(2)
    bottom = 0.3 + (0.15 if start == "above" else 0.01)
    assert found[..., 2].min() > bottom + 0.001
    assert (found[..., 2].max() > bottom + 0.2) == (start == "above")
    assert (found[..., 4:6] == 0).all() == (start == "inside")


def test_clutter_without_a_shape_has_none_of_it() -> None:
    plan: Any = compile_scene(clutter(1, n=50, length=2, width=2, boxes=0, cylinders=0, capsules=3))
    picks = np.array([entity.pick.data[0] for entity in plan.entities[2:]])
    assert set(picks.tolist()) == {1, 3}
    assert (picks == 3).sum() > (picks == 1).sum()


def test_clutter_comes_to_rest_where_it_was_placed_and_a_reset_places_it_anew() -> None:
    with load_scene(clutter(2, n=8, spheres=0), render=False) as batch:
        before = np.stack([batch.entities[f"things/object_{i}"].pose for i in range(8)])
        batch.step(300)
        after = np.stack([batch.entities[f"things/object_{i}"].pose for i in range(8)])
        assert after[..., 2].min() > 0
        assert after[..., 2].max() < 0.1
        batch.reset(seed=1)
        again = np.stack([batch.entities[f"things/object_{i}"].pose for i in range(8)])
        assert (np.abs(again - before)[..., :2].max(axis=-1) > 1e-3).all()


def test_what_does_not_fit_is_an_error() -> None:
    with pytest.raises(SceneError, match="fits nowhere"):
        compile_scene(clutter(1, n=40, length=0.1, width=0.1))
