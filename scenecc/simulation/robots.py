"""Findings about joints that sag, that never come to rest, and about robots that collapse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from scenecc.checks.physics import constrained_entities
from scenecc.plan import ArticulationStructure
from scenecc.simulation.bodies import up_of
from scenecc.simulation.bounds import bounding_boxes
from scenecc.simulation.findings import Finding, amount_text

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from scenecc.backends.sapien import SceneBatch
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan import Entity, ScenePlan

    Floats = NDArray[np.float64]

SAG: Final = {False: 0.5, True: 0.1}
"""[rad], [m] Minimum movement of a joint that counts as sagging."""

_NEAR: Final = {False: 0.05, True: 0.01}
"""[rad], [m] A joint this close to its target starts at it."""

_FAST: Final = {False: 1.0, True: 0.3}
"""[rad/s], [m/s] A joint that is faster is not at rest."""

_TURNS: Final = 4 * np.pi
"""[rad] A joint that turns further than twice around spins."""

_LATE: Final = 0.6
"""Part of the simulated time after which a joint should have come to rest."""

_SERIAL: Final = 3
"""Minimum number of moving joints in a row of an arm. A cabinet has fewer."""

_COLLAPSED: Final = 0.5
"""A robot has collapsed if the height of its root over its lowest point has shrunk to this part."""


_STANDING: Final = np.cos(np.radians(30))
"""A root that tilts by more topples (SC854)."""


@dataclass(slots=True)
class _Robot:
    """An articulation in one scene, with its readings.

    Attributes:
        entity: name of the entity. scene: index of the scene.
        structure: its plan.
        obj: the engine's articulation.
        qpos: (dof,) at the start.
        moves_at_start: whether anything of it has an initial velocity.
        height: height of the root over the lowest point at the start [m].
        upright: (3,) the direction against gravity at the start, in the root's frame.
        early, late: (dof,) maximum speeds before and after `_LATE`.
        turned: (dof,) velocity over time; `qpos` starts again after a turn [rad], [m].
    """

    entity: str
    scene: int
    structure: ArticulationStructure
    obj: Any
    qpos: Floats
    moves_at_start: bool
    height: float
    upright: Floats
    early: Floats
    late: Floats
    turned: Floats


class RobotWatch:
    """Watches the joints of the articulations that no constraint holds.

    Args:
        batch: a batch that was not stepped yet.
    """

    def __init__(self, batch: SceneBatch) -> None:
        self._up = up_of(batch.plan)
        constrained = constrained_entities(batch.plan)
        entities = [entity for entity in batch.plan.entities if entity.name not in constrained]
        self._robots = [robot for entity in entities for robot in _robots_of(batch, entity, self._up)]

    def observe(self, seconds: float, *, late: bool) -> None:
        """Reads the velocities of the joints. `seconds`: time since the last reading; `late`: in the last part."""
        for robot in self._robots:
            qvel = np.array(robot.obj.get_qvel(), np.float64)
            speeds, robot.turned = np.abs(qvel), robot.turned + qvel * seconds
            if late:
                robot.late = np.maximum(robot.late, speeds)
            else:
                robot.early = np.maximum(robot.early, speeds)

    @staticmethod
    def is_late(step: int, last: int) -> bool:
        """Returns whether a step is in the last part of a simulation."""
        return step > _LATE * last

    def findings(self, seconds: float) -> Iterator[Finding]:
        """Yields findings after a simulation of `seconds` [s]."""
        for robot in self._robots:
            if not robot.moves_at_start and robot.qpos.size:
                yield from _find_restless(robot, seconds)
                if self._up is not None:
                    yield from _find_sagging(robot, seconds)
                    yield from _find_collapsed(robot, self._up, seconds)


def joint_key(entity: str, link: str) -> str:
    """Returns the name of a link's joint in findings. Entity names have no colon."""
    return f"{entity}/{link}:joint"


def joint_origins(plan: ScenePlan) -> dict[str, Origin]:
    """Returns the origins of joints that are written in a scene, by their keys."""
    return {
        joint_key(entity.name, link.name): link.joint.origin
        for entity in plan.entities
        for structure in entity.structures
        if isinstance(structure, ArticulationStructure)
        for link in structure.links
        if link.joint is not None and link.joint.origin is not None and link.joint.origin.location is None
    }


def _robots_of(batch: SceneBatch, entity: Entity, up: Floats | None) -> Iterator[_Robot]:
    if not isinstance(entity.structures[0], ArticulationStructure):
        return
    built = batch.articulations[entity.name]
    row_of = {index: row for row, index in enumerate(entity.scene_idxs)}
    for index, obj in zip(built.scene_idxs, built.objs, strict=True):
        row = row_of[index]
        structure = entity.structure(row)
        assert isinstance(structure, ArticulationStructure)
        qvel = np.array(obj.get_qvel(), np.float64)
        values = (structure.linear_velocity, structure.angular_velocity)
        moves = bool(qvel.any()) or any(value is not None and bool(np.any(value.row(row))) for value in values)
        height = 0.0 if up is None else _root_height(obj, up)
        upright = np.zeros(3) if up is None else _root_rotation(obj).T @ up
        qpos = np.array(obj.get_qpos(), np.float64)
        yield _Robot(entity.name, index, structure, obj, qpos, moves, height, upright, *np.zeros((3, qpos.size)))


def _find_restless(robot: _Robot, seconds: float) -> Iterator[Finding]:
    """Yields joints that oscillate about a target, or spin without a drive."""
    joints = robot.obj.get_active_joints()
    if any(np.any(joint.drive_velocity_target) for joint in joints):
        return
    for number, joint in enumerate(joints):
        slides = joint.type == "prismatic"
        early, late = float(robot.early[number]), float(robot.late[number])
        key, named = joint_key(robot.entity, joint.child_link.name), f"joint `{joint.name}` of `{robot.entity}`"
        unit = "m/s" if slides else "rad/s"
        if joint.stiffness and not joint.damping and late > max(_FAST[slides], 0.5 * early):
            yield Finding(
                "SC858", (key,), robot.scene, late,
                f"{named} does not come to rest: it still moves at {late:.3g} {unit} at the end of {seconds:g} s",
                "its drive has `stiffness` but no `damping`: add some",
            )  # fmt: skip
        elif _spins_freely(robot, joint) and abs(robot.turned[number]) > _TURNS and late > 0.5 * early:
            turns = abs(robot.turned[number]) / (2 * np.pi)
            yield Finding(
                "SC858", (key,), robot.scene, late,
                f"{named} spins without a drive: it turns {turns:.2g} times around in {seconds:g} s",
                "give it limits, `friction` or a drive, or a `velocity_target` if it is meant to spin",
            )  # fmt: skip


def _spins_freely(robot: _Robot, joint: Any) -> bool:
    return robot.structure.fix_root_link and joint.type != "prismatic" and not joint.stiffness


def _find_sagging(robot: _Robot, seconds: float) -> Iterator[Finding]:
    """Yields the joint of a fixed robot that its weight moves farthest."""
    structure, joints = robot.structure, robot.obj.get_active_joints()
    if not structure.fix_root_link:
        return
    coupled = {name for mimic in structure.mimics for name in (mimic.joint, mimic.source)}
    is_driven = any(joint.stiffness for joint in joints)
    if not is_driven and not (_is_from_file(structure) and _longest_chain(structure) >= _SERIAL):
        return  # a pendulum or a door
    base = _base_joints(structure)
    found: list[tuple[float, Finding]] = []
    moved = np.abs(np.array(robot.obj.get_qpos(), np.float64) - robot.qpos)
    for number, joint in enumerate(joints):
        slides, way = joint.type == "prismatic", float(moved[number])
        if way < SAG[slides] or joint.name in coupled or np.any(joint.drive_velocity_target):
            continue
        if not joint.stiffness and joint.name in base:
            continue
        if joint.stiffness and abs(float(np.ravel(joint.drive_target)[0]) - robot.qpos[number]) > _NEAR[slides]:
            continue  # it moves to its target
        text = f"joint `{joint.name}` of `{robot.entity}` sags by {amount_text(way, slides=slides)} in {seconds:g} s"
        cure = "raise the `stiffness` of its drive" if joint.stiffness else "give it a drive with `stiffness`"
        key = joint_key(robot.entity, joint.child_link.name) if is_driven else robot.entity
        finding = Finding("SC859", (key,), robot.scene, way / SAG[slides], text, f"{cure}, or write `gravity: false`")
        found.append((finding.amount, finding))
    if found:
        yield max(found, key=lambda one: one[0])[1]


def _find_collapsed(robot: _Robot, up: Floats, seconds: float) -> Iterator[Finding]:
    """Yields a robot with a free root that does not keep its height, unless it topples, which is reported as such."""
    if robot.structure.fix_root_link or not any(joint.stiffness for joint in robot.obj.get_active_joints()):
        return
    height, stands = _root_height(robot.obj, up), float(_root_rotation(robot.obj) @ robot.upright @ up) > _STANDING
    if stands and height < _COLLAPSED * robot.height:
        yield Finding(
            "SC859", (robot.entity,), robot.scene, 1 - height / robot.height,
            f"`{robot.entity}` collapses: in {seconds:g} s its root sinks from {robot.height:.3g} m to {height:.3g} m "
            "over its lowest point",
            "start with joints at the drives' targets (`qpos`), and raise `stiffness`",
        )  # fmt: skip


def _root_rotation(obj: Any) -> Floats:
    """Returns the rotation of the root (3, 3)."""
    return obj.root.entity_pose.to_transformation_matrix()[:3, :3].astype(np.float64)


def _root_height(obj: Any, up: Floats) -> float:
    """Returns the height of the root over the lowest point [m]. Along an oblique gravity it is approximate."""
    solid = [link for link in obj.links if link.collision_shapes]
    if not solid:
        return 0.0
    boxes = bounding_boxes(solid)
    lowest = (boxes.mean(axis=1) @ up - np.ptp(boxes, axis=1) / 2 @ np.abs(up)).min()
    return float(np.array(obj.root.entity_pose.p, np.float64) @ up - lowest)


def _is_from_file(structure: ArticulationStructure) -> bool:
    return structure.file is not None or any(link.file is not None for link in structure.links)


def _base_joints(structure: ArticulationStructure) -> set[str]:
    """Returns the joints of a floating base: from the root up to the first link with shapes, if it is not the first."""
    found: set[str] = set()
    is_base = [True] * len(structure.links)
    for number, link in enumerate(structure.links):
        if link.parent is None or link.joint is None:
            continue
        is_base[number] = is_base[link.parent] and not link.body.collisions
        if is_base[number] or (is_base[link.parent] and structure.links[link.parent].parent is not None):
            found.add(link.joint.name)
    return found


def _longest_chain(structure: ArticulationStructure) -> int:
    """Returns the maximum number of moving joints in a row."""
    depths: list[int] = []
    for link in structure.links:
        before = 0 if link.parent is None else depths[link.parent]
        depths.append(before + (link.joint is not None and link.joint.type != "fixed"))
    return max(depths)
