"""Mimic joints of a URDF: those that cannot move, cycles, the file's scale, and fixed joints between the two joints."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import compose, invert
from scenecc.plan.articulation import MAX_LINKS

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.robots.description import DescribedJoint, SapienJointType
    from scenecc.robots.files import FileReport
    from scenecc.robots.urdf_joints import LinkTree


def resolve_fixed_mimics(joints: Mapping[str, DescribedJoint], findings: FileReport) -> dict[str, DescribedJoint]:
    """Joints by name, without mimics that name a fixed joint, which is told (SC489).

    A fixed joint does not move, whatever it is to follow. One that follows a fixed joint stays where its offset puts
    it.
    """
    made = dict(joints)
    for name, joint in joints.items():
        mimic = joint.mimic
        source = None if mimic is None else joints.get(mimic.source)
        if mimic is None or source is None or "fixed" not in {joint.type, source.type}:
            continue
        if joint.type == "fixed":
            message = f"the joint `{cut(name)}` is fixed and follows nothing"
            made[name] = replace(joint, mimic=None)
        else:
            message = (
                f"the joint `{cut(name)}` follows `{cut(mimic.source)}`, which is fixed, and stays at {mimic.offset:g}"
            )
            kind: SapienJointType = "prismatic" if joint.type == "prismatic" else "revolute_unwrapped"
            made[name] = replace(joint, type=kind, limits=(mimic.offset, mimic.offset), mimic=None)
        findings.report("SC489", message, mimic.location, hint="take <mimic> away, or make both joints move")
    return made


def check_mimics(joints: Sequence[DescribedJoint], findings: FileReport) -> None:
    """Reports joints of one robot that follow what they cannot: SC472."""
    named = {joint.name: joint for joint in joints}
    for joint in joints:
        mimic = joint.mimic
        if mimic is None:
            continue
        source = named.get(mimic.source)
        if source is None:
            message = f"the joint `{cut(joint.name)}` follows `{cut(mimic.source)}`, and its robot has no such joint"
            findings.report("SC472", message, mimic.location, hint=findings.near(mimic.source, named))
        elif _is_cyclic(joint, named):
            message = f"the joint `{cut(joint.name)}` follows itself, by way of `{cut(mimic.source)}`"
            findings.report("SC472", message, mimic.location, hint="let one of them follow none")


def scale_mimics(joints: Mapping[str, DescribedJoint], scale: float) -> dict[str, DescribedJoint]:
    """Joints by name, with mimics that are scaled like the lengths of the file.

    Positions of prismatic joints are lengths: so is the offset of one, and a multiplier between one and a joint that
    turns is a length to an angle.
    """
    made = dict(joints)
    for name, joint in joints.items():
        mimic = joint.mimic
        source = None if mimic is None else joints.get(mimic.source)
        if mimic is None or source is None or scale == 1:
            continue
        own = scale if joint.type == "prismatic" else 1.0
        others = scale if source.type == "prismatic" else 1.0
        multiplier = mimic.multiplier if own == others else mimic.multiplier * own / others
        made[name] = replace(joint, mimic=replace(mimic, multiplier=multiplier, offset=mimic.offset * own))
    return made


def _is_cyclic(joint: DescribedJoint, named: dict[str, DescribedJoint]) -> bool:
    at: DescribedJoint | None = joint
    for _ in named:
        at = None if at is None or at.mimic is None else named.get(at.mimic.source)
        if at is joint:
            return True
    return False


@frozen
class MimicTree:
    """A tree of links in which no fixed joint lies between a joint and the one that it follows.

    Attributes:
        parents: of each link but the root, by name.
        joints: by name.
        moved: links that hang on another link than in the file → their parents in the file.
    """

    parents: Mapping[str, str]
    joints: Mapping[str, DescribedJoint]
    moved: Mapping[str, str]


def move_over_fixed_joints(tree: LinkTree, joints: Mapping[str, DescribedJoint], findings: FileReport) -> MimicTree:
    """Hangs a link on the link that its parent is fixed to, where a mimic needs it, which is told (SC489).

    A PhysX tendon does not run over a fixed joint. Links that are fixed to one another are one body, so that every
    link keeps its pose.
    """
    rows = {name: row for name, row in zip(tree.links[1:], tree.joints[1:], strict=True) if row is not None}
    parents = {name: row.parent for name, row in rows.items()}
    children = {row.name: name for name, row in rows.items()}
    made, moved = dict(joints), dict[str, str]()
    for link, row in rows.items() if len(tree.links) <= MAX_LINKS else ():
        mimic = made[row.name].mimic
        if mimic is None or mimic.source not in children:
            continue
        for name, root in _links_of_tendon(link, children[mimic.source], parents):
            joint, parent = made[rows[name].name], parents[name]
            pose = joint.pose_in_parent
            while joint.type != "fixed" and parent != root and (fixed := made[rows[parent].name]).type == "fixed":
                pose = compose(compose(fixed.pose_in_parent, invert(fixed.pose_in_child)), pose)
                parent = parents[parent]
            if parent == parents[name]:
                continue
            moved[name], parents[name] = parents[name], parent
            made[joint.name] = replace(joint, pose_in_parent=pose)
            message = (
                f"a fixed joint lies between `{cut(row.name)}` and `{cut(mimic.source)}`, which it follows: the link "
                f"`{cut(name)}` hangs on `{cut(parent)}` in place of `{cut(moved[name])}`, at the same pose"
            )
            findings.report("SC489", message, mimic.location, hint="make one link of links that are fixed")
    return MimicTree(parents, made, moved)


def _links_of_tendon(link: str, source: str, parents: Mapping[str, str]) -> list[tuple[str, str]]:
    """Links between two, both with them, each with the link that is above all; none where a tendon cannot be."""
    own, others = _path_to_root(link, parents), _path_to_root(source, parents)
    if link in others:
        return []
    root = next(name for name in others[1:] if name in own[1:])
    return [(name, root) for path in (others, own) for name in path[: path.index(root)]]


def _path_to_root(link: str, parents: Mapping[str, str]) -> list[str]:
    """A link, its parent, and so on to the root."""
    found = [link]
    while found[-1] in parents:
        found.append(parents[found[-1]])
    return found
