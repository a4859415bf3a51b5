"""Articulations: links in a tree, the joints between them, and tendons. None: the file leaves the field out."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from scenecc.diagnostics.frozen import frozen
from scenecc.plan.properties import property_fields

if TYPE_CHECKING:
    from collections.abc import Iterable

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.plan.body import BodyStructure
    from scenecc.plan.value import Value


TENDON_STIFFNESS = 1e5
"""SAPIEN's own [N/m, N·m/rad]. A mimicking link of a few kg hangs below 1e-3 rad off where it should be."""


class TendonPull(NamedTuple):
    """Coefficients of the two joints, and the length at which the tendon is at rest."""

    source: float
    joint: float
    rest_length: float


def tendon_pull(multiplier: float, offset: float) -> TendonPull:
    """What makes joint = multiplier · source + offset the length at rest."""
    if abs(multiplier) <= 1:
        return TendonPull(-multiplier, 1.0, offset)
    return TendonPull(-1.0, 1 / multiplier, offset / multiplier)


def why_no_tendon(structure: ArticulationStructure, mimic: Mimic) -> str | None:
    """Why PhysX cannot have one joint follow the other; None where it can."""
    numbers = {link.joint.name: n for n, link in enumerate(structure.links) if link.joint is not None}
    for name in (mimic.joint, mimic.source):
        if name not in numbers:
            return f"there is no joint '{name}'"
        joint = structure.links[numbers[name]].joint
        if joint is not None and joint.type == "fixed":
            return f"joint '{name}' is fixed"
    source, joint = numbers[mimic.source], numbers[mimic.joint]
    if source == joint:
        return "it is the same joint"
    if joint in _ancestors(structure, source):
        return f"'{mimic.source}' is below it in the tree, and PhysX does not converge for this"
    for number in _links_between(structure, source, joint)[1:]:
        between = structure.links[number].joint
        if between is not None and between.type == "fixed":
            name = between.name or f"of link '{structure.links[number].name}'"
            return f"the fixed joint '{name}' lies between them"
    return None


def tendon_links(structure: ArticulationStructure, mimic: Mimic) -> tuple[int, ...]:
    """Numbers of the links that the tendon of a mimic runs over, the one that it hangs on first.

    Raises:
        ValueError: PhysX cannot do it; the message says why, and of which joint.
    """
    why = why_no_tendon(structure, mimic)
    if why is not None:
        raise ValueError(f"joint '{mimic.joint}' cannot follow '{mimic.source}': {why}")
    return _links_between(structure, _child_link(structure, mimic.source), _child_link(structure, mimic.joint))


def tendon_coefficients(
    structure: ArticulationStructure, mimic: Mimic, links: tuple[int, ...], ends: TendonPull
) -> list[float]:
    """One number a link of `tendon_links`, 0 of the first and of those between."""
    source, joint = _child_link(structure, mimic.source), _child_link(structure, mimic.joint)
    return [ends.source if link == source else ends.joint if link == joint else 0.0 for link in links]


def _links_between(structure: ArticulationStructure, source: int, joint: int) -> tuple[int, ...]:
    """From the nearest link above both to the one, then to the other."""
    above_source, above_joint = _ancestors(structure, source), _ancestors(structure, joint)
    root = next(link for link in above_source[1:] if link in above_joint[1:])
    found = [root]
    for path in (above_source, above_joint):
        found += [link for link in reversed(path[: path.index(root)]) if link not in found]
    return tuple(found)


def _child_link(structure: ArticulationStructure, name: str) -> int:
    return next(n for n, link in enumerate(structure.links) if link.joint is not None and link.joint.name == name)


def _ancestors(structure: ArticulationStructure, link: int) -> list[int]:
    """A link, the one that it hangs on, and so on to the root."""
    found = [link]
    while (parent := structure.links[found[-1]].parent) is not None:
        found.append(parent)
    return found


JointType = Literal["fixed", "revolute", "revolute_unwrapped", "prismatic"]
"""SAPIEN's. A URDF's `continuous` is a `revolute` without limits, as SAPIEN's own loader has it."""

DriveMode = Literal["force", "acceleration"]

MAX_LINKS = 255
"""Of an articulation on the CPU, where PhysX counts links in eight bits: 257 of them have 0 degrees of freedom."""

VELOCITY_FIELDS = ("linear_velocity", "angular_velocity")
"""Fields of a body and of an articulation, of which a reset sets what they say anew."""

JOINT_STATE_FIELDS = property_fields("joint_state")
"""Fields of a joint, likewise."""


@frozen
class Joint:
    """The joint between a link and its parent. Positions are [m] of a prismatic one and [rad] of others.

    Attributes:
        type: of the degree of freedom, which a fixed joint has not; what only that has is None there.
        name: unique in the articulation where it is not "".
        pose_in_parent, pose_in_child: (·, 7) its frame in the parent's and in the child's; it moves along or about x.
        limits: (·, 2) lowest and highest position; infinite on a side that has none.
        friction, armature, max_velocity: (·,).
        stiffness, damping, force_limit: (·,) of the drive; a joint with damping alone has a drive of no stiffness.
        drive_mode: what the drive's numbers are of; None: "force".
        qpos, qvel: (·,) at the start.
        drive_target, drive_velocity_target: (·,) where to and how fast the drive pulls at the start.
        limits_origin: where its limits are written, where that is a place of their own.
    """

    type: JointType
    name: str = ""
    pose_in_parent: Value | None = None
    pose_in_child: Value | None = None
    limits: Value | None = None
    friction: Value | None = None
    armature: Value | None = None
    max_velocity: Value | None = None
    stiffness: Value | None = None
    damping: Value | None = None
    force_limit: Value | None = None
    drive_mode: DriveMode | None = None
    qpos: Value | None = None
    qvel: Value | None = None
    drive_target: Value | None = None
    drive_velocity_target: Value | None = None
    origin: Origin | None = field(default=None, compare=False)
    limits_origin: Origin | None = field(default=None, compare=False)


@frozen
class Link:
    """One body of an articulation.

    Attributes:
        name: unique in the articulation.
        body: of type "link". Its velocities, its locked axes, its solver's iterations and its sleep threshold are
            None: the articulation has these, or nothing has.
        parent: number of the link that it hangs on, which stands before it; None: it is the root.
        joint: to the parent; None at the root alone.
        file: (·,) index into `ScenePlan.files` of the description of this link, in an articulation of several files.
    """

    name: str
    body: BodyStructure
    parent: int | None = None
    joint: Joint | None = None
    file: Value | None = None


@frozen
class Mimic:
    """A joint that moves as another does: its position is multiplier · (the other's) + offset.

    Attributes:
        joint, source: names of the two joints, neither fixed.
        multiplier: not 0. offset: [m] or [rad].
    """

    joint: str
    source: str
    multiplier: Value
    offset: Value
    origin: Origin | None = field(default=None, compare=False)


@frozen
class ArticulationStructure:
    """Links in a tree, and what is said of all of them.

    Attributes:
        links: in the order in which they are built, the root first.
        fix_root_link: whether the root is fixed to the world.
        mimics: joints that follow others.
        solver_position_iterations, solver_velocity_iterations: (·,) integers.
        sleep_threshold: (·,) [m²/s²].
        linear_velocity, angular_velocity: (·, 3) of the root at the start, world frame [m/s, rad/s]; of a free one.
        file: index into `ScenePlan.files` of the description that it was read from; None: it is the scene's own, or the
            links say it.
    """

    links: tuple[Link, ...]
    fix_root_link: bool = False
    mimics: tuple[Mimic, ...] = ()
    solver_position_iterations: Value | None = None
    solver_velocity_iterations: Value | None = None
    sleep_threshold: Value | None = None
    linear_velocity: Value | None = None
    angular_velocity: Value | None = None
    file: Value | None = None
    origin: Origin | None = field(default=None, compare=False)

    @property
    def bodies(self) -> tuple[BodyStructure, ...]:
        """The bodies that it is made of, in build order."""
        return tuple(link.body for link in self.links)

    @property
    def description_files(self) -> tuple[Value, ...]:
        """Indices into `ScenePlan.files` of the descriptions that it was read from, some of them several times."""
        return tuple(file for file in (self.file, *(link.file for link in self.links)) if file is not None)

    @property
    def active_joints(self) -> tuple[Joint, ...]:
        """The joints that move, in build order of their links (SAPIEN's own order may be another)."""
        return tuple(link.joint for link in self.links if link.joint is not None and link.joint.type != "fixed")


def breadth_first_order(parents: Iterable[int | None]) -> list[int]:
    """Numbers of links in the engine's order, in which it numbers joints too: by distance from the root, then as built.

    Args:
        parents: of each link the number of the one that it hangs on; the first is the root.
    """
    children: dict[int, list[int]] = {}
    for number, parent in enumerate(parents):
        if parent is not None:
            children.setdefault(parent, []).append(number)
    order = [0]
    for number in order:
        order += children.get(number, ())
    return order


NON_LINK_FIELDS: Final = (
    "linear_velocity",
    "angular_velocity",
    "locked_motion_axes",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
)

MOVING_JOINT_FIELDS: Final = (
    "limits",
    *property_fields("joint", "drive"),
    "drive_mode",
    *JOINT_STATE_FIELDS,
)
