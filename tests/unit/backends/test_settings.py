"""SAPIEN's process-wide defaults are as they were after every build, whatever came of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fidelity.hand import component
from sapien import physx

from scenecc.backends.sapien import build, instantiate
from scenecc.backends.sapien.engine import engine_settings
from scenecc.diagnostics import Sink
from scenecc.plan import Physics, ScenePlan, SdfConfig
from scenecc.plan.body import Friction

ALL = Physics(
    timestep=0.005,
    gravity=(1.0, 2.0, 3.0),
    bounce_threshold=0.5,
    enable_pcm=False,
    enable_tgs=False,
    enable_ccd=True,
    enable_enhanced_determinism=True,
    enable_friction_every_iteration=False,
    cpu_workers=2,
    default_material=Friction(0.7, 0.6, 0.5),
    contact_offset=0.04,
    rest_offset=0.01,
    solver_position_iterations=3,
    solver_velocity_iterations=4,
    sleep_threshold=0.25,
    sdf=SdfConfig(0.02, 4, 2),
)


def state() -> tuple[Any, ...]:
    material = physx.get_default_material()
    scene = physx.get_scene_config().__getstate__()
    return (
        (scene[0].tolist(), *scene[1:]),
        physx.get_shape_config().__getstate__(),
        physx.get_body_config().__getstate__(),
        physx.get_sdf_config().__getstate__(),
        (material.static_friction, material.dynamic_friction, material.restitution),
    )


def workers() -> int:
    """How many threads a new system starts: the one setting that no property shows."""
    before = threads()
    system = physx.PhysxCpuSystem()
    started = threads() - before  # others may end meanwhile
    del system
    return len(started)


def threads() -> set[str]:
    return {task.name for task in Path("/proc/self/task").iterdir()}


@pytest.fixture
def others_settings() -> Iterator[None]:
    """Somebody else has changed every default before us."""
    scene, shape = physx.get_scene_config(), physx.get_shape_config()
    body, sdf = physx.get_body_config(), physx.get_sdf_config()
    material = physx.get_default_material()
    numbers = material.static_friction, material.dynamic_friction, material.restitution
    down: Any = [0, 0, -1]
    physx.set_scene_config(gravity=down, bounce_threshold=1.5, enable_tgs=False, cpu_workers=3)
    physx.set_shape_config(0.03, 0.002)
    physx.set_body_config(7, 3, 0.1)
    physx.set_sdf_config(0.03, 5, 3)
    physx.set_default_material(0.55, 0.45, 0.35)
    yield
    physx.set_scene_config(scene)
    physx.set_shape_config(shape)
    physx.set_body_config(body)
    physx.set_sdf_config(sdf)
    physx.set_default_material(*numbers)


def test_process_wide_settings_are_restored_after_a_build(plan: ScenePlan, others_settings: None) -> None:
    before, material = state(), physx.get_default_material()
    assert workers() == 3
    batch = instantiate(replace(plan, physics=ALL), Sink(), render=False)
    assert batch is not None
    config = batch.scenes[0].physx_system.config
    assert config.gravity.tolist() == [1, 2, 3]
    assert config.enable_ccd
    assert state() == before
    assert physx.get_default_material() is material
    assert workers() == 3


def test_the_number_of_workers_is_set_and_restored(plan: ScenePlan, others_settings: None) -> None:
    for wanted in (0, 2):
        with engine_settings(Physics(cpu_workers=wanted)):
            assert workers() == wanted
        assert workers() == 3
    with engine_settings(Physics(enable_ccd=True)):
        assert workers() == 3
        assert physx.get_scene_config().enable_ccd


def test_settings_that_the_plan_omits_keep_the_process_defaults(plan: ScenePlan, others_settings: None) -> None:
    """A default that somebody set is what a hand-written scene would have got."""
    batch = instantiate(replace(plan, physics=Physics(enable_ccd=True)), Sink(), render=False)
    assert batch is not None
    config = batch.scenes[0].physx_system.config
    assert config.gravity.tolist() == [0, 0, -1]
    assert config.enable_ccd
    shape = component(batch, "table").collision_shapes[0]
    assert shape.contact_offset == pytest.approx(0.03)
    assert shape.physical_material.static_friction == pytest.approx(0.55)
    assert component(batch, "cube").solver_position_iterations == 7


@pytest.mark.parametrize("error", [RuntimeError("engine"), KeyboardInterrupt()])
def test_process_wide_settings_are_restored_after_a_failure(
    error: BaseException, plan: ScenePlan, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, scenes = state(), []
    new_scene = build.new_scene

    def fail(given: Any, turns: Any, progress: Any) -> None:
        scenes.extend(given)
        raise error

    monkeypatch.setattr(build, "fill_scenes", fail)
    with pytest.raises(type(error)):
        instantiate(replace(plan, physics=ALL), Sink(), render=False)
    assert state() == before
    assert len(scenes) == 4
    assert all(scene.entities == [] for scene in scenes)
    assert build.new_scene is new_scene


def test_sdf_settings_reach_the_engine() -> None:
    before = state()
    with engine_settings(Physics(sdf=SdfConfig(spacing=0.02))):
        assert physx.get_sdf_config().spacing == pytest.approx(0.02)
        assert physx.get_sdf_config().subgridSize == 6
    assert state() == before
