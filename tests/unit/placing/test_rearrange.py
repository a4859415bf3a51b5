"""Placements that are drawn again because a later one has no room."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenecc import SceneError, compile_scene, load_scene

FLOOR = {"body_type": "static", "shapes": [{"type": "plane"}]}
STRIP = [[0, -0.15], [0, 0.15]]


def stool(region: Any = STRIP, **keys: Any) -> dict[str, Any]:
    shapes = [{"type": "cylinder", "radius": 0.14, "half_length": 0.2, "axis": "z"}]
    return {"place": {"on": "floor", "region": region, **keys}, "shapes": shapes}


def scene(num_scenes: int, **entities: Any) -> dict[str, Any]:
    return {"scenecc": 1, "num_scenes": num_scenes, "entities": {"floor": FLOOR, **entities}}


def poses(document: dict[str, Any], **options: Any) -> dict[str, Any]:
    return {entity.name: entity.pose.data for entity in compile_scene(document, **options).entities}


def test_two_stools_that_barely_fit_are_placed_in_each_scene() -> None:
    found = poses(scene(12, a=stool(), b=stool()))
    between = found["a"][:, 1] - found["b"][:, 1]
    assert np.abs(between).min() >= 0.28 + 0.001 - 1e-6
    assert {True, False} == set((between > 0).tolist())


def test_a_scene_does_not_depend_on_the_others() -> None:
    few, many = (poses(scene(count, a=stool(), b=stool(), c=stool([[1, 0], [2, 0]]))) for count in (2, 8))
    assert all(few[name].tobytes() == many[name][: len(few[name])].tobytes() for name in few)


def test_scenes_with_room_keep_their_poses() -> None:
    wide = [[0, -0.25], [0, 0.25]]
    first = poses(scene(40, a=stool(wide)))["a"]
    found = poses(scene(40, a=stool(wide), b=stool(wide)))["a"]
    kept = (first == found).all(axis=1)
    # In the middle, the first one leaves no room.
    assert (kept == (np.abs(first[:, 1]) > 0.031)).all()
    assert 1 < kept.sum() < 40


def test_a_reset_draws_earlier_placements_again_like_a_build() -> None:
    document = scene(4, a=stool(), b=stool())
    batch, fresh = load_scene(document), load_scene(document, seed=5)
    before = batch.entities["a"].pose.copy()
    batch.reset(seed=5, scene_idxs=[1, 3])
    for name in ("a", "b"):
        assert np.array_equal(batch.entities[name].pose[[1, 3]], fresh.entities[name].pose[[1, 3]])
    assert np.array_equal(batch.entities["a"].pose[[0, 2]], before[[0, 2]])


def test_what_stands_on_a_placement_moves_with_it_and_stays_near() -> None:
    ball = [{"type": "sphere", "radius": 0.02}]
    cup = {"place": {"on": "a"}, "shapes": ball}
    mark = {"place": {"on": "floor", "region": [[-1, -1], [1, 1]], "near": {"cup": [0.2, 0.6]}}, "shapes": ball}
    found = poses(scene(8, a=stool(), cup=cup, mark=mark, b=stool()))
    away = np.hypot(*(found["cup"] - found["a"])[:, :2].T)
    assert away.max() <= 0.12 + 1e-6
    assert np.allclose(found["cup"][:, 2], 0.401 + 0.001 + 0.02)
    between = np.linalg.norm((found["cup"] - found["mark"])[:, :3], axis=1) - 0.04
    assert between.min() >= 0.2 - 1e-6
    assert between.max() <= 0.6 + 1e-6
    assert np.abs(found["a"][:, 1] - found["b"][:, 1]).min() >= 0.28


def test_what_is_read_is_drawn_again_where_no_try_is_possible() -> None:
    ball = [{"type": "sphere", "radius": 0.02}]
    mark = {"place": {"on": "floor", "region": [[0, 0], [4, 0]]}, "shapes": ball}
    near = {"place": {"on": "floor", "region": [[-1, 0], [0, 0]], "near": {"mark": [0, 0.5]}}, "shapes": ball}
    found = poses(scene(10, mark=mark, near=near))
    assert (found["mark"][:, 0] - found["near"][:, 0]).max() <= 0.54 + 1e-6


def test_static_placements_are_not_moved_for_others() -> None:
    post = {**stool(), "body_type": "static"}
    with pytest.raises(SceneError, match="`b` fits nowhere") as caught:
        compile_scene(scene(5, a=post, b=stool()))
    assert "again" not in str(caught.value)
    found = poses(scene(5, a=post, b=post))
    assert np.abs(found["a"][:, 1] - found["b"][:, 1]).min() >= 0.28


def test_the_error_says_what_was_drawn_again() -> None:
    narrow = [[0, -0.13], [0, 0.13]]
    with pytest.raises(SceneError, match=r"draw `a` again, up to 200 times and 510 in all scenes") as caught:
        compile_scene(scene(1, a=stool(narrow, tries=20), b=stool(narrow, tries=20)))
    assert [one.code for one in caught.value.diagnostics] == ["SC354"]


def test_a_packing_without_a_solution_ends_after_a_number_of_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("scenecc.placing.rearrange._STEPS", 40)
    narrow = [[0, -0.13], [0, 0.13]]
    document = scene(20, a=stool(narrow, tries=20), b=stool(narrow, tries=20))
    with pytest.raises(SceneError, match=r"nor in 15 other scenes.* again, up to 200 times and 240 in all scenes"):
        compile_scene(document)


def test_scenes_that_found_room_leave_their_steps_to_others(monkeypatch: pytest.MonkeyPatch) -> None:
    # The twelve scenes take 96 steps, more than the 60 that scenes without room may take together.
    monkeypatch.setattr("scenecc.placing.rearrange._STEPS", 0)
    monkeypatch.setattr("scenecc.placing.rearrange._STEPS_OF_SCENE", 5)
    assert len(poses(scene(12, a=stool(), b=stool()))["a"]) == 12


def test_blocks_in_a_narrow_bin_rest_on_its_floor_or_on_one_another() -> None:
    sizes = (
        ([0.2, 0.1, 0.01], [0, 0, 0.01]),
        ([0.2, 0.005, 0.08], [0, 0.1, 0.08]),
        ([0.2, 0.005, 0.08], [0, -0.1, 0.08]),
    )
    ends = ([0.005, 0.1, 0.08], [0.2, 0, 0.08]), ([0.005, 0.1, 0.08], [-0.2, 0, 0.08])
    walls = [{"type": "box", "half_size": size, "pose": at} for size, at in (*sizes, *ends)]
    block = {"place": {"inside": "bin"}, "shapes": [{"type": "box", "half_size": [0.09, 0.09, 0.06]}]}
    found = poses(scene(10, bin={"body_type": "static", "shapes": walls}, a=block, b=block))
    assert np.allclose([found["a"][:, 2], found["b"][:, 2]], 0.02 + 0.001 + 0.06)
    assert np.abs(found["a"][:, 0] - found["b"][:, 0]).min() >= 0.18
