"""Which mimic joints PhysX couples inexactly."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import normalized, rotate
from scenecc.plan.articulation import soft_mimics, tendon_links

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.plan.articulation import ArticulationStructure, Joint, Mimic


def inexact_mimics(structure: ArticulationStructure) -> list[Mimic]:
    """Returns the mimics that push joints as virtual work does not have it (SC578)."""
    return [mimic for mimic in soft_mimics(structure) if not _is_exact(structure, mimic)]


def list_mimics(mimics: Sequence[Mimic]) -> str:
    """Returns the names of mimic joints with those of their sources, and a count in place of all but three."""
    pairs = ", ".join(f"`{cut(mimic.joint)}` (source `{cut(mimic.source)}`)" for mimic in mimics[:3])
    return pairs if len(mimics) <= 3 else f"{pairs} and {len(mimics) - 3} more"


def _is_exact(structure: ArticulationStructure, mimic: Mimic) -> bool:
    """Returns whether a soft tendon gives every joint of the articulation what virtual work has it.

    PhysX acts back on the first link of the tendon, about the axis of the first joint, and measures speeds about this
    axis. This is right if all turn about one direction; also if this link cannot move, all turn or all slide, and
    those with joints between them are parallel.
    """
    path = tendon_links(structure, mimic)
    for link in (first for first in path[1:] if structure.links[first].parent == path[0]):
        branch = [link]
        while below := [number for number in path if structure.links[number].parent == branch[-1]]:
            branch.append(below[0])
        if len(branch) > 1 and not _is_exact_branch(structure, branch, is_still=_is_still(structure, path[0])):
            return False
    return True


def _is_exact_branch(structure: ArticulationStructure, branch: list[int], *, is_still: bool) -> bool:
    joints = [joint for number in branch if (joint := structure.links[number].joint) is not None]
    slides = [joint.type == "prismatic" for joint in joints]
    cosines = [_axis_cosine(above, below) for above, below in pairwise(joints)]
    if is_still:
        return len(set(slides)) == 1 and (len(branch) == 2 or all(abs(cosine) > _PARALLEL for cosine in cosines))
    return not any(slides) and all(cosine > _PARALLEL for cosine in cosines)


_PARALLEL = 0.999


def _axis_cosine(above: Joint, below: Joint) -> float:
    """Returns the cosine of the angle between a joint's axis and that of the next joint, in the first scene."""
    axes = [
        rotate((1.0, 0.0, 0.0, 0.0) if pose is None else normalized(pose.as_drawn()[3:7]), (1.0, 0.0, 0.0))
        for pose in (above.pose_in_child, below.pose_in_parent)
    ]
    return sum(a * b for a, b in zip(*axes, strict=True))


def _is_still(structure: ArticulationStructure, number: int) -> bool:
    """Returns whether a link cannot move."""
    link = structure.links[number]
    if link.parent is None or link.joint is None:
        return structure.fix_root_link
    return link.joint.type == "fixed" and _is_still(structure, link.parent)
