"""Finds bodies that rest on a plane beyond the part of it that is drawn: a plane collides without end."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.geometry.rotation_arrays import compose, rotate
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import BodyStructure
from scenecc.plan.geometry import Box, Plane, TiledPlane, VisualPlane
from scenecc.simulation.findings import Finding, length_text

if TYPE_CHECKING:
    from collections.abc import Container, Iterator, Mapping

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.plan import ScenePlan

    Floats = NDArray[np.float64]

_BEYOND: Final = 0.05
"""[m] A contact this far beyond the drawn part of a plane is outside."""


def undrawn_supports(batch: SceneBatch, moved: set[tuple[int, str]]) -> Iterator[Finding]:
    """Yields bodies that rest on a part of a plane that is not drawn, by the contacts of the last step.

    `moved`: scenes and names of bodies that start with a velocity, and may roll away.
    """
    planes = _drawn_planes(batch.plan)
    sheets = {scene: _sheets(batch.plan, scene) for scene in _scenes_beyond(batch, planes)}
    if not sheets:
        return
    contacts = batch.contacts(scene_idxs=list(sheets))
    far: dict[tuple[int, str, str], list[float]] = {}
    for number in np.flatnonzero(contacts.impulse.any(axis=1)).tolist():
        scene, names = int(contacts.scene[number]), (str(contacts.a[number]), str(contacts.b[number]))
        plane = next((name for name in names if name in planes), None)
        if plane is None or scene not in planes[plane]:
            continue
        body = names[names[0] == plane]
        point = contacts.point[number].astype(np.float64)
        out = min(float(_outside(point[None], sheet)[0]) for sheet in sheets[scene])
        far.setdefault((scene, body, plane), []).append(out)
    for (scene, body, plane), outs in far.items():
        if min(outs) > _BEYOND and (scene, body) not in moved:
            yield Finding(
                "SC857", (body, plane), scene, min(outs),
                f"`{body}` rests on a part of `{plane}` that is not drawn: it is {length_text(min(outs))} beyond what "
                "is drawn of the plane",
                "a plane collides without end: draw more of it, or move the body",
            )  # fmt: skip


def _scenes_beyond(batch: SceneBatch, planes: Mapping[str, set[int]]) -> Iterator[int]:
    """Yields the scenes in which a movable body is beyond all that is drawn of their planes, seen along the sheets."""
    for scene, built in zip(batch.scene_idxs, batch.scenes, strict=True):
        system = built.physx_system
        movable = [*system.get_rigid_dynamic_components(), *system.get_articulation_link_components()]
        drawn = {name for name, scenes in planes.items() if scene in scenes}
        if not movable or not drawn:
            continue
        points = np.array([each.entity_pose.p for each in movable], np.float64)
        outside = np.full(len(points), np.inf)
        for sheet in _sheets(batch.plan, scene, drawn):
            flat = sheet.copy()
            flat[7 + int(sheet[7:].argmin())] = np.inf
            outside = np.minimum(outside, _outside(points, flat))
        if (outside > 0).any():
            yield scene


def _drawn_planes(plan: ScenePlan) -> dict[str, set[int]]:
    """Returns bodies that collide as a plane and draw a part of it, with their scenes."""
    found: dict[str, set[int]] = {}
    for entity in plan.entities:
        for row, index in enumerate(entity.scene_idxs):
            structure = entity.structure(row)
            if not isinstance(structure, BodyStructure):
                continue
            is_drawn = any(isinstance(shape.geometry, VisualPlane | TiledPlane) for shape in structure.visuals)
            if is_drawn and any(isinstance(shape.geometry, Plane) for shape in structure.collisions):
                found.setdefault(entity.name, set()).add(index)
    return found


def _sheets(plan: ScenePlan, scene: int, names: Container[str] | None = None) -> list[Floats]:
    """Returns the flat visuals and boxes of immovable bodies in a scene: frame (7,) and half sizes (3,), each (10,).

    `names`: only these entities; None: all.
    """
    found: list[Floats] = []
    for entity in plan.entities:
        if scene not in entity.scene_idxs or (names is not None and entity.name not in names):
            continue
        row = entity.scene_idxs.index(scene)
        structure = entity.structure(row)
        if not isinstance(structure, BodyStructure) or structure.body_type == "dynamic":
            continue
        at = np.array(entity.pose.row(row), np.float64)
        for shape in structure.visuals:
            half = _half_size(shape.geometry, row)
            if half is not None:
                pose = np.array(IDENTITY_POSE if shape.pose is None else shape.pose.row(row), np.float64)
                found.append(np.concatenate([compose(at[None], pose[None])[0], half]))
    return found


def _half_size(geometry: Any, row: int) -> Floats | None:
    match geometry:
        case VisualPlane():
            return np.array([0.0, *geometry.half_size.row(row)])
        case TiledPlane():
            return np.array([*geometry.half_size.row(row), 0.0])
        case Box():
            return np.array([*geometry.half_size.row(row)], np.float64)
        case _:
            return None


def _outside(points: Floats, sheet: Floats) -> Floats:
    """Returns how far points (N, 3) are outside a sheet (N,) [m]: the greatest distance along one of its axes."""
    back = np.broadcast_to(sheet[3:7] * (1.0, -1.0, -1.0, -1.0), (len(points), 4))
    return np.maximum(np.abs(rotate(back, points - sheet[:3])) - sheet[7:], 0.0).max(axis=1)
