"""The prefabs that ship, given parameters that differ from scene to scene; and random clutter."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from fidelity.compare import scene_facts
from fidelity.prefab_cases import ALIKE, NAMES, VARIED, label

from scenecc import compile_scene, load_scene


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
    scene = {"scenecc": 1, "num_scenes": num_scenes, "entities": {"thing": thing}}
    return load_scene(scene, render=False, audit="full")


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


@pytest.mark.parametrize(
    "given",
    [{"n": 40}, {"n": 25, "length": 0.05, "width": 0.3}, {"n": 30, "max_size": 0.05, "length": 0.2, "width": 0.2}],
    ids=label,
)
def test_clutter_overlaps_nowhere_and_starts_within_its_area(given: dict[str, Any]) -> None:
    scene = {"scenecc": 1, "num_scenes": 3, "entities": {"things": {"use": "scenecc:random_clutter", "with": given}}}
    plan: Any = compile_scene(scene)
    assert [entity.name for entity in plan.entities] == [f"things/object_{i}" for i in range(given["n"])]
    reach = np.sqrt(3) * given.get("max_size", 0.035)
    places = np.stack([entity.pose.data[:, :3] for entity in plan.entities])
    apart = np.linalg.norm(places[:, None] - places[None, :], axis=-1)
    apart[range(len(places)), range(len(places))] = np.inf
    assert apart.min() >= 2 * reach - 1e-9
    for axis, key in enumerate(("length", "width")):
        room = max(given.get(key, 0.4) / 2 - reach, 0)
        assert np.abs(places[..., axis]).max() <= room + 1e-9
    assert places[..., 2].min() >= reach - 1e-9
    assert len({int(pick) for entity in plan.entities for pick in np.ravel(entity.pick.data)}) == 4


def test_clutter_without_a_shape_has_none_of_it() -> None:
    given = {"n": 50, "boxes": 0, "cylinders": 0, "capsules": 3}
    plan: Any = compile_scene({"scenecc": 1, "entities": {"things": {"use": "scenecc:random_clutter", "with": given}}})
    picks = np.array([entity.pick.data[0] for entity in plan.entities])
    assert set(picks.tolist()) == {1, 3}
    assert (picks == 3).sum() > (picks == 1).sum()


def test_clutter_comes_to_rest_on_the_ground() -> None:
    entities = {
        "floor": {"use": "scenecc:ground"},
        "things": {"use": "scenecc:random_clutter", "with": {"n": 8}},
    }
    with load_scene({"scenecc": 1, "num_scenes": 2, "entities": entities}, render=False) as batch:
        batch.step(300)
        heights = [batch.entities[f"things/object_{i}"].pose[:, 2] for i in range(8)]
        assert np.min(heights) > 0
        assert np.max(heights) < 0.3
