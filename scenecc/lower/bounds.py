"""Limits on what a document may ask for (LANGUAGE, Limits)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.spec.body import Body
from scenecc.spec.selection import count

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Origin, Sink
    from scenecc.spec.document import SceneFile


@dataclass(frozen=True, slots=True)
class Bounds:
    """The most that there may be."""

    scenes: int
    objects: int
    objects_times_scenes: int


def within(
    scene: SceneFile,
    num_scenes: int,
    selections: Mapping[str, tuple[int, ...]],
    bounds: Bounds,
    origin: Origin,
    sink: Sink,
) -> bool:
    """Whether a document asks for no more than it may; otherwise that is reported."""
    if not _under("SC605", "scenes", num_scenes, bounds.scenes, origin.child("num_scenes"), sink):
        return False
    shapes = {name: _shapes(entity) for name, entity in scene.entities.items()}
    if not _under("SC604", "objects", sum(shapes.values()), bounds.objects, origin.child("entities"), sink):
        return False
    built = sum(
        shapes[name] * (len(selections[name]) if name in selections else count(entity.scene_idxs, num_scenes))
        for name, entity in scene.entities.items()
    )
    place = origin.child("num_scenes")
    return _under("SC606", "objects times scenes", built, bounds.objects_times_scenes, place, sink)


def _shapes(entity: Any) -> int:
    if entity.__class__ is Body:
        return max(1, _own(entity))
    # Variants: the largest is in every scene at worst.
    return max(1, *(_own(entity) + _own(variant) for variant in entity.variants))


def _own(body: Any) -> int:
    return len(body.shapes) + len(body.collisions) + len(body.visuals)


def _under(code: str, what: str, number: int, limit: int, place: Origin, sink: Sink) -> bool:
    if number <= limit:
        return True
    name = what.replace(" ", "_")
    hint = f"raise it with --limit {name}={number} or limits={{'{name}': {number}}}"
    sink.report(code, f"{number} {what} are more than the limit of {limit}", place, hint=hint)
    return False
