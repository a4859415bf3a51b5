"""Writes lights, the environment and cameras."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.emit.python.context import texture_call
from scenecc.emit.python.source import SourceNode, call, string
from scenecc.emit.python.values import number_literal, pose_call, scene_block
from scenecc.plan import (
    AreaLight,
    CubeMap,
    DirectionalLight,
    Environment,
    Intrinsic,
    Orthographic,
    Perspective,
    PointLight,
    SpotLight,
    TexturedLight,
)
from scenecc.plan.rendering import shadow_parameters

if TYPE_CHECKING:
    from scenecc.emit.python.context import ScriptContext
    from scenecc.emit.python.source import SourceWriter
    from scenecc.emit.python.values import SceneValues
    from scenecc.plan import Camera, Light, ScenePlan


LIGHT_CLASSES: Final[dict[type, str]] = {
    DirectionalLight: "RenderDirectionalLightComponent",
    PointLight: "RenderPointLightComponent",
    SpotLight: "RenderSpotLightComponent",
    AreaLight: "RenderParallelogramLightComponent",
    TexturedLight: "RenderTexturedLightComponent",
}
"""SAPIEN's components, by the type of a light."""


def write_environment(source: SourceWriter, plan: ScenePlan, tables: ScriptContext) -> None:
    """What surrounds every scene."""
    if plan.environment is None or plan.environment == Environment():
        return
    source.gap()
    with source.block("if render:"):
        scenes = tuple(range(plan.num_scenes))
        with scene_block(source, "Surroundings", "environment", scenes, plan.num_scenes, tables.names) as (
            inner,
            columns,
        ):
            _write_environment(inner, plan.environment, columns, tables)


def write_lights(source: SourceWriter, plan: ScenePlan, tables: ScriptContext) -> None:
    """The lights, in order."""
    if not plan.lights:
        return
    source.gap()
    with source.block("if render:"):
        for light in plan.lights:
            with scene_block(source, light.name, light.name, light.scene_idxs, plan.num_scenes, tables.names) as (
                inner,
                columns,
            ):
                _write_light(inner, light, columns, tables)


def _write_environment(
    source: SourceWriter, environment: Environment, columns: SceneValues, tables: ScriptContext
) -> None:
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


def _write_light(source: SourceWriter, light: Light, columns: SceneValues, tables: ScriptContext) -> None:
    source.line(f"light = sapien.render.{LIGHT_CLASSES[type(light.light)]}()")
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
        source.statement(texture_call(light.light.texture, "texture", columns, tables.files), assign="light.texture")
    attach_component(source, light, "light", columns, tables)


def attach_component(
    source: SourceWriter, mounted: Light | Camera, variable: str, columns: SceneValues, tables: ScriptContext
) -> None:
    """Names a component and puts it into a scene: on an entity of its own, or on what it is mounted on."""
    name = string(mounted.name)
    source.statement(name, assign=f"{variable}.name")
    where: SourceNode = columns.value(mounted.pose, "pose", pose_call)
    if mounted.mount is not None:
        source.line(f"{tables.mount_targets.expression(mounted.mount)}.add_component({variable})")
        source.statement(where, assign=f"{variable}.local_pose")
        return
    source.line("entity = sapien.Entity()")
    source.statement(name, assign="entity.name")
    source.line(f"entity.add_component({variable})")
    source.statement(call("entity.set_pose", where))
    source.line("scene.add_entity(entity)")


def write_cameras(source: SourceWriter, plan: ScenePlan, tables: ScriptContext) -> None:
    """The cameras, in order. Of a plan without any only a batch makes one, for its pictures."""
    if not plan.cameras:
        return
    source.gap()
    with source.block("if render:"):
        for camera in plan.cameras:
            with scene_block(source, camera.name, camera.name, camera.scene_idxs, plan.num_scenes, tables.names) as (
                inner,
                columns,
            ):
                _write_camera(inner, camera, columns)
                attach_component(inner, camera, "camera", columns, tables)


def _write_camera(source: SourceWriter, camera: Camera, columns: SceneValues) -> None:
    size = (str(camera.width), str(camera.height))
    shader = () if camera.shader is None else (f"sapien.__path__[0] + {string('/vulkan_shader/' + camera.shader)}",)
    source.statement(call("sapien.render.RenderCameraComponent", *size, *shader), assign="camera")
    near, far = columns.value(camera.near, "near"), columns.value(camera.far, "far")
    match camera.lens:
        case Perspective() as lens:
            alone = str(lens.fovx is None or lens.fovy is None)
            if lens.fovy is not None:
                source.statement(call("camera.set_fovy", columns.value(lens.fovy, "fovy"), compute_x=alone))
            if lens.fovx is not None:
                source.statement(call("camera.set_fovx", columns.value(lens.fovx, "fovx"), compute_y=alone))
            source.statement(near, assign="camera.near")
            source.statement(far, assign="camera.far")
        case Intrinsic() as lens:
            names = ("fx", "fy", "cx", "cy", "skew")
            matrix = [columns.value(getattr(lens, name), name) for name in names]
            source.statement(call("camera.set_perspective_parameters", near, far, *matrix))
        case Orthographic() as lens:
            # Not with `top` alone, where SAPIEN divides width by height in whole numbers.
            top = columns.value(lens.top, "top")
            source.statement(top, assign="top")
            source.line(f"right = top * {number_literal(camera.width)} / {number_literal(camera.height)}")
            source.statement(call("camera.set_orthographic_parameters", near, far, "-right", "right", "-top", "top"))
