"""Planes of environments that share one simulation."""

from __future__ import annotations

from typing import Any

import pytest

from scenecc import compile_scene
from scenecc.backends.sapien.engine import EngineFailure

PLANE = {"type": "plane"}
BOX = {"type": "box", "half_size": [0.1, 0.1, 0.1]}


def once(ground: dict[str, Any], num_scenes: int = 3) -> Any:
    plan = compile_scene(
        {"scenecc": 1, "num_scenes": num_scenes, "entities": {"ground": {"body_type": "static", **ground}}}
    )
    from scenecc.backends.maniskill.builders import deduplicate_planes  # needs ManiSkill

    return plan, deduplicate_planes(plan)


def test_a_plane_is_only_in_the_first_scene_and_other_shapes_in_all() -> None:
    _, built = once({"shapes": [PLANE, BOX]})
    (entity,) = built.entities
    shapes = [[type(shape.geometry).__name__ for shape in entity.structure(row).collisions] for row in range(3)]
    assert shapes == [["Plane", "Box"], ["Box"], ["Box"]]
    assert all(len(entity.structure(row).visuals) == 2 for row in range(3))


@pytest.mark.parametrize("ground", [{"shapes": [{**PLANE, "every_scene": True}]}, {"shapes": [BOX]}])
def test_a_plane_required_in_every_scene_stays(ground: dict[str, Any]) -> None:
    plan, built = once(ground)
    assert built is plan


def test_planes_of_a_single_scene_are_unchanged() -> None:
    plan, built = once({"shapes": [PLANE]}, 1)
    assert built is plan


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"shapes": [PLANE], "scene_idxs": [0, 1]}, "only in some environments"),
        ({"shapes": [PLANE], "pose": [0, 0, {"per_scene": [0, 1, 2]}]}, "differs"),
        ({"shapes": [{**PLANE, "offset": {"per_scene": [0, 1, 2]}}]}, "differs"),
    ],
)
def test_a_plane_that_is_not_the_same_everywhere_is_refused(ground: dict[str, Any], message: str) -> None:
    with pytest.raises(EngineFailure, match=message) as caught:
        once(ground)
    assert caught.value.code == "SC811"
