"""Values and names as messages show them, and the known word that was probably meant."""

from __future__ import annotations

import difflib
from itertools import islice
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from scenecc.diagnostics.diagnostic import Sink

_LISTED = 30
"""How many known words a hint lists."""

_LONGEST = 60
"""How long a word may be to be compared with the known ones [characters]."""

_GUESSES, _NAMES = 20, 1000
"""After how many reports no name is guessed any more, and among how many names."""


def suggest(word: str, known: Iterable[str]) -> str | None:
    """A hint with the nearest known word, or all of them; None where there is none."""
    known = tuple(known)
    near = nearest(word, known)
    return f"did you mean `{near}`?" if near else listed(known)


def listed(known: tuple[str, ...]) -> str | None:
    """A hint with the known words; None where there is none."""
    if not known:
        return None
    more = f" and {len(known) - _LISTED} more" if len(known) > _LISTED else ""
    return "known here: " + ", ".join(known[:_LISTED]) + more


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The known word that is most like another; None where none is."""
    # What is not longer than a key could be one; a stranger's megabyte is not compared.
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.6) if len(word) <= _LONGEST else []
    return near[0] if near else None


def is_only_near(word: str, known: Iterable[str]) -> bool:
    """Whether exactly one known word is like another."""
    return len(word) <= _LONGEST and len(difflib.get_close_matches(word, known, n=2, cutoff=0.6)) == 1


def suggest_name(word: str, names: Iterable[str], sink: Sink, further: Iterable[str] = ()) -> str | None:
    """`suggest` among a document's own names, of which there may be many: comparing letters takes its time.

    `further`: names that may be guessed and are not listed.
    """
    if sink.reported >= _GUESSES:
        return None
    known = tuple(islice(names, _NAMES))
    near = nearest(word, (*known, *islice(further, _NAMES - len(known))))
    return f"did you mean `{near}`?" if near else listed(known)


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
