"""Applies hints to scene files, as a person who pastes what they say does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from scenecc.diagnostics import Diagnostic
from scenecc.diagnostics.fixing import is_mended
from scenecc.source.hint_edits import hint_edits, written_codes

_TRIES: Final = 12


def pasted(text: str, validate: Callable[[str], list[Diagnostic]]) -> str | None:
    """Returns a scene after the changes that the hints of its errors name, one after the other; None if errors stay."""
    for _ in range(_TRIES):
        every = validate(text)
        first = next((one for one in every if one.severity == "error"), None)
        if first is None:
            return text
        results = [edit.applied(text) for edit in hint_edits(text, first)]
        mended = (result for result in results if is_mended(validate(result), every, first))
        # The same line may have more faults.
        text = next(mended, None) or next((result for result in results if first not in validate(result)), "")
        if not text:
            return None
    return None


def changed_lines(text: str, result: str) -> str:
    """Returns the lines of a result that a text does not have, without indentation."""
    return "\n".join(line.strip() for line in result.splitlines() if line not in text.splitlines())


def snippet(hint: str) -> str | None:
    """Returns the first of what a hint says to write."""
    return next((code for code in written_codes(hint) if "…" not in code), None)
