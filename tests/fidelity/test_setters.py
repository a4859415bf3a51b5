"""Every row of the backend's tables of setters: one field with an unusual value, against hand-written SAPIEN."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import sapien
from fidelity.setter_arms import ARMS
from fidelity.setter_bodies import BODIES
from fidelity.setter_looks import FLAT, LOOKS, MOUNTED
from fidelity.setter_rows import RowKey, Setting, value_fields
from fidelity.setter_ties import TIES
from PIL import Image

from scenecc import load_scene
from scenecc.backends.sapien import properties
from scenecc.backends.sapien.engine import engine_settings, physx
from scenecc.backends.sapien.live_properties import DEPENDENT_PROPERTIES, LIVE_PROPERTIES
from scenecc.plan import (
    ArticulationStructure,
    BodyStructure,
    CollisionShape,
    Constraint,
    Distance,
    Drive,
    Gear,
    Inertial,
    Joint,
    Physics,
    SdfConfig,
    VisualShape,
)
from scenecc.plan.body import PhysicalMaterial, Texture, VisualMaterial
from scenecc.plan.constraint import AxisDrive, AxisLimit, DriveAxis, LimitAxis
from scenecc.plan.rendering import (
    AreaLight,
    Camera,
    Environment,
    Intrinsic,
    Light,
    Orthographic,
    Perspective,
    Shadow,
    SpotLight,
    TexturedLight,
)

SETTINGS = {"body": BODIES, "arm": ARMS, "tie": TIES, "look": LOOKS, "mounted": MOUNTED, "flat": FLAT}


def _cases(*, reset: bool) -> list[Any]:
    return [
        pytest.param(
            setting,
            key,
            id=f"{name}-{key[0].__name__}.{'.'.join(key[1:])}",
            marks=[pytest.mark.render, pytest.mark.quick] if setting.rendered else [],
        )
        for name, setting in SETTINGS.items()
        for key, row in setting.rows.items()
        if not reset or row.other is not None
    ]


@pytest.mark.parametrize(("setting", "key"), _cases(reset=False))
def test_a_field_is_built_as_by_hand(setting: Setting, key: RowKey) -> None:
    setting.assert_built(key)


@pytest.mark.parametrize(("setting", "key"), _cases(reset=True))
def test_a_field_is_reset_as_by_hand(setting: Setting, key: RowKey) -> None:
    setting.assert_reset(key)


def test_settings_of_distance_fields_are_those_of_sapien() -> None:
    """SAPIEN has one configuration of them for the process, which no scene keeps."""
    before = physx.get_sdf_config()
    usual = before.spacing, before.subgridSize, before.num_threads_for_construction
    with engine_settings(Physics(sdf=SdfConfig(spacing=0.03, subgrid_size=5, num_threads_for_construction=2))):
        config = physx.get_sdf_config()
        assert (config.spacing, config.subgridSize, config.num_threads_for_construction) == (
            pytest.approx(0.03),
            5,
            2,
        )
    after = physx.get_sdf_config()
    assert (after.spacing, after.subgridSize, after.num_threads_for_construction) == usual


PARTS = (
    BodyStructure,
    CollisionShape,
    VisualShape,
    Inertial,
    PhysicalMaterial,
    VisualMaterial,
    Texture,
    Joint,
    ArticulationStructure,
    Constraint,
    Drive,
    AxisDrive,
    AxisLimit,
    Distance,
    Gear,
    Light,
    Shadow,
    SpotLight,
    AreaLight,
    TexturedLight,
    Environment,
    Camera,
    Perspective,
    Intrinsic,
    Orthographic,
)
"""What bodies, articulations, constraints, lights and cameras are made of. Sizes of shapes are in `test_shapes.py` and
`test_visuals.py`, mimicking joints in `test_mimic.py`, environment maps below.
"""
NOT_SET = {(ArticulationStructure, "file")}


def test_every_number_of_the_plan_has_a_case() -> None:
    tested = {key[:2] for setting in SETTINGS.values() for key in setting.rows}
    assert value_fields(*PARTS) - NOT_SET <= tested


@pytest.mark.parametrize(
    ("setting", "holder", "fields"),
    [
        (BODIES, BodyStructure, properties.BODY_PROPERTIES.by_field),
        (BODIES, CollisionShape, properties.SHAPE_PROPERTIES.by_field),
        (ARMS, BodyStructure, properties.LINK_FIELDS),
        (ARMS, ArticulationStructure, properties.ARTICULATION_PROPERTIES.by_field),
        (ARMS, ArticulationStructure, properties.ROOT_PROPERTIES.by_field),
        (ARMS, Joint, properties.JOINT_PROPERTIES.by_field),
        (ARMS, Joint, properties.JOINT_FRAMES),
        (ARMS, Joint, properties.DRIVE_DEFAULTS),
        (LOOKS, BodyStructure, properties.RENDER_PROPERTIES.by_field),
    ],
)
def test_every_row_of_a_table_has_a_case(setting: Setting, holder: type, fields: Any) -> None:
    assert {(holder, field) for field in fields} <= setting.rows.keys()


def test_every_field_that_a_reset_draws_has_a_case() -> None:
    drawn = {key[:2] for setting in SETTINGS.values() for key, row in setting.rows.items() if row.other is not None}
    assert LIVE_PROPERTIES.keys() | DEPENDENT_PROPERTIES.keys() <= drawn


def test_every_axis_has_a_case() -> None:
    assert {key for key in TIES.rows if key[0] is AxisDrive} == {
        (AxisDrive, field, axis)
        for field in ("stiffness", "damping", "force_limit", "mode")
        for axis in get_args(DriveAxis)
    }
    assert {key for key in TIES.rows if key[0] is AxisLimit} == {
        (AxisLimit, field, axis) for field in ("limits", "stiffness", "damping") for axis in get_args(LimitAxis)
    }


@pytest.mark.render
def test_a_map_is_that_of_sapien_from_all_sides(tmp_path: Path) -> None:
    """Six faces of different colours, which SAPIEN lets nobody read: pictures to both sides along each axis."""
    faces = {}
    for number, face in enumerate(("px", "nx", "py", "ny", "pz", "nz")):
        faces[face] = str(tmp_path / f"{face}.png")
        Image.new("RGB", (8, 8), (40 * number + 20, 255 - 40 * number, 128)).save(faces[face])
    sides = ([0, 0, 0], [0, 0, 90], [0, 0, 180], [0, 0, 270], [0, -80, 0], [0, 80, 0])
    eyes = {
        f"eye{n}": {"pose": {"p": [0, 0, 0], "rpy_deg": rpy}, "width": 8, "height": 8} for n, rpy in enumerate(sides)
    }
    source = {"scenecc": 1, "environment": {"map": faces}, "cameras": eyes}
    hand: Any = sapien.Scene()
    hand.render_system.cubemap = sapien.render.RenderCubemap(*faces.values())
    with load_scene(source, render=True, allow_outside_assets=True) as batch:
        seen = {}
        for name, camera in batch.cameras.items():
            theirs = hand.add_camera(name, 8, 8, camera.objs[0].fovy, camera.objs[0].near, camera.objs[0].far)
            theirs.entity.pose = camera.objs[0].entity.pose
            hand.update_render()
            theirs.take_picture()
            seen[name] = camera.capture("color")["color"][0]
            assert np.array_equal(seen[name], theirs.get_picture("Color"))
        assert len({picture[4, 4].tobytes() for picture in seen.values()}) == len(sides)
