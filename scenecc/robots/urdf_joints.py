"""Joints of a URDF as SAPIEN's loader passes them to its builders, and the trees that links and joints
form. Links are in the order in which SAPIEN's loader builds them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
from scenecc.geometry.rotations import Vec3, compose, invert
from scenecc.plan.articulation import MAX_LINKS
from scenecc.robots.description import DescribedJoint, DescribedMimic, SapienJointType
from scenecc.robots.poses import axis_pose, compose_poses
from scenecc.robots.urdf_links import read_origin
from scenecc.robots.xml import (
    SourceElement,
    read_number_attribute,
    read_optional_number,
    read_text_attribute,
    read_vector3,
    warn_if_degrees,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from scenecc.robots.files import FileReport

_SAPIEN_TYPES: dict[str, SapienJointType] = {
    "fixed": "fixed",
    "revolute": "revolute_unwrapped",
    "continuous": "revolute",
    "prismatic": "prismatic",
}
"""URDF's word for a type → SAPIEN's."""

_URDF_TYPES = (*_SAPIEN_TYPES, "floating", "planar")


@frozen
class JointElement:
    """A joint of the file before its numbers are read.

    Attributes:
        kind: URDF's word for its type.
    """

    name: str
    kind: str
    parent: str
    child: str
    element: SourceElement


def read_joint_element(element: SourceElement, findings: FileReport) -> JointElement | None:
    """Name, type and links of a <joint>; None, reported, where one is missing or wrong."""
    name, kind = read_text_attribute(element, "name", findings), read_text_attribute(element, "type", findings)
    ends: list[str | None] = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None:
            findings.report("SC455", f"<joint> has no <{tag}>", element.location)
        ends.append(None if end is None else read_text_attribute(end, "link", findings))
    parent, child = ends
    if kind is not None and kind not in _URDF_TYPES:
        findings.report(
            "SC464", f"`{cut(kind)}` is no type of joint", element.at("type"), hint=suggest(kind, _URDF_TYPES)
        )
        return None
    if kind == "planar":
        findings.report(
            "SC464",
            "a planar joint is not supported, by SAPIEN neither",
            element.at("type"),
            hint="write two prismatic joints and a revolute one, with links of little mass between them",
        )
        return None
    if name is None or kind is None or parent is None or child is None:
        return None
    return JointElement(name, kind, parent, child, element)


def read_joint(
    row: JointElement, scale: float, findings: FileReport, repair: frozenset[str] = frozenset()
) -> DescribedJoint | None:
    """The joint of a row that is not floating; None, reported, where something of it is wrong.

    `repair`: with "limits", a limit that is left out is none.
    """
    before = findings.errors
    element = row.element
    origin = read_origin(element, scale, findings)
    axis = _read_axis(row, findings)
    limits = _read_limits(row, scale, findings, repair)
    friction, damping = _read_dynamics(element, findings)
    effort, velocity = _read_actuator(row, scale, findings)
    mimic = _read_mimic(element, findings)
    if origin is None or axis is None or findings.errors > before:
        return None
    frame = axis_pose(axis)
    # A joint that turns without limits is SAPIEN's `revolute`, which a file calls continuous.
    endless = "limits" in repair and row.kind == "revolute" and limits == _NO_LIMITS
    return DescribedJoint(
        name=row.name,
        type="revolute" if endless else _SAPIEN_TYPES[row.kind],
        pose_in_parent=compose_poses(origin, frame),
        pose_in_child=frame,
        location=element.location,
        limits=limits,
        friction=friction,
        damping=damping,
        effort=effort,
        velocity=velocity,
        mimic=mimic,
    )


def _read_axis(row: JointElement, findings: FileReport) -> Vec3 | None:
    """The axis, of length 1; x where there is none."""
    element = row.element.find("axis")
    if element is None:
        return (1.0, 0.0, 0.0)
    read = read_vector3(element, "xyz", findings)
    if read is None:
        return None
    axis: NDArray[np.float64] = np.array(read)
    if np.linalg.norm(axis) < 1e-4:
        if row.kind != "fixed":
            findings.report(
                "SC469",
                f"the axis of the joint `{cut(row.name)}` has no length: x is taken, as SAPIEN does",
                element.at("xyz"),
                hint="write the axis that is meant, `1 0 0` if x is",
            )
        return (1.0, 0.0, 0.0)
    # Twice, since SAPIEN's loader and what it reads with both do so, and the last bit may change.
    axis = axis / np.linalg.norm(axis)
    axis = axis / np.linalg.norm(axis)
    return (float(axis[0]), float(axis[1]), float(axis[2]))


_NO_LIMITS = (-math.inf, math.inf)

_LIMITS_REPAIR = "`repair: [limits]`: a limit that is left out is then none"


def _read_limits(
    row: JointElement, scale: float, findings: FileReport, repair: frozenset[str]
) -> tuple[float, float] | None:
    if row.kind not in {"revolute", "prismatic"}:
        return None if row.kind == "fixed" else _NO_LIMITS
    element = row.element.find("limit")
    if element is None:
        message = f"the {row.kind} joint `{cut(row.name)}` has no <limit>"
        if "limits" in repair:
            findings.report("SC488", f"{message}: it moves without limits", row.element.location)
            return _NO_LIMITS
        turns = "; a joint that turns without end is continuous" if row.kind == "revolute" else ""
        hint = f"write <limit lower=… upper=…/>{turns}; or let the scene say {_LIMITS_REPAIR}"
        findings.report("SC465", message, row.element.location, hint=hint)
        return None
    low, high = (_read_limit(row, element, end, findings, repair) for end in ("lower", "upper"))
    if low is not None and high is not None and (low > high or math.inf in {low, -high}):
        message = f"the lower limit {low:g} is above the upper {high:g}" if low > high else "the limits leave nothing"
        findings.report("SC465", message, element.at("lower"))
        low = None
    if low is None or high is None:
        return None
    if row.kind == "revolute":
        warn_if_degrees((low, high), "a limit", element.at("upper" if abs(high) >= abs(low) else "lower"), findings)
        return low, high
    return low * scale, high * scale


def _read_limit(
    row: JointElement,
    element: SourceElement,
    end: Literal["lower", "upper"],
    findings: FileReport,
    repair: frozenset[str],
) -> float | None:
    """One end of a <limit>; None, reported, where it is missing or wrong."""
    if end in element.attributes:
        return read_number_attribute(element, end, findings, infinite=True)
    if "limits" in repair:
        message = f"<limit> of the joint `{cut(row.name)}` has no `{end}`: there is no limit on that side"
        findings.report("SC488", message, element.location)
        return -math.inf if end == "lower" else math.inf
    hint = f"write it, or let the scene say {_LIMITS_REPAIR}"
    findings.report("SC465", f"<limit> has no `{end}`, which SAPIEN wants", element.location, hint=hint)
    return None


def _read_dynamics(element: SourceElement, findings: FileReport) -> tuple[float | None, float]:
    """Friction, None where there is none, and damping."""
    dynamics = element.find("dynamics")
    if dynamics is None:
        return None, 0.0
    read: list[float | None] = []
    for name in ("friction", "damping"):
        value, _ = read_optional_number(dynamics, name, findings)
        if value is not None and value < 0:
            findings.report("SC466", f"the {name} is {value:g}, which is below 0", dynamics.at(name))
        read.append(value)
    return read[0], read[1] or 0.0


def _read_actuator(row: JointElement, scale: float, findings: FileReport) -> tuple[float | None, float | None]:
    """Effort and velocity; None where there is none, or none above 0, as many files have it that know of none.

    A velocity of a prismatic joint is a length [m/s]. An effort is a force, which no scale of lengths says anything of.
    """
    limit = row.element.find("limit")
    if limit is None:
        return None, None
    values = [read_optional_number(limit, name, findings, infinite=True)[0] for name in ("effort", "velocity")]
    for name, value in zip(("effort", "velocity"), values, strict=True):
        if value is not None and value < 0:
            message = f"the {name} is {value:g}, which limits nothing: none is taken"
            findings.report_once(
                "SC487", name, message, limit.at(name), "write what the actuator can do, or leave it out"
            )
    effort, velocity = (value if value is not None and 0 < value < math.inf else None for value in values)
    return effort, velocity * scale if velocity is not None and row.kind == "prismatic" else velocity


def _read_mimic(element: SourceElement, findings: FileReport) -> DescribedMimic | None:
    mimic = element.find("mimic")
    if mimic is None:
        return None
    source = read_text_attribute(mimic, "joint", findings)
    multiplier, is_read = read_optional_number(mimic, "multiplier", findings)
    offset, is_offset_read = read_optional_number(mimic, "offset", findings)
    if source is None or not (is_read and is_offset_read):
        return None
    multiplier = 1.0 if multiplier is None else multiplier
    if multiplier == 0:
        findings.report(
            "SC472",
            "the multiplier of <mimic> is 0: the joint follows nothing",
            mimic.at("multiplier"),
            hint="make the joint a fixed one",
        )
        return None
    return DescribedMimic(source, multiplier, 0.0 if offset is None else offset, mimic.at("joint"))


_MAX_LISTED_LINKS = 5


@frozen
class LinkTree:
    """A tree of links, the root first, each after its parent.

    Attributes:
        links: their names.
        joints: the joint of each to its parent; of the root None, or the floating joint that it hangs on.
    """

    links: tuple[str, ...]
    joints: tuple[JointElement | None, ...]


def build_link_trees(
    links: dict[str, SourceElement], rows: Sequence[JointElement], findings: FileReport
) -> tuple[LinkTree, ...] | None:
    """The trees of a file: the one of the root, then one for each floating joint.

    Args:
        links: by name, in the order of the file.
        rows: joints of different names, in the order of the file.
        findings: takes the errors: missing links (SC461), links with two parents (SC462), no single root or a cycle
            (SC463), floating joints not at the root (SC464).
    """
    wrong = [row for row in rows if not _check_joint_ends(row, links, findings)]
    if wrong:
        return None
    above: dict[str, JointElement] = {}
    children: dict[str, list[JointElement]] = {name: [] for name in links}
    is_tree = True
    for row in rows:
        first = above.setdefault(row.child, row)
        if first is not row:
            is_tree = False
            _report_two_parents(row, first, findings)
            continue
        children[row.parent].append(row)
    roots = [name for name in links if name not in above]
    if not is_tree or not _check_single_root(roots, links, above, findings):
        return None
    floating = [row for row in rows if row.kind == "floating"]
    for row in floating:
        if row.parent != roots[0]:
            is_tree = False
            findings.report(
                "SC464",
                f"the floating joint `{cut(row.name)}` hangs on `{cut(row.parent)}`, which is not the root",
                row.element.at("type"),
                hint=f"let it hang on the root `{cut(roots[0])}`: what it carries is then a robot of its own",
            )
    if not is_tree:
        return None
    return (_build_tree(roots[0], None, children), *(_build_tree(row.child, row, children) for row in floating))


def _check_joint_ends(row: JointElement, links: dict[str, SourceElement], findings: FileReport) -> bool:
    is_good = True
    for tag, name in (("parent", row.parent), ("child", row.child)):
        end = row.element.find(tag)
        if name in links or end is None:
            continue
        is_good = False
        findings.report(
            "SC461",
            f"the joint `{cut(row.name)}` has the {tag} `{cut(name)}`, and there is no such link",
            end.at("link"),
            hint=findings.near(name, links),
        )
    if is_good and row.parent == row.child:
        findings.report(
            "SC461", f"the joint `{cut(row.name)}` leads from `{cut(row.child)}` to itself", row.element.location
        )
        return False
    return is_good


def _report_two_parents(row: JointElement, first: JointElement, findings: FileReport) -> None:
    findings.report(
        "SC462",
        f"the link `{cut(row.child)}` is the child of two joints, `{cut(first.name)}` and `{cut(row.name)}`",
        row.element.location,
        hint="a link has one parent; a loop is closed by a constraint of the scene",
        related=[("the first is here", first.element.location, "value")],
    )


def _check_single_root(
    roots: list[str], links: dict[str, SourceElement], above: dict[str, JointElement], findings: FileReport
) -> bool:
    if len(roots) > 1:
        shown = ", ".join(f"`{cut(name)}`" for name in roots[:_MAX_LISTED_LINKS])
        more = f" and {len(roots) - _MAX_LISTED_LINKS} more" if len(roots) > _MAX_LISTED_LINKS else ""
        findings.report(
            "SC463",
            f"{len(roots)} links are children of no joint, and a robot has one root: {shown}{more}",
            links[roots[1]].location,
            hint="connect them with joints, a fixed one or, at the root, a floating one; or part them into files",
            related=[("the first is here", links[roots[0]].location, "value")],
        )
    circle = _find_cycle(links, above)
    if circle:
        shown = " → ".join(
            f"`{cut(name)}`"
            for name in [*circle[:_MAX_LISTED_LINKS], *(["…"] if len(circle) > _MAX_LISTED_LINKS else [])]
        )
        findings.report(
            "SC463",
            f"links hang on one another in a circle: {shown} → `{cut(circle[0])}`",
            above[circle[0]].element.location,
            hint="a loop is closed by a constraint of the scene",
        )
    return len(roots) == 1 and not circle


def _find_cycle(links: Iterable[str], above: dict[str, JointElement]) -> list[str]:
    """Links that hang on one another in a circle, from parent to child; none where there is none."""
    settled: set[str] = set()
    for start in links:
        path: dict[str, None] = {}
        name = start
        while name in above and name not in settled and name not in path:
            path[name] = None
            name = above[name].parent
        if name in path:
            names = list(path)
            circle = names[names.index(name) :][::-1]
            first = circle.index(start) if start in circle else 0
            return circle[first:] + circle[:first]
        settled.update(path)
    return []


def _build_tree(root: str, floating: JointElement | None, children: dict[str, list[JointElement]]) -> LinkTree:
    """Depth first, the children of a link in the order of the file."""
    links: list[str] = []
    joints: list[JointElement | None] = []
    stack: list[tuple[str, JointElement | None]] = [(root, floating)]
    while stack:
        name, row = stack.pop()
        links.append(name)
        joints.append(row)
        stack.extend((below.child, below) for below in reversed(children[name]) if below.kind != "floating")
    return LinkTree(tuple(links), tuple(joints))


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
