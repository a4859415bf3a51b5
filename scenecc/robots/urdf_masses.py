"""Links of a URDF without a mass. Other programs give them none, SAPIEN that of their shapes or its least."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.robots.description import DescribedInertial, DescribedLink, ball_moment
from scenecc.robots.xml import parse_number

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from scenecc.robots.files import FileReport
    from scenecc.robots.xml import SourceElement

_LEAST: Final = 1e-6
"""SAPIEN's least mass [kg] and moments [kg·m²] of a link without inertia and collision shapes."""

_NOTABLE: Final = 0.01
"""Share of a link's smallest moment of inertia from which an addition is reported."""

_HINT: Final = "with `repair: [mass]` in the scene, links that are fixed to others have no mass, as in other programs"


def has_mass(link: SourceElement) -> bool:
    """Returns whether a <link> has a mass other than 0."""
    inertial = link.find("inertial")
    mass = None if inertial is None else inertial.find("mass")
    return mass is not None and parse_number(mass.attributes.get("value", "0")) != 0


def weigh_links(
    links: Sequence[DescribedLink], massless: Collection[str], findings: FileReport, repair: Collection[str]
) -> tuple[DescribedLink, ...]:
    """Reports links without a mass (SC448), or, with the repair "mass", gives those on fixed joints none (SC488).

    Args:
        links: the links of a robot, each after its parent.
        massless: links whose mass in the file is 0 or missing.
        findings: receives the notes.
        repair: repairs of the scene.
    """
    bare = [number for number, link in enumerate(links) if number and link.name in massless and not link.inertial]
    fixed = [number for number in bare if (joint := links[number].joint) is not None and joint.type == "fixed"]
    if "mass" in repair and fixed:
        count, moment = len(fixed), ball_moment(_LEAST)
        what = f"`{cut(links[fixed[0]].name)}`" + (f" and {count - 1} more links" if count > 1 else "")
        message = f"{what} without mass, fixed to {'others' if count > 1 else 'another'}: almost no mass, {_LEAST:g} kg"
        findings.report("SC488", message, links[fixed[0]].location)
        return tuple(
            replace(one, inertial=DescribedInertial(_LEAST, IDENTITY_POSE, (moment,) * 3, one.location))
            if number in fixed
            else one
            for number, one in enumerate(links)
        )
    if dense := [number for number in bare if links[number].collisions]:
        more = f" (there are {len(dense)} such links)" if len(dense) > 1 else ""
        message = f"`{cut(links[dense[0]].name)}` has no mass in the file: it gets that of its collision shapes{more}"
        findings.report("SC448", message, links[dense[0]].location, hint=_HINT if {*dense} & {*fixed} else None)
    for number in fixed:
        carrier = _carrier(links, number)
        moments = None if carrier is None or carrier.inertial is None else carrier.inertial.inertia
        if not links[number].collisions and carrier is not None and moments and min(moments) * _NOTABLE < _LEAST:
            message = (
                f"`{cut(links[number].name)}` has no mass in the file: SAPIEN gives it {_LEAST:g} kg and moments of "
                f"{_LEAST:g} kg·m², {_LEAST / min(moments):.0%} of the smallest of `{cut(carrier.name)}`"
            )
            findings.report_once("SC448", "light frame", message, links[number].location, _HINT)
    return tuple(links)


def _carrier(links: Sequence[DescribedLink], number: int) -> DescribedLink | None:
    """Returns the nearest link above with an inertial, without a moving joint in between."""
    while (parent := links[number].parent) is not None and (joint := links[number].joint) is not None:
        if joint.type != "fixed":
            return None
        if links[parent].inertial is not None:
            return links[parent]
        number = parent
    return None
