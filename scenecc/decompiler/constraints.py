"""Constraints of live scenes as mappings of the language."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from scenecc.backends.sapien.engine import physx
from scenecc.decompiler.values import Node, pose_value, same_single, to_number, to_numbers
from scenecc.plan.properties import FLOAT32_MAX

if TYPE_CHECKING:
    from scenecc.decompiler.record import Recording

COMPONENTS: Final = (physx.PhysxDriveComponent, physx.PhysxDistanceJointComponent, physx.PhysxGearComponent)
"""SAPIEN's components that connect two bodies."""

_AXES: Final = ("x", "y", "z", "twist")

_DRIVES: Final = (*_AXES, "swing", "slerp")


def constraint(
    component: Any, parent: str, child: str, recording: Recording | None, name: str, problems: list[str]
) -> Node | None:
    """A component that connects two bodies; `parent`, `child`: ENTITY or ENTITY/LINK, or "world".

    None: a drive without limits and drives, which does nothing.
    """
    node: Node = {}
    if isinstance(component, physx.PhysxDriveComponent):
        node |= _drive(component, recording)
        if not node.keys() & {"limits", "drive"}:
            unknown = "; build the scene in `scenecc.record()` if it locks axes" if recording is None else ""
            problems.append(f"the drive `{name}` between `{parent}` and `{child}`, which does nothing{unknown}")
            return None
    elif isinstance(component, physx.PhysxGearComponent):
        node |= {"type": "gear", "ratio": to_number(component.gear_ratio)}
        node |= {"enable_hinges": True} if component.is_hinges_enabled else {}
    else:
        limit = recording.call_of(component, "set_limit") if recording is not None else None
        if limit is None:
            problems.append(f"the limits of the distance `{name}`; build the scene in `scenecc.record()`")
            limit = (0.0, 0.0)
        low, high, stiffness, damping = (*to_numbers(limit), 0.0, 0.0)[:4]
        node |= {"type": "distance", "limits": [low, high]}
        node |= {key: value for key, value in (("stiffness", stiffness), ("damping", damping)) if value}
    node |= {"parent": parent, "child": child}
    node["pose_in_parent"] = pose_value(component.pose_in_parent) or [0.0, 0.0, 0.0]
    in_child = pose_value(component.pose_in_child)
    node |= {} if in_child is None else {"pose_in_child": in_child}
    return node | ({} if component.is_enabled else {"enabled": False})


def _drive(component: Any, recording: Recording | None) -> Node:
    node: Node = {"type": "drive"}
    limits: Node = {}
    springs: Node = {}
    for axis in _AXES:
        given = recording.call_of(component, f"set_limit_{axis}") if recording is not None else None
        found = getattr(component, f"get_limit_{axis}")()
        if given is None and found == _fresh_limits()[axis]:
            continue
        low, high, stiffness, damping = (*(given or found), 0.0, 0.0)[:4]
        limits[axis] = [to_number(low), to_number(high)]
        spring = {key: to_number(value) for key, value in (("stiffness", stiffness), ("damping", damping)) if value}
        springs |= {axis: spring} if spring else {}
    node |= {"limits": limits} if limits else {}
    node |= {"limit_springs": springs} if springs else {}
    drives = {axis: found for axis in _DRIVES if (found := _axis_drive(component, axis))}
    node |= {"drive": drives} if drives else {}
    target = pose_value(component.get_drive_target())
    node |= {} if target is None else {"target": target}
    velocities = {
        key: to_numbers(value)
        for key, value in zip(("linear", "angular"), component.get_drive_velocity_target(), strict=True)
        if any(value)
    }
    node |= {"velocity_target": velocities} if velocities else {}
    for name in ("inv_mass_scales", "inv_inertia_scales"):
        given = recording.call_of(component, f"set_{name}") if recording is not None else None
        if given is not None and not same_single(given, (1, 1)):
            node[name] = to_numbers(given)
    return node


@cache
def _fresh_limits() -> dict[str, Any]:
    """What a drive that nobody limits has."""
    fresh = physx.PhysxDriveComponent(physx.PhysxRigidDynamicComponent())
    return {axis: getattr(fresh, f"get_limit_{axis}")() for axis in _AXES}


def _axis_drive(component: Any, axis: str) -> Node:
    stiffness, damping, force_limit, mode = getattr(component, f"get_drive_property_{axis}")()
    node: Node = {key: to_number(value) for key, value in (("stiffness", stiffness), ("damping", damping)) if value}
    if not node:
        return {}
    if not same_single([force_limit], [FLOAT32_MAX]) and not math.isinf(force_limit):
        node["force_limit"] = to_number(force_limit)
    return node if str(mode) == "force" else {**node, "mode": str(mode)}
