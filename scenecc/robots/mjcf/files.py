"""The files that an MJCF leads to: those that it includes, meshes and images."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut
from scenecc.robots.findings import Findings, read_robot_bytes
from scenecc.robots.xml import XmlBounds, parse_xml

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics import Location
    from scenecc.robots.description import NamedFile
    from scenecc.robots.files import RobotFiles
    from scenecc.robots.mjcf.report import Report
    from scenecc.robots.xml import Element
    from scenecc.source.limits import Limits


@dataclass(slots=True)
class Files:
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
    report: Report
    _included: set[Path] = field(default_factory=set["Path"])
    _size: int = 0

    def find(self, folder: str, written: str, place: Location) -> NamedFile | None:
        """A file by its path from a folder; None, reported at `place`, where it may not be used."""
        reference = written if written.startswith("/") or not folder else posixpath.join(folder, written)
        return self.named.find(reference if written else "", place, self.report.of(place))

    def read(self) -> Element | None:
        """The root of the MJCF's tree, with everything that it includes in place of each `include`."""
        owner = self.named.owner
        return self._read(owner.path, self.name, self.report.findings, 1, 1)

    def _read(self, path: Path, name: str, findings: Findings, chain: int, depth: int) -> Element | None:
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

    def _expand(self, root: Element, chain: int, depth: int) -> None:
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
                children: list[Element] = []
                for child in own:
                    children.extend(self._content(child, chain, level) if child.tag == "include" else [child])
                parent.children[:] = children

    def _content(self, include: Element, chain: int, depth: int) -> list[Element]:
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
        findings = self.report.included[file.uri] = Findings(above.sink, origin, above.told, budget=above.budget)
        root = self._read(file.path, file.uri, findings, chain + 1, depth)
        return [] if root is None else root.children
