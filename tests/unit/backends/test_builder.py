"""The tables cover the plan's unions, fresh objects hold what setters are skipped for, the builder is SAPIEN's."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, get_args

import numpy as np
import pytest
import sapien
from fidelity.hand import component
from plugins.structures import body_of
from sapien import physx

from scenecc.backends.sapien import instantiate
from scenecc.backends.sapien.assets import Resources
from scenecc.backends.sapien.builder import BatchActorBuilder
from scenecc.backends.sapien.geometry import COLLISION_SHAPES, VISUAL_SHAPES
from scenecc.backends.sapien.properties import (
    BODY_PROPERTIES,
    COLLISION_GROUPS,
    RENDER_PROPERTIES,
    SHAPE_POSE,
    SHAPE_PROPERTIES,
)
from scenecc.diagnostics import Sink
from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionGeometry,
    CollisionShape,
    ScenePlan,
    VisualGeometry,
    constant,
)


def test_the_shape_tables_cover_every_geometry() -> None:
    """A new shape in the plan without a row in each table fails here."""
    assert set(COLLISION_SHAPES) == set(get_args(CollisionGeometry))
    assert set(VISUAL_SHAPES) == set(get_args(VisualGeometry))


def test_the_property_tables_cover_every_field() -> None:
    """A new field of a body or a shape that nothing sets or reads fails here."""
    body = {f.name for f in fields(BodyStructure)}
    elsewhere = {"body_type", "collisions", "visuals", "mass", "com", "inertial"}
    elsewhere |= {"collision_groups", "shapeless", "origin"}
    assert body == set(BODY_PROPERTIES.by_field) | set(RENDER_PROPERTIES.by_field) | elsewhere
    shape = {f.name for f in fields(CollisionShape)}
    assert shape == set(SHAPE_PROPERTIES.by_field) | {"geometry", "pose", "material", "collision_groups", "origin"}


SHAPES = {
    "box": lambda m: physx.PhysxCollisionShapeBox([1, 1, 1], m),
    "sphere": lambda m: physx.PhysxCollisionShapeSphere(1, m),
    "capsule": lambda m: physx.PhysxCollisionShapeCapsule(1, 1, m),
    "cylinder": lambda m: physx.PhysxCollisionShapeCylinder(1, 1, m),
    "plane": physx.PhysxCollisionShapePlane,
    "convex": lambda m: physx.PhysxCollisionShapeConvexMesh(np.vstack([np.eye(3), np.zeros((1, 3))]), [1, 1, 1], m),
    "triangles": lambda m: physx.PhysxCollisionShapeTriangleMesh(np.eye(3), [[0, 1, 2]], [1, 1, 1], m),
}


@pytest.mark.parametrize("changed", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_a_fresh_shape_holds_the_defaults_that_are_not_set_again(name: str, changed: bool) -> None:
    config = physx.get_shape_config()
    if changed:
        physx.set_shape_config(contact_offset=0.05, rest_offset=0.02)
    try:
        made = SHAPES[name](physx.get_default_material())
    finally:
        physx.set_shape_config(config)
    assert made.collision_groups == list(COLLISION_GROUPS.default)
    assert made.local_pose.__getstate__() == SHAPE_POSE.default
    for field, knob in SHAPE_PROPERTIES.by_field.items():
        if knob.default is not None:
            assert getattr(made, knob.get) == knob.default, field


def test_a_fresh_body_holds_the_defaults_that_are_not_set_again() -> None:
    config = physx.get_body_config()
    physx.set_body_config(3, 4, 0.5)
    try:
        made = physx.PhysxRigidDynamicComponent()
    finally:
        physx.set_body_config(config)
    for field, knob in BODY_PROPERTIES.by_field.items():
        if knob.default is not None:
            assert np.array_equal(getattr(made, knob.get), knob.default), field


def builder_of(plan: ScenePlan, name: str) -> BatchActorBuilder:
    entity = next(e for e in plan.entities if e.name == name)
    rows = np.arange(plan.num_scenes)
    return BatchActorBuilder(entity, body_of(entity), rows, Resources(plan), rendered=False)


def test_a_batch_builder_is_an_actor_builder(plan: ScenePlan) -> None:
    """SAPIEN's own `build` works on it, for the row that is asked for."""
    builder = builder_of(plan, "cube")
    assert isinstance(builder, sapien.ActorBuilder)
    builder.row = 2
    scene = sapien.Scene([physx.PhysxCpuSystem()])
    entity: Any = builder.set_scene(scene).build()
    assert scene.entities == [entity]
    assert entity.name == "cube"
    assert entity.pose.p.tolist() == np.array([0.2, 0, 3], np.float32).tolist()
    assert len(entity.components[0].collision_shapes) == 2
    again: Any = builder.build_physx_component()
    assert again.mass == entity.components[0].mass
    assert builder_of(plan, "marker").build_physx_component() is None


@pytest.mark.parametrize("add", [lambda b: b.add_box_collision(), lambda b: b.add_convex_collision_from_file("x.obj")])
def test_shapes_cannot_be_added_to_a_batch_builder(add: Any, plan: ScenePlan) -> None:
    with pytest.raises(AttributeError):
        add(builder_of(plan, "cube"))


def test_shapes_are_never_shared_between_bodies(plan: ScenePlan) -> None:
    batch = instantiate(plan, Sink(), render=False)
    assert batch is not None
    components: list[Any] = [c for e in batch.entities.values() for o in e.objs for c in o.components]
    shapes = [shape for component in components for shape in component.collision_shapes]
    assert len(set(map(id, shapes))) == len(shapes) == 4 * 5


def test_materials_are_shared_as_in_a_script(plan: ScenePlan) -> None:
    batch = instantiate(plan, Sink(), render=False)
    assert batch is not None
    material = component(batch, "cube").collision_shapes[0].physical_material
    material.static_friction = 0.75
    other = component(batch, "cube", 3).collision_shapes[0].physical_material
    assert other.static_friction == 0.75


def test_values_are_rounded_once_to_float32(plan: ScenePlan) -> None:
    """float64 in the plan, float32 in the engine, nothing between."""
    third = 1 / 3
    entity = replace(
        plan.entities[1],
        pose=constant([third, 2 * third, third, 0.5, 0.5, 0.5, 0.5]),
        structures=(BodyStructure("dynamic", (CollisionShape(Box(constant([third, third, third]))),)),),
    )
    batch = instantiate(replace(plan, entities=(entity,)), Sink(), render=False)
    assert batch is not None
    assert batch.entities["cube"].objs[0].pose.p[0] == np.float32(third)
    assert component(batch, "cube").collision_shapes[0].half_size[0] == np.float32(third)


def test_a_quaternion_is_passed_untouched(plan: ScenePlan) -> None:
    almost = [0.7071068, 0, -0.7071068, 0.000004]
    entity = replace(plan.entities[1], pose=constant([0, 0, 0, *almost]))
    batch = instantiate(replace(plan, entities=(entity,)), Sink(), render=False)
    assert batch is not None
    assert batch.entities["cube"].objs[0].pose.q.tolist() == np.array(almost, np.float32).tolist()
