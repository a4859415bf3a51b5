"""Rules for robots that hold for every format."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import IDENTITY_POSE, Vec3
from scenecc.plan.articulation import unbuilt_resistance
from scenecc.robots.description import DescribedInertial, DescribedJoint, DescribedLink, ball_moment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics.diagnostic import Location

LIGHT_SHARE: Final = 1e-3
"""Mass and inertia of a light link, relative to the next link."""

_LEAST_MASS: Final = 1e-6
"""Mass of a light link that carries nothing [kg]."""

_TRIANGLE: Final = 1 + 1e-6
"""Allowed ratio of the largest moment of inertia to the sum of the others."""


def light_link(mass: float, moment: float | None, place: Location) -> DescribedInertial:
    """Returns the inertial of a link between two freedoms of one joint.

    Its mass is 1e-3 of that of the next link, each of its moments 1e-3 of the next link's largest, and its centre of
    mass is at the joint. Without shapes PhysX would give it 1 kg. The periods of a pendulum on three hinges, and of a
    chain of ten, are then those of MuJoCo's ball joints to 0.03 %. Shares of 1e-4 and less gain more energy where the
    outer hinges are almost parallel (a chain of six: 4 times as much). A share of 1e-2 changes the period by 0.3 %.

    Args:
        mass: of the next link [kg].
        moment: its largest moment of inertia [kg·m²]; None: that of a sphere of water of the light
            link's mass.
        place: of the joint.
    """
    share = LIGHT_SHARE * mass or _LEAST_MASS
    turns = LIGHT_SHARE * moment if moment else ball_moment(share)
    return DescribedInertial(share, IDENTITY_POSE, (turns, turns, turns), place)


def split_joint(
    link: DescribedLink, freedoms: Sequence[DescribedJoint], names: Sequence[str], first: int
) -> tuple[DescribedLink, ...]:
    """Returns a link on a joint of several freedoms, after the light links between its freedoms.

    Args:
        link: with the link that carries it as its parent.
        freedoms: in series, from the parent outwards. The first has its frame in the parent, and the identity in the
            child; the last has its frame in the link; all others are identities.
        names: of the light links, one fewer than freedoms.
        first: index of the first link that is returned.
    """
    mass = 1.0 if link.inertial is None else link.inertial.mass
    moment = None if link.inertial is None or link.inertial.inertia is None else max(link.inertial.inertia)
    *others, last = freedoms
    made: list[DescribedLink] = []
    parent = link.parent
    for number, (joint, name) in enumerate(zip(others, names, strict=True)):
        inertial = light_link(mass, moment, joint.location)
        made.append(DescribedLink(name, joint.location, parent, joint, inertial=inertial, is_added=True))
        parent = first + number
    return (*made, replace(link, parent=parent, joint=last))


def enforce_triangle_rule(inertia: Vec3) -> Vec3:
    """Returns moments of inertia of which none is above the sum of the others, its physical maximum: it is lowered."""
    a, b, c = inertia
    most = (b + c, a + c, a + b)
    low = [least if moment > least * _TRIANGLE else moment for moment, least in zip(inertia, most, strict=True)]
    return (low[0], low[1], low[2])


def default_position(joint: DescribedJoint) -> float:
    """Returns where a joint without an initial position starts [m, rad]: at 0, or at the limit that is nearest to 0."""
    low, high = joint.limits or (0.0, 0.0)
    return min(max(0.0, low), high)


def with_one_resistance(joint: DescribedJoint) -> DescribedJoint:
    """Returns a joint without its friction force or its damping, if it cannot have both."""
    lost = _unbuilt_resistance(joint)
    if lost == "friction":
        return replace(joint, friction_force=None)
    return replace(joint, damping=0.0) if lost else joint


def lost_resistance(joint: DescribedJoint) -> str:
    """Returns what `with_one_resistance` drops from a joint, in words; "" if nothing."""
    lost, of = _unbuilt_resistance(joint), f" of `{joint.name}`" if joint.name else ""
    if lost == "friction":
        return f"the friction {joint.friction_force:g}{of} beside a spring, a drive or a damping"
    return f"the damping {joint.damping:g}{of} beside friction" if lost else ""


def _unbuilt_resistance(joint: DescribedJoint) -> str:
    return unbuilt_resistance(joint.friction_force or 0.0, joint.damping, is_driven=joint.drive is not None)
