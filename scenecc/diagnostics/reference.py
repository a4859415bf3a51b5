"""Descriptions of codes, for `scenecc explain`, help texts and documentation pages."""

from __future__ import annotations

import difflib
import re
import textwrap
from operator import eq

from scenecc.diagnostics.codes import BANDS, CODES, Code
from scenecc.diagnostics.formats.style import visible

_WIDTH = 100

_NEAR = 0.76
"""Least similarity of a code that may be meant: one character of five is another."""


def explain_code(code: str) -> str | None:
    """Returns cause, example and cure of a code, as Markdown; None for an unknown code.

    `sc101` and `101` mean `SC101`.
    """
    row = CODES.get(normalize_code(code))
    if row is None:
        return None
    return f"{row.code}: {row.title}\n\nSeverity: {row.severity}. Stage: {BANDS[row.code[2]]}.\n\n{markdown(row)}"


def normalize_code(code: str) -> str:
    """Returns the code as in the table: `sc101` and `101` become `SC101`."""
    name = code.strip().upper()
    return f"SC{name}" if name.isdecimal() else name


def nearest_codes(code: str, *, count: int = 3) -> list[str]:
    """Returns at most `count` known codes that look like `code`: those with the same beginning first."""
    name = normalize_code(code)
    near = difflib.get_close_matches(name, sorted(CODES), n=len(CODES), cutoff=_NEAR)
    return sorted(near, key=lambda known: [*map(eq, name, known), False].index(False), reverse=True)[:count]


def markdown(row: Code) -> str:
    """Returns cause, example and cure of a row as Markdown, with a line break at the end."""
    example = _example(row.example)
    language = {"$": "console", "{": "json"}.get(example[:1], "yaml")
    return f"{_prose(row.cause)}\n\nExample:\n\n```{language}\n{example}\n```\n\n{_prose('Cure: ' + row.cure)}\n"


def _example(example: str) -> str:
    """Returns the example with control characters spelled out."""
    return re.sub(r"[^\n\t]+", lambda run: visible(run[0]), example.strip("\n"))


def _prose(text: str) -> str:
    """Returns the text with its long lines wrapped, for a terminal and for the page's source."""
    return "\n".join(
        textwrap.fill(line, _WIDTH, break_long_words=False, break_on_hyphens=False) if len(line) > _WIDTH else line
        for line in text.strip().splitlines()
    )
