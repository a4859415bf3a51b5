"""Joints of an MJCF: their frames, limits and damping, as ManiSkill's loader gives them to its builder."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.robots.description import DescribedJoint, JointWord
from scenecc.robots.mjcf.attributes import single
from scenecc.robots.pose32 import compose, pose_of_matrix
from scenecc.robots.reading import doubt_degrees

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.robots.description import PoseNumbers
    from scenecc.robots.mjcf.attributes import Attributes
    from scenecc.robots.mjcf.classes import Classes, Scope
    from scenecc.robots.mjcf.compiler import Compiler
    from scenecc.robots.xml import Element

READ = frozenset({"name", "class", "type", "pos", "axis", "range", "limited", "ref", "damping", "frictionloss"})
"""The attributes that are heeded."""

_TYPES = ("hinge", "slide", "fixed", "ball", "free")
_SHORT = 1e-3
"""Below this length ManiSkill's loader takes x for the axis."""


@dataclass(frozen=True, slots=True)
class Joints:
    """Makes joints of the elements `joint` of a file."""

    classes: Classes
    compiler: Compiler

    def make(self, element: Element, scope: Scope, in_parent: PoseNumbers) -> DescribedJoint:
        """The joint of an element. One that cannot be built is reported, and fixed.

        Args:
            element: a `joint`.
            scope: where it stands.
            in_parent: pose of the body in the link that the joint hangs on.
        """
        joint = self.classes.attributes(element, scope, READ)
        kind = joint.word("type", _TYPES, "hinge")
        if kind in {"ball", "free"}:
            reason = "PhysX's articulations have none" if kind == "ball" else "only a body of the world may have one"
            self.classes.report.error("SC483", f"a joint of type `{kind}` cannot be built: {reason}", joint.at("type"))
            kind = "fixed"
        start = joint.number("ref", 0.0)
        if start and kind != "fixed":
            self.classes.report.left_out(
                "ref",
                "positions count from where the file puts the body, which is 0 and not `ref`",
                joint.at("ref"),
                "a position of MuJoCo's, less `ref`, is one of `qpos`; limits are taken so",
            )
        p = joint.singles("pos", (0.0, 0.0, 0.0))
        frame = pose_of_matrix(_frame(_axis(joint, kind), p))
        limits = _limits(joint, self.compiler, start) if kind != "fixed" else None
        words: dict[str, JointWord] = {"hinge": "revolute_unwrapped", "slide": "prismatic", "fixed": "fixed"}
        word = "revolute" if kind == "hinge" and limits is None else words[kind]
        return DescribedJoint(
            name=joint.text("name"),
            type=word,
            pose_in_parent=compose(in_parent, frame),
            pose_in_child=frame,
            location=element.location,
            limits=limits or (None if kind == "fixed" else (-math.inf, math.inf)),
            friction=joint.number("frictionloss", 0.0, 0.0) if "frictionloss" in joint and kind != "fixed" else None,
            damping=0.0 if kind == "fixed" else joint.number("damping", 0.0, 0.0),
        )

    def fixed(self, body: Element, scope: Scope, in_parent: PoseNumbers) -> DescribedJoint:
        """The joint of a body that has none: its frame is its class's, as ManiSkill's loader has it."""
        joint = self.classes.inherited("joint", body, scope)
        p = joint.singles("pos", (0.0, 0.0, 0.0))
        frame = pose_of_matrix(_frame(_axis(joint, "fixed"), p))
        return DescribedJoint("", "fixed", compose(in_parent, frame), frame, body.location)


def _axis(joint: Attributes, kind: str) -> NDArray[Any]:
    """The direction of a joint's axis, of length 1 but for rounding."""
    x = np.array([1.0, 0.0, 0.0])
    if "axis" not in joint:
        if kind == "fixed":
            return x
        what = "a joint without `axis` has that along z; ManiSkill's loader takes x"
        joint.report.differs("axis", what, joint.element.location)
    axis = np.array(joint.numbers("axis", (0.0, 0.0, 1.0)), np.float32)
    length = np.linalg.norm(axis)
    if length < _SHORT:
        if kind == "fixed":
            return x
        if not length > 0:
            joint.wrong("axis", "has no length")
            return x
        joint.report.differs("short axis", "ManiSkill's loader takes so short an `axis` for x", joint.at("axis"))
    if not length < math.inf:
        joint.wrong("axis", "is so long that single precision does not hold its length")
        return x
    return axis / length


def _frame(axis: NDArray[Any], p: tuple[float, ...]) -> NDArray[np.float64]:
    """A frame whose x is an axis."""
    other = [0.0, 0.0, 1.0] if abs(axis @ [1.0, 0.0, 0.0]) > 0.9 else [1.0, 0.0, 0.0]
    y = np.cross(axis, other)
    y /= np.linalg.norm(y)
    matrix: NDArray[np.float64] = np.eye(4)
    matrix[:3, 3] = p
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = axis, y, np.cross(axis, y)
    return matrix


def _limits(joint: Attributes, compiler: Compiler, start: float) -> tuple[float, float] | None:
    """Lowest and highest position; None: no limits. In single precision, as degrees turn to radians in the loader.

    `start`: the position at the start, which is 0 in what is built.
    """
    limited = joint.word("limited", ("auto", "true", "false"), "auto")
    if limited == "false" or (limited == "auto" and "range" not in joint):
        return None
    if "range" not in joint:
        joint.report.error("SC481", "a joint that is limited has no `range`", joint.at("limited"))
        return None
    values = joint.numbers("range", (0.0, 0.0), infinite=True)
    if limited == "auto" and not compiler.limits_by_range:
        joint.wrong("range", "limits nothing without `limited`, since `autolimits` is false", 'write `limited="true"`')
        return None
    if limited == "auto" and not any(values):
        joint.report.differs(
            "range 0 0", "a `range` of 0 0 limits nothing; ManiSkill's loader locks the joint", joint.at("range")
        )
        return None
    if values[0] > values[1]:
        joint.wrong("range", f"leads from {values[0]:g} down to {values[1]:g}")
    if start:
        what = "limits are counted from `ref`; ManiSkill's loader leaves that out"
        joint.report.differs("ref", what, joint.at("range"))
    singles = np.array([value - start for value in values], np.float32)
    if joint.text("type", "hinge") == "hinge" and compiler.degrees:
        singles = np.deg2rad(singles)
    elif joint.text("type", "hinge") == "hinge":
        doubt_degrees(values, "a limit", joint.at("range"), joint.report.of(joint.at("range")))
    return single(singles[0]), single(singles[1])
