"""Reading an MJCF: its sections, and what becomes of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.robots.description import DescribedRobot, Description
from scenecc.robots.files import RobotFiles
from scenecc.robots.findings import Findings, ReadBudget
from scenecc.robots.mjcf import assets, bodies, geoms, joints
from scenecc.robots.mjcf.assets import Assets
from scenecc.robots.mjcf.bodies import Bodies, Draft
from scenecc.robots.mjcf.classes import Classes, Scope
from scenecc.robots.mjcf.compiler import read_compiler
from scenecc.robots.mjcf.files import Files
from scenecc.robots.mjcf.geoms import Geoms
from scenecc.robots.mjcf.joints import Joints
from scenecc.robots.mjcf.report import Report
from scenecc.robots.pose32 import IDENTITY
from scenecc.source.limits import Limits

if TYPE_CHECKING:
    from scenecc.diagnostics import Origin, Sink
    from scenecc.robots.description import PoseNumbers
    from scenecc.robots.xml import Element
    from scenecc.source.paths import AssetScope, ResolvedFile

_LIMITS = Limits()
_SECTIONS = frozenset({"compiler", "option", "default", "asset", "worldbody"})
_CLASSES = {"geom": geoms.READ, "joint": joints.READ, **assets.READ}
_BITS = 32
"""How many pairs of links can be kept from colliding, each by a bit of its own."""

_NO_CONTACT = 1 << 1
"""The bit of everything in a file whose contacts are switched off, as ManiSkill's loader has it."""


def read_mjcf(
    file: ResolvedFile,
    *,
    scope: AssetScope,
    sink: Sink,
    origin: Origin | None = None,
    limits: Limits = _LIMITS,
    name: str | None = None,
    budget: ReadBudget | None = None,
) -> Description | None:
    """The robots and bodies of an MJCF; None where the file is wrong, all that is wrong having been reported.

    First come the articulations, each with a root named `dummy_root_N`, N being the number of its body in the world;
    then bodies without joints, named as they are or `body_N`; then the world's own geoms, named as they are or
    `geom_N`. The numbers are those of ManiSkill's loader, to the bit, where that reads what MJCF means. A root is
    `fixed` unless its body is free.

    Args:
        file: the MJCF, as `scenecc.source.paths.resolve_path` finds it.
        scope: what may be read; meshes, textures and included files are looked for inside.
        sink: takes what is wrong, at the file's own lines: codes SC401 to SC407 for files that it names, SC450 to SC453
            where it cannot be read, SC480 to SC486 for the rest.
        origin: the node of the scene that names the file, told with each finding.
        limits: `includes`: how many files include one another; `asset_bytes`: size of each.
        name: the file's name as shown to people; None: its uri.
        budget: of all files of the scene; None: it is read alone.
    """
    report = Report(Findings(sink, origin, budget=budget))
    files = Files(RobotFiles(file, scope), file.uri if name is None else name, limits, report)
    root = files.read()
    if root is None or report.failed:
        return None
    if root.tag != "mujoco":
        hint = "give a URDF with `urdf:`" if root.tag == "robot" else None
        report.error("SC453", f"an MJCF is a <mujoco>, and this is a <{cut(root.tag)}>", root.location, hint)
        return None
    # What is beyond single precision is looked for, and told.
    with np.errstate(over="ignore"):
        robots = _Reader(root, files, report).robots()
    if not robots and not report.failed:
        report.nothing(root)
    report.tell_unread()
    return None if report.failed else Description(tuple(robots), tuple(files.named.found.values()))


class _Reader:
    """Makes the robots of one file."""

    def __init__(self, root: Element, files: Files, report: Report) -> None:
        self._root = root
        self._report = report
        self._file = files.name
        for section in root.children:
            if section.tag not in _SECTIONS:
                report.unread_element(section)
        self._compiler = read_compiler(root.children, report)
        classes = Classes(report)
        classes.read(root.all("default"), _CLASSES)
        self._assets = Assets(self._compiler, classes, files, report)
        self._assets.read(root.all("asset"))
        self._bodies = Bodies(Geoms(self._assets), Joints(classes, self._compiler), report)

    def robots(self) -> list[DescribedRobot]:
        """All robots, in the order of ManiSkill's loader."""
        # The loader hangs included sections behind the file's own.
        worlds = sorted(self._root.all("worldbody"), key=lambda world: world.location.file != self._file)
        trees: list[tuple[list[Draft], bool]] = []
        standing: list[tuple[Draft, PoseNumbers]] = []
        for number, body in enumerate(body for world in worlds for body in world.all("body")):
            if bodies.has_joint(body):
                trees.append(self._bodies.articulation(body, number))
            elif made := self._bodies.standing(body):
                standing.append((made, self._bodies.pose(body)))
        standing += [(made, IDENTITY) for made in self._geoms(worlds)]
        self._assets.tell_unread()
        self._allot([link for links, _ in trees for link in links] + [made for made, _ in standing])
        if self._report.failed:
            return []
        taken = {links[0].name for links, _ in trees}
        for made, _ in standing:
            made.name = _free_name(made.name, taken)
        return [bodies.described(links, fixed=fixed) for links, fixed in trees] + [
            bodies.described_body(made, pose) for made, pose in standing
        ]

    def _geoms(self, worlds: list[Element]) -> list[Draft]:
        """The world's own geoms, each a body that stands still."""
        made: list[Draft] = []
        elements = [child for world in worlds for child in world.children]
        for child in elements:
            if child.tag in {"joint", "freejoint"}:
                self._report.error("SC483", f"the world can have no `<{child.tag}>`", child.location)
            else:
                self._bodies.look_over(child)
        for number, geom in enumerate(child for child in elements if child.tag == "geom"):
            one = Draft(geom.attributes.get("name") or f"geom_{number}", geom, None, None)
            one.visuals, one.collisions = self._bodies.make(geom, Scope(), IDENTITY)
            if one.visuals or one.collisions:
                made.append(one)
        return made

    def _allot(self, everything: list[Draft]) -> None:
        """Gives links that do not collide a bit in common."""
        bonds = self._bodies.bonds
        if len(bonds) > _BITS:
            # PhysX lets no link collide with its own parent, so that only pairs with others between need a bit.
            bonds = [bond for bond in bonds if bond.apart]
        if len(bonds) > _BITS:
            self._report.error(
                "SC483",
                f"more than {_BITS} bodies have several joints, and the engine has no more bits to keep them from "
                "colliding with the bodies that they are in",
                bonds[_BITS].second.element.location,
                "build the file in parts",
            )
            return
        for number, bond in enumerate(bonds):
            bond.first.ignore_bits |= 1 << number
            bond.second.ignore_bits |= 1 << number
        if not self._compiler.contact:
            for made in everything:
                made.ignore_bits |= _NO_CONTACT


def _free_name(name: str, taken: set[str]) -> str:
    """A name that nothing else has, which is then taken."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    taken.add(free)
    return free
