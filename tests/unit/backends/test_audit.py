"""Sabotage: something changes a scene behind the backend's back, and the audit names line and property."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import pytest

from scenecc.backends.sapien import build, instantiate
from scenecc.backends.sapien.engine import sapien
from scenecc.diagnostics import Diagnostic, Sink
from scenecc.plan import ScenePlan

Sabotage = Callable[[list[Any]], None]
Level = Literal["full", "fast", "off"]


def audited(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch, sabotage: Sabotage, level: Level) -> list[Diagnostic]:
    """What the audit says after `sabotage` was let loose on the scenes."""
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        fill(scenes, turns, progress)
        sabotage(list(scenes))

    monkeypatch.setattr(build, "fill_scenes", filled)
    sink = Sink()
    batch = instantiate(plan, sink, render=False, audit=level)
    assert (batch is None) == bool(sink.diagnostics())
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


def change(name: str, value: Any, *, of: str = "cube") -> Sabotage:
    return lambda scenes: setattr(body(scenes[0], of), name, value)


def change_shape(name: str, value: Any) -> Sabotage:
    return lambda scenes: setattr(body(scenes[0], "cube").collision_shapes[0], name, value)


def rub(scenes: list[Any]) -> None:
    body(scenes[0], "cube").collision_shapes[0].physical_material.static_friction = 0.61


def regroup(scenes: list[Any]) -> None:
    body(scenes[0], "cube").collision_shapes[1].set_collision_groups([1, 1, 2, 0])


def remove(scenes: list[Any]) -> None:
    scenes[3].remove_entity(entity(scenes[3], "post"))


def add(scenes: list[Any]) -> None:
    scenes[3].add_entity(sapien.Entity())


def reorder(scenes: list[Any]) -> None:
    first = scenes[2].entities[0]
    scenes[2].remove_entity(first)
    scenes[2].add_entity(first)


def rename(scenes: list[Any]) -> None:
    entity(scenes[0], "cube").name = "cubes"


def slow(scenes: list[Any]) -> None:
    scenes[0].timestep = 0.02


FAST: dict[str, tuple[Sabotage, str, tuple[str, ...]]] = {
    "swapped poses": (swap_poses, "entities.cube", ("pose", "scene 1", "1 more")),
    "half the mass, first scene": (halve(0), "entities.post", ("mass", "scene 0")),
    "half the mass, last scene": (halve(3), "entities.post", ("mass", "scene 3")),
    "friction": (rub, "entities.cube.shapes[0]", ("static_friction", "0.61", "0.6")),
    "restitution": (
        lambda scenes: setattr(body(scenes[0], "cube").collision_shapes[0].physical_material, "restitution", 0.2),
        "entities.cube.shapes[0]",
        ("restitution",),
    ),
    "groups": (regroup, "entities.cube.shapes[1]", ("collision_groups",)),
    "contact offset": (change_shape("contact_offset", 0.02), "entities.cube.shapes[0]", ("contact_offset", "0.02")),
    "rest offset": (change_shape("rest_offset", 0.002), "entities.cube.shapes[0]", ("rest_offset",)),
    "patch radius": (change_shape("patch_radius", 0.1), "entities.cube.shapes[0]", ("patch_radius",)),
    "damping": (change("linear_damping", 0.1), "entities.cube", ("linear_damping", "0.1")),
    "gravity": (change("disable_gravity", True), "entities.cube", ("disable_gravity",)),
    "iterations": (change("solver_position_iterations", 9), "entities.cube", ("solver_position_iterations", "9")),
    "sleep threshold": (change("sleep_threshold", 0.25), "entities.cube", ("sleep_threshold",)),
    "velocity": (change("linear_velocity", [1, 0, 0.25]), "entities.cube", ("linear_velocity",)),
    "inertia": (change("inertia", [1, 1, 1]), "entities.cube", ("inertia",)),
    "centre of mass": (
        change("cmass_local_pose", sapien.Pose([0.01, 0, 0])),
        "entities.cube",
        ("cmass_local_pose",),
    ),
    "kinematic": (change("kinematic", True), "entities.cube", ("kinematic",)),
    "component's name": (change("name", "x"), "entities.cube", ("component.name", "'x'")),
    "entity's name": (rename, "entities.cube", ("name", "'cubes'")),
    "one entity less": (remove, "", ("entities in the scene", "scene 3")),
    "one entity more": (add, "", ("entities in the scene", "scene 3")),
    "another order": (reorder, "entities.table", ("pose", "scene 2")),
    "time step": (slow, "", ("timestep", "0.02")),
}


@pytest.mark.parametrize("name", FAST)
@pytest.mark.parametrize("level", ["fast", "full"])
def test_sabotage(name: str, level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    sabotage, path, words = FAST[name]
    found = audited(plan, monkeypatch, sabotage, level)
    told = [d for d in found if d.path.startswith(path) and all(word in d.message for word in words)]
    assert told, "\n".join(map(str, found))


def test_full_reads_every_body(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    """A property that the fast audit reads in the first scene only."""

    def sabotage(scenes: list[Any]) -> None:
        body(scenes[3], "cube").linear_damping = 0.5

    assert not audited(plan, monkeypatch, sabotage, "fast")
    monkeypatch.undo()
    found = audited(plan, monkeypatch, sabotage, "full")
    assert [d.path for d in found] == ["entities.cube"]
    assert "linear_damping = 0.5" in found[0].message
    assert "scene 3" in found[0].message


def test_off_reads_nothing(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not audited(plan, monkeypatch, swap_poses, "off")


@pytest.mark.parametrize("level", ["fast", "full"])
def test_dropped_shape_of_the_builder(level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    """The builder itself leaves a shape out, in every scene, as SAPIEN's would."""
    from scenecc.backends.sapien import builder

    attach = builder.attach_shape

    def forgetful(component: Any, shape: Any, row: int) -> None:
        if shape.origin is None or shape.origin.path[-1] != 1:
            attach(component, shape, row)

    monkeypatch.setattr(builder, "attach_shape", forgetful)
    sink = Sink()
    assert instantiate(plan, sink, render=False, audit=level) is None
    counts = [d for d in sink.diagnostics() if "collision_shapes = 1" in d.message]
    assert [d.path for d in counts] == ["entities.cube"]
    assert "and in 3 more" in counts[0].message


def test_dropped_shape_in_one_scene(plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenecc.backends.sapien import builder

    attach = builder.attach_shape

    def forgetful(component: Any, shape: Any, row: int) -> None:
        second = shape.origin is not None and shape.origin.path == ("entities", "cube", "shapes", 1)
        if not (second and row == 2):
            attach(component, shape, row)

    monkeypatch.setattr(builder, "attach_shape", forgetful)
    sink = Sink()
    assert instantiate(plan, sink, render=False) is None
    messages = [d.message for d in sink.diagnostics()]
    assert any("'cube' in scene 2:" in m and "collision_shapes = 1" in m for m in messages), messages
    assert any("'cube' in scene 2:" in m and "mass" in m for m in messages), messages


def test_nothing_to_say_about_a_good_build(plan: ScenePlan) -> None:
    for level in ("fast", "full"):
        sink = Sink()
        batch = instantiate(plan, sink, render=False, audit=level)
        assert batch is not None
        assert not sink.diagnostics()
        batch.close()
