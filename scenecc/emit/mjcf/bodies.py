"""Writes MuJoCo bodies, joints, actuators, and the equalities, tendons and contact exclusions between them."""

from __future__ import annotations

import math
from itertools import combinations, product
from typing import TYPE_CHECKING

from scenecc.emit.mjcf.model import (
    InitialState,
    MjcfModel,
    ModelBody,
    pose_attributes,
    write_collision_geoms,
    write_visual_geoms,
)
from scenecc.emit.output import (
    MAX_LIMIT,
    UNLIMITED,
    XmlElement,
    format_number,
    friction_loss,
    is_pure_damping,
    optional_fields,
    pose_in_row,
    transform_direction,
)
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3, compose, invert, relative_pose
from scenecc.plan import ArticulationStructure, BodyStructure, Connection, Distance, Drive, Gear, Weld
from scenecc.plan.articulation import VELOCITY_FIELDS
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from scenecc.plan import Constraint, Value
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredJoint, MeasuredMass

_UNSUPPORTED_JOINT_FIELDS = tuple(name for name in property_fields("joint") if name not in {"friction", "armature"})


def write_joint(model: MjcfModel, measured: MeasuredEntity, number: int, element: XmlElement) -> None:
    """Writes the joint between link `number` and its parent; nothing for a fixed joint."""
    body = measured.bodies[number]
    joint = body.joint
    if joint is None or joint.type == "fixed":
        return
    entity = measured.entity.name
    name = model.name("joint", f"{entity}/{joint.name or body.name}")
    if joint.name:
        model.joints[entity, joint.name] = name
    made = element.add(
        "joint",
        name=name,
        type="slide" if joint.type == "prismatic" else "hinge",
        pos=joint.pose_in_child[:3],
        axis=transform_direction(joint.pose_in_child, (1.0, 0.0, 0.0)),
        ref=joint.qpos or None,
        range=_range(joint),
        armature=joint.armature or None,
        damping=joint.damping if _is_pure_damping(joint) and joint.damping else None,
        frictionloss=friction_loss(joint) or None,
    )
    model.starts[id(made)] = InitialState((joint.qpos,), (joint.qvel,))
    low, high = joint.limits
    if low == high:
        # `range` needs low < high.
        hold = low - joint.qpos
        model.sections["equality"].add("joint", joint1=name, polycoef=(hold, 0, 0, 0, 0))
    _write_drive(model, entity, name, joint)
    _report_joint(model, entity, joint)


def _range(joint: MeasuredJoint) -> tuple[float, float] | None:
    low, high = joint.limits
    if low == high or (math.isinf(low) and math.isinf(high)):
        return None
    return max(low, -UNLIMITED), min(high, UNLIMITED)


def _is_pure_damping(joint: MeasuredJoint) -> bool:
    return is_pure_damping(joint) and joint.force_limit >= MAX_LIMIT


def _write_drive(model: MjcfModel, entity: str, name: str, joint: MeasuredJoint) -> None:
    """Writes an actuator equal to the drive: stiffness · (control - position) - damping · velocity."""
    if _is_pure_damping(joint) or friction_loss(joint) or (joint.stiffness == 0 and joint.damping == 0):
        return
    if joint.drive_mode == "acceleration":
        model.unsupported.leave_out(entity, "the drive of a joint in the mode `acceleration`", joint.joint.origin)
        return
    strength = joint.stiffness or joint.damping
    wanted = joint.stiffness * joint.drive_target + joint.damping * joint.drive_velocity_target
    limit = joint.force_limit
    model.sections["actuator"].add(
        "general",
        name=model.name("actuator", name),
        joint=name,
        gainprm=(strength,),
        biastype="affine",
        biasprm=(0, -joint.stiffness, -joint.damping),
        forcerange=None if limit >= MAX_LIMIT else (-limit, limit),
    )
    model.controls.append(wanted / strength)
    model.is_commanded |= joint.stiffness > 0 and wanted / strength != joint.qpos


def _report_joint(model: MjcfModel, entity: str, joint: MeasuredJoint) -> None:
    unsupported, plan = model.unsupported, joint.joint
    unsupported.fields(entity, plan, _UNSUPPORTED_JOINT_FIELDS, plan.origin, " of a joint")
    if plan.friction is not None and joint.friction:
        unsupported.leave_out(entity, "`friction` of a joint, a ratio; MuJoCo has a force", plan.origin)


def write_mimics(model: MjcfModel, measured: MeasuredEntity, structure: ArticulationStructure) -> None:
    """Writes one equality per mimic joint. In MuJoCo both positions are relative to the initial ones."""
    entity, row = measured.entity.name, measured.row
    starts = {body.joint.name: body.joint.qpos for body in measured.bodies if body.joint is not None}
    for mimic in structure.mimics:
        multiplier, offset = float(mimic.multiplier.row(row)), float(mimic.offset.row(row))
        apart = multiplier * starts[mimic.source] + offset - starts[mimic.joint]
        model.sections["equality"].add(
            "joint",
            joint1=model.joints[entity, mimic.joint],
            joint2=model.joints[entity, mimic.source],
            polycoef=(apart, multiplier, 0, 0, 0),
        )


_UNSUPPORTED_BODY_FIELDS = optional_fields(
    BodyStructure,
    "mass",
    "com",
    "inertial",
    "visibility",
    "disable_gravity",
    "locked_motion_axes",
    *VELOCITY_FIELDS,
    "collision_groups",
    "shapeless",
)

_UNSUPPORTED_ARTICULATION_FIELDS = optional_fields(ArticulationStructure, "file", *VELOCITY_FIELDS)

_AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

_INERTIA_TOLERANCE = 1e-5
"""Relative rounding error by which a flat body's moments may violate the triangle inequality."""


def write_entity_bodies(model: MjcfModel, measured: MeasuredEntity) -> None:
    """Writes a body, or all links of an articulation."""
    entity, structure = measured.entity, measured.structure
    if entity.hidden:
        model.unsupported.leave_out(entity.name, "`hidden`, which hides it from sensors", entity.origin)
    if isinstance(structure, ArticulationStructure):
        _write_articulation(model, measured, structure)
        return
    (body,) = measured.bodies
    element = _start_body(model, measured, body, None)
    if body.body_type == "kinematic":
        element.attributes["mocap"] = "true"
    elif body.body_type == "dynamic":
        _write_free_axes(model, measured, body, element)
    _write_contents(model, measured, model.bodies[entity.name, None])


def _write_articulation(model: MjcfModel, measured: MeasuredEntity, structure: ArticulationStructure) -> None:
    name = measured.entity.name
    model.unsupported.fields(name, structure, _UNSUPPORTED_ARTICULATION_FIELDS, structure.origin)
    written: list[ModelBody] = []
    for number, body in enumerate(measured.bodies):
        parent = None if body.parent is None else written[body.parent]
        element = _start_body(model, measured, body, parent, link=body.name)
        if parent is None and not structure.fix_root_link:
            linear, angular = (_initial_velocity(structure, field, measured.row) for field in VELOCITY_FIELDS)
            _write_free_joint(model, element, name, body, linear, angular)
        elif body.joint is not None:
            write_joint(model, measured, number, element)
        written.append(model.bodies[name, body.name])
        _write_contents(model, measured, written[-1])
    write_mimics(model, measured, structure)


def _start_body(
    model: MjcfModel, measured: MeasuredEntity, body: MeasuredBody, parent: ModelBody | None, link: str | None = None
) -> XmlElement:
    """Adds a body element to its parent's, at its pose."""
    entity = measured.entity.name
    name = model.name("body", entity if link is None else f"{entity}/{link}")
    pose = body.pose if parent is None else relative_pose(parent.pose, body.pose)
    gravity = None if body.body.disable_gravity is None else float(bool(body.body.disable_gravity.row(measured.row)))
    element = (model.world if parent is None else parent.element).add(
        "body",
        name=name,
        **pose_attributes(pose),
        gravcomp=gravity or None,
    )
    is_fixed = _is_fixed(measured, body, parent)
    model.bodies[entity, link] = ModelBody(name, element, body.pose, body, is_fixed)
    return element


def _is_fixed(measured: MeasuredEntity, body: MeasuredBody, parent: ModelBody | None) -> bool:
    if isinstance(measured.structure, ArticulationStructure):
        if parent is None:
            return measured.structure.fix_root_link
        return parent.is_fixed and body.joint is not None and body.joint.type == "fixed"
    return body.body_type != "dynamic"


def _write_contents(model: MjcfModel, measured: MeasuredEntity, written: ModelBody) -> None:
    """Writes mass and shapes, and reports what MuJoCo does not support."""
    name, body, element = measured.entity.name, written.measured, written.element
    if body.mass is not None:
        _write_mass(model, name, body, body.mass, element)
    write_collision_geoms(model, name, body, element)
    write_visual_geoms(model, name, measured.row, body.body, element, is_fixed=written.is_fixed)
    model.unsupported.fields(name, body.body, _UNSUPPORTED_BODY_FIELDS, body.body.origin)


def _write_mass(model: MjcfModel, name: str, body: MeasuredBody, mass: MeasuredMass, element: XmlElement) -> None:
    inertia = tuple(float(format_number(each)) for each in mass.inertia)  # as MuJoCo reads them
    low, middle, high = sorted(inertia)
    if high > low + middle:
        # MuJoCo rejects moments that violate the triangle inequality; for a flat body, rounding alone may do that.
        inertia = tuple(min(each, low + middle) for each in inertia)
        if high > (1 + _INERTIA_TOLERANCE) * (low + middle):
            words = "its largest moment of inertia is lowered to the sum of the other two, the physical limit"
            model.unsupported.change(name, words, body.body.origin)
    element.add("inertial", pos=mass.com[:3], quat=mass.com[3:], mass=mass.mass, diaginertia=inertia)


def _write_free_axes(model: MjcfModel, measured: MeasuredEntity, body: MeasuredBody, element: XmlElement) -> None:
    """Writes joints of a dynamic body: a free joint, or one joint per world axis that is not locked."""
    structure, row, name = body.body, measured.row, measured.entity.name
    linear, angular = (_initial_velocity(structure, field, row) for field in VELOCITY_FIELDS)
    value = structure.locked_motion_axes
    locked = [False] * 6 if value is None else [bool(each) for each in value.row(row)]
    if not any(locked) or sum(locked[3:]) == 1:
        if any(locked):
            model.unsupported.leave_out(name, "`locked_axes` that leave two axes of rotation", structure.origin)
        _write_free_joint(model, element, name, body, linear, angular)
        return
    back = invert(body.pose)
    for axis, word, speed, is_locked in zip(_AXES, "xyz", linear, locked[:3], strict=True):
        if not is_locked:
            made = element.add(
                "joint",
                name=model.name("joint", f"{name}/{word}"),
                type="slide",
                axis=transform_direction(back, axis),
            )
            model.starts[id(made)] = InitialState((0.0,), (speed,))
    if not any(locked[3:]):
        made = element.add("joint", name=model.name("joint", f"{name}/turn"), type="ball", pos=_center_of_mass(body))
        model.starts[id(made)] = InitialState((1.0, 0.0, 0.0, 0.0), transform_direction(back, angular))
    for axis, word, speed, is_locked in zip(_AXES, "xyz", angular, locked[3:], strict=True):
        if not is_locked and any(locked[3:]):
            about = {"type": "hinge", "axis": transform_direction(back, axis), "pos": _center_of_mass(body)}
            made = element.add("joint", name=model.name("joint", f"{name}/r{word}"), **about)
            model.starts[id(made)] = InitialState((0.0,), (speed,))


def _center_of_mass(body: MeasuredBody) -> Vec3:
    """Returns the centre of mass in the body's frame [m]."""
    return (0.0, 0.0, 0.0) if body.mass is None else body.mass.com[:3]


def _initial_velocity(structure: BodyStructure | ArticulationStructure, field: str, row: int) -> Vec3:
    value = getattr(structure, field)
    x, y, z = (0.0, 0.0, 0.0) if value is None else map(float, value.row(row))
    return x, y, z


def _write_free_joint(
    model: MjcfModel,
    element: XmlElement,
    name: str,
    body: MeasuredBody,
    linear: tuple[float, ...],
    angular: tuple[float, ...],
) -> None:
    made = element.add("freejoint", name=model.name("joint", name))
    x, y, z = angular
    # MuJoCo stores the velocity of the body's origin, PhysX that of its centre of mass; MuJoCo's angular velocity is in
    # the body's frame.
    about = transform_direction(body.pose, _center_of_mass(body))
    a, b, c = about
    swept = (y * c - z * b, z * a - x * c, x * b - y * a)
    origin = tuple(speed - part for speed, part in zip(linear, swept, strict=True))
    turning = transform_direction(invert(body.pose), (x, y, z))
    model.starts[id(made)] = InitialState(body.pose, (*origin, *turning))


_GROUP_ID_MASK = 0xFFFF
"""Bits of the fourth integer. The third one applies between shapes that share these."""


def write_contact_exclusions(model: MjcfModel) -> None:
    """Excludes contacts between child and parent links, constrained bodies, and bodies that ignore each other by bits.

    MuJoCo itself excludes a body and its parent, unless the parent is fixed to the world.
    """
    found: dict[tuple[str, str], None] = {}
    for (entity, _), body in model.bodies.items():
        parent = body.measured.parent
        if parent is not None and not body.is_fixed:
            above = [each for (name, _), each in model.bodies.items() if name == entity][parent]
            if above.is_fixed and above.measured.shapes and body.measured.shapes:
                found[above.name, body.name] = None
    for constraint in model.plan.constraints:
        if constraint.parent is not None and not constraint.collide and model.scene.index in constraint.scene_idxs:
            a, b = (model.bodies[model.key(mount)].name for mount in (constraint.parent, constraint.child))
            found[a, b] = None
    groups = {id(body): {shape.groups for shape in body.measured.shapes} for body in model.bodies.values()}
    ignoring = [body for body in model.bodies.values() if any(each[2] for each in groups[id(body)])]
    for a, b in combinations(ignoring, 2):
        if (a.is_fixed and b.is_fixed) or {(a.name, b.name), (b.name, a.name)} & found.keys():
            continue
        meeting = [pair for pair in product(groups[id(a)], groups[id(b)]) if _collide(*pair)]
        ignored = sum(_ignore_each_other(*pair) for pair in meeting)
        if ignored and ignored < len(meeting):
            words = f"some of its shapes ignore some of `{b.name}` by the third of `collision_bits`, but all collide"
            model.unsupported.change(a.name, words, a.measured.body.origin)
        elif ignored:
            found[a.name, b.name] = None
    for a, b in found:
        model.sections["contact"].add("exclude", body1=a, body2=b)


Groups = tuple[int, int, int, int]


def _collide(a: Groups, b: Groups) -> bool:
    return bool(a[0] & b[1] or a[1] & b[0])


def _ignore_each_other(a: Groups, b: Groups) -> bool:
    return bool(a[2] & b[2]) and a[3] & _GROUP_ID_MASK == b[3] & _GROUP_ID_MASK


_SITE_SIZE = 0.005
"""Displayed size of a site [m]."""

_HIDDEN_GROUP = 5
"""A group that MuJoCo's viewer hides by default."""

_LINEAR_AXES = ("x", "y", "z")


def write_constraints(model: MjcfModel) -> None:
    """Writes all constraints of the scene."""
    for constraint in model.plan.constraints:
        if model.scene.index in constraint.scene_idxs:
            _write_constraint(model, constraint, constraint.scene_idxs.index(model.scene.index))


def _write_constraint(model: MjcfModel, constraint: Constraint, row: int) -> None:
    name, joint = constraint.name, constraint.joint
    if isinstance(joint, Distance) and not _is_enabled(constraint, row):
        model.unsupported.leave_out(name, "a disabled distance constraint", constraint.origin)
        return
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
    active = None if _is_enabled(constraint, row) else False
    model.sections["equality"].add(kind, name=name, site1=parent[0], site2=child[0], active=active)


def _is_enabled(constraint: Constraint, row: int) -> bool:
    return constraint.enabled is None or bool(constraint.enabled.row(row))


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
        # `range` needs low < high; an equality counts from the initial length.
        now = math.dist(at[:3], there[:3])
        model.sections["equality"].add("tendon", tendon1=name, polycoef=(low - now, 0, 0, 0, 0))


def _number_in_row(value: Value | None, row: int) -> float:
    return 0.0 if value is None else float(value.row(row))


def _write_sites(model: MjcfModel, constraint: Constraint, row: int) -> tuple[tuple[str, Pose7], tuple[str, Pose7]]:
    """Adds sites at the frames of a constraint, and returns name and world pose of the parent's and the child's."""
    found: list[tuple[str, Pose7]] = []
    for word, mount, frame in (
        ("parent", constraint.parent, constraint.pose_in_parent),
        ("child", constraint.child, constraint.pose_in_child),
    ):
        pose = pose_in_row(frame, row)
        body = None if mount is None else model.bodies[model.key(mount)]
        name = model.name("site", f"{constraint.name}/{word}")
        element = model.world if body is None else body.element
        element.add("site", name=name, **pose_attributes(pose), size=(_SITE_SIZE,), group=_HIDDEN_GROUP)
        found.append((name, compose(IDENTITY_POSE if body is None else body.pose, pose)))
    return found[0], found[1]
