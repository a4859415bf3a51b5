"""Text edits from the hints of findings: what a hint says to write, rename or remove, at each place that it may mean.

A hint is a sentence for people; what it says to write is in backticks. Whether an edit mends the finding is known only
after another check.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.diagnostics.diagnostic import dotted
from scenecc.diagnostics.messages import cut
from scenecc.source.document import written_tree
from scenecc.source.entry_edits import ENTRY, Chain, Entries, EntryEdits, Splice, Step, chains, ordered
from scenecc.source.events import resolve_scalar

if TYPE_CHECKING:
    from scenecc.diagnostics import Diagnostic
    from scenecc.diagnostics.diagnostic import At, Location
    from scenecc.source.document import WrittenTree


class HintEdit(NamedTuple):
    """An edit that a hint suggests.

    Attributes:
        title: what it does, for users. Edits with one title are the same advice at different places, likeliest first.
        splices: disjoint changes, in text order.
        is_guess: whether the hint only asks whether this was meant.
    """

    title: str
    splices: tuple[Splice, ...]
    is_guess: bool = False

    def applied(self, text: str) -> str:
        """Returns a text after the edit."""
        for start, end, new in reversed(self.splices):
            text = text[:start] + new + text[end:]
        return text


def hint_edits(text: str, found: Diagnostic, tree: WrittenTree | None = None) -> list[HintEdit]:
    """Returns the edits that the hint of a finding suggests, without repetition.

    Args:
        text: the text in which it was found.
        found: the finding.
        tree: the nodes of the text, if they are known.
    """
    if found.hint is None or found.line is None or found.column is None:
        return []
    edits = dict[tuple[Splice, ...], HintEdit]()
    for edit in _Editor(text, found, tree or written_tree(text)).edits():
        if edit.splices and edit.applied(text) != text:
            edits.setdefault(edit.splices, edit)
    return list(edits.values())


def safe_edit(text: str, found: Diagnostic, tree: WrittenTree | None = None) -> HintEdit | None:
    """Returns the edit that `--fix` makes: the finding's own correction, or another notation of the same value that its
    hint gives. None if there is none, or if its place is not whole and on one line.

    Arguments as for `hint_edits`.
    """
    if found.fix is not None:
        return _declared_edit(text, found)
    if not may_be_safe(found) or not _is_unchanged(text, found.location):
        return None
    edit = next(iter(hint_edits(text, found, tree)), None)
    if edit is None or len(edit.splices) != 1:
        return None
    start, end, new = edit.splices[0]
    old = text[start:end]
    return edit if "\n" not in old and _is_same_value(old, new) else None


def may_be_safe(found: Diagnostic) -> bool:
    """Returns whether a finding may have a safe edit, without a look at its text."""
    if found.fix is not None:
        return found.file == found.fix.location.file
    return found.hint is not None and _NOTATION.fullmatch(found.hint) is not None


def _is_unchanged(text: str, place: Location) -> bool:
    """Returns whether the line of a place is the same up to its end, after edits of other lines."""
    if place.line is None or not place.end_column or place.text is None:
        return False
    lines = text.split("\n")
    line = lines[place.line - 1] if place.line <= len(lines) else ""
    return line[: place.end_column - 1] == place.text[: place.end_column - 1]


_NOTATION: Final = re.compile(
    r"(?:write|write (?:commas and|it in|its numbers in) brackets:) `[^`\n]+`(?:, without quotes)?(?:[:;] [^`]*)?"
)
"""A hint with one entry or value to write, without a condition."""


def _is_same_value(old: str, new: str) -> bool:
    """Returns whether two entries, or values, write the same numbers and words, or the new one a word as a number or
    colour.
    """
    was, now = (re.sub(r"\A[\w.-]+:\s+", "", one) for one in (old, new))
    if re.findall(r"[\w.+-]+", was) == re.findall(r"[\w.+-]+", now):
        return True
    try:
        is_word = isinstance(resolve_scalar(was), str) and was[:1] not in {"[", "{"}
        return is_word and (now.startswith('"#') or not isinstance(resolve_scalar(now), str))
    except OverflowError:
        return False


def _declared_edit(text: str, found: Diagnostic) -> HintEdit | None:
    fix = found.fix
    if fix is None or not _is_unchanged(text, place := fix.location):
        return None
    assert place.line is not None
    assert place.column is not None
    start = sum(len(one) + 1 for one in text.split("\n")[: place.line - 1]) + place.column - 1
    end = start + (place.end_column or 0) - place.column
    old = text[start:end]
    is_list = fix.text.startswith("[")
    quote = old[:1] if old[:1] in {"'", '"'} and old[:1] == old[-1:] and not is_list else ""
    key = old[len(quote) : len(old) - len(quote)]
    if not (old[:1] == "[" and old[-1:] == "]" if is_list else key.isidentifier()):
        return None
    return HintEdit(f"Write `{cut(fix.text)}`", (Splice(start, end, quote + fix.text + quote),))


# ---------------------------------------------------------------------------------------------------------------------
# What a hint says

_CODE: Final = re.compile(r"`([^`\n]+)`")

_MEANT: Final = re.compile(r"(?:\A|; )did you mean (`[^`\n]+`(?:(?:, | or )`[^`\n]+`)*)\?")

_LEAD: Final = re.compile(r"(?:write|written|[a-z]:) \Z")
"""What stands before a value to write."""

_BLANK: Final = re.compile(r"…|\b(?:NAME|FILE|FOLDER|KEY|LINK|JOINT|ENTITY)\b")
"""A part that only the user knows."""

_REMOVE: Final = re.compile(
    r"(?:\A|, or |: )(?:remove (?:it\b|the (\w+)|`(?P<name>[^`\n-][^`\n]*)`)|leave `(?P<left>[^`\n]+)` out)"
)

_INSTEAD: Final = re.compile(r"(?:write|use) `(\w+)` instead of `(\w+)`")

_ABOVE: Final = re.compile(r"(?:beside|under) `(\w+)`|(at the top)")
"""Where else to write it: beside or below another key, or at the top of the file."""


_FEWER: Final = 9
"""How many runs of lines, from the longest, may be indented."""

_NAMES: Final = 1
"""Depth of the mappings of names, such as `entities`: a key written there would be a name."""


def written_codes(hint: str) -> list[str]:
    """Returns what a hint says to write, in its order: entries, and values after "write"; joined if it says "and"."""
    found: list[str] = []
    end, joins = 0, False
    for match in _CODE.finditer(hint):
        code, between = match[1], hint[end : match.start()]
        is_next = bool(found) and between.strip(" ,") in {"or", "and", "or write"}
        if ENTRY.match(code) or _LEAD.search(hint[: match.start()]) or is_next:
            if between == " and " and joins and ENTRY.match(code):
                found[-1] += f", {code}"
            else:
                found.append(code)
            joins, end = ENTRY.match(code) is not None, match.end()
        else:
            joins = False
    return found


class _Editor:
    """Makes the edits of one finding."""

    def __init__(self, text: str, found: Diagnostic, tree: WrittenTree) -> None:
        self._text = text
        self._found = found
        self._hint = found.hint or ""
        self._writer = EntryEdits(text)
        self._root = tree.root
        assert found.line is not None
        assert found.column is not None
        place = found.line - 1, found.column - 1
        self._start = self._writer.index(place)
        end = found.location.end_column
        self._end = max(self._writer.index((place[0], end - 1)) if end else self._start, self._start)
        here = list(chains(tree.root, place)) if tree.is_whole else []
        named = [one for one in here if dotted(tuple(step.key for step in one[0])) == found.path]
        keys = [one for one in here if one[1] == "key"]
        self._chain: Chain = ()
        self._at: At = "value"
        for chain, at in (*here[-1:], *keys[-1:], *named[-1:]):
            self._chain, self._at = chain, at

    def edits(self) -> Iterator[HintEdit]:
        """Yields all edits, likeliest first."""
        yield from self._meant()
        yield from self._of_lines()
        removed = list(self._removals())
        if self._hint.startswith(("remove", "leave")) and "and write" not in self._hint:
            yield from removed
        codes = [code for code in written_codes(self._hint) if not _BLANK.search(code)]
        if not self._chain or self._hint.startswith("quote it"):
            yield from (HintEdit(f"Write `{cut(code)}`", self._at_mark(code)) for code in codes)
            return
        instead = _INSTEAD.search(self._hint)
        if instead is not None:
            yield from self._renamed(instead[2], instead[1])
        for code in codes:
            entries = Entries.read(code)
            made = self._value(code) if entries is None else self._entries(entries)
            for splices in made:
                yield HintEdit(f"Write `{cut(code)}`", splices)
            if entries is not None and "and write" in self._hint:
                top = self._added(0, entries)
                yield from (HintEdit(f"Write `{cut(code)}`", ordered(*one.splices, *top)) for one in removed)
        yield from removed

    # ------------------------------------------------------------------------------------ lines, words and removals

    def _of_lines(self) -> Iterator[HintEdit]:
        """Yields edits of indentation and double keys."""
        if self._hint.startswith("write two spaces instead of each tab"):
            tabs = [Splice(at, at + 1, "  ") for at, one in enumerate(self._text) if one == "\t"]
            yield HintEdit("Write two spaces instead of each tab", tuple(tabs))
        if straight := re.match(r"indent it by (\d+) spaces|remove the blanks before it", self._hint):
            line = self._writer.lines[bisect_right(self._writer.lines, self._start) - 1]
            yield HintEdit(straight[0].capitalize(), (Splice(line, self._start, " " * int(straight[1] or 0)),))
        if self._hint.startswith(("indent the lines below", "indent it and")):
            yield from self._indented()
        if self._found.code == "SC004":
            yield from self._first_of_two()

    def _at_mark(self, code: str) -> tuple[Splice, ...]:
        """Replaces what the finding underlines."""
        return (Splice(self._start, self._end, code),) if self._end > self._start else ()

    def _meant(self) -> Iterator[HintEdit]:
        meant = _MEANT.search(self._hint)
        for word in () if meant is None else _CODE.findall(meant[1]):
            is_double = self._at == "key" and bool(self._chain) and word in self._chain[-1].inside.entries
            if "…" in word or is_double:
                continue
            marked = self._text[self._start : self._end]
            quote = marked[:1] if marked[:1] in {"'", '"'} and marked[:1] == marked[-1:] else ""
            shown = word if word[:1] in {"[", "{"} else f"{quote}{word}{quote}"
            yield HintEdit(f"Change to `{cut(word)}`", self._at_mark(shown), is_guess=True)

    def _removals(self) -> Iterator[HintEdit]:
        asked = _REMOVE.search(self._hint)
        if asked is None:
            return
        name = asked["name"] or asked["left"]
        if not self._chain:
            if asked[1] is None and name is None:
                yield HintEdit("Remove it", self._at_mark(""))
            return
        ways = [self._chain]
        if name is not None:
            name = name.partition(":")[0]
            around = [*(step.inside for step in self._chain), self._chain[-1].node]
            depths = _inner([at for at, one in enumerate(around) if name in one.entries])
            ways = [(*self._chain[:at], Step(around[at], name)) for at in reversed(depths)]
        elif asked[1] not in {None, "key"}:
            ways += [self._chain[:-1]] * (len(self._chain) > 1)
        for way in ways:
            key = way[-1].key
            title = f"Remove `{cut(str(key))}`" if isinstance(key, str) else f"Remove item {key + 1}"
            yield HintEdit(title, self._writer.without(way))

    def _first_of_two(self) -> Iterator[HintEdit]:
        """Removes the first of two equal keys."""
        first = next((one.location for one in self._found.related if one.location.file == self._found.file), None)
        if first is not None and first.line is not None and first.column is not None:
            for chain, at in chains(self._root, (first.line - 1, first.column - 1)):
                if at == "key":
                    yield HintEdit(f"Remove the first `{cut(str(chain[-1].key))}`", self._writer.without(chain))

    def _indented(self) -> Iterator[HintEdit]:
        """Indents the lines below the finding that belong to it, or only the first of them; with its own or without."""
        assert self._found.line is not None
        column, own = (self._found.column or 1) - 1, self._hint.startswith("indent it and")
        starts: list[int] = []
        cuts: list[int] = []
        least = None
        for start, end in pairwise([*self._writer.lines[self._found.line :], len(self._text)]):
            text = self._text[start:end]
            indent = len(text) - len(text.lstrip(" "))
            if text.strip() and indent < column + own:
                break
            if text.strip():
                least = indent if least is None else min(least, indent)
                cuts += [len(starts)] * (indent == least and bool(starts))
                starts.append(start)
        mark = [self._writer.lines[self._found.line - 1]] * own
        if starts or own:
            for count in [len(starts), *reversed(cuts)][:_FEWER]:
                splices = tuple(Splice(at, at, "  ") for at in [*mark, *starts[:count]])
                yield HintEdit("Indent the lines below it", splices)

    def _renamed(self, old: str, new: str) -> Iterator[HintEdit]:
        """Renames the nearest key of a name, alone or with the entry of the finding removed."""
        last = self._chain[-1].node
        for inside in (last, *(step.inside for step in reversed(self._chain))):
            if old in inside.entries and new not in inside.entries:
                line, start, end = inside.entries[old].key
                if end is not None:
                    rename = Splice(self._writer.index((line, start)), self._writer.index((line, end)), new)
                    for more in (), self._writer.without(self._chain) if inside is not last else ():
                        yield HintEdit(f"Write `{new}` instead of `{old}`", ordered(rename, *more))

    # ------------------------------------------------------------------------------------------------------- values

    def _value(self, code: str) -> Iterator[tuple[Splice, ...]]:
        """Writes a value: for the whole value, or for its underlined part."""
        last = self._chain[-1]
        if self._writer.is_here(last) and (self._at == "value" or code[0] in "{[\"'"):
            start, end = self._writer.value_range(last)
            yield (Splice(start, end, f" {code}" if start == end else code),)
        yield self._at_mark(code)

    def _entries(self, new: Entries) -> Iterator[tuple[Splice, ...]]:
        """Writes entries: where the hint says, in place of what is alike, or in a mapping around it."""
        last, depth = self._chain[-1], len(self._chain) - 1
        name = next(iter(new.values))
        above = _ABOVE.search(self._hint)
        if above is not None:
            up = [at for at in range(depth + 1) if above[1] in self._chain[at].inside.entries]
            at = 0 if above[2] else up[-1] if up else None
            if at is not None:
                yield self._added(at, new) if "declare" in self._hint else self._moved(at, new)
        alike = _inner([at for at, step in enumerate(self._chain) if _alike(str(step.key), name)])
        replaced = [self._writer.replaced(self._chain[at], new) for at in reversed(alike)]
        is_misplaced = self._found.code == "SC101"
        if last.node.entries and not is_misplaced:
            yield self._writer.set_in(last.node, new)
        if is_misplaced and depth not in alike:
            yield self._moved(depth, new)
        yield from replaced
        if not is_misplaced and not last.node.entries:
            if depth not in {_NAMES, *alike}:  # beside the entry of the finding, which may be meant as well
                yield self._added(depth, new)
            yield self._moved(depth, new)
        if self._at == "value":
            yield from (self._added(at, new) for at in reversed(range(depth)) if at != _NAMES)

    def _moved(self, depth: int, new: Entries) -> tuple[Splice, ...]:
        """Removes the entry of the finding, and writes entries in the mapping at a depth of the chain."""
        emptied = self._writer.emptied(self._chain)
        inside, key = self._chain[depth]
        if len(emptied) <= depth + 1 and not (inside.entries.keys() & new.values.keys()) - {key}:
            return self._writer.replaced(self._chain[depth], new)
        removed, added = self._writer.without(emptied), self._added(depth, new)
        return ordered(*removed, *added) if removed and added else ()

    def _added(self, depth: int, new: Entries) -> tuple[Splice, ...]:
        step = self._chain[depth]
        return self._writer.set_in(step.inside, new, before=step) if isinstance(step.key, str) else ()


def _inner(depths: list[int]) -> list[int]:
    """Returns the depths of keys without that of an object's name, which may equal the key that a hint means."""
    return [at for at in depths if at != _NAMES] or depths


def _alike(key: str, new: str) -> bool:
    """Returns whether one key is written instead of the other: the same, or in degrees."""
    return key in {new, new.removesuffix("_deg")}
