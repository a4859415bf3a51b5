"""What differs between the scenes of an object, by the names of a scene file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scenecc.diagnostics.diagnostic import Origin
from scenecc.inspect import VaryingField
from scenecc.inspect.varying import entity_fields
from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionShape,
    ConvexMesh,
    Entity,
    Inertial,
    Physics,
    ScenePlan,
    Sphere,
    Value,
    VisualShape,
    constant,
    per_scene,
    varying,
)
from scenecc.plan.body import AssetFile, PhysicalMaterial, VisualMaterial
from scenecc.variation.bounds import ValueBounds
from scenecc.variation.nodes import Drawn, Key

SCENES = (0, 1, 2)
HERE = [0, 0, 1, 1, 0, 0, 0]


def never() -> np.ndarray:
    raise AssertionError("nothing is drawn")


def between(low: float, high: float, **more: object) -> Value:
    return varying(never, never, SCENES, bounds=lambda: ValueBounds(None, low, high, True), **more)  # type: ignore[arg-type]


def differing(structure: BodyStructure, *, pose: Value | None = None, **tables: object) -> dict[str, str]:
    entity = Entity("thing", SCENES, pose or constant(HERE), (structure,))
    plan = ScenePlan("plan", 3, (entity,), Physics(), **tables)  # type: ignore[arg-type]
    return {field.field: field.values for field in entity_fields(entity, plan).varying}


BOX = CollisionShape(Box(constant([1, 1, 1])))


def test_equal_values_do_not_vary() -> None:
    entity = Entity("thing", SCENES, constant(HERE), (BodyStructure("dynamic", (BOX,), mass=constant(2)),))
    fields = entity_fields(entity, ScenePlan("plan", 3, (entity,), Physics()))
    assert (fields.count, fields.varying) == (4, ())


def test_varying_fields_are_named_as_in_the_file_without_drawing() -> None:
    origin = Origin("scene.yaml", ("entities", "thing", "shapes", 0))
    shape = Box(varying(never, never, SCENES, bounds=lambda: ValueBounds(None, (1, 1, 1), (2, 2, 2), True)))
    structure = BodyStructure(
        "dynamic",
        (CollisionShape(shape, density=between(1, 5), origin=origin),),
        (VisualShape(shape, origin=origin),),
        mass=between(0.5, 2),
        disable_gravity=per_scene([True, False, False], "bool"),
        inertial=Inertial(between(1, 2), constant(HERE), constant([1, 1, 1])),
    )
    assert differing(structure) == {
        "shapes[0].half_size": "1 … 2 each",
        "shapes[0].density": "1 … 5",
        "mass": "0.5 … 2",
        "gravity": "false | true",
        "inertial.mass": "1 … 2",
    }


def test_varying_shapes_of_a_plan_object_are_numbered() -> None:
    bits = per_scene([[1, 1, 0, 0], [2, 1, 0, 0], [2, 1, 0, 0]], "int64")
    structure = BodyStructure("dynamic", (BOX, CollisionShape(Sphere(between(1, 2)), collision_groups=bits)))
    assert differing(structure) == {
        "collisions[1].radius": "1 … 2",
        "collisions[1].collision_bits": "[1, 1, 0, 0] | [2, 1, 0, 0]",
    }


def test_a_pose_varies_in_position_or_rotation() -> None:
    body = BodyStructure("static", (BOX,))
    moved = per_scene([[x, 0, 1, 1, 0, 0, 0] for x in range(3)])
    turned = per_scene([[0, 0, 1, 1, 0, 0, 0], [0, 0, 1, 0, 1, 0, 0], [0, 0, 1, 0, 0, 1, 0]])
    assert differing(body, pose=moved) == {"pose.p": "[0, 0, 1] | [1, 0, 1] | [2, 0, 1]"}
    assert list(differing(body, pose=turned)) == ["pose.q"]
    low, high = (0, 0, 1, -1, 0, 0, -1), (0, 2, 1, 1, 0, 0, 1)
    drawn = varying(never, never, SCENES, bounds=lambda: ValueBounds(None, low, high, True))
    assert differing(body, pose=drawn) == {"pose.p": "[0, 0 … 2, 1]", "pose.q": "[-1 … 1, 0, 0, -1 … 1]"}


def test_bounds_of_samples_say_about() -> None:
    computed = varying(never, never, SCENES, bounds=lambda: ValueBounds(None, 0.5, 2, exact=False))
    assert differing(BodyStructure("dynamic", (BOX,), mass=computed)) == {"mass": "about 0.5 … 2"}


def test_a_uniform_rotation_is_shown_as_any() -> None:
    low, high = (0, 0, 0, -1, -1, -1, -1), (0, 0, 0, 1, 1, 1, 1)
    turned = varying(never, never, SCENES, bounds=lambda: ValueBounds(None, low, high, True))
    assert differing(BodyStructure("static", (BOX,)), pose=turned) == {"pose.q": "any rotation"}


def test_samples_are_shown_of_a_value_without_finite_bounds() -> None:
    loose = varying(
        lambda: np.arange(3.0),
        lambda: np.arange(3.0),
        SCENES,
        bounds=lambda: ValueBounds(None, -np.inf, np.inf, exact=False),
    )
    structure = BodyStructure("dynamic", (BOX,), linear_damping=loose)
    assert differing(structure) == {"linear_damping": "0 | 1 | 2"}


def test_fields_that_a_reset_draws_are_marked() -> None:
    node = Drawn("uniform", (0.0, 1.0), (3,), Key("entities", "thing", "linear_velocity"))
    velocity = varying(never, never, SCENES, bounds=lambda: ValueBounds(None, (0, 0, 0), (1, 1, 1), True), recipe=node)
    structure = BodyStructure("dynamic", (BOX,), linear_velocity=velocity, mass=between(1, 2))
    entity = Entity("thing", SCENES, constant(HERE), (structure,))
    assert entity_fields(entity, ScenePlan("plan", 3, (entity,), Physics())).varying == (
        VaryingField("mass", "1 … 2", at_reset=False),
        VaryingField("linear_velocity", "0 … 1 each", at_reset=True),
    )


def test_materials_vary_by_field() -> None:
    physical = (
        PhysicalMaterial(constant(1), constant(0.5), constant(0)),
        PhysicalMaterial(constant(0.1), constant(0.5), constant(0)),
    )
    visual = (VisualMaterial(base_color=constant([1, 0, 0, 1])), VisualMaterial(base_color=constant([0, 0, 1, 1])))
    index = per_scene([0, 1, 0], "int64")
    structure = BodyStructure(
        "dynamic",
        (CollisionShape(Box(constant([1, 1, 1])), material=index),),
        (VisualShape(Box(constant([1, 1, 1])), material=index),),
    )
    assert differing(structure, physical_materials=physical, visual_materials=visual) == {
        "collisions[0].material.static_friction": "1 | 0.1",
        "visuals[0].material.base_color": "#ff0000 | #0000ff",
    }


def test_one_material_may_vary_by_itself() -> None:
    physical = (PhysicalMaterial(between(0.1, 1), constant(0.1), constant(0)),)
    structure = BodyStructure("dynamic", (CollisionShape(Box(constant([1, 1, 1])), material=constant(0, "int64")),))
    assert differing(structure, physical_materials=physical) == {
        "collisions[0].material.static_friction": "0.1 … 1",
    }


def test_varying_files_are_shown_by_name() -> None:
    files = (AssetFile("a.obj", Path("a.obj")), AssetFile("b.obj", Path("b.obj")))
    mesh = ConvexMesh(per_scene([0, 1, 0], "int64"), constant([1, 1, 1]))
    assert differing(BodyStructure("static", (CollisionShape(mesh),)), files=files) == {
        "collisions[0].file": "a.obj | b.obj"
    }


@pytest.mark.parametrize("count", [1, 2])
def test_variants_are_shown_as_pick(count: int) -> None:
    entity = Entity(
        "thing", SCENES, constant(HERE), (BodyStructure("static", (BOX,)),) * 2, pick=per_scene([0, 1, 0], "int64")
    )
    fields = entity_fields(entity, ScenePlan("plan", 3, (entity,) * count, Physics()))
    assert fields.varying == (VaryingField("pick", "0 | 1", at_reset=False),)
