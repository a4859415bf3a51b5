"""Every shape of the language, written in YAML, against hand-written SAPIEN."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.test_shapes import CIRCLE, attach, convex, tube
from fidelity.yaml_cases import UP, compare
from plugins.scene_models import all_keys
from sapien import Pose, physx

from scenecc.spec.document import SceneFile
from scenecc.spec.shapes import CollisionKeys

ASSETS = Path(__file__).resolve().parents[1] / "scenes/good/assets"
TETRA, PAIR = str(ASSETS / "tetra.obj"), str(ASSETS / "pair.obj")
HALF = math.sqrt(0.5)
ALONG_Y, ALONG_Z = Pose(q=[HALF, 0, 0, HALF]), Pose(q=[HALF, 0, -HALF, 0])
RUBBER = "{static_friction: 0.9, dynamic_friction: 0.8, restitution: 0.6, density: 700}"
BOX = {"half_size": [0.05, 0.06, 0.07]}


def sdf(builder: Any) -> None:
    builder.add_nonconvex_collision_from_file(TETRA, scale=[0.3, 0.3, 0.3])


CASES: dict[str, tuple[str, Any]] = {
    "box": ("{type: box, half_size: [0.05, 0.06, 0.07]}", lambda b: b.add_box_collision(**BOX)),
    "sphere": ("{type: sphere, radius: 0.1}", lambda b: b.add_sphere_collision(radius=0.1)),
    "capsule": (
        "{type: capsule, radius: 0.05, half_length: 0.1}",
        lambda b: b.add_capsule_collision(radius=0.05, half_length=0.1),
    ),
    "capsule along y": (
        "{type: capsule, radius: 0.05, half_length: 0.1, axis: y}",
        lambda b: b.add_capsule_collision(ALONG_Y, radius=0.05, half_length=0.1),
    ),
    "capsule along z": (
        "{type: capsule, radius: 0.05, half_length: 0.1, axis: z, pose: [0, 0, 0.1]}",
        lambda b: b.add_capsule_collision(Pose([0, 0, 0.1], ALONG_Z.q), radius=0.05, half_length=0.1),
    ),
    "cylinder": (
        "{type: cylinder, radius: 0.05, half_length: 0.1}",
        lambda b: b.add_cylinder_collision(radius=0.05, half_length=0.1),
    ),
    "cylinder along y": (
        "{type: cylinder, radius: 0.05, half_length: 0.1, axis: y}",
        lambda b: b.add_cylinder_collision(ALONG_Y, radius=0.05, half_length=0.1),
    ),
    "cylinder along z": (
        "{type: cylinder, radius: 0.05, half_length: 0.1, axis: z}",
        lambda b: b.add_cylinder_collision(ALONG_Z, radius=0.05, half_length=0.1),
    ),
    "convex_mesh": (
        f"{{type: convex_mesh, file: {TETRA}, scale: [0.2, 0.3, 0.4]}}",
        lambda b: b.add_convex_collision_from_file(TETRA, scale=[0.2, 0.3, 0.4]),
    ),
    "convex_parts": (
        f"{{type: convex_parts, file: {PAIR}, scale: 0.2}}",
        lambda b: b.add_multiple_convex_collisions_from_file(PAIR, scale=[0.2, 0.2, 0.2]),
    ),
    "pose": (
        "{type: box, half_size: [0.05, 0.06, 0.07], pose: {p: [0.1, 0, 0.2], q: [0.6, 0, 0.8, 0]}}",
        lambda b: b.add_box_collision(Pose([0.1, 0, 0.2], [0.6, 0, 0.8, 0]), **BOX),
    ),
    "density": (
        "{type: box, half_size: [0.05, 0.06, 0.07], density: 300}",
        lambda b: b.add_box_collision(**BOX, density=300),
    ),
    "patches": (
        "{type: box, half_size: [0.05, 0.06, 0.07], patch_radius: 0.1, min_patch_radius: 0.05}",
        lambda b: b.add_box_collision(**BOX, patch_radius=0.1, min_patch_radius=0.05),
    ),
    "material": (
        f"{{type: box, half_size: [0.05, 0.06, 0.07], material: {{physical: {RUBBER}}}}}",
        lambda b: b.add_box_collision(**BOX, material=physx.PhysxMaterial(0.9, 0.8, 0.6), density=700),
    ),
    "half a material": (
        "{type: box, half_size: [0.05, 0.06, 0.07], material: {physical: {restitution: 0.9}}}",
        lambda b: b.add_box_collision(**BOX, material=physx.PhysxMaterial(0.3, 0.3, 0.9)),
    ),
}


@pytest.mark.parametrize(("axis", "turn"), [("", Pose()), (", axis: y", ALONG_Y), (", axis: z", ALONG_Z)])
def test_cone(axis: str, turn: Any) -> None:
    def component(c: Any) -> None:
        vertices = [(-1, 0, 0), *((-1, y, z) for y, z in CIRCLE), (1, 0, 0)]
        shape = physx.PhysxCollisionShapeConvexMesh(vertices, [0.1, 0.05, 0.05], physx.get_default_material())
        shape.local_pose = turn
        c.attach(shape)

    compare(f"collisions: [{{type: cone, radius: 0.05, half_length: 0.1{axis}}}]", lambda b: None, component)


def test_ring() -> None:
    text = "collisions: [{type: ring, inner_radius: 0.06, outer_radius: 0.1, half_length: 0.02}]"
    compare(text, lambda b: attach(b, [convex(part, [0.02, 0.1, 0.1]) for part in tube(0.06 / 0.1)]))


def test_heightfield() -> None:
    def component(c: Any) -> None:
        vertices = [[-1, 2, 0], [1, 2, 0.25], [-1, -2, 0.5], [1, -2, 0]]
        triangles = [[0, 2, 1], [2, 3, 1]]
        material = physx.get_default_material()
        c.attach(physx.PhysxCollisionShapeTriangleMesh(vertices, triangles, [1, 1, 1], material))

    text = "body_type: static\ncollisions: [{type: heightfield, size: [2, 4, 0.5], heights: [[0, 0.5], [1, 0]]}]"
    compare(text, lambda b: None, component, kind="static")


@pytest.mark.parametrize("kind", ["dynamic", "kinematic"])
@pytest.mark.parametrize("name", CASES)
def test_shape(name: str, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ASSETS)
    shape, builder = CASES[name]
    compare(f"body_type: {kind}\ncollisions:\n  - {shape}", builder, kind=kind)


@pytest.mark.parametrize("key", ["shapes", "collisions"])
def test_both_lists_collide_alike(key: str) -> None:
    compare(f"{key}: [{{type: sphere, radius: 0.1}}]", lambda b: b.add_sphere_collision(radius=0.1))


def test_shapes_come_before_collisions_each_in_its_order() -> None:
    def builder(b: Any) -> None:
        b.add_sphere_collision(radius=0.08)
        b.add_capsule_collision(Pose([0.1, 0, 0]), radius=0.03, half_length=0.1)
        b.add_box_collision(Pose([-0.1, 0, 0]), **BOX)

    compare(
        """
        collisions:
          - {type: box, half_size: [0.05, 0.06, 0.07], pose: [-0.1, 0, 0]}
        shapes:
          - {type: sphere, radius: 0.08}
          - {type: capsule, radius: 0.03, half_length: 0.1, pose: [0.1, 0, 0]}
        """,
        builder,
    )


@pytest.mark.parametrize("kind", ["static", "kinematic"])
@pytest.mark.parametrize(
    ("shape", "pose"),
    [
        ("{type: plane}", Pose(q=UP)),
        ("{type: plane, normal: [0, 0, 3], offset: -0.25}", Pose([0, 0, -0.25], UP)),
        ("{type: plane, normal: [2, 0, 0], offset: -2}", Pose([-2, 0, 0])),
        ("{type: plane, normal: [-1, 0, 0], offset: -2}", Pose([2, 0, 0], [0, 0, 0, 1])),
        ("{type: plane, normal: [0, 0, -1], every_scene: true, pose: [0, 0, 5]}", Pose([0, 0, 5], [HALF, 0, HALF, 0])),
    ],
)
def test_plane(shape: str, pose: Any, kind: str) -> None:
    compare(f"body_type: {kind}\nshapes: [{shape}]", lambda b: b.add_plane_collision(pose), kind=kind)


@pytest.mark.parametrize("kind", ["static", "kinematic"])
def test_triangle_mesh(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ASSETS)
    compare(
        f"body_type: {kind}\nshapes: [{{type: triangle_mesh, file: pair.obj, scale: [0.2, 0.3, 0.2]}}]",
        lambda b: b.add_nonconvex_collision_from_file(PAIR, scale=[0.2, 0.3, 0.2]),
        kind=kind,
    )


def test_offsets() -> None:
    def component(c: Any) -> None:
        c.collision_shapes[0].set_contact_offset(0.03)
        c.collision_shapes[0].set_rest_offset(-0.002)

    compare(
        "shapes: [{type: sphere, radius: 0.1, contact_offset: 0.03, rest_offset: -0.002}]",
        lambda b: b.add_sphere_collision(radius=0.1),
        component,
    )


def test_signed_distance_field_on_a_box() -> None:
    """On the CPU such a field falls through a plane, so the ground is a box here."""
    import io

    from fidelity.compare import assert_same_scene, assert_same_trajectory

    from scenecc import load_scene

    scene: Any = sapien.Scene([physx.PhysxCpuSystem()])
    floor = scene.create_actor_builder()
    floor.add_box_collision(half_size=[2, 2, 0.1])
    floor.build_static(name="floor")
    falls = scene.create_actor_builder()
    sdf(falls)
    falls.initial_pose = Pose([0, 0, 0.5])
    falls.build(name="falls")
    text = f"""
        {{scenecc: 1, entities: {{
          floor: {{body_type: static, shapes: [{{type: box, half_size: [2, 2, 0.1]}}]}},
          falls: {{pose: [0, 0, 0.5], shapes: [{{type: triangle_mesh, file: {TETRA}, scale: 0.3, sdf: true}}]}}}}}}
    """
    with load_scene(io.StringIO(text), render=False, audit="full", allow_outside_assets=True) as batch:
        assert_same_scene(batch.scenes[0], scene)
        assert_same_trajectory(batch.scenes, [scene])
        assert batch.entities["falls"].pose[0, 2] > 0


def test_every_key_of_a_colliding_shape_is_compared() -> None:
    text = Path(__file__).read_text(encoding="utf-8")
    keys = {name for model, name in all_keys(SceneFile) if issubclass(model, CollisionKeys)}
    # What cannot be compared without a renderer, without CoACD (`test_shapes.py`) or on one CPU scene.
    seen = {"name", "front_face", "color", "decomposition", "decomposition_params"}
    seen |= {"collision_bits"}  # test_yaml_bodies.py
    assert {name for name in keys if f"{name}:" not in text} <= seen | {"half_size"}
