"""Constraints, in scripts: made by SAPIEN's own `Scene.create_drive`, `create_connection` and `create_gear`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.python.columns import number, pose
from scenecc.emit.python.layout import Node, call, string
from scenecc.emit.python.scenes import in_scenes
from scenecc.plan import Connection, Distance, Drive, Gear, Weld
from scenecc.plan.constraint import WELD_SWING

if TYPE_CHECKING:
    from scenecc.emit.python.columns import Columns
    from scenecc.emit.python.layout import Source
    from scenecc.emit.python.tables import Tables
    from scenecc.plan import Constraint, ScenePlan, Value
    from scenecc.plan.body import Mount

_MAKERS: dict[type, str] = {
    Weld: "create_drive",
    Drive: "create_drive",
    Connection: "create_connection",
    # A connection whose limits are others.
    Distance: "create_connection",
    Gear: "create_gear",
}
_OBJECT = "constraint"


def write_constraints(source: Source, plan: ScenePlan, tables: Tables) -> None:
    """The constraints, in order."""
    for each in plan.constraints:
        with in_scenes(source, each.name, each.name, each.scene_idxs, plan.num_scenes, tables.names) as (
            inner,
            columns,
        ):
            _write(inner, each, columns, tables)


def _write(source: Source, constraint: Constraint, columns: Columns, tables: Tables) -> None:
    made = call(
        f"scene.{_MAKERS[type(constraint.joint)]}",
        _end(constraint.parent, tables),
        _frame(constraint.pose_in_parent, "pose_in_parent", columns),
        _end(constraint.child, tables),
        _frame(constraint.pose_in_child, "pose_in_child", columns),
    )
    source.statement(made, assign=_OBJECT)
    source.statement(string(constraint.name), assign=f"{_OBJECT}.name")
    match constraint.joint:
        case Weld():
            for axis in ("x", "y", "z", "twist"):
                _set(source, f"limit_{axis}", "0", "0")
            stiffness, damping = map(number, WELD_SWING)
            source.comment("A drive's limits of the swing do nothing: a spring that gives way to nothing holds it.")
            _set(source, "drive_property_swing", stiffness, damping, mode=string("acceleration"))
        case Distance(limits, stiffness, damping):
            _set(source, "limit", *_limited(limits, (stiffness, damping), "", columns))
        case Gear(ratio, enable_hinges):
            _set(source, "gear_ratio", columns.value(ratio, "ratio"))
            if enable_hinges:
                source.line(f"{_OBJECT}.enable_hinges()")
        case Drive() as drive:
            _write_drive(source, drive, columns)
        case Connection():
            pass


def _write_drive(source: Source, drive: Drive, columns: Columns) -> None:
    for limit in drive.limits:
        spring = (limit.stiffness, limit.damping)
        _set(source, f"limit_{limit.axis}", *_limited(limit.limits, spring, f"_{limit.axis}", columns))
    for each in drive.drives:
        arguments = [columns.value(each.stiffness, f"stiffness_{each.axis}")]
        arguments.append(columns.value(each.damping, f"damping_{each.axis}"))
        if each.force_limit is not None:
            arguments.append(columns.value(each.force_limit, f"force_limit_{each.axis}"))
        mode = {} if each.mode in {None, "force"} else {"mode": string(each.mode or "")}
        _set(source, f"drive_property_{each.axis}", *arguments, **mode)
    if drive.target is not None:
        _set(source, "drive_target", columns.value(drive.target, "target", pose))
    if drive.linear_velocity_target is not None or drive.angular_velocity_target is not None:
        linear = _vector(drive.linear_velocity_target, "linear_velocity_target", columns)
        angular = _vector(drive.angular_velocity_target, "angular_velocity_target", columns)
        _set(source, "drive_velocity_target", linear, angular)
    for name in ("inv_mass_scales", "inv_inertia_scales"):
        value: Value | None = getattr(drive, name)
        if value is not None:
            pair = (columns.of_block(columns.of_rows(value)[:, side], f"{name}_{side}") for side in (0, 1))
            _set(source, name, *pair)


def _limited(limits: Value, spring: tuple[Value | None, Value | None], suffix: str, columns: Columns) -> list[Node]:
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


def _set(source: Source, name: str, *arguments: Node, **keywords: Node) -> None:
    source.statement(call(f"{_OBJECT}.set_{name}", *arguments, **keywords))


def _end(mount: Mount | None, tables: Tables) -> Node:
    return "None" if mount is None else tables.held.expression(mount)


def _frame(value: Value | None, name: str, columns: Columns) -> Node:
    return call("sapien.Pose") if value is None else columns.value(value, name, pose)


def _vector(value: Value | None, name: str, columns: Columns) -> Node:
    return "[0, 0, 0]" if value is None else columns.value(value, name)
