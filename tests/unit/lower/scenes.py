"""Small documents, and what they compile to."""

from __future__ import annotations

from typing import Any

import numpy as np

from scenecc import compile_scene, validate
from scenecc.plan import Entity, ScenePlan

BALL: list[dict[str, Any]] = [{"type": "sphere", "radius": 0.1}]


def scene(body: dict[str, Any] | None = None, **top: Any) -> dict[str, Any]:
    """A document with one body, which has a ball if nothing else."""
    body = {"shapes": BALL, **(body or {})}
    return {"scenecc": 1, "entities": {"body": body}, **top}


def compiled(body: dict[str, Any] | None = None, **top: Any) -> ScenePlan:
    return compile_scene(scene(body, **top))


def entity(plan: ScenePlan, name: str = "body") -> Entity:
    return next(entity for entity in plan.entities if entity.name == name)


def pose_of(pose: Any, **top: Any) -> np.ndarray:
    """Seven numbers of a body's pose as it is lowered."""
    return entity(compiled({"pose": pose}, **top)).pose.data[0]


def codes(document: dict[str, Any], **options: Any) -> list[tuple[str, str]]:
    """Codes and paths of what is wrong."""
    return [(diagnostic.code, diagnostic.path) for diagnostic in validate(document, **options)]
