"""Every body type and every knob of a body against hand-written SAPIEN."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sapien
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import SCENES, Case, box_shape, built, by_hand, counts, flags, plan_of

from scenecc.backends.sapien.properties import BODY_PROPERTIES
from scenecc.plan import BodyStructure, Entity, Inertial, Physics, ScenePlan, constant, per_scene
from scenecc.plan.body import Friction

SIZES = [0.05, 0.06, 0.07]
SHAPES = (box_shape(*SIZES), box_shape(0.02, 0.02, 0.2, density=constant(300.0)))
INERTIAL = Inertial(
    constant(1.7), constant([0.01, -0.02, 0.03, 0.9238795, 0.3826834, 0, 0]), constant([0.011, 0.012, 0.0021])
)

KNOBS: dict[str, tuple[Any, list[Any]]] = {
    "disable_gravity": (flags, [True, False, True]),
    "locked_motion_axes": (flags, [[True, False, False, False, True, False], [False] * 6, [False, True] * 3]),
    "linear_damping": (per_scene, [0.0, 0.5, 3.25]),
    "angular_damping": (per_scene, [0.0, 0.5, 3.25]),
    "max_linear_velocity": (per_scene, [0.3, 1.0, 20.0]),
    "max_angular_velocity": (per_scene, [0.3, 1.0, 20.0]),
    "max_depenetration_velocity": (per_scene, [0.1, 1.0, 20.0]),
    "max_contact_impulse": (per_scene, [0.01, 1.0, 20.0]),
    "sleep_threshold": (per_scene, [0.0, 0.5, 5.0]),
    "solver_position_iterations": (counts, [1, 4, 40]),
    "solver_velocity_iterations": (counts, [0, 2, 8]),
    "linear_velocity": (per_scene, [[1, 2, 3], [0, 0, 0], [-1, 0.5, 0]]),
    "angular_velocity": (per_scene, [[1, 2, 3], [0, 0, 0], [-1, 0.5, 0]]),
}


def add_shapes(builder: Any, scene: int) -> None:
    builder.add_box_collision(half_size=SIZES)
    builder.add_box_collision(half_size=[0.02, 0.02, 0.2], density=300.0)


def assert_same(case: Case) -> None:
    batch, hand = built(plan_of(case)), by_hand(case)
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)


def test_every_knob_has_a_case() -> None:
    assert set(KNOBS) == set(BODY_PROPERTIES.by_field)


@pytest.mark.parametrize("name", KNOBS)
def test_knob(name: str) -> None:
    make, values = KNOBS[name]

    def by_hand_set(component: Any, scene: int) -> None:
        getattr(component, f"set_{name}")(values[scene])

    assert_same(Case(BodyStructure("dynamic", SHAPES, **{name: make(values)}), add_shapes, by_hand_set))


@pytest.mark.parametrize("kind", ["dynamic", "kinematic", "static"])
def test_body_type(kind: Any) -> None:
    assert_same(Case(BodyStructure(kind, SHAPES), add_shapes, kind=kind))


def test_mass_scales_the_inertia_that_the_densities_give() -> None:
    masses = [0.3, 2.5, 11.0]

    def scale(component: Any, scene: int) -> None:
        mass, inertia = component.mass, component.inertia.astype(np.float64)
        component.mass = masses[scene]
        component.inertia = inertia * (masses[scene] / mass)

    assert_same(Case(BodyStructure("dynamic", SHAPES, mass=per_scene(masses)), add_shapes, scale))


def test_inertial() -> None:
    def give(builder: Any, scene: int) -> None:
        add_shapes(builder, scene)
        com = sapien.Pose([0.01, -0.02, 0.03], [0.9238795, 0.3826834, 0, 0])
        builder.set_mass_and_inertia(1.7, com, [0.011, 0.012, 0.0021])

    assert_same(Case(BodyStructure("dynamic", SHAPES, inertial=INERTIAL), give))


def test_inertial_without_any_shape() -> None:
    def give(builder: Any, scene: int) -> None:
        com = sapien.Pose([0.01, -0.02, 0.03], [0.9238795, 0.3826834, 0, 0])
        builder.set_mass_and_inertia(1.7, com, [0.011, 0.012, 0.0021])

    assert_same(Case(BodyStructure("dynamic", inertial=INERTIAL), give))


def test_all_knobs_at_once() -> None:
    def by_hand_set(component: Any, scene: int) -> None:
        for name, (_, values) in KNOBS.items():
            getattr(component, f"set_{name}")(values[scene])

    structure = BodyStructure("dynamic", SHAPES, **{name: make(values) for name, (make, values) in KNOBS.items()})
    assert_same(Case(structure, add_shapes, by_hand_set))


PHYSICS: dict[str, Any] = {
    "timestep": 0.005,
    "gravity": (0.5, 0.0, -3.7),
    "bounce_threshold": 0.1,
    "enable_pcm": False,
    "enable_tgs": False,
    "enable_ccd": True,
    "enable_enhanced_determinism": True,
    "enable_friction_every_iteration": False,
    "cpu_workers": 2,
    "default_material": Friction(0.9, 0.8, 0.6),
    "contact_offset": 0.05,
    "rest_offset": 0.005,
    "solver_position_iterations": 3,
    "solver_velocity_iterations": 4,
    "sleep_threshold": 0.5,
}


@pytest.mark.parametrize("name", PHYSICS)
def test_physics(name: str, engine_defaults: None) -> None:
    """By hand the process-wide default is set and stays; the fixture puts it back."""
    from sapien import physx

    value = PHYSICS[name]
    case = Case(BodyStructure("dynamic", SHAPES), add_shapes, physics=Physics(**{name: value}))
    batch = built(plan_of(case))
    config = {"contact_offset": "shape", "rest_offset": "shape", "timestep": None, "default_material": None}
    if name == "default_material":
        physx.set_default_material(0.9, 0.8, 0.6)
    elif name in ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold"):
        physx.set_body_config(**{name: value})
    elif config.get(name) == "shape":
        physx.set_shape_config(**{name: value})
    elif name != "timestep":
        physx.set_scene_config(**{name: value})
    hand = by_hand(case)
    if name == "timestep":
        for scene in hand:
            scene.timestep = value
    for ours, theirs in zip(batch.scenes, hand, strict=True):
        assert_same_scene(ours, theirs)
    assert_same_trajectory(batch.scenes, hand)


@pytest.fixture
def engine_defaults() -> Any:
    from sapien import physx

    scene, shape, body = physx.get_scene_config(), physx.get_shape_config(), physx.get_body_config()
    material = physx.get_default_material()
    friction = material.static_friction, material.dynamic_friction, material.restitution
    yield
    physx.set_scene_config(scene)
    physx.set_shape_config(shape)
    physx.set_body_config(body)
    physx.set_default_material(*friction)


def test_rest_offset_alone_is_below_the_contact_offset() -> None:
    """The value above is no accident: SAPIEN's contact offset is 0.01."""
    assert PHYSICS["rest_offset"] < 0.01


def test_none_is_an_entity_without_physics() -> None:
    every = tuple(range(SCENES))
    body = Entity("marker", every, constant([1, 2, 3, 1, 0, 0, 0]), (BodyStructure("none"),))
    batch = built(ScenePlan("marker", SCENES, (body,), Physics()))
    for scene in batch.scenes:
        assert [(e.name, e.components) for e in scene.entities] == [("marker", [])]
    assert batch.entities["marker"].pose.tolist() == [[1, 2, 3, 1, 0, 0, 0]] * SCENES
