"""Rules for robots that hold for every format."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import IDENTITY_POSE, Vec3
from scenecc.robots.description import DescribedInertial, DescribedJoint, DescribedLink, ball_moment

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.diagnostics.diagnostic import Location

LIGHT_SHARE: Final = 1e-3
"""Mass and inertia of a light link, relative to what it carries."""

_TRIANGLE: Final = 1 + 1e-6
"""Allowed ratio of the largest moment of inertia to the sum of the others."""


def light_link(mass: float, moment: float | None, place: Location) -> DescribedInertial:
    """Returns the inertial of a link between two freedoms of one joint.

    It has a share of 1e-3 of the mass and, about each axis, of the largest moment of inertia of what it carries, with
    its centre of mass at the joint. Without shapes PhysX would give it 1 kg.

    Args:
        mass: of the links that it carries [kg].
        moment: largest moment of inertia of the link after it [kg·m²]; None: that of a sphere of water.
        place: of the joint.
    """
    share = max(LIGHT_SHARE * mass, 1e-9)
    turns = ball_moment(share) if moment is None else max(LIGHT_SHARE * moment, 1e-12)
    return DescribedInertial(share, IDENTITY_POSE, (turns, turns, turns), place)


def split_joint(
    link: DescribedLink, freedoms: Sequence[DescribedJoint], names: Sequence[str], first: int, mass: float
) -> tuple[DescribedLink, ...]:
    """Returns a link on a joint of several freedoms, after the light links between its freedoms.

    Args:
        link: with the link that carries it as its parent.
        freedoms: in series, from the parent outwards. The first has its frame in the parent, and the identity in the
            child; the last has its frame in the link; all others are identities.
        names: of the light links, one fewer than freedoms.
        first: index of the first link that is returned.
        mass: of the link with everything that it carries [kg].
    """
    moments = None if link.inertial is None or link.inertial.inertia is None else max(link.inertial.inertia)
    *others, last = freedoms
    made: list[DescribedLink] = []
    parent = link.parent
    for number, (joint, name) in enumerate(zip(others, names, strict=True)):
        inertial = light_link(mass, moments, joint.location)
        made.append(DescribedLink(name, joint.location, parent, joint, inertial=inertial, source=" "))
        parent = first + number
    return (*made, replace(link, parent=parent, joint=last))


def enforce_triangle_rule(inertia: Vec3) -> Vec3:
    """Returns moments of inertia of which none is above the sum of the others, its physical maximum: it is lowered."""
    a, b, c = inertia
    most = (b + c, a + c, a + b)
    low = [least if moment > least * _TRIANGLE else moment for moment, least in zip(inertia, most, strict=True)]
    return (low[0], low[1], low[2])
