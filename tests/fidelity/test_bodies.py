"""Every body type, knob and physics setting of the language, written in YAML, against hand-written SAPIEN."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from fidelity.compare import assert_same_scene, assert_same_trajectory
from fidelity.hand import Case, box_shape, built, counts, flags, plan_of
from fidelity.hand import by_hand as case_by_hand
from fidelity.yaml_cases import SCENES, assert_same, by_hand, compare, compare_each, document, load
from sapien import Pose, physx

from scenecc.plan import BodyStructure, Inertial, constant
from scenecc.spec.body import BodySpec
from scenecc.spec.physics import PhysicsSpec

SHAPES = """
shapes:
  - {type: box, half_size: [0.05, 0.06, 0.07]}
  - {type: box, half_size: [0.02, 0.02, 0.2], density: 300}
"""


def shapes(builder: Any) -> None:
    builder.add_box_collision(half_size=[0.05, 0.06, 0.07])
    builder.add_box_collision(half_size=[0.02, 0.02, 0.2], density=300)


def scaled(component: Any, mass: float) -> None:
    """A mass and the inertia that belongs to it (`component.mass = m` alone leaves the inertia of the old one)."""
    before, inertia = float(component.mass), np.asarray(component.inertia, np.float64)
    component.mass = mass
    component.inertia = inertia * (mass / before)


def moved(component: Any, com: list[float]) -> None:
    """A centre of mass; mass and inertia stay, and so do the principal axes."""
    component.set_cmass_local_pose(Pose(com, component.cmass_local_pose.q))


AXES = ["x", "y", "z", "rx", "ry", "rz"]


def setter(name: str) -> Any:
    return lambda component, value: getattr(component, f"set_{name}")(value)


SPEEDS = [0.3, 1.0, 20.0]
MOVING = [[1, 2, 3], [0, 0, 0], [-1, 0.5, 0]]
KNOBS: dict[str, tuple[list[Any], Any]] = {
    "mass": ([0.3, 2.5, 11.0], scaled),
    "com": ([[0.1, 0, -0.05], [0, 0, 0], [-0.02, 0.01, 0.3]], moved),
    "gravity": ([False, True, False], lambda c, pulls: c.set_disable_gravity(not pulls)),
    "locked_axes": (
        [["ry", "x", "z"], [], ["rx"]],
        lambda c, locked: c.set_locked_motion_axes([axis in locked for axis in AXES]),
    ),
    **{name: (MOVING, setter(name)) for name in ("linear_velocity", "angular_velocity")},
    **{name: ([0.0, 0.5, 3.25], setter(name)) for name in ("linear_damping", "angular_damping")},
    **{name: (SPEEDS, setter(name)) for name in ("max_linear_velocity", "max_angular_velocity")},
    "max_depenetration_velocity": ([0.1, 1.0, 20.0], setter("max_depenetration_velocity")),
    "max_contact_impulse": ([0.01, 1.0, 20.0], setter("max_contact_impulse")),
    "sleep_threshold": ([0.0, 0.5, 5.0], setter("sleep_threshold")),
    "solver_position_iterations": ([1, 4, 40], setter("solver_position_iterations")),
    "solver_velocity_iterations": ([0, 2, 8], setter("solver_velocity_iterations")),
}
"""Values by scene, and what sets one by hand."""
ELSEWHERE = {
    "pose": "every case",
    "place": "tests/unit/placing",
    "body_type": "test_body_type",
    "scene_idxs": "test_yaml_scenes.py",
    "hidden": "what is seen: test_pictures.py",
    **dict.fromkeys(("shapes", "collisions", "visuals"), "test_shapes.py"),
    "inertial": "test_inertial",
    **dict.fromkeys(("material", "density"), "test_defaults_of_a_body"),
    **dict.fromkeys(("collision_group", "collision_bits"), "test_collision_groups"),
    **dict.fromkeys(("color", "visibility", "shading_mode"), "what is seen: test_visuals.py"),
}


def test_every_key_of_a_body_is_compared() -> None:
    assert set(KNOBS) | set(ELSEWHERE) == set(BodySpec.model_fields)


@pytest.mark.parametrize("name", KNOBS)
def test_knob(name: str) -> None:
    values, set_by_hand = KNOBS[name]
    for value in values:
        compare(f"{name}: {json.dumps(value)}{SHAPES}", shapes, lambda c, value=value: set_by_hand(c, value))


BY_SCENE = {name: knob for name, knob in KNOBS.items() if name != "locked_axes"}


@pytest.mark.parametrize("name", BY_SCENE)
def test_knob_by_scene(name: str) -> None:
    values, set_by_hand = KNOBS[name]
    text = f"{name}: {{per_scene: {json.dumps(values)}}}{SHAPES}"
    compare_each(text, lambda b, _: shapes(b), lambda c, i: set_by_hand(c, values[i]))


@pytest.mark.parametrize("kind", ["dynamic", "kinematic", "static"])
def test_body_type(kind: str) -> None:
    compare(f"body_type: {kind}{SHAPES}", shapes, kind=kind)


def test_none_has_no_physics() -> None:
    with load(document("body_type: none\nvisuals: [{type: sphere, radius: 1}]")) as batch:
        assert all(
            not [c for c in entity.components if "Physx" in type(c).__name__] for entity in batch.entities["body"].objs
        )


def test_inertial() -> None:
    compare(
        "inertial: {mass: 1.7, com: {p: [0.01, -0.02, 0.03], q: [0.6, 0.8, 0, 0]}, inertia: [0.011, 0.012, 0.0021]}"
        + SHAPES,
        lambda b: (
            shapes(b),
            b.set_mass_and_inertia(1.7, Pose([0.01, -0.02, 0.03], [0.6, 0.8, 0, 0]), [0.011, 0.012, 0.0021]),
        ),
    )


BOX = box_shape(0.05, 0.06, 0.07)
LOCKED = [[True, False, False, False, True, False], [False] * 6, [False, True] * 3]
GROUPS = [[2, 2, 0, 0], [1, 1, 4, 7], [3, 1, 0, 0]]
COM = [0.01, -0.02, 0.03, 0.6, 0.8, 0, 0]
INERTIAL = Inertial(constant(1.7), constant(COM), constant([0.011, 0.012, 0.0021]))
ONLY_IN_PLANS = {
    "locked axes by scene": Case(
        BodyStructure("dynamic", (BOX,), locked_motion_axes=flags(LOCKED)),
        lambda b, _: b.add_box_collision(half_size=[0.05, 0.06, 0.07]),
        lambda c, i: c.set_locked_motion_axes(LOCKED[i]),
    ),
    "groups by scene": Case(
        BodyStructure("dynamic", (BOX,), collision_groups=counts(GROUPS)),
        lambda b, i: (
            setattr(b, "collision_groups", GROUPS[i]),
            b.add_box_collision(half_size=[0.05, 0.06, 0.07]),
        ),
    ),
    "inertial without any shape": Case(
        BodyStructure("dynamic", inertial=INERTIAL),
        lambda b, _: b.set_mass_and_inertia(1.7, Pose(COM[:3], COM[3:]), [0.011, 0.012, 0.0021]),
    ),
}


@pytest.mark.parametrize("case", ONLY_IN_PLANS.values(), ids=ONLY_IN_PLANS)
def test_what_a_plan_alone_can_hold(case: Case) -> None:
    assert_same(built(plan_of(case)), case_by_hand(case))


def test_defaults_of_a_body() -> None:
    """A shape's own density goes before its material's, that before the body's material's, that before the body's."""
    rubber, ice = (0.9, 0.8, 0.5), (0.1, 0.05, 0)

    def builder(b: Any) -> None:
        named, other = physx.PhysxMaterial(*rubber), physx.PhysxMaterial(*ice)
        b.add_sphere_collision(radius=0.1, material=named, density=250)
        b.add_sphere_collision(Pose([0.1, 0, 0]), radius=0.05, material=other, density=900)
        b.add_sphere_collision(Pose([0, 0.1, 0]), radius=0.05, material=other, density=100)
        b.add_sphere_collision(Pose([0, 0, 0.1]), radius=0.05, material=physx.PhysxMaterial(0.4, 0.3, 0.1), density=250)

    compare(
        """
        material: rubber
        density: 250
        shapes:
          - {type: sphere, radius: 0.1}
          - {type: sphere, radius: 0.05, pose: [0.1, 0, 0], material: ice}
          - {type: sphere, radius: 0.05, pose: [0, 0.1, 0], material: ice, density: 100}
          - {type: sphere, radius: 0.05, pose: [0, 0, 0.1], material: {physical: {static_friction: 0.4}}}
        """,
        builder,
        rest="""
        materials:
          rubber: {physical: {static_friction: 0.9, dynamic_friction: 0.8, restitution: 0.5}}
          ice: {physical: {static_friction: 0.1, dynamic_friction: 0.05, restitution: 0, density: 900}}
        """,
    )


def test_collision_groups() -> None:
    """The one group of the file: bit 1, and it ignores itself; `cap` has no group and SAPIEN's own bits."""
    compare(
        f"collision_group: debris{SHAPES}",
        lambda b: (setattr(b, "collision_groups", [2, 1, 0, 0]), shapes(b)),
        rest="collision_groups: {debris: {ignore: [debris]}}\n",
    )
    compare(
        f"collision_bits: [4, 0xfffffff0, 3, 9]{SHAPES}",
        lambda b: (setattr(b, "collision_groups", [4, 0xFFFFFFF0, 3, 9]), shapes(b)),
    )


def test_collision_bits_of_a_shape_replace_those_of_its_body() -> None:
    def component(c: Any) -> None:
        c.collision_shapes[1].set_collision_groups([5, 4, 1, 2])

    ball = "{type: sphere, radius: 0.05, collision_bits: [5, 4, 1, 2]}"
    compare(
        f"collision_bits: [1, 3, 0, 0]\nshapes: [{{type: box, half_size: [0.05, 0.06, 0.07]}}, {ball}]",
        lambda b: (
            setattr(b, "collision_groups", [1, 3, 0, 0]),
            b.add_box_collision(half_size=[0.05, 0.06, 0.07]),
            b.add_sphere_collision(radius=0.05),
        ),
        component,
    )


def test_everything_at_once() -> None:
    moving = {name: knob for name, knob in BY_SCENE.items() if name not in ("mass", "gravity")}
    body = "\n".join(f"{name}: {{per_scene: {json.dumps(values)}}}" for name, (values, _) in moving.items())

    def component(c: Any, scene: int) -> None:
        for values, set_by_hand in moving.values():
            set_by_hand(c, values[scene])

    compare_each(body + SHAPES, lambda b, _: shapes(b), component)


SETTINGS: dict[str, tuple[str, Any]] = {
    "timestep": ("0.004", None),
    "gravity": (
        "[1, 0, -3]",
        lambda: physx.set_scene_config(gravity=[1, 0, -3]),  # pyright: ignore[reportArgumentType] - a list is taken
    ),
    "bounce_threshold": ("0.1", lambda: physx.set_scene_config(bounce_threshold=0.1)),
    "enable_pcm": ("false", lambda: physx.set_scene_config(enable_pcm=False)),
    "enable_tgs": ("false", lambda: physx.set_scene_config(enable_tgs=False)),
    "enable_ccd": ("true", lambda: physx.set_scene_config(enable_ccd=True)),
    "enable_enhanced_determinism": ("true", lambda: physx.set_scene_config(enable_enhanced_determinism=True)),
    "enable_friction_every_iteration": ("false", lambda: physx.set_scene_config(enable_friction_every_iteration=False)),
    "cpu_workers": ("1", lambda: physx.set_scene_config(cpu_workers=1)),
    "default_material": (
        "{static_friction: 0.9, dynamic_friction: 0.8, restitution: 0.6}",
        lambda: physx.set_default_material(0.9, 0.8, 0.6),
    ),
    "contact_offset": ("0.03", lambda: physx.set_shape_config(contact_offset=0.03)),
    "rest_offset": ("-0.002", lambda: physx.set_shape_config(rest_offset=-0.002)),
    "solver_position_iterations": ("3", lambda: physx.set_body_config(solver_position_iterations=3)),
    "solver_velocity_iterations": ("5", lambda: physx.set_body_config(solver_velocity_iterations=5)),
    "sleep_threshold": ("0.5", lambda: physx.set_body_config(sleep_threshold=0.5)),
}
NOT_HERE = {"sdf": "needs a distance field", "scene_spacing": "needs a GPU", "gpu_memory": "needs a GPU"}


@pytest.fixture
def engine_defaults() -> Iterator[None]:
    """Puts back what a person sets for the whole process."""
    scene, shape, body = physx.get_scene_config(), physx.get_shape_config(), physx.get_body_config()
    material = physx.get_default_material()
    friction = material.static_friction, material.dynamic_friction, material.restitution
    yield
    physx.set_scene_config(scene)
    physx.set_shape_config(shape)
    physx.set_body_config(body)
    physx.set_default_material(*friction)


def test_every_setting_is_compared() -> None:
    assert set(SETTINGS) | set(NOT_HERE) == set(PhysicsSpec.model_fields)


@pytest.mark.parametrize("name", SETTINGS)
def test_setting(name: str, engine_defaults: None) -> None:
    value, set_by_hand = SETTINGS[name]
    with load(document(SHAPES, f"physics: {{{name}: {value}}}\n")) as batch:
        if set_by_hand:
            set_by_hand()
        hand = [by_hand(shapes) for _ in range(SCENES)]
        if name == "timestep":
            for scene in hand:
                scene.timestep = 0.004
        assert_same(batch, hand)


def test_half_a_material_takes_the_rest_from_the_default(engine_defaults: None) -> None:
    text = document(
        "shapes: [{type: sphere, radius: 0.1, material: {physical: {restitution: 0}}}]",
        "physics: {default_material: {static_friction: 0.9, dynamic_friction: 0.8, restitution: 0.6}}\n",
    )
    with load(text) as batch:
        physx.set_default_material(0.9, 0.8, 0.6)
        hand = by_hand(lambda b: b.add_sphere_collision(radius=0.1, material=physx.PhysxMaterial(0.9, 0.8, 0)))
        assert_same_scene(batch.scenes[0], hand)
        assert_same_trajectory(batch.scenes[:1], [hand])
