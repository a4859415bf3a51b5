"""Scenes whose values are drawn: each as it is among all, and what was drawn is what is there."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import built
from plugins.structures import body_of
from unit.backends.drawn import heap, value

from scenecc.plan import BodyStructure, Box, CollisionShape, Entity, Physics, ScenePlan, constant, per_scene
from scenecc.plan.body import PhysicalMaterial
from scenecc.variation.nodes import Chosen, Drawn, Key, Posed

SCENES = 6


@pytest.mark.parametrize("chosen", [[0], [5], [4, 1], [0, 2, 3]], ids=str)
def test_a_scene_is_the_same_alone_and_among_all(chosen: list[int]) -> None:
    some, every = built(heap(SCENES, seed=11), scene_idxs=chosen), built(heap(SCENES, seed=11))
    among_all = [every.scenes[index] for index in sorted(chosen)]
    for ours, theirs in zip(some.scenes, among_all, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(some.scenes, among_all)


def test_scenes_of_a_small_batch_are_those_of_a_large_one() -> None:
    few, many = built(heap(2, seed=5)), built(heap(9, seed=5))
    for ours, theirs in zip(few.scenes, many.scenes, strict=False):
        assert_same_scene(ours, theirs)


@pytest.mark.parametrize("num_scenes", [1, 3])
def test_what_is_drawn_alike_everywhere_is_built_as_drawn(num_scenes: int) -> None:
    """One row in all, whose bounds are others than its numbers."""
    every = tuple(range(num_scenes))
    size = value(Chosen(((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)), (0.0, 1.0), Key("entities", "box", "size")), every, 3, 0)
    place = Posed(Drawn("uniform", ((-1, -1, 1), (1, 1, 2)), (3,), Key("entities", "box", "p")), (1.0, 0.0, 0.0, 0.0))
    shape = CollisionShape(Box(size), pose=value(place, every, 3, 0), density=constant(200))
    box = Entity("box", every, value(place, every, 3, 0), (BodyStructure("dynamic", (shape,)),))
    batch = built(ScenePlan("alike", num_scenes, (box,), Physics()))
    assert (batch.entities["box"].pose == box.pose.data.astype(np.float32)).all()
    component: Any = batch.entities["box"].objs[0].components[0]
    assert np.allclose(component.collision_shapes[0].half_size, [0.4, 0.5, 0.6])


def frictions(num_scenes: int) -> ScenePlan:
    """Two boxes with one drawn material, one of them in some scenes, and one whose material itself is picked."""
    every, some = tuple(range(num_scenes)), tuple(range(0, num_scenes, 2))
    names = ("static_friction", "dynamic_friction", "restitution")
    rng = np.random.default_rng(0)
    table = {name: rng.uniform(0.1, 0.9, num_scenes) for name in names}

    def rubber(where: tuple[int, ...]) -> PhysicalMaterial:
        return PhysicalMaterial(
            per_scene(table[names[0]][list(where)]), constant(0.1), per_scene(table[names[2]][list(where)])
        )

    materials = (rubber(every), rubber(some), PhysicalMaterial(constant(0.9), constant(0.8), constant(0.0)))
    picked = per_scene([2 * (index % 2) for index in every], "int64")

    def box(name: str, where: tuple[int, ...], material: Any, x: float) -> Entity:
        shape = CollisionShape(Box(constant([0.1] * 3)), material=material)
        return Entity(name, where, constant([x, 0, 1, 1, 0, 0, 0]), (BodyStructure("dynamic", (shape, shape)),))

    entities = (
        box("all", every, constant(0, "int64"), 0),
        box("some", some, constant(1, "int64"), 1),
        box("either", every, picked, 2),
    )
    return ScenePlan("frictions", num_scenes, entities, Physics(), physical_materials=materials)


@pytest.mark.parametrize("chosen", [None, [4, 1]])
def test_drawn_materials(chosen: list[int] | None) -> None:
    plan = frictions(SCENES)
    batch = built(plan, scene_idxs=chosen)
    for name, entity in batch.entities.items():
        body = next(each for each in plan.entities if each.name == name)
        for index, obj in zip(entity.scene_idxs, entity.objs, strict=True):
            row = body.scene_idxs.index(index)
            material = body_of(body).collisions[0].material
            assert material is not None
            wanted = plan.physical_materials[int(material.row(row))].row(row)
            component: Any = obj.components[0]
            for shape in component.collision_shapes:
                found = shape.physical_material
                assert found.static_friction == np.float32(wanted.static_friction)
                assert found.dynamic_friction == np.float32(wanted.dynamic_friction)
                assert found.restitution == np.float32(wanted.restitution)


def test_materials_alike_are_one_object() -> None:
    plan = frictions(SCENES)
    same = PhysicalMaterial(per_scene([0.5, 0.6] * 3), constant(0.1), constant(0.0))
    batch = built(replace(plan, physical_materials=(same, *plan.physical_materials[1:])))
    components: Any = [obj.components[0] for obj in batch.entities["all"].objs]
    shapes: Any = [component.collision_shapes[0].physical_material for component in components]
    shapes[0].static_friction = 0.125
    assert [material.static_friction == 0.125 for material in shapes] == [True, False] * 3
