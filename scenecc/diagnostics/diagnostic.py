"""Diagnostics, their locations, and the sink that collects the reports of every stage."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Final, Literal, TypeVar

from scenecc.diagnostics.codes import CODES, Severity
from scenecc.diagnostics.frozen import frozen

PathKey = str | int
"""One step into a document: a mapping's key or a sequence's index."""

Path = tuple[PathKey, ...]

At = Literal["value", "key"]
"""Which half of a mapping's entry is meant. A sequence's item has only a value."""


@frozen
class Origin:
    """The node of a document that asked for something.

    Cheap to make (a valid file makes thousands and prints none): a line is looked up only when a
    diagnostic is printed.

    Attributes:
        file: name of the document as shown to people; None for a dict.
        path: keys and indices from the document's root.
        copy: which copy of a repeated node ("i=1, j=-1"); empty for a node written once.
        parent: the node that brought this document in (a `use`, an item of `include`, a robot's file); None for the
            top document.
        location: where it is, where that is known already: in a text that is no scene file.
    """

    file: str | None
    path: Path = ()
    copy: str = ""
    parent: Origin | None = None
    location: Location | None = None

    def child(self, *keys: PathKey) -> Origin:
        """The origin of a node below this one."""
        return Origin(self.file, self.path + keys, self.copy, self.parent, self.location)

    def into(self, location: Location, *path: PathKey) -> Origin:
        """The origin of a line in another text, which this node names. `path`: what stands there."""
        return Origin(location.file, path, "", self, location)


@frozen
class Location:
    """A place in a text. Lines and columns count from 1; columns count characters.

    Attributes:
        file: name of the document as shown to people.
        line: 1-based line; None where the document has no text (a dict).
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
"""Finds an origin in its text. Total: what cannot be found gives a location without a line."""

Tracer = Callable[[Origin], Origin]
"""Turns an origin in an expanded document into the one as written. Total."""


def as_written(origin: Origin) -> Origin:
    """The tracer of documents that are compiled as they are written."""
    return origin


def nowhere(origin: Origin, at: At) -> Location:
    """The locator of documents that have no text."""
    del at
    return Location(origin.file)


_QUOTED = frozenset(". []\"'\n\t")


def dotted(path: Path) -> str:
    """A path as people write it: `entities.cube.shapes[0].half_size[1]`.

    Keys that would read as something else (dots, brackets, blanks) are quoted:
    `entities["a.b"]`.
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
"""The first character and the one after the last, in the value of a scalar."""

_BEFORE = re.compile(r"(?:[&!]\S*\s+)*")
"""An anchor and a tag, in front of the scalar itself."""

_CHARACTER = {
    '"': re.compile(r"\\x..|\\u.{4}|\\U.{8}|\\.|[^\"\\]"),
    "'": re.compile(r"''|[^']"),
    "": re.compile(r"."),
}
"""What stands for one character: in double quotes, in single quotes, and in plain text."""


def locate_span(location: Location, span: Span) -> Location:
    """The place of a part of a scalar; the scalar's own where the part does not begin on its first line.

    Args:
        location: of the scalar.
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
    """A second place that belongs to a diagnostic (the first of two equal keys, say)."""

    message: str
    location: Location


@frozen
class Fix:
    """A safe correction: a text in place of a part of one line."""

    location: Location
    text: str


@frozen
class Diagnostic:
    """One finding.

    Attributes:
        code: `SC` and three digits, a row of `scenecc.diagnostics.codes.CODES`.
        severity: errors stop the pipeline; warnings and notes do not.
        message: one sentence about this file, without its place.
        location: file, line and columns, as far as they are known.
        path: the place in the document (`entities.cube.mass`); "" for the whole document. A fault of the caller has
            the argument or option here.
        hint: what to do, where there is more to say than the message does.
        related: other places that belong to it, nearest first.
        fix: what `--fix` writes, where there is one safe correction.
    """

    code: str
    severity: Severity
    message: str
    location: Location
    path: str = ""
    hint: str | None = None
    related: tuple[Related, ...] = ()
    fix: Fix | None = None

    @property
    def file(self) -> str | None:
        """Name of the document; None for a dict, and where no file is at fault."""
        return self.location.file

    @property
    def line(self) -> int | None:
        """1-based line; None where there is no text."""
        return self.location.line

    @property
    def column(self) -> int | None:
        """1-based column; None where there is no text."""
        return self.location.column

    @property
    def place(self) -> str:
        """Where it is, in words: a file, a dict, the argument that is at fault, or scenecc for the machine's faults."""
        if self.file:
            return self.file
        return "<dict>" if self._is_in_dict else self.path or "scenecc"

    @property
    def node(self) -> str:
        """The place in the document; "" for the whole document and where there is none."""
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
    """Of documents that use no prefab."""
    return ()


_USERS = 10
"""How many nodes that name the same file are shown."""

_STOPPED = "SC016"
"""The code for all errors after the last one that is reported."""

RelatedPlace = tuple[str, Origin | Location, At]
"""A message, the place it is about, and which half of it."""


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


_Repeated = tuple[str, str | None, Path, int | None]
"""The code and the place of what many copies of one node may have in common."""


def _repeated(code: str, place: Origin) -> _Repeated:
    return code, place.file, place.path, None if place.location is None else place.location.line


class Sink:
    """Collects what the stages report; turns origins into lines only when read.

    Attributes:
        locate: finds an origin in its text. Set by the pipeline once there is a document.
        trace: leads the origins of what is reported from now on back to what was written. Set by the pipeline
            once a document is expanded.
        given: finds where the parameters are given that a node inside a prefab reads. Set by the pipeline.
        overridden: finds where keys are overridden of the node that an origin leads into. Set by the pipeline.
        parent: the node that includes the document which is being read; its locations do not contain it.
        silencings: the comments of the files that were read which silence findings.
    """

    def __init__(self, locate: Locator = nowhere) -> None:
        self.locate = locate
        self.trace: Tracer = as_written
        self.given: Callable[[Origin], tuple[Origin, ...]] = _given_nowhere
        self.overridden: Callable[[Origin], tuple[Origin, ...]] = _given_nowhere
        self._misgiven: dict[tuple[str, tuple[Origin, ...]], Origin] = {}
        self.parent: Origin | None = None
        self.silencings: Silencings = {}
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
        """A sink without findings, which leads back to the same documents."""
        made = Sink(self.locate)
        made.trace, made.given, made.overridden = self.trace, self.given, self.overridden
        made.silencings = self.silencings
        return made

    @property
    def failed(self) -> bool:
        """Whether any error was reported."""
        return self._failed

    @property
    def full(self) -> bool:
        """Whether no more errors are taken, so that nothing need be looked for."""
        return "error" in self._full

    @property
    def reported(self) -> int:
        """How many findings there are."""
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
        """Adds a finding. The same code, message and place twice is one finding, and so is the same code in many
        copies of one node: the first copy is reported, the others are counted.

        `path` is for a place that is a location; an origin brings its own. `span` is the part of a scalar that is
        meant, in characters of its value. Of each severity `MAX_REPORTS` are
        kept; an error beyond them is SC016. `severity` is for a code that is not in the table: one of a house rule.
        `fix` is what `--fix` writes in place of the value or key.
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
                # One mistake in what is given shows wherever the prefab reads it.
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
        self._reports.append(_Report(code, severity, message, place, at, hint, places, path, span, parent, fix))
        self._counts[severity] += 1
        self._failed = self._failed or severity == "error"

    def silence(self, found: Iterable[Silencing]) -> None:
        """Takes the comments of a file that was read."""
        for one in found:
            self.silencings.setdefault(one, set())

    @contextmanager
    def merge_repeats(self) -> Generator[None]:
        """While it lasts, the same code at the same place is one finding, whatever the message: the first is reported,
        the others are counted.
        """
        self._is_alike = True
        try:
            yield
        finally:
            self._is_alike = False

    def note_user(self, user: Origin, other: Origin) -> None:
        """Notes that what is reported of a text which one node names holds for another node, that names it too."""
        user, other = self._trace(user), self._trace(other)
        if other != user:
            self._users.setdefault(user, {})[other] = None

    def _other_users(self, report: _Report) -> list[Origin]:
        """The other nodes that name the text that a report is about, if that is no scene file."""
        place = report.place
        if not isinstance(place, Origin) or place.location is None:
            return []
        others = self._others.get(_repeated(report.code, place), ())
        found = dict.fromkeys(parent for _, parent in others if parent is not None)
        for user in (*chain_of(place.parent), *found):
            found |= self._users.get(user, {})
        return list(found)

    def _is_counted(self, code: str, place: Origin, message: str) -> bool:
        """Whether another finding is reported instead of this one."""
        if not self._is_alike:
            return False
        messages = self._alike.setdefault((code, place), {})
        messages[message] = None
        return message != next(iter(messages))

    def _is_copy(self, code: str, place: Origin) -> bool:
        """Whether another copy of the node has the same code, which counts this one."""
        if not place.copy and place.parent is None:
            return False
        key = _repeated(code, place)
        first = self._first.setdefault(key, place)
        if (first.copy, first.parent) == (place.copy, place.parent):
            return False
        self._others.setdefault(key, {})[place.copy, place.parent] = None
        return True

    def take_over(self, other: Sink) -> None:
        """Goes on where another sink stands: with its findings, and its places. This one must have none yet."""
        assert not self._reports, "a sink with findings takes over no others"
        vars(self).update(vars(other))
        self._reports, self._seen, self._counts = [*other._reports], {*other._seen}, Counter(other._counts)
        self._misgiven, self._full, self._first = {**other._misgiven}, {*other._full}, {**other._first}
        self._others, self._users = _copy_tables(other._others), _copy_tables(other._users)
        self._alike = _copy_tables(other._alike)

    def diagnostics(self) -> list[Diagnostic]:
        """All findings that no comment silences, by their places in each file (those of the engine last)."""
        found = [self._resolve(report) for report in self._reports]
        if self.silencings:
            found = without_silenced(found, self.silencings)
        return sorted(found, key=lambda d: (d.file or "", d.line or 0, d.column or 0))

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
        )

    def _location(self, place: Origin | Location, at: At) -> Location:
        if isinstance(place, Origin):
            return self.locate(place, at) if place.location is None else place.location
        return place

    def _trace(self, place: Origin) -> Origin:
        if place.location is None or place.parent is None:
            return self.trace(place)
        # The text is none that was expanded; the node that names it may be.
        return Origin(place.file, place.path, place.copy, self._trace(place.parent), place.location)

    def _copies(self, report: _Report) -> str:
        """Which copy of a repeated node it is about, and in how many others it was found."""
        place = report.place
        if not isinstance(place, Origin):
            return ""
        count = len(self._other_users(report) or self._others.get(_repeated(report.code, place), ()))
        what = "copy" if place.copy else "use"
        plural = "copies" if place.copy else "uses"
        others = f"and in {count} other {what if count == 1 else plural}" if count else ""
        alike = len(self._alike.get((report.code, place), ())) - 1
        like_it = f"and {alike} other{'s' if alike > 1 else ''} like it" if alike > 0 else ""
        parts = [part for part in (like_it, place.copy, others) if part]
        return f" ({'; '.join(parts)})" if parts else ""

    def _chain(self, report: _Report) -> Sequence[RelatedPlace]:
        """The related places, the chain of uses that brought the document in, and others that name it."""
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
    """A node, and those that brought in its document, one by one."""
    while origin is not None:
        yield origin
        origin = origin.parent


def _of_copy(place: Origin | Location) -> str:
    return f" ({place.copy})" if isinstance(place, Origin) and place.copy else ""


MARKER: Final = "scenecc: ignore"
"""What every such comment holds; a text without it is not searched."""

_BODY = re.compile(r"\s+(?P<codes>[A-Z]+[0-9]+(?:\s*,\s*[A-Z]+[0-9]+)*)\s*(?:\s--?\s.*)?")


@frozen
class Silencing:
    """One comment.

    Attributes:
        codes: that it silences; none where it cannot be read.
        line: whose findings it silences, from 1.
        location: of the comment.
    """

    codes: tuple[str, ...]
    line: int
    location: Location


Silencings = dict[Silencing, set[str]]
"""Comments, and the codes that each has silenced so far."""


def silencings_of(comments: Iterable[tuple[Location, str, bool]]) -> list[Silencing]:
    """The silencings of a file's comments.

    Args:
        comments: in the order of the file: the place, the text after the marker, and whether the comment is alone on
            its line. Such a comment is about the next line, or where that is one too, about the line after it.
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
    """The diagnostics that no comment silences; of the others it is noted. Errors are never silenced."""
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
                sink.report("SC018", f"there is no code {code}", one.location, hint=hint)
            elif row is not None and row.severity == "error":
                sink.report("SC018", f"{code} is an error, and errors cannot be ignored", one.location)


def report_unused(sink: Sink, file: str | None, is_judged: Callable[[str], bool]) -> None:
    """Reports comments of a file that silence nothing of what was reported so far.

    Args:
        sink: has the reports, and takes the warnings.
        file: that is checked.
        is_judged: whether a code, if it applied, would have been reported by now.
    """
    sink.diagnostics()
    for one, used in sink.silencings.items():
        for code in one.codes if one.location.file == file else ():
            row = CODES.get(code)
            if code not in used and (row is None or row.severity != "error") and is_judged(code):
                message = f"line {one.line} has no {code}, so this comment silences nothing"
                sink.report("SC018", message, one.location, hint=f"remove {code}")
