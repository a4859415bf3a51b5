"""Writes MuJoCo bodies, joints, actuators and the equalities of mimic joints."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from scenecc.emit import xml
from scenecc.emit.mjcf.model import InitialState, ModelBody, pose_attributes, write_collisions, write_visuals
from scenecc.emit.unsupported import unsupported_fields
from scenecc.emit.xml import MAX_LIMIT, UNLIMITED
from scenecc.plan import ArticulationStructure, BodyStructure
from scenecc.plan.articulation import VELOCITY_FIELDS
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import MjcfModel
    from scenecc.emit.xml import XmlElement
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredJoint, MeasuredMass, Vec3


def write_joint(model: MjcfModel, measured: MeasuredEntity, number: int, element: XmlElement) -> None:
    """The joint by which link `number` hangs on its parent; nothing for a fixed one."""
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
        axis=xml.transform_direction(joint.pose_in_child, (1.0, 0.0, 0.0)),
        ref=joint.qpos or None,
        range=_range(joint),
        armature=joint.armature or None,
        damping=joint.damping if _is_pure_damping(joint) and joint.damping else None,
        frictionloss=None if joint.joint.friction is None else joint.friction or None,
    )
    model.starts[id(made)] = InitialState((joint.qpos,), (joint.qvel,))
    low, high = joint.limits
    if low == high:
        # A range has two ends.
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
    return xml.is_pure_damping(joint) and joint.force_limit >= MAX_LIMIT


def _write_drive(model: MjcfModel, entity: str, name: str, joint: MeasuredJoint) -> None:
    """An actuator that pulls as the drive does: stiffness · (control - position) - damping · velocity."""
    if _is_pure_damping(joint) or (joint.stiffness == 0 and joint.damping == 0):
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


def _report_joint(model: MjcfModel, entity: str, joint: MeasuredJoint) -> None:
    unsupported, plan = model.unsupported, joint.joint
    unsupported.fields(entity, plan, _UNSUPPORTED_JOINT_FIELDS, plan.origin, " of a joint")
    if plan.friction is not None and joint.friction:
        words = "`friction` of a joint is written as `frictionloss`, a force; PhysX's grows with the joint's load"
        unsupported.change(entity, words, plan.origin)


def write_mimics(model: MjcfModel, measured: MeasuredEntity, structure: ArticulationStructure) -> None:
    """An equality a mimic: MuJoCo counts both positions from where the model starts."""
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


_UNSUPPORTED_JOINT_FIELDS = tuple(name for name in property_fields("joint") if name not in {"friction", "armature"})

_UNSUPPORTED_BODY_FIELDS = unsupported_fields(
    BodyStructure,
    "mass",
    "inertial",
    "visibility",
    "disable_gravity",
    "locked_motion_axes",
    *VELOCITY_FIELDS,
    "collision_groups",
)

_UNSUPPORTED_ARTICULATION_FIELDS = unsupported_fields(ArticulationStructure, "file", *VELOCITY_FIELDS)

_AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

_INERTIA_TOLERANCE = 1e-5
"""How far moments of a body that is flat may miss those that a body can have, by a rounding."""


def write_entity(model: MjcfModel, measured: MeasuredEntity) -> None:
    """Writes a body, or all links of an articulation."""
    entity, structure = measured.entity, measured.structure
    if entity.hidden:
        model.unsupported.leave_out(entity.name, "that only people see it", entity.origin)
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
    """A new body in the one that it hangs on, at its place."""
    entity = measured.entity.name
    name = model.name("body", entity if link is None else f"{entity}/{link}")
    pose = body.pose if parent is None else xml.relative_pose(parent.pose, body.pose)
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
    """Its mass and its shapes, and what of it MuJoCo has not."""
    name, body, element = measured.entity.name, written.measured, written.element
    if body.mass is not None:
        _write_mass(model, name, body, body.mass, element)
    write_collisions(model, name, body, element)
    write_visuals(model, name, measured.row, body.body, element, is_fixed=written.is_fixed)
    model.unsupported.fields(name, body.body, _UNSUPPORTED_BODY_FIELDS, body.body.origin)


def _write_mass(model: MjcfModel, name: str, body: MeasuredBody, mass: MeasuredMass, element: XmlElement) -> None:
    inertia = tuple(float(xml.format_number(each)) for each in mass.inertia)  # as MuJoCo reads them
    low, middle, high = sorted(inertia)
    if high > low + middle:
        # MuJoCo refuses what no body can have; a flat one is at the edge of that, and a rounding brings it over.
        inertia = tuple(min(each, low + middle) for each in inertia)
        if high > (1 + _INERTIA_TOLERANCE) * (low + middle):
            words = "its largest moment of inertia is lowered to the sum of the others, above which no body has one"
            model.unsupported.change(name, words, body.body.origin)
    element.add("inertial", pos=mass.com[:3], quat=mass.com[3:], mass=mass.mass, diaginertia=inertia)


def _write_free_axes(model: MjcfModel, measured: MeasuredEntity, body: MeasuredBody, element: XmlElement) -> None:
    """How a dynamic body moves: freely, or along and about those of the world's axes that are not locked."""
    structure, row, name = body.body, measured.row, measured.entity.name
    linear, angular = (_initial_velocity(structure, field, row) for field in VELOCITY_FIELDS)
    value = structure.locked_motion_axes
    locked = [False] * 6 if value is None else [bool(each) for each in value.row(row)]
    if not any(locked) or sum(locked[3:]) == 1:
        if any(locked):
            model.unsupported.leave_out(name, "`locked_axes` that leave two axes to turn about", structure.origin)
        _write_free_joint(model, element, name, body, linear, angular)
        return
    back = xml.invert_pose(body.pose)
    for axis, word, speed, is_locked in zip(_AXES, "xyz", linear, locked[:3], strict=True):
        if not is_locked:
            made = element.add(
                "joint",
                name=model.name("joint", f"{name}/{word}"),
                type="slide",
                axis=xml.transform_direction(back, axis),
            )
            model.starts[id(made)] = InitialState((0.0,), (speed,))
    if not any(locked[3:]):
        made = element.add("joint", name=model.name("joint", f"{name}/turn"), type="ball", pos=_center_of_mass(body))
        model.starts[id(made)] = InitialState((1.0, 0.0, 0.0, 0.0), xml.transform_direction(back, angular))
    for axis, word, speed, is_locked in zip(_AXES, "xyz", angular, locked[3:], strict=True):
        if not is_locked and any(locked[3:]):
            about = {"type": "hinge", "axis": xml.transform_direction(back, axis), "pos": _center_of_mass(body)}
            made = element.add("joint", name=model.name("joint", f"{name}/r{word}"), **about)
            model.starts[id(made)] = InitialState((0.0,), (speed,))


def _center_of_mass(body: MeasuredBody) -> Vec3:
    """Where a body turns about: its centre of mass."""
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
    # MuJoCo has the velocity of the body's origin, PhysX that of its centre of mass; a turn is in the body's frame.
    about = xml.transform_direction(body.pose, _center_of_mass(body))
    a, b, c = about
    swept = (y * c - z * b, z * a - x * c, x * b - y * a)
    origin = tuple(speed - part for speed, part in zip(linear, swept, strict=True))
    turning = xml.transform_direction(xml.invert_pose(body.pose), (x, y, z))
    model.starts[id(made)] = InitialState(body.pose, (*origin, *turning))
