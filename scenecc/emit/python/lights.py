"""Lights and surroundings, in scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.emit.python.columns import pose
from scenecc.emit.python.layout import Node, call, string
from scenecc.emit.python.materials import texture_of
from scenecc.emit.python.scenes import in_scenes
from scenecc.plan import (
    AreaLight,
    CubeMap,
    DirectionalLight,
    Environment,
    PointLight,
    SpotLight,
    TexturedLight,
)
from scenecc.plan.rendering import shadow_parameters

if TYPE_CHECKING:
    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.layout import Source
    from scenecc.emit.python.tables import Tables
    from scenecc.plan import Camera, Light, ScenePlan

CLASSES: Final[dict[type, str]] = {
    DirectionalLight: "RenderDirectionalLightComponent",
    PointLight: "RenderPointLightComponent",
    SpotLight: "RenderSpotLightComponent",
    AreaLight: "RenderParallelogramLightComponent",
    TexturedLight: "RenderTexturedLightComponent",
}
"""SAPIEN's components, by the type of a light."""


def write_environment(source: Source, plan: ScenePlan, tables: Tables) -> None:
    """What surrounds every scene."""
    if plan.environment is None or plan.environment == Environment():
        return
    source.gap()
    with source.block("if render:"):
        scenes = tuple(range(plan.num_scenes))
        with in_scenes(source, "Surroundings", "environment", scenes, plan.num_scenes, tables.names) as (
            inner,
            columns,
        ):
            _write_surroundings(inner, plan.environment, columns, tables)


def write_lights(source: Source, plan: ScenePlan, tables: Tables) -> None:
    """The lights, in order."""
    if not plan.lights:
        return
    source.gap()
    with source.block("if render:"):
        for light in plan.lights:
            with in_scenes(source, light.name, light.name, light.scene_idxs, plan.num_scenes, tables.names) as (
                inner,
                columns,
            ):
                _write_light(inner, light, columns, tables)


def _write_surroundings(source: Source, environment: Environment, columns: Columns, tables: Tables) -> None:
    if environment.ambient_light is not None:
        ambient = columns.value(environment.ambient_light, "ambient_light")
        source.statement(call("scene.set_ambient_light", ambient))
    surroundings = environment.map
    if isinstance(surroundings, CubeMap):
        faces = [
            call("str", columns.value(getattr(surroundings, face), face, tables.files.name))
            for face in ("px", "nx", "py", "ny", "pz", "nz")
        ]
        source.statement(call("scene.set_environment_map_from_files", *faces))
    elif surroundings is not None:
        file = columns.value(surroundings.file, "map", tables.files.name)
        source.statement(call("scene.set_environment_map", call("str", file)))


def _write_light(source: Source, light: Light, columns: Columns, tables: Tables) -> None:
    source.line(f"light = sapien.render.{CLASSES[type(light.light)]}()")
    if isinstance(light.light, AreaLight):
        half_width, half_height = light.light.half_width, light.light.half_height
        size = [columns.value(half_width, "half_width"), columns.value(half_height, "half_height")]
        source.statement(call("light.set_shape", *size))
    source.statement(columns.value(light.color, "color"), assign="light.color")
    for name, value in shadow_parameters(light).items():
        source.statement(columns.value(value, name), assign=f"light.{name}")
    if isinstance(light.light, SpotLight | TexturedLight):
        source.statement(columns.value(light.light.inner_fov, "inner_fov"), assign="light.inner_fov")
        source.statement(columns.value(light.light.outer_fov, "outer_fov"), assign="light.outer_fov")
    if isinstance(light.light, TexturedLight):
        source.statement(texture_of(light.light.texture, "texture", columns, tables.files), assign="light.texture")
    write_held(source, light, "light", columns, tables)


def write_held(source: Source, held: Light | Camera, variable: str, columns: Columns, tables: Tables) -> None:
    """Names a component and puts it into a scene: on an entity of its own, or on what it is mounted on."""
    name = string(held.name)
    source.statement(name, assign=f"{variable}.name")
    where: Node = columns.value(held.pose, "pose", pose)
    if held.mount is not None:
        source.line(f"{tables.held.expression(held.mount)}.add_component({variable})")
        source.statement(where, assign=f"{variable}.local_pose")
        return
    source.line("entity = sapien.Entity()")
    source.statement(name, assign="entity.name")
    source.line(f"entity.add_component({variable})")
    source.statement(call("entity.set_pose", where))
    source.line("scene.add_entity(entity)")
