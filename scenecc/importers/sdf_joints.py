"""Describes SDF joints: as joints of a link tree, or as constraints."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import AXES, IDENTITY, Pose7, Vec3, compose, relative_pose, rotate
from scenecc.importers.numbers import along_x
from scenecc.importers.sdf_files import SMALLEST, SourceElement, find_element, text_of
from scenecc.importers.sdf_scopes import SEPARATOR, WORLD
from scenecc.robots.description import DescribedConstraint, DescribedDrive, DescribedJoint, DescribedMimic
from scenecc.robots.rules import lost_resistance, with_one_resistance

if TYPE_CHECKING:
    from scenecc.importers.sdf_scopes import Scope
    from scenecc.robots.description import DriveAxis, LinkName

_UNLIMITED: Final = 1e9
"""SDF writes "no limit" as 1e16, and worlds also as 1e12."""

_NO_LIMITS: Final = (-math.inf, math.inf)

_AXES_OF: Final = {
    "fixed": (),
    "revolute": ("axis",),
    "continuous": ("axis",),
    "prismatic": ("axis",),
    "screw": ("axis",),
    "universal": ("axis", "axis2"),
    "revolute2": ("axis", "axis2"),
    "ball": ("x", "y", "z"),
}
"""Joint type → tags of its axes, in series; a ball has none of its own."""


@dataclass(frozen=True, slots=True, eq=False)
class SdfJoint:
    """A joint between two links, or between a link and the world. Each equals only itself.

    Attributes:
        scope: the scope that contains it.
        element: the <joint>.
        path: from the top model.
        type: a key of `_AXES_OF`.
        parent, child: paths of links from the world; "" is the world itself.
        pose: of its frame in the world.
        turn: pose of the scope's frame in the world.
    """

    scope: Scope
    element: SourceElement
    path: str
    type: str
    parent: str
    child: str
    pose: Pose7
    turn: Pose7


def read_sdf_joint(
    scope: Scope, element: SourceElement, name: str, prefixes: tuple[str, str], turn: Pose7
) -> SdfJoint | None:
    """Returns a joint; None after an error or a loss.

    Args:
        scope: the scope that contains it.
        element: the <joint>.
        name: its name in the scope.
        prefixes: paths of the scope from the world and from its top model, with a separator at their ends.
        turn: pose of the scope's frame in the world.
    """
    above, inner = prefixes
    kind, file, path = element.attributes.get("type", ""), scope.file, inner + name
    if kind not in _AXES_OF:
        what = f"the joint `{path}` of type `{kind}` is left out"
        file.lose("gearbox-joints" if kind == "gearbox" else "joints", what, element)
        return None
    ends: list[str] = []
    for tag in ("parent", "child"):
        end = text_of(element, tag) or text_of(element, tag, "link_name")
        found = "" if end == WORLD else scope.link_of(end, element)
        if found is None:
            return None
        ends.append(above + found if found else "")
    if ends[0] == ends[1]:
        file.error(f"the joint `{path}` connects a link to itself", element)
        return None
    return SdfJoint(scope, element, path, kind, ends[0], ends[1], compose(turn, scope.pose_of(name, element)), turn)


def freedoms_of(joint: SdfJoint, above: Pose7, below: Pose7, *, is_reversed: bool) -> tuple[DescribedJoint, ...]:
    """Returns the joints of one freedom that a joint consists of, in series; a fixed joint if it has none.

    Args:
        joint: the joint.
        above: pose of the link that carries the other, in the world.
        below: pose of the other link.
        is_reversed: whether the link that carries the other is the joint's child.
    """
    freedoms = _freedoms(joint, above, below, is_reversed=is_reversed)
    for freedom in freedoms:
        if words := lost_resistance(freedom):
            joint.scope.file.lose("joint-friction", words, joint.element)
    return tuple(map(with_one_resistance, freedoms))


def _freedoms(joint: SdfJoint, above: Pose7, below: Pose7, *, is_reversed: bool) -> tuple[DescribedJoint, ...]:
    """Returns what `freedoms_of` does, with all that the file says of friction and damping."""
    tags = _AXES_OF[joint.type]
    if not tags:
        frames = relative_pose(above, joint.pose), relative_pose(below, joint.pose)
        return (DescribedJoint(joint.path, "fixed", *frames, joint.element.location),)
    made: list[DescribedJoint] = []
    for number, tag in enumerate(reversed(tags) if is_reversed else tags, 1):
        name = joint.path if len(tags) == 1 else f"{joint.path}_{number}"
        axis = _axis_of(joint, tag)
        turn = along_x((-axis[0], -axis[1], -axis[2]) if is_reversed else axis)
        before, after = above if number == 1 else joint.pose, below if number == len(tags) else joint.pose
        frames = compose(relative_pose(before, joint.pose), turn), compose(relative_pose(after, joint.pose), turn)
        made.append(_freedom(joint, tag, name, frames))
    return tuple(made)


def _freedom(joint: SdfJoint, tag: str, name: str, frames: tuple[Pose7, Pose7]) -> DescribedJoint:
    """Returns the freedom about or along one axis, whose x the frames have."""
    file, axis = joint.scope.file, joint.element.find(tag)
    low = file.number(axis, "limit", "lower", default=-math.inf)
    high = file.number(axis, "limit", "upper", default=math.inf)
    limits = (-math.inf if low < -_UNLIMITED else low, math.inf if high > _UNLIMITED else high)
    if joint.type == "continuous":
        limits = _NO_LIMITS
    elif limits[0] > limits[1]:
        file.error(f"the lower limit of `{joint.path}` is above the upper one", joint.element)
    if 0 <= file.number(axis, "limit", "effort", default=-1) < _UNLIMITED:
        file.lose("effort-limits", f"the effort of `{joint.path}`; the joint has no drive", joint.element)
    if joint.type == "screw":
        file.lose("screw-joints", f"the screw joint `{joint.path}` turns without moving along its axis", joint.element)
    velocity = file.number(axis, "limit", "velocity", default=-1)
    stiffness = file.number(axis, "dynamics", "spring_stiffness", default=0)
    friction = max(min(file.number(axis, "dynamics", "friction", default=0), _UNLIMITED), 0.0)
    target = file.number(axis, "dynamics", "spring_reference", default=0)
    return DescribedJoint(
        name,
        "prismatic" if joint.type == "prismatic" else "revolute",
        *frames,
        joint.element.location,
        limits,
        friction=0.0,
        friction_force=friction or None,
        damping=max(file.number(axis, "dynamics", "damping", default=0), 0.0),
        velocity=velocity if 0 < velocity <= _UNLIMITED else None,
        mimic=_mimic(joint, axis),
        drive=DescribedDrive(stiffness, 0.0, target=target) if stiffness > 0 else None,
    )


def _mimic(joint: SdfJoint, axis: SourceElement | None) -> DescribedMimic | None:
    mimic = find_element(axis, "mimic")
    if mimic is None:
        return None
    file, prefix = joint.scope.file, joint.path.rpartition(SEPARATOR)[0]
    source = mimic.attributes.get("joint", "")
    multiplier = file.number(mimic, "multiplier", default=1)
    offset = file.number(mimic, "offset", default=0) - multiplier * file.number(mimic, "reference", default=0)
    return DescribedMimic(f"{prefix}{SEPARATOR}{source}" if prefix else source, multiplier, offset, mimic.location)


def _axis_of(joint: SdfJoint, tag: str) -> Vec3:
    """Returns an axis in the joint's frame, from the parent to the child."""
    if tag in AXES:
        return AXES[tag]
    file, axis = joint.scope.file, joint.element.find(tag)
    xyz = file.vector(axis, "xyz", default=AXES["z"])
    if math.hypot(*xyz) < SMALLEST:
        file.error(f"the axis of `{joint.path}` has length 0", joint.element)
        return AXES["z"]
    element = find_element(axis, "xyz")
    frame = "" if element is None else element.attributes.get("expressed_in", "")
    is_model = file.flag(axis, "use_parent_model_frame", default=False) or file.is_before(1, 5)
    if frame and element is not None:
        around = compose(joint.turn, joint.scope.pose_of(frame, element))
    elif is_model:
        around = joint.turn
    else:
        return xyz
    local = relative_pose(joint.pose, around)
    if max(abs(a - b) for a, b in zip(local[3:], IDENTITY, strict=True)) < 1e-12:
        return xyz
    return rotate(local[3:], xyz)


def sdf_constraint(
    joint: SdfJoint, parent: tuple[LinkName, Pose7], child: tuple[LinkName, Pose7], *, is_reversed: bool
) -> DescribedConstraint:
    """Returns a joint as a constraint.

    Args:
        joint: the joint.
        parent: link and its pose in the world.
        child: the same of the other link, which moves.
        is_reversed: whether `parent` is the joint's child.
    """
    file, place = joint.scope.file, joint.element
    first, *others = freedoms = _freedoms(joint, parent[1], child[1], is_reversed=is_reversed)
    for loss, what in dict.fromkeys(lost for freedom in freedoms for lost in _lost_in_a_constraint(freedom)):
        file.lose(loss, f"the {what} of `{joint.path}`, which becomes a constraint", place)
    frames = first.pose_in_parent, first.pose_in_child
    kind, axis, span, drive = "weld", "x", None, None
    if others:
        if joint.type != "ball":
            words = "it becomes a ball joint without limits, springs and damping"
            file.lose("loops", f"the {joint.type} joint `{joint.path}` closes a loop; {words}", place)
        kind, frames = "ball", (relative_pose(parent[1], joint.pose), relative_pose(child[1], joint.pose))
    elif first.type != "fixed":
        kind, span = "slider", first.limits or _NO_LIMITS
        if first.type != "prismatic":
            # PhysX measures a twist from -π to π.
            kind, axis = "hinge", "twist"
            span = (span[0] if span[0] > -math.pi else -math.inf, span[1] if span[1] < math.pi else math.inf)
        if first.drive is not None or first.damping:
            drive = replace(first.drive or DescribedDrive(0.0, 0.0), damping=first.damping)
    drives: tuple[tuple[DriveAxis, DescribedDrive], ...] = () if drive is None else ((axis, drive),)
    return DescribedConstraint(joint.path, kind, parent[0], child[0], *frames, place.location, span, drives=drives)


def _lost_in_a_constraint(freedom: DescribedJoint) -> list[tuple[str, str]]:
    """Returns what a constraint cannot hold of a joint of one freedom: kinds of losses, and words."""
    found = (
        ("joint-friction", "friction", freedom.friction_force),
        ("joint-couplings", "mimic", freedom.mimic),
        ("joint-limits", "velocity limit", freedom.velocity),
    )
    return [(kind, words) for kind, words, value in found if value is not None]
