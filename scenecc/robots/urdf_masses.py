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

_HINT: Final = "with `repair: [mass]` in the scene, it has no mass, as in other programs"


def has_mass(link: SourceElement) -> bool:
    """Returns whether a <link> has a mass other than 0."""
    inertial = link.find("inertial")
    mass = None if inertial is None else inertial.find("mass")
    return mass is not None and parse_number(mass.attributes.get("value", "0")) != 0


def weigh_links(
    links: Sequence[DescribedLink], massless: Collection[str], findings: FileReport, repair: Collection[str]
) -> tuple[DescribedLink, ...]:
    """Reports links without a mass that are fixed to links with one (SC448).

    With the repair "mass" they get almost none (SC488). A link that moves by itself has the mass of its shapes.

    Args:
        links: the links of a robot, each after its parent.
        massless: links whose mass in the file is 0 or missing.
        findings: receives the notes.
        repair: repairs of the scene.
    """
    groups = _groups(links, {"fixed"})
    heavy = {groups[number] for number, link in enumerate(links) if link.inertial is not None}
    bare = [
        number
        for number, link in enumerate(links)
        if link.name in massless and link.inertial is None and groups[number] in heavy
    ]
    if "mass" in repair and bare:
        more = f" and {len(bare) - 1} more links" if len(bare) > 1 else ""
        message = f"`{cut(links[bare[0]].name)}`{more} without mass, fixed to others: almost no mass, {_LEAST:g} kg"
        findings.report("SC488", message, links[bare[0]].location)
        moment = ball_moment(_LEAST)
        light = DescribedInertial(_LEAST, IDENTITY_POSE, (moment, moment, moment), links[bare[0]].location)
        return tuple(replace(one, inertial=light) if number in bare else one for number, one in enumerate(links))
    if dense := [number for number in bare if links[number].collisions]:
        more = f" (there are {len(dense)} such links)" if len(dense) > 1 else ""
        message = f"`{cut(links[dense[0]].name)}` has no mass in the file: it gets that of its collision shapes{more}"
        findings.report("SC448", message, links[dense[0]].location, hint=_HINT)
    # A finger that slides on a hand rotates with it.
    groups = _groups(links, {"fixed", "prismatic"})
    least: dict[int, float] = {}
    for group, link in zip(groups, links, strict=True):
        if link.inertial is not None and link.inertial.inertia is not None:
            least[group] = max(least.get(group, 0.0), min(link.inertial.inertia))
    for number in bare:
        moment = least.get(groups[number], 0.0)
        if not links[number].collisions and 0 < moment * _NOTABLE < _LEAST:
            message = (
                f"`{cut(links[number].name)}` has no mass in the file: SAPIEN gives it {_LEAST:g} kg and moments of "
                f"{_LEAST:g} kg·m², {_LEAST / moment:.0%} of those of the links that it rotates with"
            )
            findings.report_once("SC448", "light frame", message, links[number].location, _HINT)
    return tuple(links)


def _groups(links: Sequence[DescribedLink], types: Collection[str]) -> list[int]:
    """Returns for each link the first of the links that joints of these types connect it with."""
    found: list[int] = []
    for number, link in enumerate(links):
        joined = link.parent is not None and link.joint is not None and link.joint.type in types
        found.append(found[link.parent] if joined and link.parent is not None else number)
    return found
