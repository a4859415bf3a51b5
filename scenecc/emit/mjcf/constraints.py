"""Writes contact exclusions, equality constraints and tendons."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING

from scenecc.emit import xml
from scenecc.emit.mjcf.model import pose_attributes
from scenecc.emit.xml import UNLIMITED
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.plan import Connection, Distance, Drive, Gear, Weld

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import MjcfModel, ModelBody
    from scenecc.plan import Constraint, Value


_GROUP_ID_MASK = 0xFFFF
"""The bits of the fourth integer that say which bodies the third is about."""


def write_contact_exclusions(model: MjcfModel) -> None:
    """Excludes links and what they hang on, bodies that a constraint ties, and those that ignore one another by bits.

    MuJoCo leaves out a body and its parent by itself, but not where the parent is fixed to the world.
    """
    found: dict[tuple[str, str], None] = {}
    for (entity, _), body in model.bodies.items():
        parent = body.measured.parent
        if parent is not None and not body.is_fixed:
            above = [each for (name, _), each in model.bodies.items() if name == entity][parent]
            if above.is_fixed and above.measured.shapes and body.measured.shapes:
                found[above.name, body.name] = None
    for constraint in model.plan.constraints:
        if constraint.parent is not None and model.scene.index in constraint.scene_idxs:
            a, b = (model.bodies[model.key(mount)].name for mount in (constraint.parent, constraint.child))
            found[a, b] = None
    ignoring = [body for body in model.bodies.values() if body.measured.shapes and body.measured.shapes[0].groups[2]]
    for a, b in combinations(ignoring, 2):
        if (
            _ignore_each_other(a, b)
            and not (a.is_fixed and b.is_fixed)
            and not {(a.name, b.name), (b.name, a.name)} & found.keys()
        ):
            found[a.name, b.name] = None
    for a, b in found:
        model.sections["contact"].add("exclude", body1=a, body2=b)


def _ignore_each_other(a: ModelBody, b: ModelBody) -> bool:
    (_, _, bits_a, id_a), (_, _, bits_b, id_b) = (each.measured.shapes[0].groups for each in (a, b))
    return bool(bits_a & bits_b) and id_a & _GROUP_ID_MASK == id_b & _GROUP_ID_MASK


_SITE_SIZE = 0.005
"""Size of a site where it is drawn [m]."""

_HIDDEN_GROUP = 5
"""A group that nobody sees unless he asks."""

_LINEAR_AXES = ("x", "y", "z")


def write_constraints(model: MjcfModel) -> None:
    """All constraints of the scene."""
    for constraint in model.plan.constraints:
        if model.scene.index in constraint.scene_idxs:
            _write_constraint(model, constraint, constraint.scene_idxs.index(model.scene.index))


def _write_constraint(model: MjcfModel, constraint: Constraint, row: int) -> None:
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
                len(joint.limits) > len(_LINEAR_AXES)
                or joint.drives
                or joint.inv_mass_scales
                or joint.inv_inertia_scales
            )
            if rest:
                words = (
                    "a drive whose x, y and z are locked is a `connect`; its other limits and its drives are left out"
                )
                model.unsupported.change(name, words, constraint.origin)
        case Drive():
            model.unsupported.leave_out(name, "a drive between two bodies", constraint.origin)
        case Gear():
            model.unsupported.leave_out(name, "a gear", constraint.origin)


def _is_connection(drive: Drive, row: int) -> bool:
    locked = {each.axis for each in drive.limits if each.stiffness is None and not each.limits.row(row).any()}
    return locked >= set(_LINEAR_AXES)


def _write_equality(model: MjcfModel, kind: str, constraint: Constraint, row: int) -> None:
    parent, child = _write_sites(model, constraint, row)
    name = model.name("equality", constraint.name)
    model.sections["equality"].add(kind, name=name, site1=parent[0], site2=child[0])


def _write_distance(model: MjcfModel, constraint: Constraint, joint: Distance, row: int) -> None:
    (parent, at), (child, there) = _write_sites(model, constraint, row)
    low, high = map(float, joint.limits.row(row))
    stiffness = _number_in_row(joint.stiffness, row)
    name = model.name("tendon", constraint.name)
    soft = stiffness > 0
    tendon = model.sections["tendon"].add(
        "spatial",
        name=name,
        range=(low, min(high, UNLIMITED)) if not soft and low < high else None,
        stiffness=stiffness or None,
        damping=_number_in_row(joint.damping, row) or None if soft else None,
        springlength=(low, min(high, UNLIMITED)) if soft else None,
        group=_HIDDEN_GROUP,
    )
    for site in (parent, child):
        tendon.add("site", site=site)
    if not soft and low == high:
        # A range has two ends; an equality counts from where the model starts.
        now = math.dist(at[:3], there[:3])
        model.sections["equality"].add("tendon", tendon1=name, polycoef=(low - now, 0, 0, 0, 0))


def _number_in_row(value: Value | None, row: int) -> float:
    return 0.0 if value is None else float(value.row(row))


def _write_sites(model: MjcfModel, constraint: Constraint, row: int) -> tuple[tuple[str, Pose7], tuple[str, Pose7]]:
    """Sites where the frames of a constraint are, in its parent and in its child, and their places in the world."""
    found: list[tuple[str, Pose7]] = []
    for word, mount, frame in (
        ("parent", constraint.parent, constraint.pose_in_parent),
        ("child", constraint.child, constraint.pose_in_child),
    ):
        pose = xml.pose_in_row(frame, row)
        body = None if mount is None else model.bodies[model.key(mount)]
        name = model.name("site", f"{constraint.name}/{word}")
        element = model.world if body is None else body.element
        element.add("site", name=name, **pose_attributes(pose), size=(_SITE_SIZE,), group=_HIDDEN_GROUP)
        found.append((name, xml.compose_poses(IDENTITY_POSE if body is None else body.pose, pose)))
    return found[0], found[1]
