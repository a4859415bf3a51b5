"""How a plan is rendered: the plan for one camera, default lights for an unlit plan, and the shadow defaults of
SAPIEN.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from scenecc.plan.body import BodyStructure
from scenecc.plan.camera import Intrinsic
from scenecc.plan.light import AreaLight, DirectionalLight, Light
from scenecc.plan.value import literal, per_scene

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

FRAMING_DIRECTION: Final = (1.0, 0.75, 0.75)
"""Where a camera that frames a scene stands from the middle of it: before it, to the left and above."""

FLAT_THICKNESS: Final = 1e-4
"""What is thinner than this [m] is ground, or paint: it counts for such a camera where there is nothing else."""


def restrict_to_camera(plan: ScenePlan, camera: Camera | None, *, collision: bool) -> ScenePlan:
    """The plan with this camera alone, or none.

    Args:
        plan: the plan.
        camera: one of its own, or one of these resized.
        collision: whether its pictures will show what collides: nothing else is seen in it then.
    """
    entities = tuple(map(_remove_entity_visuals, plan.entities)) if collision else plan.entities
    return replace(plan, entities=entities, cameras=() if camera is None else (camera,))


def resize_camera(camera: Camera, width: int, height: int) -> Camera:
    """The camera with pictures of another size [px].

    Its angles, or its `top`, stay as they are; a matrix is scaled with the picture, so that it shows the same.
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


def _remove_entity_visuals(entity: Entity) -> Entity:
    return replace(entity, structures=tuple(map(_remove_structure_visuals, entity.structures)))


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


DEFAULT_AMBIENT_LIGHT: Final = (0.3, 0.3, 0.3)

DEFAULT_LIGHT_DIRECTIONS: Final = ((1.0, 1.0, -1.0), (0.0, 0.0, -1.0))
"""Ambient light, and where two white directional lights without shadows shine to: as in ManiSkill's tasks."""


def is_unlit(plan: ScenePlan) -> bool:
    """Whether a plan has neither a light nor an ambient light nor a map, so that it is seen under these."""
    around = plan.environment
    return not plan.lights and (around is None or (around.ambient_light is None and around.map is None))


def shadow_parameters(light: Light) -> dict[str, Value]:
    """How a light throws shadows, by the names of its component's attributes, in SAPIEN's order; {} of an area light.

    Distances are [m], the size of the map [px].
    """
    if isinstance(light.light, AreaLight):
        return {}
    parallel, given = isinstance(light.light, DirectionalLight), light.shadow
    left_out = {
        "shadow": literal(0, "bool"),
        "shadow_near": literal(-10.0 if parallel else 0.1),
        "shadow_far": literal(10.0),
        **({"shadow_half_size": literal(10.0)} if parallel else {}),
        "shadow_map_size": literal(2048, "int64"),
    }
    if given is None:
        return left_out
    said = {
        "shadow": given.on,
        "shadow_near": given.near,
        "shadow_far": given.far,
        "shadow_half_size": given.half_size,
        "shadow_map_size": given.map_size,
    }
    return {name: said[name] or otherwise for name, otherwise in left_out.items()}
