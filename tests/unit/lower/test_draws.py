"""Shared draws, arrays that replace them, and what varying parameters are given."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from plugins.structures import body_of
from unit.lower.scenes import BALL, codes, compiled, entity, scene

from scenecc import SceneError, ScenePlan, compile_scene, validate
from scenecc.variation.evaluation import Batch
from scenecc.variation.nodes import Rows, Stacked

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic


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


def test_an_unused_material_reads_a_draw() -> None:
    materials = {"ice": {"physical": {"restitution": "${half}"}}}
    assert codes(scene(ball(0.1), draws=HALF, materials=materials)) == [("SC313", "materials.ice")]


def test_an_expression_is_judged_scene_by_scene() -> None:
    document = scene(ball("${x}"), draws={"x": {"cycle": [0.1, 0.2, -0.1]}}, num_scenes=4)
    assert codes(document) == [("SC513", "entities.body.shapes[0].radius")]
    assert codes(scene(ball("${x}"), draws={"x": {"cycle": [0.1, 0.2, -0.1]}}, num_scenes=2)) == []
    draws = {"x": {"choice": [0.1, 0.2, -0.1]}}
    assert codes(scene(ball("${x}"), draws=draws, num_scenes=50)) == [("SC513", "entities.body.shapes[0].radius")]
    assert codes(scene(ball("${x}"), draws=draws, num_scenes=1)) == [("SC514", "entities.body.shapes[0].radius")]
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
    place = "entities.body.material.physical"
    assert codes(document) == [("SC504", place)]
    tied["physical"]["dynamic_friction"] = "${1.1 * mu - 0.05}"
    assert codes(document) == [("SC504", place)]
    tied["physical"]["dynamic_friction"] = "${1.1 * mu - 0.098}"
    assert codes(document) == [("SC514", place)]


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
    plan = compiled({"density": {"uniform": [1, 2]}, "sleep_threshold": {"uniform": [1, 2]}}, num_scenes=2)
    body = body_of(entity(plan))
    assert body.sleep_threshold.recipe is None  # type: ignore[union-attr]
    assert body.collisions[0].density.recipe is None  # type: ignore[union-attr]


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
    assert [(name, type(node)) for name, node in plan.draws] == [("half", Rows)]


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


def body_radius(plan: Any, name: str = "body") -> Any:
    geometry: Any = body_of(entity(plan, name)).collisions[0].geometry
    return geometry.radius.data


DECLARED = {
    "half": {"uniform": [1, 2]},
    "sum": "${half + 1}",
    "corner": {"uniform": [[0, 0, 0], [1, 1, 1]]},
    "twice": "${[half, 2 * half]}",
    "count": {"integers": [0, 500]},
    "flag": {"choice": [True, False]},
    "text": {"choice": ["a", "b"]},
    "either": {"choice": [1, "a"]},
}
READ = "${half + sum + corner[0] + twice[1] + count + (1 if flag and text == 'a' and [either] == [1] else 2)}"


@pytest.mark.parametrize(
    ("name", "given", "wanted"),
    [
        ("half", [0.1], "must be of shape (3,), as the file declares, not (1,)"),
        ("half", np.ones((3, 2)), "must be of shape (3,), as the file declares, not (3, 2)"),
        ("half", np.ones((3, 1)), "must be of shape (3,), as the file declares, not (3, 1)"),
        ("half", 0.5, "must be of shape (3,), as the file declares, not ()"),
        ("half", [[1], [1, 2], [3]], "must have rows of one length"),
        ("half", ["a", "b", "c"], "must be of numbers, as the file declares, not of texts"),
        ("half", [True, False, True], "must be of numbers, as the file declares, not of flags"),
        ("half", [None] * 3, "must be of numbers, not of other objects"),
        ("half", [1, float("nan"), 1], "must be of finite numbers: row 1 is nan"),
        ("sum", np.ones((3, 1)), "must be of shape (3,), as the file declares, not (3, 1)"),
        ("corner", np.ones((3, 2)), "must be of shape (3, 3), as the file declares, not (3, 2)"),
        ("corner", np.ones((3, 4)), "must be of shape (3, 3), as the file declares, not (3, 4)"),
        ("corner", [1, 2, 3], "must be of shape (3, 3), as the file declares, not (3,)"),
        ("twice", np.ones((3, 3)), "must be of shape (3, 2), as the file declares, not (3, 3)"),
        ("count", [0, 1, 1.5], "must be of integers, as the file declares: row 2 is 1.5"),
        ("count", [0, 1, 1e30], "must be of integers, as the file declares: row 2 is 1e+30"),
        ("count", ["1", "2", "3"], "must be of integers, as the file declares, not of texts"),
        ("flag", [1, 0, 1], "must be of flags, as the file declares, not of numbers"),
        ("text", [1, 0, 1], "must be of texts, as the file declares, not of numbers"),
        ("either", np.ones((3, 0)), "must be of shape (3,), as the file declares, not (3, 0)"),
    ],
)
def test_an_array_is_what_its_draw_is_declared_to_be(name: str, given: Any, wanted: str) -> None:
    document = scene({"mass": READ, **ball(1)}, draws=DECLARED, num_scenes=3)
    found = validate(document, draws={name: given})
    assert [(d.code, d.path, d.message) for d in found] == [
        ("SC318", f"draws.{name}", f"the array given for this draw {wanted}")
    ]


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("half", [1, 2, 3]),
        ("half", np.array([1, 2, 3], dtype=object)),
        ("half", np.array([7, 8, 9], dtype=np.float32)),  # outside of what is declared, which is allowed
        ("twice", np.ones((3, 2), dtype=np.uint8)),
        ("count", np.array([3.0, 600.0, 7.0])),
        ("flag", np.array([True, False, True])),
        ("text", ["a", "b", "zzz"]),
        ("either", ["a", "b", "a"]),
    ],
)
def test_an_array_of_the_kind_and_shape_is_taken(name: str, given: Any) -> None:
    compiled({"mass": READ, **ball(1)}, draws=DECLARED, num_scenes=3)
    document = scene({"mass": READ, **ball(1)}, draws=DECLARED, num_scenes=3)
    assert validate(document, draws={name: given}) == []
    assert compile_scene(document, draws={name: given}).num_scenes == 3


def test_given_integers_stand_for_the_floats_that_are_declared() -> None:
    document = scene({"pose": ["${half}", 0, 0], **ball(1)}, draws=HALF, num_scenes=2)
    [(_, node)] = compile_scene(document, draws={"half": [1, 2]}).draws
    assert repr(node.items) == "(1.0, 2.0)"  # pyright: ignore[reportAttributeAccessIssue]


def test_what_is_given_is_judged_by_the_fields_that_read_it() -> None:
    document = scene(ball("${half}"), draws=HALF, num_scenes=3)
    with pytest.raises(SceneError) as caught:
        compile_scene(document, draws={"half": [1, -1, 1]})
    [error] = [found for found in caught.value.diagnostics if found.severity == "error"]
    assert (error.code, error.path) == ("SC513", "entities.body.shapes[0].radius")
    assert "in scene 1 this is -1" in error.message


def test_the_draw_of_a_prefab_is_given_by_its_full_name(tmp_path: Path) -> None:
    (tmp_path / "ball.yaml").write_text(
        "scenecc: 1\ndraws: {half: {uniform: [0.1, 0.2]}}\nentities:\n"
        '  ball: {shapes: [{type: sphere, radius: "${half}"}]}\n'
    )
    (tmp_path / "two.yaml").write_text("scenecc: 1\nentities:\n  ball: {use: ball.yaml}\n")
    top = tmp_path / "scene.yaml"
    top.write_text("scenecc: 1\nnum_scenes: 2\nentities:\n  a: {use: ball.yaml}\n  b: {use: two.yaml}\n")
    plan = compile_scene(top, draws={"a/half": [1, 2], "b/ball/half": [3, 4]})
    assert body_radius(plan, "a/ball").tolist() == [1, 2]
    assert body_radius(plan, "b/ball/ball").tolist() == [3, 4]
    found = validate(top, draws={"b/ball/half": [[3, 4], [5, 6]]})
    assert [(d.code, d.message) for d in found] == [
        ("SC318", "the array given for this draw must be of shape (2,), as the file declares, not (2, 2)")
    ]


PREFAB = """scenecc: 1
params:
  p: {%s}
entities:
  leg: {shapes: [{type: sphere, radius: "${1 if p == p else 2}"}]}
"""

SCENE = """scenecc: 1
num_scenes: 4
draws:
  u: {uniform: [0, 1]}
  v: {uniform: [[0, 0], [1, 1]]}
  n: {choice: [1, 2, 3]}
  far: {integers: [0, 1000000]}
entities:
  a: {use: prefab.yaml, with: {p: %s}%s}
  b: {shapes: [{type: sphere, radius: "${1 + u + v[0] + n + far}"}]}
"""


def write(folder: Path, declared: str, given: str, rest: str = "") -> Path:
    (folder / "prefab.yaml").write_text(PREFAB % declared)
    (folder / "scene.yaml").write_text(SCENE % (given, rest))
    return folder / "scene.yaml"


def errors(found: tuple[Diagnostic, ...] | list[Diagnostic]) -> list[str]:
    return [one.code for one in found if one.severity == "error"]


@pytest.mark.parametrize(
    ("declared", "given", "code"),
    [
        ("type: number, min: 0", '"${u - 0.5}"', "SC212"),
        ("type: number, min: 0", '"${u - 0.005}"', "SC514"),
        ("type: number, max: 2", '"${n}"', "SC212"),
        ("type: number, max: 2", '{cycle: [1, "${n}"]}', "SC212"),
        ("type: number, max: 2", '{uniform: [0, "${n}"]}', "SC212"),
        ("type: number, max: 2", '"${scene}"', "SC212"),
        ("type: number", '"${v}"', "SC211"),
        ("type: integer", '"${n * 0.5}"', "SC211"),
        ("type: integer", '"${u}"', "SC211"),
        ("type: string", '"${u}"', "SC211"),
        ("type: boolean", '"${n}"', "SC211"),
        ("type: vector", '"${u}"', "SC211"),
        ("type: vector, default: [0, 0, 0]", '"${v}"', "SC211"),
        ("type: vector, default: [0, 0], min: 0.5", '"${v}"', "SC212"),
        ("type: color", '"${v}"', "SC211"),
        ("type: choice, options: [1, 2], default: 1", '"${n}"', "SC211"),
        ("type: choice, options: [1, 2], default: 1", '"${u}"', "SC211"),
        ("type: number, max: 2", '"${u * u - u + 3}"', "SC212"),
        ("type: vector, default: [0, 0], max: 2", '"${[3 + u * u - u, 0]}"', "SC212"),
        ("type: file", '"${n}"', "SC211"),
        ("type: list", '"${n}"', "SC211"),
        ("type: number, min: 0, max: 1", '"${u}"', None),
        ("type: number, min: 0, max: 1", '"${n / 3}"', None),
        ("type: vector, default: [0, 0], min: 0", '"${v}"', None),
        ("type: choice, options: [1, 2, 3], default: 1", '"${n}"', None),
        ("type: boolean", '"${n > 1}"', None),
    ],
)
def test_arguments_are_judged_by_their_rows_and_samples(
    tmp_path: Path, declared: str, given: str, code: str | None
) -> None:
    found = validate(write(tmp_path, declared, given))
    assert [one.code for one in found] == ([] if code is None else [code])
    for one in found:
        assert one.location.line == 9
        assert "the parameter `p` must" in one.message
        assert [Path(str(related.location.file)).name for related in one.related] == ["prefab.yaml"]


def test_an_invalid_argument_is_reported_once(tmp_path: Path) -> None:
    path = write(tmp_path, "type: number, min: 0", '"${u - 0.5}"')
    prefab = PREFAB % "type: number, min: 0"
    (tmp_path / "prefab.yaml").write_text(prefab.replace("${1 if p == p else 2}", "${p}"))
    assert [one.code for one in validate(path)] == ["SC212"]


def test_scenes_in_which_an_instance_is_not_do_not_matter(tmp_path: Path) -> None:
    assert errors(validate(write(tmp_path, "type: number, max: 2", '"${scene}"', ", scene_idxs: [0, 1, 2]"))) == []
    file = write(tmp_path, "type: number, max: 2", '"${scene}"', ", scene_idxs: [1, 3]")
    [found] = [one for one in validate(file) if one.severity == "error"]
    assert found.code == "SC212"
    assert "in scene 3" in found.message


def test_an_array_for_a_parameter_is_judged_too(tmp_path: Path) -> None:
    file = tmp_path / "scene.yaml"
    file.write_text(
        "scenecc: 1\nnum_scenes: 2\nparams: {p: {type: number, min: 0, default: {uniform: [0, 1]}}}\n"
        'entities: {a: {shapes: [{type: sphere, radius: "${p + 2}"}]}}\n'
    )
    assert errors(validate(file, draws={"p": [0.0, 1.0]})) == []
    assert errors(validate(file, draws={"p": [0.0, -1.0]})) == ["SC212"]


def test_rows_for_scenes_in_which_an_instance_is_not_do_not_matter(tmp_path: Path) -> None:
    (tmp_path / "prefab.yaml").write_text(
        "scenecc: 1\nparams: {p: {type: number, min: 0, default: {uniform: [0, 1]}}}\n"
        'entities: {a: {shapes: [{type: sphere, radius: "${p + 2}"}]}}\n'
    )
    file = tmp_path / "scene.yaml"
    file.write_text("scenecc: 1\nnum_scenes: 2\nentities: {i: {use: prefab.yaml, scene_idxs: [1]}}\n")
    assert errors(validate(file, draws={"i/p": [-1.0, 1.0]})) == []
    assert errors(validate(file, draws={"i/p": [1.0, -1.0]})) == ["SC212"]


@pytest.mark.parametrize(("given", "code"), [("1 / scene", "SC202"), ("sqrt(z + 0.5)", "SC516")])
def test_an_argument_without_a_value_is_reported_even_if_the_prefab_does_not_read_it(
    tmp_path: Path, given: str, code: str
) -> None:
    (tmp_path / "prefab.yaml").write_text(
        "scenecc: 1\nparams: {p: {type: number, default: 1}}\nentities: {a: {shapes: [{type: sphere, radius: 1}]}}\n"
    )
    file = tmp_path / "scene.yaml"
    file.write_text(
        "scenecc: 1\nnum_scenes: 2\ndraws: {z: {uniform: [-1, 1]}}\n"
        f'entities: {{i: {{use: prefab.yaml, with: {{p: "${{{given}}}"}}}}}}\n'
    )
    found = [(one.code, one.path) for one in validate(file) if one.code not in {"SC319", "SC322"}]
    assert found == [(code, "entities.i.with.p")]


def test_a_draw_that_only_a_condition_reads_is_checked() -> None:
    draws = {"u": {"uniform": [0, 1]}, "d": "${u / scene}"}
    condition = {"that": "${d > 0}", "after": 0.1}
    document = scene(draws=draws, expect={"holds": [condition]}, num_scenes=3)
    assert codes(document) == [("SC202", "draws.d")]
    assert codes({**document, "expect": {"holds": [{**condition, "scene_idxs": [1, 2]}]}}) == []


@pytest.mark.parametrize(
    ("draws", "body"),
    [
        (
            {"d": {"once": "${u / scene}"}, "w": {"uniform": [0, 1]}},
            {"scene_idxs": [1, 2], "pose": ["${d + w}", 0, 0]},
        ),
        ({}, {"pose": [{"per_scene": {0: {"uniform": [0, 1]}, "default": {"once": "${u / scene}"}}}, 0, 0]}),
    ],
    ids=["in a shared draw", "in a field"],
)
def test_a_fixed_draw_may_lack_a_value_in_scenes_that_do_not_read_it(draws: Any, body: Any) -> None:
    plan = compiled(body, draws={"u": {"once": {"uniform": [1, 2]}}, **draws}, num_scenes=3)
    kept = [node for name, node in plan.draws if isinstance(node, Rows) and name != "u"]
    assert [node.scene_idxs for node in kept] == [(1, 2)]
