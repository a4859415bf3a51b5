"""Objects of JSON in which every key stands once: of two equal ones, one reader takes the first, another the last."""

from __future__ import annotations

from typing import Any


class RepeatedKeyError(ValueError):
    """A key that stands twice in one object. Its words are the key."""


def json_object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An `object_pairs_hook`.

    Raises:
        RepeatedKeyError: a key stands twice.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        seen: set[str] = set()
        raise RepeatedKeyError(next(repr(key[:80]) for key, _ in pairs if key in seen or seen.add(key)))
    return found
