"""Bodies, their defaults and their materials, as the plan holds them."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from plugins.expectations import GOOD
from plugins.sample_plans import look
from plugins.structures import body_of
from unit.lower.scenes import compiled, entity

import scenecc
from scenecc.lower.field_types import BODY_FIELDS
from scenecc.plan import CoacdParams, ConvexParts
from scenecc.plan.body import VisualMaterial
from scenecc.spec.body import MOTION_AXES, BodySpec

SPHERE: dict[str, Any] = {"type": "sphere", "radius": 0.1}


def density_of(shape: dict[str, Any], **top: Any) -> float | None:
    body = {key: top.pop(key) for key in ("material", "density") if key in top}
    value = body_of(entity(compiled({**body, "shapes": [{**SPHERE, **shape}]}, **top))).collisions[0].density
    return None if value is None else float(value.data[0])


@pytest.mark.parametrize("given", list(itertools.product([False, True], repeat=4)), ids=str)
def test_density_own_then_material_then_body(given: tuple[bool, bool, bool, bool]) -> None:
    """A shape's own, its material's (its own material, else the body's), the body's, else SAPIEN's."""
    own, of_material, of_body_material, of_body = given
    shape: dict[str, Any] = {"density": 1} if own else {}
    top: dict[str, Any] = {"density": 4} if of_body else {}
    if of_material:
        shape["material"] = {"physical": {"density": 2}}
    if of_body_material:
        top["material"] = {"physical": {"density": 3}}
    expected = [value for value, there in zip((1, 2, 3, 4), given, strict=True) if there]
    assert density_of(shape, **top) == (expected[0] if expected else None)


def test_a_material_without_a_density_hides_the_bodys_material() -> None:
    shape = {"material": {"physical": {"restitution": 0}}}
    assert density_of(shape, material={"physical": {"density": 3}}, density=4) == 4


def look_of(shape: dict[str, Any], **body: Any) -> VisualMaterial | None:
    plan = compiled({**body, "shapes": [{**SPHERE, **shape}]})
    value = body_of(entity(plan)).visuals[0].material
    return None if value is None else plan.visual_materials[int(value.data[0])]


RED, GREEN, BLUE, GREY = [1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0.5]


@pytest.mark.parametrize("given", list(itertools.product([False, True], repeat=4)), ids=str)
def test_colour_own_then_material_then_body_then_the_bodys_material(given: tuple[bool, bool, bool, bool]) -> None:
    own, of_material, of_body, of_body_material = given
    shape: dict[str, Any] = {"color": RED} if own else {}
    body: dict[str, Any] = {"color": BLUE} if of_body else {}
    if of_material:
        shape["material"] = {"visual": {"base_color": GREEN}}
    if of_body_material:
        body["material"] = {"visual": {"base_color": GREY}}
    expected = [color for color, there in zip((RED, GREEN, BLUE, GREY), given, strict=True) if there]
    seen = look_of(shape, **body)
    assert seen == (look(base_color=(*expected[0], 1)) if expected else None)


def test_a_colour_leaves_the_rest_of_the_material() -> None:
    material = {"visual": {"base_color": GREEN, "roughness": 0.25, "metallic": 1}}
    assert look_of({"material": material, "color": RED}) == look(base_color=(1, 0, 0, 1), roughness=0.25, metallic=1)
    assert look_of({"material": {"visual": {"roughness": 0.25}}}, color=RED) == look(
        base_color=(1, 0, 0, 1), roughness=0.25
    )


@pytest.mark.parametrize(
    ("color", "expected"),
    [
        ([1, 0.5, 0], (1, 0.5, 0, 1)),
        ([1, 0.5, 0, 0.25], (1, 0.5, 0, 0.25)),
        ("#ff8000", (1, 0.21586050011389926, 0, 1)),
        ("#FF800040", (1, 0.21586050011389926, 0, 64 / 255)),
        ("#000000", (0, 0, 0, 1)),
    ],
    ids=str,
)
def test_colours(color: Any, expected: tuple[float, ...]) -> None:
    assert look_of({"color": color}) == look(base_color=expected)


def test_nothing_said_is_no_material() -> None:
    plan = compiled()
    body = body_of(entity(plan))
    assert body.collisions[0].material is None
    assert body.visuals[0].material is None
    assert plan.physical_materials == plan.visual_materials == ()


def test_equal_materials_are_one_row() -> None:
    inline = {"physical": {"static_friction": 0.5, "dynamic_friction": 0.5, "restitution": 0}}
    materials = {"a": inline, "b": inline}
    shapes = [{**SPHERE, "material": name} for name in ("a", "b", "a")] + [{**SPHERE, "material": inline}]
    assert len(compiled({"shapes": shapes}, materials=materials).physical_materials) == 1


@pytest.mark.parametrize("missing", ["static_friction", "dynamic_friction", "restitution"])
@pytest.mark.parametrize("default", [None, {"static_friction": 0.9, "dynamic_friction": 0.8, "restitution": 0.7}])
def test_what_a_material_leaves_out_is_the_default_materials(missing: str, default: Any) -> None:
    full = {"static_friction": 1.5, "dynamic_friction": 0.2, "restitution": 0.05}
    given = {key: value for key, value in full.items() if key != missing}
    top = {} if default is None else {"physics": {"default_material": default}}
    (row,) = compiled({"material": {"physical": given}}, **top).physical_materials
    sapiens = {"static_friction": 0.3, "dynamic_friction": 0.3, "restitution": 0.1}
    expected = {**full, missing: (default or sapiens)[missing]}
    assert tuple(value.numbers()[0] for value in row.values()) == tuple(expected.values())


KNOB_VALUES: dict[str, tuple[Any, Any]] = {
    "mass": (2, 2.0),
    "com": ([0.1, 0, 0.2], [0.1, 0.0, 0.2]),
    "gravity": (False, True),
    "locked_axes": (["rz", "x"], [True, False, False, False, False, True]),
    "linear_velocity": ([1, 2, 3], [1.0, 2.0, 3.0]),
    "angular_velocity": ([1, 2, 3], [1.0, 2.0, 3.0]),
    "linear_damping": (0, 0.0),
    "angular_damping": (0.5, 0.5),
    "max_linear_velocity": (1, 1.0),
    "max_angular_velocity": (1, 1.0),
    "max_depenetration_velocity": (1, 1.0),
    "max_contact_impulse": (1, 1.0),
    "sleep_threshold": (0, 0.0),
    "solver_position_iterations": (7, 7),
    "solver_velocity_iterations": (0, 0),
    "collision_bits": ([1, 2, 3, 4], [1, 2, 3, 4]),
    "visibility": (0.5, 0.5),
    "shading_mode": (3, 3),
}


def test_every_knob_has_a_value_here() -> None:
    assert set(KNOB_VALUES) == set(BODY_FIELDS) <= set(BodySpec.model_fields)


@pytest.mark.parametrize("name", KNOB_VALUES)
def test_a_knob_is_in_its_field_and_alone(name: str) -> None:
    given, expected = KNOB_VALUES[name]
    body = body_of(entity(compiled({name: given})))
    field = BODY_FIELDS[name][0]
    value = getattr(body, field)
    assert value.data.tolist() == [expected]
    assert (
        value.data.dtype.kind
        == {bool: "b", int: "i", float: "f"}[type(expected[0] if isinstance(expected, list) else expected)]
    )
    others = {BODY_FIELDS[other][0] for other in BODY_FIELDS} - {field}
    assert all(getattr(body, other) is None for other in others), "what the file leaves out calls no setter"


def test_gravity_true_is_said_too() -> None:
    value = body_of(entity(compiled({"gravity": True}))).disable_gravity
    assert value is not None
    assert value.data.tolist() == [False]


def test_all_axes_in_sapiens_order() -> None:
    for i, axis in enumerate(MOTION_AXES):
        value = body_of(entity(compiled({"locked_axes": [axis]}))).locked_motion_axes
        assert value is not None
        assert value.data[0].tolist() == [j == i for j in range(6)]


def test_lists_of_shapes() -> None:
    body = body_of(
        entity(
            compiled(
                {
                    "visuals": [{**SPHERE, "name": "v"}],
                    "collisions": [{**SPHERE, "density": 3}],
                    "shapes": [{**SPHERE, "name": "s1", "density": 1}, {**SPHERE, "name": "s2", "density": 2}],
                }
            )
        )
    )
    assert [shape.name for shape in body.visuals] == ["s1", "s2", "v"]
    assert [shape.density.data[0] for shape in body.collisions if shape.density] == [1, 2, 3]


def test_numbers_come_through_untouched() -> None:
    body = body_of(entity(compiled({"mass": 0.1, "shapes": [{"type": "box", "half_size": [0.1, 1 / 3, 2e-3]}]})))
    assert body.mass is not None
    assert body.mass.data[0] == 0.1
    assert body.collisions[0].geometry.half_size.data.tolist() == [[0.1, 1 / 3, 2e-3]]  # type: ignore[union-attr]


@pytest.mark.parametrize("params", [None, {}, {"threshold": 0.1, "seed": 3}], ids=str)
def test_decomposition(params: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(GOOD)
    shape: dict[str, Any] = {"type": "convex_parts", "file": "assets/pair.obj", "decomposition": "coacd"}
    if params is not None:
        shape["decomposition_params"] = params
    (found,) = body_of(entity(compiled({"shapes": [], "collisions": [shape]}))).collisions
    assert isinstance(found.geometry, ConvexParts)
    assert found.geometry.coacd == CoacdParams(**(params or {}))


def test_a_body_without_shapes_is_built_where_that_is_written_out() -> None:
    empty = {"shapes": [], "body_type": "static", "pose": [1, 2, 3]}
    weighs = {"shapes": [], "inertial": {"mass": 2, "inertia": [0.1, 0.1, 0.1]}, "gravity": False}
    scene = {"scenecc": 1, "entities": {"mark": empty, "mass": weighs, "lost": {"shapes": []}, "forgotten": {}}}
    found = {(one.code, str(one.path)) for one in scenecc.validate(scene)}
    assert found == {("SC502", "entities.lost"), ("SC501", "entities.forgotten")}
    kept = {name: body for name, body in scene["entities"].items() if name in {"mark", "mass"}}
    with scenecc.load_scene({**scene, "entities": kept}, render=False) as batch:
        mark: Any
        mass: Any
        mark, mass = (batch.entities[name].objs[0] for name in ("mark", "mass"))
        assert mark.pose.p.tolist() == [1, 2, 3]
        assert mass.components[-1].mass == 2
        assert not mark.components[-1].collision_shapes
