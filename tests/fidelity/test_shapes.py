"""Every collision shape against hand-written SAPIEN: properties and 300 steps to the last bit."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import SCENES, Case, box_shape, built, by_hand, component, counts, plan_of
from plugins.sample_plans import rubbing
from sapien import physx

from scenecc.backends.sapien.geometry import COLLISION_SHAPES
from scenecc.plan import (
    BodyStructure,
    Box,
    Capsule,
    CoacdParams,
    CollisionShape,
    Cone,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Heightfield,
    Plane,
    Ring,
    Sphere,
    TriangleMesh,
    constant,
    per_scene,
)

POSE = [0.01, 0.02, -0.03, 0.9689124, 0.1, 0.2, 0.1061]
OTHER = [0.05, 0.0, 0.01, 0.5, 0.5, 0.5, 0.5]
SIZES = [0.05, 0.06, 0.07]

Meshes = dict[str, Path]
Make = Callable[[Meshes], Case]


def pose(numbers: list[float]) -> Any:
    return sapien.Pose(numbers[:3], numbers[3:])


def one(geometry: Any, builder: Callable[[Any, int], None], kind: Any = "dynamic", **case: Any) -> Case:
    return Case(BodyStructure(kind, (CollisionShape(geometry),)), builder, kind=kind, **case)


def mesh(kind: Any, geometry: type, method: str, name: str, meshes: Meshes, **extra: Any) -> Case:
    """A mesh of one file, scaled, whose scale differs by scene."""
    scales = [[1.0, 1.1, 0.9 + 0.1 * i] for i in range(SCENES)]
    return one(
        geometry(constant(0, int), per_scene(scales), **extra),
        lambda b, i: getattr(b, method)(str(meshes[name]), scale=scales[i]),
        kind,
        files=(meshes[name],),
    )


CIRCLE = [(math.cos(k * math.pi / 16), math.sin(k * math.pi / 16)) for k in range(32)]
TIP = [(-1, 0, 0), *((-1, y, z) for y, z in CIRCLE), (1, 0, 0)]


def tube(hole: float) -> list[list[tuple[float, float, float]]]:
    """A ring of unit size in 32 parts."""
    corners = [(-1, hole), (-1, 1), (1, 1), (1, hole)]
    sides = [(CIRCLE[k - 1], CIRCLE[k]) for k in range(32)]
    return [[(x, r * y, r * z) for y, z in side for x, r in corners] for side in sides]


def convex(vertices: list[tuple[float, float, float]], scale: list[float]) -> Any:
    return physx.PhysxCollisionShapeConvexMesh(vertices, scale, physx.get_default_material())


HILL = ((0.0, 1.0, 0.5), (0.25, 0.75, -1.0))


def terrain(size: list[float]) -> Any:
    """The triangles of `HILL`, seen from above: its first row is at +y."""
    places = [(x, y, HILL[i][j]) for i, y in enumerate((0.5, -0.5)) for j, x in enumerate((-0.5, 0, 0.5))]
    vertices = [[number * factor for number, factor in zip(place, size, strict=True)] for place in places]
    triangles = [[0, 3, 1], [1, 4, 2], [3, 4, 1], [4, 5, 2]]
    return physx.PhysxCollisionShapeTriangleMesh(vertices, triangles, [1, 1, 1], physx.get_default_material())


def attach(builder: Any, shapes: list[Any]) -> None:
    """Gives the component that a builder makes shapes for which the builder has no method."""
    make = builder.build_physx_component

    def build(link_parent: Any = None) -> Any:
        component = make(link_parent)
        for shape in shapes:
            component.attach(shape)
        return component

    builder.build_physx_component = build


CASES: dict[str, Make] = {
    "box": lambda _: one(Box(constant(SIZES)), lambda b, _: b.add_box_collision(half_size=SIZES)),
    "box, varying": lambda _: one(
        Box(per_scene([[s, 0.06, 0.1 - s] for s in SIZES])),
        lambda b, i: b.add_box_collision(half_size=[SIZES[i], 0.06, 0.1 - SIZES[i]]),
    ),
    "sphere": lambda _: one(Sphere(constant(0.1)), lambda b, _: b.add_sphere_collision(radius=0.1)),
    "sphere, varying": lambda _: one(Sphere(per_scene(SIZES)), lambda b, i: b.add_sphere_collision(radius=SIZES[i])),
    "capsule": lambda _: one(
        Capsule(per_scene(SIZES), constant(0.1)),
        lambda b, i: b.add_capsule_collision(radius=SIZES[i], half_length=0.1),
    ),
    "cylinder": lambda _: one(
        Cylinder(constant(0.07), per_scene(SIZES)),
        lambda b, i: b.add_cylinder_collision(radius=0.07, half_length=SIZES[i]),
    ),
    "cone": lambda _: Case(
        BodyStructure("dynamic", (CollisionShape(Cone(constant(0.07), per_scene(SIZES))),)),
        lambda b, i: attach(b, [convex(TIP, [SIZES[i], 0.07, 0.07])]),
    ),
    "ring": lambda _: Case(
        BodyStructure("dynamic", (CollisionShape(Ring(per_scene(SIZES), constant(0.1), constant(0.04))),)),
        lambda b, i: attach(b, [convex(part, [0.04, 0.1, 0.1]) for part in tube(SIZES[i] / 0.1)]),
    ),
    "heightfield": lambda _: Case(
        BodyStructure("static", (CollisionShape(Heightfield(per_scene([[1, s, 0.1] for s in SIZES]), HILL)),)),
        lambda b, i: attach(b, [terrain([1, SIZES[i], 0.1])]),
        kind="static",
    ),
    "plane": lambda _: one(Plane(), lambda b, _: b.add_plane_collision(), "static"),
    "convex mesh": lambda m: mesh("dynamic", ConvexMesh, "add_convex_collision_from_file", "rock", m),
    "convex parts": lambda m: mesh("dynamic", ConvexParts, "add_multiple_convex_collisions_from_file", "pair", m),
    "triangle mesh, static": lambda m: mesh("static", TriangleMesh, "add_nonconvex_collision_from_file", "ring", m),
    "triangle mesh, kinematic": lambda m: mesh(
        "kinematic", TriangleMesh, "add_nonconvex_collision_from_file", "ring", m
    ),
    "file, varying": lambda m: one(
        ConvexMesh(counts([0, 1, 0]), constant([1, 1, 1])),
        lambda b, i: b.add_convex_collision_from_file(str(m[("rock", "wedge", "rock")[i]])),
        files=(m["rock"], m["wedge"]),
    ),
    "pose": lambda _: Case(
        BodyStructure("dynamic", (box_shape(*SIZES, pose=constant(POSE)),)),
        lambda b, _: b.add_box_collision(pose=pose(POSE), half_size=SIZES),
    ),
    "several, in order": lambda _: Case(
        BodyStructure(
            "dynamic",
            (
                box_shape(*SIZES, pose=per_scene([POSE, OTHER, POSE])),
                CollisionShape(Sphere(constant(0.08)), pose=constant(OTHER)),
                CollisionShape(Capsule(constant(0.03), constant(0.1))),
            ),
        ),
        lambda b, i: (
            b.add_box_collision(pose=pose((POSE, OTHER, POSE)[i]), half_size=SIZES),
            b.add_sphere_collision(pose=pose(OTHER), radius=0.08),
            b.add_capsule_collision(radius=0.03, half_length=0.1),
        ),
    ),
    "density": lambda _: Case(
        BodyStructure("dynamic", (box_shape(*SIZES, density=per_scene([300.0, 1000.0, 7800.0])),)),
        lambda b, i: b.add_box_collision(half_size=SIZES, density=(300.0, 1000.0, 7800.0)[i]),
    ),
    "patch radii": lambda _: Case(
        BodyStructure("dynamic", (box_shape(*SIZES, patch_radius=constant(0.1), min_patch_radius=constant(0.05)),)),
        lambda b, _: b.add_box_collision(half_size=SIZES, patch_radius=0.1, min_patch_radius=0.05),
    ),
    "offsets": lambda _: Case(
        BodyStructure(
            "dynamic",
            (box_shape(*SIZES, contact_offset=per_scene([0.02, 0.03, 0.04]), rest_offset=constant(0.015)),),
        ),
        lambda b, _: b.add_box_collision(half_size=SIZES),
        lambda c, i: (
            c.collision_shapes[0].set_contact_offset((0.02, 0.03, 0.04)[i]),
            c.collision_shapes[0].set_rest_offset(0.015),
        ),
    ),
    "material": lambda _: Case(
        BodyStructure("dynamic", (box_shape(*SIZES, material=counts([0, 1, 0])),)),
        lambda b, i: b.add_box_collision(
            half_size=SIZES,
            material=sapien.physx.PhysxMaterial(*((0.9, 0.8, 0.0), (0.1, 0.05, 0.7))[(0, 1, 0)[i]]),
        ),
        physical_materials=(rubbing(0.9, 0.8, 0.0), rubbing(0.1, 0.05, 0.7)),
    ),
    "groups": lambda _: Case(
        BodyStructure(
            "dynamic", (box_shape(*SIZES),), collision_groups=counts([[2, 2, 0, 0], [1, 1, 4, 7], [3, 1, 0, 0]])
        ),
        lambda b, i: (
            setattr(b, "collision_groups", ([2, 2, 0, 0], [1, 1, 4, 7], [3, 1, 0, 0])[i]),
            b.add_box_collision(half_size=SIZES),
        ),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_shape_is_as_written_by_hand(name: str, meshes: Meshes) -> None:
    case = CASES[name](meshes)
    batch, hand = built(plan_of(case)), by_hand(case)
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)


def test_dynamic_triangle_mesh_with_a_distance_field(meshes: Meshes) -> None:
    """It rests on a box: on a plane it would fall through on the CPU."""
    case = mesh("dynamic", TriangleMesh, "add_nonconvex_collision_from_file", "ring", meshes, sdf=True)
    with_sdf = plan_of(case, scenes=1)
    batch, hand = built(with_sdf), by_hand(case, scenes=1)
    assert_same_scene(batch.scenes[0], hand[0])
    assert_same_trajectory(batch.scenes, hand, steps=60)


def test_coacd_gives_the_parts_that_sapien_gives(
    meshes: Meshes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coacd")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    params = {"threshold": 0.2, "mcts_iterations": 20, "resolution": 500, "seed": 3}
    ours, theirs = tmp_path / "ring.obj", tmp_path / "theirs" / "ring.obj"
    theirs.parent.mkdir()
    for path in (ours, theirs):
        path.write_bytes(meshes["hoop"].read_bytes())
    case = Case(
        BodyStructure(
            "dynamic",
            (CollisionShape(ConvexParts(constant(0, int), constant([1, 1, 1]), CoacdParams(**params))),),
        ),
        lambda b, _: b.add_multiple_convex_collisions_from_file(
            str(theirs), decomposition="coacd", decomposition_params=params
        ),
        files=(ours,),
    )
    batch, hand = built(plan_of(case, scenes=1)), by_hand(case, scenes=1)
    assert_same_scene(batch.scenes[0], hand[0])
    assert len(component(batch, "body").collision_shapes) > 1
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == ["ring.obj"]


def test_every_collision_geometry_has_a_case() -> None:
    """A new shape without a comparison against SAPIEN fails here."""
    covered = {Box, Sphere, Capsule, Cylinder, Cone, Ring, Heightfield, Plane, ConvexMesh, ConvexParts, TriangleMesh}
    assert covered == set(COLLISION_SHAPES)
