"""The files that a robot's file names: meshes, textures, an SRDF, included files. Found as an asset's files are, inside
what the scene may read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.robots.description import NamedFile
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, resolve_asset_reference, shorten_uri

if TYPE_CHECKING:
    from collections.abc import Callable

    from scenecc.diagnostics import Location
    from scenecc.robots.findings import Findings

_PACKAGE = "package://"

_TRIES = 40
"""In how many folders above the robot's own a ROS package is looked for."""

_ABSENT = "SC401"


@dataclass(frozen=True, slots=True)
class RobotFiles:
    """Finds what one robot's file names, and remembers it.

    Attributes:
        owner: the robot's file.
        scope: what may be read.
        package: finds what follows `package://` in the folder that the scene gives for it; None: it gives none.
        found: every file that was found, by uri.
    """

    owner: ResolvedFile
    scope: AssetScope
    package: Callable[[str], ResolvedFile | Refusal] | None = None
    found: dict[str, NamedFile] = field(default_factory=dict[str, NamedFile])

    def find(self, reference: str, location: Location, findings: Findings) -> NamedFile | None:
        """The file of a reference as written; None where there is none, reported with a code of `scenecc.source.paths`.

        A relative path is one from the robot's own folder. `package://PACKAGE/PATH` is `PACKAGE/PATH` in the folder
        that the scene gives, else in the robot's own, else in the nearest above it that has it: so does SAPIEN, which
        goes on up to the root of the file system, and here the scene's folders end it.
        """
        if reference.startswith(_PACKAGE):
            found = self._in_packages(reference[len(_PACKAGE) :])
        else:
            found = resolve_asset_reference(
                reference, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope
            )
        if isinstance(found, Refusal):
            hint = found.hint
            if found.code == _ABSENT:
                near = "" if hint is None else f"; {hint}"
                hint = f"looked for {self._looked(reference)}{near}"
            findings.report(found.code, found.message, location, hint=hint)
            return None
        return self.add(found, location)

    def beside(self, name: str) -> ResolvedFile | None:
        """A file beside the robot's own; None where there is none that may be read."""
        found = resolve_asset_reference(name, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope)
        return None if isinstance(found, Refusal) else ResolvedFile(found.path, self._uri(found))

    def add(self, file: ResolvedFile, location: Location) -> NamedFile:
        """Remembers a file that was found."""
        uri = self._uri(file)
        self.scope.memory.note(ResolvedFile(file.path, uri), self.owner.uri)
        return self.found.setdefault(uri, NamedFile(uri, file.path, location))

    def _in_packages(self, inner: str) -> ResolvedFile | Refusal:
        if not inner or inner.startswith("/"):
            return Refusal("SC403", f"`{shorten_uri(_PACKAGE + inner)}` names no file", "write package://PACKAGE/PATH")
        given = None if self.package is None else self.package(inner)
        if isinstance(given, ResolvedFile):
            return given
        first: Refusal | None = None if given is None or given.code == _ABSENT else given
        for step in range(min(_TRIES, len(self.owner.path.parents))):
            reference = "../" * step + inner
            found = resolve_asset_reference(
                reference, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope
            )
            if isinstance(found, ResolvedFile):
                return found
            if found.code == "SC402" and step:
                break
            if found.code != _ABSENT and first is None:
                first = found
        return first or Refusal(_ABSENT, f"there is no file `{shorten_uri(_PACKAGE + inner)}`")

    def _looked(self, reference: str) -> str:
        """Where it was looked for, in words."""
        folder = self.owner.path.parent
        if not reference.startswith(_PACKAGE):
            return f"it in {folder}"
        given = "" if self.package is None else "the package_dir of the scene, "
        return (
            f"`{shorten_uri(reference[len(_PACKAGE) :])}` in {given}{folder} and the folders above it that may be read"
        )

    def _uri(self, found: ResolvedFile) -> str:
        """A uri as a scene would name the file: by the scheme by which it names the robot's own file, if by one."""
        scheme, separator, inner = self.owner.uri.partition("://")
        if not separator or "://" in found.uri:
            return found.uri
        above = Path(inner).parents
        # The last of the parents is `.`, which of a package is its name's own parent.
        for level, folder in enumerate(self.owner.path.parents[: len(above) - (scheme == "pkg")]):
            if found.path.is_relative_to(folder):
                return f"{scheme}://{(above[level] / found.path.relative_to(folder)).as_posix()}"
        return found.uri
