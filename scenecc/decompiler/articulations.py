"""Reads articulations of live scenes: a robot as its URDF with differences, others as a tree of links."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from scenecc.backends.sapien.engine import sapien
from scenecc.backends.sapien.properties import ARTICULATION_PROPERTIES
from scenecc.decompiler.bodies import LiveBodyReader, friction_of, inertial, is_equal, physical_material, plain_value
from scenecc.decompiler.values import FileNamer, Node, pose_value, same_single, to_number, to_numbers
from scenecc.geometry.rotations import EXACT_UNIT_TOLERANCE, normalized
from scenecc.names import UniqueNames
from scenecc.plan.articulation import BRAKE_DAMPING
from scenecc.plan.properties import properties_of
from scenecc.scene_file.patterns import group_by_pattern
from scenecc.scene_file.shared_keys import move_up

if TYPE_CHECKING:
    from scenecc.decompiler.names import SceneNames
    from scenecc.decompiler.record import Recording, RobotSource

_JOINT_KEYS: Final = tuple(row.field for row in properties_of("joint"))

_DRIVE_KEYS: Final = tuple(row.field for row in properties_of("drive"))

_TREE_DEFAULTS: Final = {"friction": 0.05, "armature": 0.0}


@dataclass(frozen=True)
class JointState:
    """Values of an active joint."""

    limits: list[float]
    numbers: Node
    drive: Node
    target: float
    velocity_target: float

    @property
    def brakes(self) -> bool:
        """Whether the drive is a friction force, see `friction_force` of the plan."""
        drive, still = self.drive, self.target == 0 and self.velocity_target == 0
        is_brake = drive["stiffness"] == 0 and drive["damping"] == BRAKE_DAMPING and drive["mode"] == "force"
        return is_brake and still and 0 < drive["force_limit"] < _UNDRIVEN["force_limit"]

    @staticmethod
    def of(joint: Any) -> JointState:
        """Reads a live joint with one degree of freedom."""
        drive = {key: plain_value(getattr(joint, key)) for key in _DRIVE_KEYS}
        mode: Any = joint.drive_mode
        return JointState(
            to_numbers(joint.limits[0]),
            {key: _first_number(getattr(joint, key)) for key in _JOINT_KEYS},
            drive | {"mode": str(mode)},
            to_number(joint.drive_target[0] if hasattr(joint.drive_target, "__len__") else joint.drive_target),
            _first_number(joint.drive_velocity_target),
        )


def _first_number(value: Any) -> float:
    return to_number(value[0] if hasattr(value, "__len__") else value)


class ArticulationReader:
    """Reads articulations of one scene."""

    def __init__(
        self,
        recording: Recording | None,
        files: FileNamer,
        bodies: LiveBodyReader,
        names: SceneNames,
        physics: Node,
    ) -> None:
        self._recording = recording
        self._files = files
        self._bodies = bodies
        self._names = names
        self._physics = physics

    def entity(self, name: str, articulation: Any, *, is_only: bool) -> Node:
        """Returns an articulation. `is_only`: no other articulation in the scene has ignore bits."""
        source = self._recording.robot_of(articulation.links[0]) if self._recording is not None else None
        if source is not None:
            node = self._robot(name, articulation, source, is_only=is_only)
            if node is not None:
                return node
        return self._tree(name, articulation)

    # ---- a robot by its URDF

    def _robot(self, name: str, articulation: Any, source: RobotSource, *, is_only: bool) -> Node | None:
        file = Path(source.file)
        node: Node = {"urdf": self._files.name(file)}
        fixed = articulation.links[0].joint.type == "fixed"
        node |= {key: value for key, value in source.options.items() if key != "fix_root_link"}
        bits = [shape.get_collision_groups() for link in articulation.links for shape in link.collision_shapes]
        if not is_only and any(groups[2] for groups in bits) and not any(groups[3] for groups in bits):
            node["sapien_bits"] = True
        if not fixed:
            node["fix_root_link"] = False
        reference = self._reference({**node, "urdf": str(file.resolve())})
        if reference is None or [self._names.rename(link.name) for link in articulation.links] != [
            link.name for link in reference[0].links
        ]:
            self._bodies.problems.append(f"`{name}`: its file builds different links; it is written as a link tree")
            return None
        self._names.keep([*(link.entity for link in articulation.links), *articulation.joints])
        node |= self._state(articulation, reference[0])
        node |= self._link_differences(articulation, reference[0], name)
        return node | self._joint_differences(articulation, *reference)

    def _reference(self, node: Node) -> tuple[Any, Any] | None:
        """Builds the articulation from its file, without and with drives, for comparison."""
        import scenecc  # noqa: PLC0415 - the facade is above this module's other users
        from scenecc.decompiler.verify import default_engine_settings  # noqa: PLC0415 - as above

        entities = {"plain": node, "driven": {**node, "drives": {".*": {"stiffness": 0}}}}
        document = {"scenecc": 1, "physics": self._physics, "entities": entities}
        try:
            with default_engine_settings():
                batch = scenecc.load_scene(document, render=False, allow_outside_assets=True)
        except scenecc.SceneError:
            del entities["driven"]
            try:
                with default_engine_settings():
                    batch = scenecc.load_scene(document, render=False, allow_outside_assets=True)
            except scenecc.SceneError as error:
                self._bodies.problems.append(f"{node}: {error}")
                return None
        self._bodies.keep_alive(batch)
        found = [batch.articulations[name].objs[0] for name in entities if name in batch.articulations]
        return (found[0], found[-1]) if len(found) == len(entities) else None

    def _link_differences(self, articulation: Any, reference: Any, name: str) -> Node:
        links: dict[str, Node] = {}
        names = [link.name for link in reference.links]
        for link, other in zip(articulation.links, reference.links, strict=True):
            keys = self._link_keys(link, other, name)
            if keys:
                links[other.name] = keys
        node: Node = {}
        if len(links) == len(names):
            move_up(node, list(links.values()), "gravity")
        links = {link: keys for link, keys in links.items() if keys}
        return {**node, "links": group_by_pattern(links, names)} if links else node

    def _link_keys(self, link: Any, other: Any, name: str) -> Node:
        mine, theirs = self._bodies.link_properties(link), self._bodies.link_properties(other)
        keys = {key: value for key, value in mine.items() if theirs.get(key) != value}
        for key in theirs.keys() - mine.keys():
            keys[key] = self._bodies.link_default(key)
        if not (
            is_equal(link.mass, other.mass)
            and is_equal(link.inertia, other.inertia)
            and same_single(link.cmass_local_pose.p, other.cmass_local_pose.p)
            and same_single(link.cmass_local_pose.q, other.cmass_local_pose.q)
        ):
            keys["inertial"] = inertial(link)
        return keys | self._shape_keys(link, other, name)

    def _shape_keys(self, link: Any, other: Any, name: str) -> Node:
        pairs = list(zip(link.collision_shapes, other.collision_shapes, strict=False))
        keys: Node = {}
        if any(not same_single(friction_of(a.physical_material), friction_of(b.physical_material)) for a, b in pairs):
            (numbers, *others) = {friction_of(a.physical_material) for a, _ in pairs}
            if others:
                self._bodies.problems.append(f"`{name}/{other.name}`: shapes with different friction")
            keys["material"] = physical_material(numbers)
        for key in ("patch_radius", "min_patch_radius", "density"):
            if any(not is_equal(getattr(a, key), getattr(b, key)) for a, b in pairs):
                keys[key] = plain_value(getattr(pairs[0][0], key))
        if any(list(a.get_collision_groups()) != list(b.get_collision_groups()) for a, b in pairs):
            keys["collision_bits"] = list(pairs[0][0].get_collision_groups())
        return keys

    def _joint_differences(self, articulation: Any, reference: Any, driven: Any) -> Node:
        joints: dict[str, Node] = {}
        drives: dict[str, Node] = {}
        names = [joint.name for joint in reference.active_joints]
        qpos = articulation.qpos.tolist()
        rows = zip(articulation.active_joints, reference.active_joints, driven.active_joints, qpos, strict=True)
        for joint, other, with_drive, start in rows:
            live, plain, pulled = JointState.of(joint), JointState.of(other), JointState.of(with_drive)
            keys = {key: value for key, value in live.numbers.items() if value != plain.numbers[key]}
            if live.limits != plain.limits:
                keys["limits"] = live.limits
            if keys:
                joints[other.name] = keys
            drive = self._drive(live, plain, pulled, start)
            if drive:
                drives[other.name] = drive
        node: Node = {}
        node |= {"joints": group_by_pattern(joints, names)} if joints else {}
        return node | ({"drives": group_by_pattern(drives, names)} if drives else {})

    def _drive(self, live: JointState, plain: JointState, driven: JointState, start: float) -> Node:
        targets: Node = {}
        if live.velocity_target:
            targets["velocity_target"] = live.velocity_target
        if live.drive == plain.drive and live.target == 0 and not targets:
            return {}
        keys = {key: value for key, value in live.drive.items() if value != driven.drive[key]}
        if live.target != to_number(start):
            targets["target"] = live.target
        return keys | targets or {"stiffness": live.drive["stiffness"]}

    def _state(self, articulation: Any, reference: Any) -> Node:
        pose = pose_value(_root_pose(articulation, reference))
        node: Node = {} if pose is None else {"pose": pose}
        qpos, qvel = to_numbers(articulation.qpos), to_numbers(articulation.qvel)
        limits = articulation.qlimits
        if any(qpos) or any(not low <= 0 <= high for low, high in limits):
            node["qpos"] = qpos
        if any(qvel):
            node["qvel"] = qvel
        targets = [JointState.of(joint).target for joint in articulation.active_joints]
        if any(
            not low - _LIMIT_TOLERANCE <= value <= high + _LIMIT_TOLERANCE
            for values in (qpos, targets)
            for value, (low, high) in zip(values, limits, strict=True)
        ) or any(not low <= value <= high for value, (low, high) in zip(qpos, limits, strict=True)):
            node["beyond_limits"] = True
        for key in ("linear_velocity", "angular_velocity"):
            value = to_numbers(getattr(articulation, f"root_{key}"))
            if any(value) and articulation.links[0].joint.type != "fixed":
                node[key] = value
        return node | self._bodies.articulation_properties(articulation, ARTICULATION_PROPERTIES.by_field)

    # ---- a tree of links

    def _tree(self, name: str, articulation: Any) -> Node:
        links = articulation.links
        self._names.replace("link", [link.entity for link in links], ["link"] * len(links), UniqueNames(), of=name)
        joints = [joint for joint in articulation.joints if self._names.rename(joint.name) or joint.dof]
        self._names.replace("joint", joints, ["joint"] * len(joints), UniqueNames(), of=name)
        fixed = links[0].joint.type == "fixed"
        node: Node = {"fix_root_link": True} if fixed else {}
        nodes: dict[int, Node] = {}
        for link in links:
            nodes[link.index] = self._tree_link(name, link)
        for link in links[1:]:
            nodes[link.parent.index].setdefault("children", []).append(nodes[link.index])
        move_up(node, list(nodes.values()), "gravity")
        node |= self._state(articulation, None)
        settings: dict[str, Node] = {}
        drives: dict[str, Node] = {}
        names = [self._names.of(joint) for joint in articulation.active_joints]
        for joint, start in zip(articulation.active_joints, articulation.qpos.tolist(), strict=True):
            state, joint_name = JointState.of(joint), self._names.of(joint)
            drive = {} if state.brakes else {k: v for k, v in state.drive.items() if v != _UNDRIVEN[k]}
            if state.target != to_number(start) and (drive or state.target):
                drive["target"] = state.target
            if drive.keys() - {"damping", "target"} or state.target:
                drives[joint_name] = drive
            if not same_single([state.numbers["max_velocity"]], [_USUAL_MAX_VELOCITY]):
                settings[joint_name] = {"max_velocity": state.numbers["max_velocity"]}
        node |= {"joints": group_by_pattern(settings, names)} if settings else {}
        node |= {"drives": group_by_pattern(drives, names)} if drives else {}
        return {**node, "root": nodes[links[0].index]}

    def _tree_link(self, name: str, link: Any) -> Node:
        link_name = self._names.of(link.entity)
        node: Node = {"name": link_name}
        if not link.is_root:
            node["joint"] = self._tree_joint(link)
        look = self._bodies.look_of(link.entity)
        node |= self._bodies.shapes(f"{name}/{link_name}", link, look)
        if not link.auto_compute_mass:
            node["inertial"] = inertial(link)
        return node | self._bodies.link_properties(link)

    def _tree_joint(self, link: Any) -> Node:
        joint = link.joint
        record = getattr(self._recording and self._recording.builder_of(link), "joint_record", None)
        name = self._names.of(joint)
        node: Node = {"name": name, "type": str(joint.type)} if name else {"type": str(joint.type)}
        for key in ("pose_in_parent", "pose_in_child"):
            live, given = getattr(joint, key), getattr(record, key, None)
            value = pose_value(_original_frame(given, live))
            node |= {key: value or [0.0, 0.0, 0.0]} if key == "pose_in_parent" or value is not None else {}
        if joint.dof:
            state = JointState.of(joint)
            if state.limits != [-float("inf"), float("inf")]:
                node["limits"] = state.limits
            node |= {
                key: state.numbers[key]
                for key, usual in _TREE_DEFAULTS.items()
                if not same_single([state.numbers[key]], [usual])
            }
            if state.brakes:
                node["friction_force"] = state.drive["force_limit"]
            elif state.drive["damping"]:
                node["damping"] = state.drive["damping"]
        return node


def _root_pose(articulation: Any, reference: Any) -> Any:
    """Returns the pose that was set on an articulation, if it has few digits, since PhysX returns a rounded one."""
    live = articulation.root_pose
    if reference is None:
        return live
    short_q = [round(item, 6) + 0.0 for item in normalized(to_numbers(live.q))]
    for p in ([round(item, 6) + 0.0 for item in live.p.tolist()], to_numbers(live.p)):
        for q in (short_q, to_numbers(live.q)):
            pose = sapien.Pose(p, q)
            reference.set_root_pose(pose)
            if same_single(reference.root_pose.p, live.p) and same_single(reference.root_pose.q, live.q):
                return pose
    return live


_USUAL_MAX_VELOCITY: Final = 100.0
"""Default velocity limit of a PhysX joint [m/s or rad/s]."""

_UNDRIVEN: Final = {row.field: row.untouched for row in properties_of("drive")} | {"mode": "force"}

_LIMIT_TOLERANCE: Final = 1e-6
"""Allowed distance of a position beyond a limit (`SC517`)."""


def _original_frame(given: Any, live: Any) -> Any:
    """Returns a joint's frame as set in its builder, if known, since PhysX changes the last bits; else the live frame.

    A scene file passes a quaternion of almost unit length unchanged.
    """
    if given is None:
        return live
    q = to_numbers(given.q)
    unit = sapien.Pose(given.p, list(normalized(q)))
    if not _is_near(live, unit):
        return live
    return given if abs(math.hypot(*q) - 1) <= EXACT_UNIT_TOLERANCE else unit


def _is_near(first: Any, second: Any) -> bool:
    return all(
        abs(a - b) <= 2e-6
        for name in ("p", "q")
        for a, b in zip(getattr(first, name), getattr(second, name), strict=True)
    )
