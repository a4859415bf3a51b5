"""Reader for MJCF: robots and bodies as MuJoCo's files describe them, built as ManiSkill's loader builds them."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field
from functools import reduce
from typing import TYPE_CHECKING

import numpy as np

from scenecc.diagnostics.messages import cut
from scenecc.geometry.rotations import IDENTITY_POSE
from scenecc.robots import mjcf_bodies, mjcf_geoms
from scenecc.robots.description import DescribedRobot, RobotDescription
from scenecc.robots.files import FileReport, ReadBudget, RobotFiles, read_robot_bytes
from scenecc.robots.mjcf_attributes import ClassScope, DefaultClasses, read_compiler
from scenecc.robots.mjcf_bodies import BodyReader, JointReader, LinkDraft
from scenecc.robots.mjcf_geoms import GeomReader, MjcfAssets
from scenecc.robots.xml import XmlBounds, parse_xml
from scenecc.source.limits import Limits

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location, Origin
    from scenecc.geometry.rotations import Pose7
    from scenecc.robots.description import DescribedFile
    from scenecc.robots.xml import SourceElement
    from scenecc.source.paths import AssetScope, ResolvedFile


UNREAD_ELEMENT_HINTS: dict[str, str] = {
    "actuator": "say under `drives` what drives the joints",
    "camera": "declare it under `cameras`, with `mount` where it moves with a link",
    "contact": "say under `collision_groups` and `links` what ignores what",
    "equality": "declare it under `constraints`",
    "inertial": "masses follow from the shapes' densities; `links: {NAME: {inertial: …}}` gives others",
    "keyframe": "give `qpos`",
    "light": "declare it under `lights`",
    "option": "timestep, gravity and solver are the scene's `physics`",
    "site": "declare a `frame`, or mount on the link",
}
"""Hints for elements that are not read: what to write in the scene."""

_UNREAD_ATTRIBUTE_HINTS: dict[tuple[str, str], str] = {
    ("body", "gravcomp"): "`gravity: false` under `links` takes gravity away",
    ("body", "mocap"): "it stands still, where it has no joints; declare a kinematic body in the scene",
    (
        "geom",
        "mass",
    ): "masses follow from densities (1000 where none is given); `links: {NAME: {mass: …}}` gives others",
    ("joint", "armature"): "`joints: {NAME: {armature: …}}` gives it",
    ("joint", "stiffness"): "`drives: {NAME: {stiffness: …}}` pulls a joint back",
    ("option", "gravity"): UNREAD_ELEMENT_HINTS["option"],
    ("option", "timestep"): UNREAD_ELEMENT_HINTS["option"],
    ("texture", "builtin"): "paint the texture into a file",
}


def unread_attribute_hint(tag: str, names: Iterable[str]) -> str | None:
    """The hint for attributes that are not read: what to write in the scene."""
    hints = [_UNREAD_ATTRIBUTE_HINTS[tag, name] for name in names if (tag, name) in _UNREAD_ATTRIBUTE_HINTS]
    return "; ".join(dict.fromkeys(hints)) or None


@dataclass(slots=True)
class MjcfReport:
    """Collects findings, so that each kind of unread element is reported once, with the number of elements.

    Attributes:
        findings: of the file itself.
        included: the findings of each included file, by its displayed name.
    """

    findings: FileReport
    included: dict[str, FileReport] = field(default_factory=dict[str, "FileReport"])
    _unbuilt: dict[str, tuple[str, Location, str | None]] = field(
        default_factory=dict[str, "tuple[str, Location, str | None]"]
    )
    _elements: dict[str, list[SourceElement]] = field(default_factory=dict[str, "list[SourceElement]"])
    _attributes: dict[str, dict[str, SourceElement]] = field(default_factory=dict[str, "dict[str, SourceElement]"])

    @property
    def failed(self) -> bool:
        """Whether an error was reported."""
        return bool(self.findings.errors) or any(findings.errors for findings in self.included.values())

    def error(self, code: str, message: str, location: Location, hint: str | None = None) -> None:
        """Reports an error."""
        self.of(location).report(code, message, location, hint=hint)

    def of(self, location: Location) -> FileReport:
        """The findings of the file of a location."""
        return self.included.get(location.file or "", self.findings)

    def left_out(self, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Warns of something that is not built, once per kind."""
        self.of(location).report_once("SC484", kind, message, location, hint)

    def not_built(self, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Records a body or geom that is left out, for `report_unread` or `nothing`."""
        self._unbuilt.setdefault(kind, (message, location, hint))

    def nothing(self, root: SourceElement) -> None:
        """Reports a file of which nothing is built, at the first thing that was left out, if any."""
        message, location, hint = "it has no body and no geom that is", root.location, None
        if self._unbuilt:
            message, location, hint = self._unbuilt.pop(next(iter(self._unbuilt)))
        self.error("SC480", f"nothing in the file is built: {message}", location, hint)

    def differs(self, kind: str, message: str, location: Location) -> None:
        """Warns of something that ManiSkill's loader reads differently, once per kind."""
        self.of(location).report_once("SC485", kind, message, location)

    def unread_element(self, element: SourceElement) -> None:
        """Records an unread element."""
        self._elements.setdefault(element.tag, []).append(element)

    def unread_attributes(self, element: SourceElement, read: frozenset[str]) -> None:
        """Records the attributes of an element that are not read."""
        unread = self._attributes.setdefault(element.tag, {})
        for name in element.attributes:
            if name not in read:
                unread[name] = _first_in_file(unread.get(name, element), element)

    def report_unread(self) -> None:
        """Reports what was recorded: one warning per kind of element, and one for the attributes of each kind."""
        for kind, (message, location, hint) in self._unbuilt.items():
            self.left_out(kind, message, location, hint)
        for tag, elements in self._elements.items():
            count = f" (there are {len(elements)})" if len(elements) > 1 else ""
            place = reduce(_first_in_file, elements).location
            self.left_out(f"<{tag}>", f"`<{cut(tag)}>` is not read{count}", place, UNREAD_ELEMENT_HINTS.get(tag))
        for tag, names in self._attributes.items():
            if not names:
                continue
            # Of one element's they stand as written already.
            ordered = sorted(names, key=lambda name: (names[name].line, names[name].column))
            shown = ", ".join(f"`{cut(name)}`" for name in ordered[:20])
            more = f" and {len(ordered) - 20} more" if len(ordered) > 20 else ""
            verb = "are" if len(ordered) > 1 else "is"
            self.left_out(
                f"{tag}@",
                f"of `<{cut(tag)}>`, {shown}{more} {verb} not read",
                names[ordered[0]].at(ordered[0]),
                unread_attribute_hint(tag, ordered),
            )


def _first_in_file(one: SourceElement, other: SourceElement) -> SourceElement:
    """The first of two elements in their file; of different files, `one`."""
    is_before = (other.line, other.column) < (one.line, one.column)
    return other if is_before and other.location.file == one.location.file else one


@dataclass(slots=True)
class MjcfFiles:
    """Finds the files that an MJCF names. All are named from the folder of the MJCF itself, in included files too.

    Attributes:
        named: finds and remembers them.
        name: the MJCF's as shown to people.
        limits: how much is read.
        report: where faults go.
    """

    named: RobotFiles
    name: str
    limits: Limits
    report: MjcfReport
    _included: set[Path] = field(default_factory=set["Path"])
    _size: int = 0

    def find(self, folder: str, written: str, place: Location) -> DescribedFile | None:
        """A file by its path from a folder; None, reported at `place`, where it may not be used."""
        reference = written if written.startswith("/") or not folder else posixpath.join(folder, written)
        return self.named.find(reference if written else "", place, self.report.of(place))

    def read(self) -> SourceElement | None:
        """The root of the MJCF's tree, with everything that it includes in place of each `include`."""
        owner = self.named.owner
        return self._read(owner.path, self.name, self.report.findings, 1, 1)

    def _read(self, path: Path, name: str, findings: FileReport, chain: int, depth: int) -> SourceElement | None:
        bounds = XmlBounds()
        self._included.add(path)
        data = read_robot_bytes(path, name, findings, min(bounds.size, self.limits.asset_bytes))
        root = None if data is None else parse_xml(data, name, findings, bounds)
        if data is None or root is None:
            return None
        self._size += len(data)
        if self._size > bounds.size:
            findings.report("SC452", f"the files together have more than {bounds.size} bytes", findings.top(name))
            return None
        self._expand(root, chain, depth)
        return root

    def _expand(self, root: SourceElement, chain: int, depth: int) -> None:
        """Puts what is included into place, wherever it stands. `depth`: of the root among all elements."""
        pending = [(root, depth)]
        while pending:
            parent, level = pending.pop()
            if level > XmlBounds().depth:
                what = f"the file is too large: more than {XmlBounds().depth} elements stand inside one another"
                self.report.error("SC452", what, parent.location)
                return
            own = list(parent.children)
            pending.extend((child, level + 1) for child in own if child.tag != "include")
            if any(child.tag == "include" for child in own):
                children: list[SourceElement] = []
                for child in own:
                    children.extend(self._content(child, chain, level) if child.tag == "include" else [child])
                parent.children[:] = children

    def _content(self, include: SourceElement, chain: int, depth: int) -> list[SourceElement]:
        """What stands in the file that an `include` names. `depth`: of the element that it stands in."""
        name = include.attributes.get("file")
        if name is None:
            self.report.error("SC481", "`<include>` names no `file`", include.location)
            return []
        place = include.at("file")
        file = self.find("", name, place)
        if file is None:
            return []
        if file.path in self._included:
            self.report.error("SC486", f"`{cut(name)}` is included twice", place, "MJCF takes each file once")
            return []
        if chain >= self.limits.includes:
            self.report.error("SC452", f"more than {self.limits.includes} files include one another", place)
            return []
        above = self.report.of(place)
        origin = None if above.origin is None else above.origin.into(place)
        findings = self.report.included[file.uri] = FileReport(
            above.sink, origin, above.reported_kinds, budget=above.budget
        )
        root = self._read(file.path, file.uri, findings, chain + 1, depth)
        return [] if root is None else root.children


_DEFAULT_LIMITS = Limits()

_SECTIONS = frozenset({"compiler", "option", "default", "asset", "worldbody"})

_CLASS_ATTRIBUTES = {
    "geom": mjcf_geoms.GEOM_ATTRIBUTES,
    "joint": mjcf_bodies.JOINT_ATTRIBUTES,
    **mjcf_geoms.ASSET_ATTRIBUTES,
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
        limits: `includes`: how many files include one another; `asset_bytes`: size of each.
        name: the file's name as shown to people; None: its uri.
        budget: of all files of the scene; None: it is read alone.
    """
    report = MjcfReport(FileReport(sink, origin, budget=budget))
    files = MjcfFiles(RobotFiles(file, scope), file.uri if name is None else name, limits, report)
    root = files.read()
    if root is None or report.failed:
        return None
    if root.tag != "mujoco":
        hint = "give a URDF with `urdf:`" if root.tag == "robot" else None
        report.error("SC453", f"an MJCF is a <mujoco>, and this is a <{cut(root.tag)}>", root.location, hint)
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
            if mjcf_bodies.has_joint(body):
                trees.append(self._bodies.articulation(body, number))
            elif made := self._bodies.static_body(body):
                static_bodies.append((made, self._bodies.pose(body)))
        static_bodies += [(made, IDENTITY_POSE) for made in self._geoms(worlds)]
        self._assets.report_unread()
        self._assign_ignore_bits([link for links, _ in trees for link in links] + [made for made, _ in static_bodies])
        if self._report.failed:
            return []
        taken = {links[0].name for links, _ in trees}
        for made, _ in static_bodies:
            made.name = _unique_name(made.name, taken)
        return [mjcf_bodies.describe_articulation(links, fixed=fixed) for links, fixed in trees] + [
            mjcf_bodies.describe_static_body(made, pose) for made, pose in static_bodies
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


def _unique_name(name: str, taken: set[str]) -> str:
    """A unique name, which is added to `taken`."""
    number, free = 1, name
    while free in taken:
        number += 1
        free = f"{name}_{number}"
    taken.add(free)
    return free
