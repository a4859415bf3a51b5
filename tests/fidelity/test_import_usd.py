"""What scenecc writes as USD, read again: the same masses, poses, shapes, joints, limits and drives."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.testing import assert_allclose
from plugins.plan_parts import ROOT

from scenecc import compile_scene, open_scene
from scenecc.backends.sapien import instantiate
from scenecc.backends.sapien.measure import measure_bodies
from scenecc.diagnostics import Sink
from scenecc.importers.import_scene import import_scene
from scenecc.plan import Gear, ScenePlan

if TYPE_CHECKING:
    from scenecc.plan.snapshot import MeasuredBody, MeasuredScene

SCENES = sorted((ROOT / "scenes").glob("*.yaml"))


def measured(plan: ScenePlan) -> MeasuredScene:
    batch = instantiate(plan, Sink(), scene_idxs=[0], render=False)
    assert batch is not None
    with batch:
        return measure_bodies(batch).scenes[0]


def bodies(scene: MeasuredScene, *, imported: bool = False) -> dict[str, MeasuredBody]:
    """Bodies and links by their names, as USD can say these. An imported body of a prefab has its instance's name."""
    found: dict[str, MeasuredBody] = {}
    for entity in scene.entities:
        name = entity.entity.name.partition("/")[0] if imported else entity.entity.name
        for body in entity.bodies:
            link = f"/{body.name}" if len(entity.bodies) > 1 or body.joint is not None else ""
            found[re.sub(r"[^\w.-]", "_", name) + re.sub(r"(?<!^)[^\w.-]", "_", link)] = body
    return found


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_an_exported_usd_is_imported_again(path: Path, tmp_path: Path) -> None:
    scene = open_scene(path)
    for name, data in scene.emit("usd", name="out").files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(data)
    made = import_scene(tmp_path / "out.usda", tmp_path / "back.yaml")
    # A name of an instance's body holds a slash, which a prim has not.
    assert {loss.kind for loss in made.losses} <= {"names"}
    assert made.certificate.relative_mass < 1e-5
    planned, again = scene.plan, compile_scene(tmp_path / "back.yaml")
    before, after = bodies(measured(planned)), bodies(measured(again), imported=True)
    assert list(before) == list(after)
    for name, first in before.items():
        second = after[name]
        assert first.body_type == second.body_type
        assert_allclose(first.pose[:3], second.pose[:3], atol=1e-5, err_msg=name)
        assert abs(np.dot(first.pose[3:], second.pose[3:])) == pytest.approx(1, abs=1e-6)
        assert Counter(shape.kind for shape in first.shapes) == Counter(shape.kind for shape in second.shapes)
        if first.mass is not None and second.mass is not None:
            assert_allclose(first.mass.mass, second.mass.mass, rtol=1e-5, err_msg=name)
            assert_allclose(sorted(first.mass.inertia), sorted(second.mass.inertia), rtol=1e-4, err_msg=name)
        one, two = first.joint, second.joint
        if one is not None and two is not None and one.type != "fixed":
            assert_allclose(one.limits, two.limits, atol=1e-5)
            for field in ("stiffness", "damping", "drive_target", "drive_velocity_target"):
                assert getattr(one, field) == pytest.approx(getattr(two, field), rel=1e-4, abs=1e-6), field
            assert one.force_limit == pytest.approx(two.force_limit, rel=1e-5)
    written = [each for each in planned.constraints if 0 in each.scene_idxs and not isinstance(each.joint, Gear)]
    assert len(again.constraints) == len(written)  # a gear is not in a USD, which the export tells
