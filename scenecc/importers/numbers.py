"""Numbers, poses and names as a scene file writes them."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

from scenecc.geometry.rotations import IDENTITY, Pose7, rotate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.geometry.rotations import Quat, Vec3

_ROUND = 12
"""Decimals that are kept: far below what the engine's single precision holds."""

_AXES = {(1.0, 0.0, 0.0): "x", (0.0, 1.0, 0.0): "y", (0.0, 0.0, 1.0): "z"}


def plain_number(value: float) -> float | int:
    """A number without the noise of its arithmetic; a whole one as an integer."""
    rounded = round(value, _ROUND) if abs(value) < 1e3 else value
    return int(rounded) if rounded == int(rounded) and abs(rounded) < 1e6 else rounded


def plain_numbers(values: Sequence[float]) -> list[float | int]:
    """Several of them."""
    return [plain_number(value) for value in values]


def plain_pose(pose: Pose7) -> Any:
    """A pose as `pose:` takes it; None for the identity."""
    p, q = plain_numbers(pose[:3]), pose[3:]
    turn = max(abs(a - b) for a, b in zip(q, IDENTITY, strict=True))
    if turn < 1e-12 or max(abs(a + b) for a, b in zip(q, IDENTITY, strict=True)) < 1e-12:
        return p if any(p) else None
    turned = _plain_rotation(q)
    return {"p": p, **turned} if any(p) else turned


def _plain_rotation(q: Quat) -> dict[str, Any]:
    """Roll, pitch and yaw where these are whole degrees; else the quaternion."""
    w, x, y, z = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    degrees = [math.degrees(angle) for angle in (roll, pitch, yaw)]
    whole = [round(angle) for angle in degrees]
    is_whole = all(abs(a - b) < 1e-9 for a, b in zip(degrees, whole, strict=True)) and abs(whole[1]) < 90
    return {"rpy_deg": whole} if is_whole else {"q": [round(each, 15) + 0.0 for each in q]}


def plain_axis(axis: Vec3) -> Any:
    """A direction: a letter where it is an axis, else a unit vector."""
    length = math.sqrt(sum(each * each for each in axis))
    unit = [round(each / length, 15) + 0.0 for each in axis]
    return _AXES.get((unit[0], unit[1], unit[2]), unit)


def turned_axis(pose: Pose7, axis: Vec3) -> Vec3:
    """A direction of a pose's own frame, in the frame around it. No noise where nothing turns."""
    return axis if pose[3:] == IDENTITY else rotate(pose[3:], axis)


class Names:
    """Names that the language takes, each once."""

    def __init__(self, *taken: str) -> None:
        self._taken = set(taken)
        self._counts: dict[str, int] = {}

    def new(self, wish: str) -> str:
        """The nearest free name: what a name cannot hold becomes `_`."""
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", wish.replace("::", "."))
        name = name if re.match(r"[A-Za-z_]", name) and not name.startswith("x-") else f"_{name}"
        free, count = name, self._counts.get(name, 1)
        while free in self._taken:
            count += 1
            free = f"{name}_{count}"
        self._counts[name] = count
        self._taken.add(free)
        return free
