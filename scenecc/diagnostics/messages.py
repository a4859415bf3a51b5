"""Values and names as messages show them, and the known word that was probably meant."""

from __future__ import annotations

import difflib
import re
from itertools import islice
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.diagnostics.diagnostic import Sink

_LISTED, _NEAR = 12, 3
"""How many known words a hint lists at most, and how many of more."""

_LONGEST = 60
"""How long a word may be to be compared with the known ones [characters]."""

_GUESSES, _NAMES = 20, 1000
"""After how many reports no name is guessed any more, and among how many names."""


def suggest(word: str, known: Iterable[str]) -> str | None:
    """A hint with the nearest known word, or all of them; None where there is none."""
    known = tuple(known)
    near = nearest(word, known)
    return f"did you mean `{near}`?" if near else listed(known, word)


def listed(known: tuple[str, ...], word: str = "") -> str | None:
    """A hint with the known words, or, of many, those that are most like `word`; None where there is none."""
    if not known:
        return None
    if len(known) <= _LISTED:
        return "known here: " + ", ".join(known)
    near = difflib.get_close_matches(word[:_LONGEST], known, n=_NEAR, cutoff=0)
    return f"the nearest here: {', '.join(near)} (of {len(known)})"


def nearest(word: str, known: Iterable[str], cutoff: float = 0.6) -> str | None:
    """The known word that is most like another; None where none is. `cutoff`: how similar, from 0 to 1."""
    # What is not longer than a key could be one; a stranger's megabyte is not compared.
    near = difflib.get_close_matches(word, known, n=1, cutoff=cutoff) if len(word) <= _LONGEST else []
    return near[0] if near else None


def is_slip_of(word: str, known: Iterable[str]) -> bool:
    """Whether exactly one known word is like another, and has at most two letters more or less."""
    near = difflib.get_close_matches(word, known, n=2, cutoff=0.6) if len(word) <= _LONGEST else []
    return len(near) == 1 and abs(len(near[0].replace("_", "")) - len(word.replace("_", ""))) <= _LETTERS


_LETTERS: Final = 2
"""`size` and `half_size` are two things."""


def suggest_name(word: str, names: Iterable[str], sink: Sink, further: Iterable[str] = ()) -> str | None:
    """`suggest` among a document's own names, of which there may be many: comparing letters takes its time.

    `further`: names that may be guessed and are not listed.
    """
    if sink.reported >= _GUESSES:
        return None
    known = tuple(islice(names, _NAMES))
    near = nearest(word, (*known, *islice(further, _NAMES - len(known))))
    return f"did you mean `{near}`?" if near else listed(known, word)


def show(found: Any, width: int = 60) -> str:
    """A value as a message shows it, cut where it is long."""
    text = str(found).lower() if isinstance(found, bool) else repr(found)
    return cut(text, width)


def cut(text: str, width: int = 60) -> str:
    """A text of at most so many characters: a file may come from a stranger."""
    return text if len(text) <= width else text[: width - 1] + "…"


def index_ranges(idxs: Sequence[int]) -> str:
    """Ascending scene indices in short: `0, 2`, `0–4095`, `0–3, 8`."""
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
    """A hint for characters that word processors put in place of those of a keyboard; None where there are none."""
    if len(text) > _LONGEST:
        return None
    if curly := _CURLY.fullmatch(text):
        return f'use the straight quotes of a keyboard: "{curly[1]}"'
    if text[:1] in {"−", "–", "—"} and text[1:2].isdecimal():
        return f"use the minus of a keyboard: -{text[1:]}"
    return None
