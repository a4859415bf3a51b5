"""Restricts a plan to what one picture needs: its camera, resized, and the visible content."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from scenecc.plan.body import BodyStructure
from scenecc.plan.rendering import Camera, Intrinsic
from scenecc.plan.value import Value, per_scene

if TYPE_CHECKING:
    from scenecc.plan.articulation import ArticulationStructure
    from scenecc.plan.scene import ScenePlan


def restrict_to_camera(plan: ScenePlan, camera: Camera | None, *, collision: bool, unlit: bool = False) -> ScenePlan:
    """Returns the plan with only this camera.

    Args:
        plan: the plan.
        camera: a camera of the plan, possibly resized; None: no camera.
        collision: remove visual shapes, since pictures show collision shapes.
        unlit: remove lights and environment.
    """
    if unlit:
        plan = replace(plan, lights=(), environment=None)
    entities = plan.entities
    if collision:
        entities = tuple(
            replace(one, structures=tuple(map(_remove_structure_visuals, one.structures))) for one in entities
        )
    return replace(plan, entities=entities, cameras=() if camera is None else (camera,))


def resize_camera(camera: Camera, width: int, height: int) -> Camera:
    """Returns the camera with pictures of another size [px].

    Angles of view and `top` stay; an intrinsic matrix is scaled with the picture, so that the view stays the same.
    """
    lens = camera.lens
    if isinstance(lens, Intrinsic):
        x, y = width / camera.width, height / camera.height
        lens = replace(
            lens,
            fx=_scale_value(lens.fx, x),
            fy=_scale_value(lens.fy, y),
            cx=_scale_value(lens.cx, x),
            cy=_scale_value(lens.cy, y),
            skew=_scale_value(lens.skew, x),
        )
    return replace(camera, width=width, height=height, lens=lens)


def _scale_value(value: Value, factor: float) -> Value:
    return per_scene(value.data * factor)


def _remove_structure_visuals(
    structure: BodyStructure | ArticulationStructure,
) -> BodyStructure | ArticulationStructure:
    if isinstance(structure, BodyStructure):
        return _remove_body_visuals(structure)
    return replace(
        structure, links=tuple(replace(link, body=_remove_body_visuals(link.body)) for link in structure.links)
    )


def _remove_body_visuals(body: BodyStructure) -> BodyStructure:
    return replace(body, visuals=(), visibility=None, shading_mode=None)
