"""Formatting of values and names in messages, and suggestions of similar words."""

from __future__ import annotations

import difflib
import re
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.diagnostics.diagnostic import Sink

_NEAR: Final = 3
"""Maximum number of known words in a hint."""

_LONGEST = 60
"""Maximum length of a word that is compared with the known ones [characters]."""

_GUESSES, _NAMES = 20, 1000
"""Number of reports after which no names are guessed, and maximum number of compared names."""


def suggest(word: str, known: Iterable[str], lists: str = "") -> str | None:
    """Returns a hint with the nearest known word, or else a few of them; None if there are none. `lists`: as for
    `listed`.
    """
    known = tuple(known)
    near = nearest(word, known)
    return f"did you mean `{near}`?" if near else listed(known, word, lists)


def listed(known: Sequence[str], word: str = "", lists: str = "") -> str | None:
    """Returns a hint with the known words, at most the three most similar to `word`; None if there are none.

    Args:
        known: the known words.
        word: the unknown one.
        lists: what lists all of them, for example a command.
    """
    if len(known) <= _NEAR:
        return "known here: " + ", ".join(map(cut, known)) if known else None
    near = difflib.get_close_matches(word[:_LONGEST], known, n=_NEAR, cutoff=0) if word else known[:_NEAR]
    others = len(known) - _NEAR
    more = f"{others} other{'' if others == 1 else 's'}" + (f" ({lists} lists all)" if lists else "")
    return f"{'the nearest here' if word else 'known here'}: {', '.join(map(cut, near))} and {more}"


def nearest(word: str, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """Returns the known word most similar to another; None if there is none. `cutoff`: minimum similarity, 0 to 1."""
    # Only words about as long as a key are compared, not a megabyte of untrusted text.
    if len(word) > _LONGEST:
        return None
    known = tuple(known)
    near = difflib.get_close_matches(word, known, n=1, cutoff=cutoff)
    near = near or difflib.get_close_matches(word.lower(), known, n=1, cutoff=cutoff)
    # Two words of another beginning resemble each other by chance: `free` and `repeat`, `units` and `entities`.
    starts = word[:1].lower() == near[0][:1].lower() if near else False
    by_chance = near and not starts and word.lower() not in near[0] and near[0] not in word.lower()
    if by_chance and not difflib.get_close_matches(word.lower(), near, n=1, cutoff=max(cutoff, _ALIKE)):
        return None
    return near[0] if near else None


_ALIKE: Final = 0.7
"""Similarity of two words that do not begin alike and do not contain each other, from which one may be meant."""


def is_slip_of(word: str, known: Iterable[str]) -> bool:
    """Returns whether exactly one known word is similar, and its length differs by at most two."""
    near = difflib.get_close_matches(word, known, n=2, cutoff=0.6) if len(word) <= _LONGEST else []
    return len(near) == 1 and abs(len(near[0].replace("_", "")) - len(word.replace("_", ""))) <= _LETTERS


_LETTERS: Final = 2
"""`size` and `half_size` are different things."""


def suggest_name(word: str, names: Iterable[str], sink: Sink, further: Iterable[str] = ()) -> str | None:
    """Returns `suggest` among a document's names, of which there may be too many to compare.

    `further`: names that may be suggested but are not listed.
    """
    if sink.reported >= _GUESSES:
        return None
    known = tuple(islice(names, _NAMES))
    near = nearest(word, (*known, *islice(further, _NAMES - len(known))))
    return f"did you mean `{near}`?" if near else listed(known, word)


LISTS_KEYS: Final = "`scenecc schema`"
"""The command that lists all keys and the words that are their values."""


def show(found: Any, width: int = 60) -> str:
    """Returns a value for a message, shortened if it is long."""
    text = str(found).lower() if isinstance(found, bool) else repr(found)
    return cut(text, width)


def cut(text: str, width: int = 60) -> str:
    """Returns a text shortened to a width, because a file may contain any text."""
    return text if len(text) <= width else text[: width - 1] + "…"


def index_ranges(idxs: Sequence[int]) -> str:
    """Returns ascending scene indices in short form: `0, 2`, `0–4095`, `0–3, 8`."""
    runs: list[list[int]] = []
    for idx in idxs:
        if runs and idx == runs[-1][1] + 1:
            runs[-1][1] = idx
        else:
            runs.append([idx, idx])
    return ", ".join(_run(first, last) for first, last in runs)


def _run(first: int, last: int) -> str:
    if first == last:
        return str(first)
    return f"{first}, {last}" if last == first + 1 else f"{first}–{last}"


_CURLY: Final = re.compile(r"[“”„‘’«»](.*?)[“”„‘’«»]?")


def keyboard_hint(text: str) -> str | None:
    """Returns a hint for characters that word processors substitute; None if there are none."""
    if len(text) > _LONGEST:
        return None
    if curly := _CURLY.fullmatch(text):
        return f'use straight quotes: `"{curly[1]}"`'
    if text[:1] in {"−", "–", "—"} and text[1:2].isdecimal():
        return f"use a hyphen as minus: `-{text[1:]}`"
    return None
