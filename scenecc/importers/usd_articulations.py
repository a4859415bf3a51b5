"""Builds link trees from bodies connected by USD joints; joints that close loops become constraints."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, compose
from scenecc.importers.numbers import along_x
from scenecc.importers.usd_joints import NO_SPEED_LIMIT
from scenecc.names import UniqueNames
from scenecc.robots.description import DescribedDynamics, DescribedJoint, DescribedLink, DescribedMimic, DescribedRobot
from scenecc.robots.rules import lost_resistance, split_joint

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from scenecc.importers.usd_bodies import UsdBody, UsdBodyReader
    from scenecc.importers.usd_joints import Freedom, UsdJoint
    from scenecc.importers.usd_stage import Prim, UsdStage

_ADDED_ROOT: Final = "base"
"""Name of the root of a tree that the world carries."""

_MIMIC: Final = "PhysxMimicJointAPI:"
"""Start of the name of the schema of joints that follow another."""

_ITERATIONS: Final = ("Position", "Velocity")

_SMALL: Final = 1e-6
"""Positions nearer to 0 are 0 [m, rad]."""

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


class UsdArticulationReader:
    """Describes trees as robots.

    Attributes:
        mimics: paths of the joints that follow another.
    """

    def __init__(self, stage: UsdStage, reader: UsdBodyReader, bodies: Mapping[str, UsdBody]) -> None:
        self.mimics: set[str] = set()
        self._stage = stage
        self._reader = reader
        self._bodies = bodies

    def robot(self, tree: JointTree, names: Mapping[str, str]) -> DescribedRobot:
        """Returns the robot of a tree. `names`: path of a body → unique name of its link."""
        free = UniqueNames(*names.values())
        if tree.root:
            pose = self._bodies[tree.root].pose
            links = [self._reader.link(self._bodies[tree.root], names[tree.root])]
        else:
            pose = tree.joints[0].frames[0]
            links = [DescribedLink(free.new(_ADDED_ROOT), self._stage.place, is_added=True)]
        indices = {tree.root: 0}
        single: dict[int, Prim] = {}
        joint_names = UniqueNames()
        for joint in tree.joints:
            parent, body = joint.bodies
            first = joint.frames[0] if parent else IDENTITY_POSE
            freedoms = self._freedoms(joint, first, joint_names.new(joint.name))
            # Light links take a share of the mass of the link.
            link = self._reader.link(self._bodies[body], names[body], is_weighed=len(freedoms) > 1)
            small = [free.new(f"{link.name}_dummy_{k}") for k in range(len(freedoms) - 1)]
            links += split_joint(replace(link, parent=indices[parent]), freedoms, small, len(links))
            indices[body] = len(links) - 1
            if len(joint.freedoms) == 1:
                single[indices[body]] = joint.prim
        links = self._with_mimics(links, single)
        dynamics, collide = self._settings(tree)
        place = self._stage.place
        return DescribedRobot(tuple(links), None, tree.fixed, pose, place, self_collisions=collide, dynamics=dynamics)

    def _settings(self, tree: JointTree) -> tuple[DescribedDynamics | None, bool]:
        """Returns initial velocities and solver iterations, and whether the links collide with one another."""
        dynamics = None if tree.fixed else self._reader.velocities(self._bodies[tree.root])
        if tree.prim is None:
            return dynamics, True
        read = self._stage.authored
        counts = (read(tree.prim, f"physxArticulation:solver{name}IterationCount") for name in _ITERATIONS)
        position, velocity = (int(count) if count is not None and math.isfinite(count) else None for count in counts)
        given = dynamics or DescribedDynamics()
        dynamics = replace(given, solver_position_iterations=position, solver_velocity_iterations=velocity)
        return dynamics, read(tree.prim, "physxArticulation:enabledSelfCollisions") is not False

    def _freedoms(self, joint: UsdJoint, first: Pose7, name: str) -> list[DescribedJoint]:
        """Returns the joints in series that a joint consists of: one for each freedom, and a fixed one before them if
        its bodies collide with each other.

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
        elif joint.collides and all(body in self._bodies and self._bodies[body].collides for body in joint.bodies):
            # PhysX prevents contacts only between a link and its parent.
            freedoms, positions = [None, *freedoms], [0.0, *(positions or [0.0])]
        made: list[DescribedJoint] = []
        for number, (freedom, position) in enumerate(zip(freedoms, positions or [0.0], strict=True), 1):
            frames = (
                first if number == 1 else IDENTITY_POSE,
                joint.frames[1] if number == len(freedoms) else IDENTITY_POSE,
            )
            if freedom is None:
                made.append(DescribedJoint("", "fixed", *frames, self._stage.place))
                continue
            own = name if len(joint.freedoms) == 1 else f"{name}_{freedom.name}"
            turned = [compose(frame, along_x(freedom.axis)) for frame in frames]
            made.append(self._joint(joint.prim, freedom, position, own, turned))
        return made

    def _joint(
        self, prim: Prim, freedom: Freedom, position: float, name: str, frames: Sequence[Pose7]
    ) -> DescribedJoint:
        """Returns a joint of one freedom, with friction, armature and velocity limit from PhysX's schema."""
        stage, metres = self._stage, self._stage.frames.metres
        low, high = freedom.limits
        near = min(max(position, low), high)
        start = near if abs(near - position) <= _OFF_ANGLE else position
        force = self._friction_force(prim, freedom)
        armature = stage.authored(prim, "physxJoint:armature") or 0.0
        speed = stage.authored(prim, "physxJoint:maxJointVelocity")
        unit = math.radians(1) if freedom.turns else metres
        made = DescribedJoint(
            name,
            "revolute" if freedom.turns else "prismatic",
            frames[0],
            frames[1],
            stage.place,
            freedom.limits,
            friction=stage.authored(prim, "physxJoint:jointFriction") or 0.0,  # UsdPhysics has no joint friction
            friction_force=force or None,
            armature=armature * stage.frames.kilograms * (metres**2 if freedom.turns else 1.0) or None,
            velocity=speed * unit if speed is not None and 0 < speed < NO_SPEED_LIMIT else None,
            qpos=0.0 if abs(start) < _SMALL and low <= 0 <= high else start,
            drive=freedom.drive,
        )
        if words := lost_resistance(made):
            stage.lose("joint-friction", words, prim)
        return made

    def _with_mimics(self, links: Sequence[DescribedLink], prims: Mapping[int, Prim]) -> list[DescribedLink]:
        """Returns links whose joints follow others. `prims`: number of a link on one freedom → prim of its joint."""
        joints = {str(prim.GetPath()): joint for number, prim in prims.items() if (joint := links[number].joint)}
        found = [*links]
        for number, prim in prims.items():
            joint = joints[str(prim.GetPath())]
            found[number] = replace(links[number], joint=replace(joint, mimic=self._mimic(prim, joint, joints)))
        return found

    def _mimic(self, prim: Prim, joint: DescribedJoint, joints: Mapping[str, DescribedJoint]) -> DescribedMimic | None:
        """Returns what the `PhysxMimicJointAPI` of a joint says: position + gearing · reference + offset = 0.

        `joints`: prim path → joint, those of one freedom in the same tree.
        """
        schemas = map(str, prim.GetPrimTypeInfo().GetAppliedAPISchemas())
        instance = next((each.removeprefix(_MIMIC) for each in schemas if each.startswith(_MIMIC)), None)
        if instance is None:
            return None
        stage, attributes = self._stage, f"physxMimicJoint:{instance}:"
        reference = prim.GetRelationship(f"{attributes}referenceJoint")
        targets = reference.GetTargets() if reference else ()
        source = joints.get(str(targets[0])) if targets else None
        gearing, offset = (stage.authored(prim, attributes + name) for name in ("gearing", "offset"))
        gearing, offset = 1.0 if gearing is None else float(gearing), float(offset or 0.0)
        if source is None or source is joint or not (math.isfinite(offset) and math.isfinite(gearing) and gearing):
            return None
        self.mimics.add(str(prim.GetPath()))
        own, other = (stage.frames.metres if each.type == "prismatic" else math.radians(1) for each in (joint, source))
        return DescribedMimic(source.name, -gearing * own / other, -offset * own, stage.place)

    def _friction_force(self, prim: Prim, freedom: Freedom) -> float:
        """Returns the friction that does not depend on the load [N, N·m]; 0 if there is none."""
        frames = self._stage.frames
        names = [f"physxJointAxis:{axis}:dynamicFrictionEffort" for axis in (freedom.name, _AXIS_WORDS[freedom.turns])]
        found = [self._stage.authored(prim, name) for name in (*names, "mjc:frictionloss")]
        force = next((float(each) for each in found if each and math.isfinite(each)), 0.0)
        return max(force, 0.0) * frames.kilograms * (frames.metres**2 if freedom.turns else frames.metres)


_AXIS_WORDS: Final = {True: "angular", False: "linear"}
"""Names of PhysX's schema for the axes of a joint of one freedom, by whether it turns."""
