"""Reports, memory budget and file search of the robot readers.

Errors are reported at the lines of the robot's file, with the place in the scene that names it. Meshes, textures, SRDF
and included files must be inside the folders that the scene may read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import Location, Origin, RelatedPlace
from scenecc.diagnostics.messages import cut, nearest
from scenecc.files import TooLongError, read_at_most
from scenecc.robots.description import DescribedFile
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, resolve_asset_reference, shorten_uri

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.diagnostics import Sink

_MAX_SUGGESTIONS, _MAX_CANDIDATES = 20, 1000
"""Maximum number of errors with a suggested name, and of names to compare."""

OTHER_FORMAT_HINTS = {
    "robot": "write `urdf: FILE` for a URDF",
    "mujoco": "give an MJCF with `mjcf:`",
    "sdf": "make a scene of an SDF with `scenecc import`",
}
"""Root element of another format → hint how to read it."""

MAX_READ_MEMORY = 2**30
"""Maximum estimated memory for reading all robot files of a scene [bytes]."""

_TEXT_BYTE_COST, _ELEMENT_COST, _FILE_COST = 3, 1024, 4096
"""Estimated memory per byte of text, per element and per file [bytes]."""


@dataclass(slots=True)
class ReadBudget:
    """Memory budget for reading the robot files of one scene. A file counts each time it is read: a small scene may use
    a large file at many scales, or through many includes.

    Attributes:
        left: remaining estimated memory [bytes].
    """

    left: int = field(default_factory=lambda: MAX_READ_MEMORY)

    def take(self, data: bytes, *, is_xml: bool = True) -> bool:
        """Counts a file; returns whether the budget sufficed."""
        self.left -= _FILE_COST + len(data)
        if is_xml:
            self.left -= (_TEXT_BYTE_COST - 1) * len(data) + _ELEMENT_COST * data.count(b"<")
        return self.left >= 0


@dataclass(slots=True)
class FileReport:
    """Reports findings of one robot file.

    Attributes:
        sink: receives the diagnostics.
        origin: the scene node that names the file, if any.
        reported_kinds: (code, kind) of findings that are reported once.
        errors: number of errors so far.
        budget: shared by all robot files of the scene; None: no budget.
    """

    sink: Sink
    origin: Origin | None = None
    reported_kinds: set[tuple[str, str]] = field(default_factory=set[tuple[str, str]])
    errors: int = 0
    budget: ReadBudget | None = None

    def place(self, location: Location, *path: str | int) -> Origin | Location:
        """Returns a place in the file, with the scene that led to it. `path`: of the described item."""
        return location if self.origin is None else self.origin.into(location, *path)

    def top(self, file: str) -> Location:
        """Returns the location of the file as a whole."""
        return Location(file)

    def report(
        self,
        code: str,
        message: str,
        location: Location,
        *path: str | int,
        hint: str | None = None,
        related: Iterable[RelatedPlace] = (),
    ) -> None:
        """Reports a finding. `path`: of the item (`"links", "base"`)."""
        self.errors += CODES[code].severity == "error"
        self.sink.report(code, message, self.place(location, *path), hint=hint, related=related)

    def near(self, word: str, names: Iterable[str]) -> str | None:
        """Returns a hint with a similar name; None if there is none, or after many errors, as the search takes time."""
        found = nearest(word, tuple(islice(names, _MAX_CANDIDATES))) if self.errors < _MAX_SUGGESTIONS else None
        return None if found is None else f"did you mean `{found}`?"

    def guess(self, kind: str, word: str, names: Iterable[str]) -> str | None:
        """Returns a similar name, unless this kind of SC454 was reported already or too many kinds were."""
        is_wanted = ("SC454", kind) not in self.reported_kinds and len(self.reported_kinds) < _MAX_SUGGESTIONS
        return nearest(word, tuple(islice(names, _MAX_CANDIDATES))) if is_wanted else None

    def report_once(self, code: str, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Reports only the first finding of its kind."""
        if (code, kind) not in self.reported_kinds:
            self.reported_kinds.add((code, kind))
            self.report(code, message, location, hint=hint)


def read_robot_bytes(path: Path, file: str, findings: FileReport, limit: int, *, is_xml: bool = True) -> bytes | None:
    """Returns the content of a file; None after an error (SC450: unreadable, SC452: too large).

    Args:
        path: path of the file.
        file: displayed file name.
        findings: receives the errors.
        limit: maximum size [bytes].
        is_xml: whether it is parsed, which needs much more memory.
    """
    try:
        data = read_at_most(path, limit)
    except TooLongError as error:
        findings.report("SC452", f"the file is too large: {error.strerror}", findings.top(file))
        return None
    except OSError as error:
        findings.report("SC450", f"the file cannot be read: {error.strerror or error}", findings.top(file))
        return None
    if findings.budget is not None and not findings.budget.take(data, is_xml=is_xml):
        findings.report(
            "SC452",
            f"the scene's robot files need more than {MAX_READ_MEMORY} bytes of memory",
            findings.top(file),
            hint="use fewer files or fewer scales; a file is read again for each scale",
        )
        return None
    return data


_PACKAGE_SCHEME = "package://"

_MAX_PARENT_FOLDERS = 40
"""Maximum number of parent folders in which a ROS package is searched."""

_FILE_NOT_FOUND = "SC401"

_NO_FILE = (_FILE_NOT_FOUND, "SC403")
"""Codes of unresolved references: a missing file, or an unknown scheme."""

MAX_MISSING = 1000
"""Maximum number of missing files to search for: each search takes milliseconds, in all folders of a package."""


@dataclass(frozen=True, slots=True)
class RobotFiles:
    """Finds and records the files that a robot file names.

    Attributes:
        owner: the robot's file.
        scope: folders that may be read.
        package: resolves a `package://` path in the folder that the scene gives; None: the scene gives none.
        repairs: whether the scene sets `repair: [files]`, so that optional files may be missing.
        found: files found, by URI.
        missing: error of each reference that was not found.
        elsewhere: references to packages that were found in a folder with another name.
    """

    owner: ResolvedFile
    scope: AssetScope
    package: Callable[[str], ResolvedFile | Refusal] | None = None
    repairs: bool = False
    found: dict[str, DescribedFile] = field(default_factory=dict[str, DescribedFile])
    missing: dict[str, Refusal] = field(default_factory=dict[str, Refusal])
    elsewhere: set[str] = field(default_factory=set[str])

    def find(
        self,
        reference: str,
        location: Location,
        findings: FileReport,
        *,
        repaired: str | None = None,
    ) -> DescribedFile | None:
        """Returns the file of a reference; None after an error (codes of `scenecc.source.paths`) or a repair (SC488).

        A relative path starts in the robot's folder. `package://PACKAGE/PATH` is searched for as `PACKAGE/PATH` in the
        scene's `package_dir`, then in the robot's folder, then in its parents. SAPIEN searches up to the root of the
        file system; here the search ends at the folders that the scene may read.

        Args:
            reference: as written.
            location: where it is written.
            findings: receives the error or note.
            repaired: text for what `repair: [files]` does about a missing file; None: nothing.
        """
        if len(self.missing) >= MAX_MISSING and reference not in self.missing:
            message = f"more than {MAX_MISSING} of its files are missing; the rest are not checked"
            findings.report_once("SC452", "missing files", message, location)
            return None
        found = self.missing.get(reference) or self._search(reference)
        if isinstance(found, Refusal):
            self.missing[reference] = found
            hint = found.hint
            if found.code in _NO_FILE and repaired is not None and self.repairs:
                findings.report("SC488", f"{found.message}: {repaired}", location)
                return None
            if found.code in _NO_FILE:
                looked = f"looked for {self._searched_places(reference)}" if found.code == _FILE_NOT_FOUND else None
                repair = None if repaired is None else f"with `repair: [files]` in the scene {repaired}"
                hint = "; ".join(part for part in (looked, hint, repair) if part) or None
            findings.report(found.code, found.message, location, hint=hint)
            return None
        if reference in self.elsewhere:
            package, _, inner = reference[len(_PACKAGE_SCHEME) :].lstrip("/").partition("/")
            message = f"there is no package `{cut(package)}`: `{cut(inner)}` is taken from `{self._uri(found)}`"
            findings.report_once("SC449", package, message, location)
        return self.add(found, location)

    def _search(self, reference: str) -> ResolvedFile | Refusal:
        if reference.startswith(_PACKAGE_SCHEME):
            return self._find_in_packages(reference[len(_PACKAGE_SCHEME) :])
        return resolve_asset_reference(reference, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope)

    def find_sibling(self, name: str) -> ResolvedFile | None:
        """Returns a file in the robot's folder; None if there is none that may be read."""
        found = resolve_asset_reference(name, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope)
        return None if isinstance(found, Refusal) else ResolvedFile(found.path, self._uri(found))

    def add(self, file: ResolvedFile, location: Location) -> DescribedFile:
        """Records a file."""
        uri = self._uri(file)
        self.scope.memory.note(ResolvedFile(file.path, uri), self.owner.uri)
        return self.found.setdefault(uri, DescribedFile(uri, file.path, location))

    def _find_in_packages(self, written: str) -> ResolvedFile | Refusal:
        # `package:///PACKAGE/PATH` occurs too; pinocchio, for one, accepts it.
        inner = written.lstrip("/")
        found = self._find_in_folders(inner) if inner else None
        if isinstance(found, Refusal) and found.code == _FILE_NOT_FOUND:
            # The package's folder may have another name here: the longest end of the path decides.
            parts = inner.split("/")
            ends = ("/".join(parts[start:]) for start in range(1, len(parts) - 1))
            other = next((file for end in ends if isinstance(file := self._find_above(end), ResolvedFile)), None)
            if other is not None:
                self.elsewhere.add(_PACKAGE_SCHEME + written)
                return other
        if isinstance(found, ResolvedFile) or (found is not None and written == inner):
            return found
        shown = shorten_uri(_PACKAGE_SCHEME + written)
        return Refusal("SC403", f"`{shown}` does not name a file", "write package://PACKAGE/PATH")

    def _find_in_folders(self, inner: str) -> ResolvedFile | Refusal:
        given = None if self.package is None else self.package(inner)
        if isinstance(given, ResolvedFile):
            return given
        return self._find_above(inner, None if given is None or given.code == _FILE_NOT_FOUND else given)

    def _find_above(self, inner: str, first: Refusal | None = None) -> ResolvedFile | Refusal:
        """Returns a file in the robot's folder or the nearest folder above. `first`: the refusal to return, if any."""
        for step in range(min(_MAX_PARENT_FOLDERS, len(self.owner.path.parents))):
            reference = "../" * step + inner
            found = resolve_asset_reference(
                reference, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope
            )
            if isinstance(found, ResolvedFile):
                return found
            if found.code == "SC402" and step:
                break
            if found.code != _FILE_NOT_FOUND and first is None:
                first = found
        return first or Refusal(_FILE_NOT_FOUND, f"there is no file `{shorten_uri(_PACKAGE_SCHEME + inner)}`")

    def _searched_places(self, reference: str) -> str:
        folder = self.owner.path.parent
        if not reference.startswith(_PACKAGE_SCHEME):
            return f"it in {folder}"
        given = "" if self.package is None else "the package_dir of the scene, "
        path = shorten_uri(reference[len(_PACKAGE_SCHEME) :])
        return f"`{path}` in {given}{folder} and the folders above it that may be read"

    def _uri(self, found: ResolvedFile) -> str:
        """Returns the file's URI for a scene, with the scheme of the robot's own URI if it has one."""
        scheme, separator, inner = self.owner.uri.partition("://")
        if not separator or "://" in found.uri:
            return found.uri
        above = Path(inner).parents
        # The last parent is `.`, which is the parent of a package's name.
        for level, folder in enumerate(self.owner.path.parents[: len(above) - (scheme == "pkg")]):
            if found.path.is_relative_to(folder):
                return f"{scheme}://{(above[level] / found.path.relative_to(folder)).as_posix()}"
        return found.uri
