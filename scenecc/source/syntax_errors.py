"""Errors in YAML text: a reporter at parser marks, and advice for each problem that the parser reports."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from yaml import MarkedYAMLError, YAMLError

from scenecc.diagnostics.frozen import frozen
from scenecc.source.events import Event, Mark, NodeEvent, describe_type
from scenecc.source.limits import MAX_DEPTH
from scenecc.source.syntax_repair import find_repair
from scenecc.source.text import TextLines, find_control_character, report_character

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Location, Path
    from scenecc.source.limits import Limits

MAX_ERRORS = 1000
"""Maximum number of errors: a text of only errors (`- ` a million times) must not fill the memory."""


class ReadAborted(Exception):
    """The rest of the text is not read: a limit was reached, or there are too many errors."""


class SourceReporter:
    """Reports errors at the marks of a parser.

    Attributes:
        lines: the text.
        any: whether anything was reported.
    """

    def __init__(self, lines: TextLines, sink: Sink) -> None:
        self.lines = lines
        self.any = False
        self._count = 0
        self._sink = sink

    def at(
        self,
        code: str,
        message: str,
        event: Event,
        *,
        path: Path = (),
        hint: str | None = None,
        related: tuple[tuple[str, Location], ...] = (),
    ) -> None:
        """Reports an error at an event.

        Raises:
            ReadAborted: there are too many errors.
        """
        self.report(code, message, self.span(event.start_mark, event.end_mark), path=path, hint=hint, related=related)
        self.admit(event)

    def admit(self, event: Event) -> None:
        """Counts an error at an event.

        Raises:
            ReadAborted: there are too many errors.
        """
        self._count += 1
        if self._count >= MAX_ERRORS:
            self.report(
                "SC016",
                f"reading stopped after {MAX_ERRORS} errors",
                self.span(event.start_mark, event.end_mark),
                hint="fix these first; the rest of the file was not checked",
            )
            raise ReadAborted

    def report(
        self,
        code: str,
        message: str,
        location: Location,
        *,
        path: Path = (),
        hint: str | None = None,
        related: tuple[tuple[str, Location], ...] = (),
    ) -> None:
        """Reports an error at a location."""
        self.any = True
        self._sink.report(
            code, message, location, path=path, hint=hint, related=[(text, place, "value") for text, place in related]
        )

    def character(self, offset: int) -> None:
        """Reports a character that is not allowed in a scene file."""
        self.any = True
        report_character(self.lines, offset, self._sink)

    def span(self, start: Mark, end: Mark) -> Location:
        """Returns the location between two marks, limited to the line of the first."""
        return self.lines.location(start.line, start.column, end.column if end.line == start.line else None)


_EXPRESSION = re.compile(r"\$\{[^}]*\}?")

_KEY_WITHOUT_BLANK = re.compile(r"\s*(?:- +)*(?P<key>[A-Za-z_][\w.-]*):(?P<value>[^\s:/].{0,60}?)\s*(?:#.*)?$")

_MAX_KEY = 1024
"""Maximum length of a key before its colon, by YAML's rule for keys without `? `."""


@frozen
class _Problem:
    """A parser error and its position, with the text."""

    lines: TextLines
    problem: str
    mark: Mark
    context: Mark | None

    @property
    def text(self) -> str:
        """The line of the error."""
        return self.lines.line(self.mark.line)

    @property
    def rest_length(self) -> int:
        """Length of the rest without trailing blanks."""
        return max(len(self.rest.rstrip()), 1)

    @property
    def at_end(self) -> bool:
        """Whether only blanks follow the error."""
        return not self.rest.strip() and self.lines.is_last(self.mark.line)

    @property
    def rest(self) -> str:
        """The rest of the line after the error."""
        return self.text[self.mark.column :]


@frozen
class _Advice:
    """A report about the position of the error, or about another one."""

    message: str
    hint: str | None = None
    line: int | None = None
    column: int | None = None
    length: int = 1
    related: str | None = None
    """A message about the start of the parser's context."""
    code: str = "SC003"

    @property
    def is_sure(self) -> bool:
        """Whether the hint says what to write."""
        return _SURE.search(self.hint or "") is not None


_SURE = re.compile(r"write `(?!key: value)[^`…]+`|quote (?:it|the colour): `|two spaces instead")


def report_syntax(error: YAMLError, faults: SourceReporter) -> None:
    """Reports the error that stopped the parser."""
    lines = faults.lines
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        offset = find_control_character(lines.text)
        if offset is None:
            faults.report("SC003", f"bad YAML: {error}", lines.location(0, 0, 1))
        else:
            faults.character(offset)
        return
    problem = _Problem(lines, error.problem or "bad YAML", error.problem_mark, error.context_mark)
    advice = _find_advice(problem)
    if not advice.is_sure:
        advice = _find_repair(problem) or advice
    line = problem.mark.line if advice.line is None else advice.line
    column = problem.mark.column if advice.column is None else advice.column
    context = problem.context
    related = ()
    if advice.related is not None and context is not None and (context.line, context.column) != (line, column):
        related = ((advice.related, lines.location(context.line, context.column, context.column + 1)),)
    if lines.is_past(line):
        # If the last line has no line break, libyaml names the line after it.
        line, column = line - 1, len(lines.line(line - 1))
    place = lines.location(line, column, column + advice.length)
    faults.report(advice.code, advice.message, place, hint=advice.hint, related=related)


def _find_repair(problem: _Problem) -> _Advice | None:
    """Returns the advice to change a line so that the text around it is YAML."""
    context = (problem.context or problem.mark).line
    found = find_repair(problem.lines, problem.mark.line, context)
    return found and _Advice(found.message, found.hint, found.line, found.column, found.end - found.column)


def _find_advice(problem: _Problem) -> _Advice:
    if advice := _find_commented_colour(problem):
        return advice
    for beginning, advise in _ADVICE_BY_PROBLEM.items():
        if problem.problem.startswith(beginning):
            return _find_tab(problem) or (advise if isinstance(advise, _Advice) else advise(problem))
    return _find_tab(problem) or _Advice(f"bad YAML: {problem.problem}")


_COMMENTED_COLOUR = re.compile(r":[ \t]+(?P<colour>#[0-9A-Fa-f]{3,8})\b[\"']?")


def _find_commented_colour(problem: _Problem) -> _Advice | None:
    """Finds an unquoted colour, which hides the brackets after it, in the error's line or up to two lines before."""
    for line in range(problem.mark.line, max(problem.mark.line - 3, -1), -1):
        if found := _COMMENTED_COLOUR.search(problem.lines.line(line)):
            colour = found["colour"]
            message = "a bracket is not closed: `#` starts a comment"
            return _Advice(
                message,
                f'quote the colour: `"{colour}"`',
                line,
                found.start("colour"),
                found.end() - found.start("colour"),
            )
    return None


def _find_tab(problem: _Problem) -> _Advice | None:
    text = problem.text
    column = text.find("\t", 0, len(text) - len(text.lstrip(" \t")))
    if column < 0:
        return None
    return _Advice("a tab in the indentation", "write two spaces instead of each tab", column=column)


_QUOTES = "\"'"


def _explain_brackets(problem: _Problem) -> _Advice:
    """Handles a flow collection that continues with neither a comma nor its end."""
    before = problem.mark.column - 1
    expression = _EXPRESSION.match(problem.text, before) if before >= 0 else None
    if expression is not None:
        text = expression[0]
        message = "unquoted expression: inside brackets, `{` starts a mapping"
        after = re.match(r"[^\s,\]}:]*", problem.text[before + len(text) :])
        text += after[0] if after else ""
        return _Advice(message, f'quote it: `"{text.rstrip(_QUOTES)}"`', column=before, length=len(text))
    closing = problem.problem.rstrip("'")[-1:]
    what, opening = ("list", "[") if closing == "]" else ("mapping", "{")
    start = before + 1 - len("scenecc")
    if start >= 0 and problem.text.startswith("scenecc:", start):
        name = re.match(r":\s*(\w{1,60})", problem.text[before + 1 :])
        if name is not None:
            message = "a space is not allowed in the name of a prefab"
            length = len("scenecc") + name.end()
            return _Advice(message, f"write `scenecc:{name[1]}`", column=start, length=length)
    if problem.at_end and problem.context is not None:
        return _Advice(f"this `{opening}` is never closed", None, problem.context.line, problem.context.column)
    if problem.context is not None and problem.mark.line > problem.context.line:
        hint = f"close it with `{closing}` before this line, or put a comma between its parts"
    else:
        hint = f"put a comma between the parts of a {what}, and `{closing}` at its end; quote strings with brackets"
    return _Advice(f"a comma or `{closing}` is missing", hint, related=f"the {what} starts here")


def _explain_colon(problem: _Problem) -> _Advice:
    """Handles a colon where a key is not allowed."""
    line, column = problem.mark.line, problem.mark.column
    above = _find_line_above(problem)
    if above is not None:
        match = _KEY_WITHOUT_BLANK.match(problem.lines.line(above))
        if match is not None:
            return _explain_missing_blank(match, above)
    before = problem.text[:column]
    if re.search(r":\s", before):
        hint = "quote the value if the colon belongs to it; otherwise start a new line for the second key"
        return _Advice("a second `: ` in one line", hint)
    if column - (len(before) - len(before.lstrip())) > _MAX_KEY:
        return _explain_long_key(problem.mark)
    hint = "indent it as far as the keys it belongs with"
    if above is not None:
        hint += f" (line {above + 1} above already has a value)"
    start = len(before) - len(before.lstrip(" -"))
    return _Advice("a key is not allowed here", hint, line, start, max(column - start, 1))


def _explain_long_key(place: Mark) -> _Advice:
    return _Advice(f"a key of more than {_MAX_KEY} characters", "shorten it", place.line, 0)


def _explain_missing_blank(match: re.Match[str], line: int) -> _Advice:
    key = match["key"]
    return _Advice(
        f"the space is missing after the colon of `{key}`",
        f"write `{key}: {match['value']}`; without the space, the colon is part of a string",
        line,
        match.start("key"),
        len(key) + 1 + len(match["value"]),
    )


def _find_line_above(problem: _Problem) -> int | None:
    """Returns the last line before the error that has more than blanks and a comment."""
    for line in range(problem.mark.line - 1, max(problem.mark.line - 100, -1), -1):
        text = problem.lines.line(line).strip()
        if text and not text.startswith("#"):
            return line
    return None


def _explain_missing_colon(problem: _Problem) -> _Advice:
    """Handles a line that should be a key."""
    place = problem.context or problem.mark
    text = problem.lines.line(place.line)
    match = _KEY_WITHOUT_BLANK.match(text)
    if match is not None:
        return _explain_missing_blank(match, place.line)
    if len(text) > _MAX_KEY and ":" in text:
        return _explain_long_key(place)
    length = max(len(text.rstrip()) - place.column, 1)
    if text.lstrip().startswith("//"):
        return _Advice(
            "`//` does not start a comment", f"write `#{text.strip()[2:62]}`", place.line, place.column, length
        )
    hint = "write `key: value`; a string over several lines is indented further than its key"
    return _Advice("this line has no colon, so it is not a key", hint, place.line, place.column, length)


def _explain_key(problem: _Problem) -> _Advice:
    """Handles a block mapping that continues with something other than a key."""
    before = problem.text[: problem.mark.column].strip()
    if problem.rest[:1] in ("]", "}"):
        return _Advice(f"this `{problem.rest[0]}` closes nothing", "remove it, or quote the whole value")
    if before:
        hint = "quote the whole value, or start a new line"
        if problem.rest.startswith("//"):
            hint = f"a comment is written `#{problem.rest.rstrip()[2:62]}`"
        return _Advice("there is extra text after a complete value", hint, length=problem.rest_length)
    if problem.rest.startswith("- "):
        hint = "write either keys or list items at one indentation, not both"
        return _Advice("a list item among keys", hint, related="the mapping starts here")
    hint = "its indentation matches neither the keys above it nor their values"
    return _Advice("bad indentation", hint, length=problem.rest_length, related="the mapping starts here")


_QUOTE_STAR = "a string that starts with `*` must be quoted"

_DASH = _Advice(
    "a list continues with a line that is not an item",
    "indent it further to make it part of the item above, or start it with `- `",
    related="the list starts here",
)

_DASH_IN_LINE = _Advice("a list item cannot start here", "start the list on a line of its own, or write `[…]`")


def _explain_content(problem: _Problem) -> _Advice:
    found = problem.rest[:1]
    if found == ",":
        return _Advice("a value is missing before this comma", "remove the comma, or put a value before it")
    what = f"`{found}`" if found.strip() else "the end of the line"
    return _Advice(f"expected a value, not {what}", "check for a missing or extra bracket")


def _explain_first_character(problem: _Problem) -> _Advice:
    found = problem.rest[:1]
    return _Advice(f"a string cannot start with `{found}`", f'quote it: "{found}…"')


def _explain_anchor(problem: _Problem) -> _Advice:
    place = problem.context or problem.mark
    found = problem.lines.line(place.line)[place.column : place.column + 1]
    hint = f'quote it: "{found}…"'
    return _Advice(f"a string cannot start with `{found}`, which marks or names a node", hint, place.line, place.column)


def _explain_open_quote(problem: _Problem) -> _Advice:
    place = problem.context or problem.mark
    return _Advice("this quote is never closed", None, place.line, place.column)


_ESCAPE = _Advice(
    "unknown escape sequence", "in double quotes a backslash starts an escape: double it, or use single quotes"
)


def _explain_extra_text(problem: _Problem) -> _Advice:
    hint = "check for a first line without a key, or a bracket that is closed too early"
    return _Advice("there is extra text after the end of the document", hint, length=problem.rest_length)


_DEPTH = _Advice(
    f"more than {MAX_DEPTH} nested mappings and lists",
    f"use fewer levels: the YAML parser supports only {MAX_DEPTH}, whatever the limits",
    code="SC602",
)
"""libyaml's own depth limit (since 0.2.6). The parser looks ahead, so it can fail before `Limits.depth`."""

_ADVICE_BY_PROBLEM: dict[str, _Advice | Callable[[_Problem], _Advice]] = {
    "exceeded maximum nesting depth": _DEPTH,
    "did not find expected ',' or": _explain_brackets,
    "found unexpected ':'": _Advice("the space is missing after the colon of a key", "write `key: value`"),
    "mapping values are not allowed": _explain_colon,
    "could not find expected ':'": _explain_missing_colon,
    "did not find expected key": _explain_key,
    "did not find expected '-'": _DASH,
    "block sequence entries are not allowed": _DASH_IN_LINE,
    "did not find expected node content": _explain_content,
    "found character that cannot start any token": _explain_first_character,
    "did not find expected alphabetic or numeric character": _explain_anchor,
    "found unexpected end of stream": _explain_open_quote,
    "found unknown escape character": _ESCAPE,
    "found invalid Unicode character escape code": _ESCAPE,
    "did not find expected hexdecimal number": _ESCAPE,
    "did not find expected <document start>": _explain_extra_text,
}
"""The beginnings of libyaml's problem texts → the advice, or the function that gives it."""

Container = dict[str, Any] | list[Any]


class AnchorTable:
    """The anchors of one document.

    Aliases share nodes, so a short text can unfold to any size. Each use counts all nodes below the anchor, and the
    depth is that of the unfolded document.
    """

    def __init__(self, faults: SourceReporter, limits: Limits) -> None:
        self._faults = faults
        self._limits = limits
        self._anchors: dict[str, Any] = {}
        # id of a container below an anchor → its number of nodes and height, with aliases unfolded.
        self._sizes: dict[int, tuple[int, int]] = {}
        self._reached = 0

    def define(self, name: str, value: Any) -> None:
        """Names a value; the latest definition of a name counts."""
        self._anchors[name] = value

    def follow(self, event: NodeEvent, ancestors: Sequence[Container], path: Path) -> Any:
        """Returns the value of an alias; None, reported, if it is not valid there."""
        name = event.anchor or ""
        if name not in self._anchors:
            self._faults.at(
                "SC009",
                f"there is no anchor `&{name}` before this alias",
                event,
                path=path,
                hint=f"write `x-{name}: &{name} {{…}}` above it" if path[-1:] == ("<<",) else _QUOTE_STAR,
            )
            return None
        value = self._anchors[name]
        if any(value is ancestor for ancestor in ancestors):
            self._faults.at("SC010", f"the alias `*{name}` is inside its own node", event, path=path)
            return None
        nodes, height = self._measure(value)
        self._reached += nodes
        if self._reached > self._limits.alias_nodes:
            self._stop(event, path)
        if len(ancestors) + height > self._limits.depth:
            abort_at_depth(self._faults, self._limits, event, path)
        return value

    def _stop(self, event: NodeEvent, path: Path) -> None:
        self._faults.at(
            "SC603",
            f"more than {self._limits.alias_nodes} nodes come from aliases (limit alias_nodes)",
            event,
            path=path,
            hint="`repeat` writes many copies without aliases; `--limit alias_nodes=N` or "
            "`limits={'alias_nodes': N}` raises the limit",
        )
        raise ReadAborted

    def _measure(self, value: Any) -> tuple[int, int]:
        """Returns the number of nodes and the height of a finished node: 1 and 0 for a scalar."""
        if not isinstance(value, (dict, list)):
            return 1, 0
        node = cast("Container", value)
        known = self._sizes.get(id(node))
        if known is None:
            children = node.values() if isinstance(node, dict) else node
            sizes = [self._measure(child) for child in children]
            known = 1 + sum(nodes for nodes, _ in sizes), 1 + max((height for _, height in sizes), default=0)
            self._sizes[id(node)] = known
        return known


def abort_at_depth(faults: SourceReporter, limits: Limits, event: NodeEvent, path: Path) -> None:
    """Reports at an event that the document is too deep.

    Raises:
        ReadAborted: always.
    """
    faults.at(
        "SC602",
        f"more than {limits.depth} nested mappings and lists (limit depth)",
        event,
        path=path[:8],
        hint=f"`--limit depth=N` or `limits={{'depth': N}}` raises the limit, to {MAX_DEPTH} at most",
    )
    raise ReadAborted


@dataclass(slots=True)
class _MergeKey:
    """A merge key: its position, and its keys that no explicit key has replaced."""

    event: NodeEvent
    keys: set[str] = field(default_factory=set[str])


class MergeKeys:
    """The merge keys of the mappings of one text, which this object keeps alive."""

    def __init__(self, faults: SourceReporter) -> None:
        self._faults = faults
        self._merges: dict[int, _MergeKey] = {}
        """id of a mapping → its merge key."""

    def merge(self, value: object, event: NodeEvent, node: dict[str, Any], path: Path) -> None:
        """Applies a merge key: adds its entries whose keys the mapping lacks.

        Args:
            value: the merged value.
            event: event of the key.
            node: the mapping with the merge key.
            path: path of the key.
        """
        first = self._merges.get(id(node))
        if first is not None:
            place = self._faults.span(first.event.start_mark, first.event.end_mark)
            hint = "merge several mappings with a list: `<<: [*a, *b]`"
            related = (("first written here", place),)
            self._faults.at("SC004", "the key `<<` is written twice", event, path=path, hint=hint, related=related)
            return
        merge = self._merges[id(node)] = _MergeKey(event)
        for source in cast("list[object]", value) if isinstance(value, list) else [value]:
            if not isinstance(source, dict):
                self._refuse(source, event, path)
                continue
            for key, item in cast("dict[str, Any]", source).items():
                if key not in node:
                    node[key] = item
                    merge.keys.add(key)

    def brought(self, key: str, node: dict[str, Any]) -> bool:
        """Returns whether a key of a mapping comes only from a merge key, so that it may still be written."""
        merge = self._merges.get(id(node))
        return merge is not None and key in merge.keys

    def replace(self, key: str, node: dict[str, Any]) -> None:
        """Records that a key is written in a mapping."""
        merge = self._merges.get(id(node))
        if merge is not None:
            merge.keys.discard(key)

    def _refuse(self, source: object, event: NodeEvent, path: Path) -> None:
        if source is not None:  # otherwise it is already reported
            hint = "write `<<: *anchor` or `<<: [*one, *other]`, anchors of mappings; to use `<<` as a key, quote it"
            self._faults.at("SC011", f"`<<` merges mappings, not {describe_type(source)}", event, path=path, hint=hint)
