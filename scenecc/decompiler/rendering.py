"""Reads lights, cameras and environment of live scenes."""

from __future__ import annotations

import math
from itertools import chain
from typing import TYPE_CHECKING, Any, Final

from scenecc.backends.sapien.engine import render
from scenecc.decompiler.bodies import plain_value
from scenecc.decompiler.values import (
    Node,
    aimed_pose_value,
    direction_value,
    nearly_same,
    pose_value,
    same_single,
    to_number,
    to_numbers,
)
from scenecc.plan.rendering import LIGHT_CLASSES, LIGHT_NUMBERS
from scenecc.plan.schema import type_name

if TYPE_CHECKING:
    from scenecc.decompiler.record import Recording
    from scenecc.decompiler.values import FileNamer

LIGHTS: Final = {component: type_name(kind) for kind, component in LIGHT_CLASSES.items()}
"""SAPIEN's light components → light types of a scene file."""

_SHADOW: Final = {
    "shadow": ("shadow", False),
    "shadow_near": ("shadow_near", 0.1),
    "shadow_far": ("shadow_far", 10.0),
    "shadow_half_size": ("shadow_scale", 10.0),
    "shadow_map_size": ("shadow_map_size", 2048),
}
"""SAPIEN's light properties → key and default of a scene file."""


def light(component: Any, files: FileNamer, mount: str | None) -> Node:
    """Returns a light. `mount`: ENTITY or ENTITY/LINK that it is attached to."""
    type_ = LIGHTS[type(component).__name__]
    node: Node = {"type": type_, "color": to_numbers(component.color)}
    node |= {} if mount is None else {"mount": mount}
    node |= _light_pose(component, type_, mounted=mount is not None)
    for name, (key, usual) in _SHADOW.items():
        if not hasattr(component, name) or (name != "shadow" and not component.shadow):
            continue
        value = plain_value(getattr(component, name))
        otherwise = -10.0 if (type_, name) == ("directional", "shadow_near") else usual
        if not (value == otherwise or (isinstance(value, float) and same_single([value], [otherwise]))):
            node[key] = value
    for key in dict.fromkeys(chain.from_iterable(LIGHT_NUMBERS.values())):
        if hasattr(component, key):
            node[key] = to_number(getattr(component, key))
    if type_ == "textured":
        node["texture"] = files.name(component.texture.filename)
    return node


def _light_pose(component: Any, type_: str, *, mounted: bool) -> Node:
    pose = component.local_pose if mounted else component.entity.pose
    if mounted or type_ == "area":
        value = pose_value(pose, nearly_same)
        return {} if value is None else {"pose": value}
    p, q = to_numbers(pose.p), to_numbers(pose.q)
    where = {"position": p} if any(p) or type_ in ("spot", "textured", "point") else {}
    if type_ == "point" and same_single(q, (1, 0, 0, 0)):
        return where
    direction = direction_value(q)
    if direction is None or type_ == "point":
        return {"pose": pose_value(pose, nearly_same) or [0.0, 0.0, 0.0]}
    return {**where, "direction": direction}


def camera(component: Any, mount: str | None) -> Node:
    """Returns a camera. `mount`: ENTITY or ENTITY/LINK that it is attached to."""
    node: Node = {} if mount is None else {"mount": mount}
    mounted = mount is not None
    pose = component.local_pose if mounted else component.entity.pose * component.local_pose
    value = aimed_pose_value(pose, mounted=mounted)
    node |= {} if value is None else {"pose": value}
    node |= {"width": component.width, "height": component.height}
    node |= _lens(component)
    node |= {} if same_single([component.near], [0.01]) else {"near": to_number(component.near)}
    return node | ({} if same_single([component.far], [100.0]) else {"far": to_number(component.far)})


def _lens(component: Any) -> Node:
    if component.mode == "orthographic":
        return {"orthographic": {"top": to_number(component.ortho_top)}}
    numbers = {key: to_number(getattr(component, key)) for key in ("fx", "fy", "cx", "cy", "skew")}
    middle = (component.width / 2, component.height / 2, 0)
    if numbers["fx"] == numbers["fy"] and (numbers["cx"], numbers["cy"], numbers["skew"]) == middle:
        fovy = 2 * math.atan(component.height / 2 / numbers["fy"])
        degrees = round(math.degrees(fovy), 3)
        for key, shown, angle in (
            ("fovy_deg", degrees, math.radians(degrees)),
            ("fovy", round(fovy, 4), round(fovy, 4)),
            ("fovy", to_number(component.fovy), component.fovy),
        ):
            if _keeps_focal_length(component, angle):
                return {key: shown}
    if (numbers["cx"], numbers["cy"]) == middle[:2]:
        del numbers["cx"], numbers["cy"]
    if not numbers["skew"]:
        del numbers["skew"]
    return {"intrinsic": numbers}


def _keeps_focal_length(component: Any, fovy: float) -> bool:
    other = render.RenderCameraComponent(component.width, component.height)
    other.set_fovy(fovy, compute_x=True)
    return other.fx == component.fx and other.fy == component.fy


def environment(system: Any, recording: Recording | None, files: FileNamer, problems: list[str]) -> Node:
    """Returns the environment of a scene."""
    node: Node = {}
    ambient = to_numbers(system.ambient_light)
    if any(ambient):
        node["ambient_light"] = ambient
    cubemap = system.cubemap
    if cubemap is not None:
        known = recording.cubemaps.get(id(cubemap)) if recording is not None else None
        if known is None:
            problems.append("the environment map, whose file is unknown; build the scene in `scenecc.record()`")
        else:
            names = [files.name(file) for file in known[1]]
            node["map"] = (
                names[0] if len(names) == 1 else dict(zip(("px", "nx", "py", "ny", "pz", "nz"), names, strict=True))
            )
    return node
