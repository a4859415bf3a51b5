"""Constraints of the plan in live scenes: SAPIEN's components, and what is set on them, prepared once for all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.columns import Column, poses, scalars, side_by_side, taken, vectors
from scenecc.backends.sapien.engine import physx, sapien
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import Connection, Distance, Drive, Gear, Weld, literal
from scenecc.plan.constraint import WELD_SWING
from scenecc.plan.properties import FLOAT32_MAX

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien.standing import Standing
    from scenecc.plan import Constraint, Value

_COMPONENTS: dict[type, Any] = {
    Weld: physx.PhysxDriveComponent,
    Drive: physx.PhysxDriveComponent,
    Connection: physx.PhysxDistanceJointComponent,
    Distance: physx.PhysxDistanceJointComponent,
    Gear: physx.PhysxGearComponent,
}
IDENTITY = literal(IDENTITY_POSE)
STILL = literal((0.0, 0.0, 0.0))
_NOTHING = literal(0.0)
_NO_LIMIT = literal(FLOAT32_MAX)


@dataclass(frozen=True, slots=True)
class Call:
    """A setter of the engine.

    Attributes:
        set: its name.
        get: name of the getter that gives the same back; None: the engine gives it nobody.
        rows: its arguments, one tuple in all or one a scene.
    """

    set: str
    get: str | None
    rows: list[tuple[Any, ...]]

    def arguments(self, number: int) -> tuple[Any, ...]:
        """Those of the scene of a number among those that are built."""
        return self.rows[0 if len(self.rows) == 1 else number]


class Tie:
    """A constraint, prepared for those of its scenes that are built.

    Attributes:
        constraint: of the plan.
        scene_idxs: the scenes, ascending.
        rows: their rows in the plan's values.
        calls: what is set on a component once it is in its entity, in order.
    """

    def __init__(self, constraint: Constraint, scene_idxs: tuple[int, ...]) -> None:
        having = {index: row for row, index in enumerate(constraint.scene_idxs)}
        self.constraint = constraint
        self.scene_idxs = tuple(index for index in scene_idxs if index in having)
        self.rows = np.array([having[index] for index in self.scene_idxs], dtype=np.intp)
        self.in_parent = self._poses(constraint.pose_in_parent)
        self.in_child = self._poses(constraint.pose_in_child)
        self.calls = list(_calls(constraint, self.rows)) if self.scene_idxs else []

    def _poses(self, value: Value | None) -> Column:
        return poses(taken(IDENTITY if value is None else value, self.rows))

    def build(self, standing: Standing) -> list[Any]:
        """The component in each scene, in its child's entity: as `sapien.Scene.create_drive` and its like make it."""
        constraint = self.constraint
        number_of = {index: number for number, index in enumerate(standing.scene_idxs)}
        made: list[Any] = []
        for row, index in enumerate(self.scene_idxs):
            number = number_of[index]
            component = _COMPONENTS[type(constraint.joint)](standing.component(constraint.child, number))
            component.set_name(constraint.name)
            if constraint.parent is not None:
                component.set_parent(standing.component(constraint.parent, number))
            component.set_pose_in_child(self.in_child[row % len(self.in_child)])
            component.set_pose_in_parent(self.in_parent[row % len(self.in_parent)])
            standing.entity(constraint.child, number).add_component(component)
            for call in self.calls:
                getattr(component, call.set)(*call.arguments(row))
            made.append(component)
        return made


def _calls(constraint: Constraint, rows: NDArray[np.intp]) -> Iterator[Call]:
    match constraint.joint:
        case Weld():
            for axis in ("x", "y", "z", "twist"):
                yield Call(f"set_limit_{axis}", f"get_limit_{axis}", [(0.0, 0.0, 0.0, 0.0)])
            swing = (*WELD_SWING, FLOAT32_MAX, "acceleration")
            yield Call("set_drive_property_swing", "get_drive_property_swing", [swing])
        case Connection():
            yield Call("set_limit", None, [(0.0, 0.0)])
        case Distance(limits, stiffness, damping):
            yield Call("set_limit", None, _limited(limits, stiffness, damping, rows))
        case Gear(ratio, enable_hinges):
            yield Call("set_gear_ratio", "get_gear_ratio", side_by_side([_numbers(ratio, rows)]))
            if enable_hinges:
                yield Call("enable_hinges", None, [()])
        case Drive() as drive:
            yield from _drive_calls(drive, rows)


def _drive_calls(drive: Drive, rows: NDArray[np.intp]) -> Iterator[Call]:
    for limit in drive.limits:
        arguments = _limited(limit.limits, limit.stiffness, limit.damping, rows)
        yield Call(f"set_limit_{limit.axis}", f"get_limit_{limit.axis}", arguments)
    for each in drive.drives:
        values = (each.stiffness, each.damping, each.force_limit or _NO_LIMIT)
        columns: list[Column] = [*(_numbers(value, rows) for value in values), [each.mode or "force"]]
        name = f"drive_property_{each.axis}"
        yield Call(f"set_{name}", f"get_{name}", side_by_side(columns))
    if drive.target is not None:
        yield target_call(poses(taken(drive.target, rows)))
    if drive.linear_velocity_target is not None or drive.angular_velocity_target is not None:
        linear, angular = (value or STILL for value in (drive.linear_velocity_target, drive.angular_velocity_target))
        yield velocity_call(vectors(taken(linear, rows)), vectors(taken(angular, rows)))
    for name in ("inv_mass_scales", "inv_inertia_scales"):
        value: Value | None = getattr(drive, name)
        if value is not None:
            yield Call(f"set_{name}", None, list(map(tuple, taken(value, rows).tolist())))


def target_call(targets: Column) -> Call:
    """What a drive is driven to: `sapien.Pose`s."""
    return Call("set_drive_target", "get_drive_target", side_by_side([targets]))


def velocity_call(linear: Column, angular: Column) -> Call:
    """How fast it is driven: float32 vectors."""
    return Call("set_drive_velocity_target", "get_drive_velocity_target", side_by_side([linear, angular]))


def _numbers(value: Value, rows: NDArray[np.intp]) -> Column:
    return scalars(taken(value, rows))


def _limited(
    limits: Value, stiffness: Value | None, damping: Value | None, rows: NDArray[np.intp]
) -> list[tuple[Any, ...]]:
    pairs = taken(limits, rows)
    spring = [_numbers(value or _NOTHING, rows) for value in (stiffness, damping)]
    return side_by_side([scalars(pairs[:, 0]), scalars(pairs[:, 1]), *spring])


def start_calls(drive: Drive, rows: NDArray[np.intp]) -> list[Call]:
    """What a reset sets again on a drive that pulls: its targets, as built."""
    if not drive.drives:
        return []
    linear, angular = (value or STILL for value in (drive.linear_velocity_target, drive.angular_velocity_target))
    return [
        target_call(poses(taken(drive.target or IDENTITY, rows))),
        velocity_call(vectors(taken(linear, rows)), vectors(taken(angular, rows))),
    ]


def plain(found: Any) -> list[Any]:
    """What a getter of the engine gives, or a setter takes, as single numbers and words."""
    if isinstance(found, str):
        return [found]
    if isinstance(found, sapien.Pose):
        return [*found.p.tolist(), *found.q.tolist()]
    if isinstance(found, tuple | list):
        parts: list[Any] = [*found]  # pyright: ignore[reportUnknownArgumentType]
        return [number for part in parts for number in plain(part)]
    return np.asarray(found, np.float32).ravel().tolist()
