"""Constraints, in scripts: made by SAPIEN's own `Scene.create_drive`, `create_connection` and `create_gear`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.source import SourceNode, call, string
from scenecc.emit.python.values import number_literal, pose_call, scene_block
from scenecc.plan import Connection, Distance, Drive, Gear, Weld
from scenecc.plan.constraint import WELD_SWING

if TYPE_CHECKING:
    from scenecc.emit.python.context import ScriptContext
    from scenecc.emit.python.source import SourceWriter
    from scenecc.emit.python.values import SceneValues
    from scenecc.plan import Constraint, ScenePlan, Value
    from scenecc.plan.body import Mount

_CREATE_METHODS: dict[type, str] = {
    Weld: "create_drive",
    Drive: "create_drive",
    Connection: "create_connection",
    # A connection whose limits are others.
    Distance: "create_connection",
    Gear: "create_gear",
}
_VARIABLE = "constraint"


def write_constraints(source: SourceWriter, plan: ScenePlan, tables: ScriptContext) -> None:
    """The constraints, in order."""
    for each in plan.constraints:
        with scene_block(source, each.name, each.name, each.scene_idxs, plan.num_scenes, tables.names) as (
            inner,
            columns,
        ):
            _write_constraint(inner, each, columns, tables)


def _write_constraint(
    source: SourceWriter, constraint: Constraint, columns: SceneValues, tables: ScriptContext
) -> None:
    made = call(
        f"scene.{_CREATE_METHODS[type(constraint.joint)]}",
        _mount_expression(constraint.parent, tables),
        _frame_expression(constraint.pose_in_parent, "pose_in_parent", columns),
        _mount_expression(constraint.child, tables),
        _frame_expression(constraint.pose_in_child, "pose_in_child", columns),
    )
    source.statement(made, assign=_VARIABLE)
    source.statement(string(constraint.name), assign=f"{_VARIABLE}.name")
    match constraint.joint:
        case Weld():
            for axis in ("x", "y", "z", "twist"):
                _write_setter(source, f"limit_{axis}", "0", "0")
            stiffness, damping = map(number_literal, WELD_SWING)
            source.comment("A drive's limits of the swing do nothing: a spring that gives way to nothing holds it.")
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
    """The arguments of a limit: lowest, highest, and the spring where there is one."""
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


def _frame_expression(value: Value | None, name: str, columns: SceneValues) -> SourceNode:
    return call("sapien.Pose") if value is None else columns.value(value, name, pose_call)


def _vector_expression(value: Value | None, name: str, columns: SceneValues) -> SourceNode:
    return "[0, 0, 0]" if value is None else columns.value(value, name)
