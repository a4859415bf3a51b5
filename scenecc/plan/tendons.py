"""Mimic joints as fixed tendons, the only thing of PhysX's that SAPIEN can bind joints with.

A tendon over joints q₁, q₂, … of lengths Σ cᵢ·qᵢ pulls every one of them by cᵢ·k·(rest length - length). Its first link
is where it hangs; every other one hangs, in the articulation, on a link that stands before it. What lies between the
two joints has the coefficient 0. Three things were measured with SAPIEN 3.0.3:

- What the engine calls the reciprocal of a coefficient is the share of the pull that a joint gets. Where it is the
  coefficient itself, the tendon does no work of its own; SAPIEN's own reciprocals, and coefficients above 1, let a
  joint and the one that hangs on it swing up. So the larger of the two coefficients is 1 here.
- A fixed joint on the way cannot be part of a tendon: SAPIEN raises.
- A joint that follows one further out on its own branch swings up, or is torn off, once that one is driven.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from scenecc.plan.articulation import ArticulationStructure, Mimic

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
        return f"'{mimic.source}' hangs on it, and PhysX does not hold that still"
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
