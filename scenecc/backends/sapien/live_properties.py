"""Setters and getters of values that a reset redraws, besides poses, velocities, joints and targets.

One row for each field of the plan. Resets and saved states use this table. `Quantity.reset` has the same fields for the
language and the plan's JSON; a test compares the two.
"""

from __future__ import annotations

from collections import deque
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from scenecc.backends.sapien.engine import physx, render, sapien
from scenecc.backends.sapien.properties import (
    BODY_PROPERTIES,
    JOINT_LIMITS,
    JOINT_PROPERTIES,
    set_center_of_mass,
    to_poses,
    to_scalars,
    to_vectors,
)
from scenecc.plan.articulation import Joint
from scenecc.plan.body import BodyStructure, Inertial, PhysicalMaterial, VisualMaterial
from scenecc.plan.constraint import AxisDrive, Constraint
from scenecc.plan.properties import property_fields
from scenecc.plan.rendering import Camera, Environment, Intrinsic, Light, Orthographic, Perspective

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from scenecc.backends.sapien.properties import Column, EngineProperty


class LiveProperty(NamedTuple):
    """One field of the plan in a running simulation.

    Attributes:
        set: takes an engine object and an item of a column.
        get: returns the object's value, as numbers in any shape.
        convert: converts rows (B, …) to a column.
        stored: how the engine stores numbers: it rounds them to float32; it stores their inverse; it normalises the
            quaternion of a pose; or it computes an angle from a focal length.
    """

    set: Callable[[Any, Any], Any]
    get: Callable[[Any], Any]
    convert: Callable[[NDArray[Any]], Column] = to_scalars
    stored: Literal["rounded", "inverse", "pose", "angle"] = "rounded"


def _live(prop: EngineProperty) -> LiveProperty:
    return LiveProperty(prop.set, attrgetter(prop.get), prop.convert)


def _make_property(owner: Any, field: str, convert: Callable[[NDArray[Any]], Column] = to_scalars) -> LiveProperty:
    """Returns a property that the engine names as the plan does."""
    return LiveProperty(getattr(owner, f"set_{field}"), attrgetter(field), convert)


def _pose_getter(name: str) -> Callable[[Any], Any]:
    read = attrgetter(name)
    return lambda obj: read(obj).__getstate__()


_Body = physx.PhysxRigidBodyComponent


def _set_mass_and_inertia(body: Any, row: Any) -> None:
    body.set_mass(row[0])
    body.set_inertia(row[1:])


def _mass_and_inertia(body: Any) -> list[float]:
    return [body.get_mass(), *body.get_inertia().tolist()]


MASS_AND_INERTIA = LiveProperty(_set_mass_and_inertia, _mass_and_inertia, list, stored="inverse")
"""`mass` of `BodyStructure`, with the inertia that it scales: (B, 4)."""


def _set_gain(index: int, joint: Any, value: float) -> None:
    gains = [joint.stiffness, joint.damping, joint.force_limit]
    gains[index] = value
    joint.set_drive_properties(*gains, joint.drive_mode)


def _set_axis_gain(index: int, axis: str, component: Any, value: float) -> None:
    gains = list(getattr(component, f"get_drive_property_{axis}")())
    gains[index] = value
    getattr(component, f"set_drive_property_{axis}")(*gains)


_GAINS = ("stiffness", "damping", "force_limit")


def axis_gain(drive: AxisDrive, field: str) -> LiveProperty:
    """Returns a gain of one axis of a constraint's drive."""
    index, axis = _GAINS.index(field), drive.axis

    def get(component: Any) -> float:
        return getattr(component, f"get_drive_property_{axis}")()[index]

    return LiveProperty(partial(_set_axis_gain, index, axis), get)


_CameraClass = render.RenderCameraComponent


def _set_angle(field: str, camera: Any, value: float, *, square: bool) -> None:
    getattr(camera, f"set_{field}")(value, square)


def angle_of_view(lens: Perspective, field: str) -> LiveProperty:
    """Returns the property for `fovx` or `fovy`. Pixels are square if only one is given."""
    square = lens.fovx is None or lens.fovy is None
    setter = partial(_set_angle, field, square=square)
    return LiveProperty(setter, attrgetter(field), stored="angle")


def _set_part_of_matrix(setter: str, names: tuple[str, ...], index: int, camera: Any, value: float) -> None:
    numbers = [getattr(camera, name) for name in names]
    numbers[index] = value
    getattr(camera, setter)(*numbers)


def _matrix_part(setter: str, names: tuple[str, ...], index: int) -> LiveProperty:
    return LiveProperty(partial(_set_part_of_matrix, setter, names, index), attrgetter(names[index]))


def _set_top(camera: Any, top: float) -> None:
    right = top * camera.width / camera.height
    camera.set_orthographic_parameters(camera.near, camera.far, -right, right, -top, top)


def _set_plane(name: str, camera: Any, value: float) -> None:
    if camera.mode != "orthographic":
        setattr(camera, name, value)
        return
    planes = {"near": camera.near, "far": camera.far, name: value}
    sides = (camera.ortho_left, camera.ortho_right, camera.ortho_bottom, camera.ortho_top)
    camera.set_orthographic_parameters(planes["near"], planes["far"], *sides)


def _set_by_name(setter: str, obj: Any, value: Any) -> None:
    """Calls a setter that several classes have: a `PhysxMaterial` and a `SharedMaterial`, a light and a camera."""
    getattr(obj, setter)(value)


def _set_ambient_light(system: Any, color: Any) -> None:
    system.ambient_light = color


def set_enabled(component: Any, flag: bool) -> None:  # noqa: FBT001 - as the engine's setters
    """Enables or disables a constraint, given by its first component."""
    if flag != component.is_enabled:
        for each in components_of(component):
            (each.enable if flag else each.disable)()


def components_of(component: Any) -> list[Any]:
    """Returns all components of a constraint, given by its first: those of its name in its entity."""
    entity = component.get_entity()
    others = () if entity is None else entity.components
    same = (each for each in others if isinstance(each, type(component)) and each.name == component.name)
    return [component, *(each for each in same if each != component)]


_FOCAL_LENGTHS, _PRINCIPAL_POINT = ("fx", "fy"), ("cx", "cy")

LIVE_PROPERTIES: dict[tuple[type, str], LiveProperty] = {
    **{
        (BodyStructure, field): _live(BODY_PROPERTIES.by_field[field])
        for field in ("linear_damping", "angular_damping", "disable_gravity")
    },
    (BodyStructure, "mass"): MASS_AND_INERTIA,
    (BodyStructure, "com"): LiveProperty(set_center_of_mass, attrgetter("cmass_local_pose.p"), to_vectors),
    (Inertial, "mass"): _make_property(_Body, "mass")._replace(stored="inverse"),
    (Inertial, "com"): LiveProperty(
        _Body.set_cmass_local_pose, _pose_getter("cmass_local_pose"), to_poses, stored="pose"
    ),
    (Inertial, "inertia"): _make_property(_Body, "inertia", to_vectors)._replace(stored="inverse"),
    **{
        (PhysicalMaterial, field): LiveProperty(partial(_set_by_name, f"set_{field}"), attrgetter(field))
        for field in ("static_friction", "dynamic_friction", "restitution")
    },
    **{
        (VisualMaterial, field): _make_property(render.RenderMaterial, field, to_vectors)
        for field in ("base_color", "emission")
    },
    **{
        (VisualMaterial, field): _make_property(render.RenderMaterial, field)
        for field in ("specular", "roughness", "metallic", "transmission_roughness")
    },
    **{(Joint, field): _live(JOINT_PROPERTIES.by_field[field]) for field in property_fields("joint")},
    (Joint, "limits"): _live(JOINT_LIMITS),
    **{
        (Joint, field): LiveProperty(partial(_set_gain, index), attrgetter(field)) for index, field in enumerate(_GAINS)
    },
    (Constraint, "enabled"): LiveProperty(set_enabled, attrgetter("is_enabled")),
    (Light, "color"): _make_property(render.RenderLightComponent, "color", to_vectors),
    **{
        (Intrinsic, field): _matrix_part("set_focal_lengths", _FOCAL_LENGTHS, index)
        for index, field in enumerate(_FOCAL_LENGTHS)
    },
    **{
        (Intrinsic, field): _matrix_part("set_principal_point", _PRINCIPAL_POINT, index)
        for index, field in enumerate(_PRINCIPAL_POINT)
    },
    (Intrinsic, "skew"): _make_property(_CameraClass, "skew"),
    (Orthographic, "top"): LiveProperty(_set_top, attrgetter("ortho_top")),
    **{(Camera, field): LiveProperty(partial(_set_plane, field), attrgetter(field)) for field in ("near", "far")},
    (Environment, "ambient_light"): LiveProperty(_set_ambient_light, attrgetter("ambient_light"), to_vectors),
}
"""By the plan's dataclass and its field."""

ENTITY_POSE = LiveProperty(sapien.Entity.set_pose, _pose_getter("pose"), to_poses)
"""`pose` of an unmounted light or camera: that of its own entity."""

LOCAL_POSE = LiveProperty(partial(_set_by_name, "set_local_pose"), _pose_getter("local_pose"), to_poses)
"""`pose` of a mounted light or camera."""


def _pose_property(item: Light | Camera) -> LiveProperty:
    return ENTITY_POSE if item.mount is None else LOCAL_POSE


DEPENDENT_PROPERTIES: dict[tuple[type, str], Callable[[Any], LiveProperty]] = {
    **{(AxisDrive, field): partial(axis_gain, field=field) for field in _GAINS},
    **{(Perspective, field): partial(angle_of_view, field=field) for field in ("fovx", "fovy")},
    (Light, "pose"): _pose_property,
    (Camera, "pose"): _pose_property,
}
"""Properties that depend on other fields of the dataclass: an axis, another angle of view, a mount."""


def live_property(holder: Any, field: str) -> LiveProperty | None:
    """Returns the property of a field of a plan's dataclass. None: it is part of the motion state."""
    key = (holder.__class__, field)
    dependent = DEPENDENT_PROPERTIES.get(key)
    return LIVE_PROPERTIES.get(key) if dependent is None else dependent(holder)


ROTATION_TOLERANCE = 5e-7
"""For the quaternion of a centre of mass: PhysX normalises it, which changes a few units in the last place."""

ANGLE_TOLERANCE = 1e-6
"""Relative, for an angle of view: SAPIEN stores it as a focal length."""


def set_all(prop: LiveProperty, objs: list[Any], rows: NDArray[Any]) -> None:
    """Sets a property of objects to rows (B, …), without a Python call for each, since there are thousands."""
    if prop is MASS_AND_INERTIA:
        masses: list[float] = rows[:, 0].tolist()
        setters: list[tuple[Any, Column]] = [(_Body.set_mass, masses), (_Body.set_inertia, to_vectors(rows[:, 1:]))]
        for setter, column in setters:
            deque(map(setter, objs, column), maxlen=0)  # pyright: ignore[reportUnknownArgumentType]
    else:
        deque(map(prop.set, objs, prop.convert(rows)), maxlen=0)


def read_all(prop: LiveProperty, objs: list[Any]) -> NDArray[np.float32]:
    """Returns the values of objects, (B, n)."""
    if prop is MASS_AND_INERTIA:
        masses = np.array([*map(_Body.get_mass, objs)], np.float32)
        return np.column_stack((masses, np.array([*map(_Body.get_inertia, objs)], np.float32)))
    return np.array([*map(prop.get, objs)], np.float32).reshape(len(objs), -1)


def stored_rows(prop: LiveProperty, rows: NDArray[np.float64]) -> NDArray[np.float32]:
    """Returns what the engine reports after setting rows (B, …), as (B, n)."""
    flat = rows.reshape(len(rows), -1).astype(np.float32)
    if prop.stored == "inverse":
        with np.errstate(divide="ignore", over="ignore"):
            return np.float32(1) / (np.float32(1) / flat)
    return flat
