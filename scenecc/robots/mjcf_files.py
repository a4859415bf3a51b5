"""What the two readers of MJCF share: the report of what is not built, and the search for files and includes."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field
from functools import reduce
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.robots.files import OTHER_FORMAT_HINTS, FileReport, RobotFiles, read_robot_bytes
from scenecc.robots.xml import SourceElement, XmlBounds, parse_xml
from scenecc.source.paths import ResolvedFile

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.description import DescribedFile
    from scenecc.source.limits import Limits

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
        losses: kind, message and place of everything that is not built from the file.
    """

    findings: FileReport
    included: dict[str, FileReport] = field(default_factory=dict[str, "FileReport"])
    losses: list[tuple[str, str, Location]] = field(default_factory=list["tuple[str, str, Location]"])
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
        self.losses.append((kind, message, location))
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

    def elsewhere(self, kind: str, message: str, location: Location) -> None:
        """Notes what a scene says in another place, once per kind."""
        self.losses.append((kind, message, location))
        self.of(location).report_once("SC490", kind, message, location)

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

    def read_model(self) -> SourceElement | None:
        """As `read`; None also after an error, SC453: the root is no `<mujoco>`."""
        root = self.read()
        if root is None or self.report.failed:
            return None
        if root.tag != "mujoco":
            message = f"an MJCF is a <mujoco>, and this is a <{cut(root.tag)}>"
            self.report.error("SC453", message, root.location, OTHER_FORMAT_HINTS.get(root.tag))
            return None
        return root

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
        root = self._read(file.path, file.uri, self._findings(file, place), chain + 1, depth)
        return [] if root is None else root.children

    def _findings(self, file: DescribedFile, place: Location) -> FileReport:
        above = self.report.of(place)
        origin = None if above.origin is None else above.origin.into(place)
        made = FileReport(above.sink, origin, above.reported_kinds, budget=above.budget)
        self.report.included[file.uri] = made
        return made

    def attach(self, file: DescribedFile, place: Location) -> tuple[MjcfFiles, SourceElement | None]:
        """What another MJCF names, which this one attaches at `place`, and the root of its tree."""
        owner = ResolvedFile(file.path, file.uri)
        files = MjcfFiles(
            RobotFiles(owner, self.named.scope, found=self.named.found), file.uri, self.limits, self.report
        )
        return files, files._read(file.path, file.uri, self._findings(file, place), 1, 1)
