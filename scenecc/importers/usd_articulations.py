"""Builds link trees from bodies connected by USD joints; joints that close loops become constraints."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.importers.numbers import plain_number, pose_key
from scenecc.importers.usd_joints import Freedom, UsdJoint, usd_tree_joint

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.importers.usd_bodies import UsdBody, UsdBodyReader
    from scenecc.importers.usd_stage import Prim, UsdStage

_DUMMY_MASS: Final = 1e-3
"""Mass of a link between two freedoms of one joint, relative to the next link's mass."""

_OFF_POSITION, _OFF_ANGLE = 1e-4, 1e-3
"""Largest offset between a joint's frames that is not reported as a loss [m, rad]."""


@dataclass(slots=True)
class JointTree:
    """Bodies that become one articulation.

    Attributes:
        root: path of the root link's body; "" if the root is the world.
        fixed: whether the root cannot move.
        joints: joints from the root outwards, each with the parent as its first body.
        rest: joints that close loops.
        prim: the articulation root; None if the file has none.
    """

    root: str
    fixed: bool
    joints: list[UsdJoint]
    rest: list[UsdJoint]
    prim: Prim | None

    @property
    def bodies(self) -> list[str]:
        """Paths of its bodies, the root first."""
        found = [self.root] if self.root else []
        return found + [joint.bodies[1] for joint in self.joints]

    @property
    def split_joints(self) -> list[UsdJoint]:
        """Joints with several freedoms. PhysX disables collisions only between direct neighbours of a tree."""
        return [joint for joint in self.joints if len(joint.freedoms) > 1]


def find_trees(
    joints: Iterable[UsdJoint], moving: Iterable[str], roots: Mapping[str, Prim]
) -> tuple[list[JointTree], list[UsdJoint]]:
    """Finds spanning trees of the bodies connected by joints.

    Args:
        joints: joints of the stage.
        moving: paths of the dynamic bodies, in stage order.
        roots: body → prim of its articulation root; if nothing is fixed, the prim's first body is the root.

    Returns:
        The trees, and the joints outside of them.
    """
    order = {path: k for k, path in enumerate(moving)}
    edges: dict[str, list[UsdJoint]] = {}
    rest: list[UsdJoint] = []
    for joint in joints:
        inside = all(not body or body in order for body in joint.bodies)
        if not inside or not _fits_tree(joint, roots):
            rest.append(joint)
            continue
        for body in joint.bodies:
            edges.setdefault(body, []).append(joint)
    trees: list[JointTree] = []
    seen: set[str] = set()
    for body in order:
        if body in edges and body not in seen:
            tree = _span(_component(body, edges), edges, order, roots)
            seen.update(tree.bodies)
            trees.append(tree)
    return trees, rest


def _fits_tree(joint: UsdJoint, roots: Mapping[str, Prim]) -> bool:
    if joint.excluded or joint.distance is not None or len(joint.freedoms) == 6:
        return False
    if any(body in roots for body in joint.bodies):
        return True
    # PhysX constrains free bodies by a ball joint without hinges; only limits need hinges.
    free_ball = len(joint.freedoms) == 3 and all(
        each.turns and each.drive is None and each.limits == (-math.inf, math.inf) for each in joint.freedoms
    )
    return not free_ball


def _component(start: str, edges: Mapping[str, list[UsdJoint]]) -> set[str]:
    """Returns all bodies connected to one by joints, but not through the world."""
    found, todo = {start}, [start]
    while todo:
        for joint in edges[todo.pop()]:
            for other in joint.bodies:
                if other and other not in found:
                    found.add(other)
                    todo.append(other)
    return found


def _span(
    bodies: set[str], edges: Mapping[str, list[UsdJoint]], order: Mapping[str, int], roots: Mapping[str, Prim]
) -> JointTree:
    joints = list(dict.fromkeys(joint for body in sorted(bodies, key=order.__getitem__) for joint in edges[body]))
    grounded = [joint for joint in joints if "" in joint.bodies]
    fixed = next((joint for joint in grounded if not joint.freedoms), None)
    above = {joint.bodies[1] for joint in joints}
    first = min(bodies, key=lambda body: (body in above, order[body]))
    prim = next((roots[body] for body in sorted(bodies, key=order.__getitem__) if body in roots), None)
    if fixed is not None:
        root = fixed.bodies[0] or fixed.bodies[1]
    elif grounded:
        root = ""
    else:
        root = str(prim.GetPath()) if prim is not None and str(prim.GetPath()) in bodies else first
    tree = JointTree(root, fixed is not None or bool(grounded), [], [], prim)
    used: set[int] = {id(fixed)} if fixed is not None else set()
    reached = {root}
    front = [root]
    if not root:
        used.add(id(grounded[0]))
        tree.joints.append(grounded[0] if not grounded[0].bodies[0] else grounded[0].reversed())
        front = [tree.joints[0].bodies[1]]
        reached.add(front[0])
    while front:
        body = front.pop(0)
        for joint in edges[body]:
            other = joint.bodies[1] if joint.bodies[0] == body else joint.bodies[0]
            if other and other not in reached and id(joint) not in used:
                used.add(id(joint))
                reached.add(other)
                front.append(other)
                tree.joints.append(joint if joint.bodies[0] == body else joint.reversed())
    tree.rest = [joint for joint in joints if id(joint) not in used]
    return tree


class ArticulationWriter:
    """Writes trees as entities.

    Attributes:
        keys: keys of each link, by the path of its body.
    """

    def __init__(self, stage: UsdStage, reader: UsdBodyReader, bodies: Mapping[str, UsdBody]) -> None:
        self.keys: dict[str, dict[str, Any]] = {}
        self._stage = stage
        self._reader = reader
        self._bodies = bodies

    def entity(self, tree: JointTree, names: Mapping[str, str], joint_names: Mapping[int, str]) -> dict[str, Any]:
        """Returns the entity of a tree.

        Args:
            tree: the tree.
            names: path of a body → name of its link.
            joint_names: `id` of a joint → its name.
        """
        links: dict[str, dict[str, Any]] = {}
        if tree.root:
            pose = self._bodies[tree.root].pose
            root = links[tree.root] = self._link(tree.root, names)
        else:
            pose = tree.joints[0].frames[0]
            root = links[""] = {"name": "world"}
        settings: dict[str, dict[str, Any]] = {"joints": {}, "drives": {}, "qpos": {}, "qvel": {}}
        beyond = False
        for joint in tree.joints:
            link = self._link(joint.bodies[1], names)
            links[joint.bodies[1]] = link
            first = IDENTITY_POSE if not tree.root and joint is tree.joints[0] else joint.frames[0]
            beyond = self._add(joint, first, links[joint.bodies[0]], link, joint_names[id(joint)], settings) or beyond
        entity = pose_key(pose)
        if tree.fixed:
            entity["fix_root_link"] = True
        elif tree.root:
            entity |= self._reader.velocity_keys(self._bodies[tree.root])
        entity |= self._articulation_keys(tree)
        if beyond:
            entity["beyond_limits"] = True
        entity |= {key: row for key, row in settings.items() if row}
        return {**entity, "root": root}

    def _link(self, path: str, names: Mapping[str, str]) -> dict[str, Any]:
        self.keys[path] = {"name": names[path], **self._reader.keys(self._bodies[path], is_link=True)}
        return self.keys[path]

    def _add(
        self,
        joint: UsdJoint,
        first: Pose7,
        parent: dict[str, Any],
        link: dict[str, Any],
        name: str,
        settings: dict[str, dict[str, Any]],
    ) -> bool:
        """Adds a link below its parent, with a link between each two freedoms, and one above if both collide with each
        other. Returns whether it starts beyond a limit.

        `first`: the joint's frame in the parent.
        """
        positions, distance, angle = joint.positions()
        if distance > _OFF_POSITION or angle > _OFF_ANGLE:
            self._stage.lose(
                "joint-frames",
                f"the pose of a link: its joint's frames are {distance:.3g} m and {angle:.3g} rad apart",
                joint.prim,
            )
        freedoms: list[Freedom | None] = list(joint.freedoms) or [None]
        if len(joint.freedoms) > 1:
            self._stage.lose(
                "ball-joints",
                f"a joint with {len(freedoms)} freedoms; it becomes {len(freedoms)} joints in series",
                joint.prim,
            )
        elif joint.collides and all(_collides(self._bodies.get(body)) for body in joint.bodies):
            # PhysX prevents contacts only between a link and its parent.
            freedoms, positions = [None, *freedoms], [0.0, *(positions or [0.0])]
        beyond = False
        for k, (freedom, position) in enumerate(zip(freedoms, positions or [0.0], strict=True)):
            last = k == len(freedoms) - 1
            child = link if last else _dummy(link, f"{link['name']}_dummy_{k}")
            own = name if len(joint.freedoms) <= 1 or freedom is None else f"{name}_{freedom.name}"
            in_child = joint.frames[1] if last else IDENTITY_POSE
            made = usd_tree_joint(first, in_child, freedom, own)
            first = IDENTITY_POSE
            placed: dict[str, Any] = {"name": child.pop("name"), "joint": made, **child}
            child.clear()
            child.update(placed)
            parent.setdefault("children", []).append(child)
            parent = child
            if freedom is not None:
                beyond = self._set_start(freedom, position, own, settings) or beyond
                settings["joints"] |= self._joint_keys(joint.prim, own, freedom)
        return beyond

    def _set_start(self, freedom: Freedom, position: float, name: str, settings: dict[str, dict[str, Any]]) -> bool:
        """Sets a joint's initial position and drive. Returns whether it starts beyond a limit."""
        low, high = freedom.limits
        near = min(max(position, low), high)
        beyond = abs(near - position) > _OFF_ANGLE
        start = plain_number(position if beyond else near)
        if abs(start) < 1e-6 and low <= 0 <= high:
            start = 0.0
        if start != plain_number(min(max(0.0, low), high)) or not low <= 0 <= high:
            settings["qpos"][name] = start
        drive = freedom.drive
        if drive is not None:
            keys = drive.keys()
            if abs(drive.target - start) > 1e-7:
                keys["target"] = plain_number(drive.target)
            if drive.velocity:
                keys["velocity_target"] = plain_number(drive.velocity)
            settings["drives"][name] = keys
            beyond = beyond or not low - 1e-6 <= drive.target <= high + 1e-6
        return beyond

    def _joint_keys(self, prim: Prim, name: str, freedom: Freedom) -> dict[str, dict[str, Any]]:
        """Returns friction, armature and velocity limit from PhysX's schema. UsdPhysics has no joint friction."""
        force = self._friction_force(prim, freedom)
        keys: dict[str, Any] = {"friction": plain_number(self._stage.authored(prim, "physxJoint:jointFriction") or 0.0)}
        if force and freedom.drive is None:
            keys["friction_force"] = plain_number(force)
        elif force:
            self._stage.lose("joint-friction", f"the friction force {force:g} of a joint that has a drive", prim)
        armature = self._stage.authored(prim, "physxJoint:armature")
        frames = self._stage.frames
        if armature:
            keys["armature"] = plain_number(armature * frames.kilograms * (frames.metres**2 if freedom.turns else 1.0))
        speed = self._stage.authored(prim, "physxJoint:maxJointVelocity")
        if speed is not None and math.isfinite(speed) and speed < 1e6:
            keys["max_velocity"] = plain_number(speed * (math.radians(1) if freedom.turns else frames.metres))
        return {name: keys}

    def _friction_force(self, prim: Prim, freedom: Freedom) -> float:
        """Returns the friction that does not depend on the load [N, N·m]; 0 if there is none."""
        frames = self._stage.frames
        names = [f"physxJointAxis:{axis}:dynamicFrictionEffort" for axis in (freedom.name, _AXIS_WORDS[freedom.turns])]
        found = [self._stage.authored(prim, name) for name in (*names, "mjc:frictionloss")]
        force = next((float(each) for each in found if each and math.isfinite(each)), 0.0)
        return max(force, 0.0) * frames.kilograms * (frames.metres**2 if freedom.turns else frames.metres)

    def _articulation_keys(self, tree: JointTree) -> dict[str, Any]:
        keys: dict[str, Any] = {}
        if tree.prim is None:
            return keys
        if self._stage.authored(tree.prim, "physxArticulation:enabledSelfCollisions") is False:
            keys["disable_self_collisions"] = True
        for key, name in (
            ("solver_position_iterations", "solverPositionIterationCount"),
            ("solver_velocity_iterations", "solverVelocityIterationCount"),
        ):
            found = self._stage.authored(tree.prim, f"physxArticulation:{name}")
            if found is not None:
                keys[key] = int(found)
        return keys


_AXIS_WORDS: Final = {True: "angular", False: "linear"}
"""Names of PhysX's schema for the axes of a joint of one freedom, by whether it turns."""


def _collides(body: UsdBody | None) -> bool:
    return body is not None and any(parsed.collisionEnabled for _, parsed in body.colliders)


def _dummy(link: dict[str, Any], name: str) -> dict[str, Any]:
    """Returns a light link between two freedoms of one joint."""
    inertial = link.get("inertial", {})
    mass = float(inertial.get("mass", link.get("mass", 1.0))) * _DUMMY_MASS
    moment = max(inertial.get("inertia", [mass / _DUMMY_MASS * 0.01])) * _DUMMY_MASS
    return {"name": name, "inertial": {"mass": plain_number(mass), "inertia": [plain_number(moment)] * 3}}


def merge_settings(entity: dict[str, Any]) -> None:
    """Moves settings that all joints of an articulation share under the pattern `.*`."""
    joints: dict[str, dict[str, Any]] = entity.get("joints", {})
    if len(joints) > 1 or (joints and len(next(iter(joints.values()))) >= 1):
        shared = [(key, value) for key, value in next(iter(joints.values())).items()]
        common = {key: value for key, value in shared if all(row.get(key) == value for row in joints.values())}
        own = {name: {k: v for k, v in row.items() if k not in common} for name, row in joints.items()}
        rows = {name: row for name, row in own.items() if row}
        entity["joints"] = {".*": common, **rows} if common else rows
