"""Articulations against the plan: links as bodies, joints, and what is the whole's.

Tendons, which bind joints that mimic others, SAPIEN lets nobody read.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.articulation_builder import engine_order, joint_rows
from scenecc.backends.sapien.audit.bodies import look_at_all
from scenecc.backends.sapien.audit.difference import plain, shown
from scenecc.backends.sapien.audit.kinematics import mass_reach
from scenecc.backends.sapien.audit.sweep import Place
from scenecc.backends.sapien.columns import plain_row
from scenecc.backends.sapien.joints import FORCE_LIMIT, JOINT_KNOBS, NO_LIMITS
from scenecc.backends.sapien.knobs import ARTICULATION_KNOBS, ROOT_KNOBS
from scenecc.backends.sapien.turn import Part
from scenecc.geometry.rotations import IDENTITY_POSE

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.body import BodyAudit
    from scenecc.backends.sapien.audit.defaults import Defaults
    from scenecc.backends.sapien.audit.meshes import Meshes
    from scenecc.backends.sapien.audit.sweep import Expected, Sweep
    from scenecc.backends.sapien.turn import ArticulationTurn
    from scenecc.plan import ArticulationStructure, Joint, Value

_IDENTITY = np.array(IDENTITY_POSE)

_OF_EVERY_AXIS = ("armature", "drive_target", "drive_velocity_target")
"""What SAPIEN gives back as an array."""


JOINT_TOLERANCE = 1e-5
"""Between a joint's frame and what the engine gives back of it: it keeps the frame from the links' centres of mass."""


class ArticulationAudit:
    """Looks at articulations; what differs is in the sweep afterwards."""

    def __init__(self, bodies: BodyAudit, defaults: Defaults, meshes: Meshes, sweep: Sweep) -> None:
        self._bodies = bodies
        self._defaults = defaults
        self._meshes = meshes
        self._sweep = sweep

    def look_at(self, turn: ArticulationTurn, *, every: bool) -> None:
        """One a structure closely, or every one; of the others shape counts and masses of links, and qpos."""
        for part in turn.parts:
            closely = part.numbers if every else part.numbers[:1]
            for number in closely.tolist():
                self._articulation(turn, part.structure, number)
            if len(closely) == len(part.numbers):
                continue
            self._qpos(turn, part)
            for which, link in enumerate(part.structure.links):
                own = Part(link.body, part.numbers, part.rows)
                components: list[Any] = [turn.links[number][which] for number in part.numbers]
                look_at_all(turn, own, components, self._meshes, self._sweep, link=link.name)

    def _articulation(self, turn: ArticulationTurn, structure: ArticulationStructure, number: int) -> None:
        row, made = int(turn.rows[number]), turn.objs[number]
        place = Place(turn, number, structure.origin)
        found: list[Any] = turn.links[number]
        if sorted(link.get_index() for link in found) != list(range(len(structure.links))):
            self._sweep.tell(place, "links", len(structure.links), len(made.get_links()))
            return
        for which in range(len(found)):
            self._link(turn, structure, which, number)
        self._sweep.hold("articulation.name", turn.entity.name, made, place)
        self._sweep.hold("articulation.dof", len(structure.active_joints), made, place)
        own = {knob.get: plain_row(value, row) for knob, value in ARTICULATION_KNOBS.said(structure)}
        self._sweep.expect_but(self._defaults.articulation, own, made, place)
        for field, knob in ROOT_KNOBS.by_field.items():
            value: Value | None = getattr(structure, field)
            self._sweep.hold(knob.get, np.zeros(3) if value is None else value.row(row), made, place)
        order = engine_order(structure, found)
        for field in ("qpos", "qvel"):
            wanted = joint_rows(structure, field, turn.rows[number : number + 1], order)[0]
            if (actual := getattr(made, field)).tobytes() != wanted.tobytes():
                self._sweep.tell(place, field, wanted.tolist(), actual.tolist())

    def _qpos(self, turn: ArticulationTurn, part: Part[ArticulationStructure]) -> None:
        order = engine_order(part.structure, turn.links[int(part.numbers[0])])
        wanted = np.broadcast_to(joint_rows(part.structure, "qpos", part.rows, order), (len(part.rows), len(order)))
        found = np.array([turn.objs[number].get_qpos() for number in part.numbers], np.float32).reshape(wanted.shape)
        for i in np.flatnonzero((found != wanted).any(axis=1)).tolist():
            place = Place(turn, int(part.numbers[i]), part.structure.origin)
            self._sweep.tell(place, "qpos", wanted[i].tolist(), found[i].tolist())

    def _link(self, turn: ArticulationTurn, structure: ArticulationStructure, which: int, number: int) -> None:
        link, row = structure.links[which], int(turn.rows[number])
        place = Place(turn, number, link.body.origin, link.name)
        self._bodies.components(link.name, link.body, turn.entities[number][which].components, row, place)
        joint = turn.links[number][which].get_joint()
        if link.joint is None:
            self._sweep.hold("root joint.type", "fixed" if structure.fix_root_link else "undefined", joint, place)
        else:
            where = place._replace(origin=link.joint.origin or place.origin)
            links = turn.links[number]
            ends = [links[which]] if link.parent is None else [links[which], links[link.parent]]
            self._joint(link.joint, joint, row, where, JOINT_TOLERANCE * mass_reach(ends))

    def _joint(self, joint: Joint, found: Any, row: int, place: Place, tolerance: float) -> None:
        hold = self._sweep.hold
        hold("joint.name", joint.name, found, place)
        hold("joint.type", joint.type, found, place)
        for field in ("pose_in_parent", "pose_in_child"):
            pose: Value | None = getattr(joint, field)
            wanted, actual = _IDENTITY if pose is None else pose.row(row), getattr(found, field)
            if _apart(wanted, actual) > tolerance:
                self._sweep.tell(place, field, shown(wanted), shown(actual))
        if joint.type == "fixed":
            return
        limits = NO_LIMITS if joint.limits is None else joint.limits.row(row)
        hold("limits", np.array(limits)[None], found, place)
        for field, nothing_said in (("stiffness", 0.0), ("damping", 0.0), ("force_limit", FORCE_LIMIT)):
            value: Value | None = getattr(joint, field)
            hold(f"joint.{field}", nothing_said if value is None else float(value.row(row)), found, place)
        hold("drive_mode", joint.drive_mode or "force", found, place)
        self._sweep.expect_but(self._defaults.joint, _said(joint, row), found, place)


def _said(joint: Joint, row: int) -> Expected:
    own = {knob.get: plain_row(value, row) for knob, value in JOINT_KNOBS.said(joint)}
    return {name: [value] if name in _OF_EVERY_AXIS else value for name, value in own.items()}


def _apart(wanted: NDArray[np.float64], found: Any) -> float:
    actual = plain(found)
    unit = wanted[3:] / np.linalg.norm(wanted[3:])
    rotation = min(np.abs(unit - actual[3:]).max(), np.abs(unit + actual[3:]).max())
    return float(max(np.abs(wanted[:3] - actual[:3]).max() / max(1.0, np.abs(wanted[:3]).max()), rotation))
