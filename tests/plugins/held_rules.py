"""The rules across the fields of constraints, lights and cameras: what they hold on to, and what excludes what."""

from __future__ import annotations

import math
from random import Random
from typing import NamedTuple

from plugins.articulation_rules import robot_of
from plugins.scene_nodes import KINDS, Node, ascending, drop, is_copied, keep_one, nodes, scenes_of

LENSES = ("fovy", "fovy_deg", "fovx", "fovx_deg", "intrinsic", "orthographic")


class _End(NamedTuple):
    """What may be held on to. `body`: which one it is, whatever it is called."""

    name: str
    body: tuple[str, str]
    scenes: frozenset[int]
    kind: str
    is_hinged: bool = False


def _ends(document: Node) -> list[_End]:
    """Every body that something else may name."""
    found: list[_End] = []
    for name, entity in document.get("entities", {}).items():
        if is_copied(entity):
            continue
        scenes = scenes_of(entity, document)
        if not any(key in entity for key in KINDS):
            found.append(_End(name, (name, ""), scenes, entity.get("body_type", "dynamic")))
            continue
        robot = robot_of(entity)
        root = robot.links[0]
        if "body_type" in entity:
            found.append(_End(name, (name, root), scenes, entity["body_type"]))
            continue
        still = "fixed root" if entity.get("fix_root_link", "root" not in entity) else "dynamic"
        found.append(_End(name, (name, root), scenes, still))
        for link in robot.links:
            kind = still if link == root else "dynamic"
            found.append(_End(f"{name}/{link}", (name, link), scenes, kind, link in robot.hinged))
    return found


def mounts(document: Node, random: Random) -> None:
    """What a light or a camera is mounted on is in all of its scenes."""
    ends = _ends(document)
    for section in ("lights", "cameras"):
        for held in document.get(section, {}).values():
            if "mount" in held:
                scenes = scenes_of(held, document)
                names = [end.name for end in ends if scenes <= end.scenes]
                drop(held, "mount")
                if names:
                    held["mount"] = random.choice(names)


def lights(document: Node, random: Random) -> None:
    """A light stands and shines in one way, its cone is given once, and only a shadow has keys of one."""
    for light in document.get("lights", {}).values():
        _stand(light, random)
        if light.get("shadow") is not True:
            drop(light, "shadow", "shadow_near", "shadow_far", "shadow_scale", "shadow_map_size")
        if light["type"] == "directional":
            _near_and_far(light, "shadow_near", "shadow_far", -10)
        else:
            _near_and_far(light, "shadow_near", "shadow_far", 0.1)
        if light["type"] in {"spot", "textured"}:
            drop(light, *(f"{side}_fov{unit}" for side in ("inner", "outer") for unit in ("", "_deg")))
            for side, degrees in zip(("inner", "outer"), sorted(random.randint(1, 179) for _ in "ab"), strict=True):
                key, angle = random.choice([("", math.radians(degrees)), ("_deg", degrees)])
                light[f"{side}_fov{key}"] = angle


def _stand(light: Node, random: Random) -> None:
    keep_one(light, random, ("pose",), ("position", "direction"))
    if light["type"] in {"point", "directional", "spot", "textured"} and not any(light.get("direction", [1])):
        light["direction"] = [0, 0, -1]
    if "mount" in light or "pose" in light:
        return
    match light["type"]:
        case "area":
            light["pose"] = [0, 0, 2]
        case "point":
            light.setdefault("position", [0, 0, 2])
        case "directional":
            light.setdefault("direction", [0, 1, -1])
        case _:
            light.setdefault("position", [0, 0, 2])
            light.setdefault("direction", [0, 1, -1])


def _near_and_far(node: Node, near: str, far: str, least: float) -> None:
    """What is left out has its own default: both are given, or none."""
    given = [node[key] for key in (near, far) if key in node]
    drop(node, near, far)
    if given:
        node[near] = max(min(given), least)
        node[far] = max(*given, node[near]) + 1


def cameras(document: Node, random: Random) -> None:
    """One lens, and something between near and far."""
    for camera in document.get("cameras", {}).values():
        keep_one(camera, random, *((lens,) for lens in LENSES))
        _near_and_far(camera, "near", "far", 0.01)


def constraints(document: Node, random: Random) -> None:
    """Constraints tie two bodies of the same scenes together, one of which moves, and say what does something."""
    ends = _ends(document)
    kept = document.get("constraints", {})
    for name, constraint in list(kept.items()):
        pair = _pair(constraint, ends, document, random)
        if pair is None:
            del kept[name]
            continue
        parent, child = pair
        constraint["parent"] = "world" if parent is None else parent.name
        constraint["child"] = child.name
        if constraint.get("enable_hinges"):
            constraint["enable_hinges"] = parent is not None and parent.is_hinged and child.is_hinged
        for pose in ("pose_in_parent", "pose_in_child", "target"):
            for node in nodes(constraint.get(pose)):
                drop(node, "relative_to")
        if parent is None or len(kept) > 1:  # another one may keep the bodies apart
            drop(constraint, "collide")
        _typed(constraint, random)


def _pair(constraint: Node, ends: list[_End], document: Node, random: Random) -> tuple[_End | None, _End] | None:
    selected = "scene_idxs" in constraint
    scenes = scenes_of(constraint, document)
    there = [end for end in ends if end.kind != "none" and (not selected or scenes <= end.scenes)]
    if constraint.get("enable_hinges") and random.random() < 0.8:
        there = [end for end in there if end.is_hinged] or there
    pairs = [
        (parent, child)
        for child in there
        if child.kind != "static"
        for parent in (None, *there)
        if (child.kind == "dynamic" or (parent is not None and parent.kind == "dynamic"))
        and (parent is None or (parent.body != child.body and parent.scenes & child.scenes))
    ]
    return random.choice(pairs) if pairs else None


def _typed(constraint: Node, random: Random) -> None:
    match constraint["type"]:
        case "distance":
            constraint["limits"].sort()
        case "gear":
            constraint["ratio"] = constraint["ratio"] or 1
        case "hinge" | "slider" | "ball":
            keep_one(constraint, random, ("limits",), ("limits_deg",))
            for key in ("limits", "limits_deg"):
                if key in constraint:
                    sides = constraint[key]
                    near = sides if constraint["type"] == "slider" else [min(max(side, -3), 3) for side in sides]
                    constraint[key] = ascending(near, random)
            drive = constraint.get("drive") or {}
            for aim, strength in (("target", "stiffness"), ("velocity_target", "damping")):
                if aim in drive:
                    drive.setdefault(strength, 1.0)
        case "drive":
            _drive(constraint, random)


def _drive(constraint: Node, random: Random) -> None:
    limits = constraint.setdefault("limits", {})
    for axis in constraint.get("limit_springs", {}):
        limits.setdefault(axis, [0, 1])
    for axis, pair in limits.items():
        sides = [min(max(side, -3), 3) for side in pair] if axis == "twist" else pair
        limits[axis] = ascending(sides, random)
    drives = constraint.setdefault("drive", {})
    keep_one(drives, random, ("slerp",), ("twist", "swing"))
    if not limits and not drives:
        limits["x"] = [0, 0]
    if not drives:
        drop(constraint, "target", "velocity_target")
