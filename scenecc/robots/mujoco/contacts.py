"""Links of a file that never collide, as bits of SAPIEN's third collision integer.

In MuJoCo, bodies welded together do not collide, nor does a welded group collide with its parent group, nor do pairs in
`<exclude>`. PhysX excludes only a link and its parent. Each bit is a set of links that ignore one another.
There are only 32 bits, so the pairs are covered greedily.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from scenecc.robots.ignored_sets import MAX_SETS, Pairs, cover_pairs, symmetric
from scenecc.robots.mujoco.model import WORLD, CompiledModel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from scenecc.robots.mjcf_files import MjcfReport

MAX_BITS = 31
"""Usable bits of `contype` and `conaffinity`: SAPIEN's integers hold them shifted by one."""


@dataclass(slots=True)
class CollidingLink:
    """A link that collides.

    Attributes:
        body: index of its body in the model.
        key: identifies the link.
        robot: index of its robot.
        parent: key of its parent link; None: it has none.
        contype, conaffinity: union over its geoms.
    """

    body: int
    key: int
    robot: int
    parent: int | None
    contype: int
    conaffinity: int


def find_ignore_bits(
    links: Sequence[CollidingLink], model: CompiledModel, report: MjcfReport
) -> tuple[dict[int, int], bool]:
    """Returns the ignore bits of each link that has any, by its key, and whether each robot has bits of its own.

    It has none after an error (SC483: too many sets).
    """
    if {"CONTACT", "CONSTRAINT"} & {*model.header["disabled"]}:
        return {link.key: 1 for link in links}, False
    wanted, free = _pairs(links, model)
    sets = cover_pairs(wanted, free)
    alone = len(sets) > MAX_SETS and all(links[i].robot == links[j].robot for i, j in wanted)
    if alone:
        robots = np.array([link.robot for link in links])
        free &= robots[:, None] == robots
        covers = [cover_pairs(own, free) for own in _pairs_of_robots(wanted, links)]
        sets = [
            [number for cover in covers for number in (cover[bit] if bit < len(cover) else [])]
            for bit in range(max(map(len, covers)))
        ]
    if len(sets) > MAX_SETS:
        message = f"links that ignore one another need {len(sets)} bits, but SAPIEN has {MAX_SETS}"
        place = model.location("exclude", 0) if len(model["exclude_signature"]) else model.source.elements[0].location
        report.error("SC483", message, place, _hint(links, wanted, model))
        return {}, False
    bits: dict[int, int] = {}
    for bit, together in enumerate(sets):
        for number in together:
            bits[links[number].key] = bits.get(links[number].key, 0) | 1 << bit
    return bits, alone


def _pairs_of_robots(wanted: Pairs, links: Sequence[CollidingLink]) -> list[Pairs]:
    """Returns the pairs of each robot that has any."""
    found: dict[int, Pairs] = {}
    for i, j in wanted:
        found.setdefault(links[i].robot, set()).add((i, j))
    return [*found.values()]


def _hint(links: Sequence[CollidingLink], wanted: Pairs, model: CompiledModel) -> str:
    """Returns what to do about too many pairs that ignore one another."""
    excluded = {(one >> 16, one & 0xFFFF) for one in model["exclude_signature"].tolist()}
    bodies = [(links[i].body, links[j].body) for i, j in wanted]
    named = sum(bool({pair, pair[::-1]} & excluded) for pair in bodies)
    if 2 * named >= len(bodies):
        return "split the file, or remove some `<exclude>`"
    return (
        "bodies with several joints need a bit each: give each body of a chain one hinge, in turn about x and y, as a "
        "link never collides with its parent; or set `contype` and `conaffinity` of some to 0"
    )


def _pairs(links: Sequence[CollidingLink], model: CompiledModel) -> tuple[Pairs, NDArray[np.bool_]]:
    """Returns the pairs that need a bit, and whether two links never collide, as a symmetric matrix."""
    weld, parent = model["body_weldid"], model["body_parentid"]
    filters = "FILTERPARENT" not in model.header["disabled"]
    bodies, keys = np.array([(link.body, link.key) for link in links], np.int64).reshape(-1, 2).T
    parents = np.array([-1 if link.parent is None else link.parent for link in links], np.int64)
    bits = np.array([(link.contype, link.conaffinity) for link in links], np.uint32).reshape(-1, 2).T
    groups = weld[bodies]
    above = np.where(groups == WORLD, -1, weld[parent[groups]])
    excluded = symmetric(((one >> 16, one & 0xFFFF) for one in model["exclude_signature"].tolist()), len(parent))
    wanted: Pairs = set()
    never = np.zeros((len(links), len(links)), np.bool_)
    for i, group in enumerate(groups):
        ignores = (groups == group) | excluded[bodies[i], bodies]
        if filters and group != WORLD:
            ignores |= (groups != WORLD) & ((above == group) | (groups == above[i]))
        touches = ((bits[0] & bits[1, i]) | (bits[1] & bits[0, i])) != 0
        # PhysX excludes a link and its parent, and pairs of static shapes.
        apart = (parents == keys[i]) | (keys == parents[i])
        if group == WORLD:
            apart |= groups == WORLD
        never[i] = ignores | apart | ~touches
        wanted |= {(i, i + 1 + int(j)) for j in np.flatnonzero((ignores & touches & ~apart)[i + 1 :])}
    return wanted, never
