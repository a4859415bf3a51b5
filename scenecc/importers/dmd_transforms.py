"""Reads Drake's transforms, with the tags of their rotations."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY, from_axis_angle, from_rpy, to_vector
from scenecc.importers.sdf_files import SMALLEST

if TYPE_CHECKING:
    from scenecc.geometry.rotations import Pose7, Quat
    from scenecc.importers.yaml_values import YamlValue


def required_value(value: YamlValue, keys: dict[str, YamlValue], key: str) -> YamlValue:
    """Returns a key of a mapping, whose absence is a fault."""
    if key not in keys:
        raise value.fault(f"{{}} needs the key `{key}`")
    return keys[key]


def read_transform(value: YamlValue) -> tuple[YamlValue | None, Pose7]:
    """Returns the base frame of a transform, if it names one, and the pose in it."""
    keys = value.entries("base_frame", "translation", "rotation")
    p = to_vector(keys["translation"].numbers(3)) if "translation" in keys else (0.0, 0.0, 0.0)
    q = _rotation(keys["rotation"]) if "rotation" in keys else IDENTITY
    return keys.get("base_frame"), (*p, *q)


def _rotation(value: YamlValue) -> Quat:
    """Returns a rotation: `!Rpy {deg}` or `!AngleAxis {angle_deg, axis}`; without a tag it is the identity, `{}`."""
    kind = value.tag
    if kind in {"", "!Identity"}:
        if value.entries():
            raise value.fault("a rotation needs a tag", "write `!Rpy {deg: [ROLL, PITCH, YAW]}`")
        return IDENTITY
    if kind == "!Rpy":
        keys = value.entries("deg")
        roll, pitch, yaw = map(math.radians, required_value(value, keys, "deg").numbers(3))
        return from_rpy(roll, pitch, yaw)
    if kind == "!AngleAxis":
        keys = value.entries("angle_deg", "axis")
        axis = to_vector(required_value(value, keys, "axis").numbers(3))
        if math.hypot(*axis) < SMALLEST:
            raise keys["axis"].fault("{} has length 0")
        return from_axis_angle(axis, math.radians(required_value(value, keys, "angle_deg").number()))
    raise value.fault(f"the rotation `{cut(kind)}` is random or unknown", "write `!Rpy` or `!AngleAxis`")
