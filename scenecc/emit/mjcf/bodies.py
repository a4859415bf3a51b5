"""Bodies: a free one, one that is moved by its pose, one that stands; and the links of articulations."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.emit.mjcf.joints import write_joint
from scenecc.emit.mjcf.mimics import write_mimics
from scenecc.emit.mjcf.model import Start, Written
from scenecc.emit.mjcf.shapes import write_collisions, write_visuals
from scenecc.emit.xml import elements, frames
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.plan import ArticulationStructure

if TYPE_CHECKING:
    from scenecc.emit.mjcf.model import Model
    from scenecc.emit.xml.elements import Element
    from scenecc.plan import BodyStructure
    from scenecc.plan.snapshot import MeasuredBody, MeasuredEntity, MeasuredMass, Vec3

_OF_A_BODY = (
    "linear_damping",
    "angular_damping",
    "max_linear_velocity",
    "max_angular_velocity",
    "max_depenetration_velocity",
    "max_contact_impulse",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
    "shading_mode",
)
_OF_AN_ARTICULATION = ("solver_position_iterations", "solver_velocity_iterations", "sleep_threshold")

_AXES: tuple[Vec3, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_BY_ROUNDING = 1e-5
"""How far moments of a body that is flat may miss those that a body can have, by a rounding."""


def write_entity(model: Model, measured: MeasuredEntity) -> None:
    """Writes a body, or all links of an articulation."""
    entity, structure = measured.entity, measured.structure
    if entity.hidden:
        model.lost.leave_out(entity.name, "that only people see it", entity.origin)
    if isinstance(structure, ArticulationStructure):
        _write_articulation(model, measured, structure)
        return
    (body,) = measured.bodies
    element = _start_body(model, measured, body, None)
    if body.body_type == "kinematic":
        element.attributes["mocap"] = "true"
    elif body.body_type == "dynamic":
        _write_freedom(model, measured, body, element)
    _fill(model, measured, model.bodies[entity.name, None])


def _write_articulation(model: Model, measured: MeasuredEntity, structure: ArticulationStructure) -> None:
    name = measured.entity.name
    model.lost.fields(name, structure, _OF_AN_ARTICULATION, structure.origin)
    written: list[Written] = []
    for number, body in enumerate(measured.bodies):
        parent = None if body.parent is None else written[body.parent]
        element = _start_body(model, measured, body, parent, link=body.name)
        if parent is None and not structure.fix_root_link:
            row = measured.row
            speeds = (structure.linear_velocity, structure.angular_velocity)
            linear, angular = ((0.0,) * 3 if value is None else tuple(value.row(row).tolist()) for value in speeds)
            _write_free_joint(model, element, name, body, linear, angular)
        elif body.joint is not None:
            write_joint(model, measured, number, element)
        written.append(model.bodies[name, body.name])
        _fill(model, measured, written[-1])
    write_mimics(model, measured, structure)


def _start_body(
    model: Model, measured: MeasuredEntity, body: MeasuredBody, parent: Written | None, link: str | None = None
) -> Element:
    """A new body in the one that it hangs on, at its place."""
    entity = measured.entity.name
    name = model.name("body", entity if link is None else f"{entity}/{link}")
    pose = body.pose if parent is None else frames.between(parent.pose, body.pose)
    gravity = None if body.body.disable_gravity is None else float(bool(body.body.disable_gravity.row(measured.row)))
    element = (model.world if parent is None else parent.element).add(
        "body",
        name=name,
        pos=None if pose[:3] == IDENTITY_POSE[:3] else pose[:3],
        quat=None if pose[3:] == IDENTITY_POSE[3:] else pose[3:],
        gravcomp=gravity or None,
    )
    held = _is_held(measured, body, parent)
    model.bodies[entity, link] = Written(name, element, body.pose, body, held)
    return element


def _is_held(measured: MeasuredEntity, body: MeasuredBody, parent: Written | None) -> bool:
    if isinstance(measured.structure, ArticulationStructure):
        if parent is None:
            return measured.structure.fix_root_link
        return parent.held and body.joint is not None and body.joint.type == "fixed"
    return body.body_type != "dynamic"


def _fill(model: Model, measured: MeasuredEntity, written: Written) -> None:
    """Its mass and its shapes, and what of it MuJoCo has not."""
    name, body, element = measured.entity.name, written.measured, written.element
    if body.mass is not None:
        _write_mass(model, name, body, body.mass, element)
    write_collisions(model, name, body, element)
    write_visuals(model, name, measured.row, body.body, element, held=written.held)
    model.lost.fields(name, body.body, _OF_A_BODY, body.body.origin)


def _write_mass(model: Model, name: str, body: MeasuredBody, mass: MeasuredMass, element: Element) -> None:
    inertia = tuple(float(elements.number(each)) for each in mass.inertia)  # as MuJoCo reads them
    low, middle, high = sorted(inertia)
    if high > low + middle:
        # MuJoCo refuses what no body can have; a flat one is at the edge of that, and a rounding brings it over.
        inertia = tuple(min(each, low + middle) for each in inertia)
        if high > (1 + _BY_ROUNDING) * (low + middle):
            words = "its largest moment of inertia is lowered to the sum of the others, above which no body has one"
            model.lost.change(name, words, body.body.origin)
    element.add("inertial", pos=mass.com[:3], quat=mass.com[3:], mass=mass.mass, diaginertia=inertia)


def _write_freedom(model: Model, measured: MeasuredEntity, body: MeasuredBody, element: Element) -> None:
    """How a dynamic body moves: freely, or along and about those of the world's axes that are not locked."""
    structure, row, name = body.body, measured.row, measured.entity.name
    linear, angular = (_speed(structure, field, row) for field in ("linear_velocity", "angular_velocity"))
    value = structure.locked_motion_axes
    locked = [False] * 6 if value is None else [bool(each) for each in value.row(row)]
    if not any(locked) or sum(locked[3:]) == 1:
        if any(locked):
            model.lost.leave_out(name, "`locked_axes` that leave two axes to turn about", structure.origin)
        _write_free_joint(model, element, name, body, linear, angular)
        return
    back = frames.inverse(body.pose)
    for axis, word, speed, is_locked in zip(_AXES, "xyz", linear, locked[:3], strict=True):
        if not is_locked:
            made = element.add(
                "joint", name=model.name("joint", f"{name}/{word}"), type="slide", axis=frames.turn(back, axis)
            )
            model.starts[id(made)] = Start((0.0,), (speed,))
    if not any(locked[3:]):
        made = element.add("joint", name=model.name("joint", f"{name}/turn"), type="ball", pos=_middle(body))
        model.starts[id(made)] = Start((1.0, 0.0, 0.0, 0.0), frames.turn(back, angular))
    for axis, word, speed, is_locked in zip(_AXES, "xyz", angular, locked[3:], strict=True):
        if not is_locked and any(locked[3:]):
            about = {"type": "hinge", "axis": frames.turn(back, axis), "pos": _middle(body)}
            made = element.add("joint", name=model.name("joint", f"{name}/r{word}"), **about)
            model.starts[id(made)] = Start((0.0,), (speed,))


def _middle(body: MeasuredBody) -> Vec3:
    """Where a body turns about: its centre of mass."""
    return (0.0, 0.0, 0.0) if body.mass is None else body.mass.com[:3]


def _speed(structure: BodyStructure, field: str, row: int) -> Vec3:
    value = getattr(structure, field)
    x, y, z = (0.0, 0.0, 0.0) if value is None else map(float, value.row(row))
    return x, y, z


def _write_free_joint(
    model: Model, element: Element, name: str, body: MeasuredBody, linear: tuple[float, ...], angular: tuple[float, ...]
) -> None:
    made = element.add("freejoint", name=model.name("joint", name))
    x, y, z = angular
    # MuJoCo has the velocity of the body's origin, PhysX that of its centre of mass; a turn is in the body's frame.
    about = frames.turn(body.pose, _middle(body))
    a, b, c = about
    swept = (y * c - z * b, z * a - x * c, x * b - y * a)
    origin = tuple(speed - part for speed, part in zip(linear, swept, strict=True))
    turning = frames.turn(frames.inverse(body.pose), (x, y, z))
    model.starts[id(made)] = Start(body.pose, (*origin, *turning))
