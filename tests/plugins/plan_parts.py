"""Parts of plans made by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from scenecc.plan import (
    BodyStructure,
    BodyType,
    CollisionGeometry,
    CollisionShape,
    Entity,
    Plane,
    Value,
    VisualPlane,
    VisualShape,
    constant,
    literal,
    per_scene,
)
from scenecc.plan.body import AssetFile, PhysicalMaterial, Texture, VisualMaterial

ROOT = Path(__file__).resolve().parents[2]

FLAG = np.bool_
INT = np.int64
UP = (0.7071068, 0, -0.7071068, 0)
ONE = constant([1, 1, 1])


def pose(x: float, y: float, z: float, q: tuple[float, ...] = (1, 0, 0, 0)) -> Value:
    return constant([x, y, z, *q])


def poses(*points: tuple[float, float, float]) -> Value:
    return per_scene([[*point, 1, 0, 0, 0] for point in points])


def indices(*rows: int) -> Value:
    return per_scene(rows, INT)


def rubbing(static_friction: float, dynamic_friction: float, restitution: float) -> PhysicalMaterial:
    return PhysicalMaterial(literal(static_friction), literal(dynamic_friction), literal(restitution))


def look(**given: Any) -> VisualMaterial:
    """Numbers, colours and textures; numbers and colours as they are."""
    parts: Any = {name: item if isinstance(item, Texture | Value) else literal(item) for name, item in given.items()}
    return VisualMaterial(**parts)


def files(*names: str) -> tuple[AssetFile, ...]:
    return tuple(AssetFile(f"scenes/assets/{name}", ROOT / "scenes" / "assets" / name) for name in names)


def ground(num_scenes: int) -> Entity:
    shape = CollisionShape(Plane(), pose=pose(0, 0, 0, UP))
    look = VisualShape(VisualPlane(constant([10, 10])), pose=pose(0, 0, 0, UP))
    body = BodyStructure("static", collisions=(shape,), visuals=(look,))
    return Entity("ground", tuple(range(num_scenes)), pose(0, 0, 0), (body,))


def entity(name: str, at: Value, body: BodyStructure, scene_idxs: tuple[int, ...] = (0, 1)) -> Entity:
    return Entity(name, scene_idxs, at, (body,))


def solid(*geometries: CollisionGeometry, body_type: BodyType = "dynamic", **knobs: Any) -> BodyStructure:
    return BodyStructure(body_type, collisions=tuple(CollisionShape(g) for g in geometries), **knobs)
