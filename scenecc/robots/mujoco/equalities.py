"""Weld and connect equalities of a compiled model, as constraints between links."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.robots.description import DescribedConstraint, LinkName
from scenecc.robots.mujoco.model import CONNECT_EQUALITY, JOINT_EQUALITY, WELD_EQUALITY, WORLD, CompiledModel
from scenecc.robots.poses import compose_poses

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.robots.mjcf_files import MjcfReport

_OF_SITES = 6
"""`mjOBJ_SITE`: the equality is between sites, not bodies."""


WORLD_EQUALITY: Final = "equality/world"
"""Kind of loss for an equality with the world, which a robot in a file cannot have."""


def read_constraints(
    model: CompiledModel, links: Mapping[int, LinkName], report: MjcfReport
) -> list[DescribedConstraint]:
    """Returns the welds and connections that are active from the start.

    Args:
        model: the compiled model.
        links: link of each body that is built.
        report: receives the findings.
    """
    made: list[DescribedConstraint] = []
    for number, kind in enumerate(model["eq_type"].tolist()):
        place = model.location("eq", number)
        if not model["eq_active0"][number]:
            report.note_elsewhere(
                "inactive", f"{_what(model, number, kind)} is not built: it is inactive at the start", place
            )
        elif kind in {CONNECT_EQUALITY, WELD_EQUALITY}:
            if _has_no_effect(model, *(body for body, _ in equality_frames(model, number, kind))):
                message = (
                    f"{_what(model, number, kind)} is not built: no force moves one of its bodies against the other"
                )
                report.note_elsewhere("inactive/fixed", message, place)
                continue
            (first, in_first), (second, in_second) = built_frames(model, number, kind, links)
            if first not in links or second not in links:
                message = "an equality with the world is built only if it involves a fixed robot of the file"
                report.leave_out(WORLD_EQUALITY, message, place)
                continue
            name = model.name("eq", number) or f"equality_{number}"
            word = "weld" if kind == WELD_EQUALITY else "connection"
            ends = (links[first], in_first, links[second], in_second)
            # The world cannot be a child.
            parent, in_parent, child, in_child = ends if second != WORLD else (*ends[2:], *ends[:2])
            made.append(DescribedConstraint(name, word, parent, child, in_parent, in_child, place))
        elif kind != JOINT_EQUALITY:
            report.leave_out("equality/other", "equalities of tendons, flexes or distances are not built", place)
    return made


def mocaps_with_equalities(model: CompiledModel) -> set[int]:
    """Returns the mocap bodies to which an active weld or connection holds a body that moves."""
    found: set[int] = set()
    for number, kind in enumerate(model["eq_type"].tolist()):
        if model["eq_active0"][number] and kind in {CONNECT_EQUALITY, WELD_EQUALITY}:
            bodies = [body for body, _ in equality_frames(model, number, kind)]
            if not _has_no_effect(model, *bodies):
                roots = (int(model["body_weldid"][body]) for body in bodies)
                found.update(root for root in roots if model["body_mocapid"][root] >= 0)
    return found


def _has_no_effect(model: CompiledModel, first: int, second: int) -> bool:
    """Returns whether no force moves one body against another: they are fixed together, or to the world or mocaps."""
    groups = {int(model["body_weldid"][body]) for body in (first, second)}
    return len(groups) == 1 or all(group == WORLD or model["body_mocapid"][group] >= 0 for group in groups)


def _what(model: CompiledModel, number: int, kind: int) -> str:
    name = model.name("eq", number)
    joint = model.name("jnt", int(model["eq_obj1id"][number])) if kind == JOINT_EQUALITY else ""
    return f"the equality{f' `{name}`' if name else ''}{f' of `{joint}`' if joint else ''}"


def equality_frames(model: CompiledModel, number: int, kind: int) -> tuple[tuple[int, Pose7], tuple[int, Pose7]]:
    """Returns both bodies of a weld or connection, each with its frame; the two frames coincide."""
    first, second = int(model["eq_obj1id"][number]), int(model["eq_obj2id"][number])
    if model["eq_objtype"][number] == _OF_SITES:
        return _site(model, first), _site(model, second)
    data = model["eq_data"][number].tolist()
    if kind == CONNECT_EQUALITY:
        return (first, (*data[:3], 1.0, 0.0, 0.0, 0.0)), (second, (*data[3:6], 1.0, 0.0, 0.0, 0.0))
    # The pose of the second body in the first.
    return (first, (*data[3:6], *data[6:10])), (second, IDENTITY_POSE)


def built_frames(
    model: CompiledModel, number: int, kind: int, links: Mapping[int, LinkName]
) -> tuple[tuple[int, Pose7], tuple[int, Pose7]]:
    """Returns the ends of an equality as `equality_frames`, on the bodies that are built, or the world.

    A body that is fixed to the world or to a mocap body, and has no link, is a part of the body above it.
    """

    def built(body: int, pose: Pose7) -> tuple[int, Pose7]:
        """Returns a frame on the next body above that is built."""
        if body in links or body == WORLD:
            return body, pose
        return built(int(model["body_parentid"][body]), compose_poses(model.body_pose(body), pose))

    first, second = equality_frames(model, number, kind)
    return built(*first), built(*second)


def _site(model: CompiledModel, site: int) -> tuple[int, Pose7]:
    pose = (*model["site_pos"][site].tolist(), *model["site_quat"][site].tolist())
    return int(model["site_bodyid"][site]), pose
