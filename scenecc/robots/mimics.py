"""Joints that follow others: whether they can, and by how much where a file is scaled."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.robots.description import DescribedJoint
    from scenecc.robots.findings import Findings


def check_mimics(joints: Sequence[DescribedJoint], findings: Findings) -> None:
    """Reports joints of one robot that follow what they cannot: SC472."""
    named = {joint.name: joint for joint in joints}
    for joint in joints:
        mimic = joint.mimic
        if mimic is None:
            continue
        source = named.get(mimic.source)
        if source is None:
            message = f"the joint `{cut(joint.name)}` follows `{cut(mimic.source)}`, and its robot has no such joint"
            findings.report("SC472", message, mimic.location, hint=findings.near(mimic.source, named))
        elif joint.type == "fixed":
            message = f"the joint `{cut(joint.name)}` is fixed and can follow no other"
            findings.report("SC472", message, mimic.location, hint="take <mimic> away")
        elif source.type == "fixed":
            message = f"the joint `{cut(joint.name)}` follows `{cut(mimic.source)}`, which is fixed"
            findings.report("SC472", message, mimic.location, hint="make it a fixed joint too")
        elif _is_in_circle(joint, named):
            message = f"the joint `{cut(joint.name)}` follows itself, by way of `{cut(mimic.source)}`"
            findings.report("SC472", message, mimic.location, hint="let one of them follow none")


def scaled_mimics(joints: Mapping[str, DescribedJoint], scale: float) -> dict[str, DescribedJoint]:
    """Joints by name, with mimics that say of scaled lengths what they said of the file's.

    Positions of prismatic joints are lengths: so is the offset of one, and a multiplier between one and a joint that
    turns is a length to an angle.
    """
    made = dict(joints)
    for name, joint in joints.items():
        mimic = joint.mimic
        source = None if mimic is None else joints.get(mimic.source)
        if mimic is None or source is None or scale == 1:
            continue
        own = scale if joint.type == "prismatic" else 1.0
        others = scale if source.type == "prismatic" else 1.0
        multiplier = mimic.multiplier if own == others else mimic.multiplier * own / others
        made[name] = replace(joint, mimic=replace(mimic, multiplier=multiplier, offset=mimic.offset * own))
    return made


def _is_in_circle(joint: DescribedJoint, named: dict[str, DescribedJoint]) -> bool:
    at: DescribedJoint | None = joint
    for _ in named:
        at = None if at is None or at.mimic is None else named.get(at.mimic.source)
        if at is joint:
            return True
    return False
