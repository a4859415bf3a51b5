"""Every collision shape against hand-written SAPIEN: properties and 300 steps to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import SCENES, Case, box_shape, built, by_hand, component, counts, plan_of
from plugins.sample_plans import rubbing

from scenecc.backends.sapien.geometry import COLLISION_SHAPES
from scenecc.plan import (
    BodyStructure,
    Box,
    Capsule,
    CoacdParams,
    CollisionShape,
    ConvexMesh,
    ConvexParts,
    Cylinder,
    Plane,
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
    covered = {Box, Sphere, Capsule, Cylinder, Plane, ConvexMesh, ConvexParts, TriangleMesh}
    assert covered == set(COLLISION_SHAPES)
