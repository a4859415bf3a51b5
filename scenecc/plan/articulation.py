"""Articulations: links in a tree, their joints, and tendons. None: the file omits the field."""

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


BRAKE_DAMPING = 1e9
"""Damping of a drive that brakes [N·s/m, N·m·s/rad], see `friction_force`. Exact in single precision. A load of 1 kN
creeps by 1e-6 m/s."""

LIGHT_DAMPING = 0.1
"""Ratio of damping to friction force up to which a joint that has both gets the friction: a tenth of the force at 1 m/s
or 1 rad/s is lost."""


def unbuilt_resistance(force: float, damping: float, *, is_driven: bool) -> Literal["", "friction", "damping"]:
    """Which of a joint's friction force [N, N·m] and damping is not built, since PhysX has one drive for each joint.

    A spring or an actuator (`is_driven`) replaces the friction, and so does a damping that is not light.
    """
    if not force:
        return ""
    if is_driven or damping > LIGHT_DAMPING * force:
        return "friction"
    return "damping" if damping else ""


class TendonPull(NamedTuple):
    """Coefficients of the two joints, and the rest length of the tendon."""

    source: float
    joint: float
    rest_length: float


def tendon_pull(multiplier: float, offset: float) -> TendonPull:
    """The tendon whose rest length gives joint = multiplier · source + offset."""
    if abs(multiplier) <= 1:
        return TendonPull(-multiplier, 1.0, offset)
    return TendonPull(-1.0, 1 / multiplier, offset / multiplier)


def why_no_tendon(structure: ArticulationStructure, mimic: Mimic) -> str | None:
    """Why PhysX cannot make one joint follow the other; None if it can."""
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
    """Numbers of the links along the tendon of a mimic, the common ancestor first.

    Raises:
        ValueError: PhysX does not support it; the message names the joint and the reason.
    """
    why = why_no_tendon(structure, mimic)
    if why is not None:
        raise ValueError(f"joint '{mimic.joint}' cannot follow '{mimic.source}': {why}")
    return _links_between(structure, _child_link(structure, mimic.source), _child_link(structure, mimic.joint))


def tendon_coefficients(
    structure: ArticulationStructure, mimic: Mimic, links: tuple[int, ...], ends: TendonPull
) -> list[float]:
    """One coefficient per link of `tendon_links`. It is 0 for the first and for those between the two joints."""
    source, joint = _child_link(structure, mimic.source), _child_link(structure, mimic.joint)
    return [ends.source if link == source else ends.joint if link == joint else 0.0 for link in links]


def is_sibling_tendon(links: tuple[int, ...], structure: ArticulationStructure) -> bool:
    """Whether both joints of a tendon over these links hang on the same link."""
    return all(structure.links[number].parent == links[0] for number in links[1:])


def soft_mimics(structure: ArticulationStructure) -> list[Mimic]:
    """Mimics whose joints hang on different links: the reaction of their tendons has to be moved."""
    possible = [mimic for mimic in structure.mimics if why_no_tendon(structure, mimic) is None]
    return [mimic for mimic in possible if not is_sibling_tendon(tendon_links(structure, mimic), structure)]


def _links_between(structure: ArticulationStructure, source: int, joint: int) -> tuple[int, ...]:
    """The path from the nearest common ancestor to one link, then to the other."""
    above_source, above_joint = _ancestors(structure, source), _ancestors(structure, joint)
    root = next(link for link in above_source[1:] if link in above_joint[1:])
    found = [root]
    for path in (above_source, above_joint):
        found += [link for link in reversed(path[: path.index(root)]) if link not in found]
    return tuple(found)


def _child_link(structure: ArticulationStructure, name: str) -> int:
    return next(n for n, link in enumerate(structure.links) if link.joint is not None and link.joint.name == name)


def _ancestors(structure: ArticulationStructure, link: int) -> list[int]:
    """A link and its ancestors up to the root."""
    found = [link]
    while (parent := structure.links[found[-1]].parent) is not None:
        found.append(parent)
    return found


JointType = Literal["fixed", "revolute", "revolute_unwrapped", "prismatic"]
"""SAPIEN's joint types. A URDF's `continuous` joint is a `revolute` without limits, as in SAPIEN's loader, unless
it must count turns."""

DriveMode = Literal["force", "acceleration"]

UNLIMITED_VELOCITY = 1e6
"""[rad/s, m/s] SAPIEN's default is 100."""

MAX_LINKS = 255
"""Maximum for an articulation on the CPU. PhysX counts links in eight bits: 257 links have 0 degrees of freedom."""

VELOCITY_FIELDS = ("linear_velocity", "angular_velocity")
"""Velocity fields of a body or an articulation, which a reset sets again."""

JOINT_STATE_FIELDS = property_fields("joint_state")
"""Fields of a joint that a reset sets again."""


@frozen
class Joint:
    """The joint between a link and its parent. Positions are in [m] for a prismatic joint, otherwise in [rad].

    Attributes:
        type: a fixed joint has no degree of freedom, and the fields that need one are None.
        name: unique in the articulation unless "".
        pose_in_parent, pose_in_child: (·, 7) joint frame in the parent's and in the child's frame; it moves along or
            about x.
        limits: (·, 2) lowest and highest position; infinite on a side without a limit.
        friction, armature, max_velocity: (·,).
        stiffness, damping, force_limit: (·,) of the drive. Damping alone gives a drive of stiffness 0.
        drive_mode: "force" or "acceleration"; None: "force".
        qpos, qvel: (·,) initial.
        drive_target, drive_velocity_target: (·,) initial targets of the drive.
        limits_origin: origin of the limits, if they have their own.
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


def friction_force(joint: Joint) -> Value | None:
    """Friction of a joint that does not depend on its load, (·,) [N, N·m]; None: it has none.

    PhysX's joint friction is a ratio. A drive without stiffness whose damping reaches its force limit at any speed
    gives Coulomb friction: up to the limit it holds the joint, and beyond it opposes the motion with the limit.
    """
    damping = joint.damping
    if joint.stiffness is not None or damping is None or not damping.is_constant:
        return None
    return joint.force_limit if damping.numbers() == (BRAKE_DAMPING,) else None


@frozen
class Link:
    """One body of an articulation.

    Attributes:
        name: unique in the articulation.
        body: of type "link". Its velocities, locked axes, solver iterations and sleep threshold are None: the
            articulation has them, or nothing does.
        parent: number of the parent link, which comes before it; None: it is the root.
        joint: to the parent; None only for the root.
        file: (·,) index into `ScenePlan.files` of this link's description, in an articulation of several files.
    """

    name: str
    body: BodyStructure
    parent: int | None = None
    joint: Joint | None = None
    file: Value | None = None


@frozen
class Mimic:
    """A joint that follows another: its position is multiplier · (the other's) + offset.

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
    """Links in a tree, and the settings of the whole articulation.

    Attributes:
        links: in build order, the root first.
        fix_root_link: whether the root is fixed to the world.
        mimics: joints that follow others.
        solver_position_iterations, solver_velocity_iterations: (·,) integers.
        sleep_threshold: (·,) [m²/s²].
        linear_velocity, angular_velocity: (·, 3) initial, of a free root, world frame [m/s, rad/s].
        file: index into `ScenePlan.files` of its description; None: it is written in the scene, or each link has a
            file.
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
        """The bodies of its links, in build order."""
        return tuple(link.body for link in self.links)

    @property
    def description_files(self) -> tuple[Value, ...]:
        """Indices into `ScenePlan.files` of its descriptions, with repetitions."""
        return tuple(file for file in (self.file, *(link.file for link in self.links)) if file is not None)

    @property
    def active_joints(self) -> tuple[Joint, ...]:
        """The joints that move, in build order of their links (SAPIEN's own order may differ)."""
        return tuple(link.joint for link in self.links if link.joint is not None and link.joint.type != "fixed")


def breadth_first_order(parents: Iterable[int | None]) -> list[int]:
    """Link numbers in the engine's order, which also numbers the joints: by depth, then in build order.

    Args:
        parents: number of each link's parent; the first link is the root.
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
