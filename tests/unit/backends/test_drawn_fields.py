"""What a reset may draw anew: one table and its errors."""

from __future__ import annotations

import gc
import io
from typing import Any

import pytest

import scenecc
from scenecc.backends.sapien import assets, live_properties
from scenecc.inspect.varying import entity_fields
from scenecc.plan import body, constraint, rendering, scene
from scenecc.plan.articulation import JOINT_STATE_FIELDS, VELOCITY_FIELDS, ArticulationStructure, Joint
from scenecc.plan.properties import Quantity
from scenecc.plan.schema import plan_fields

HOLDERS = (
    body.BodyStructure, body.Inertial, body.PhysicalMaterial, body.VisualMaterial, body.CollisionShape,
    body.VisualShape, ArticulationStructure, Joint, constraint.Drive, constraint.AxisDrive,
    constraint.AxisLimit, constraint.Distance,
    constraint.Gear, constraint.Constraint, rendering.Light, rendering.Camera, rendering.Perspective,
    rendering.Intrinsic, rendering.Orthographic, rendering.Environment, rendering.Shadow, rendering.SpotLight,
    scene.Entity,
)  # fmt: skip
MOTION = {
    *VELOCITY_FIELDS, *JOINT_STATE_FIELDS, "pose", "target", "linear_velocity_target", "angular_velocity_target"
}  # fmt: skip
"""What states of motion hold, and the poses of lights and cameras, which entities have."""

TEXT = """
scenecc: 1
draws: {{u: {{uniform: [0.5, 1]}}}}
entities:
  cube: {{{keys}, shapes: [{{type: box, half_size: [0.1, 0.1, 0.1]}}]}}
"""


def loaded(keys: str, **options: Any) -> scenecc.SceneBatch:
    return scenecc.load_scene(io.StringIO(TEXT.format(keys=keys)), num_scenes=3, render=False, **options)


def test_exactly_the_fields_that_a_reset_may_draw_can_be_set() -> None:
    allowed = {
        (holder, slot.name)
        for holder in HOLDERS
        for slot in plan_fields(holder)
        if isinstance(slot.kind, Quantity) and slot.kind.reset and slot.name not in MOTION
    }
    known = live_properties.LIVE_PROPERTIES.keys() | live_properties.DEPENDENT_PROPERTIES.keys()
    assert allowed == {(holder, field) for holder, field in known if field not in MOTION}


@pytest.mark.parametrize(
    ("keys", "given", "message"),
    [
        ("mass: '${u - 0.1}'", 0.1, r"'cube' in scene 1: the drawn mass is 0.0, but must be above 0 and"),
        ("mass: '${1 / u}'", 0.0, "'cube' in scene 1: its mass has no value"),
        ("mass: '${1e30 / u}'", 1e-30, "'cube' in scene 1: the drawn mass is 1e.60; values must be finite"),
        (
            "material: {physical: {static_friction: '${u}'}}",
            0.2,
            "scene 1: the drawn dynamic friction exceeds the static friction",
        ),
        (
            "inertial: {mass: 1, com: [0, 0, 0], inertia: [1, 1, '${u}']}",
            3.0,
            "'cube.inertial' in scene 1: a drawn moment of inertia exceeds the sum of the others",
        ),
    ],
)
def test_a_reset_with_values_out_of_range_changes_nothing(keys: str, given: float, message: str) -> None:
    batch = loaded(f"{keys}, pose: [0, 0, '${{u}}']")
    before = batch.state()
    with pytest.raises(ValueError, match=message):
        batch.reset(seed=4, draws={"u": [0.6, given, 0.7]})
    assert batch.state() == before


def test_drawn_materials_count_towards_the_limit_of_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    gc.collect()  # batches that other tests have dropped
    monkeypatch.setattr(assets, "MATERIAL_LIMIT", len(assets._live_materials) + 2)  # pyright: ignore[reportPrivateUsage]
    with pytest.raises(scenecc.SceneError, match="SC821"):
        loaded("material: {physical: {restitution: {uniform: [0.5, 0.6]}}}", seed=1)


def test_a_state_of_another_plan_is_refused() -> None:
    batch, other = loaded("mass: {uniform: [1, 2]}"), loaded("linear_damping: {uniform: [1, 2]}")
    with pytest.raises(ValueError, match=r"'cube\.mass', which a reset draws, is missing"):
        batch.set_state(other.state())
    with pytest.raises(ValueError, match=r"does not draw 'cube\.mass'"):
        scenecc.load_scene(io.StringIO(TEXT.format(keys="mass: 1")), num_scenes=3, render=False).set_state(
            batch.state()
        )


def test_a_dry_run_marks_what_a_reset_draws() -> None:
    keys = "mass: {uniform: [1, 2]}, density: {uniform: [1, 2]}, color: {uniform: [[0, 0, 0], [1, 1, 1]]}"
    plan = scenecc.compile_scene(io.StringIO(TEXT.format(keys=keys)), num_scenes=3)
    assert {field.field: field.at_reset for field in entity_fields(plan.entities[0], plan).varying} == {
        "mass": True,
        "shapes[0].density": False,
        "shapes[0].material.base_color": True,
    }
