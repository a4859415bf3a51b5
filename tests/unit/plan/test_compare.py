"""What differs between two plans."""

from __future__ import annotations

import dataclasses
import re
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plugins.nightly import examples
from plugins.plan_strategy import TABLES, plans
from plugins.sample_plans import SAMPLES, entity, indices, look, pose, rubbing, solid

from scenecc import Difference, compile_scene
from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionShape,
    Entity,
    Mimic,
    Physics,
    ScenePlan,
    Sphere,
    Value,
    VisualShape,
    constant,
    literal,
    per_scene,
    recalled,
)
from scenecc.plan.body import PhysicalMaterial
from scenecc.plan.diff import diff_plans
from scenecc.plan.display import SPEC_FIELD_NAMES
from scenecc.plan.properties import Quantity
from scenecc.plan.scene import SettledStart
from scenecc.plan.schema import ChoiceKind, ListKind, ObjectKind, ScalarKind, UnionKind, VectorKind, plan_fields
from scenecc.variation.nodes import Chosen, Drawn, Key, Posed, Shared, Stacked

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

Site = tuple[str, Any, Any, "Callable[[Any], Any]"]


@pytest.mark.parametrize("name", SAMPLES)
def test_a_plan_is_equal_to_itself(name: str) -> None:
    assert diff_plans(SAMPLES[name](), SAMPLES[name]()) == []


@given(plans(), st.randoms(use_true_random=False))
@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large], max_examples=examples(25))
def test_the_order_of_the_tables_is_no_difference(plan: ScenePlan, random: Any) -> None:
    orders: dict[str, list[int]] = {}
    for table in TABLES:
        orders[table] = random.sample(range(len(getattr(plan, table))), len(getattr(plan, table)))
    other = _reordered(plan, orders)
    assert diff_plans(plan, other) == diff_plans(other, plan) == []


def _reordered(node: Any, orders: dict[str, list[int]]) -> Any:
    """With the tables in other orders and every index as its entry is numbered then."""
    changed: dict[str, Any] = {}
    for slot in plan_fields(type(node)):
        item = getattr(node, slot.name)
        if item is None:
            continue
        if isinstance(slot.kind, Quantity) and slot.kind.table is not None:
            places = np.argsort(orders[slot.kind.table])
            changed[slot.name] = Value(places[item.data])
        elif isinstance(slot.kind, ObjectKind | UnionKind):
            changed[slot.name] = _reordered(item, orders)
        elif isinstance(slot.kind, ListKind) and not isinstance(slot.kind.item, ListKind | ScalarKind):
            changed[slot.name] = tuple(_reordered(one, orders) for one in item)
            if slot.name in orders:
                changed[slot.name] = tuple(changed[slot.name][index] for index in orders[slot.name])
    return dataclasses.replace(node, **changed)


def _sites(node: Any, path: str, rebuild: Callable[[Any], Any]) -> Iterator[Site]:
    """Every field that has one: path, kind, what it holds, and the whole with something else in its place."""
    for slot in plan_fields(type(node)):
        item = getattr(node, slot.name)
        where = f"{path}.{slot.name}" if path else slot.name

        def put(new: Any, name: str = slot.name) -> Any:
            return rebuild(dataclasses.replace(node, **{name: new}))

        if item is None or slot.name in {
            "expectations",  # told as a whole: tests/unit/simulation/test_expect.py
            "files",
            "physical_materials",
            "visual_materials",
            "name",
            "scene_idxs",
            "axis",
        }:
            continue
        if isinstance(node, Mimic) and slot.name == "joint":
            continue
        if isinstance(slot.kind, ListKind) and isinstance(slot.kind.item, ListKind):
            continue  # heights of terrain, which are compared as a whole
        if isinstance(slot.kind, ListKind):
            for index, one in enumerate(item):

                def put_item(new: Any, index: int = index, item: Any = item, put: Any = put) -> Any:
                    return put((*item[:index], new, *item[index + 1 :]))

                yield from _sites(one, f"{where}[{index}]", put_item)
        elif isinstance(slot.kind, ObjectKind | UnionKind):
            yield from _sites(item, where, put)
        elif not isinstance(slot.kind, Quantity) or (slot.kind.table is None and slot.name != "pick"):
            yield where, slot.kind, item, put


def _other(kind: Any, item: Any, data: st.DataObject) -> Any:
    """Something else of the kind."""
    match kind:
        case Quantity():
            row = data.draw(st.integers(0, len(item.data) - 1))
            rows = item.data.copy()
            rows[row] = ~rows[row] if rows.dtype == np.bool_ else rows[row] * 0.5 + 1
            return Value(rows) if item.recipe is None else recalled(rows, item.recipe)
        case ChoiceKind():
            return next(option for option in kind.options if option != item)
        case VectorKind():
            return (item[0] * 0.5 + 1, *item[1:])
        case ScalarKind():
            return not item if kind.type is bool else item + "x" if kind.type is str else item * 2 + 1
        case _:
            return None


@given(plans(), st.data())
@settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large], max_examples=examples(25))
def test_a_change_of_one_field_is_told_as_that_field(plan: ScenePlan, data: st.DataObject) -> None:
    sites = [site for site in _sites(plan, "", lambda new: new) if not site[0].startswith(("num_scenes", "starts"))]
    # To draw a plan takes far longer than to compare it.
    for path, kind, item, put in data.draw(st.lists(st.sampled_from(sites), min_size=4, max_size=8)):
        new = _other(kind, item, data)
        if new is None or new == item:
            continue
        found = diff_plans(plan, put(new))
        assert 1 <= len(found) <= (2 if isinstance(kind, Quantity) and kind.pose else 1)
        # An axis has nothing but its limits.
        field = "" if re.search(r"limits\[\d+\]\.limits$", path) else path.rpartition(".")[2]
        for one in found:
            assert one.kind == "changed"
            assert one.path.removesuffix(".p").removesuffix(".q").endswith(SPEC_FIELD_NAMES.get(field, field))
            assert not {"structures", "geometry", "lens", "recipe"} & set(re.split(r"[.\[]", one.path))
            assert one.a != one.b
            assert (one.scene_count is None) == (not isinstance(kind, Quantity))
        back = diff_plans(put(new), plan)
        assert [(one.path, one.a, one.b) for one in back] == [(one.path, one.b, one.a) for one in found]


def two(**more: Any) -> ScenePlan:
    ball, box = solid(Sphere(constant(0.1))), solid(Box(constant([0.1, 0.1, 0.1])))
    return ScenePlan(
        "two",
        2,
        (entity("ball", pose(0, 0, 1), ball), entity("box", pose(0, 0, 2), box)),
        **{"physics": Physics(), **more},
    )


def test_other_starts_are_one_difference() -> None:
    starts = (SettledStart(3, 0, b"\0" * 56), SettledStart(4, 0, b"\1" * 56))
    a, b = (dataclasses.replace(two(), starts=some) for some in (starts, starts[::-1]))
    (found,) = diff_plans(a, b)
    assert (found.path, found.a == found.b) == ("starts", False)


def test_entities_come_and_go_and_move() -> None:
    plan = two()
    ball, box = plan.entities
    extra = entity("extra", pose(0, 0, 3), solid(Sphere(constant(0.2)), body_type="static"), (1,))
    assert diff_plans(plan, dataclasses.replace(plan, entities=(extra, ball, box))) == [
        Difference("added", "entities", "extra", "", None, "static in scene 1")
    ]
    assert diff_plans(plan, dataclasses.replace(plan, entities=(box,))) == [
        Difference("removed", "entities", "ball", "", "dynamic in every scene", None)
    ]
    (moved,) = diff_plans(plan, dataclasses.replace(plan, entities=(box, ball)))
    assert (moved.kind, moved.name) == ("moved", "box") or (moved.kind, moved.name) == ("moved", "ball")


def test_a_structure_more_is_told_in_a_few_words() -> None:
    plan = two()
    ball, box = plan.entities
    more = dataclasses.replace(ball, structures=(*ball.structures, *box.structures), pick=indices(0, 1))
    found = diff_plans(plan, dataclasses.replace(plan, entities=(more, box)))
    assert ("added", "variants[1]", None, "type dynamic, collisions 1, visuals 0") in [
        (one.kind, one.path, one.a, one.b) for one in found
    ]


def test_only_what_must_move_is_told_to_have_moved() -> None:
    many = tuple(entity(f"e{i}", pose(0, 0, i), solid(Sphere(constant(0.1)))) for i in range(6))
    plan = dataclasses.replace(two(), entities=many)
    last_first = dataclasses.replace(plan, entities=(many[5], *many[:5]))
    assert [(one.kind, one.name, one.a, one.b) for one in diff_plans(plan, last_first)] == [
        ("moved", "e5", "number 6", "number 1")
    ]


def body_of(*shapes: CollisionShape, visuals: tuple[VisualShape, ...] = ()) -> BodyStructure:
    return BodyStructure("dynamic", shapes, visuals)


def with_shapes(*sizes: float) -> ScenePlan:
    shapes = tuple(CollisionShape(Sphere(constant(size))) for size in sizes)
    return dataclasses.replace(two(), entities=(entity("ball", pose(0, 0, 1), body_of(*shapes)),))


def test_a_shape_put_in_between_is_one_difference() -> None:
    base = "collisions"
    assert diff_plans(with_shapes(1, 2, 3), with_shapes(1, 9, 2, 3)) == [
        Difference("added", "entities", "ball", f"{base}[1]", None, "type sphere, radius 9")
    ]
    assert [one.path for one in diff_plans(with_shapes(1, 2, 3), with_shapes(2, 3))] == [f"{base}[0]"]
    assert [(one.kind, one.path) for one in diff_plans(with_shapes(1, 2, 3), with_shapes(5, 2, 3, 4))] == [
        ("changed", f"{base}[0].radius"),
        ("added", f"{base}[3]"),
    ]


def test_values_are_told_by_their_range_and_the_scenes_that_differ() -> None:
    def at(*heights: float) -> ScenePlan:
        rows = per_scene([[0, 0, height, 1, 0, 0, 0] for height in heights])
        ball = Entity("ball", tuple(range(len(heights))), rows, (solid(Sphere(constant(0.1))),))
        return dataclasses.replace(two(), num_scenes=len(heights), entities=(ball,))

    (one,) = diff_plans(at(1, 2, 3, 4, 5, 6), at(1, 2, 3, 4, 5, 7))
    assert one == Difference(
        "changed", "entities", "ball", "pose.p", "[0, 0, 6]", "[0, 0, 7]", 1,
    )  # fmt: skip
    (one,) = diff_plans(at(1, 1), at(2, 2))
    assert (one.a, one.b, one.scene_count) == ("[0, 0, 1]", "[0, 0, 2]", 2)
    (one,) = diff_plans(at(1, 2, 3, 4, 5, 6), at(2, 3, 4, 5, 6, 7))
    assert (one.a, one.b, one.scene_count) == ("[0, 0, 1 … 6]", "[0, 0, 2 … 7]", 6)


def test_numbers_have_the_digits_that_tell_them_apart() -> None:
    def at(*heights: float) -> ScenePlan:
        rows = per_scene([[0, 0, height, 1, 0, 0, 0] for height in heights])
        return dataclasses.replace(two(), entities=(entity("ball", rows, solid(Sphere(constant(0.1)))),))

    (one,) = diff_plans(at(1 / 3, 2), at(1 / 3 + 1e-7, 2))
    assert (one.a, one.b, one.scene_count) == ("[0, 0, 0.33333333]", "[0, 0, 0.33333343]", 1)
    (one,) = diff_plans(at(1, 2), at(2, 1))
    assert (one.a, one.b) == ("[0, 0, 1] | [0, 0, 2]", "[0, 0, 2] | [0, 0, 1]")


def test_rows_are_compared_scene_by_scene() -> None:
    def ball(scenes: tuple[int, ...], *radii: float) -> ScenePlan:
        body = body_of(CollisionShape(Sphere(per_scene(radii)), material=indices(0)))
        frictions = PhysicalMaterial(per_scene(radii), literal(0.1), literal(0))
        return dataclasses.replace(
            two(),
            num_scenes=4,
            entities=(entity("ball", pose(0, 0, 1), body, scenes),),
            physical_materials=(frictions,),
        )

    paths = [one.path for one in diff_plans(ball((0, 1), 1, 2), ball((1, 2), 2, 3))]
    assert paths == ["scene_idxs"]
    found = diff_plans(ball((0, 1), 1, 2), ball((1, 2), 1, 2))
    assert [(one.path, one.scene_count) for one in found] == [
        ("scene_idxs", None),
        ("collisions[0].radius", 1),
        ("collisions[0].material.static_friction", 1),
    ]


def test_entities_that_share_no_scene_differ_in_their_scenes_alone() -> None:
    def ball(scene: int, **more: Any) -> ScenePlan:
        body = solid(Sphere(constant(0.1 + scene)), **more)
        return dataclasses.replace(two(), entities=(entity("ball", pose(0, 0, 1), body, (scene,)),))

    found = diff_plans(ball(0), ball(1, mass=constant(1)))
    assert [(one.path, one.a, one.b) for one in found] == [("scene_idxs", "scene 0", "scene 1")]


def test_more_scenes_are_one_difference_for_what_is_in_all_of_them() -> None:
    def plan(count: int) -> ScenePlan:
        ball = Entity("ball", tuple(range(count)), pose(0, 0, 1), (solid(Sphere(constant(0.1))),))
        return dataclasses.replace(two(), num_scenes=count, entities=(ball,))

    assert [one.path for one in diff_plans(plan(2), plan(4))] == ["num_scenes"]


def test_materials_are_told_by_what_they_hold() -> None:
    def plan(static: float, color: tuple[float, ...] | None) -> ScenePlan:
        seen = VisualShape(Sphere(constant(0.1)), material=None if color is None else indices(0))
        body = body_of(CollisionShape(Sphere(constant(0.1)), material=indices(0)), visuals=(seen,))
        return dataclasses.replace(
            two(),
            entities=(entity("ball", pose(0, 0, 1), body),),
            physical_materials=(rubbing(static, 0.1, 0),),
            visual_materials=() if color is None else (look(base_color=color),),
        )

    red, blue = (1.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)
    assert diff_plans(plan(0.5, red), plan(0.6, blue)) == [
        Difference("changed", "entities", "ball", "collisions[0].material.static_friction", "0.5", "0.6", 2),
        Difference(
            "changed", "entities", "ball", "visuals[0].material.base_color",
            "#ff0000", "#0000ff", 2,
        ),
    ]  # fmt: skip
    (one,) = diff_plans(plan(0.5, red), plan(0.5, None))
    assert (one.path, one.a, one.b) == ("visuals[0].material.base_color", "#ff0000", None)


def drawn(node: Any, **more: Any) -> ScenePlan:
    rows = np.array([[0, 0, 1, 1, 0, 0, 0], [0, 0, 2, 1, 0, 0, 0]], dtype=np.float64)
    ball = entity("ball", recalled(rows, node), solid(Sphere(constant(0.1))))
    return dataclasses.replace(two(), entities=(ball,), **more)


def evenly(high: float) -> Drawn:
    return Drawn("uniform", (0, high), (), Key("draws", "u", ""))


def standing(height: Any) -> Posed:
    return Posed(Stacked((0, 0, height)), (1, 0, 0, 0))


def test_what_a_reset_draws_otherwise_is_a_difference_at_reset() -> None:
    (one,) = diff_plans(drawn(standing(evenly(1))), drawn(standing(evenly(2))))
    assert (one.path, one.a, one.b) == ("pose.p", "[0, 0, 0 … 1] at reset", "[0, 0, 0 … 2] at reset")
    assert one.scene_count == 2
    other = dataclasses.replace(evenly(1), key=Key("draws", "v", ""))
    (one,) = diff_plans(drawn(standing(evenly(1))), drawn(standing(other)))
    assert (one.a, one.b) == ("[0, 0, 0 … 1] at reset", "[0, 0, 0 … 1] at reset, drawn differently")


def test_recipes_are_compared_as_they_are_written() -> None:
    inline, shared = drawn(standing(evenly(1))), drawn(standing(Shared("u")), draws=(("u", evenly(1)),))
    (one,) = diff_plans(inline, shared)
    assert (one.path, one.a) == ("pose.p", "[0, 0, 0 … 1] at reset")
    assert one.b == "[0, 0, 0 … 1] at reset, drawn differently"
    assert diff_plans(shared, drawn(standing(Shared("u")), draws=(("u", evenly(1)),))) == []


def test_shared_draws_are_compared_where_they_are_read() -> None:
    shared = drawn(standing(Shared("u")), draws=(("u", evenly(1)),))
    (one,) = diff_plans(shared, dataclasses.replace(shared, draws=(("u", evenly(3)),)))
    assert (one.section, one.path, one.b) == ("entities", "pose.p", "[0, 0, 0 … 3] at reset")
    through = drawn(standing(Shared("v")), draws=(("u", evenly(1)), ("v", Shared("u"))))
    (one,) = diff_plans(through, dataclasses.replace(through, draws=(("u", evenly(3)), ("v", Shared("u")))))
    assert (one.path, one.b) == ("pose.p", "[0, 0, 0 … 3] at reset")
    assert diff_plans(shared, dataclasses.replace(shared, draws=(*shared.draws, ("w", evenly(9))))) == []


def test_the_part_of_a_pose_that_is_drawn_otherwise_is_named() -> None:
    turned = Posed(Stacked((0, 0, evenly(1))), Chosen(((1, 0, 0, 0), (0, 1, 0, 0)), None, Key("entities", "b", "q")))
    (one,) = diff_plans(drawn(standing(evenly(1))), drawn(turned))
    assert (one.path, one.a, one.b) == ("pose.q", "as built", "[1, 0, 0, 0] | [0, 1, 0, 0] at reset")


def test_a_material_that_a_reset_draws_otherwise_is_a_difference() -> None:
    def plan(high: float) -> ScenePlan:
        friction = PhysicalMaterial(recalled(np.array([0.5]), evenly(high)), literal(0.1), literal(0))
        body = body_of(CollisionShape(Sphere(constant(0.1)), material=indices(0)))
        entities = (entity("ball", pose(0, 0, 1), body),)
        return dataclasses.replace(two(), entities=entities, physical_materials=(friction,))

    (one,) = diff_plans(plan(1), plan(2))
    assert (one.path, one.a, one.b) == (
        "collisions[0].material.static_friction",
        "0 … 1 at reset",
        "0 … 2 at reset",
    )


def test_what_seldom_differs_after_a_reset_is_seen() -> None:
    often = Chosen((1, 2), (0.97, 0.03), Key("entities", "ball", "pose.p"))
    (one,) = diff_plans(drawn(standing(1)), drawn(standing(often)))
    assert one.b == "[0, 0, 1] | [0, 0, 2] at reset"


def test_a_friction_force_is_told_by_its_key() -> None:
    def plan(force: float) -> ScenePlan:
        joint = {"name": "slide", "type": "prismatic", "friction_force": force}
        shapes = [{"type": "box", "half_size": [0.1, 0.1, 0.1]}]
        root = {"name": "rail", "shapes": shapes, "children": [{"name": "cart", "shapes": shapes, "joint": joint}]}
        return compile_scene({"scenecc": 1, "entities": {"rig": {"root": root}}})

    (found,) = diff_plans(plan(5), plan(6))
    assert (found.path, found.a, found.b) == ("links.cart.joint.friction_force", "5", "6")
