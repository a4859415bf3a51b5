"""SRDF: pairs of links that do not collide, as bits of the third collision integer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut
from scenecc.robots.files import read_robot_bytes
from scenecc.robots.xml import XmlBounds, parse_xml, read_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from scenecc.diagnostics import Location
    from scenecc.robots.files import FileReport
    from scenecc.robots.xml import SourceElement

MAX_IGNORED_PAIRS = 31
"""How many bits SAPIEN's loader gives away."""


@frozen
class IgnoredPair:
    """Two links that do not collide, by name."""

    first: str
    second: str
    location: Location


def read_srdf(path: Path, file: str, links: Iterable[str], findings: FileReport) -> tuple[IgnoredPair, ...]:
    """The pairs that SAPIEN's loader heeds: those whose reason is `Default`.

    Of others nothing is told where they are neighbours (`Adjacent`) or cannot meet (`Never`), since these make no
    difference; any other reason is SC474.

    Args:
        path: of the SRDF.
        file: its name as shown to people.
        links: names of the robot's links; a pair of another is SC471.
        findings: where faults are reported.
    """
    data = read_robot_bytes(path, file, findings, XmlBounds().size)
    root = None if data is None else parse_xml(data, file, findings)
    if root is None:
        return ()
    if root.tag != "robot":
        findings.report("SC453", f"an SRDF is a <robot>, and this is a <{cut(root.tag)}>", root.location)
        return ()
    known = dict.fromkeys(links)
    pairs: list[IgnoredPair] = []
    others: list[SourceElement] = []
    for element in root.all("disable_collisions"):
        reason = element.attributes.get("reason", "").lower()
        if reason != "default":
            if reason not in {"adjacent", "never"}:
                others.append(element)
        elif (pair := _read_pair(element, known, findings)) is not None:
            pairs.append(pair)
    if others:
        findings.report(
            "SC474",
            f"pairs not to collide with another reason than `Default`: {len(others)}, and SAPIEN heeds none of them",
            others[0].location,
            hint='write reason="Default" where a pair is not to collide',
        )
    return tuple(pairs)


def _read_pair(element: SourceElement, links: Mapping[str, None], findings: FileReport) -> IgnoredPair | None:
    names = [read_text(element, attribute, findings) for attribute in ("link1", "link2")]
    is_good = True
    for attribute, name in zip(("link1", "link2"), names, strict=True):
        if name is not None and name not in links:
            is_good = False
            findings.report(
                "SC471",
                f"the robot has no link `{cut(name)}`",
                element.at(attribute),
                hint=findings.near(name, links),
            )
    first, second = names
    if first is None or second is None or not is_good:
        return None
    if first == second:
        findings.report("SC471", f"the link `{cut(first)}` is paired with itself", element.at("link2"))
        return None
    return IgnoredPair(first, second, element.location)


def assign_ignore_bits(
    links: Sequence[str], parents: Sequence[int | None], pairs: Iterable[IgnoredPair], findings: FileReport
) -> tuple[list[int], tuple[Location, ...]]:
    """The bits of each link of one robot, and for each bit its pair.

    Each pair takes the next bit, except parent and child, which never collide.

    Args:
        links: names, in build order.
        parents: number of each one's parent.
        pairs: of the whole file; one of another robot's links is not looked at.
        findings: takes SC473, for more pairs than there are bits.
    """
    numbers = {name: index for index, name in enumerate(links)}
    bits = [0] * len(links)
    found: list[Location] = []
    for pair in pairs:
        first, second = numbers.get(pair.first), numbers.get(pair.second)
        if first is None or second is None or parents[first] == second or parents[second] == first:
            continue
        if len(found) == MAX_IGNORED_PAIRS:
            findings.report(
                "SC473",
                f"more than {MAX_IGNORED_PAIRS} pairs of links are not to collide, and there is a bit for so many",
                pair.location,
                hint="leave out pairs that never meet, or say `disable_self_collisions: true`",
            )
            break
        bits[first] |= 1 << len(found)
        bits[second] |= 1 << len(found)
        found.append(pair.location)
    return bits, tuple(found)
