"""Robots and bodies of a compiled model: links, joints and masses.

Poses, masses, inertias, limits and contacts are the compiled model's. Features that PhysX lacks are reported once per
kind, at the first element that has them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE, Pose7, Vec3
from scenecc.names import UniqueNames
from scenecc.plan.properties import FLOAT32_MIN
from scenecc.robots.description import (
    DescribedInertial,
    DescribedJoint,
    DescribedLink,
    DescribedRobot,
    LinkName,
    ball_moment,
)
from scenecc.robots.mujoco.contacts import CollidingLink, find_ignore_bits
from scenecc.robots.mujoco.equalities import mocaps_with_equalities
from scenecc.robots.mujoco.joints import MjcfJointReader
from scenecc.robots.mujoco.model import FREE, WORLD, CompiledModel
from scenecc.robots.mujoco.shapes import MjcfShapeReader
from scenecc.robots.poses import compose_poses
from scenecc.robots.rules import light_link

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from scenecc.robots.mjcf_files import MjcfReport


@dataclass(slots=True)
class _Draft:
    """A link under construction.

    Attributes:
        body: index of its body in the model.
        parent: index of its parent among the robot's links.
        is_body: False for a link between a body's joints, and for an added root.
    """

    name: str
    body: int
    parent: int | None
    joint: DescribedJoint | None
    is_body: bool = True


class MjcfModelReader:
    """Describes the robots of a compiled model.

    Args:
        model: the compiled model.
        report: receives the findings.
        keyframe: index of the keyframe with the initial positions; None: no keyframe.
        visual_groups: visible geom groups.

    Attributes:
        links_of_bodies: link of each body, by body index.
    """

    def __init__(
        self, model: CompiledModel, report: MjcfReport, keyframe: int | None, visual_groups: Collection[int]
    ) -> None:
        self._model = model
        self._report = report
        self._joint_numbers = model.rows_of_bodies("jnt_bodyid")
        self._geoms = model.rows_of_bodies("geom_bodyid")
        self._joints = MjcfJointReader(model, report, keyframe)
        self._shapes = MjcfShapeReader(model, report, visual_groups)
        self._touching: dict[int, bool] = {body: bool(apart) for body, apart in model.header["touching"]}
        self._holders = mocaps_with_equalities(model)
        self.links_of_bodies: dict[int, LinkName] = {}

    def robots(self) -> list[DescribedRobot]:
        """Returns all robots and bodies: articulations first, then bodies, then the world's own geoms."""
        moving: list[tuple[DescribedRobot, list[int]]] = []
        still: list[tuple[DescribedRobot, list[int]]] = []
        for number, body in enumerate(self._model.children[WORLD]):
            if any(self._joint_numbers[one] for one in self._subtree(body)):
                moving.append(self._robot(body, number))
            elif (made := self._static_body(body)) is not None:
                still.append((made, [body]))
        for geom in self._geoms[WORLD]:
            name, place = self._model.name("geom", geom) or f"geom_{geom}", self._model.location("geom", geom)
            collisions, visuals = self._shapes.of_geoms([(geom, IDENTITY_POSE)])
            if collisions or visuals:
                link = DescribedLink(name, place, collisions=collisions, visuals=visuals)
                still.append((DescribedRobot((link,), "static", location=place), [WORLD]))
        made = [*moving, *still]
        self._report_gravity()
        robots = self._rename_duplicates(self._with_ignore_bits(made))
        for robot, (_, bodies) in zip(robots, made, strict=True):
            root = robot.links[0].name
            for link, body in zip(robot.links, bodies, strict=True):
                if body > WORLD:
                    self.links_of_bodies[body] = root, link.name
            # An added root of a fixed robot has the world's pose.
            if bodies[0] < WORLD:
                self.links_of_bodies.setdefault(WORLD, (root, root))
        return robots

    def _subtree(self, body: int) -> Iterator[int]:
        pending = [body]
        while pending:
            one = pending.pop()
            yield one
            pending.extend(reversed(self._model.children[one]))

    def _robot(self, body: int, number: int) -> tuple[DescribedRobot, list[int]]:
        """Returns the articulation of a top-level body, and the body of each link."""
        model = self._model
        joints = self._joint_numbers[body]
        free = bool(joints) and model["jnt_type"][joints[0]] == FREE
        if free or not joints:
            drafts, pose = [_Draft(model.body_name(body), body, None, None)], model.body_pose(body)
            for child in model.children[body]:
                self._add_links(child, 0, drafts)
        else:
            root = model.free_name(f"dummy_root_{number}")
            drafts, pose = [_Draft(root, WORLD, None, None, is_body=False)], IDENTITY_POSE
            self._add_links(body, 0, drafts)
        links = tuple(self._describe(draft) for draft in self._without_invalid_mimics(drafts))
        kind = "dynamic" if free and len(links) == 1 else None
        if model["body_mocapid"][body] >= 0:
            message = "a mocap body with joints becomes the fixed root of a robot"
            self._report.leave_out("mocap", message, model.location("body", body))
        robot = DescribedRobot(links, kind, not free, pose, model.location("body", body))
        return robot, [draft.body if draft.is_body else -1 for draft in drafts]

    def _add_links(self, body: int, parent: int, drafts: list[_Draft]) -> None:
        pending = [(body, parent)]
        while pending:
            one, above = pending.pop()
            name, in_parent = self._model.body_name(one), self._model.body_pose(one)
            made = self._joints.of_body(self._joint_numbers[one])
            if not made or (len(made) == 1 and self._collides_with_parent(one, made[0])):
                # PhysX prevents contacts only between a link and its parent.
                fixed = DescribedJoint("", "fixed", IDENTITY_POSE, IDENTITY_POSE, self._model.location("body", one))
                made = [fixed, *made]
            for index, joint in enumerate(made):
                # Links between a body's joints share its pose.
                frame = compose_poses(in_parent, joint.pose_in_child) if index == 0 else joint.pose_in_child
                last = index == len(made) - 1
                whole = replace(joint, pose_in_parent=frame)
                own = name if last else self._model.free_name(f"{name}_dummy_{index}")
                drafts.append(_Draft(own, one, above, whole, is_body=last))
                above = len(drafts) - 1
            pending += [(child, above) for child in reversed(self._model.children[one])]

    def _collides_with_parent(self, body: int, joint: DescribedJoint) -> bool:
        """Returns whether contacts of a body and its parent are built; reports those that cannot be."""
        apart = self._touching.get(body)
        if apart is None or (apart and not self._joints.is_coupled(joint.name)):
            return bool(apart)
        name, parent = (cut(self._model.body_name(each)) for each in (body, self._model["body_parentid"][body]))
        why = "its joint follows another" if apart else "other shapes of them overlap"
        message = f"`{name}` and `{parent}` do not collide, as they do in MuJoCo: {why}"
        self._report.leave_out("parent", message, self._model.location("body", body))
        return False

    def _without_invalid_mimics(self, drafts: list[_Draft]) -> list[_Draft]:
        """Removes mimics that PhysX cannot build."""
        names = {draft.joint.name: number for number, draft in enumerate(drafts) if draft.joint is not None}
        for number, draft in enumerate(drafts):
            if draft.joint is None or draft.joint.mimic is None:
                continue
            source = names.get(draft.joint.mimic.source)
            if source is None or not _can_follow(drafts, source, number):
                message = (
                    f"`{cut(draft.joint.name)}` is free: it cannot mimic `{cut(draft.joint.mimic.source)}`, as they "
                    "are in two robots, a fixed joint is between them, or the first is above the second"
                )
                self._report.leave_out("coupling/follow", message, draft.joint.mimic.location)
                draft.joint = replace(draft.joint, mimic=None)
        return drafts

    def _describe(self, draft: _Draft) -> DescribedLink:
        model = self._model
        place = model.location("body", draft.body)
        mass = float(model["body_mass"][draft.body])
        if not draft.is_body or not mass:
            inertial = self._light_inertial(draft)
        else:
            com = (*model["body_ipos"][draft.body].tolist(), *model["body_iquat"][draft.body].tolist())
            inertial = DescribedInertial(mass, com, self._moments(draft.body, mass), place)
        disable_gravity = bool(model["body_gravcomp"][draft.body] == 1)
        if not draft.is_body:
            return DescribedLink(
                draft.name,
                place,
                draft.parent,
                draft.joint,
                inertial=inertial,
                disable_gravity=disable_gravity,
                is_added=True,
            )
        collisions, visuals = self._shapes.of_geoms([(geom, IDENTITY_POSE) for geom in self._geoms[draft.body]])
        return DescribedLink(
            draft.name, place, draft.parent, draft.joint, collisions, visuals, inertial, disable_gravity=disable_gravity
        )

    def _report_gravity(self) -> None:
        """Reports `gravcomp` shares other than 0 and 1, since PhysX can only switch gravity on or off."""
        partly = [body for body, share in enumerate(self._model["body_gravcomp"].tolist()) if share not in {0, 1}]
        if partly:
            message = f"`gravcomp` other than 0 and 1 is not built (there are {len(partly)})"
            self._report.leave_out("gravcomp", message, self._model.location("body", partly[0]))

    def _moments(self, body: int, mass: float) -> Vec3:
        """Returns the principal moments of a body. Moments of 0, which MuJoCo allows on a welded body, become small."""
        x, y, z = moments = self._model["body_inertia"][body].tolist()
        if min(moments) >= FLOAT32_MIN:
            return (x, y, z)
        small = min([ball_moment(mass), *(moment for moment in moments if moment >= FLOAT32_MIN)])
        x, y, z = (max(moment, small) for moment in moments)
        place = self._model.location("body", body)
        message = f"a moment of inertia of `{cut(self._model.body_name(body))}` is 0: {small:.3g} kg·m² is built"
        self._report.losses.append(("inertia", message, place))
        self._report.of(place).report("SC580", message, place, hint="PhysX cannot represent a moment of 0")
        return (x, y, z)

    def _light_inertial(self, draft: _Draft) -> DescribedInertial | None:
        """Returns a small inertial for a link without mass; None for a fixed root, where it has no effect."""
        if draft.parent is None and draft.body == WORLD:
            return None
        model = self._model
        mass, moment = (float(model[name][draft.body].max()) for name in ("body_mass", "body_inertia"))
        place = model.location("body", draft.body)
        if not mass:
            below = max((float(model["body_mass"][child]) for child in model.children[draft.body]), default=0.0)
            return light_link(below or float(model["body_subtreemass"][draft.body]), None, place)
        return light_link(mass, moment or None, place)

    def _static_body(self, body: int) -> DescribedRobot | None:
        """Returns a top-level body without joints, with its descendants; None if it has no shapes and holds nothing."""
        model = self._model
        geoms: list[tuple[int, Pose7]] = []
        pending = [(body, IDENTITY_POSE)]
        while pending:
            one, pose = pending.pop()
            geoms += [(geom, pose) for geom in self._geoms[one]]
            pending += [(child, compose_poses(pose, model.body_pose(child))) for child in reversed(model.children[one])]
        collisions, visuals = self._shapes.of_geoms(geoms)
        if not (collisions or visuals or body in self._holders):
            return None
        place = model.location("body", body)
        link = DescribedLink(model.body_name(body), place, collisions=collisions, visuals=visuals)
        kind = "kinematic" if model["body_mocapid"][body] >= 0 else "static"
        return DescribedRobot((link,), kind, pose=model.body_pose(body), location=place)

    def _with_ignore_bits(self, made: list[tuple[DescribedRobot, list[int]]]) -> list[DescribedRobot]:
        """Sets the ignore bits of the robots' links."""
        colliding: list[CollidingLink] = []
        starts: list[int] = []
        key = 0
        for index, (robot, bodies) in enumerate(made):
            starts.append(key)
            for link, body in zip(robot.links, bodies, strict=True):
                if link.collisions and body >= 0:
                    parent = None if link.parent is None else starts[-1] + link.parent
                    colliding.append(self._colliding_link(link, body, (key, index), parent))
                key += 1
        bits, alone = find_ignore_bits(colliding, self._model, self._report)
        return [
            replace(
                robot,
                links=tuple(
                    replace(link, ignore_bits=bits.get(start + number, 0)) for number, link in enumerate(robot.links)
                ),
                ignores_alone=alone,
            )
            for (robot, _), start in zip(made, starts, strict=True)
        ]

    @staticmethod
    def _colliding_link(link: DescribedLink, body: int, keys: tuple[int, int], parent: int | None) -> CollidingLink:
        contype = conaffinity = 0
        for shape in link.collisions:
            first, second = shape.bits or (0, 0)
            contype, conaffinity = contype | first >> 1, conaffinity | second >> 1
        return CollidingLink(body, *keys, parent, contype, conaffinity)

    @staticmethod
    def _rename_duplicates(robots: list[DescribedRobot]) -> list[DescribedRobot]:
        """Makes the names of the roots unique."""
        names = UniqueNames()
        made: list[DescribedRobot] = []
        for robot in robots:
            root, *others = robot.links
            made.append(replace(robot, links=(replace(root, name=names.new(root.name)), *others)))
        return made


def _can_follow(drafts: list[_Draft], source: int, follower: int) -> bool:
    """Returns whether a PhysX tendon can connect two joints, see `plan.articulation.why_no_tendon`."""

    def above(link: int) -> list[int]:
        chain = [link]
        while (parent := drafts[chain[-1]].parent) is not None:
            chain.append(parent)
        return chain

    to_source, to_follower = above(source), above(follower)
    if follower in to_source:
        return False
    common = next(link for link in to_source if link in to_follower)
    between = to_source[1 : to_source.index(common)] + to_follower[1 : to_follower.index(common)]
    return all(
        (joint := drafts[link].joint) is not None and joint.type != "fixed" for link in between if link != common
    )
