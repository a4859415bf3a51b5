"""Rules of physics over plans, without a document behind them too."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from plugins.expectations import GOOD
from plugins.sample_plans import indices, rubbing
from plugins.structures import body_of

from scenecc import validate
from scenecc.checks.physics import (
    BODY_RULES,
    NUMBER_RULES,
    check_physics,
    collision_key,
    may_collide,
)
from scenecc.plan import (
    BodyStructure,
    Box,
    CollisionShape,
    ConvexMesh,
    Entity,
    Inertial,
    Physics,
    Plane,
    ScenePlan,
    Sphere,
    TriangleMesh,
    VisualShape,
    constant,
    per_scene,
)
from scenecc.plan.body import AssetFile, groups_collide
from scenecc.plan.properties import CONTACT_OFFSET, REST_OFFSET

IDENTITY = constant([0, 0, 0, 1, 0, 0, 0])
BALL = CollisionShape(Sphere(constant(0.1)))
SEEN = VisualShape(Sphere(constant(0.1)))
FILES = (AssetFile("tetra.obj", GOOD / "assets/tetra.obj"),)
FIELD = CollisionShape(TriangleMesh(constant(0, np.int64), constant([1, 1, 1]), sdf=True))
PLANE = CollisionShape(Plane())


def entity(name: str, *structures: BodyStructure, scenes: tuple[int, ...] = (0, 1), pick: Any = None) -> Entity:
    return Entity(name, scenes, IDENTITY, structures, pick)


def plan(*entities: Entity, **keys: Any) -> ScenePlan:
    return ScenePlan("test", 2, entities, **{"physics": Physics(), "files": FILES, **keys})


def check(sink: Any, *entities: Entity, **keys: Any) -> None:
    check_physics(plan(*entities, **keys), {}, sink)


def body(*shapes: CollisionShape, kind: Any = "dynamic", **knobs: Any) -> BodyStructure:
    return BodyStructure(kind, tuple(shapes) or (BALL,), **knobs)


def test_default_materials_and_offsets_are_those_of_sapien() -> None:
    from sapien import physx

    config = physx.get_shape_config()
    assert (np.float32(CONTACT_OFFSET), np.float32(REST_OFFSET)) == (config.contact_offset, config.rest_offset)


def test_a_good_body_passes_every_rule(sink: Any) -> None:
    check(sink, entity("a", body(mass=constant(1.0))), entity("b", body(kind="static")))
    assert len({*BODY_RULES, *NUMBER_RULES}) == len(BODY_RULES) + len(NUMBER_RULES)


def test_findings_of_a_plan_without_origins_have_paths(sink: Any) -> None:
    check(sink, entity("a", BodyStructure("dynamic")), physical_materials=(rubbing(0.1, 0.2, 3),))
    sink.take("SC501", path="entities.a")
    sink.take("SC504", path="physical_materials[0]")
    sink.take("SC505", path="physical_materials[0]")


@pytest.mark.parametrize(
    ("structure", "code"),
    [
        (BodyStructure("none"), "SC501"),
        (BodyStructure("dynamic", (), (SEEN,)), "SC502"),
        (body(PLANE), "SC503"),
        (body(CollisionShape(TriangleMesh(constant(0, np.int64), constant([1, 1, 1])))), "SC508"),
        (BodyStructure("none", (BALL,), (SEEN,)), "SC115"),
        (body(kind="static", mass=constant(1.0)), "SC115"),
        (body(visibility=constant(0.5)), "SC115"),
        (body(CollisionShape(Sphere(constant(1.0)), density=constant(0.0)), mass=constant(1.0)), "SC510"),
        (body(inertial=Inertial(constant(1.0), IDENTITY, constant([1, 1, 5]))), "SC506"),
        (body(CollisionShape(Sphere(constant(1.0)), contact_offset=constant(0.1), rest_offset=constant(0.1))), "SC507"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_each_body_rule_reports_its_code(structure: BodyStructure, code: str, sink: Any) -> None:
    check(sink, entity("a", structure))
    sink.take(code)


@pytest.mark.parametrize("kind", ["static", "kinematic"])
def test_a_body_that_does_not_move_may_have_only_visuals(kind: Any, sink: Any) -> None:
    check(sink, entity("a", BodyStructure(kind, (), (SEEN,))))


LONG = CollisionShape(Box(constant([0.03, 0.03, 1e38])))
MESHED = CollisionShape(ConvexMesh(constant(0, np.int64), constant([1, 1, 1])))


@pytest.mark.parametrize("kind", ["dynamic", "kinematic"])
@pytest.mark.parametrize("others", [(), (BALL,), (MESHED,)], ids=["alone", "ball", "mesh"])
def test_one_huge_shape_makes_a_mass_invalid(kind: Any, others: tuple[CollisionShape, ...], sink: Any) -> None:
    check(sink, entity("a", body(*others, LONG, kind=kind)))
    sink.take("SC512")


def test_a_mesh_may_add_enough_mass_and_a_kinematic_body_needs_none(sink: Any) -> None:
    tiny = CollisionShape(Sphere(constant(1e-5)))
    check(sink, entity("a", body(tiny, MESHED)))
    check(sink, entity("b", body(tiny, kind="kinematic")))
    check(sink, entity("c", body(CollisionShape(Sphere(constant(1.0)), density=constant(0.0)), kind="kinematic")))


def test_a_purely_visual_body_may_have_an_inertial(sink: Any) -> None:
    given = Inertial(constant(1.0), IDENTITY, constant([1, 1, 1]))
    check(sink, entity("a", BodyStructure("dynamic", (), (SEEN,), inertial=given)))


@pytest.mark.parametrize("moments", [[1, 1, 2], [2, 1, 1], [1, 2, 1], [1, 1, 1e-6], [0.1, 0.2, 0.3]], ids=str)
def test_inertias_of_flat_and_long_bodies_are_valid(moments: list[float], sink: Any) -> None:
    """[1, 1, 2] is a disc, and 0.1 + 0.2 is not 0.3 to the bit."""
    check(sink, entity("a", body(inertial=Inertial(constant(1.0), IDENTITY, constant(moments)))))


@pytest.mark.parametrize("moments", sorted(set(itertools.permutations([1, 1, 2.01]))), ids=str)
def test_every_principal_moment_is_checked(moments: tuple[float, ...], sink: Any) -> None:
    check(sink, entity("a", body(inertial=Inertial(constant(1.0), IDENTITY, constant(list(moments))))))
    sink.take("SC506")


def test_one_bad_scene_of_many_is_reported(sink: Any) -> None:
    moments = per_scene([[1, 1, 1], [1, 1, 5]])
    check(sink, entity("a", body(inertial=Inertial(constant(1.0), IDENTITY, moments))))
    sink.take("SC506")
    offsets = CollisionShape(Sphere(constant(1.0)), contact_offset=per_scene([0.02, 0.03]), rest_offset=constant(0.025))
    check(sink, entity("b", body(offsets)))
    sink.take("SC507")


@pytest.mark.parametrize(
    ("physics", "shape", "bad"),
    [
        ({}, {}, False),
        ({}, {"rest": 0.0099}, False),
        ({}, {"rest": 0.01}, True),
        ({"contact_offset": 0.02}, {"rest": 0.015}, False),
        ({"rest_offset": 0.005}, {"contact": 0.005}, True),
        ({"rest_offset": 0.005}, {"contact": 0.006}, False),
        ({}, {"contact": 0.001}, False),
        ({"rest_offset": -1}, {"contact": 1e-6}, False),
    ],
    ids=str,
)
def test_missing_offsets_come_from_the_scene(physics: Any, shape: Any, bad: bool, sink: Any) -> None:
    given: dict[str, Any] = {f"{key}_offset": constant(value) for key, value in shape.items()}
    check(sink, entity("a", body(CollisionShape(Box(constant([1, 1, 1])), **given))), physics=Physics(**physics))
    if bad:
        sink.take("SC507")


def test_contact_offsets_of_the_scene_are_checked(sink: Any) -> None:
    check(sink, physics=Physics(contact_offset=0.001, rest_offset=0.001))
    sink.take("SC507", path="physics.rest_offset")
    check(sink, physics=Physics(rest_offset=0.5))
    sink.take("SC507", path="physics.rest_offset")


GROUPS = [None, [0, 0, 0, 0], [2, 2, 0, 0], [1, 1, 4, 7], [1, 1, 4, 8], [3, 1, 0, 0]]


@pytest.mark.parametrize(("a", "b"), list(itertools.product(GROUPS, repeat=2)), ids=str)
def test_may_collide_agrees_with_physx(a: Any, b: Any) -> None:
    """Two balls, one in the other: PhysX makes a contact exactly where they may collide."""
    import sapien
    from sapien import physx

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    for groups in (a, b):
        builder = scene.create_actor_builder()
        builder.collision_groups = groups or [1, 1, 0, 0]
        builder.add_sphere_collision(radius=0.5)
        builder.build()
    scene.step()
    touching = bool(scene.get_contacts())
    first = body(collision_groups=None if a is None else constant(a, np.int64))
    second = body(collision_groups=None if b is None else constant(b, np.int64))
    assert may_collide(entity("a", first), first, entity("b", second), second) == touching
    assert groups_collide(a or [1, 1, 0, 0], b or [1, 1, 0, 0]) == touching


def test_an_sdf_above_a_plane_is_reported_only_in_common_scenes(sink: Any) -> None:
    floor = body(PLANE, kind="static")
    check(sink, entity("f", body(FIELD)), entity("p", floor))
    sink.take("SC509")
    check(sink, entity("f", body(FIELD), scenes=(0,)), entity("p", floor, scenes=(1,)))
    # The field is picked in scene 0, the plane in scene 1.
    picking = (
        entity("f", body(FIELD), body(), pick=indices(0, 1)),
        entity("p", body(kind="static"), floor, pick=indices(0, 1)),
    )
    check(sink, *picking)
    check(sink, picking[0], entity("q", body(kind="static"), floor, pick=indices(1, 0)))
    sink.take("SC509")


def test_equal_collision_keys_collide_with_the_same_bodies() -> None:
    groups = [None, constant([0, 0, 0, 0], np.int64), constant([2, 2, 0, 0], np.int64)]
    made = [
        entity(f"{i}{scenes}", body(collision_groups=g), scenes=scenes)
        for i, g in enumerate(groups)
        for scenes in ((0,), (1,), (0, 1))
    ]
    for a, b in itertools.product(made, repeat=2):
        if collision_key(a, body_of(a)) == collision_key(b, body_of(b)):
            of_a, of_b = ([may_collide(one, body_of(one), c, body_of(c)) for c in made] for one in (a, b))
            assert of_a == of_b


def test_hundreds_of_sdfs_and_planes_give_one_diagnostic_each(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(GOOD)
    count = 300
    planes = {f"p{i}": {"body_type": "static", "shapes": [{"type": "plane"}]} for i in range(count)}
    field = {"type": "triangle_mesh", "file": "assets/tetra.obj", "sdf": True}
    fields = {f"s{i}": {"shapes": [field]} for i in range(count)}
    found = validate({"scenecc": 1, "entities": {**planes, **fields}})
    assert [d.code for d in found] == ["SC509"] * count
