"""Which links of a file never collide, as bits of SAPIEN's third collision integer.

MuJoCo lets bodies that are welded together not collide, nor such a group and the one that it moves on, nor the pairs of
`<exclude>`. PhysX keeps only a link and its parent link apart. Each bit stands for a set of links of which all pairs
ignore one another: the pairs are covered by such sets, greedily, for there are only 32 bits.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from scenecc.robots.ignored_sets import MAX_SETS, Pairs, cover_pairs
from scenecc.robots.mujoco.model import WORLD, CompiledModel

if TYPE_CHECKING:
    from collections.abc import Sequence

    from scenecc.robots.mjcf_files import MjcfReport

MAX_BITS = 31
"""Bits of `contype` and `conaffinity` that SAPIEN's integers hold, shifted by one."""


@dataclass(slots=True)
class CollidingLink:
    """A link that collides.

    Attributes:
        body: number of its body in the model.
        key: of the link itself: equal for a link and for the parent that others name.
        parent: the key of its parent link; None: it has none.
        contype, conaffinity: of all its geoms together.
    """

    body: int
    key: int
    parent: int | None
    contype: int
    conaffinity: int


def find_ignore_bits(links: Sequence[CollidingLink], model: CompiledModel, report: MjcfReport) -> dict[int, int]:
    """The bits of each link that has any, by its key; after an error (SC483: too many sets), none."""
    if "CONTACT" in model.header["disabled"]:
        return {link.key: 1 for link in links}
    wanted, free = _pairs(links, model)
    sets = cover_pairs(wanted, free, len(links))
    if len(sets) > MAX_SETS:
        message = f"links that ignore one another need {len(sets)} bits, and SAPIEN has {MAX_SETS}"
        place = model.location("exclude", 0) if len(model["exclude_signature"]) else model.source.elements[0].location
        report.error("SC483", message, place, "build the file in parts, or leave out some `<exclude>`")
        return {}
    bits: dict[int, int] = {}
    for bit, together in enumerate(sets):
        for number in together:
            bits[links[number].key] = bits.get(links[number].key, 0) | 1 << bit
    return bits


def _pairs(links: Sequence[CollidingLink], model: CompiledModel) -> tuple[Pairs, Pairs]:
    """Pairs that need a bit, and all that never collide."""
    weld, parent = model["body_weldid"].tolist(), model["body_parentid"].tolist()
    excluded = {(one >> 16, one & 0xFFFF) for one in model["exclude_signature"].tolist()}
    filters = "FILTERPARENT" not in model.header["disabled"]
    wanted: Pairs = set()
    never: Pairs = set()
    for (i, a), (j, b) in combinations(enumerate(links), 2):
        first, second = weld[a.body], weld[b.body]
        above_first, above_second = weld[parent[first]], weld[parent[second]]
        moves_on = WORLD not in (first, second) and (first == above_second or second == above_first)
        pair = (a.body, b.body)
        touches = bool(a.contype & b.conaffinity or b.contype & a.conaffinity)
        ignores = first == second or (filters and moves_on) or pair in excluded or pair[::-1] in excluded
        # PhysX keeps a link and its parent apart, and what stands still.
        apart = a.parent == b.key or b.parent == a.key or first == second == WORLD
        if ignores or apart or not touches:
            never.add((i, j))
        if ignores and touches and not apart:
            wanted.add((i, j))
    return wanted, never
