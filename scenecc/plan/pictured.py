"""A plan as it is built for the pictures of one camera: without what these do not show."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from scenecc.plan.body import BodyStructure
from scenecc.plan.camera import Intrinsic
from scenecc.plan.value import per_scene

if TYPE_CHECKING:
    from scenecc.plan.articulation import ArticulationStructure
    from scenecc.plan.camera import Camera
    from scenecc.plan.scene import Entity, ScenePlan
    from scenecc.plan.value import Value

COLLISION_COLORS: Final = {
    "dynamic": (0.0437, 0.2051, 0.6867, 1.0),
    "kinematic": (0.8879, 0.2705, 0.0242, 1.0),
    "static": (0.3231, 0.3231, 0.3231, 1.0),
    "link": (0.1001, 0.3564, 0.0782, 1.0),
}
"""What collides, by type of body, wherever it is drawn: blue, orange, grey, green as linear RGBA."""


TOWARDS: Final = (1.0, 0.75, 0.75)
"""Where a camera that frames a scene stands from the middle of it: before it, to the left and above."""

FLAT: Final = 1e-4
"""What is thinner than this [m] is ground, or paint: it counts for such a camera where there is nothing else."""


def seen_by(plan: ScenePlan, camera: Camera | None, *, collision: bool) -> ScenePlan:
    """The plan with this camera alone, or none.

    Args:
        plan: the plan.
        camera: one of its own, or one of these resized.
        collision: whether its pictures will show what collides: nothing else is seen in it then.
    """
    entities = tuple(map(_unseen, plan.entities)) if collision else plan.entities
    return replace(plan, entities=entities, cameras=() if camera is None else (camera,))


def resized(camera: Camera, width: int, height: int) -> Camera:
    """The camera with pictures of another size [px].

    Its angles, or its `top`, stay as they are; a matrix is scaled with the picture, so that it shows the same.
    """
    lens = camera.lens
    if isinstance(lens, Intrinsic):
        x, y = width / camera.width, height / camera.height
        lens = replace(
            lens,
            fx=_times(lens.fx, x),
            fy=_times(lens.fy, y),
            cx=_times(lens.cx, x),
            cy=_times(lens.cy, y),
            skew=_times(lens.skew, x),
        )
    return replace(camera, width=width, height=height, lens=lens)


def _times(value: Value, factor: float) -> Value:
    return per_scene(value.data * factor)


def _unseen(entity: Entity) -> Entity:
    return replace(entity, structures=tuple(map(_bare, entity.structures)))


def _bare(structure: BodyStructure | ArticulationStructure) -> BodyStructure | ArticulationStructure:
    if isinstance(structure, BodyStructure):
        return _without_visuals(structure)
    return replace(structure, links=tuple(replace(link, body=_without_visuals(link.body)) for link in structure.links))


def _without_visuals(body: BodyStructure) -> BodyStructure:
    return replace(body, visuals=(), visibility=None, shading_mode=None)
