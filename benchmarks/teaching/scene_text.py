"""The text of a shipped scene with its entries, and edits of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final, NamedTuple

import yaml

from scenecc.diagnostics import Sink
from scenecc.source import make_limits, read_text
from scenecc.spec.json_schema import json_schema

NAMED: Final = frozenset(
    ("entities", "materials", "lights", "cameras", "constraints", "frames", "params", "draws", "collision_groups",
     "links", "joints", "drives", "attach", "override", "with", "repeat", "near", "qpos")
)  # fmt: skip
"""Keys of mappings whose keys are names."""


def _language() -> frozenset[str]:
    schema = json_schema()
    return frozenset(key for one in (schema, *schema["$defs"].values()) for key in one.get("properties", ()))


LANGUAGE: Final = _language()
"""Keys that the language has in any place."""


class Edit(NamedTuple):
    """A replacement of characters from `start` to `end` of a text."""

    start: int
    end: int
    new: str


class Fault(NamedTuple):
    """A fault of one scene.

    Attributes:
        what: its kind, in words.
        edits: of the text.
        at: characters of the text on whose lines a person looks for it.
        codes: pattern of the codes that name it.
    """

    what: str
    edits: tuple[Edit, ...]
    at: tuple[int, ...]
    codes: str


@dataclass(frozen=True, eq=False)
class Entry:
    """An entry of a mapping, or an item of a list (without a key)."""

    path: tuple[str | int, ...]
    key: yaml.Node | None
    value: yaml.Node

    @property
    def name(self) -> str:
        """The last key of its path that is not an index."""
        return next((one for one in reversed(self.path) if isinstance(one, str)), "")

    @property
    def is_key(self) -> bool:
        """Whether its key is a word of the language, not a name."""
        *above, last = ("", *self.path)
        return self.key is not None and above[-1:] != [] and above[-1] not in NAMED and last in LANGUAGE

    @property
    def start(self) -> int:
        """The first character of its key or its value."""
        return (self.key or self.value).start_mark.index


class SceneText:
    """A scene file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.text = path.read_text(encoding="utf-8")

    @cached_property
    def entries(self) -> list[Entry]:
        """All entries and items, in the order of the text."""
        top = yaml.compose(self.text)
        every = [] if top is None else _entries((), top)
        found = {entry.start: entry for entry in every if "<<" not in entry.path}
        return sorted(found.values(), key=lambda one: one.start)

    @cached_property
    def data(self) -> Any:
        """The mapping that scenecc reads."""
        document = read_text(self.text, str(self.path), Sink(), make_limits(), self.path)
        assert document is not None
        return document.data

    def entries_of(self, *names: str) -> list[Entry]:
        """Returns the entries with one of some keys of the language; without names, all."""
        return [one for one in self.entries if one.is_key and (not names or one.path[-1] in names)]

    def end(self, node: yaml.Node) -> int:
        """The character after a node, without the blank lines and comments that YAML counts to a block."""
        text = self.text[node.start_mark.index : node.end_mark.index]
        while (last := text.rstrip().rpartition("\n")[2].lstrip()).startswith("#"):
            text = text.rstrip()[: -len(last)]
        return node.start_mark.index + len(text.rstrip())

    def source(self, node: yaml.Node) -> str:
        return self.text[node.start_mark.index : self.end(node)]

    def line_start(self, at: int) -> int:
        return self.text.rfind("\n", 0, at) + 1

    def begins_line(self, entry: Entry) -> bool:
        return not self.text[self.line_start(entry.start) : entry.start].strip(" -")

    def is_one_line(self, entry: Entry) -> bool:
        return "\n" not in self.text[entry.start : self.end(entry.value)]

    def at_path(self, path: tuple[str | int, ...]) -> Any:
        """Returns the data at a path."""
        node = self.data
        for key in path:
            node = node[key]
        return node

    def without(self, entry: Entry) -> Edit:
        """Returns the edit that removes an entry, with its comma or its line."""
        start, end = entry.start, self.end(entry.value)
        if self.text[end : end + 2] == ", ":
            return Edit(start, end + 2, "")
        if self.text[max(start - 2, 0) : start] == ", ":
            return Edit(start - 2, end, "")
        line_end = self.text.find("\n", end)
        return Edit(self.line_start(start), line_end + 1, "")


def applied(text: str, edits: tuple[Edit, ...]) -> str:
    """Returns a text with edits that do not overlap."""
    for edit in sorted(edits, reverse=True):
        text = text[: edit.start] + edit.new + text[edit.end :]
    return text


def lines_of(text: str, fault: Fault, edits: tuple[Edit, ...]) -> set[int]:
    """Returns the lines of a fault after edits, its own among them."""
    changed, lines = applied(text, edits), set[int]()
    for at in fault.at:
        moved = sum(len(one.new) - (one.end - one.start) for one in edits if one.start < at and one.end <= at)
        lines.add(changed.count("\n", 0, at + moved) + 1)
    return lines


def numbers(value: Any) -> list[float]:
    """Returns a number, or the numbers of a list; empty if it is or has something else."""
    found = value if isinstance(value, list) else [value]
    is_plain = all(isinstance(one, int | float) and not isinstance(one, bool) for one in found)
    return list(found) if is_plain else []


def _entries(path: tuple[str | int, ...], node: yaml.Node) -> Iterator[Entry]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield Entry((*path, str(key.value)), key, value)
            yield from _entries((*path, str(key.value)), value)
    elif isinstance(node, yaml.SequenceNode):
        for index, value in enumerate(node.value):
            yield Entry((*path, index), None, value)
            yield from _entries((*path, index), value)
