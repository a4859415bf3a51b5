"""What no field of an articulation tells alone: whether its links are a tree, and what names in it stand for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from scenecc.plan.articulation import MOST_LINKS, ArticulationStructure, Joint, Link, Mimic
from scenecc.plan.decode_numbers import Fault, shown

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

NOT_OF_A_LINK: Final = (
    "linear_velocity",
    "angular_velocity",
    "locked_motion_axes",
    "sleep_threshold",
    "solver_position_iterations",
    "solver_velocity_iterations",
)
"""Fields of a body that the articulation has in its links' place, or nothing has."""

NOT_OF_A_FIXED_JOINT: Final = (
    "limits",
    "friction",
    "armature",
    "max_velocity",
    "stiffness",
    "damping",
    "force_limit",
    "drive_mode",
    "qpos",
    "qvel",
    "drive_target",
    "drive_velocity_target",
)
"""Fields of the degree of freedom that a fixed joint has not."""


def joint_faults(read: dict[str, Any]) -> Iterator[Fault]:
    """What is wrong with the fields of a joint."""
    if read["type"] == "fixed":
        for name in NOT_OF_A_FIXED_JOINT:
            if read.get(name) is not None:
                yield Fault("SC703", f"a fixed joint has no `{name}`", (name,))


def link_faults(read: dict[str, Any]) -> Iterator[Fault]:
    """What is wrong with the fields of a link."""
    body = read["body"]
    if body.body_type != "link":
        yield Fault("SC705", f'the body of a link is of type "link", not "{body.body_type}"', ("body", "body_type"))
    for name in NOT_OF_A_LINK:
        if getattr(body, name) is not None:
            yield Fault("SC703", f"a link has no `{name}`", ("body", name))


def articulation_faults(read: dict[str, Any]) -> Iterator[Fault]:
    """What is wrong with the fields of an articulation: its links in a tree, the names of its joints."""
    links: tuple[Link, ...] = read["links"]
    if not links:
        yield Fault("SC706", "an articulation has one link at least", ("links",))
    if len(links) > MOST_LINKS:
        message = f"an articulation has {MOST_LINKS} links at most, as PhysX counts them on the CPU, not {len(links)}"
        yield Fault("SC706", message, ("links",))
    for index, link in enumerate(links):
        yield from _tree_faults(index, link)
    joints = [(index, link.joint) for index, link in enumerate(links) if link.joint is not None]
    yield from _twice("links", "name", ((index, link.name) for index, link in enumerate(links)))
    yield from _twice("links", "joint.name", ((index, joint.name) for index, joint in joints if joint.name))
    yield from _mimic_faults(read.get("mimics", ()), [joint for _, joint in joints])


def _tree_faults(index: int, link: Link) -> Iterator[Fault]:
    place = ("links", index)
    if index == 0:
        for name in ("parent", "joint"):
            if getattr(link, name) is not None:
                yield Fault("SC714", f"the first link is the root, which has no `{name}`", (*place, name))
    elif link.parent is None or link.joint is None:
        name = "parent" if link.parent is None else "joint"
        yield Fault("SC714", f"every link but the first has a `{name}`", place)
    elif link.parent >= index:
        message = f"a parent stands before its child, and link {link.parent} does not stand before link {index}"
        yield Fault("SC714", message, (*place, "parent"))


def _mimic_faults(mimics: tuple[Mimic, ...], joints: list[Joint]) -> Iterator[Fault]:
    moving = {joint.name for joint in joints if joint.type != "fixed" and joint.name}
    for index, mimic in enumerate(mimics):
        for name in ("joint", "source"):
            wanted = getattr(mimic, name)
            if wanted not in moving:
                message = f"no joint that moves is called {shown(wanted)}"
                yield Fault("SC715", message, ("mimics", index, name))
        if mimic.joint == mimic.source:
            yield Fault("SC715", "a joint cannot follow itself", ("mimics", index, "source"))
    yield from _twice("mimics", "joint", ((index, mimic.joint) for index, mimic in enumerate(mimics)))


def structure_faults(read: dict[str, Any]) -> Iterator[Fault]:
    """What is wrong with the structures of an entity: all are bodies or all are articulations, and none is a link."""
    structures = read["structures"]
    if not structures:
        yield Fault("SC706", "an entity has one structure at least", ("structures",))
    if len({isinstance(structure, ArticulationStructure) for structure in structures}) > 1:
        yield Fault("SC705", "the structures of an entity are all bodies or all articulations", ("structures",))
    for index, structure in enumerate(structures):
        if not isinstance(structure, ArticulationStructure) and structure.body_type == "link":
            yield Fault("SC705", "a link is part of an articulation", ("structures", index, "body_type"))


def axis_faults(read: dict[str, Any]) -> Iterator[Fault]:
    """What is wrong with the axes of a drive between two bodies: each has its limits and its drive once."""
    for name in ("limits", "drives"):
        yield from _twice(name, "axis", ((index, item.axis) for index, item in enumerate(read.get(name, ()))))


def _twice(above: str, key: str, names: Iterable[tuple[int, str]]) -> Iterator[Fault]:
    seen: dict[str, int] = {}
    for index, name in names:
        if seen.setdefault(name, index) != index:
            message = f"{shown(name)} stands twice: {above} {seen[name]} and {index}"
            yield Fault("SC710", message, (above, index, *key.split(".")))
