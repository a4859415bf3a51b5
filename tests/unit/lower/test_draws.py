"""Shared draws, the draw stage, and what a reset draws anew."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from plugins.structures import body_of
from unit.lower.scenes import BALL, codes, compiled, entity, scene

from scenecc import SceneError, ScenePlan, compile_scene, validate
from scenecc.variation.evaluation import Batch
from scenecc.variation.nodes import Rows, Stacked

HALF = {"half": {"uniform": [0.1, 0.2]}}


def radius(plan: ScenePlan, name: str = "body") -> Any:
    geometry: Any = body_of(entity(plan, name)).collisions[0].geometry
    return geometry.radius.data


def ball(size: Any, **keys: Any) -> dict[str, Any]:
    return {"shapes": [{"type": "sphere", "radius": size}], **keys}


def drawn(document: dict[str, Any], **options: Any) -> list[tuple[str, str]]:
    """Codes and paths of what compiling reports."""
    with pytest.raises(SceneError) as caught:
        compile_scene(document, **options)
    return [(diagnostic.code, diagnostic.path) for diagnostic in caught.value.diagnostics]


def test_what_reads_a_draw_agrees() -> None:
    document = scene(ball("${half}"), draws=HALF, num_scenes=4)
    document["entities"]["other"] = ball("${2 * half}")
    plan = compile_scene(document)
    assert (radius(plan, "other") == 2 * radius(plan)).all()
    assert len(set(radius(plan))) == 4


def test_a_draw_reads_those_before_it() -> None:
    draws = {"u": {"uniform": [0, 1]}, "r": "${0.1 + sqrt(u)}", "list": [1, 2, 3], "flag": True, "text": "a"}
    plan = compiled(ball("${r if flag and text == 'a' else list[0]}"), draws=draws, num_scenes=4)
    assert len(set(radius(plan))) == 4
    assert codes(scene(ball("${r}"), draws={"r": "${u}", "u": {"uniform": [1, 2]}}))[0][0] == "SC201"


def test_what_is_given_takes_the_place_of_draws() -> None:
    draws = {"a": {"uniform": [0.1, 0.2]}, "b": "${2 * a}"}
    document = scene(ball("${b}", mass="${v[1]}"), draws={**draws, "v": [1, 2]}, num_scenes=3)
    plan = compile_scene(document, draws={"a": [1, 2, 3], "v": np.array([[1, 2], [3, 4], [5, 6]])})
    assert radius(plan).tolist() == [2, 4, 6]
    assert body_of(entity(plan)).mass.data.tolist() == [2, 4, 6]  # type: ignore[union-attr]


def test_a_draw_that_is_not_there_cannot_be_given() -> None:
    assert [code for code, _ in drawn(scene(ball("${half}"), draws=HALF), draws={"haf": [1]})] == ["SC250"]


def test_a_draw_that_nothing_reads_is_a_warning() -> None:
    assert codes(scene(draws=HALF)) == [("SC319", "draws.half")]
    assert codes(scene(ball("${b}"), draws={**HALF, "b": "${half}"})) == []


def test_an_expression_is_judged_scene_by_scene() -> None:
    document = scene(ball("${x}"), draws={"x": {"cycle": [0.1, 0.2, -0.1]}}, num_scenes=4)
    assert codes(document) == [("SC513", "entities.body.shapes[0].radius")]
    assert codes(scene(ball("${x}"), draws={"x": {"cycle": [0.1, 0.2, -0.1]}}, num_scenes=2)) == []
    document = scene(ball("${x}"), draws={"x": {"choice": [0.1, 0.2, -0.1]}}, num_scenes=50)
    assert codes(document) == [("SC514", "entities.body.shapes[0].radius")]
    assert drawn(document) == [("SC514", "entities.body.shapes[0].radius"), ("SC513", "entities.body.shapes[0].radius")]
    found = validate(scene(ball("${max(0.1, x)}"), draws={"x": {"uniform": [-1, 1]}}))
    assert found == []


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("mass", "${'a' if x else 'b'}"),
        ("mass", "${[x, 2]}"),
        ("mass", "${x > 1}"),
        ("gravity", "${1 + x}"),
        ("solver_position_iterations", "${x + 0.5}"),
        ("linear_velocity", "${x}"),
        ("linear_velocity", ["${'a' if x else 'b'}", 0, 0]),
    ],
)
def test_an_expression_of_another_kind(field: str, value: Any) -> None:
    found = drawn(scene({field: value}, draws={"x": {"uniform": [1, 2]}}))
    errors = [(code, path.startswith(f"entities.body.{field}")) for code, path in found if code != "SC514"]
    assert errors == [("SC515", True)]


def test_an_expression_without_a_value_names_the_scene() -> None:
    document = scene({"mass": "${1 / (2 - scene)}"}, num_scenes=4)
    with pytest.raises(SceneError, match=r"in scene 2: .*zero") as caught:
        compile_scene(document)
    assert {diagnostic.code for diagnostic in caught.value.diagnostics} <= {"SC202", "SC514"}


@pytest.mark.parametrize(
    ("pose", "path"),
    [
        ({"look_at": [0, 0, 1], "p": ["${u * 0}", 0, 0]}, "pose.look_at"),
        ({"axis_angle": {"axis": ["${u * 0}", 0, 0], "angle": 1}}, "pose.axis_angle.axis"),
        ({"q": ["${u * 0}", 0, 0, 0]}, "pose.q"),
        ({"relative_to": "frame", "p": [0, 0, 0]}, "pose"),
    ],
)
def test_a_rotation_that_is_none_names_the_scene(pose: Any, path: str) -> None:
    frames = {"frame": {"pose": {"look_at": ["${u * 0}", 0, 0]}}}
    document = scene({"pose": pose}, draws={"u": {"uniform": [0, 1]}}, frames=frames, num_scenes=2)
    found = drawn(document)
    assert [code for code, _ in found] == ["SC515"] or found[0][0] == "SC515"
    if path != "pose":
        assert ("SC515", f"entities.body.{path}") in found


def test_pairs_that_an_expression_ties_together_are_judged_by_rows() -> None:
    tied = {"physical": {"static_friction": "${mu}", "dynamic_friction": "${0.9 * mu}"}}
    draws = {"mu": {"uniform": [0.2, 1]}}
    compiled({"material": tied}, draws=draws, num_scenes=64)
    tied["physical"]["dynamic_friction"] = "${1.1 * mu}"
    document = scene({"material": tied}, draws=draws, num_scenes=4)
    assert validate(document) == []
    assert drawn(document) == [("SC504", "entities.body.material.physical")]


def test_pairs_that_are_drawn_apart_are_judged_by_their_worst_corner() -> None:
    apart = {"physical": {"static_friction": {"uniform": [0.2, 1]}, "dynamic_friction": {"uniform": [0.1, 0.3]}}}
    assert codes(scene({"material": apart})) == [("SC504", "entities.body.material.physical")]
    apart["physical"]["dynamic_friction"] = {"uniform": [0.1, 0.2]}
    assert codes(scene({"material": apart})) == []


def recipes(plan: ScenePlan, name: str = "body") -> tuple[Any, Any]:
    one = entity(plan, name)
    velocity = body_of(one).linear_velocity
    return one.pose.recipe, velocity and velocity.recipe


FALLING = {"pose": {"p": {"uniform": [[0, 0, 0], [1, 1, 1]]}}, "linear_velocity": {"uniform": [[0, 0, 0], [1, 1, 1]]}}


def test_poses_and_velocities_have_recipes_that_give_what_was_drawn() -> None:
    plan = compiled(FALLING, num_scenes=4, seed=3)
    one = entity(plan)
    batch = Batch(np.arange(4), 3, 4, dict(plan.draws), {})
    for recipe, value in zip(recipes(plan), (one.pose, body_of(one).linear_velocity), strict=True):
        assert value is not None
        assert batch.evaluate(recipe).tolist() == value.data.tolist()


@pytest.mark.parametrize(
    "body",
    [
        {"pose": {"p": {"per_scene": [[0, 0, 0], [1, 1, 1]]}}},
        {"pose": ["${scene}", 0, 0]},
        {"body_type": "static", "pose": FALLING["pose"]},
        {"body_type": "none", "shapes": [], "visuals": BALL, "pose": FALLING["pose"]},
    ],
)
def test_what_no_seed_decides_or_no_simulation_moves_has_no_recipe(body: dict[str, Any]) -> None:
    plan = compiled(body, num_scenes=2)
    assert recipes(plan) == (None, None)
    assert entity(plan).pose.data.shape == (2, 7)


def test_other_fields_have_no_recipe() -> None:
    plan = compiled({"mass": {"uniform": [1, 2]}}, num_scenes=2)
    assert body_of(entity(plan)).mass.recipe is None  # type: ignore[union-attr]


def test_a_draw_that_a_size_reads_stays_as_it_is_built() -> None:
    draws = {"base": {"uniform": [0.1, 0.2]}, "half": "${base}", "free": {"uniform": [0, 1]}}
    document = scene(ball("${half}", pose=["${free}", "${base}", "${half}"]), draws=draws, num_scenes=3)
    plan = compile_scene(document)
    recipe, _ = recipes(plan)
    assert recipe is not None
    held = dict(plan.draws)
    assert [isinstance(held[name], Rows) for name in ("base", "half", "free")] == [True, True, False]
    again = Batch(np.arange(3), 99, 3, held, {}).evaluate(recipe)
    before = entity(plan).pose.data
    assert again[:, 1:3].tolist() == before[:, 1:3].tolist()
    assert again[:, 0].tolist() != before[:, 0].tolist()


def test_a_pose_that_reads_only_what_stays_has_no_recipe() -> None:
    plan = compile_scene(scene(ball("${half}", pose=["${half}", 0, 0]), draws=HALF, num_scenes=3))
    assert recipes(plan) == (None, None)
    assert plan.draws == ()


def chain(kind: str) -> dict[str, Any]:
    """A cube on a table in a frame, all drawn, and a wall beside the table."""
    free = {"uniform": [[0, 0, 0], [1, 1, 1]]}
    return {
        "scenecc": 1,
        "num_scenes": 3,
        "frames": {"room": {"pose": {"p": free, "rpy_deg": [0, 0, {"uniform": [0, 90]}]}}},
        "entities": {
            "table": {"body_type": kind, "shapes": BALL, "pose": {"p": free, "relative_to": "room"}},
            "cube": {"shapes": BALL, "pose": {"p": free, "q": "uniform", "relative_to": "table"}},
        },
    }


def test_a_recipe_follows_the_frames_that_are_drawn_anew() -> None:
    plan = compile_scene(chain("kinematic"))
    for name in ("table", "cube"):
        recipe, _ = recipes(plan, name)
        for seed, same in ((0, True), (7, False)):
            again = Batch(np.arange(3), seed, 3, dict(plan.draws), {}).evaluate(recipe)
            assert (again == entity(plan, name).pose.data).all() == same


def test_what_a_static_body_stands_relative_to_stays_where_it_is() -> None:
    plan = compile_scene(chain("static"))
    assert recipes(plan, "table") == (None, None)
    recipe, _ = recipes(plan, "cube")
    assert isinstance(recipe.outer, Rows)
    assert np.array(recipe.outer.items).tolist() == entity(plan, "table").pose.data.tolist()
    again = Batch(np.arange(3), 7, 3, dict(plan.draws), {}).evaluate(recipe)
    assert (again != entity(plan, "cube").pose.data).any()


def test_a_frame_that_a_static_body_stands_in_is_held_for_all() -> None:
    document = chain("kinematic")
    document["entities"]["wall"] = {"body_type": "static", "shapes": BALL, "pose": {"relative_to": "room"}}
    plan = compile_scene(document)
    recipe, _ = recipes(plan, "table")
    assert isinstance(recipe.outer, Rows)
    assert np.array(recipe.outer.items).tolist() == entity(plan, "wall").pose.data.tolist()


def test_the_expressions_of_a_velocity_are_part_of_its_recipe() -> None:
    draws = {"v": {"uniform": [0, 1]}, "w": "${2 * v}"}
    plan = compiled({"linear_velocity": [0, 0, "${w}"]}, draws=draws, num_scenes=3)
    _, recipe = recipes(plan)
    assert isinstance(recipe, Stacked)
    assert [name for name, _ in plan.draws] == ["v", "w"]


def test_bounds_that_change_places_name_the_scene() -> None:
    document = scene({"mass": {"uniform": [{"cycle": [1, 3]}, 2]}}, num_scenes=4)
    (found,) = validate(document)
    assert (found.code, found.path) == ("SC515", "entities.body.mass")
    assert found.message == "in scene 1: the lower bound is above the upper one"


def test_a_shape_is_known_to_its_draws_by_its_number() -> None:
    drawn_ball = {"type": "sphere", "radius": {"uniform": [1, 2]}}
    alone = radius(compiled({"shapes": [drawn_ball]}, num_scenes=4))
    second = compiled({"shapes": [{"type": "sphere", "radius": 1}, drawn_ball]}, num_scenes=4)
    geometry: Any = body_of(entity(second)).collisions[1].geometry
    assert (geometry.radius.data != alone).all()
    first = compiled({"shapes": [drawn_ball, {"type": "sphere", "radius": 1}]}, num_scenes=4)
    assert (radius(first) == alone).all()


def test_a_whole_number_stays_one_in_a_text() -> None:
    document = {
        "scenecc": 1,
        "num_scenes": 4,
        "draws": {"k": {"choice": [1, 2]}, "j": {"cycle": [3, 4]}},
        "materials": {f"m{n}": {"physical": {"static_friction": n}} for n in range(1, 5)},
        "entities": {
            name: {"body_type": "static", "material": f"m${{{name}}}", "shapes": [{"type": "sphere", "radius": 1}]}
            for name in ("k", "j")
        },
    }
    plan = compile_scene(document)
    material = body_of(plan.entities[1]).collisions[0].material
    assert material is not None
    rows = [plan.physical_materials[int(material.row(i))].row(0).static_friction for i in range(4)]
    assert rows == [3, 4, 3, 4]
