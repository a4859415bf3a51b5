"""Documents that become shorter and build the same."""

from __future__ import annotations

from typing import Any

import scenecc
from scenecc.scene_file.parallel import merge_scenes
from scenecc.scene_file.simplify import simplify


def compiled(document: dict[str, Any]) -> Any:
    plan = scenecc.compile_scene(document)
    return plan.entities, plan.physical_materials, plan.visual_materials


def box(*pose: float, **keys: Any) -> dict[str, Any]:
    return {"type": "box", "half_size": [0.1, 0.1, 0.4], "pose": list(pose), **keys}


def test_runs_of_equal_shapes_become_a_repeat() -> None:
    legs = [box(x, y, -0.5) for x in (-0.4, 0.4) for y in (-0.3, 0.3)]
    scene = {"scenecc": 1, "entities": {"table": {"shapes": [box(0, 0, 0, density=500.0), *legs]}}}
    found = simplify(scene)
    assert found["entities"]["table"]["shapes"][1] == {
        "repeat": {"x": [-0.4, 0.4], "y": [-0.3, 0.3]},
        "type": "box",
        "half_size": [0.1, 0.1, 0.4],
        "pose": ["${x}", "${y}", -0.5],
    }
    assert compiled(found) == compiled(scene)


def test_runs_of_numbered_bodies_become_a_repeat() -> None:
    balls = {
        f"ball_{i}": {"pose": [0.1 * i, 0.0, 1.0 + i], "shapes": [{"type": "sphere", "radius": 0.05}]} for i in range(4)
    }
    pair = {f"pair_{i}": {"shapes": [{"type": "sphere", "radius": 0.05}], "pose": [9.0, i, 0.0]} for i in range(2)}
    scene = {"scenecc": 1, "entities": {**balls, **pair}}
    found = simplify(scene)
    assert list(found["entities"]) == ["ball", "pair_0", "pair_1"]
    assert found["entities"]["ball"]["repeat"] == {"p": [ball["pose"] for ball in balls.values()]}
    assert compiled(found) == compiled(scene)


def test_bodies_with_references_are_not_repeated() -> None:
    balls = {f"ball_{i}": {"shapes": [{"type": "sphere", "radius": 0.05}]} for i in range(4)}
    camera = {"mount": "ball_1", "fovy_deg": 60.0}
    found = simplify({"scenecc": 1, "entities": balls, "cameras": {"eye": camera}})
    assert "ball_1" in found["entities"]


def test_thousands_of_bodies_in_no_order_stay_as_they_are() -> None:
    # Comparing all of them with one another would take hours.
    places = {f"box_{i * i}": {"pose": [i, i % 7, 0], "shapes": [box(0, 0, 0)]} for i in range(3, 3000)}
    assert simplify({"scenecc": 1, "entities": places})["entities"] == places


def test_materials_used_twice_get_names() -> None:
    rubber = {"physical": {"static_friction": 2.0, "dynamic_friction": 2.0, "restitution": 0.0}}
    shapes = [box(0, 0, 0, material=rubber), box(0, 0, 1, material=rubber, density=20.0)]
    scene = {"scenecc": 1, "entities": {"stack": {"shapes": shapes}}}
    found = simplify(scene)
    assert found["materials"] == {"friction_2": rubber}
    assert compiled(found)[0] == compiled(scene)[0]


def test_scenes_that_differ_in_numbers_merge_into_forms() -> None:
    def scene(index: int) -> dict[str, Any]:
        ball = {"pose": [0.0, 0.0, 1.0 + index], "shapes": [{"type": "sphere", "radius": 0.1 + 0.1 * (index % 2)}]}
        thing = {
            "shapes": [box(0, 0, 0)] if index % 2 else [{"type": "sphere", "radius": 0.2}],
            "pose": [5.0, 0.0, 0.0],
        }
        entities = {"ball": ball, "thing": thing} | ({} if index else {"only": {"shapes": [box(9, 9, 9)]}})
        return {"scenecc": 1, "entities": entities}

    merged = merge_scenes([scene(index) for index in range(4)])
    assert merged["num_scenes"] == 4
    assert merged["entities"]["ball"] == {
        "pose": {"per_scene": [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0], [0.0, 0.0, 3.0], [0.0, 0.0, 4.0]]},
        "shapes": [{"type": "sphere", "radius": {"cycle": [0.1, 0.2]}}],
    }
    assert merged["entities"]["thing"]["pick"] == {"cycle": [0, 1]}
    assert merged["entities"]["only"]["scene_idxs"] == [0]
    plan = scenecc.compile_scene(merged)
    assert [entity.name for entity in plan.entities] == ["ball", "thing", "only"]
