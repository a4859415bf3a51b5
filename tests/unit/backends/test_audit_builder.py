"""Sabotage of the builder itself: what it sets wrongly must not become what the audit expects."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import pytest

from scenecc.backends.sapien import assets, build, engine, instantiate
from scenecc.backends.sapien.engine import physx
from scenecc.diagnostics import Sink
from scenecc.plan import Physics, ScenePlan, SdfConfig, constant
from scenecc.plan.body import Friction

pytestmark = pytest.mark.parametrize("level", ["fast", "full"])
Level = Literal["full", "fast"]

ASKED = Physics(
    gravity=(0.0, 0.0, -1.6),
    bounce_threshold=0.5,
    enable_pcm=False,
    enable_tgs=False,
    enable_ccd=True,
    enable_enhanced_determinism=True,
    enable_friction_every_iteration=False,
    timestep=0.004,
    contact_offset=0.05,
    rest_offset=0.01,
    solver_position_iterations=33,
    solver_velocity_iterations=3,
    sleep_threshold=0.25,
    sdf=SdfConfig(0.02, 4, 2),
)


def messages(plan: ScenePlan, level: Level) -> list[str]:
    sink = Sink()
    batch = instantiate(plan, sink, render=False, audit=level)
    if batch is not None:
        batch.close()
    found = sink.diagnostics()
    assert {d.code for d in found} <= {"SC802"}
    return [d.message for d in found]


def told(plan: ScenePlan, level: Level, *words: str) -> bool:
    return any(all(word in message for word in words) for message in messages(plan, level))


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("shape", ("contact_offset", "rest_offset")),
        ("body", ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")),
        (
            "scene",
            (
                "gravity",
                "bounce_threshold",
                "enable_pcm",
                "enable_tgs",
                "enable_ccd",
                "enable_enhanced_determinism",
                "enable_friction_every_iteration",
            ),
        ),
        ("sdf", ("spacing", "subgridSize", "num_threads_for_construction")),
    ],
)
def test_settings_that_are_not_set(
    kind: str, names: tuple[str, ...], level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = replace(plan, physics=ASKED)
    assert not messages(asked, level)
    set_it = engine._set_config
    monkeypatch.setattr(engine, "_set_config", lambda it, *given: None if it == kind else set_it(it, *given))
    found = messages(asked, level)
    for name in names:
        assert any(f" {name} = " in message for message in found), (name, found)


def test_settings_that_nobody_asked_for(level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    set_them = engine.engine_settings
    monkeypatch.setattr(build, "engine_settings", lambda _: set_them(ASKED))
    found = messages(plan, level)
    for name in ("gravity", "enable_ccd", "contact_offset", "sleep_threshold", "spacing"):
        assert any(f" {name} = " in message for message in found), (name, found)


def test_settings_of_the_process_that_the_plan_leaves_alone(level: Level, plan: ScenePlan) -> None:
    before, config = physx.get_shape_config(), physx.get_shape_config()
    config.contact_offset = 0.03
    try:
        physx.set_shape_config(config)
        assert not messages(plan, level)
    finally:
        physx.set_shape_config(before)


def test_time_step_that_is_not_set(level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    new_scene = build.new_scene
    monkeypatch.setattr(build, "new_scene", lambda _, **more: new_scene(plan, **more))
    assert told(replace(plan, physics=ASKED), level, "timestep = 0.01", "0.004")


@pytest.mark.parametrize("default", [None, Friction(0.8, 0.7, 0.2)])
def test_swapped_frictions(
    default: Friction | None, level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the plan's default material, or of the shape that names one where the plan says nothing of it."""

    def swapped(static_friction: float, dynamic_friction: float, restitution: float) -> Any:
        return physx.PhysxMaterial(dynamic_friction, static_friction, restitution)

    asked = replace(plan, physics=Physics(default_material=default))
    assert not messages(asked, level)
    monkeypatch.setattr(assets, "_make_physical_material", swapped)
    if default is None:
        assert told(asked, level, "'cube'", "static_friction = 0.5", "0.6")
    else:
        assert told(asked, level, "'post'", "static_friction = 0.7", "0.8")


def test_another_default_material_than_the_engines(
    level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = physx.PhysxMaterial(0.9, 0.9, 0.0)
    monkeypatch.setattr(assets, "physx", _With(physx, get_default_material=lambda: own))
    assert told(plan, level, "'post'", "static_friction = 0.9", "0.3")


class _With:
    """A module with something else under one name."""

    def __init__(self, module: Any, **instead: Callable[..., Any]) -> None:
        self._module = module
        self.__dict__.update(instead)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)


def alike(plan: ScenePlan) -> ScenePlan:
    """All entities at one place, so that no pose tells one from another."""
    place = constant([0, 0, 1, 1, 0, 0, 0])
    return replace(plan, entities=tuple(replace(entity, pose=place) for entity in plan.entities))


@pytest.mark.parametrize("number", [0, 3])
def test_build_order(number: int, level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two entities of one pose change places, in the first scene or in the last."""
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        for each, scene in enumerate(scenes):
            fill([scene], _swapped(turns) if each == number else turns, progress)

    asked = alike(plan)
    assert not messages(asked, level)
    monkeypatch.setattr(build, "fill_scenes", filled)
    assert told(asked, level, "'cube'", f"in scene {number}:", "build order", "'post'")


def _swapped(turns: list[Any]) -> list[Any]:
    first, second, third, *others = turns
    return [first, third, second, *others]


def test_objects_handed_out_for_one_another(level: Level, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch) -> None:
    """The batch hands out each other's objects."""
    fill = build.fill_scenes

    def filled(scenes: Any, turns: Any, progress: Any) -> None:
        fill(scenes, turns, progress)
        turns[1].objs[:], turns[2].objs[:] = turns[2].objs[:], turns[1].objs[:]

    monkeypatch.setattr(build, "fill_scenes", filled)
    assert told(alike(plan), level, "'cube'", "entity = another")
