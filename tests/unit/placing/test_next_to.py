"""Positions beside another entity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from scenecc import compile_scene, emit_scene, load_scene, validate

TABLE = {"body_type": "static", "pose": [0, 0, 0.4], "shapes": [{"type": "box", "half_size": [1, 1, 0.02]}]}
BOX = [{"type": "box", "half_size": [0.05, 0.1, 0.03], "pose": [0.01, 0, 0]}]
CAN = [{"type": "cylinder", "radius": 0.04, "half_length": 0.1, "axis": "z"}]


def beside(of: str = "first", side: str = "left", **place: Any) -> dict[str, Any]:
    gap = place.pop("gap", 0.02)
    return {"on": "table", "next_to": {"of": of, "side": side, "gap": gap}, **place}


def scene(num_scenes: int = 1, table: dict[str, Any] = TABLE, **entities: Any) -> dict[str, Any]:
    first = {"place": {"on": "table", "at": [0.2, 0.1]}, "shapes": BOX}
    return {"scenecc": 1, "num_scenes": num_scenes, "entities": {"table": table, "first": first, **entities}}


def poses(document: dict[str, Any]) -> dict[str, Any]:
    return {entity.name: entity.pose.data for entity in compile_scene(document).entities}


def codes(document: dict[str, Any]) -> list[str]:
    return [one.code for one in validate(document) if one.severity == "error"]


@pytest.mark.parametrize(
    ("side", "align", "expected"),
    [
        ("left", None, [0.21, 0.1 + 0.1 + 0.02 + 0.04]),
        ("right", "min", [0.2 - 0.04 + 0.04, 0.1 - 0.1 - 0.02 - 0.04]),
        ("front", "max", [0.2 + 0.06 + 0.02 + 0.04, 0.2 - 0.04]),
        ("back", "center", [0.2 - 0.04 - 0.02 - 0.04, 0.1]),
    ],
)
def test_the_boxes_are_a_gap_apart_and_level_as_given(side: str, align: str | None, expected: list[float]) -> None:
    keys = {} if align is None else {"align": align}
    can = poses(scene(can={"place": beside(side=side, **keys), "shapes": CAN}))["can"][0]
    assert np.allclose(can[:3], [*expected, 0.42 + 0.001 + 0.1])


def test_axes_are_those_of_the_target_and_the_own_rotation_counts() -> None:
    table = {**TABLE, "pose": {"p": [1, 2, 0.4], "rpy_deg": [0, 0, 90]}}
    turned = {"place": beside(side="front", yaw_deg=90), "shapes": BOX}
    found = poses(scene(table=table, turned=turned))["turned"][0]
    # In the table's axes: 0.2 + 0.06 + 0.02 + 0.1, and centres level: the box is 0.01 off its origin, along y now.
    x, y = 0.38, 0.1 - 0.01
    assert np.allclose(found[:2], [1 - y, 2 + x])


def test_rows_of_drawn_sizes_need_no_draw_and_follow_at_a_reset() -> None:
    box = {
        "repeat": {"i": {"count": 3}},
        "name": "box_${i + 1}",
        "place": beside("box_${i}"),
        "shapes": [{"type": "box", "half_size": [0.03, {"uniform": [0.02, 0.06]}, 0.03]}],
    }
    first = {"place": {"on": "table", "region": [[-0.3, -0.6], [0.3, -0.2]]}, "shapes": BOX}
    document = {"scenecc": 1, "num_scenes": 4, "entities": {"table": TABLE, "box_0": first, "box": box}}
    plan = compile_scene(document)
    assert compile_scene(emit_scene(plan, "json")) == plan
    geometries: dict[str, Any] = {one.name: one.bodies[0].collisions[0].geometry for one in plan.entities}
    half = {name: one.half_size.data[:, 1] for name, one in geometries.items()}
    for scenes in (load_scene(document), load_scene(plan)):
        for seed in (None, 7):
            scenes.reset(seed=seed, scene_idxs=[1, 3])
            at = {name: scenes.entities[name].pose for name in half}
            for i in range(3):
                a, b = f"box_{i}", f"box_{i + 1}"
                gap = at[b][:, 1] - half[b] - at[a][:, 1] - half[a]
                assert np.allclose(gap, 0.02, atol=1e-6)


def test_touching_is_allowed_and_others_are_avoided() -> None:
    can = {"place": beside(gap=0, apart=0.1), "shapes": CAN}
    assert np.allclose(poses(scene(can=can))["can"][0, 1], 0.1 + 0.1 + 0.04, atol=2e-6)
    post = {"body_type": "static", "pose": [0.21, 0.27, 0.5], "shapes": CAN}
    with pytest.raises(Exception, match="`can` fits nowhere") as caught:
        compile_scene(scene(post=post, can=can))
    assert "1 of 1 are too close to `post`" in str(caught.value)


def test_an_earlier_neighbour_that_is_drawn_again_takes_its_row_along() -> None:
    wide = [{"type": "cylinder", "radius": 0.14, "half_length": 0.1, "axis": "z"}]
    region = [[0, -0.15], [0, 0.15]]
    entities = {
        "table": TABLE,
        "a": {"place": {"on": "table", "region": region}, "shapes": wide},
        "cup": {"place": beside("a", "front", gap=0.01), "shapes": CAN},
        "b": {"place": {"on": "table", "region": region}, "shapes": wide},
    }
    found = poses({"scenecc": 1, "num_scenes": 4, "entities": entities})
    assert np.allclose((found["cup"] - found["a"])[:, :2], [0.14 + 0.01 + 0.04, 0], atol=1e-6)
    assert np.abs(found["a"][:, 1] - found["b"][:, 1]).min() >= 0.28


@pytest.mark.parametrize(
    ("place", "code"),
    [
        (beside(gap=-0.1), "SC104"),
        (beside(side="up"), "SC105"),
        (beside(at=[0, 0]), "SC111"),
        (beside(facing=[0, 0]), "SC111"),
        (beside("nobody"), "SC330"),
        (beside("ghost"), "SC359"),
        (beside("floor"), "SC359"),
        (beside("can"), "SC350"),
        ({"on": "table", "next_to": {"of": "first"}}, "SC102"),
        ({"on": "table", "align": "min"}, "SC115"),
    ],
)
def test_mistakes_are_reported(place: dict[str, Any], code: str) -> None:
    ghost = {"body_type": "none", "pose": [0, 0, 2], "visuals": CAN}
    floor = {"body_type": "static", "shapes": [{"type": "plane"}]}
    assert codes(scene(ghost=ghost, floor=floor, can={"place": place, "shapes": CAN})) == [code]


def test_a_planes_surface_needs_no_region_beside_a_neighbour() -> None:
    floor = {"body_type": "static", "shapes": [{"type": "plane"}]}
    can = {"place": {**beside(), "on": "floor"}, "shapes": CAN}
    assert np.allclose(poses(scene(floor=floor, can=can))["can"][0, 2], 0.101)


def test_a_neighbour_without_a_surface_is_told_to_name_one() -> None:
    place = beside()
    del place["on"]
    (found,) = [one for one in validate(scene(second={"place": place, "shapes": CAN})) if one.severity == "error"]
    assert (found.code, found.hint) == ("SC102", "`next_to` places it sideways: add what it stands on, `on: ENTITY`")
