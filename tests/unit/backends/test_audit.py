"""Something changes a scene behind the builder's back, or the builder errs: the audit names the line and the fault."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenecc.backends.sapien import build, builder, instantiate
from scenecc.backends.sapien.audit import masses
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.plan import CollisionShape, Constraint, ConvexMesh, Mount, Ring, ScenePlan, Weld, constant

Sabotage = Callable[[list[Any]], object]


def audited(
    plan: ScenePlan, monkeypatch: pytest.MonkeyPatch, sabotage: Sabotage, *, audit: bool = True
) -> list[Diagnostic]:
    """What the audit reports after `sabotage` has changed the scenes."""
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        fill(scenes, turns, progress)
        sabotage(list(scenes))

    monkeypatch.setattr(build, "fill_scenes", filled)
    return complaints(plan, audit=audit)


def complaints(plan: ScenePlan, *, audit: bool = True) -> list[Diagnostic]:
    sink = Sink()
    batch = instantiate(plan, sink, render=False, audit=audit)
    assert (batch is None) == bool(sink.diagnostics())
    if batch is not None:
        batch.close()
    assert {d.code for d in sink.diagnostics()} <= {"SC802"}
    return sink.diagnostics()


def entity(scene: Any, name: str) -> Any:
    return next(e for e in scene.entities if e.name == name)


def body(scene: Any, name: str) -> Any:
    return entity(scene, name).components[-1]


def swap_poses(scenes: list[Any]) -> None:
    a, b = entity(scenes[1], "cube"), entity(scenes[3], "cube")
    a.pose, b.pose = b.pose, a.pose


def halve(scene: int) -> Sabotage:
    def sabotage(scenes: list[Any]) -> None:
        component = body(scenes[scene], "post")
        component.mass = component.mass / 2

    return sabotage


def remove(scenes: list[Any]) -> None:
    scenes[3].remove_entity(entity(scenes[3], "post"))


def reorder(scenes: list[Any]) -> None:
    first = scenes[2].entities[0]
    scenes[2].remove_entity(first)
    scenes[2].add_entity(first)


def one_shape_more(scene: int) -> Sabotage:
    def sabotage(scenes: list[Any]) -> None:
        body(scenes[scene], "cube").attach(physx.PhysxCollisionShapeSphere(0.1, physx.get_default_material()))

    return sabotage


CASES: dict[str, tuple[Sabotage, str, tuple[str, ...]]] = {
    "swapped poses": (swap_poses, "entities.cube", ("pose", "scene 1", "1 more")),
    "half the mass, first scene": (halve(0), "entities.post", ("mass", "scene 0")),
    "half the mass, last scene": (halve(3), "entities.post", ("mass", "scene 3")),
    "one entity less": (remove, "", ("the scene in scene 3", "entities in the scene")),
    "one entity more": (lambda scenes: scenes[3].add_entity(sapien.Entity()), "", ("entities in the scene", "scene 3")),
    "another order": (reorder, "entities.table", ("entity 0 of the build order", "scene 2")),
    "one shape more, first scene": (one_shape_more(0), "entities.cube", ("collision_shapes = 3", "asks for 2")),
    "one shape more, last scene": (one_shape_more(3), "entities.cube", ("mass", "scene 3")),
}


@pytest.mark.parametrize("name", CASES)
def test_the_audit_reports_a_manipulated_scene(name: str, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    sabotage, path, words = CASES[name]
    found = audited(plan, monkeypatch, sabotage)
    assert [d for d in found if d.path.startswith(path) and all(word in d.message for word in words)], found


def test_without_the_audit_nothing_is_reported(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not audited(plan, monkeypatch, swap_poses, audit=False)


def test_the_audit_reports_nothing_for_a_good_build(plan: ScenePlan) -> None:
    assert not complaints(plan)


@pytest.mark.parametrize(("scene", "words"), [(0, "collision_shapes = 1"), (0, "mass"), (2, "mass")])
def test_the_audit_reports_a_shape_that_the_builder_drops(
    scene: int, words: str, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    attach = builder.attach_shape

    def forgetful(component: Any, shape: Any, row: int) -> None:
        second = shape.origin is not None and shape.origin.path == ("entities", "cube", "shapes", 1)
        if not (second and row == scene):
            attach(component, shape, row)

    monkeypatch.setattr(builder, "attach_shape", forgetful)
    messages = [d.message for d in complaints(plan)]
    assert any(f"'cube' in scene {scene}:" in m and words in m for m in messages), messages


def test_the_audit_reports_a_mesh_part_that_the_builder_drops_in_one_scene(
    plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A ring is 32 convex meshes, and static, so that its mass does not tell."""
    ring = CollisionShape(Ring(constant(0.1), constant(0.2), constant(0.05)))
    table = plan.entities[0]
    structure = replace(table.structures[0], collisions=(ring,))
    plan = replace(plan, entities=(replace(table, structures=(structure,)), *plan.entities[1:]))
    assert not complaints(plan)
    attach = builder.attach_shape

    def forgetful(component: Any, shape: Any, row: int) -> None:
        if shape.many and row == 2:
            shape = shape._replace(make=lambda row, make=shape.make: make(row)[1:])
        attach(component, shape, row)

    monkeypatch.setattr(builder, "attach_shape", forgetful)
    (found,) = complaints(plan)
    assert "'table' in scene 2: the engine holds collision_shapes = 31, but the plan asks for 32" in found.message


def alike(plan: ScenePlan) -> ScenePlan:
    """All entities at one place, so that no pose tells one from another."""
    place = constant([0, 0, 1, 1, 0, 0, 0])
    return replace(plan, entities=tuple(replace(entity, pose=place) for entity in plan.entities))


@pytest.mark.parametrize("number", [0, 3])
def test_the_audit_reports_two_entities_in_swapped_order(
    number: int, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        first, second, third, *others = turns
        for each, scene in enumerate(scenes):
            fill([scene], [first, third, second, *others] if each == number else turns, progress)

    monkeypatch.setattr(build, "fill_scenes", filled)
    messages = [d.message for d in complaints(alike(plan))]
    words = (
        f"'cube' in scene {number}: the engine holds entity 1 of the build order = 'post', but the plan asks for 'cube'"
    )
    assert any(words in message for message in messages), messages


def test_the_audit_reports_objects_with_the_name_of_another_entity(
    plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        fill(scenes, turns, progress)
        turns[1].objs[:], turns[2].objs[:] = turns[2].objs[:], turns[1].objs[:]

    monkeypatch.setattr(build, "fill_scenes", filled)
    messages = [d.message for d in complaints(alike(plan))]
    words = "'cube' in scene 0 (and in 3 more): the engine holds entity 1 of the build order = another entity 'cube'"
    assert any(words in message for message in messages), messages


def test_constraints_are_counted_on_their_bodies(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    tied = replace(plan, constraints=tuple(Constraint(name, (0, 2), Weld(), Mount("cube")) for name in ("a", "b")))
    assert not complaints(tied)
    make = build.ConstraintSet

    def forgetful(plan: ScenePlan, lookup: Any) -> Any:
        made = make(plan, lookup)
        component = made.batches["a"].objs[1]
        component.get_entity().remove_component(component)
        return made

    monkeypatch.setattr(build, "ConstraintSet", forgetful)
    (found,) = complaints(tied)
    assert (
        "'a' in scene 2: the engine holds constraints of 'cube' = 'b', but the plan asks for 'a', 'b'" in found.message
    )


def test_a_cooked_mesh_is_not_weighed_for_every_shape(
    plan_of_shapes: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "wedge.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    shape = CollisionShape(ConvexMesh(constant(0, np.int64), constant([1, 2, 1])))
    plan = plan_of_shapes(shape, shape, files=(path,), kind="static")
    assert not complaints(plan)
    weighed: list[Any] = []
    monkeypatch.setattr(masses, "enclosed_volume", lambda mesh: weighed.append(mesh) or 0.15)
    (found,) = complaints(plan)
    assert "volume of the cooked mesh = 0.16" in found.message
    assert len(weighed) == 2  # once to compare it with its file, once for the audit
