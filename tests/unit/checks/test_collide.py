"""Whether two bodies can touch, scene by scene and in many scenes."""

from __future__ import annotations

import time
from itertools import product

from plugins.nightly import assert_took
from plugins.plan_parts import INT
from plugins.sample_plans import indices

from scenecc.checks.physics import may_collide
from scenecc.plan import BodyStructure, CollisionShape, Entity, Sphere, Value, constant, per_scene

FREE, GHOST = (1, 1, 0, 0), (0, 0, 0, 0)


def body(groups: list[tuple[int, ...]] | None = None) -> BodyStructure:
    given = None if groups is None else per_scene(groups, "int64")
    return BodyStructure("dynamic", (CollisionShape(Sphere(constant(0.1))),), collision_groups=given)


def entity(name: str, scenes: tuple[int, ...], *bodies: BodyStructure, pick: Value | None = None) -> Entity:
    return Entity(name, scenes, constant([0.0, 0, 0, 1, 0, 0, 0]), bodies, pick)


def test_collision_groups_are_read_per_scene() -> None:
    a, b = body([FREE, GHOST, FREE]), body([GHOST, FREE, GHOST])
    for shift, expected in ((0, False), (1, True)):
        first = entity("a", (0, 1, 2), a)
        second = entity("b", tuple(scene + shift for scene in (0, 1, 2)), b)
        assert may_collide(first, a, second, b) is expected


def test_only_the_structure_of_the_scene_counts_for_collision() -> None:
    a, other, b = body(), body([GHOST]), body()
    picked = entity("a", (0, 1), a, other, pick=indices(1, 0))
    for scene, expected in ((0, False), (1, True), (2, False)):
        assert may_collide(picked, a, entity("b", (scene,), b), b) is expected


def test_constant_groups_collide_in_common_scenes() -> None:
    for groups, scenes in product((FREE, GHOST), ((0, 2), (1,))):
        a, b = body(), body([groups])
        expected = groups == FREE and scenes == (0, 2)
        assert may_collide(entity("a", (0, 2), a), a, entity("b", scenes, b), b) is expected


def test_one_colliding_pair_of_shapes_is_enough() -> None:
    ghost, free = (CollisionShape(Sphere(constant(0.1)), collision_groups=constant(one, INT)) for one in (GHOST, FREE))
    mixed, still = BodyStructure("dynamic", (ghost, free)), BodyStructure("dynamic", (ghost, ghost))
    for a, b, expected in ((mixed, mixed, True), (mixed, body(), True), (mixed, still, False), (still, body(), False)):
        assert may_collide(entity("a", (0,), a), a, entity("b", (0,), b), b) is expected


def test_collision_of_many_scenes_is_fast() -> None:
    count = 65_536
    a, b = body([GHOST] * (count - 1) + [FREE]), body([GHOST] * count)
    scenes = tuple(range(count))
    started = time.process_time()
    assert not may_collide(entity("a", scenes, a), a, entity("b", scenes, b), b)
    assert_took(time.process_time() - started, most=3)
