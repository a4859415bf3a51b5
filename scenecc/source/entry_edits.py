"""Edits of the entries of a YAML text: written, merged, moved into a mapping, removed. All other text is kept."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.source.document import written_tree

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import At, PathKey
    from scenecc.source.document import Place, WrittenEntry, WrittenNode


class Splice(NamedTuple):
    """Replaces the characters from `start` to `end` of a text."""

    start: int
    end: int
    text: str


def ordered(*splices: Splice) -> tuple[Splice, ...]:
    """Returns splices in text order; none if two of them overlap."""
    made = sorted(splices)
    if any(one.end > other.start for one, other in pairwise(made)):
        return ()
    return tuple(made)


class Step(NamedTuple):
    """One entry or list item on the way from the root of a text to a place."""

    inside: WrittenNode
    key: PathKey

    @property
    def node(self) -> WrittenNode:
        """The value or item."""
        return self.inside.entries[self.key].node if isinstance(self.key, str) else self.inside.items[self.key]


Chain = tuple[Step, ...]
"""The way from the root to an entry or item."""


def chains(root: WrittenNode, place: Place) -> Iterator[tuple[Chain, At]]:
    """Yields the entries and items whose key or value begins at a place, outermost first."""
    todo: list[tuple[WrittenNode, Chain]] = [(root, ())]
    while todo:
        node, chain = todo.pop()
        if any(step.inside is node for step in chain):
            continue  # an alias leads back
        for key, entry in node.entries.items():
            if not entry.merged and entry.key[:2] == place:
                yield (*chain, Step(node, key)), "key"
        below = [
            *((key, entry.node) for key, entry in node.entries.items() if not entry.merged),
            *enumerate(node.items),
        ]
        todo += ((one, (*chain, Step(node, key))) for key, one in below if one.span[:2] <= place <= one.end)
        if chain and node.span[:2] == place:
            yield chain, "value"


@lru_cache(maxsize=1)
def _line_starts(text: str) -> list[int]:
    return [0, *(match.end() for match in re.finditer(r"\r\n?|\n", text))]


class EntryEdits:
    """Makes edits of one text. An edit that is not possible has no splices."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._break = "\r\n" if "\r\n" in text else "\n"
        self.lines = _line_starts(text)

    def index(self, place: Place) -> int:
        """Returns the position of a place in the text."""
        return min(self.lines[min(place[0], len(self.lines) - 1)] + place[1], len(self._text))

    def is_here(self, step: Step) -> bool:
        """Returns whether a value is written in its place, and is not an alias."""
        if isinstance(step.key, str):
            return step.node.span[:2] >= step.inside.entries[step.key].key[:2]
        return step.node.span[:2] >= step.inside.span[:2]

    def value_range(self, step: Step) -> tuple[int, int]:
        """Returns where a value or item begins and ends."""
        start = self.index(step.node.span[:2])
        return start, max(start + len(self._text[start : self.index(step.node.end)].rstrip()), start)

    def entry_range(self, step: Step) -> tuple[int, int]:
        """Returns where an entry, from its key, or an item begins and ends."""
        start, end = self.value_range(step)
        return (self.index(step.inside.entries[step.key].key[:2]) if isinstance(step.key, str) else start), end

    def replaced(self, step: Step, new: Entries) -> tuple[Splice, ...]:
        """Writes entries in place of one. Another entry of the same name is merged."""
        if not self.is_here(step):
            return ()
        if not isinstance(step.key, str):
            return (Splice(*self.entry_range(step), "{" + new.text(self._gap(None)) + "}"),)
        return (Splice(*self.entry_range(step), new.text(self._gap(self._column(step)))),)

    def _gap(self, column: int | None) -> str:
        """Returns what stands between entries in brackets, or in a block at a column."""
        return ", " if column is None else self._break + " " * column

    def _column(self, step: Step) -> int | None:
        """Returns the column of an entry in a block; None in brackets."""
        return step.inside.entries[step.key].key[1] if step.inside.is_block and isinstance(step.key, str) else None

    def set_in(self, inside: WrittenNode, new: Entries, before: Step | None = None) -> tuple[Splice, ...]:
        """Writes entries in a mapping; mappings of the same name are merged, other values replaced."""
        splices: list[Splice] = []
        added: list[str] = []
        for name, value in new.values.items():
            entry = inside.entries.get(name)
            if entry is None:
                added.append(new.entry(name))
                continue
            step, node = Step(inside, name), entry.node
            if entry.merged or not self.is_here(step):
                return ()
            if node.entries and value.node.entries:
                splices += self.set_in(node, Entries(new.code, {**value.node.entries}))
            elif node.entries or any(item.text is None for item in node.items):
                return ()  # it would lose what is written
            else:
                start, end = self.value_range(step)
                splices.append(Splice(start, end, (" " if start == end else "") + new.value(name)))
        first = next((key for key, one in inside.entries.items() if not one.merged), None)
        if added and first is not None:
            at = before if before is not None and before.inside is inside else Step(inside, first)
            start, _ = self.entry_range(at)
            gap = self._gap(self._column(at))
            splices.append(Splice(start, start, gap.join(added) + gap))
        elif added:
            return ()
        return ordered(*splices)

    @staticmethod
    def emptied(chain: Chain) -> Chain:
        """Returns the way to what has no other content than the end of a way."""
        while len(chain) > 1 and len(chain[-1].inside.entries) + len(chain[-1].inside.items) == 1:
            chain = chain[:-1]
        return chain

    def without(self, chain: Chain) -> tuple[Splice, ...]:
        """Removes an entry or item; with it what then is empty."""
        step = self.emptied(chain)[-1]
        if not self.is_here(step):
            return ()
        start, end = self.entry_range(step)
        text = self._text
        if step.inside.is_block:
            line = self.lines[bisect_right(self.lines, start) - 1]
            below = self.lines[min(bisect_right(self.lines, end), len(self.lines) - 1)]
            below = below if below > end else len(text)
            indent = text[line:start]
            if not indent.strip() or (not isinstance(step.key, str) and indent.strip() == "-"):
                return (Splice(line, below, ""),)
            following = re.compile(r"[ \t]*").match(text, below)
            return (Splice(start, following.end() if following else below, ""),)
        after = re.compile(r"\s*,\s*").match(text, end)
        if after is not None:
            return (Splice(start, after.end(), ""),)
        return (Splice(start - len(text[:start]) + len(re.sub(r",\s*\Z", "", text[:start])), end, ""),)


ENTRY: Final = re.compile(r'(?:- )?("[^"]+"|[\w.*/-]+): +\S')
"""A key with its value."""


@dataclass(frozen=True, slots=True)
class Entries:
    """Entries that a hint says to write.

    Attributes:
        code: a flow mapping that has them, in one line.
        values: its entries, by key.
    """

    code: str
    values: dict[str, WrittenEntry]

    @staticmethod
    def read(code: str) -> Entries | None:
        """Reads `key: value, key: value`; None for anything else."""
        if ENTRY.match(code) is None:
            return None
        flow = "{" + code.removeprefix("- ") + "}"
        tree = written_tree(flow)
        values = {**tree.root.entries}
        return Entries(flow, values) if tree.is_whole and values and "" not in values else None

    def value(self, name: str) -> str:
        """Returns the text of a value."""
        span = self.values[name].node.span
        return self.code[span[1] : span[2]]

    def entry(self, name: str) -> str:
        """Returns the text of an entry."""
        key = self.values[name].key
        return f"{self.code[key[1] : key[2]]}: {self.value(name)}"

    def text(self, gap: str) -> str:
        """Returns the texts of all entries. `gap`: what stands between them."""
        return gap.join(map(self.entry, self.values))
