"""Twelve things of mixed shapes on a table: how far apart they are, as PhysX and coal measure it.

`SCENECC_PLACED_SCENES=4096` sets the number of scenes; coal is judged by where it is installed (`pip install coal`).
"""

from __future__ import annotations

import os
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from scenecc import ScenePlan, compile_scene, load_scene
from scenecc.geometry.rotation_arrays import rotation_matrix
from scenecc.geometry.surfaces import revolved_parts
from scenecc.plan.geometry import Cone

SCENES = int(os.environ.get("SCENECC_PLACED_SCENES", "100"))
THINGS, APART = 12, 0.01
SHAPES: list[dict[str, Any]] = [
    {"type": "box", "half_size": [0.03, 0.02, 0.015]},
    {"type": "sphere", "radius": 0.025},
    {"type": "cylinder", "radius": 0.025, "half_length": 0.03, "axis": "z"},
    {"type": "capsule", "radius": 0.018, "half_length": 0.03, "axis": "z"},
    {"type": "cone", "radius": 0.03, "half_length": 0.03, "axis": "z"},
]
NAMES = [f"thing_{i}" for i in range(THINGS)]


@cache
def plan(num_scenes: int) -> ScenePlan:
    table = {"body_type": "static", "shapes": [{"type": "box", "half_size": [0.4, 0.3, 0.02]}]}
    turned = {"on": "table", "yaw_deg": {"uniform": [0, 360]}, "apart": APART}
    # Capsules lie, at any heading.
    lying = {"on": "table", "rpy_deg": [90, 0, {"uniform": [0, 360]}], "apart": APART}
    things = {
        name: {"place": lying if i % 5 == 3 else turned, "shapes": [SHAPES[i % 5]]} for i, name in enumerate(NAMES)
    }
    physics = {"contact_offset": 2 * APART, "gravity": [0, 0, 0]}
    entities = {"table": table, **things}
    return compile_scene({"scenecc": 1, "num_scenes": num_scenes, "physics": physics, "entities": entities})


def poses(num_scenes: int) -> Any:
    """(things, scenes, 7)."""
    return np.stack([one.pose.data for one in plan(num_scenes).entities if one.name in NAMES])


def test_none_are_nearer_by_the_contacts_of_the_engine() -> None:
    separations: list[float] = []
    with load_scene(plan(SCENES), render=False) as batch:
        for scene in batch.scenes:
            scene.step()
            for contact in scene.get_contacts():
                if "table" not in {body.entity.name for body in contact.bodies}:
                    separations += [point.separation for point in contact.points]
    assert len(separations) > 2 * SCENES
    assert APART - 2e-5 <= min(separations) < APART + 2e-4


def test_none_are_nearer_by_coal() -> None:
    coal = pytest.importorskip("coal")
    cone: Any = next(one for one in plan(SCENES).entities if one.name == "thing_4").structures[0]
    (shape,) = cone.collisions
    assert isinstance(shape.geometry, Cone)
    (hull,) = revolved_parts(shape.geometry.profile(*shape.geometry.sizes(0)))
    points = coal.StdVec_Vec3s()
    points.extend([np.array([-z, y, x]) for x, y, z in hull])  # its axis is x, and stands upright
    made = [
        coal.Box(0.06, 0.04, 0.03), coal.Sphere(0.025), coal.Cylinder(0.025, 0.06), coal.Capsule(0.018, 0.06),
        coal.Convex.convexHull(points, True, "Qt"),
    ]  # fmt: skip
    found = poses(SCENES).astype(float)
    turn = np.moveaxis(rotation_matrix(found[..., 3:].reshape(-1, 4).T), -1, 0).reshape(THINGS, SCENES, 3, 3)
    least = np.inf
    for a, b in combinations(range(THINGS), 2):
        close = np.linalg.norm(found[a, :, :3] - found[b, :, :3], axis=1) < 0.12
        for row in np.flatnonzero(close).tolist():
            at = [coal.Transform3s(turn[one, row], found[one, row, :3]) for one in (a, b)]
            pair = made[a % 5], at[0], made[b % 5], at[1]
            least = min(least, coal.distance(*pair, coal.DistanceRequest(), coal.DistanceResult()))
    assert APART - 2e-6 <= least < APART + 2e-4


def test_batches_of_8_and_of_all_are_the_same() -> None:
    assert poses(8).tobytes() == poses(SCENES)[:, :8].tobytes()
