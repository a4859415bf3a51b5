"""The files of an MJCF: the report of what is not built of them, and the search for files and includes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.robots.files import OTHER_FORMAT_HINTS, FileReport, RobotFiles, read_robot_bytes
from scenecc.robots.xml import SourceElement, XmlBounds, parse_xml
from scenecc.source.paths import ResolvedFile

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Location
    from scenecc.robots.description import DescribedFile
    from scenecc.source.limits import Limits


@dataclass(slots=True)
class MjcfReport:
    """Collects findings, so that each kind of what is not built is reported once.

    Attributes:
        findings: of the file itself.
        included: the findings of each included file, by its displayed name.
        losses: kind, message and place of everything that is not built from the file.
    """

    findings: FileReport
    included: dict[str, FileReport] = field(default_factory=dict[str, "FileReport"])
    losses: list[tuple[str, str, Location]] = field(default_factory=list["tuple[str, str, Location]"])

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

    def elsewhere(self, kind: str, message: str, location: Location) -> None:
        """Notes what a scene says in another place, once per kind."""
        self.losses.append((kind, message, location))
        self.of(location).report_once("SC490", kind, message, location)


@dataclass(slots=True)
class MjcfFiles:
    """Finds the files that an MJCF names. All are named from the folder of the MJCF itself, in included files too.

    Attributes:
        named: finds and remembers them.
        limits: how much is read.
        report: where faults go.
    """

    named: RobotFiles
    limits: Limits
    report: MjcfReport
    _included: set[Path] = field(default_factory=set["Path"])
    _size: int = 0

    def find(self, written: str, place: Location) -> DescribedFile | None:
        """A file by its path; None, reported at `place`, where it may not be used."""
        return self.named.find(written, place, self.report.of(place))

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
        return self._read(owner.path, owner.uri, self.report.findings, 1, 1)

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
        """Replaces each `include` by its content. `depth`: of the root among all elements."""
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
        """The elements of an included file. `depth`: of the element that holds the `include`."""
        name = include.attributes.get("file")
        if name is None:
            self.report.error("SC481", "`<include>` names no `file`", include.location)
            return []
        place = include.at("file")
        file = self.find(name, place)
        if file is None:
            return []
        if file.path in self._included:
            self.report.error("SC486", f"`{cut(name)}` is included twice", place, "MJCF takes each file once")
            return []
        if chain >= self.limits.depth:
            self.report.error("SC452", f"more than {self.limits.depth} files include one another", place)
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
        files = MjcfFiles(RobotFiles(owner, self.named.scope, found=self.named.found), self.limits, self.report)
        return files, files._read(file.path, file.uri, self._findings(file, place), 1, 1)
