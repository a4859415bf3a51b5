"""URDF joints as SAPIEN's loader passes them to its builders, and the link trees that they form."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, suggest
from scenecc.geometry.rotations import Vec3, compose
from scenecc.plan.articulation import MAX_LINKS
from scenecc.robots.description import DescribedJoint, DescribedMimic, SapienJointType
from scenecc.robots.link_poses import pose_across
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
"""URDF joint type → SAPIEN joint type."""

_URDF_TYPES = (*_SAPIEN_TYPES, "floating", "planar")


@frozen
class JointElement:
    """A <joint> whose numbers are not parsed yet.

    Attributes:
        kind: URDF joint type.
    """

    name: str
    kind: str
    parent: str
    child: str
    element: SourceElement


def read_joint_element(element: SourceElement, findings: FileReport) -> JointElement | None:
    """Returns the name, type and links of a <joint>; None after an error."""
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
            "SC464", f"`{cut(kind)}` is not a joint type", element.at("type"), hint=suggest(kind, _URDF_TYPES)
        )
        return None
    if kind == "planar":
        findings.report(
            "SC464",
            "neither scenecc nor SAPIEN supports planar joints",
            element.at("type"),
            hint="use two prismatic joints and a revolute one, with light links between them",
        )
        return None
    if name is None or kind is None or parent is None or child is None:
        return None
    return JointElement(name, kind, parent, child, element)


def read_joint(
    row: JointElement, scale: float, findings: FileReport, repair: frozenset[str] = frozenset()
) -> DescribedJoint | None:
    """Returns the joint of an element that is not floating; None after an error.

    `repair`: with "limits", a missing limit means no limit.
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
    # A revolute joint without limits is SAPIEN's `revolute`, which URDF calls continuous.
    endless = "limits" in repair and row.kind == "revolute" and limits == _NO_LIMITS
    return DescribedJoint(
        name=row.name,
        type="revolute" if endless else _SAPIEN_TYPES[row.kind],
        pose_in_parent=compose_poses(origin, frame),
        pose_in_child=frame,
        location=element.location,
        limits=limits,
        # A force in URDF, a ratio in PhysX.
        friction=None if friction else friction,
        friction_force=friction or None,
        damping=damping,
        effort=effort,
        velocity=velocity,
        mimic=mimic,
    )


def _read_axis(row: JointElement, findings: FileReport) -> Vec3 | None:
    """Returns the unit axis; x by default."""
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
                f"the axis of joint `{cut(row.name)}` has zero length: x is used, as in SAPIEN",
                element.at("xyz"),
                hint="write the axis, `1 0 0` for x",
            )
        return (1.0, 0.0, 0.0)
    # Normalized twice, as SAPIEN's loader and its URDF parser do; this may change the last bit.
    axis = axis / np.linalg.norm(axis)
    axis = axis / np.linalg.norm(axis)
    return (float(axis[0]), float(axis[1]), float(axis[2]))


_NO_LIMITS = (-math.inf, math.inf)

_LIMITS_REPAIR = "`repair: [limits]` in the scene for no limit"


def _read_limits(
    row: JointElement, scale: float, findings: FileReport, repair: frozenset[str]
) -> tuple[float, float] | None:
    if row.kind not in {"revolute", "prismatic"}:
        return None if row.kind == "fixed" else _NO_LIMITS
    element = row.element.find("limit")
    if element is None:
        message = f"the {row.kind} joint `{cut(row.name)}` has no <limit>"
        if "limits" in repair:
            findings.report("SC488", f"{message}: it has no limits", row.element.location)
            return _NO_LIMITS
        turns = "; a joint without limits is `continuous`" if row.kind == "revolute" else ""
        hint = f"write <limit lower=… upper=…/>{turns}; or set {_LIMITS_REPAIR}"
        findings.report("SC465", message, row.element.location, hint=hint)
        return None
    low, high = (_read_limit(row, element, end, findings, repair) for end in ("lower", "upper"))
    if low is not None and high is not None and (low > high or math.inf in {low, -high}):
        message = (
            f"the lower limit {low:g} is above the upper {high:g}"
            if low > high
            else "the limits exclude every position"
        )
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
    """Returns one end of a <limit>; None after an error."""
    if end in element.attributes:
        return read_number_attribute(element, end, findings, infinite=True)
    if "limits" in repair:
        message = f"<limit> of joint `{cut(row.name)}` has no `{end}`: no limit on that side"
        findings.report("SC488", message, element.location)
        return -math.inf if end == "lower" else math.inf
    hint = f"write it, or set {_LIMITS_REPAIR}"
    findings.report("SC465", f"<limit> has no `{end}`, which SAPIEN requires", element.location, hint=hint)
    return None


def _read_dynamics(element: SourceElement, findings: FileReport) -> tuple[float | None, float]:
    """Returns friction (None if not given) and damping."""
    dynamics = element.find("dynamics")
    if dynamics is None:
        return None, 0.0
    read: list[float | None] = []
    for name in ("friction", "damping"):
        value, _ = read_optional_number(dynamics, name, findings)
        if value is not None and value < 0:
            findings.report("SC466", f"the {name} is {value:g}, but cannot be negative", dynamics.at(name))
        read.append(value)
    return read[0], read[1] or 0.0


def _read_actuator(row: JointElement, scale: float, findings: FileReport) -> tuple[float | None, float | None]:
    """Returns effort and velocity limits; None if not given or 0, which many files write for "unknown".

    The velocity of a prismatic joint is in m/s and is scaled; effort is not scaled.
    """
    limit = row.element.find("limit")
    if limit is None:
        return None, None
    values = [read_optional_number(limit, name, findings, infinite=True)[0] for name in ("effort", "velocity")]
    for name, value in zip(("effort", "velocity"), values, strict=True):
        if value is not None and value < 0:
            message = f"the {name} is {value:g}, but a limit cannot be negative: it is ignored"
            findings.report_once("SC487", name, message, limit.at(name), "write the actuator's limit, or remove it")
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
            "the multiplier of <mimic> is 0, so the joint never moves",
            mimic.at("multiplier"),
            hint="make the joint fixed",
        )
        return None
    return DescribedMimic(source, multiplier, 0.0 if offset is None else offset, mimic.at("joint"))


_MAX_LISTED_LINKS = 5


@frozen
class LinkTree:
    """A tree of links, parents before children.

    Attributes:
        links: link names.
        joints: each link's joint to its parent; for the root, None or its floating joint.
    """

    links: tuple[str, ...]
    joints: tuple[JointElement | None, ...]


def build_link_trees(
    links: dict[str, SourceElement], rows: Sequence[JointElement], findings: FileReport
) -> tuple[LinkTree, ...] | None:
    """Returns the link trees of a file: the root's, then one for each floating joint.

    Args:
        links: by name, in file order.
        rows: joints with distinct names, in file order.
        findings: receives the errors: missing links (SC461), links with two parents (SC462), no single root or a cycle
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
                f"the floating joint `{cut(row.name)}` has the parent `{cut(row.parent)}`, which is not the root",
                row.element.at("type"),
                hint=f"make the root `{cut(roots[0])}` its parent: its child then becomes a separate robot",
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
            f"the {tag} of joint `{cut(row.name)}` is `{cut(name)}`, but there is no such link",
            end.at("link"),
            hint=findings.near(name, links),
        )
    if is_good and row.parent == row.child:
        findings.report("SC461", f"joint `{cut(row.name)}` connects `{cut(row.child)}` to itself", row.element.location)
        return False
    return is_good


def _report_two_parents(row: JointElement, first: JointElement, findings: FileReport) -> None:
    findings.report(
        "SC462",
        f"the link `{cut(row.child)}` is the child of two joints, `{cut(first.name)}` and `{cut(row.name)}`",
        row.element.location,
        hint="a link has one parent; close loops with a constraint in the scene",
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
            f"{len(roots)} links have no parent, but a robot has one root: {shown}{more}",
            links[roots[1]].location,
            hint="connect them with joints (fixed, or floating at the root), or split them into several files",
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
            f"links form a cycle: {shown} → `{cut(circle[0])}`",
            above[circle[0]].element.location,
            hint="close loops with a constraint in the scene",
        )
    return len(roots) == 1 and not circle


def _find_cycle(links: Iterable[str], above: dict[str, JointElement]) -> list[str]:
    """Returns the links of a cycle from parent to child; empty if there is no cycle."""
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
    """Collects the tree depth first, with children in file order."""
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
    """Returns the joints by name, without mimics from or to fixed joints (SC489).

    A fixed joint does not move. A joint that mimics a fixed joint stays at its offset.
    """
    made = dict(joints)
    for name, joint in joints.items():
        mimic = joint.mimic
        source = None if mimic is None else joints.get(mimic.source)
        if mimic is None or source is None or "fixed" not in {joint.type, source.type}:
            continue
        if joint.type == "fixed":
            message = f"joint `{cut(name)}` is fixed, so its <mimic> is ignored"
            made[name] = replace(joint, mimic=None)
        else:
            message = (
                f"joint `{cut(name)}` mimics `{cut(mimic.source)}`, which is fixed, so it stays at {mimic.offset:g}"
            )
            kind: SapienJointType = "prismatic" if joint.type == "prismatic" else "revolute_unwrapped"
            made[name] = replace(joint, type=kind, limits=(mimic.offset, mimic.offset), mimic=None)
        findings.report("SC489", message, mimic.location, hint="remove <mimic>, or make both joints movable")
    return made


def check_mimics(joints: Sequence[DescribedJoint], findings: FileReport) -> None:
    """Reports invalid mimics of one robot (SC472)."""
    named = {joint.name: joint for joint in joints}
    for joint in joints:
        mimic = joint.mimic
        if mimic is None:
            continue
        source = named.get(mimic.source)
        if source is None:
            message = f"joint `{cut(joint.name)}` mimics `{cut(mimic.source)}`, but its robot has no such joint"
            findings.report("SC472", message, mimic.location, hint=findings.near(mimic.source, named))
        elif _is_cyclic(joint, named):
            message = f"joint `{cut(joint.name)}` mimics itself, through `{cut(mimic.source)}`"
            findings.report("SC472", message, mimic.location, hint="remove one of the <mimic> elements")


def scale_mimics(joints: Mapping[str, DescribedJoint], scale: float) -> dict[str, DescribedJoint]:
    """Returns the joints by name, with mimics scaled like the lengths of the file.

    Positions of prismatic joints are lengths, so their offsets are scaled. A multiplier between a prismatic and a
    revolute joint is scaled too.
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
    """A link tree in which no fixed joint lies between a joint and the joint that it mimics.

    Attributes:
        parents: parent of each link except the root, by name.
        joints: by name.
        moved: links with a new parent → their parent in the file.
    """

    parents: Mapping[str, str]
    joints: Mapping[str, DescribedJoint]
    moved: Mapping[str, str]


def move_over_fixed_joints(tree: LinkTree, joints: Mapping[str, DescribedJoint], findings: FileReport) -> MimicTree:
    """Moves a link to the link that its parent is fixed to, if a mimic needs it (SC489).

    A PhysX tendon cannot cross a fixed joint. Fixed links move as one body, so every link keeps its pose.
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
                pose = compose(pose_across(fixed), pose)
                parent = parents[parent]
            if parent == parents[name]:
                continue
            moved[name], parents[name] = parents[name], parent
            made[joint.name] = replace(joint, pose_in_parent=pose)
            message = (
                f"a fixed joint lies between `{cut(row.name)}` and `{cut(mimic.source)}`, which it mimics: link "
                f"`{cut(name)}` becomes a child of `{cut(parent)}` instead of `{cut(moved[name])}`, at the same pose"
            )
            findings.report("SC489", message, mimic.location, hint="merge links that are fixed together")
    return MimicTree(parents, made, moved)


def _links_of_tendon(link: str, source: str, parents: Mapping[str, str]) -> list[tuple[str, str]]:
    """Returns the links between two links with their common ancestor; empty if no tendon is possible."""
    own, others = _path_to_root(link, parents), _path_to_root(source, parents)
    if link in others:
        return []
    root = next(name for name in others[1:] if name in own[1:])
    return [(name, root) for path in (others, own) for name in path[: path.index(root)]]


def _path_to_root(link: str, parents: Mapping[str, str]) -> list[str]:
    found = [link]
    while found[-1] in parents:
        found.append(parents[found[-1]])
    return found
