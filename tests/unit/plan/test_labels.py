"""What a scene file calls the fields of a plan."""

from __future__ import annotations

from plugins.sample_plans import solid

from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import CollisionShape, Sphere, constant
from scenecc.plan.display import field_path, item_path, shape_path


def test_a_field_is_called_as_in_a_file() -> None:
    assert field_path("", "disable_gravity") == "gravity"
    assert field_path("shapes[0]", "geometry") == "shapes[0]"
    assert field_path("shapes[0]", "radius") == "shapes[0].radius"


def test_a_shape_is_where_it_was_written() -> None:
    origin = Origin("a.yaml", ("entities", "ball", "shapes", 2))
    assert shape_path(origin, "collisions[0]") == "shapes[2]"
    assert shape_path(None, "collisions[0]") == "collisions[0]"
    shape = CollisionShape(Sphere(constant(0.1)), origin=origin)
    assert item_path("collisions", 0, shape, count=1) == "shapes[2]"


def test_a_single_structure_is_the_entity_and_one_of_several_a_variant() -> None:
    assert item_path("", 0, solid(Sphere(constant(0.1))), count=1) == ""
    assert item_path("", 1, solid(Sphere(constant(0.1))), count=2) == "variants[1]"
