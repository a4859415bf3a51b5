"""What a terminal may be sent: colours, and text from strangers made harmless."""

from __future__ import annotations

import os
import unicodedata
from collections.abc import Mapping
from typing import Protocol

_KEPT = "\u200c\u200d"
"""The joiners: invisible, but Persian words and emoji families fall apart without them."""

_HIDDEN = frozenset({"Cc", "Cf", "Cs", "Zl", "Zp"})
"""Unicode categories that steer a terminal, hide in a line, reorder or break it, or cannot be encoded."""


class HasIsatty(Protocol):
    """The part of a text stream that decides about colour."""

    def isatty(self) -> bool:
        """Whether people read it."""
        ...


def wants_color(stream: HasIsatty, environ: Mapping[str, str] | None = None) -> bool:
    """Whether to colour what is written to `stream`.

    `NO_COLOR`, then `FORCE_COLOR` decide if they are set and not empty; otherwise a terminal that
    is not `TERM=dumb` gets colours. `environ`: None is the process's own.
    """
    env = os.environ if environ is None else environ
    if env.get("NO_COLOR"):
        return False
    if env.get("FORCE_COLOR"):
        return True
    return env.get("TERM") != "dumb" and stream.isatty()


def visible(text: str) -> str:
    """The text with every control, bidirectional, invisible or unencodable character spelled out.

    A scene file may come from a stranger, and its lines are printed: an escape sequence must show,
    not act. C0 controls become their pictures (ESC is ␛), others `<U+202E>`.
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(map(_visible, text))


def _visible(char: str) -> str:
    if char in _KEPT or unicodedata.category(char) not in _HIDDEN:
        return char
    if char == "\x7f":
        return "\u2421"
    return chr(0x2400 + ord(char)) if char < "\x20" else f"<U+{ord(char):04X}>"


def encodable(text: str) -> str:
    """The text with lone surrogates, which no encoding can write, as U+FFFD."""
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
