"""Applies hints to scene files, as a person who pastes what they say does."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any, Final

import yaml

from scenecc.diagnostics import Diagnostic

_CODE: Final = re.compile(r"`([^`]+)`")
_ENTRY: Final = re.compile(r'("?[\w.*-]+"?): ')
_TRIES: Final = 6
_WHOLE: Final = frozenset({"SC101", "SC006"})
"""Codes of errors of whole entries."""


def pasted(text: str, validate: Callable[[str], list[Diagnostic]]) -> str | None:
    """Returns a scene after the changes that the hints of its errors name, one after the other; None if errors stay."""
    for _ in range(_TRIES):
        first = next((one for one in validate(text) if one.severity == "error"), None)
        if first is None:
            return text
        changed = _paste(text, first)
        if changed is None or changed == text:
            return None
        text = changed
    return None


def changed_lines(text: str, result: str) -> str:
    """Returns the lines of a result that a text does not have, without indentation."""
    return "\n".join(line.strip() for line in result.splitlines() if line not in text.splitlines())


def snippet(hint: str) -> str | None:
    """Returns what a hint says to write: its first complete entry, or the text after "did you mean" or "write"."""
    codes = [code for code in _CODE.findall(hint) if "…" not in code]
    named = [code for code in codes if _ENTRY.match(code)]
    meant = re.search(r"(?:did you mean|write|quote it:|colour:|quotes:|minus:|written|brackets:) `([^`]+)`", hint)
    return named[0] if named else meant[1] if meant and "…" not in meant[1] else None


def _paste(text: str, found: Diagnostic) -> str | None:  # noqa: PLR0911 - a return for each form of hint
    hint, (line, column) = found.hint or "", (found.line or 1, found.column or 1)
    place, new = (line - 1, column - 1), snippet(hint)
    try:
        top: Any = yaml.compose(text)
    except yaml.YAMLError:
        start = sum(map(len, text.splitlines(keepends=True)[: line - 1])) + column - 1
        end = start + (found.location.end_column or column) - column
        return None if new is None else _put(text, new, (start, end))
    nothing: tuple[Any, Any] = None, None
    key, value = next((pair for pair in _pairs(top) if _start(pair[0]) == place), nothing)
    if hint.startswith("remove it") and key is not None:
        return _without(text, *_span(text, key, value))
    if new is None:
        return None
    entry = _ENTRY.match(new)
    if key is not None and hint.startswith("did you mean") and entry is None:
        return _put(text, new, _span(text, key, key))
    if both := re.search(r"`([^`]+)` and `([^`]+)`", hint):
        new = f"{both[1]}, {both[2]}"
    around = [pair for pair in _pairs(top) if _start(pair[0]) <= place <= _end(pair[1])]
    same = [pair for pair in around if entry and _alike(str(pair[0].value), entry[1].strip('"'))]
    if key is not None and found.code in _WHOLE and not (found.code == "SC006" and same):
        return _put(text, _as_block(new, text, key), _span(text, key, value))
    if same:
        return _put(text, new, _span(text, *same[-1]))
    node = next((node for node in _nodes(top) if _start(node) == place), value)
    if node is None:
        return None
    if found.code == "SC102" and entry and isinstance(node, yaml.MappingNode) and node.flow_style:
        start = node.start_mark.index + 1
        return f"{text[:start]}{new}, {text[start:]}"
    return _put(text, new, _span(text, node, node))


def _alike(key: str, new: str) -> bool:
    """Whether one key is written instead of the other: the same, or in degrees."""
    return key in {new, new.removesuffix("_deg")}


def _as_block(new: str, text: str, key: yaml.Node) -> str:
    """Two entries in a block are two lines."""
    line = text.splitlines()[key.start_mark.line]
    is_block = line[: key.start_mark.column].strip(" -") == ""
    return re.sub(r", (?=height: )", "\n" + " " * key.start_mark.column, new) if is_block else new


def _put(text: str, new: str, span: tuple[int, int]) -> str:
    return text[: span[0]] + new + text[span[1] :]


def _without(text: str, start: int, end: int) -> str:
    """Removes an entry with its line, or with its comma."""
    if not text[text.rfind("\n", 0, start) + 1 : start].strip():
        return text[: text.rfind("\n", 0, start) + 1] + text[end + 1 :]
    if text[end : end + 2] == ", ":
        return text[:start] + text[end + 2 :]
    return text[:start].removesuffix(", ") + text[end:]


def _start(node: yaml.Node) -> tuple[int, int]:
    return node.start_mark.line, node.start_mark.column


def _end(node: yaml.Node) -> tuple[int, int]:
    return node.end_mark.line, node.end_mark.column


def _span(text: str, first: yaml.Node, last: yaml.Node) -> tuple[int, int]:
    start = first.start_mark.index
    return start, start + len(text[start : last.end_mark.index].rstrip())


def _pairs(node: yaml.Node) -> Iterator[tuple[yaml.Node, yaml.Node]]:
    for one in _nodes(node):
        if isinstance(one, yaml.MappingNode):
            yield from one.value


def _nodes(node: yaml.Node) -> Iterator[yaml.Node]:
    yield node
    parts = node.value if isinstance(node, yaml.SequenceNode) else ()
    if isinstance(node, yaml.MappingNode):
        parts = [part for pair in node.value for part in pair]
    for part in parts:
        yield from _nodes(part)
