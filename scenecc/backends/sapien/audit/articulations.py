"""Audit of articulations: links, joints, and the poses of links by forward kinematics of the plan."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.backends.sapien.articulation_builder import engine_joint_order, joint_rows
from scenecc.backends.sapien.audit.bodies import compare_bodies
from scenecc.backends.sapien.audit.comparison import BodyLocation, format_value, to_engine_array
from scenecc.backends.sapien.preparation import StructureRows
from scenecc.backends.sapien.properties import (
    ARTICULATION_PROPERTIES,
    DRIVE_DEFAULTS,
    JOINT_FRAMES,
    JOINT_LIMITS,
    JOINT_PROPERTIES,
    ROOT_PROPERTIES,
    row_value,
    select_rows,
)
from scenecc.geometry.rotation_arrays import compose, invert
from scenecc.geometry.rotations import IDENTITY_POSE

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    from scenecc.backends.sapien.audit.bodies import BodyAudit
    from scenecc.backends.sapien.audit.comparison import BatchComparison, ExpectedProperties
    from scenecc.backends.sapien.audit.reference import EngineDefaults, ReferenceMeshes
    from scenecc.backends.sapien.preparation import PreparedArticulation
    from scenecc.geometry.rotation_arrays import Floats
    from scenecc.plan import ArticulationStructure, Entity, Joint, Value


def center_of_mass_reach(links: Iterable[Any]) -> float:
    """How far from links of the engine their centres of mass are at the most [m]; 1 at the least.

    The engine goes by centres of mass, and knows by as much less where links and joints are.
    """
    return max([1.0, *(float(np.abs(link.cmass_local_pose.p).max()) for link in links)])


def link_poses(entity: Entity, structure: ArticulationStructure, rows: NDArray[np.intp]) -> list[NDArray[np.float32]]:
    """(B, 7) of each link in the world of its scene, in the order of the plan."""
    found: list[Floats] = []
    for link in structure.links:
        if link.parent is None or link.joint is None:
            found.append(_normalize(np.broadcast_to(select_rows(entity.pose, rows), (len(rows), 7))))
            continue
        in_parent = compose(_frame_rows(link.joint.pose_in_parent, rows), _joint_motions(link.joint, rows))
        step = compose(in_parent, invert(_frame_rows(link.joint.pose_in_child, rows)))
        found.append(compose(found[link.parent], step))
    return [poses.astype(np.float32) for poses in found]


def _joint_motions(joint: Joint, rows: NDArray[np.intp]) -> Floats:
    """How far the joint's frames are apart."""
    moved = _identity_poses(len(rows))
    if joint.type != "fixed" and joint.qpos is not None:
        qpos = np.broadcast_to(select_rows(joint.qpos, rows), len(rows))
        if joint.type == "prismatic":
            moved[:, 0] = qpos
        else:
            moved[:, 3], moved[:, 4] = np.cos(qpos / 2), np.sin(qpos / 2)
    return moved


def _frame_rows(pose: Value | None, rows: NDArray[np.intp]) -> Floats:
    if pose is None:
        return _identity_poses(len(rows))
    return _normalize(np.broadcast_to(select_rows(pose, rows), (len(rows), 7)))


def _identity_poses(count: int) -> Floats:
    return np.tile(IDENTITY_POSE, (count, 1))


def _normalize(poses: Floats) -> Floats:
    """With quaternions of unit length, as the engine has them."""
    found = poses.copy()
    found[:, 3:] /= np.linalg.norm(found[:, 3:], axis=1, keepdims=True)
    return found


_IDENTITY = np.array(IDENTITY_POSE)

_AXIS_FIELDS = ("armature", "drive_target", "drive_velocity_target")
"""What SAPIEN gives back as an array."""

JOINT_TOLERANCE = 1e-5
"""Between a joint's frame and what the engine gives back of it: it keeps the frame from the links' centres of mass."""


class ArticulationAudit:
    """Reads articulations; differences go to the comparison."""

    def __init__(
        self, bodies: BodyAudit, defaults: EngineDefaults, meshes: ReferenceMeshes, comparison: BatchComparison
    ) -> None:
        self._bodies = bodies
        self._defaults = defaults
        self._meshes = meshes
        self._comparison = comparison

    def look_at(self, prepared: PreparedArticulation, *, every: bool) -> None:
        """One a structure closely, or every one; of the others shape counts and masses of links, and qpos."""
        for part in prepared.parts:
            closely = part.numbers if every else part.numbers[:1]
            for number in closely.tolist():
                self._articulation(prepared, part.structure, number)
            if len(closely) == len(part.numbers):
                continue
            self._qpos(prepared, part)
            for which, link in enumerate(part.structure.links):
                own = StructureRows(link.body, part.numbers, part.rows)
                components: list[Any] = [prepared.links[number][which] for number in part.numbers]
                compare_bodies(prepared, own, components, self._meshes, self._comparison, link=link.name)

    def _articulation(self, prepared: PreparedArticulation, structure: ArticulationStructure, number: int) -> None:
        row, made = int(prepared.rows[number]), prepared.objs[number]
        place = BodyLocation(prepared, number, structure.origin)
        found: list[Any] = prepared.links[number]
        if sorted(link.get_index() for link in found) != list(range(len(structure.links))):
            self._comparison.tell(place, "links", len(structure.links), len(made.get_links()))
            return
        for which in range(len(found)):
            self._link(prepared, structure, which, number)
        self._comparison.hold("articulation.name", prepared.entity.name, made, place)
        self._comparison.hold("articulation.dof", len(structure.active_joints), made, place)
        own = {prop.get: row_value(value, row) for prop, value in ARTICULATION_PROPERTIES.said(structure)}
        self._comparison.expect_but(self._defaults.articulation, own, made, place)
        for field, prop in ROOT_PROPERTIES.by_field.items():
            value: Value | None = getattr(structure, field)
            self._comparison.hold(prop.get, np.zeros(3) if value is None else value.row(row), made, place)
        order = engine_joint_order(structure, found)
        for field in ("qpos", "qvel"):
            wanted = joint_rows(structure, field, prepared.rows[number : number + 1], order)[0]
            if (actual := getattr(made, field)).tobytes() != wanted.tobytes():
                self._comparison.tell(place, field, wanted.tolist(), actual.tolist())

    def _qpos(self, prepared: PreparedArticulation, part: StructureRows[ArticulationStructure]) -> None:
        order = engine_joint_order(part.structure, prepared.links[int(part.numbers[0])])
        wanted = np.broadcast_to(joint_rows(part.structure, "qpos", part.rows, order), (len(part.rows), len(order)))
        found = np.array([prepared.objs[number].get_qpos() for number in part.numbers], np.float32).reshape(
            wanted.shape
        )
        for i in np.flatnonzero((found != wanted).any(axis=1)).tolist():
            place = BodyLocation(prepared, int(part.numbers[i]), part.structure.origin)
            self._comparison.tell(place, "qpos", wanted[i].tolist(), found[i].tolist())

    def _link(self, prepared: PreparedArticulation, structure: ArticulationStructure, which: int, number: int) -> None:
        link, row = structure.links[which], int(prepared.rows[number])
        place = BodyLocation(prepared, number, link.body.origin, link.name)
        self._bodies.components(link.name, link.body, prepared.entities[number][which].components, row, place)
        joint = prepared.links[number][which].get_joint()
        if link.joint is None:
            self._comparison.hold("root joint.type", "fixed" if structure.fix_root_link else "undefined", joint, place)
        else:
            where = place._replace(origin=link.joint.origin or place.origin)
            links = prepared.links[number]
            ends = [links[which]] if link.parent is None else [links[which], links[link.parent]]
            self._joint(link.joint, joint, row, where, JOINT_TOLERANCE * center_of_mass_reach(ends))

    def _joint(self, joint: Joint, found: Any, row: int, place: BodyLocation, tolerance: float) -> None:
        hold = self._comparison.hold
        hold("joint.name", joint.name, found, place)
        hold("joint.type", joint.type, found, place)
        for field in JOINT_FRAMES:
            pose: Value | None = getattr(joint, field)
            wanted, actual = _IDENTITY if pose is None else pose.row(row), getattr(found, field)
            if _pose_error(wanted, actual) > tolerance:
                self._comparison.tell(place, field, format_value(wanted), format_value(actual))
        if joint.type == "fixed":
            return
        limits = JOINT_LIMITS.default if joint.limits is None else joint.limits.row(row)
        hold("limits", np.array(limits)[None], found, place)
        for field, nothing_said in DRIVE_DEFAULTS.items():
            value: Value | None = getattr(joint, field)
            hold(f"joint.{field}", nothing_said if value is None else float(value.row(row)), found, place)
        hold("drive_mode", joint.drive_mode or "force", found, place)
        self._comparison.expect_but(self._defaults.joint, _expected_joint(joint, row), found, place)


def _expected_joint(joint: Joint, row: int) -> ExpectedProperties:
    own = {prop.get: row_value(value, row) for prop, value in JOINT_PROPERTIES.said(joint)}
    return {name: [value] if name in _AXIS_FIELDS else value for name, value in own.items()}


def _pose_error(wanted: NDArray[np.float64], found: Any) -> float:
    actual = to_engine_array(found)
    unit = wanted[3:] / np.linalg.norm(wanted[3:])
    rotation = min(np.abs(unit - actual[3:]).max(), np.abs(unit + actual[3:]).max())
    return float(max(np.abs(wanted[:3] - actual[:3]).max() / max(1.0, np.abs(wanted[:3]).max()), rotation))
