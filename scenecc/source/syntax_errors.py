"""Errors in YAML text: a reporter at parser marks, and advice for each problem that the parser reports."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, cast

from yaml import MarkedYAMLError, YAMLError

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


def report_syntax(error: YAMLError, faults: SourceReporter) -> None:
    """Reports the error that stopped the parser: a tab, the change of a line that mends it, or what the parser says."""
    lines = faults.lines
    if not isinstance(error, MarkedYAMLError) or error.problem_mark is None:
        offset = find_control_character(lines.text)
        if offset is None:
            faults.report("SC003", f"bad YAML: {error}", lines.location(0, 0, 1))
        else:
            faults.character(offset)
        return
    mark, start, problem = error.problem_mark, error.context_mark or error.problem_mark, error.problem or ""
    text = lines.line(mark.line)
    tab = text.find("\t", 0, len(text) - len(text.lstrip(" \t")))
    if tab >= 0:
        place = lines.location(mark.line, tab, tab + 1)
        faults.report("SC003", "a tab in the indentation", place, hint="write two spaces instead of each tab")
    elif problem.startswith("exceeded maximum nesting depth"):
        # libyaml's own limit (since 0.2.6). The parser looks ahead, so it can fail before `Limits.depth`.
        hint = f"use fewer levels: the YAML parser supports only {MAX_DEPTH}, whatever the limits"
        place = lines.location(mark.line, mark.column, mark.column + 1)
        faults.report("SC602", f"more than {MAX_DEPTH} nested mappings and lists", place, hint=hint)
    elif repair := find_repair(lines, mark.line, start.line):
        place = lines.location(repair.line, repair.column, repair.end)
        faults.report("SC003", repair.message, place, hint=repair.hint)
    else:
        _report_problem(problem, mark, start, faults)


def _report_problem(problem: str, mark: Mark, start: Mark, faults: SourceReporter) -> None:
    """Reports what the parser says. `start`: of the mapping, list, key or quote that it was reading."""
    lines, text = faults.lines, faults.lines.line(mark.line)
    told = f"{problem}\n{text[: mark.column].strip()}\n{text[mark.column :].rstrip()}"
    found, message, hint = next(
        (found, message, hint) for pattern, message, hint in _ADVICE if (found := re.match(pattern, told))
    )
    is_at_start = message.startswith("this ")
    here = start if is_at_start else mark
    # If the last line has no line break, libyaml names the line after it.
    line, column = here.line, here.column
    if lines.is_past(line):
        line, column = line - 1, len(lines.line(line - 1))
    kind = "list" if re.search(r"'[]-]'", problem) else "mapping"
    related = [(f"the {kind} starts here", lines.location(start.line, start.column, start.column + 1))]
    has_start = not is_at_start and (start.line, start.column) != (line, column) and "did not find expected" in problem
    length = len(found.groupdict().get("rest") or "")
    faults.report(
        "SC003",
        found.expand(message),
        lines.location(line, column, None if is_at_start else column + length),
        hint=found.expand(hint) or None,
        related=tuple(related) if has_start else (),
    )


_ADVICE: tuple[tuple[str, str, str], ...] = (
    ("did not find expected ',' or '(.)'", r"a comma or `\1` is missing",
     r"put a comma between its parts, and `\1` at its end; quote strings with brackets"),
    ("found unexpected ':'", "the space is missing after the colon of a key", "write `key: value`"),
    (r"mapping values are not allowed.*\n.*:\s", "a second `: ` in one line",
     "quote the value if the colon belongs to it; otherwise start a new line for the second key"),
    ("mapping values are not allowed", "a key is not allowed here",
     "indent it as far as the keys it belongs with: a line above it already has a value"),
    ("could not find expected ':'", "this line is not a key and a value",
     "write `key: value`; a string over several lines is indented further than its key"),
    (r"did not find expected key\n.*\n([\]}])", r"`\1` closes nothing", "remove it, or quote the whole value"),
    (r"did not find expected key\n.+\n(?P<rest>.*)", "there is extra text after a complete value",
     "quote the whole value, or start a new line"),
    (r"did not find expected key\n.*\n- ", "a list item among keys",
     "write either keys or list items at one indentation, not both"),
    (r"did not find expected key\n.*\n(?P<rest>.*)", "bad indentation",
     "its indentation matches neither the keys above it nor their values"),
    ("did not find expected '-'", "a list continues with a line that is not an item",
     "indent it further to make it part of the item above, or start it with `- `"),
    ("block sequence entries are not allowed", "a list item cannot start here",
     "start the list on a line of its own, or write `[…]`"),
    (r"did not find expected node content\n.*\n,", "a value is missing before this comma",
     "remove the comma, or put a value before it"),
    (r"did not find expected node content\n.*\n(.)", r"expected a value, not `\1`",
     "check for a missing or extra bracket"),
    ("did not find expected node content", "expected a value, not the end of the line",
     "check for a missing or extra bracket"),
    (r"found character that cannot start any token.*\n.*\n(.)", r"a string cannot start with `\1`",
     r'quote it: "\1…"'),
    (r"did not find expected alphabetic or numeric character\n(?:.*[ \[{])?([*&])",
     r"this cannot start with `\1`, which marks or names a node", r'quote it: "\1…"'),
    ("found unexpected end of stream", "this quote is never closed", ""),
    ("found unknown escape|found invalid Unicode character|did not find expected hexdecimal",
     "unknown escape sequence", "in double quotes a backslash starts an escape: double it, or use single quotes"),
    (r"did not find expected <document start>\n.*\n(?P<rest>.*)",
     "there is extra text after the end of the document",
     "check for a first line without a key, or a bracket that is closed too early"),
    ("(.*)", r"bad YAML: \1", ""),
)  # fmt: skip
"""Patterns of what libyaml says, the text before the error and that after it, each in a line; a message and a hint,
with groups of the pattern. The group `rest` is marked. A message of `this` is about where the parser began."""

_QUOTE_STAR = "a string that starts with `*` must be quoted"

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
