"""`check --permute`: a scene that depends on its neighbours is found, and none of ours does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import scenecc
from scenecc.simulation import permute

SCENES = Path(__file__).parents[3] / "scenes"
SCENE: dict[str, Any] = {
    "scenecc": 1,
    "num_scenes": 3,
    "entities": {
        "floor": {"body_type": "static", "shapes": [{"type": "plane"}]},
        "cube": {"pose": [1, 0, 0.1], "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]},
        "arm": {
            "pose": [0, 0, 1],
            "fix_root_link": True,
            "root": {
                "name": "base",
                "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1]}],
                "children": [
                    {
                        "name": "hand",
                        "joint": {"name": "elbow", "type": "revolute", "axis": "y"},
                        "shapes": [{"type": "box", "half_size": [0.1, 0.1, 0.1], "pose": [0.3, 0, 0]}],
                    }
                ],
            },
        },
    },
}


def differing(monkeypatch: pytest.MonkeyPatch, change: Any, scene: int) -> list[Any]:
    """What `check` finds if `change` is applied to the smaller batch with a scene."""
    build = permute.build_batch

    def changed(*arguments: Any, scene_idxs: Any, **options: Any) -> Any:
        batch = build(*arguments, scene_idxs=scene_idxs, **options)
        if len(scene_idxs) < 3 and scene in scene_idxs:
            change(batch)
        return batch

    monkeypatch.setattr(permute, "build_batch", changed)
    found = scenecc.check_scene(SCENE, permute=True, settle=0)
    return [one for one in found if one.code == "SC867"]


def test_equal_scenes_are_equal() -> None:
    assert scenecc.check_scene(SCENE, permute=True, settle=0) == []


def test_a_body_that_differs_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def move(batch: Any) -> None:
        batch.entities["cube"].set_pose([1.25, 0, 0.1, 1, 0, 0, 0], scene_idxs=[1])

    (found,) = differing(monkeypatch, move, 1)
    assert (found.severity, found.path) == ("error", "entities.cube")
    words = "`cube` differs from itself in another batch: `pose` by 0.25 after 1 s, in scene 1"
    assert found.message == words


def test_a_joint_that_differs_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def turn(batch: Any) -> None:
        arm = batch.articulations["arm"]
        arm.qpos = arm.qpos + np.float32(1e-6)

    (found,) = differing(monkeypatch, turn, 0)
    assert found.path == "entities.arm"
    assert found.message.startswith("`arm/elbow` differs from itself in another batch: `qpos` by ")
    assert "in scenes 0, 2" in found.message


@pytest.mark.slow
@pytest.mark.parametrize("name", ["clutter", "robot_gripper", "variants", "rope_bridge"])
def test_our_scenes_do_not_depend_on_their_neighbours(name: str) -> None:
    found = scenecc.check_scene(SCENES / f"{name}.yaml", num_scenes=4, permute=True, settle=0)
    assert "SC867" not in {one.code for one in found}
