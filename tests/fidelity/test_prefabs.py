"""The prefabs that ship, against the same bodies written by hand: every property, and 300 steps to the last bit."""

from __future__ import annotations

import io
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sapien
import trimesh
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand_prefabs import (
    HAND,
    TABLE_HEIGHT,
    TABLE_MESH,
    WORKSPACE_POSE,
    Builder,
    build,
    ground,
    workspace_table,
)
from fidelity.prefab_cases import CASES, OURS, STATIC, label, srgb
from fidelity.yaml_cases import load
from plugins.structures import bodies_of, body_of
from sapien import Pose, physx

from scenecc import compile_scene, load_scene, validate
from scenecc.plan import Box, Entity, Mesh, ScenePlan, TiledPlane

AT = [0.03, -0.02, 0.6]
TURNED = [0.9238795, 0.2209424, 0.2209424, 0.2209424]


def empty(*, render: bool = False) -> Any:
    return sapien.Scene() if render else sapien.Scene([physx.PhysxCpuSystem()])


def document(name: str, given: dict[str, Any]) -> str:
    """The prefab a little above a plane, and a box that falls on it."""
    thing = {"use": f"scenecc:{name}", "with": given, "pose": {"p": AT, "q": TURNED}}
    return (
        "scenecc: 1\nentities:\n  plane: {body_type: static, collisions: [{type: plane}]}\n"
        f"  thing: {json.dumps(thing)}\n"
        "  cap: {pose: [0.02, 0.01, 2.5], collisions: [{type: box, half_size: [0.05, 0.06, 0.07]}]}\n"
    )


def by_hand(name: str, given: dict[str, Any], *, render: bool = False) -> tuple[Any, Builder]:
    scene = empty(render=render)
    build(scene, "plane", ground, "static", Pose(), render=render)
    params = OURS.get(name, {}) | given
    body_type = params.pop("body_type", "static" if name in STATIC else "dynamic")
    params = {key: srgb(value) if isinstance(value, str) else value for key, value in params.items()}
    builder = build(scene, f"thing/{name}", HAND[name], body_type, Pose(AT, TURNED), render=render, **params)
    cap = scene.create_actor_builder()
    cap.add_box_collision(half_size=[0.05, 0.06, 0.07])
    cap.initial_pose = Pose([0.02, 0.01, 2.5])
    cap.build(name="cap")
    return scene, builder


def assert_seen(plan: ScenePlan, entity: str, builder: Builder) -> None:
    """The visual shapes of the plan are those that were asked for by hand, in single precision."""
    (structure,) = bodies_of(next(e for e in plan.entities if e.name == entity))
    for shape, seen in zip(structure.visuals, builder.seen, strict=True):
        assert type(shape.geometry).__name__.lower() == seen.type
        for key, size in seen.sizes.items():
            assert_close(getattr(shape.geometry, key).data[0], size)
        pose = [0, 0, 0, 1, 0, 0, 0] if shape.pose is None else shape.pose.data[0]
        assert_close(pose, [*seen.pose.p, *seen.pose.q])
        assert shape.material is not None
        material = plan.visual_materials[int(shape.material.data[0])]
        assert material.base_color is not None
        assert_close(material.base_color.data[0], [*(seen.color or ()), 1][:4])
        assert material.roughness is None


def assert_close(ours: Any, theirs: Any) -> None:
    assert np.array_equal(np.float32(ours), np.float32(theirs))


@pytest.mark.parametrize(("name", "given"), CASES, ids=label)
def test_a_prefab_is_what_a_person_builds(name: str, given: dict[str, Any]) -> None:
    scene, builder = by_hand(name, given)
    text = document(name, given)
    with load(text) as batch:
        assert_same_scene(batch.scenes[0], scene)
        assert_same_trajectory(batch.scenes, [scene])
        assert_seen(batch.plan, f"thing/{name}", builder)


@pytest.mark.render
@pytest.mark.parametrize(("name", "given"), CASES, ids=label)
def test_a_prefab_looks_like_what_a_person_builds(name: str, given: dict[str, Any]) -> None:
    scene, _ = by_hand(name, given, render=True)
    with load_scene(io.StringIO(document(name, given)), render=True) as batch:
        assert_same_scene(batch.scenes[0], scene)


@pytest.mark.parametrize(
    "given",
    [{}, {"altitude": -TABLE_HEIGHT}, {"altitude": 0.25, "floor_width": 20}, {"add_collision": False}],
    ids=label,
)
def test_the_ground_is_maniskills(given: dict[str, Any]) -> None:
    text = (
        f"scenecc: 1\nentities:\n  floor: {json.dumps({'use': 'scenecc:ground', 'prefix': '', 'with': given})}\n"
        "  ball: {pose: [0, 0, 1], collisions: [{type: sphere, radius: 0.1}]}\n"
    )
    scene = empty()
    build(scene, "ground", ground, "static", Pose(), render=False, **given)
    ball = scene.create_actor_builder()
    ball.add_sphere_collision(radius=0.1)
    ball.initial_pose = Pose([0, 0, 1])
    ball.build(name="ball")
    with load(text) as batch:
        assert_same_scene(batch.scenes[0], scene)
        assert_same_trajectory(batch.scenes, [scene])


@pytest.mark.parametrize(
    ("given", "half_size", "repeat", "centre"),
    [
        ({}, [50, 50], [25, 25], [0, 0, 0]),
        ({"floor_width": 40, "altitude": -0.5}, [20, 20], [10, 10], [0, 0, -0.5]),
        # ManiSkill's length runs along x, its width along y.
        ({"floor_width": 8, "floor_length": 20, "xy_origin": [1, 2]}, [10, 4], [5, 2], [1, 2, 0]),
        ({"floor_width": 8, "texture_square_len": 2}, [4, 4], [4, 4], [0, 0, 0]),
    ],
    ids=label,
)
def test_the_floor_has_maniskills_extent_and_tiles(
    given: dict[str, Any], half_size: list[float], repeat: list[float], centre: list[float]
) -> None:
    plan = compile_scene({"scenecc": 1, "entities": {"floor": {"use": "scenecc:ground", "with": given}}})
    (structure,) = bodies_of(plan.entities[0])
    (floor,) = structure.visuals
    assert isinstance(floor.geometry, TiledPlane)
    assert floor.geometry.half_size.data.tolist() == [half_size]
    assert floor.geometry.texture_repeat.data.tolist() == [repeat]
    at = [0, 0, 0] if floor.pose is None else floor.pose.data[0, :3].tolist()
    assert at == centre
    assert [file.path.name for file in plan.files] == ["tiles.png"]


@pytest.mark.parametrize("prefix", [None, ""], ids=["prefixed", "as in ManiSkill"])
def test_the_workspace_is_maniskills_table_and_ground(prefix: str | None) -> None:
    use = {"use": "scenecc:table_workspace", "with": {"visual": "boxes"}}
    use |= {} if prefix is None else {"prefix": prefix}
    text = (
        f"scenecc: 1\nnum_scenes: 2\nentities:\n  place: {json.dumps(use)}\n"
        "  cube: {pose: [0.1, 0.2, 0.3], collisions: [{type: box, half_size: [0.02, 0.02, 0.02]}]}\n"
        "  fallen: {pose: [2, 0, 0], collisions: [{type: sphere, radius: 0.1}]}\n"
    )
    within = "place/" if prefix is None else ""

    def hand() -> tuple[Any, Builder]:
        scene = empty()
        table = build(scene, f"{within}table-workspace", workspace_table, "kinematic", WORKSPACE_POSE, render=False)
        build(scene, f"{within}ground", ground, "static", Pose(), render=False, altitude=-TABLE_HEIGHT)
        cube, fallen = scene.create_actor_builder(), scene.create_actor_builder()
        cube.add_box_collision(half_size=[0.02] * 3)
        cube.initial_pose = Pose([0.1, 0.2, 0.3])
        cube.build(name="cube")
        fallen.add_sphere_collision(radius=0.1)
        fallen.initial_pose = Pose([2, 0, 0])
        fallen.build(name="fallen")
        return scene, table

    built = [hand(), hand()]
    with load(text) as batch:
        for ours, (theirs, _) in zip(batch.scenes, built, strict=True):
            assert_same_scene(ours, theirs)
        assert_same_trajectory(batch.scenes, [scene for scene, _ in built])
        assert_seen(batch.plan, f"{within}table-workspace", built[0][1])
        # The cube came to rest on z = 0, the ball on the ground below.
        assert batch.entities["cube"].pose[0, 2] == pytest.approx(0.02, abs=1e-3)
        assert batch.entities["fallen"].pose[0, 2] == pytest.approx(0.1 - TABLE_HEIGHT, abs=1e-3)


@pytest.fixture
def maniskill(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of this name with the table's mesh, found first and never imported."""
    file = tmp_path / "mani_skill" / TABLE_MESH.removeprefix("pkg://mani_skill/")
    file.parent.mkdir(parents=True)
    (tmp_path / "mani_skill" / "__init__.py").write_text("raise AssertionError('imported')\n")
    trimesh.creation.box((0.7, 1.4, 0.5)).export(file)
    monkeypatch.delitem(sys.modules, "mani_skill", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    return file


@pytest.fixture
def no_maniskill(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mani_skill", None)


def workspace(**given: str) -> dict[str, Any]:
    place = {"use": "scenecc:table_workspace", "with": given, "prefix": ""}
    return {"scenecc": 1, "entities": {"place": place}}


@pytest.mark.usefixtures("maniskill")
@pytest.mark.parametrize("given", [{}, {"visual": "mesh"}], ids=label)
def test_the_workspace_shows_maniskills_mesh_where_it_is_installed(given: dict[str, str]) -> None:
    plan = compile_scene(workspace(**given))
    (structure,) = bodies_of(plan.entities[0])
    (mesh,) = structure.visuals
    assert isinstance(mesh.geometry, Mesh)
    assert mesh.geometry.scale.data.tolist() == [[1.75] * 3]
    assert mesh.pose is not None
    assert_close(mesh.pose.data[0], [0, 0, 0, *WORKSPACE_POSE.q])
    assert TABLE_MESH in [file.uri for file in plan.files]


@pytest.mark.usefixtures("no_maniskill")
def test_the_workspace_shows_boxes_where_maniskill_is_not_installed() -> None:
    plan = compile_scene(workspace())
    assert plan == compile_scene(workspace(visual="boxes"))
    assert [type(shape.geometry) for shape in body_of(plan.entities[0]).visuals] == [Box] * 5
    assert not [file for file in plan.files if "mani_skill" in file.uri]


@pytest.mark.usefixtures("maniskill")
def test_only_the_look_of_the_workspace_depends_on_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = compile_scene(workspace())
    pinned = compile_scene(workspace(visual="boxes"))
    monkeypatch.setitem(sys.modules, "mani_skill", None)
    boxes = compile_scene(workspace())
    assert boxes == pinned
    assert boxes.physical_materials == mesh.physical_materials
    assert collide(boxes) == collide(mesh)
    assert all(structure.collisions for entity in collide(boxes) for structure in bodies_of(entity))
    assert boxes != mesh


def collide(plan: ScenePlan) -> list[Entity]:
    """The entities without what is seen of them."""
    return [
        replace(entity, structures=tuple(replace(structure, visuals=()) for structure in entity.structures))
        for entity in plan.entities
    ]


@pytest.mark.usefixtures("no_maniskill")
def test_the_mesh_of_the_workspace_is_an_error_where_it_is_not_installed() -> None:
    found = validate(workspace(visual="mesh"))
    assert [d.code for d in found if d.severity == "error"] == ["SC405"], found
    assert not validate(workspace())


def test_a_maniskill_without_the_mesh_is_an_error_that_boxes_avoid(maniskill: Path) -> None:
    maniskill.unlink()
    (found,) = validate(workspace())
    assert found.code == "SC401"
    assert found.path == "entities.place.use"
    assert not validate(workspace(visual="boxes"))
