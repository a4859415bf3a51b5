"""Every shape of the language, written in YAML, against hand-written SAPIEN."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import sapien
from fidelity.yaml_cases import UP, compare, compare_each
from plugins.scene_models import all_keys
from sapien import Pose, physx

from scenecc.backends.sapien.geometry import COLLISION_SHAPES
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


CIRCLE = [(math.cos(k * math.pi / 16), math.sin(k * math.pi / 16)) for k in range(32)]
TIP = [(-1, 0, 0), *((-1, y, z) for y, z in CIRCLE), (1, 0, 0)]


def tube(hole: float) -> list[list[tuple[float, float, float]]]:
    """A ring of unit size in 32 parts."""
    corners = [(-1, hole), (-1, 1), (1, 1), (1, hole)]
    sides = [(CIRCLE[k - 1], CIRCLE[k]) for k in range(32)]
    return [[(x, r * y, r * z) for y, z in side for x, r in corners] for side in sides]


def convex(vertices: list[tuple[float, float, float]], scale: list[float]) -> Any:
    return physx.PhysxCollisionShapeConvexMesh(vertices, scale, physx.get_default_material())


def attach(builder: Any, shapes: list[Any]) -> None:
    """Gives the component that a builder makes shapes for which the builder has no method."""
    make = builder.build_physx_component

    def build(link_parent: Any = None) -> Any:
        component = make(link_parent)
        for shape in shapes:
            component.attach(shape)
        return component

    builder.build_physx_component = build


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


SIZES = [0.05, 0.06, 0.07]
DENSITIES, OFFSETS = [300.0, 1000.0, 7800.0], [0.02, 0.03, 0.04]
POSES = [[0.01, 0.02, -0.03, 0.6, 0, 0.8, 0], [0.05, 0.0, 0.01, 0.5, 0.5, 0.5, 0.5], [0, 0, 0.1, 0, 0.8, 0, 0.6]]
SCALES = [[1.0, 1.1, 0.9 + 0.1 * i] for i in range(3)]
BOXES = [[size, 0.06, 0.1 - size] for size in SIZES]
FRICTIONS = [(0.9, 0.8, 0.0), (0.1, 0.05, 0.7), (0.9, 0.8, 0.0)]
MATERIALS = """
materials:
  rough: {physical: {static_friction: 0.9, dynamic_friction: 0.8, restitution: 0}}
  smooth: {physical: {static_friction: 0.1, dynamic_friction: 0.05, restitution: 0.7}}
"""


def by_scene(values: Any) -> str:
    return f"{{per_scene: {json.dumps(values)}}}"


def pose_of(numbers: list[float]) -> Pose:
    return Pose(numbers[:3], numbers[3:])


BY_SCENE: dict[str, tuple[str, Callable[[Any, int], object]]] = {
    "box": (f"{{type: box, half_size: {by_scene(BOXES)}}}", lambda b, i: b.add_box_collision(half_size=BOXES[i])),
    "sphere": (f"{{type: sphere, radius: {by_scene(SIZES)}}}", lambda b, i: b.add_sphere_collision(radius=SIZES[i])),
    "capsule": (
        f"{{type: capsule, radius: {by_scene(SIZES)}, half_length: 0.1}}",
        lambda b, i: b.add_capsule_collision(radius=SIZES[i], half_length=0.1),
    ),
    "cylinder": (
        f"{{type: cylinder, radius: 0.07, half_length: {by_scene(SIZES)}}}",
        lambda b, i: b.add_cylinder_collision(radius=0.07, half_length=SIZES[i]),
    ),
    "cone": (
        f"{{type: cone, radius: 0.07, half_length: {by_scene(SIZES)}}}",
        lambda b, i: attach(b, [convex(TIP, [SIZES[i], 0.07, 0.07])]),
    ),
    "ring": (
        f"{{type: ring, inner_radius: {by_scene(SIZES)}, outer_radius: 0.1, half_length: 0.04}}",
        lambda b, i: attach(b, [convex(part, [0.04, 0.1, 0.1]) for part in tube(SIZES[i] / 0.1)]),
    ),
    "convex mesh": (
        f"{{type: convex_mesh, file: rock.obj, scale: {by_scene(SCALES)}}}",
        lambda b, i: b.add_convex_collision_from_file("rock.obj", scale=SCALES[i]),
    ),
    "convex parts": (
        f"{{type: convex_parts, file: pair.obj, scale: {by_scene(SCALES)}}}",
        lambda b, i: b.add_multiple_convex_collisions_from_file("pair.obj", scale=SCALES[i]),
    ),
    "file": (
        "{type: convex_mesh, file: {per_scene: [rock.obj, wedge.obj, rock.obj]}}",
        lambda b, i: b.add_convex_collision_from_file(("rock.obj", "wedge.obj", "rock.obj")[i]),
    ),
    "pose": (
        f"{{type: box, half_size: [0.05, 0.06, 0.07], pose: {by_scene([{'p': p[:3], 'q': p[3:]} for p in POSES])}}}",
        lambda b, i: b.add_box_collision(pose_of(POSES[i]), **BOX),
    ),
    "density": (
        f"{{type: box, half_size: [0.05, 0.06, 0.07], density: {by_scene(DENSITIES)}}}",
        lambda b, i: b.add_box_collision(**BOX, density=DENSITIES[i]),
    ),
    "material": (
        "{type: box, half_size: [0.05, 0.06, 0.07], material: {per_scene: [rough, smooth, rough]}}",
        lambda b, i: b.add_box_collision(**BOX, material=physx.PhysxMaterial(*FRICTIONS[i])),
    ),
}


@pytest.mark.parametrize("name", BY_SCENE)
def test_shape_by_scene(name: str, meshes: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(meshes["rock"].parent)
    shape, builder = BY_SCENE[name]
    compare_each(f"collisions: [{shape}]", builder, rest=MATERIALS)


@pytest.mark.parametrize("kind", ["static", "kinematic"])
def test_triangle_mesh_by_scene(kind: str, meshes: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(meshes["ring"].parent)
    compare_each(
        f"body_type: {kind}\ncollisions: [{{type: triangle_mesh, file: ring.obj, scale: {by_scene(SCALES)}}}]",
        lambda b, i: b.add_nonconvex_collision_from_file("ring.obj", scale=SCALES[i]),
        kind=kind,
    )


def test_heightfield_by_scene() -> None:
    """The triangles as seen from above: the first row of heights is at +y."""
    heights, sizes = [[0.0, 1.0, 0.5], [0.25, 0.75, -1.0]], [[1, size, 0.1] for size in SIZES]
    places = [(x, y, heights[i][j]) for i, y in enumerate((0.5, -0.5)) for j, x in enumerate((-0.5, 0, 0.5))]
    triangles = [[0, 3, 1], [1, 4, 2], [3, 4, 1], [4, 5, 2]]

    def terrain(size: list[float]) -> Any:
        vertices = [[number * factor for number, factor in zip(place, size, strict=True)] for place in places]
        return physx.PhysxCollisionShapeTriangleMesh(vertices, triangles, [1, 1, 1], physx.get_default_material())

    compare_each(
        f"body_type: static\ncollisions: [{{type: heightfield, size: {by_scene(sizes)}, heights: {heights}}}]",
        lambda b, i: attach(b, [terrain(sizes[i])]),
        kind="static",
    )


def test_coacd_gives_the_parts_that_sapien_gives(
    meshes: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("coacd")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    params = {"threshold": 0.2, "mcts_iterations": 20, "resolution": 500, "seed": 3}
    ours, theirs = tmp_path / "ring.obj", tmp_path / "theirs" / "ring.obj"
    theirs.parent.mkdir()
    for path in (ours, theirs):
        path.write_bytes(meshes["hoop"].read_bytes())
    monkeypatch.chdir(tmp_path)
    shape = f"{{type: convex_parts, file: ring.obj, decomposition: coacd, decomposition_params: {json.dumps(params)}}}"

    def by_hand(builder: Any) -> None:
        builder.add_multiple_convex_collisions_from_file(
            str(theirs), decomposition="coacd", decomposition_params=params
        )

    def component(c: Any) -> None:
        assert len(c.collision_shapes) > 1

    compare(f"collisions: [{shape}]", by_hand, component)
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_file()) == ["ring.obj"]


@pytest.mark.parametrize(("axis", "turn"), [("", Pose()), (", axis: y", ALONG_Y), (", axis: z", ALONG_Z)])
def test_cone(axis: str, turn: Any) -> None:
    def component(c: Any) -> None:
        shape = convex(TIP, [0.1, 0.05, 0.05])
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
    def component(c: Any, scene: int) -> None:
        c.collision_shapes[0].set_contact_offset(OFFSETS[scene])
        c.collision_shapes[0].set_rest_offset(-0.002)

    compare_each(
        f"shapes: [{{type: sphere, radius: 0.1, contact_offset: {by_scene(OFFSETS)}, rest_offset: -0.002}}]",
        lambda b, _: b.add_sphere_collision(radius=0.1),
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
    with load_scene(io.StringIO(text), render=False, allow_outside_assets=True) as batch:
        assert_same_scene(batch.scenes[0], scene)
        assert_same_trajectory(batch.scenes, [scene])
        assert batch.entities["falls"].pose[0, 2] > 0


def test_every_key_of_a_colliding_shape_is_compared() -> None:
    text = Path(__file__).read_text(encoding="utf-8")
    keys = {name for model, name in all_keys(SceneFile) if issubclass(model, CollisionKeys)}
    # What cannot be compared without a renderer,  on one CPU scene.
    seen = {"name", "front_face", "color"}
    seen |= {"collision_bits"}  # test_bodies.py
    assert {name for name in keys if f"{name}:" not in text} <= seen | {"half_size"}


def test_every_collision_geometry_has_a_case() -> None:
    """A new shape without a comparison against SAPIEN fails here."""
    text = Path(__file__).read_text(encoding="utf-8")
    kinds = [re.sub("(?<!^)([A-Z])", r"_\1", geometry.__name__).lower() for geometry in COLLISION_SHAPES]
    assert [kind for kind in kinds if f"{{type: {kind}," not in text and f"{{type: {kind}}}" not in text] == []
