"""Writes lights, the environment, cameras and constraints."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.context import frame_expression, pose_call, scene_block, texture_call, write_properties
from scenecc.emit.python.source import SourceNode, call, number_literal, string
from scenecc.plan import Connection, Distance, Drive, Gear, Weld
from scenecc.plan.constraint import WELD_SWING, ConstraintJoint, colliding_constraints, component_joints
from scenecc.plan.rendering import (
    LIGHT_CLASSES,
    LIGHT_NUMBERS,
    AreaLight,
    CubeMap,
    Environment,
    Intrinsic,
    Orthographic,
    Perspective,
    TexturedLight,
    shadow_parameters,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from scenecc.emit.python.context import SceneValues, ScriptContext
    from scenecc.emit.python.source import SourceWriter
    from scenecc.plan import Constraint, ScenePlan, Value
    from scenecc.plan.body import Mount
    from scenecc.plan.rendering import Camera, Light

    ObjectWriter = Callable[[SourceWriter, Any, SceneValues, ScriptContext], None]
    """Writes the statements of an object for each of its scenes."""


def write_sections(source: SourceWriter, plan: ScenePlan, tables: ScriptContext) -> None:
    """Writes what is built after the entities, section by section. `source`: the body of `build_scenes`.

    A plan without cameras gets none here; only a batch makes a default camera, for its pictures.
    """
    around = () if plan.environment is None or plan.environment == Environment() else (plan.environment,)
    rendered: tuple[tuple[Sequence[Any], ObjectWriter], ...] = (
        (around, _write_environment),
        (plan.lights, _write_light),
        (plan.cameras, _write_camera),
    )
    colliding = colliding_constraints(plan.constraints)

    def write(source: SourceWriter, constraint: Constraint, columns: SceneValues, tables: ScriptContext) -> None:
        _write_constraint(source, constraint, columns, tables)
        if constraint.name in colliding:
            _write_collisions(source, [index in colliding[constraint.name] for index in constraint.scene_idxs], columns)

    _write_objects(source, plan.constraints, write, plan.num_scenes, tables)
    for objects, write_object in rendered:
        if objects:
            source.gap()
            with source.block("if render:"):
                _write_objects(source, objects, write_object, plan.num_scenes, tables)


def _write_objects(
    source: SourceWriter, objects: Sequence[Any], write_object: ObjectWriter, num_scenes: int, tables: ScriptContext
) -> None:
    for each in objects:
        title, name, scene_idxs = (
            ("Surroundings", "environment", tuple(range(num_scenes)))
            if isinstance(each, Environment)
            else (each.name, each.name, each.scene_idxs)
        )
        with scene_block(source, title, name, scene_idxs, num_scenes, tables.names) as (inner, columns):
            write_object(inner, each, columns, tables)


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
    if not isinstance(light.light, AreaLight):
        write_properties(source, light.light, LIGHT_NUMBERS[type(light.light)], columns, "light")
    if isinstance(light.light, TexturedLight):
        source.statement(texture_call(light.light.texture, "texture", columns, tables.files), assign="light.texture")
    _attach_component(source, light, "light", columns, tables)


def _attach_component(
    source: SourceWriter, mounted: Light | Camera, variable: str, columns: SceneValues, tables: ScriptContext
) -> None:
    """Names a component and adds it to a scene, on its own entity or on its mount."""
    name = string(mounted.name)
    source.statement(name, assign=f"{variable}.name")
    where: SourceNode = columns.value(mounted.pose, "pose", pose_call)
    if mounted.mount is not None:
        target = tables.mount_targets.expression(mounted.mount)
        source.statement(replace(target, tail=f"{target.tail}.add_component({variable})"))
        source.statement(where, assign=f"{variable}.local_pose")
        return
    source.line("entity = sapien.Entity()")
    source.statement(name, assign="entity.name")
    source.line(f"entity.add_component({variable})")
    source.statement(call("entity.set_pose", where))
    source.line("scene.add_entity(entity)")


def _write_camera(source: SourceWriter, camera: Camera, columns: SceneValues, tables: ScriptContext) -> None:
    size = (str(camera.width), str(camera.height))
    shader = () if camera.shader is None else (f"sapien.__path__[0] + {string('/vulkan_shader/' + camera.shader)}",)
    source.statement(call("sapien.render.RenderCameraComponent", *size, *shader), assign="camera")
    near, far = columns.value(camera.near, "near"), columns.value(camera.far, "far")
    match camera.lens:
        case Perspective() as lens:
            is_only_angle = str(lens.fovx is None or lens.fovy is None)
            if lens.fovy is not None:
                source.statement(call("camera.set_fovy", columns.value(lens.fovy, "fovy"), compute_x=is_only_angle))
            if lens.fovx is not None:
                source.statement(call("camera.set_fovx", columns.value(lens.fovx, "fovx"), compute_y=is_only_angle))
            write_properties(source, camera, ("near", "far"), columns, "camera")
        case Intrinsic() as lens:
            names = ("fx", "fy", "cx", "cy", "skew")
            matrix = [columns.value(getattr(lens, name), name) for name in names]
            source.statement(call("camera.set_perspective_parameters", near, far, *matrix))
        case Orthographic():
            pass
    _attach_component(source, camera, "camera", columns, tables)
    if isinstance(camera.lens, Orthographic):
        # Not earlier, since SAPIEN would reset it. Not with `top` only, since SAPIEN then uses integer division.
        source.statement(columns.value(camera.lens.top, "top"), assign="top")
        source.line(f"right = top * {number_literal(camera.width)} / {number_literal(camera.height)}")
        source.statement(call("camera.set_orthographic_parameters", near, far, "-right", "right", "-top", "top"))


_CREATE_METHODS: dict[type, str] = {
    Weld: "create_drive",
    Drive: "create_drive",
    Connection: "create_connection",
    # A connection with other limits.
    Distance: "create_connection",
    Gear: "create_gear",
}

_VARIABLE = "constraint"


def _write_constraint(
    source: SourceWriter, constraint: Constraint, columns: SceneValues, tables: ScriptContext
) -> None:
    for number, joint in enumerate(component_joints(constraint.joint)):
        if number:
            source.comment("The target of a drive would rotate its swing, so another drive holds the axis.")
        _write_component(source, constraint, joint, columns, tables)


def _write_component(
    source: SourceWriter, constraint: Constraint, joint: ConstraintJoint, columns: SceneValues, tables: ScriptContext
) -> None:
    made = call(
        f"scene.{_CREATE_METHODS[type(joint)]}",
        _mount_expression(constraint.parent, tables),
        frame_expression(constraint.pose_in_parent, "pose_in_parent", columns),
        _mount_expression(constraint.child, tables),
        frame_expression(constraint.pose_in_child, "pose_in_child", columns),
    )
    source.statement(made, assign=_VARIABLE)
    source.statement(string(constraint.name), assign=f"{_VARIABLE}.name")
    match joint:
        case Weld():
            for axis in ("x", "y", "z", "twist"):
                _write_setter(source, f"limit_{axis}", "0", "0")
            stiffness, damping = map(number_literal, WELD_SWING)
            source.comment("A drive's swing limits have no effect, so a stiff spring holds the swing.")
            _write_setter(source, "drive_property_swing", stiffness, damping, mode=string("acceleration"))
        case Distance(limits, stiffness, damping):
            _write_setter(source, "limit", *_limit_arguments(limits, (stiffness, damping), "", columns))
        case Gear(ratio, enable_hinges):
            _write_setter(source, "gear_ratio", columns.value(ratio, "ratio"))
            if enable_hinges:
                source.line(f"{_VARIABLE}.enable_hinges()")
        case Drive() as drive:
            _write_drive(source, drive, columns)
        case Connection():
            pass
    if constraint.enabled is not None:
        _write_enabled(source, constraint.enabled, columns)


def _write_enabled(source: SourceWriter, enabled: Value, columns: SceneValues) -> None:
    if not enabled.is_constant:
        with source.block(f"if not {columns.value(enabled, 'enabled')}:"):
            source.line(f"{_VARIABLE}.disable()")
    elif not enabled.numbers()[0]:
        source.line(f"{_VARIABLE}.disable()")


def _write_collisions(source: SourceWriter, collide: list[bool], columns: SceneValues) -> None:
    """Writes what lets both bodies of a constraint collide in some of its scenes."""
    source.comment("A joint prevents contacts of its bodies, until another joint between them ends.")
    chosen = nullcontext()
    if not all(collide):
        chosen = source.block(f"if {columns.of_block(np.array(collide), 'collide')}:")
    with chosen:
        source.line(f"own = {_VARIABLE}.entity.find_component_by_type(sapien.physx.PhysxRigidBodyComponent)")
        source.line(f"sapien.physx.PhysxDistanceJointComponent(own).set_parent({_VARIABLE}.parent)")


def _write_drive(source: SourceWriter, drive: Drive, columns: SceneValues) -> None:
    for limit in drive.limits:
        spring = (limit.stiffness, limit.damping)
        _write_setter(source, f"limit_{limit.axis}", *_limit_arguments(limit.limits, spring, f"_{limit.axis}", columns))
    for each in drive.drives:
        arguments = [columns.value(each.stiffness, f"stiffness_{each.axis}")]
        arguments.append(columns.value(each.damping, f"damping_{each.axis}"))
        if each.force_limit is not None:
            arguments.append(columns.value(each.force_limit, f"force_limit_{each.axis}"))
        mode = {} if each.mode in {None, "force"} else {"mode": string(each.mode or "")}
        _write_setter(source, f"drive_property_{each.axis}", *arguments, **mode)
    if drive.target is not None:
        _write_setter(source, "drive_target", columns.value(drive.target, "target", pose_call))
    if drive.linear_velocity_target is not None or drive.angular_velocity_target is not None:
        linear = _vector_expression(drive.linear_velocity_target, "linear_velocity_target", columns)
        angular = _vector_expression(drive.angular_velocity_target, "angular_velocity_target", columns)
        _write_setter(source, "drive_velocity_target", linear, angular)
    for name in ("inv_mass_scales", "inv_inertia_scales"):
        value: Value | None = getattr(drive, name)
        if value is not None:
            pair = (columns.of_block(columns.of_rows(value)[:, side], f"{name}_{side}") for side in (0, 1))
            _write_setter(source, name, *pair)


def _limit_arguments(
    limits: Value, spring: tuple[Value | None, Value | None], suffix: str, columns: SceneValues
) -> list[SourceNode]:
    """Returns the arguments of a limit: lower, upper, and the spring if there is one."""
    rows = columns.of_rows(limits)
    arguments = [columns.of_block(rows[:, side], f"{name}{suffix}") for side, name in enumerate(("low", "high"))]
    if any(value is not None for value in spring):
        names = ("stiffness", "damping")
        arguments += [
            "0" if value is None else columns.value(value, f"limit_{name}{suffix}")
            for name, value in zip(names, spring, strict=True)
        ]
    return arguments


def _write_setter(source: SourceWriter, name: str, *arguments: SourceNode, **keywords: SourceNode) -> None:
    source.statement(call(f"{_VARIABLE}.set_{name}", *arguments, **keywords))


def _mount_expression(mount: Mount | None, tables: ScriptContext) -> SourceNode:
    return "None" if mount is None else tables.mount_targets.expression(mount)


def _vector_expression(value: Value | None, name: str, columns: SceneValues) -> SourceNode:
    return "[0, 0, 0]" if value is None else columns.value(value, name)
