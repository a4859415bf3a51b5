from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc.options import check_scene_idxs

BALL: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 4,
    "entities": {"ball": {"shapes": [{"type": "sphere", "radius": 0.1}]}},
}


def test_scene_idxs_may_be_integers_of_any_kind() -> None:
    found = check_scene_idxs(np.array([2, 0]))
    assert found == (2, 0)
    assert all(type(index) is int for index in found)


@pytest.mark.parametrize(
    ("given", "error"),
    [
        ([1.5], TypeError),
        ("0:4", TypeError),
        (3, TypeError),
        ([True, False], TypeError),
        (np.array([True, False]), TypeError),
        ([1, 1], ValueError),
    ],
    ids=str,
)
def test_scene_idxs_must_be_integers(given: Any, error: type[Exception]) -> None:
    with pytest.raises(error, match=r"scene_idxs|scene index"):
        scenecc.load_scene(BALL, scene_idxs=given, render=False)
    with scenecc.load_scene(BALL, render=False) as batch, pytest.raises(error, match=r"scene_idxs|scene index"):
        batch.entities["ball"].set_pose([0, 0, 1, 1, 0, 0, 0], scene_idxs=given)
