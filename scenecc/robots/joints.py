"""Joints of a URDF, as SAPIEN's loader gives them to its builders."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
from scenecc.robots.description import DescribedJoint, DescribedMimic
from scenecc.robots.geometry import read_origin
from scenecc.robots.pose32 import compose, pose_of_matrix
from scenecc.robots.reading import doubt_degrees, number, optional_number, three, word

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.robots.description import JointWord, PoseNumbers, Vector3
    from scenecc.robots.findings import Findings
    from scenecc.robots.xml import Element

_TYPES: dict[str, JointWord] = {
    "fixed": "fixed",
    "revolute": "revolute_unwrapped",
    "continuous": "revolute",
    "prismatic": "prismatic",
}
"""URDF's word for a type → SAPIEN's."""

_KINDS = (*_TYPES, "floating", "planar")


@frozen
class JointRow:
    """A joint of the file before its numbers are read.

    Attributes:
        kind: URDF's word for its type.
    """

    name: str
    kind: str
    parent: str
    child: str
    element: Element


def read_row(element: Element, findings: Findings) -> JointRow | None:
    """Name, type and links of a <joint>; None, reported, where one is missing or wrong."""
    name, kind = word(element, "name", findings), word(element, "type", findings)
    ends: list[str | None] = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None:
            findings.report("SC455", f"<joint> has no <{tag}>", element.location)
        ends.append(None if end is None else word(end, "link", findings))
    parent, child = ends
    if kind is not None and kind not in _KINDS:
        findings.report("SC464", f"`{cut(kind)}` is no type of joint", element.at("type"), hint=suggest(kind, _KINDS))
        return None
    if kind == "planar":
        findings.report(
            "SC464",
            "a planar joint is not supported, by SAPIEN neither",
            element.at("type"),
            hint="write two prismatic joints and a revolute one, with links of little mass between them",
        )
        return None
    if name is None or kind is None or parent is None or child is None:
        return None
    return JointRow(name, kind, parent, child, element)


def read_joint(row: JointRow, scale: float, findings: Findings) -> DescribedJoint | None:
    """The joint of a row that is not floating; None, reported, where something of it is wrong."""
    before = findings.errors
    element = row.element
    origin = read_origin(element, scale, findings)
    axis = _axis(row, findings)
    limits = _limits(row, scale, findings)
    friction, damping = _dynamics(element, findings)
    effort, velocity = _actuator(row, scale, findings)
    mimic = _mimic(element, findings)
    if origin is None or axis is None or findings.errors > before:
        return None
    frame = _frame(*axis)
    return DescribedJoint(
        name=row.name,
        type=_TYPES[row.kind],
        pose_in_parent=compose(origin, frame),
        pose_in_child=frame,
        location=element.location,
        limits=limits,
        friction=friction,
        damping=damping,
        effort=effort,
        velocity=velocity,
        mimic=mimic,
    )


def _axis(row: JointRow, findings: Findings) -> Vector3 | None:
    """The axis, of length 1; x where there is none."""
    element = row.element.find("axis")
    if element is None:
        return (1.0, 0.0, 0.0)
    read = three(element, "xyz", findings)
    if read is None:
        return None
    axis: NDArray[np.float64] = np.array(read)
    if np.linalg.norm(axis) < 1e-4:
        if row.kind != "fixed":
            findings.report(
                "SC469",
                f"the axis of the joint `{cut(row.name)}` has no length: x is taken, as SAPIEN does",
                element.at("xyz"),
                hint="write the axis that is meant, `1 0 0` if x is",
            )
        return (1.0, 0.0, 0.0)
    # Twice, since SAPIEN's loader and what it reads with both do so, and the last bit may change.
    axis = axis / np.linalg.norm(axis)
    axis = axis / np.linalg.norm(axis)
    return (float(axis[0]), float(axis[1]), float(axis[2]))


@lru_cache(maxsize=1024)
def _frame(x: float, y: float, z: float) -> PoseNumbers:
    """A frame whose x is the axis; y and z are those that SAPIEN's loader chooses."""
    axis: NDArray[np.float64] = np.array((x, y, z))
    beside: NDArray[np.float64] = np.array((0.0, 0.0, 1.0) if abs(x) > 0.9 else (1.0, 0.0, 0.0))
    second: NDArray[np.float64] = np.array(np.cross(axis, beside), np.float64)
    second /= np.linalg.norm(second)
    matrix: NDArray[np.float64] = np.eye(4)
    matrix[:3, 0] = axis
    matrix[:3, 1] = second
    matrix[:3, 2] = np.cross(axis, second)
    return pose_of_matrix(matrix)


def _limits(row: JointRow, scale: float, findings: Findings) -> tuple[float, float] | None:
    if row.kind not in {"revolute", "prismatic"}:
        return None if row.kind == "fixed" else (-math.inf, math.inf)
    element = row.element.find("limit")
    if element is None:
        findings.report(
            "SC465",
            f"the {row.kind} joint `{cut(row.name)}` has no <limit>",
            row.element.location,
            hint="write <limit lower=… upper=…/>"
            + ("; a joint that turns without end is continuous" if row.kind == "revolute" else ""),
        )
        return None
    ends: list[float | None] = []
    for end in ("lower", "upper"):
        if end not in element.attributes:
            findings.report("SC465", f"<limit> has no `{end}`, which SAPIEN wants", element.location)
        ends.append(number(element, end, findings, infinite=True) if end in element.attributes else None)
    low, high = ends
    if low is None or high is None:
        return None
    if low > high or math.inf in {low, -high}:
        message = f"the lower limit {low:g} is above the upper {high:g}" if low > high else "the limits leave nothing"
        findings.report("SC465", message, element.at("lower"))
        return None
    if row.kind == "prismatic":
        return low * scale, high * scale
    doubt_degrees((low, high), "a limit", element.at("upper" if abs(high) >= abs(low) else "lower"), findings)
    return low, high


def _dynamics(element: Element, findings: Findings) -> tuple[float | None, float]:
    """Friction, None where there is none, and damping."""
    dynamics = element.find("dynamics")
    if dynamics is None:
        return None, 0.0
    read: list[float | None] = []
    for name in ("friction", "damping"):
        value, _ = optional_number(dynamics, name, findings)
        if value is not None and value < 0:
            findings.report("SC466", f"the {name} is {value:g}, which is below 0", dynamics.at(name))
        read.append(value)
    return read[0], read[1] or 0.0


def _actuator(row: JointRow, scale: float, findings: Findings) -> tuple[float | None, float | None]:
    """Effort and velocity; None where there is none, or none above 0, as many files have it that know of none.

    A velocity of a prismatic joint is a length [m/s]. An effort is a force, which no scale of lengths says anything of.
    """
    limit = row.element.find("limit")
    if limit is None:
        return None, None
    values = [optional_number(limit, name, findings, infinite=True)[0] for name in ("effort", "velocity")]
    for name, value in zip(("effort", "velocity"), values, strict=True):
        if value is not None and value < 0:
            message = f"the {name} is {value:g}, which limits nothing: none is taken"
            findings.report_once(
                "SC487", name, message, limit.at(name), "write what the actuator can do, or leave it out"
            )
    effort, velocity = (value if value is not None and 0 < value < math.inf else None for value in values)
    return effort, velocity * scale if velocity is not None and row.kind == "prismatic" else velocity


def _mimic(element: Element, findings: Findings) -> DescribedMimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    source = word(mimic, "joint", findings)
    multiplier, is_read = optional_number(mimic, "multiplier", findings)
    offset, is_offset_read = optional_number(mimic, "offset", findings)
    if source is None or not (is_read and is_offset_read):
        return None
    multiplier = 1.0 if multiplier is None else multiplier
    if multiplier == 0:
        findings.report(
            "SC472",
            "the multiplier of <mimic> is 0: the joint follows nothing",
            mimic.at("multiplier"),
            hint="make the joint a fixed one",
        )
        return None
    return DescribedMimic(source, multiplier, 0.0 if offset is None else offset, mimic.at("joint"))
