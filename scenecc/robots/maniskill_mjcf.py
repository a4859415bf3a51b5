"""Reader for MJCF: robots and bodies as MuJoCo's files describe them, built as ManiSkill's loader builds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from scenecc.geometry.rotations import IDENTITY_POSE, Pose7
from scenecc.names import UniqueNames
from scenecc.robots import maniskill_bodies, maniskill_geoms
from scenecc.robots.description import DescribedRobot, RobotDescription
from scenecc.robots.files import FileReport, ReadBudget, RobotFiles
from scenecc.robots.maniskill_attributes import ClassScope, DefaultClasses, read_compiler
from scenecc.robots.maniskill_bodies import BodyReader, JointReader, LinkDraft
from scenecc.robots.maniskill_geoms import GeomReader, MjcfAssets
from scenecc.robots.mjcf_files import MjcfFiles, MjcfReport
from scenecc.source.limits import Limits

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.robots.xml import SourceElement
    from scenecc.source.paths import AssetScope, ResolvedFile

_DEFAULT_LIMITS = Limits()

_SECTIONS = frozenset({"compiler", "option", "default", "asset", "worldbody"})

_CLASS_ATTRIBUTES = {
    "geom": maniskill_geoms.GEOM_ATTRIBUTES,
    "joint": maniskill_bodies.JOINT_ATTRIBUTES,
    **maniskill_geoms.ASSET_ATTRIBUTES,
}

_MAX_EXCLUDED_PAIRS = 32
"""Maximum number of pairs of links that do not collide, each by a bit of its own."""

_NO_CONTACT_BIT = 1 << 1
"""The bit of everything in a file whose contacts are switched off, as ManiSkill's loader has it."""


def read_mjcf(
    file: ResolvedFile,
    *,
    scope: AssetScope,
    sink: Sink,
    origin: Origin | None = None,
    limits: Limits = _DEFAULT_LIMITS,
    name: str | None = None,
    budget: ReadBudget | None = None,
) -> RobotDescription | None:
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
        origin: the node of the scene that names the file, reported with each finding.
        limits: `depth`: how many files include one another; `asset_bytes`: size of each.
        name: the file's name as shown to people; None: its uri.
        budget: of all files of the scene; None: it is read alone.
    """
    report = MjcfReport(FileReport(sink, origin, budget=budget))
    files = MjcfFiles(RobotFiles(file, scope), file.uri if name is None else name, limits, report)
    root = files.read_model()
    if root is None:
        return None
    # Numbers beyond single precision are checked and reported.
    with np.errstate(over="ignore"):
        robots = _MjcfReader(root, files, report).robots()
    if not robots and not report.failed:
        report.nothing(root)
    report.report_unread()
    return None if report.failed else RobotDescription(tuple(robots), tuple(files.named.found.values()))


class _MjcfReader:
    """Builds the robots of one file."""

    def __init__(self, root: SourceElement, files: MjcfFiles, report: MjcfReport) -> None:
        self._root = root
        self._report = report
        self._file = files.name
        for section in root.children:
            if section.tag not in _SECTIONS:
                report.unread_element(section)
        self._compiler = read_compiler(root.children, report)
        classes = DefaultClasses(report)
        classes.read(root.all("default"), _CLASS_ATTRIBUTES)
        self._assets = MjcfAssets(self._compiler, classes, files, report)
        self._assets.read(root.all("asset"))
        self._bodies = BodyReader(GeomReader(self._assets), JointReader(classes, self._compiler), report)

    def robots(self) -> list[DescribedRobot]:
        """All robots, in the order of ManiSkill's loader."""
        # The loader hangs included sections behind the file's own.
        worlds = sorted(self._root.all("worldbody"), key=lambda world: world.location.file != self._file)
        trees: list[tuple[list[LinkDraft], bool]] = []
        static_bodies: list[tuple[LinkDraft, Pose7]] = []
        for number, body in enumerate(body for world in worlds for body in world.all("body")):
            if maniskill_bodies.has_joint(body):
                trees.append(self._bodies.articulation(body, number))
            elif made := self._bodies.static_body(body):
                static_bodies.append((made, self._bodies.pose(body)))
        static_bodies += [(made, IDENTITY_POSE) for made in self._geoms(worlds)]
        self._assets.report_unread()
        self._assign_ignore_bits([link for links, _ in trees for link in links] + [made for made, _ in static_bodies])
        if self._report.failed:
            return []
        names = UniqueNames(*(links[0].name for links, _ in trees))
        for made, _ in static_bodies:
            made.name = names.new(made.name)
        return [maniskill_bodies.describe_articulation(links, fixed=fixed) for links, fixed in trees] + [
            maniskill_bodies.describe_static_body(made, pose) for made, pose in static_bodies
        ]

    def _geoms(self, worlds: list[SourceElement]) -> list[LinkDraft]:
        """The world's own geoms, each as a static body."""
        made: list[LinkDraft] = []
        elements = [child for world in worlds for child in world.children]
        for child in elements:
            if child.tag in {"joint", "freejoint"}:
                self._report.error("SC483", f"the world can have no `<{child.tag}>`", child.location)
            else:
                self._bodies.report_unread(child)
        for number, geom in enumerate(child for child in elements if child.tag == "geom"):
            one = LinkDraft(geom.attributes.get("name") or f"geom_{number}", geom, None, None)
            one.visuals, one.collisions = self._bodies.make(geom, ClassScope(), IDENTITY_POSE)
            if one.visuals or one.collisions:
                made.append(one)
        return made

    def _assign_ignore_bits(self, everything: list[LinkDraft]) -> None:
        """Assigns a common bit to links that do not collide."""
        bonds = self._bodies.bonds
        if len(bonds) > _MAX_EXCLUDED_PAIRS:
            # PhysX lets no link collide with its own parent, so that only pairs with others between need a bit.
            bonds = [bond for bond in bonds if bond.apart]
        if len(bonds) > _MAX_EXCLUDED_PAIRS:
            self._report.error(
                "SC483",
                f"more than {_MAX_EXCLUDED_PAIRS} bodies have several joints, and the engine has no more bits "
                "to keep them from colliding with the bodies that they are in",
                bonds[_MAX_EXCLUDED_PAIRS].second.element.location,
                "build the file in parts",
            )
            return
        for number, bond in enumerate(bonds):
            bond.first.ignore_bits |= 1 << number
            bond.second.ignore_bits |= 1 << number
        if not self._compiler.contact:
            for made in everything:
                made.ignore_bits |= _NO_CONTACT_BIT
