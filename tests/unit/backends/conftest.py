"""Small plans for the backend's own tests."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from plugins.sample_plans import rubbing

from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan import BodyStructure, Box, CollisionShape, Entity, Physics, ScenePlan, constant, per_scene
from scenecc.plan.body import AssetFile

ROOT = Origin("scene.yaml")
SCENES = 4


def shape(half_size: Any, *path: str | int, **knobs: Any) -> CollisionShape:
    return CollisionShape(Box(half_size), origin=ROOT.child("entities", *path), **knobs)


@pytest.fixture
def plan() -> ScenePlan:
    """Two boxes on one body, a post of other sizes by scene, and a table, in four scenes."""
    every = tuple(range(SCENES))
    cube = BodyStructure(
        "dynamic",
        (
            shape(constant([0.1, 0.1, 0.1]), "cube", "shapes", 0, material=constant(0, int)),
            shape(constant([0.02, 0.02, 0.2]), "cube", "shapes", 1),
        ),
        linear_velocity=constant([1, 0, 0.5]),
        origin=ROOT.child("entities", "cube"),
    )
    post = BodyStructure(
        "dynamic",
        (shape(per_scene([[0.02, 0.02, 0.1 + 0.1 * i] for i in every]), "post", "shapes", 0),),
        origin=ROOT.child("entities", "post"),
    )
    table = BodyStructure(
        "static", (shape(constant([1, 1, 0.1]), "table", "shapes", 0),), origin=ROOT.child("entities", "table")
    )
    marker = BodyStructure("none", origin=ROOT.child("entities", "marker"))
    arm = BodyStructure("kinematic", (shape(constant([0.1, 0.1, 0.1]), "arm", "shapes", 0),))
    starts = {
        "cube": per_scene([[0.1 * i, 0, 1 + i, 1, 0, 0, 0] for i in every]),
        "post": constant([0, 1, 1, 1, 0, 0, 0]),
        "table": constant([0, 0, -0.1, 1, 0, 0, 0]),
        "marker": constant([0, 0, 2, 1, 0, 0, 0]),
        "arm": constant([0, 0, 5, 1, 0, 0, 0]),
    }
    structures = {"table": table, "cube": cube, "post": post, "marker": marker, "arm": arm}
    return ScenePlan(
        "test",
        SCENES,
        tuple(
            Entity(name, every, starts[name], (structure,), origin=ROOT.child("entities", name))
            for name, structure in structures.items()
        ),
        Physics(),
        physical_materials=(rubbing(0.6, 0.5, 0.1),),
        origin=ROOT,
    )


PlanOf = Callable[..., ScenePlan]


@pytest.fixture
def plan_of_shapes() -> PlanOf:
    """A plan of one dynamic body in one scene, with these shapes and files."""

    def make(*shapes: CollisionShape, files: tuple[Path, ...] = (), kind: Any = "dynamic", **more: Any) -> ScenePlan:
        body = BodyStructure(kind, shapes, origin=ROOT.child("entities", "body"))
        entity = Entity("body", (0,), constant([0, 0, 1, 1, 0, 0, 0]), (body,), origin=ROOT.child("entities", "body"))
        tables = tuple(AssetFile(path.name, path) for path in files)
        return ScenePlan("test", 1, (entity,), more.pop("physics", Physics()), files=tables, origin=ROOT, **more)

    return make
