"""Reading of a robot's file and of the files it names: the report of errors, the memory budget and the search for
files.

Errors are reported at the lines of the robot's file, with the place in the scene that names it. Meshes, textures,
SRDF and included files are found as other assets are, inside the folders that the scene may read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from scenecc.diagnostics.codes import CODES
from scenecc.diagnostics.diagnostic import Location, Origin, RelatedPlace
from scenecc.diagnostics.messages import nearest
from scenecc.files import TooLongError, read_at_most
from scenecc.robots.description import DescribedFile
from scenecc.source.paths import AssetScope, Refusal, ResolvedFile, resolve_asset_reference, shorten_uri

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from scenecc.diagnostics import Sink

_MAX_SUGGESTIONS, _MAX_CANDIDATES = 20, 1000
"""Maximum number of errors with a suggested name, and of names to compare."""

OTHER_FORMAT_HINTS = {
    "robot": "give a URDF with `urdf:`",
    "mujoco": "give an MJCF with `mjcf:`",
    "sdf": "make a scene of an SDF with `scenecc import`",
}
"""Root element of a file of another format → hint with what reads it."""

MAX_READ_MEMORY = 2**30
"""Maximum estimated memory for reading all robot files of a scene [bytes]."""

_TEXT_BYTE_COST, _ELEMENT_COST, _FILE_COST = 3, 1024, 4096
"""Estimated memory per byte of text, per element and per file [bytes]."""


@dataclass(slots=True)
class ReadBudget:
    """Budget for reading the robot files of one scene; a file counts each time that it is read. A small scene may
    use one large file at many scales, and many small files that include it.

    Attributes:
        left: remaining estimated memory [bytes].
    """

    left: int = field(default_factory=lambda: MAX_READ_MEMORY)

    def take(self, data: bytes) -> bool:
        """Counts a text that was read, and returns whether the budget sufficed."""
        self.left -= _FILE_COST + _TEXT_BYTE_COST * len(data) + _ELEMENT_COST * data.count(b"<")
        return self.left >= 0


@dataclass(slots=True)
class FileReport:
    """Reports of one robot's file.

    Attributes:
        sink: takes the diagnostics.
        origin: the node of the scene that names the file, if any.
        reported_kinds: (code, kind) of findings that are reported once only.
        errors: number of errors so far.
        budget: of all robot files of the scene; None: the file is read alone.
    """

    sink: Sink
    origin: Origin | None = None
    reported_kinds: set[tuple[str, str]] = field(default_factory=set[tuple[str, str]])
    errors: int = 0
    budget: ReadBudget | None = None

    def place(self, location: Location, *path: str | int) -> Origin | Location:
        """A place in the file, with the scene that led to it. `path`: of the described item."""
        return location if self.origin is None else self.origin.into(location, *path)

    def top(self, file: str) -> Location:
        """The place of a file as a whole."""
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
        """Reports a finding. `path`: of the item that it concerns (`"links", "base"`)."""
        self.errors += CODES[code].severity == "error"
        self.sink.report(code, message, self.place(location, *path), hint=hint, related=related)

    def near(self, word: str, names: Iterable[str]) -> str | None:
        """A hint with a similar name; None if there is none, or after many errors, since the comparison takes time."""
        found = nearest(word, tuple(islice(names, _MAX_CANDIDATES))) if self.errors < _MAX_SUGGESTIONS else None
        return None if found is None else f"did you mean `{found}`?"

    def guess(self, kind: str, word: str, names: Iterable[str]) -> str | None:
        """A similar name, if no such name of this kind (SC454) is reported yet and few kinds are."""
        is_wanted = ("SC454", kind) not in self.reported_kinds and len(self.reported_kinds) < _MAX_SUGGESTIONS
        return nearest(word, tuple(islice(names, _MAX_CANDIDATES))) if is_wanted else None

    def report_once(self, code: str, kind: str, message: str, location: Location, hint: str | None = None) -> None:
        """Reports a finding, but only the first one of its kind."""
        if (code, kind) not in self.reported_kinds:
            self.reported_kinds.add((code, kind))
            self.report(code, message, location, hint=hint)


def read_robot_bytes(path: Path, file: str, findings: FileReport, limit: int) -> bytes | None:
    """The content of a file; None after an error (SC450, SC452): it cannot be read, or is too large.

    Args:
        path: of the file.
        file: its name as shown to people.
        findings: where it is reported.
        limit: its largest size [bytes].
    """
    try:
        data = read_at_most(path, limit)
    except TooLongError as error:
        findings.report("SC452", f"the file is too large: {error.strerror}", findings.top(file))
        return None
    except OSError as error:
        findings.report("SC450", f"the file cannot be read: {error.strerror or error}", findings.top(file))
        return None
    if findings.budget is not None and not findings.budget.take(data):
        findings.report(
            "SC452",
            f"the robots' files of the scene take more than {MAX_READ_MEMORY} bytes of memory",
            findings.top(file),
            hint="use fewer files, or each at fewer scales, for it is read again for each",
        )
        return None
    return data


_PACKAGE_SCHEME = "package://"

_MAX_PARENT_FOLDERS = 40
"""Maximum number of parent folders in which a ROS package is searched."""

_FILE_NOT_FOUND = "SC401"

_NO_FILE = (_FILE_NOT_FOUND, "SC403")
"""Codes of references to no file: it is missing, or has a scheme that is not read."""

MAX_MISSING = 1000
"""Maximum number of missing files that are looked for: each takes milliseconds, in all folders of a package."""


@dataclass(frozen=True, slots=True)
class RobotFiles:
    """Finds and records the files that one robot file names.

    Attributes:
        owner: the robot's file.
        scope: what may be read.
        package: finds what follows `package://` in the folder that the scene gives for it; None: it gives none.
        repairs: whether the scene says `repair: [files]`, so that files that are not needed may be missing.
        found: every file that was found, by uri.
        missing: why each reference was not found.
    """

    owner: ResolvedFile
    scope: AssetScope
    package: Callable[[str], ResolvedFile | Refusal] | None = None
    repairs: bool = False
    found: dict[str, DescribedFile] = field(default_factory=dict[str, DescribedFile])
    missing: dict[str, Refusal] = field(default_factory=dict[str, Refusal])

    def find(
        self,
        reference: str,
        location: Location,
        findings: FileReport,
        *,
        repaired: str | None = None,
    ) -> DescribedFile | None:
        """The file of a reference; None after an error, with a code of `scenecc.source.paths`, or a repair (SC488).

        A relative path is one from the robot's own folder. `package://PACKAGE/PATH` is `PACKAGE/PATH` in the folder
        that the scene gives, else in the robot's own, else in the nearest above it that has it: so does SAPIEN, which
        goes on up to the root of the file system, and here the scene's folders end it.

        Args:
            reference: as it is written.
            location: where it is.
            findings: takes the error or the note.
            repaired: what `repair: [files]` makes of a missing file, in words; None: nothing.
        """
        if len(self.missing) >= MAX_MISSING and reference not in self.missing:
            message = f"more than {MAX_MISSING} files that it names are missing, and the others are not looked for"
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
        return self.add(found, location)

    def _search(self, reference: str) -> ResolvedFile | Refusal:
        if reference.startswith(_PACKAGE_SCHEME):
            return self._find_in_packages(reference[len(_PACKAGE_SCHEME) :])
        return resolve_asset_reference(reference, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope)

    def find_sibling(self, name: str) -> ResolvedFile | None:
        """A file in the folder of the robot's file; None if there is none that may be read."""
        found = resolve_asset_reference(name, owner=self.owner.path, owner_uri=self.owner.uri, scope=self.scope)
        return None if isinstance(found, Refusal) else ResolvedFile(found.path, self._uri(found))

    def add(self, file: ResolvedFile, location: Location) -> DescribedFile:
        """Records a file that was found."""
        uri = self._uri(file)
        self.scope.memory.note(ResolvedFile(file.path, uri), self.owner.uri)
        return self.found.setdefault(uri, DescribedFile(uri, file.path, location))

    def _find_in_packages(self, written: str) -> ResolvedFile | Refusal:
        # `package:///PACKAGE/PATH` is written too, and read by pinocchio among others.
        inner = written.lstrip("/")
        found = self._find_in_folders(inner) if inner else None
        if isinstance(found, ResolvedFile) or (found is not None and written == inner):
            return found
        shown = shorten_uri(_PACKAGE_SCHEME + written)
        return Refusal("SC403", f"`{shown}` names no file", "write package://PACKAGE/PATH")

    def _find_in_folders(self, inner: str) -> ResolvedFile | Refusal:
        given = None if self.package is None else self.package(inner)
        if isinstance(given, ResolvedFile):
            return given
        first: Refusal | None = None if given is None or given.code == _FILE_NOT_FOUND else given
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
        """Where a reference was searched, in words."""
        folder = self.owner.path.parent
        if not reference.startswith(_PACKAGE_SCHEME):
            return f"it in {folder}"
        given = "" if self.package is None else "the package_dir of the scene, "
        path = shorten_uri(reference[len(_PACKAGE_SCHEME) :])
        return f"`{path}` in {given}{folder} and the folders above it that may be read"

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
