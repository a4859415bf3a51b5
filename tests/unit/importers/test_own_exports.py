"""Scenes of this repository, exported as MJCF and imported again: the same bodies, joints and constraints."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from scenecc import Scene, open_scene
from scenecc.backends.sapien.measure import measure_bodies
from scenecc.importers.import_scene import import_scene

if TYPE_CHECKING:
    from scenecc.plan.snapshot import MeasuredBody, MeasuredJoint

pytest.importorskip("mujoco")

SCENES = Path(__file__).parents[3] / "scenes"

NOT_IN_MJCF = {
    "knobs/dish": "a triangle mesh collides as its hull",
    "knobs/ghost": "a shape that collides with nothing has no contacts",
    "knobs/slider": "a body with locked axes becomes one on slides",
    "constraints/cogs": "a gear",
    "constraints/leash": "a tendon",
    "constraints/lift": "a drive that leaves an axis free",
}


def measured_bodies(scene: Scene, *, imported: bool = False) -> dict[str, MeasuredBody]:
    """The bodies of the first scene, by ENTITY or ENTITY/LINK; those of the imported file by their names there."""
    with scene.build(render=False, scene_idxs=[0]) as batch:
        (found,) = measure_bodies(batch).scenes
    bodies: dict[str, MeasuredBody] = {}
    for entity in found.entities:
        name = entity.entity.name.removeprefix("out/")
        for body in entity.bodies:
            # A slash in a name of MuJoCo's becomes an underscore; prefabs add a second name.
            prefab = imported and len(entity.bodies) == 1 and name.count("/")
            own = f"{name}/{body.name}" if len(entity.bodies) > 1 else name
            bodies[name.partition("/")[0] if prefab else own.replace("/", "_")] = body
    return bodies


def joint_facts(joint: MeasuredJoint) -> list[float]:
    """Type, limits and drive; MuJoCo counts positions from the initial one."""
    limits = np.clip(np.array(joint.limits) - joint.qpos, -1e9, 1e9)
    target = joint.drive_target - joint.qpos if joint.stiffness else 0.0
    drive = (joint.stiffness, joint.damping, min(joint.force_limit, 1e9), target)
    return [float(joint.type == "prismatic"), *limits, *drive]


@pytest.mark.parametrize(
    "path", sorted([*SCENES.glob("*.yaml"), *SCENES.glob("recipes/*.yaml")]), ids=lambda path: path.stem
)
def test_an_exported_mjcf_is_imported_again(path: Path, tmp_path: Path) -> None:
    scene = open_scene(path)
    scene.export(tmp_path / "out.xml")
    import_scene(tmp_path / "out.xml", tmp_path / "back.yaml", allow={"tendons"})
    again = open_scene(tmp_path / "back.yaml")
    expected, found = measured_bodies(scene), measured_bodies(again, imported=True)
    for name, body in expected.items():
        if f"{path.stem}/{name}" in NOT_IN_MJCF:
            continue
        other = found[name]
        assert other.pose[:3] == pytest.approx(body.pose[:3], abs=1e-5), name
        assert abs(np.dot(other.pose[3:], body.pose[3:])) == pytest.approx(1, abs=1e-6), name
        assert Counter(each.kind for each in other.shapes) == Counter(each.kind for each in body.shapes), name
        if body.mass is not None and other.mass is not None and body.body_type != "kinematic":
            assert other.mass.mass == pytest.approx(body.mass.mass, rel=1e-5), name
            assert sorted(other.mass.inertia) == pytest.approx(sorted(body.mass.inertia), rel=1e-4), name
        if body.joint is not None and body.joint.type != "fixed":
            assert other.joint is not None
            assert joint_facts(other.joint) == pytest.approx(joint_facts(body.joint), abs=1e-5, rel=1e-4), name
    constraints = {one.name for one in scene.plan.constraints if f"{path.stem}/{one.name}" not in NOT_IN_MJCF}
    assert {one.name.removeprefix("out/") for one in again.plan.constraints} == constraints
