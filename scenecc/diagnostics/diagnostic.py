"""Diagnostics, their locations, and the sink that collects the reports of every stage."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import field, replace
from typing import Final, Literal, TypeVar

from scenecc.diagnostics.codes import CODES, Severity
from scenecc.diagnostics.frozen import frozen

PathKey = str | int
"""One step into a document: a mapping's key or a list's index."""

Path = tuple[PathKey, ...]

At = Literal["value", "key"]
"""Which half of a mapping's entry is meant. A list item has only a value."""


@frozen
class Origin:
    """The node of a document that caused something.

    Cheap to make (a valid file makes thousands and prints none): the line is looked up only when a diagnostic is
    printed.

    Attributes:
        file: name of the document for messages; None for a dict.
        path: keys and indices from the document's root.
        copy: which copy of a repeated node ("i=1, j=-1"); empty for a node written once.
        parent: the node that references this document (a `use`, an item of `include`, a robot's file); None for the top
            document.
        location: its location, if already known: in a text that is not a scene file.
    """

    file: str | None
    path: Path = ()
    copy: str = ""
    parent: Origin | None = None
    location: Location | None = None

    def child(self, *keys: PathKey) -> Origin:
        """Returns the origin of a node below this one."""
        return Origin(self.file, self.path + keys, self.copy, self.parent, self.location)

    def into(self, location: Location, *path: PathKey) -> Origin:
        """Returns the origin of a line in another text, which this node references. `path`: path of its content."""
        return Origin(location.file, path, "", self, location)


@frozen
class Location:
    """A place in a text. Lines and columns count from 1; columns count characters.

    Attributes:
        file: name of the document for messages.
        line: 1-based line; None if the document has no text (a dict).
        column: 1-based column of the first character.
        end_column: column after the last character to underline, on the same line.
        text: the whole line, without its line break.
    """

    file: str | None
    line: int | None = None
    column: int | None = None
    end_column: int | None = None
    text: str | None = None


Locator = Callable[[Origin, At], Location]
"""Returns the location of an origin. It never fails: if nothing is found, the location has no line."""

Tracer = Callable[[Origin], Origin]
"""Maps an origin in an expanded document to the origin as written. It never fails."""


def as_written(origin: Origin) -> Origin:
    """Tracer of documents that are compiled as written."""
    return origin


def nowhere(origin: Origin, at: At) -> Location:
    """Locator of documents without text."""
    del at
    return Location(origin.file)


_QUOTED = frozenset(". []\"'\n\t")


def dotted(path: Path) -> str:
    """Returns a path as users write it: `entities.cube.shapes[0].half_size[1]`.

    Keys with dots, brackets or blanks are quoted: `entities["a.b"]`.
    """
    out: list[str] = []
    for key in path:
        if isinstance(key, int):
            out.append(f"[{key}]")
        elif key and _QUOTED.isdisjoint(key):
            out.append(f".{key}" if out else key)
        else:
            out.append('["' + key.replace("\\", "\\\\").replace('"', '\\"') + '"]')
    return "".join(out)


Span = tuple[int, int]
"""First character, and the one after the last, in the value of a scalar."""

_BEFORE = re.compile(r"(?:[&!]\S*\s+)*")
"""An anchor and a tag before a scalar."""

_CHARACTER = {
    '"': re.compile(r"\\x..|\\u.{4}|\\U.{8}|\\.|[^\"\\]"),
    "'": re.compile(r"''|[^']"),
    "": re.compile(r"."),
}
"""The notation of one character: in double quotes, in single quotes, and in plain text."""


def locate_span(location: Location, span: Span) -> Location:
    """Returns the location of a part of a scalar; that of the scalar if the part does not begin on its first line.

    Args:
        location: location of the scalar.
        span: the part.
    """
    if location.column is None or location.text is None:
        return location
    start = location.column - 1
    end = len(location.text) if location.end_column is None else location.end_column - 1
    match = _BEFORE.match(location.text, start, end)
    start = match.end() if match else start
    first = location.text[start : start + 1]
    if first in {"|", ">"}:
        return location
    style = first if first in {'"', "'"} else ""
    columns = [found.start() for found in _CHARACTER[style].finditer(location.text, start + len(style), end)]
    if span[0] >= len(columns):
        return location
    last = columns[min(span[1], len(columns)) - 1] + 1 if span[1] > span[0] else columns[span[0]] + 1
    return replace(location, column=columns[span[0]] + 1, end_column=last + 1)


_Key = TypeVar("_Key")

_Other = TypeVar("_Other")

MAX_REPORTS = 1000
"""Maximum number of reported errors, and of warnings: a file full of errors must not fill the memory."""


@frozen
class Related:
    """A second place of a diagnostic, for example the first of two equal keys."""

    message: str
    location: Location


@frozen
class Fix:
    """A safe correction: a replacement for a part of one line."""

    location: Location
    text: str


STAGES: Final = ("YAML", "keys and values", "parameters and prefabs", "names and poses", "physics")
"""What `validate` checks, in this order. After an error in one stage, later ones do not run."""


@frozen
class Diagnostic:
    """A finding.

    Attributes:
        code: `SC` and three digits, a row of `scenecc.diagnostics.codes.CODES`.
        severity: errors stop the pipeline; warnings and notes do not.
        message: one sentence about this file, without its place.
        location: file, line and columns, as far as known.
        path: path in the document (`entities.cube.mass`); "" for the whole document. For wrong usage, the argument or
            option.
        hint: how to fix it, if the message does not say.
        related: related places, nearest first.
        fix: what `--fix` writes, if there is one safe correction.
        stage: the stage of `STAGES` that reported it; "" for a later one.
    """

    code: str
    severity: Severity
    message: str
    location: Location
    path: str = ""
    hint: str | None = None
    related: tuple[Related, ...] = ()
    fix: Fix | None = None
    stage: str = field(default="", compare=False)

    @property
    def file(self) -> str | None:
        """Name of the document; None for a dict, or if no file is at fault."""
        return self.location.file

    @property
    def line(self) -> int | None:
        """1-based line; None if there is no text."""
        return self.location.line

    @property
    def column(self) -> int | None:
        """1-based column; None if there is no text."""
        return self.location.column

    @property
    def place(self) -> str:
        """Where it is, in words: a file, a dict, a wrong argument, or scenecc for errors of the machine."""
        if self.file:
            return self.file
        return "<dict>" if self._is_in_dict else self.path or "scenecc"

    @property
    def node(self) -> str:
        """The path in the document; "" for the whole document, or if there is none."""
        return self.path if self.file or self._is_in_dict else ""

    @property
    def _is_in_dict(self) -> bool:
        fault = CODES[self.code].at_fault if self.code in CODES else "scene"
        if self.path.startswith("--") or fault == "usage":
            return False
        return fault == "scene" or bool(self.path)

    def __str__(self) -> str:
        where = ":".join(str(x) for x in (self.place, self.line, self.column) if x is not None)
        path = f" ({self.node})" if self.node else ""
        return f"{where}: {self.severity} {self.code}: {self.message}{path}"


def _given_nowhere(_origin: Origin) -> tuple[Origin, ...]:
    """The `given` function of documents without prefabs."""
    return ()


_USERS = 10
"""Maximum number of listed nodes that reference the same file."""

_PACKAGED: Final = ("scenecc:", "pkg:")
"""Beginnings of the names of files that are part of packages."""

IN_PREFAB: Final = "the place in the prefab"
"""Message of the related place of a finding that is placed at the `use` of its prefab."""

_STOPPED = "SC016"
"""The code that replaces all errors beyond the maximum."""

RelatedPlace = tuple[str, Origin | Location, At]
"""A message, its place, and which half of the entry it concerns."""


@frozen
class _Report:
    code: str
    severity: Severity
    message: str
    place: Origin | Location
    at: At
    hint: str | None
    related: tuple[RelatedPlace, ...]
    path: Path
    span: Span | None
    parent: Origin | None
    fix: tuple[At, str] | None
    stage: str


_Repeated = tuple[str, str | None, Path, int | None]
"""The code and place that copies of one node have in common."""


def _repeated(code: str, place: Origin) -> _Repeated:
    return code, place.file, place.path, None if place.location is None else place.location.line


_OF_SAMPLES = frozenset(("SC514", "SC516"))
"""Warnings about other seeds. Objects that share a material or a draw may give its place an error as well."""


class Sink:
    """Collects the reports of the stages; origins become lines only when read.

    Attributes:
        locate: finds an origin in its text. Set by the pipeline once there is a document.
        trace: maps origins of later reports to what was written. Set by the pipeline once a document is expanded.
        given: finds where the parameters read by a node in a prefab are given. Set by the pipeline.
        overridden: finds where keys of a node are overridden. Set by the pipeline.
        parent: the node that includes the document being read; the document's locations do not contain it.
        silencings: comments that silence findings, of all files read.
        at_use: whether findings in a prefab are placed at its outermost `use`, with a note in the prefab.
        stage: the stage of `STAGES` that is running; "" for a later one. Set by the pipeline.
    """

    def __init__(self, locate: Locator = nowhere) -> None:
        self.locate = locate
        self.trace: Tracer = as_written
        self.given: Callable[[Origin], tuple[Origin, ...]] = _given_nowhere
        self.overridden: Callable[[Origin], tuple[Origin, ...]] = _given_nowhere
        self._misgiven: dict[tuple[str, tuple[Origin, ...]], Origin] = {}
        self.parent: Origin | None = None
        self.silencings: Silencings = {}
        self.at_use = False
        self.stage = ""
        self._reports: list[_Report] = []
        self._seen: set[tuple[str, str, Origin | Location]] = set()
        self._failed = False
        self._counts: Counter[Severity] = Counter()
        self._full: set[Severity] = set()
        self._first: dict[_Repeated, Origin] = {}
        self._others: dict[_Repeated, dict[tuple[str, Origin | None], None]] = {}
        self._users: dict[Origin, dict[Origin, None]] = {}
        self._is_alike = False
        self._alike: dict[tuple[str, Origin | Location], dict[str, None]] = {}

    def another(self) -> Sink:
        """Returns an empty sink for the same documents."""
        made = Sink(self.locate)
        made.trace, made.given, made.overridden = self.trace, self.given, self.overridden
        made.silencings = self.silencings
        return made

    @property
    def failed(self) -> bool:
        """Whether an error was reported."""
        return self._failed

    @property
    def full(self) -> bool:
        """Whether no more errors are stored, so that further checks are useless."""
        return "error" in self._full

    @property
    def reported(self) -> int:
        """The number of findings."""
        return len(self._reports)

    def report(
        self,
        code: str,
        message: str,
        place: Origin | Location,
        *,
        at: At = "value",
        hint: str | None = None,
        related: Iterable[RelatedPlace] = (),
        path: Path = (),
        span: Span | None = None,
        severity: Severity | None = None,
        fix: tuple[At, str] | None = None,
    ) -> None:
        """Adds a finding. Equal findings (code, message and place) are stored once. If many copies of one node have the
        same code, the first copy is reported and the others are counted.

        `path` is for a place that is a location; an origin has its own. `span` is the affected part of a scalar, in
        characters of its value. `MAX_REPORTS` of each severity are kept; an error beyond them becomes SC016. `severity`
        is for a code that is not in the table: that of a house rule. `fix` is what `--fix` writes instead of the value
        or key.
        """
        severity = severity or CODES[code].severity
        if severity in self._full:
            return
        if isinstance(place, Origin) and not place.path and code in CODES and CODES[code].at_fault == "machine":
            place = Location(None)  # no part of the scene is at fault
        given: tuple[Origin, ...] = ()
        overridden: tuple[Origin, ...] = ()
        if isinstance(place, Origin):
            overridden = () if place.location else self.overridden(place)
            place = self._trace(place)
            if self._is_copy(code, place) or self._is_counted(code, place, message):
                return
            given = self.given(place) if place.parent is not None and place.location is None else ()
            if given and self._misgiven.setdefault((code, given), place) != place:
                # One wrong argument shows wherever the prefab reads it.
                return
        if code == _STOPPED:
            self._full.add("error")
        elif self._counts[severity] >= MAX_REPORTS:
            self._full.add(severity)
            message, hint = f"checking stopped after {MAX_REPORTS} {severity}s", "fix these first"
            code, related, given, overridden = _STOPPED if severity == "error" else code, (), (), ()
        key = (code, message, place)
        if key in self._seen:
            return
        self._seen.add(key)
        path = place.path if isinstance(place, Origin) else path
        places: tuple[RelatedPlace, ...] = (
            *((f"`{other.path[-1]}` is given here", other, "value") for other in given),
            *((f"`{other.path[-1]}` is overridden here", other, "key") for other in overridden),
            *((what, self._trace(other) if isinstance(other, Origin) else other, at) for what, other, at in related),
        )
        parent = place.parent if isinstance(place, Origin) else self.parent
        found = _Report(code, severity, message, place, at, hint, places, path, span, parent, fix, self.stage)
        self._reports.append(found)
        self._counts[severity] += 1
        self._failed = self._failed or severity == "error"

    def silence(self, found: Iterable[Silencing]) -> None:
        """Adds the comments of a file."""
        for one in found:
            self.silencings.setdefault(one, set())

    @contextmanager
    def merge_repeats(self) -> Generator[None]:
        """Merges findings with the same code and place, whatever their message: the first is reported, the others are
        counted.
        """
        self._is_alike = True
        try:
            yield
        finally:
            self._is_alike = False

    def note_user(self, user: Origin, other: Origin) -> None:
        """Records that findings in a text which `user` references also concern `other`, which references it too."""
        user, other = self._trace(user), self._trace(other)
        if other != user:
            self._users.setdefault(user, {})[other] = None

    def _other_users(self, report: _Report) -> list[Origin]:
        """Returns the other nodes that reference the text of a report, unless it is a scene file."""
        place = report.place
        if not isinstance(place, Origin) or place.location is None:
            return []
        others = self._others.get(_repeated(report.code, place), ())
        found = dict.fromkeys(parent for _, parent in others if parent is not None)
        for user in (*chain_of(place.parent), *found):
            found |= self._users.get(user, {})
        return list(found)

    def _is_counted(self, code: str, place: Origin, message: str) -> bool:
        """Returns whether another finding is reported instead of this one."""
        if not self._is_alike:
            return False
        messages = self._alike.setdefault((code, place), {})
        messages[message] = None
        return message != next(iter(messages))

    def _is_copy(self, code: str, place: Origin) -> bool:
        """Returns whether another copy of the node has the same code, and counts this one there."""
        if not place.copy and place.parent is None:
            return False
        key = _repeated(code, place)
        first = self._first.setdefault(key, place)
        if (first.copy, first.parent) == (place.copy, place.parent):
            return False
        self._others.setdefault(key, {})[place.copy, place.parent] = None
        return True

    def take_over(self, other: Sink) -> None:
        """Takes the findings and places of another sink. This one must be empty."""
        assert not self._reports, "only an empty sink can take over another"
        vars(self).update(vars(other))
        self._reports, self._seen, self._counts = [*other._reports], {*other._seen}, Counter(other._counts)
        self._misgiven, self._full, self._first = {**other._misgiven}, {*other._full}, {**other._first}
        self._others, self._users = _copy_tables(other._others), _copy_tables(other._users)
        self._alike = _copy_tables(other._alike)

    def diagnostics(self) -> list[Diagnostic]:
        """Returns all findings that no comment silences, sorted by place in each file (those of the engine last).

        A warning about a sample is left out if its place has an error too, of other scenes.
        """
        failed = {report.place for report in self._reports if report.severity == "error"}
        kept = [one for one in self._reports if one.code not in _OF_SAMPLES or one.place not in failed]
        found = [self._resolve(report) for report in kept]
        reports = dict(zip(found, kept, strict=True))
        if self.silencings:
            found = [
                one for one, report in zip(found, kept, strict=True) if not self._is_silenced_by_users(one, report)
            ]
            found = without_silenced(found, self.silencings)
        # A comment may be in the prefab or at its use.
        found = without_silenced([self._at_use(one, reports[one]) for one in found], self.silencings)
        return sorted(found, key=lambda d: (d.file or "", d.line or 0, d.column or 0))

    def _is_silenced_by_users(self, found: Diagnostic, report: _Report) -> bool:
        """Returns whether a finding in a robot file is silenced at all nodes that reference the file."""
        place = report.place
        if not isinstance(place, Origin) or place.location is None or place.parent is None:
            return False
        for user in (place.parent, *self._other_users(report)):
            # The file may be included by another robot file.
            chain = [*chain_of(user)]
            scene = next((number for number, one in enumerate(chain) if one.location is None), len(chain))
            here = [replace(found, location=self._location(one, "value")) for one in chain[: scene + 1]]
            if len(without_silenced(here, self.silencings)) == len(here):
                return False
        return True

    def _resolve(self, report: _Report) -> Diagnostic:
        location = self._location(report.place, report.at)
        return Diagnostic(
            code=report.code,
            severity=report.severity,
            message=report.message + self._copies(report),
            location=location if report.span is None else locate_span(location, report.span),
            path=dotted(report.path),
            hint=report.hint,
            related=tuple(
                Related(message + _of_copy(place), self._location(place, at))
                for message, place, at in self._chain(report)
            ),
            fix=report.fix and Fix(self._location(report.place, report.fix[0]), report.fix[1]),
            stage=report.stage,
        )

    def _at_use(self, found: Diagnostic, report: _Report) -> Diagnostic:
        """Returns a finding in a prefab at its outermost `use`, or at the argument that caused it; others unchanged.

        A file with an error stays the place of that error, unless it is part of a package: its users cannot edit it.
        """
        is_of_package = (found.file or "").startswith(_PACKAGED)
        uses = [user for user in chain_of(report.parent) if user.path[-1:] == ("use",)]
        if not uses or not (self.at_use or is_of_package):
            return found
        place = uses[-1]
        if not self.at_use:
            top = (one for _, one, _ in report.related if isinstance(one, Origin) and one.file == place.file)
            place = next((one for one in top if one.path[:-1] == (*place.path[:-1], "with")), place)
        location = self._location(place, "value")
        others = (other for other in found.related if other.location != location)
        related = (Related(IN_PREFAB, found.location), *others)
        return replace(found, location=location, path=dotted(place.path), related=related)

    def _location(self, place: Origin | Location, at: At) -> Location:
        if isinstance(place, Origin):
            return self.locate(place, at) if place.location is None else place.location
        return place

    def _trace(self, place: Origin) -> Origin:
        if place.location is None or place.parent is None:
            return self.trace(place)
        # The text itself was not expanded, but the referencing node may be.
        return Origin(place.file, place.path, place.copy, self._trace(place.parent), place.location)

    def _copies(self, report: _Report) -> str:
        """Returns which copy of a repeated node it concerns, and the number of other affected copies."""
        place = report.place
        if not isinstance(place, Origin):
            return ""
        count = len(self._other_users(report) or self._others.get(_repeated(report.code, place), ()))
        what = "copy" if place.copy else "use"
        plural = "copies" if place.copy else "uses"
        others = f"and in {count} other {what if count == 1 else plural}" if count else ""
        alike = len(self._alike.get((report.code, place), ())) - 1
        like_it = f"and {alike} other{'s' if alike > 1 else ''} like it" if alike > 0 else ""
        # The variables of a loop in a package say nothing to its users.
        copy = "" if (place.file or "").startswith(_PACKAGED) else place.copy
        parts = [part for part in (like_it, copy, others) if part]
        return f" ({'; '.join(parts)})" if parts else ""

    def _chain(self, report: _Report) -> Sequence[RelatedPlace]:
        """Returns the related places, the chain of uses of the document, and other nodes that reference it."""
        places = list(report.related)
        for user in chain_of(report.parent):
            verb = "included" if user.path[:1] == ("include",) else "used"
            places.append((f"{verb} from here", user, "value"))
        chain = {(user.file, user.path) for user in chain_of(report.parent)}
        # Copies of one node are counted.
        others = {(user.file, user.path): user for user in self._other_users(report)}
        too = [user for written, user in others.items() if written not in chain]
        return [*places, *[("used from here too", user, "value") for user in too[:_USERS]]]


def _copy_tables(tables: dict[_Key, dict[_Other, None]]) -> dict[_Key, dict[_Other, None]]:
    return {key: {**table} for key, table in tables.items()}


def chain_of(origin: Origin | None) -> Iterator[Origin]:
    """Yields a node, and then the nodes that reference its document, one by one."""
    while origin is not None:
        yield origin
        origin = origin.parent


def _of_copy(place: Origin | Location) -> str:
    return f" ({place.copy})" if isinstance(place, Origin) and place.copy else ""


MARKER: Final = "scenecc: ignore"
"""The text in every such comment; a text without it is not searched."""

_BODY = re.compile(r"\s+(?P<codes>[A-Z]+[0-9]+(?:\s*,\s*[A-Z]+[0-9]+)*)\s*(?:\s--?\s.*)?")


@frozen
class Silencing:
    """A comment that silences findings.

    Attributes:
        codes: silenced codes; empty if it cannot be read.
        line: the line whose findings it silences, from 1.
        location: location of the comment.
    """

    codes: tuple[str, ...]
    line: int
    location: Location


Silencings = dict[Silencing, set[str]]
"""Comments, and the codes that each has silenced so far."""


def silencings_of(comments: Iterable[tuple[Location, str, bool]]) -> list[Silencing]:
    """Returns the silencing comments of a file.

    Args:
        comments: in file order: the location, the text after the marker, and whether the comment is alone on its line.
            Such a comment applies to the next line that is not another one.
    """
    found: list[Silencing] = []
    line_below, next_line = 0, 0
    for location, text, is_alone in reversed([*comments]):
        line = location.line or 0
        if is_alone:
            next_line, line_below = (next_line if line_below == line + 1 else line + 1), line
        match = _BODY.fullmatch(text.rstrip())
        codes = re.split(r"\s*,\s*", match["codes"]) if match else []
        found.append(Silencing(tuple(dict.fromkeys(codes)), next_line if is_alone else line, location))
    return found[::-1]


def without_silenced(diagnostics: list[Diagnostic], silencings: Silencings) -> list[Diagnostic]:
    """Returns the diagnostics that no comment silences, and records the silenced codes. Errors are never silenced."""
    by_place: dict[tuple[str | None, int, str], Silencing] = {
        (one.location.file, one.line, code): one for one in silencings for code in one.codes
    }
    kept: list[Diagnostic] = []
    for found in diagnostics:
        silencing = by_place.get((found.file, found.line or 0, found.code)) if found.severity != "error" else None
        if silencing is None:
            kept.append(found)
        else:
            silencings[silencing].add(found.code)
    return kept


def report_invalid(silencings: Mapping[Silencing, object], file: str | None, sink: Sink) -> None:
    """Reports comments of a file that can never silence anything."""
    for one in silencings:
        if one.location.file != file:
            continue
        if not one.codes:
            hint = "write the codes, then the reason: `scenecc: ignore SC484, SC526 -- reason`"
            sink.report("SC018", "this comment names no code to ignore", one.location, hint=hint)
        for code in one.codes:
            row = CODES.get(code)
            if row is None and code.startswith("SC"):
                hint = "`scenecc explain` lists all codes"
                sink.report("SC018", f"unknown code {code}", one.location, hint=hint)
            elif row is not None and row.severity == "error":
                sink.report("SC018", f"{code} is an error, and errors cannot be ignored", one.location)


def report_unused(sink: Sink, file: str | None, is_judged: Callable[[str], bool]) -> None:
    """Reports comments of a file that silence none of the findings so far.

    Args:
        sink: contains the findings, and collects the warnings.
        file: the checked file.
        is_judged: returns whether a code would have been reported by now.
    """
    sink.diagnostics()
    for one, used in sink.silencings.items():
        for code in one.codes if one.location.file == file else ():
            row = CODES.get(code)
            if code not in used and (row is None or row.severity != "error") and is_judged(code):
                message = f"line {one.line} has no {code}, so this comment silences nothing"
                sink.report("SC018", message, one.location, hint=f"remove {code}")
