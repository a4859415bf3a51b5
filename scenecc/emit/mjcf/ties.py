"""Constraints: welds and connections as equalities of sites, distances as tendons."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenecc.emit.mjcf.joints import FAR
from scenecc.emit.mjcf.shapes import placed
from scenecc.emit.xml import frames
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.plan import Connection, Distance, Drive, Gear, Weld

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import Model
    from scenecc.plan import Constraint, Value

_POINT = 0.005
"""Size of a site where it is drawn [m]."""

_HIDDEN = 5
"""A group that nobody sees unless he asks."""

_STRAIGHT = ("x", "y", "z")


def write_ties(model: Model) -> None:
    """All constraints of the scene."""
    for constraint in model.plan.constraints:
        if model.scene.index in constraint.scene_idxs:
            _write_tie(model, constraint, constraint.scene_idxs.index(model.scene.index))


def _write_tie(model: Model, constraint: Constraint, row: int) -> None:
    name, joint = constraint.name, constraint.joint
    match joint:
        case Weld():
            _write_equality(model, "weld", constraint, row)
        case Connection():
            _write_equality(model, "connect", constraint, row)
        case Distance():
            _write_distance(model, constraint, joint, row)
        case Drive() if _is_connection(joint, row):
            _write_equality(model, "connect", constraint, row)
            rest = (
                len(joint.limits) > len(_STRAIGHT) or joint.drives or joint.inv_mass_scales or joint.inv_inertia_scales
            )
            if rest:
                words = (
                    "a drive whose x, y and z are locked is a `connect`; its other limits and its drives are left out"
                )
                model.lost.change(name, words, constraint.origin)
        case Drive():
            model.lost.leave_out(name, "a drive between two bodies", constraint.origin)
        case Gear():
            model.lost.leave_out(name, "a gear", constraint.origin)


def _is_connection(drive: Drive, row: int) -> bool:
    locked = {each.axis for each in drive.limits if each.stiffness is None and not each.limits.row(row).any()}
    return locked >= set(_STRAIGHT)


def _write_equality(model: Model, kind: str, constraint: Constraint, row: int) -> None:
    parent, child = _sites(model, constraint, row)
    name = model.name("equality", constraint.name)
    model.sections["equality"].add(kind, name=name, site1=parent[0], site2=child[0])


def _write_distance(model: Model, constraint: Constraint, joint: Distance, row: int) -> None:
    (parent, at), (child, there) = _sites(model, constraint, row)
    low, high = map(float, joint.limits.row(row))
    stiffness = _number(joint.stiffness, row)
    name = model.name("tendon", constraint.name)
    soft = stiffness > 0
    tendon = model.sections["tendon"].add(
        "spatial",
        name=name,
        range=(low, min(high, FAR)) if not soft and low < high else None,
        stiffness=stiffness or None,
        damping=_number(joint.damping, row) or None if soft else None,
        springlength=(low, min(high, FAR)) if soft else None,
        group=_HIDDEN,
    )
    for site in (parent, child):
        tendon.add("site", site=site)
    if not soft and low == high:
        # A range has two ends; an equality counts from where the model starts.
        now = math.dist(at[:3], there[:3])
        model.sections["equality"].add("tendon", tendon1=name, polycoef=(low - now, 0, 0, 0, 0))


def _number(value: Value | None, row: int) -> float:
    return 0.0 if value is None else float(value.row(row))


def _sites(model: Model, constraint: Constraint, row: int) -> tuple[tuple[str, Pose7], tuple[str, Pose7]]:
    """Sites where the frames of a constraint are, in its parent and in its child, and their places in the world."""
    found: list[tuple[str, Pose7]] = []
    of_parent, of_child = frames.of(constraint.pose_in_parent, row), frames.of(constraint.pose_in_child, row)
    for word, mount, pose in (("parent", constraint.parent, of_parent), ("child", constraint.child, of_child)):
        body = None if mount is None else model.bodies[model.key(mount)]
        name = model.name("site", f"{constraint.name}/{word}")
        element = model.world if body is None else body.element
        element.add("site", name=name, **placed(pose), size=(_POINT,), group=_HIDDEN)
        found.append((name, frames.compose(IDENTITY_POSE if body is None else body.pose, pose)))
    return found[0], found[1]
