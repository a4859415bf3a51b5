"""Numbers of the engine as values of a scene document: poses, rotations, colours, and files."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable
from importlib import util
from pathlib import Path
from typing import Any

import numpy as np

from scenecc.geometry.rotations import IDENTITY, from_rpy, looking, normalized, rotate, shortest_from_x
from scenecc.scene_file import Node, is_mapping_node

_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_.-]+")


def to_number(value: Any) -> float:
    """A number without the sign of a zero, whole where it is."""
    return float(value) + 0.0


def to_numbers(values: Iterable[Any]) -> list[float]:
    """Numbers of an array or list."""
    return [to_number(value) for value in values]


def same_single(first: Iterable[float], second: Iterable[float]) -> bool:
    """Whether two rows of numbers are the same in single precision; zeros have no sign."""
    return bool(np.array_equal(np.asarray(list(first), np.float32), np.asarray(list(second), np.float32)))


def nearly_same(first: Iterable[float], second: Iterable[float]) -> bool:
    """Whether two rows of numbers differ by the last bits of single precision, which nobody sees."""
    return bool(
        np.abs(np.asarray(list(first), np.float32) - np.asarray(list(second), np.float32)).max() <= SEEN_TOLERANCE
    )


SEEN_TOLERANCE = 2.5e-7
"""Of numbers near 1 that say where something is that is only seen."""

Same = Callable[[Iterable[float], Iterable[float]], bool]
"""Whether a quaternion that a scene file gives is the one of the engine."""


def pose_value(pose: Any, same: Same = same_single) -> Any:
    """A `sapien.Pose` as a pose of the language; None: the identity."""
    p, q = to_numbers(pose.p), to_numbers(pose.q)
    if same(IDENTITY, q):
        return p if any(p) else None
    return {**({"p": p} if any(p) else {}), **rotation_value(q, same)}


def rotation_value(q: list[float], same: Same = same_single) -> Node:
    """A quaternion, as whole degrees where these give the same one.

    A colliding shape, whose quaternion PhysX normalises once more, is given one of length 1.
    """
    w, x, y, z = q
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    a, b, c = (float(round(math.degrees(angle))) for angle in (roll, pitch, yaw))
    for turns in ((a, b, c), (0.0, b, c - a), (a - c, b, 0.0)):
        for shift in (0.0, 360.0, -360.0):
            candidate = (turns[0], turns[1], turns[2] + shift)
            if max(map(abs, candidate)) <= 360 and same(from_rpy(*map(math.radians, candidate)), q):
                return {"rpy_deg": to_numbers(candidate)}
    unit = to_numbers(np.asarray(normalized(q), np.float32))
    return {"q": unit if not same(q, q) and same(unit, q) else q}


def aimed_pose_value(pose: Any, *, mounted: bool) -> Any:
    """The `sapien.Pose` of a camera as a pose of the language, with `look_at` where the point has few digits.

    A camera along an axis keeps its angles: they are shorter. `mounted`: the sign of its quaternion counts.
    """
    value = pose_value(pose, nearly_same)
    if not is_mapping_node(value) or not any(angle % 90 for angle in value.get("rpy_deg", [1.0])):
        return value
    q = to_numbers(pose.q)
    target = _target_value(to_numbers(pose.p), [q] if mounted else [q, [-item for item in q]])
    return value if target is None else {**({"p": value["p"]} if "p" in value else {}), "look_at": target}


def _target_value(p: list[float], turns: list[list[float]]) -> list[float] | None:
    """A point of few digits for which `look_at` gives one of the quaternions, which are the same turn."""
    w, x, y, z = turns[0]
    forward = rotate((w, x, y, z), (1.0, 0.0, 0.0))
    points: set[tuple[float, float, float]] = set()
    for axis in range(3):
        for step in range(-_REACH, _REACH + 1):
            distance = (step / _STEPS - p[axis]) / forward[axis] if forward[axis] else 0.0
            if distance > 0:
                a, b, c = (round(start + distance * along, 2) + 0.0 for start, along in zip(p, forward, strict=True))
                points.add((a, b, c))
    for point in sorted(points, key=_digits):
        a, b, c = (end - start for end, start in zip(point, p, strict=True))
        found = looking((a, b, c))
        if found is not None and any(nearly_same(found, turn) for turn in turns):
            return list(point)
    return None


def _digits(point: tuple[float, ...]) -> tuple[int, int, tuple[float, ...]]:
    texts = [f"{item:g}" for item in point]
    return max(map(len, texts)), sum(map(len, texts)), point


_REACH, _STEPS = 40, 20
"""Coordinates of points that a camera may look at: 2 m to both sides of the origin, in steps of 5 cm."""


def direction_value(q: list[float]) -> list[float] | None:
    """A short direction to which the shortest turn from x is the quaternion of a light; None: there is none."""
    w, x, y, z = q
    forward = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y))
    largest = max(map(abs, forward))
    for scale in (1, 2, 3, 4, 5, 10):
        a, b, c = (round(item / largest * scale, 2) for item in forward)
        if nearly_same(shortest_from_x((a, b, c)), q):
            return to_numbers((a, b, c))
    return None


def color_value(color: Any) -> list[float] | str:
    """A colour, without an alpha of 1; `"#rrggbb"` where that is it and numbers would be long."""
    numbers = to_numbers(color)
    numbers = numbers[:3] if len(numbers) == 4 and numbers[3] == 1 else numbers
    bytes_ = [round(number * 255) for number in numbers]
    is_hex = max(bytes_) <= 255 and same_single([item / 255 for item in bytes_], numbers)
    is_short = same_single([round(number, 2) for number in numbers], numbers)
    return "#" + "".join(f"{item:02x}" for item in bytes_) if is_hex and not is_short else numbers


def scale_value(scale: Any) -> Any:
    """One factor where all three are the same; None: 1."""
    numbers = to_numbers(scale)
    if len(set(numbers)) == 1:
        return None if numbers[0] == 1 else numbers[0]
    return numbers


def language_name(name: str, *, local: bool = False) -> str:
    """A name of the language for one of the engine, the same where that is one; empty of an empty one.

    `local`: of a link or joint, which may be called `world`.
    """
    plain = _NOT_IN_NAMES.sub("_", name)
    reserved = plain.startswith("x-") or (plain == "world" and not local)
    return plain if not plain or (not reserved and (plain[0].isalpha() or plain[0] == "_")) else f"_{plain}"


class FileNamer:
    """Paths as a scene file names them."""

    def __init__(self, base: Path) -> None:
        """`base`: the folder of the scene file."""
        self._base = base.resolve()

    def name(self, path: str | Path) -> str:
        """`pkg://PACKAGE/PATH` where a package has the file, else relative to the scene file, else absolute."""
        file = Path(path).resolve()
        for parent in file.parents:
            if parent.name in ("site-packages", "dist-packages"):
                package, *rest = file.relative_to(parent).parts
                if rest and util.find_spec(package) is not None:
                    return f"pkg://{package}/{'/'.join(rest)}"
        return file.relative_to(self._base).as_posix() if file.is_relative_to(self._base) else file.as_posix()
