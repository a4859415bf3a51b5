"""Finds the change of one line after which a text is YAML again: a colon, a dash, a comma, a bracket, a quote, blanks.

The changes are tried on the lines around an error, those that people mean most often first.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import yaml

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from scenecc.source.text import TextLines

_ABOVE: Final = 80
_BELOW: Final = 12
"""Lines around the error that are read again."""

_LONGEST: Final = 300
"""Longest line to change [characters]: the number of changes grows with it."""

_MOST: Final = 300_000
"""Characters that are read again at most, about 0.1 s: those of the window for each change that is tried."""

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_PAIRS: Final = {"[": "]", "{": "}"}
_TOKENS: Final = re.compile(r'"(?:\\.|[^"\\])*"?|\'[^\']*\'?|\s#.*|.', re.DOTALL)


@frozen
class Repair:
    """A change of one line.

    Attributes:
        line: 0-based.
        column: the first character that changes.
        end: the character after the last one.
        message: what is wrong.
        hint: what to do.
    """

    line: int
    column: int
    end: int
    message: str
    hint: str


class _Change(NamedTuple):
    message: str
    text: str


def find_repair(lines: TextLines, line: int, context: int) -> Repair | None:
    """Returns the change that makes a text YAML around an error, or None.

    Args:
        lines: the text.
        line: 0-based line of the error.
        context: line on which the mapping or list around it starts.
    """
    window = _Window.around(lines, line)
    if window is None or window.length > _MOST or window.oddities() is not None:
        return None
    above = [one for one in range(line - 1, max(window.first, line - 4) - 1, -1) if window.has_code(one)]
    places = [one for one in dict.fromkeys((line, *above[:1], context, *above[1:])) if window.has_code(one)]
    kinds = (_straighten, _separate, _balance, _close_quotes, _reindent)
    changes = ((place, change) for kind in kinds for place in places for change in kind(window, place))
    for place, change in islice(changes, _MOST // window.length):
        if window.oddities(place, change.text) == 0:
            return _as_repair(window.text(place), place, change)
    return None


def _as_repair(old: str, line: int, change: _Change) -> Repair:
    column = len(old) - len(old.lstrip())
    end = max(len(old.rstrip()), column + 1)
    indent = len(change.text) - len(change.text.lstrip())
    if old.strip() == change.text.strip():
        hint = f"indent it by {indent} spaces" if indent else "remove the blanks before it"
        return Repair(line, column, end, change.message, hint)
    comment = re.search(r"\s+#[^\"']*$", old)
    new = change.text.strip()
    if comment is not None and new.endswith(comment[0].strip()):
        new, end = new[: -len(comment[0].strip())].rstrip(), comment.start()
    return Repair(line, column, end, change.message, f"write `{new}`")


class _Window:
    """The lines around an error, from one that is indented least."""

    def __init__(self, lines: list[str], first: int) -> None:
        self._lines = lines
        self.first = first
        self.length = sum(map(len, lines)) + len(lines)

    @staticmethod
    def around(lines: TextLines, line: int) -> _Window | None:
        """Returns the window; None if the line is too long."""
        if len(lines.line(line)) > _LONGEST:
            return None
        every = [lines.line(one) for one in range(max(line - _ABOVE, 0), line + _BELOW)]
        at = line - max(line - _ABOVE, 0)
        coded = [one for one in range(at + 1) if _is_code(every[one])]
        least = min((_indent(every[one]) for one in coded), default=0)
        start = next((one for one in coded if _indent(every[one]) == least), 0)
        stop = next(
            (one for one in range(at + 1, len(every)) if _is_code(every[one]) and _indent(every[one]) < least), None
        )
        return _Window(every[start:stop], line - at + start)

    def text(self, line: int) -> str:
        return self._lines[line - self.first]

    def has_code(self, line: int) -> bool:
        """Whether a line is in the window, and has more than a comment."""
        return (
            0 <= line - self.first < len(self._lines) and _is_code(self.text(line)) and len(self.text(line)) <= _LONGEST
        )

    def neighbours(self, line: int) -> tuple[int | None, int | None]:
        """Returns the indentation of the lines with code before and after a line."""
        before = next((_indent(one) for one in reversed(self._lines[: line - self.first]) if _is_code(one)), None)
        after = next((_indent(one) for one in self._lines[line - self.first + 1 :] if _is_code(one)), None)
        return before, after

    def dashes(self) -> list[int]:
        """Returns the indentations of list items, the largest first."""
        return sorted({_indent(one) for one in self._lines if one.lstrip().startswith("- ")}, reverse=True)

    def indents(self) -> set[int]:
        return {_indent(one) for one in self._lines if _is_code(one)}

    def oddities(self, line: int | None = None, text: str = "") -> int | None:
        """Returns how many nodes nobody writes a window has, with another text in a line; None if it is not YAML."""
        lines = list(self._lines)
        if line is not None:
            lines[line - self.first] = text
        try:
            root = yaml.compose("\n".join(lines), _LOADER)
        except (yaml.YAMLError, RecursionError):
            return None
        near = [one for one in _nodes(root) if line is None or abs(one.start_mark.line + self.first - line) < 2]
        return sum(map(_is_odd, near)) + (not isinstance(root, yaml.MappingNode))


def _is_code(text: str) -> bool:
    return text.strip() != "" and not text.lstrip().startswith("#")


def _indent(text: str) -> int:
    return len(text) - len(text.lstrip(" "))


def _nodes(node: yaml.Node | None) -> Iterator[yaml.Node]:
    if node is not None:
        yield node
        parts = [one for pair in node.value for one in pair] if isinstance(node, yaml.MappingNode) else node.value
        if isinstance(node, yaml.CollectionNode):
            for part in parts:
                yield from _nodes(part)


_ODD: Final = re.compile(r"-[A-Za-z\[{]|\w+ *[-=] |\w+ *[\[{]|[\w.-]+ *;|[^$]*[\]})]$|[\w.-]+ +[\d.-]+$")
"""Plain strings that are a part of something else."""


def _is_odd(node: yaml.Node) -> bool:
    if isinstance(node, yaml.ScalarNode):
        is_plain = node.style in {None, ""}
        is_split = node.start_mark.line != node.end_mark.line and node.value != ""
        return is_plain and (node.value == "" or is_split or _ODD.match(node.value) is not None)
    if isinstance(node, yaml.MappingNode):
        keys = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
        is_pair = (
            node.flow_style and len(node.value) == 1 and node.start_mark.index == node.value[0][0].start_mark.index
        )
        return len({*keys}) < len(node.value) or is_pair
    return False


def _straighten(window: _Window, line: int) -> Iterator[_Change]:
    """The indentation that the lines before and after have."""
    text, (before, after) = window.text(line), window.neighbours(line)
    if after is not None and before == after and after != _indent(text):
        yield _Change(
            f"bad indentation: the lines around it have {after} spaces, not {_indent(text)}", _with(text, after)
        )


def _with(text: str, indent: int) -> str:
    return " " * indent + text.lstrip(" ")


def _reindent(window: _Window, line: int) -> Iterator[_Change]:
    text = window.text(line)
    for indent in sorted(window.indents() - {_indent(text)}, key=lambda one: (abs(one - _indent(text)), -one)):
        yield _Change("bad indentation: it matches neither the keys above it nor their values", _with(text, indent))


_NO_COLON: Final = re.compile(r"^(\s*(?:- +)*)([A-Za-z_.*|][\w.*|/-]*)( ?[=-])?(?: +(?=\S)|$)")
_INNER_COLON: Final = re.compile(
    r'(?<=[{,] )([A-Za-z_]\w*)( ?[=-])? +(?=[\w"\[{$.-])|(?<=\{)([A-Za-z_]\w*)( ?[=-])? +(?=[\w"\[{$.-])'
)
_NO_COMMA: Final = re.compile(r'(?<=[\w"\]}]);? +(?=["\[{\w.-])|(?<=[\w"\]}]);(?=\S)')


def _separate(window: _Window, line: int) -> Iterator[_Change]:
    """Colons, dashes and commas."""
    text = window.text(line)
    if found := re.search(r"(?<!\S)//", text):
        yield _Change("`//` does not start a comment", f"{text[: found.start()]}#{text[found.end() :]}")
    if found := re.search(r"\bscenecc:\s+(?=\w)", text):
        message = "a space is not allowed in the name of a prefab"
        yield _Change(message, f"{text[: found.start()]}scenecc:{text[found.end() :]}")
    if (found := _NO_COLON.match(text)) and ":" not in found[0]:
        rest = text[found.end() :]
        yield _Change(f"the colon is missing after `{found[2]}`", f"{found[1]}{found[2]}:{' ' * bool(rest)}{rest}")
    if dash := re.match(r"(\s*)-(?=[\w{\[\"'])", text):
        yield _Change("the space is missing after the `-`", f"{dash[0]} {text[dash.end() :]}")
    if dash := re.match(r"(\s*)- +", text):
        yield _Change("a list item among keys", dash[1] + text[dash.end() :])
    for found in _INNER_COLON.finditer(text):
        word = found[1] or found[3]
        yield _Change(f"the colon is missing after `{word}`", f"{text[: found.start()]}{word}: {text[found.end() :]}")
    for found in re.finditer(r"(?<=[\w\"]):(?=[\w\[{\"-])", text):
        yield _Change("the space is missing after a colon", f"{text[: found.end()]} {text[found.end() :]}")
    for found in _NO_COMMA.finditer(text):
        yield _Change("a comma is missing", f"{text[: found.start()]}, {text[found.end() :]}")
    for indent in window.dashes() if not text.lstrip().startswith("-") else ():
        if indent < _indent(text):
            yield _Change("a list item has no `-`", f"{' ' * indent}- {text.lstrip()}")


def _balance(window: _Window, line: int) -> Iterator[_Change]:
    """Brackets that are missing, too many, or of another kind."""
    text = window.text(line)
    code = re.sub(r"\s+#[^\"']*$", "", text)
    tail = text[len(code) :]
    opened: list[tuple[int, str]] = []
    for found in _TOKENS.finditer(code):
        at, mark = found.start(), found[0]
        if mark in _PAIRS:
            opened.append((at, mark))
        elif mark in {"]", "}", ")"} and opened and mark == _PAIRS[opened[-1][1]]:
            opened.pop()
        elif mark in {"]", "}"} or (mark == ")" and opened):
            yield from _at_mismatch(code, tail, at, mark, opened[-1] if opened else None)
            return
    if not opened:
        return
    at, bracket = opened[-1]
    message = f"this `{bracket}` is never closed: `{_PAIRS[bracket]}` is missing"
    for found in re.finditer(r", (?=[A-Za-z_]\w*: )|(?=[}\]]+$)", code[at:]):
        end = at + found.start()
        yield _Change(message, code[:end] + _PAIRS[bracket] + code[end:] + tail)
    yield _Change(message, code.rstrip().rstrip(",") + "".join(_PAIRS[one] for _, one in reversed(opened)) + tail)


def _at_mismatch(code: str, tail: str, at: int, mark: str, opened: tuple[int, str] | None) -> Iterator[_Change]:
    """Changes at a closing bracket that closes nothing, or something else."""
    if opened is None:
        opening = "[" if mark == "]" else "{"
        if mark != ")":
            message = f"this `{mark}` closes nothing: `{opening}` is missing"
            if code[at - 1] in "]}":
                yield _Change(f"this `{mark}` closes nothing", code[:at] + code[at + 1 :] + tail)
            for start in sorted(
                {0, *(found.end() for found in re.finditer(r"(?:- |: |\{|, )", code[:at]))}, reverse=True
            ):
                place = start or len(code) - len(code.lstrip())
                yield _Change(message, code[:place] + opening + code[place:] + tail)
        yield _Change(f"this `{mark}` closes nothing", code[:at] + code[at + 1 :] + tail)
        return
    start, bracket = opened
    missing = _PAIRS[bracket]
    message = f"`{missing}` is missing: this `{mark}` does not close `{bracket}`"
    yield _Change(message, code[:at] + missing + code[at + 1 :] + tail)
    for found in re.finditer(r", (?=[A-Za-z_]\w*: )", code[start:at]):
        yield _Change(message, code[: start + found.start()] + missing + code[start + found.start() :] + tail)
    yield _Change(message, code[:at] + missing + code[at:] + tail)
    yield _Change(message, code[:at] + code[at + 1 :] + tail)


def _close_quotes(window: _Window, line: int) -> Iterator[_Change]:
    """Quotes that are missing at one end, or at both ends of an expression or a colour."""
    text = window.text(line)
    for quote in ('"', "'"):
        if text.count(quote) % 2:
            for found in re.finditer(quote, text):
                inner = re.match(r"#[0-9A-Fa-f]{3,8}\b|\$\{[^}]*\}[\w.-]*|[^\s,\[\]{}\"']+", text[found.end() :])
                if inner is not None:
                    end = found.end() + inner.end()
                    yield _Change("this quote is never closed", text[:end] + quote + text[end:])
                start = re.search(r"(?:\$\{[^}]*\}[\w.-]*|#[0-9A-Fa-f]+|[^\s,\[\]{}\"']+)$", text[: found.start()])
                if start is not None:
                    yield _Change("a quote is missing", text[: start.start()] + quote + text[start.start() :])
            yield _Change("this quote is never closed", text.rstrip() + quote)
    quoted = re.sub(r"(?<=[:,\[] )(#[0-9A-Fa-f]{3,8})\b", r'"\1"', text)
    if quoted != text:
        yield _Change("a bracket is not closed: `#` starts a comment", quoted)
    quoted = re.sub(r"(?<![\"'\w])(\$\{(?:[^{}\"]|\{[^}]*\})*\}[\w.-]*)", r'"\1"', text)
    if quoted != text:
        yield _Change("unquoted expression: inside brackets, `{` starts a mapping", quoted)
