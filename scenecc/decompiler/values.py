"""Converts engine numbers to values of a scene document: poses, rotations, colours, files."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from importlib import util
from pathlib import Path
from typing import Any

import numpy as np

from scenecc.colors import color_text, read_color_text
from scenecc.geometry.rotations import IDENTITY, from_rpy, looking, normalized, rotate, shortest_from_x, to_rpy
from scenecc.names import valid_name
from scenecc.scene_file import Node, is_mapping_node


def to_number(value: Any) -> float:
    """Converts a number to float, and -0.0 to 0.0."""
    return float(value) + 0.0


def to_numbers(values: Iterable[Any]) -> list[float]:
    """Converts the numbers of an array or list."""
    return [to_number(value) for value in values]


def same_single(first: Iterable[float], second: Iterable[float]) -> bool:
    """Returns whether two rows of numbers are equal in single precision; 0.0 equals -0.0."""
    return bool(np.array_equal(np.asarray(list(first), np.float32), np.asarray(list(second), np.float32)))


def nearly_same(first: Iterable[float], second: Iterable[float]) -> bool:
    """Returns whether two rows of numbers differ at most in the last bits of single precision, which is invisible."""
    return bool(
        np.abs(np.asarray(list(first), np.float32) - np.asarray(list(second), np.float32)).max() <= SEEN_TOLERANCE
    )


SEEN_TOLERANCE = 2.5e-7
"""Tolerance of numbers near 1 in poses of visual objects."""

Same = Callable[[Iterable[float], Iterable[float]], bool]
"""Whether a quaternion of a scene file is equivalent to the engine's."""


def pose_value(pose: Any, same: Same = same_single) -> Any:
    """Converts a `sapien.Pose` to a pose of a scene file; None for the identity."""
    p, q = to_numbers(pose.p), to_numbers(pose.q)
    if same(IDENTITY, q):
        return p if any(p) else None
    return {**({"p": p} if any(p) else {}), **rotation_value(q, same)}


def rotation_value(q: list[float], same: Same = same_single) -> Node:
    """Converts a quaternion, to whole degrees if these are equivalent.

    PhysX normalizes quaternions of collision shapes again, so these are written with length 1.
    """
    a, b, c = (float(round(math.degrees(angle))) for angle in to_rpy((q[0], q[1], q[2], q[3])))
    for turns in ((a, b, c), (0.0, b, c - a), (a - c, b, 0.0)):
        for shift in (0.0, 360.0, -360.0):
            candidate = (turns[0], turns[1], turns[2] + shift)
            if max(map(abs, candidate)) <= 360 and same(from_rpy(*map(math.radians, candidate)), q):
                return {"rpy_deg": to_numbers(candidate)}
    unit = to_numbers(np.asarray(normalized(q), np.float32))
    return {"q": unit if not same(q, q) and same(unit, q) else q}


def aimed_pose_value(pose: Any, *, mounted: bool) -> Any:
    """Converts a camera's `sapien.Pose`, with `look_at` if the point has few digits.

    An axis-aligned camera keeps its angles, which are shorter. `mounted`: the sign of the quaternion matters.
    """
    value = pose_value(pose, nearly_same)
    if not is_mapping_node(value) or not any(angle % 90 for angle in value.get("rpy_deg", [1.0])):
        return value
    q = to_numbers(pose.q)
    target = _target_value(to_numbers(pose.p), [q] if mounted else [q, [-item for item in q]])
    return value if target is None else {**({"p": value["p"]} if "p" in value else {}), "look_at": target}


def _target_value(p: list[float], turns: list[list[float]]) -> list[float] | None:
    """Returns a point with few digits for which `look_at` gives one of the equivalent quaternions."""
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
"""Range of `look_at` coordinates: 2 m to both sides of the origin, in steps of 5 cm."""


def direction_value(q: list[float]) -> list[float] | None:
    """Returns a short direction that gives a light's quaternion as the shortest rotation from x; None if impossible."""
    w, x, y, z = q
    forward = (1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y))
    largest = max(map(abs, forward))
    for scale in (1, 2, 3, 4, 5, 10):
        a, b, c = (round(item / largest * scale, 2) for item in forward)
        if nearly_same(shortest_from_x((a, b, c)), q):
            return to_numbers((a, b, c))
    return None


def color_value(color: Any) -> list[float] | str:
    """Converts a linear colour, without an alpha of 1; to `"#rrggbb"` if equivalent and shorter."""
    numbers = to_numbers(color)
    numbers = numbers[:3] if len(numbers) == 4 and numbers[3] == 1 else numbers
    if same_single([round(number, 2) for number in numbers], numbers):
        return numbers
    text = color_text(numbers, SEEN_TOLERANCE)
    return text if text is not None and same_single(read_color_text(text)[: len(numbers)], numbers) else numbers


def scale_value(scale: Any) -> Any:
    """Returns one factor if all three are equal; None for 1."""
    numbers = to_numbers(scale)
    if len(set(numbers)) == 1:
        return None if numbers[0] == 1 else numbers[0]
    return numbers


def language_name(name: str, *, local: bool = False) -> str:
    """Returns the nearest valid name; empty for an empty one.

    `local`: of a link or joint, which may be named `world`.
    """
    if name == "world" and not local:
        return "_world"
    return valid_name(name) if name else ""


class FileNamer:
    """Converts file paths for a scene file."""

    def __init__(self, base: Path) -> None:
        """`base`: folder of the scene file."""
        self._base = base.resolve()

    def name(self, path: str | Path) -> str:
        """Returns `pkg://PACKAGE/PATH` for a package, else a path relative to the scene file, else an absolute one."""
        file = Path(path).resolve()
        for parent in file.parents:
            if parent.name in ("site-packages", "dist-packages"):
                package, *rest = file.relative_to(parent).parts
                if rest and util.find_spec(package) is not None:
                    return f"pkg://{package}/{'/'.join(rest)}"
        return file.relative_to(self._base).as_posix() if file.is_relative_to(self._base) else file.as_posix()
