"""Finds the files of an MJCF, resolves its includes, and reports what is not built."""

from __future__ import annotations

import os
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
    """Collects findings and reports each kind of unbuilt element once.

    Attributes:
        findings: of the file itself.
        included: findings of each included file, by its displayed name.
        losses: kind, message and location of everything that is not built.
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
        """Returns the report of the file that contains a location."""
        return self.included.get(location.file or "", self.findings)

    def leave_out(self, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Warns about something that is not built, once per kind."""
        self.losses.append((kind, message, location))
        self.of(location).report_once("SC484", kind, message, location, hint)

    def note_elsewhere(self, kind: str, message: str, location: Location) -> None:
        """Notes something that a scene sets elsewhere, once per kind."""
        self.losses.append((kind, message, location))
        self.of(location).report_once("SC490", kind, message, location)


@dataclass(slots=True)
class MjcfFiles:
    """Finds the files that an MJCF names. Paths are relative to the main MJCF, also in included files.

    Attributes:
        named: finds and records files.
        limits: limits of size and depth.
        report: receives the errors.
    """

    named: RobotFiles
    limits: Limits
    report: MjcfReport
    _included: set[Path] = field(default_factory=set["Path"])
    _size: int = 0

    def find(self, written: str, place: Location) -> DescribedFile | None:
        """Returns a file by its path; None after an error at `place`.

        The path may be absolute, as in compiled models, but the file must be inside the allowed folders.
        """
        if written.startswith("/"):
            written = os.path.relpath(written, self.named.owner.path.parent)
        return self.named.find(written, place, self.report.of(place))

    def read_model(self) -> SourceElement | None:
        """Like `read`, but the root must be `<mujoco>` (SC453)."""
        root = self.read()
        if root is None or self.report.failed:
            return None
        if root.tag != "mujoco":
            message = f"the root of an MJCF is <mujoco>, not <{cut(root.tag)}>"
            self.report.error("SC453", message, root.location, OTHER_FORMAT_HINTS.get(root.tag))
            return None
        return root

    def read(self) -> SourceElement | None:
        """Returns the root of the MJCF's tree, with each `include` replaced by the file's content."""
        owner = self.named.owner
        return self._read(owner.path, owner.uri, self.report.findings, 1, 1)

    def _read(self, path: Path, name: str, findings: FileReport, chain: int, depth: int) -> SourceElement | None:
        bounds = XmlBounds()
        self._included.add(path)
        data = read_robot_bytes(path, name, findings, min(bounds.size, self.limits.asset_bytes))
        root = None if data is None else parse_xml(data, name, findings, bounds, self._ignore_rest)
        if data is None or root is None:
            return None
        self._size += len(data)
        if self._size > bounds.size:
            findings.report("SC452", f"the files together have more than {bounds.size} bytes", findings.top(name))
            return None
        self._expand(root, chain, depth)
        return root

    def _ignore_rest(self, place: Location) -> None:
        self.report.leave_out("rest", "what follows the end of the root element is ignored", place)

    def _expand(self, root: SourceElement, chain: int, depth: int) -> None:
        """Replaces each `include` by the file's content. `depth`: of the root in the whole tree."""
        pending = [(root, depth)]
        while pending:
            parent, level = pending.pop()
            if level > XmlBounds().depth:
                what = f"the file is too large: it is nested more than {XmlBounds().depth} elements deep"
                self.report.error("SC452", what, parent.location)
                return
            own = list(parent.children)
            pending.extend((child, level + 1) for child in own if child.tag != "include")
            if any(child.tag == "include" for child in own):
                children: list[SourceElement] = []
                for child in own:
                    children.extend(self._read_included(child, chain, level) if child.tag == "include" else [child])
                parent.children[:] = children

    def _read_included(self, include: SourceElement, chain: int, depth: int) -> list[SourceElement]:
        """Returns the elements of an included file. `depth`: of the element that contains the `include`."""
        name = include.attributes.get("file")
        if name is None:
            self.report.error("SC481", "`<include>` has no `file`", include.location)
            return []
        place = include.at("file")
        file = self.find(name, place)
        if file is None:
            return []
        if file.path in self._included:
            self.report.error("SC486", f"`{cut(name)}` is included twice", place, "MJCF allows each file once")
            return []
        if chain >= self.limits.depth:
            self.report.error("SC452", f"includes are nested more than {self.limits.depth} files deep", place)
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
        """Returns the files and the root of an MJCF that this one attaches at `place`."""
        owner = ResolvedFile(file.path, file.uri)
        files = MjcfFiles(RobotFiles(owner, self.named.scope, found=self.named.found), self.limits, self.report)
        return files, files._read(file.path, file.uri, self._findings(file, place), 1, 1)
