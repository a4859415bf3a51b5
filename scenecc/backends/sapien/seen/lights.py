"""Lights and surroundings of the plan in live scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.backends.sapien.engine import render
from scenecc.backends.sapien.failure import EngineFailure
from scenecc.backends.sapien.seen.hold import hold
from scenecc.plan import (
    AreaLight,
    CubeMap,
    DirectionalLight,
    PointLight,
    SkyMap,
    SpotLight,
    TexturedLight,
)
from scenecc.plan.rendering import shadow_parameters

if TYPE_CHECKING:
    from scenecc.backends.sapien.resources import Resources
    from scenecc.backends.sapien.standing import Standing
    from scenecc.plan import Environment, Light

CLASSES: Final[dict[type, str]] = {
    DirectionalLight: "RenderDirectionalLightComponent",
    PointLight: "RenderPointLightComponent",
    SpotLight: "RenderSpotLightComponent",
    AreaLight: "RenderParallelogramLightComponent",
    TexturedLight: "RenderTexturedLightComponent",
}
"""SAPIEN's components, by the type of a light."""


def has_light(scene: Any) -> bool:
    """Whether a live scene is lit by anything: lights, ambient light or a map, of the plan or added by hand."""
    system = scene.render_system
    return bool(system.get_lights()) or any(system.get_ambient_light()) or system.get_cubemap() is not None


def build_light(light: Light, standing: Standing, resources: Resources) -> list[Any]:
    """The component of a light in each scene that has it, among those that are built.

    Raises:
        EngineFailure: its picture cannot be loaded.
    """
    shadow = shadow_parameters(light)
    rows = {index: row for row, index in enumerate(light.scene_idxs)}
    made: list[Any] = []
    for number, index in enumerate(standing.scene_idxs):
        row = rows.get(index)
        if row is None:
            continue
        component = getattr(render, CLASSES[type(light.light)])()
        if isinstance(light.light, AreaLight):
            component.set_shape(float(light.light.half_width.row(row)), float(light.light.half_height.row(row)))
        component.color = light.color.row(row)
        for name, value in shadow.items():
            setattr(component, name, value.row(row).item())
        if isinstance(light.light, SpotLight | TexturedLight):
            component.inner_fov = float(light.light.inner_fov.row(row))
            component.outer_fov = float(light.light.outer_fov.row(row))
        if isinstance(light.light, TexturedLight):
            component.texture = resources.texture(light.light.texture, row)
        hold(component, light, row, standing, number)
        made.append(component)
    return made


def build_environment(environment: Environment, standing: Standing, resources: Resources) -> None:
    """Gives scenes what surrounds them.

    Raises:
        EngineFailure: the map cannot be loaded.
    """
    maps: dict[tuple[str, ...], Any] = {}
    for scene, index in zip(standing.scenes, standing.scene_idxs, strict=True):
        if environment.ambient_light is not None:
            scene.render_system.ambient_light = environment.ambient_light.row(index)
        if environment.map is None:
            continue
        paths = tuple(resources.path(file) for file in _files(environment.map, index))
        if paths not in maps:
            maps[paths] = _cubemap(paths, environment)
        scene.render_system.cubemap = maps[paths]


def _files(surroundings: SkyMap | CubeMap, index: int) -> list[int]:
    if isinstance(surroundings, SkyMap):
        return [int(surroundings.file.row(index))]
    faces = (getattr(surroundings, face) for face in ("px", "nx", "py", "ny", "pz", "nz"))
    return [int(face.row(index)) for face in faces]


def _cubemap(paths: tuple[str, ...], environment: Environment) -> Any:
    try:
        return render.RenderCubemap(*paths)
    except RuntimeError as error:
        origin = environment.origin and environment.origin.child("map")
        message = f"the renderer cannot load the map '{paths[0]}': {error}"
        raise EngineFailure("SC807", message, origin=origin) from error
