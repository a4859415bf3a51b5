"""Groups settings of links and joints by name patterns."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenecc.spec.references import MAX_PATTERN_LENGTH

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.scene_file import Node


def group_by_pattern(settings: Mapping[str, Node], names: Sequence[str]) -> Node:
    """Groups settings as pattern → keys; names with the same value share a pattern.

    Args:
        settings: name → keys, for names with any.
        names: all names that a pattern could match.
    """
    holders: dict[tuple[str, ...], Node] = {}
    values: dict[str, list[tuple[Any, list[str]]]] = {}
    for name, keys in settings.items():
        for key, value in keys.items():
            groups = values.setdefault(key, [])
            group = next((members for other, members in groups if other == value), None)
            if group is None:
                groups.append((value, [name]))
            else:
                group.append(name)
    for key, groups in values.items():
        for value, members in groups:
            holders.setdefault(tuple(members), {})[key] = value
    ordered = sorted(holders.items(), key=lambda entry: -len(entry[0]))
    found: Node = {}
    for members, keys in ordered:
        for pattern in _short_patterns(list(members), names):
            found[pattern] = found.get(pattern, {}) | keys
    return found


def _short_patterns(members: Sequence[str], names: Sequence[str]) -> list[str]:
    """Returns patterns that match these names and no others, each short enough for a scene."""
    pattern = pattern_of(members, names)
    if len(pattern) <= MAX_PATTERN_LENGTH or len(members) == 1:
        return [pattern]
    half = len(members) // 2
    return [*_short_patterns(members[:half], names), *_short_patterns(members[half:], names)]


def pattern_of(members: Sequence[str], names: Sequence[str]) -> str:
    """Returns a regular expression that matches these names and no others."""
    if set(members) == set(names) and len(members) > 1:
        return ".*"
    start = _trim_to_words(_common_start(list(members)), members)
    rest = [name[len(start) :][::-1] for name in members]
    end = _trim_to_words(_common_start(rest), rest)[::-1]
    for middle in (".*", ".", "[0-9]+"):
        pattern = f"{re.escape(start)}{middle}{re.escape(end)}".replace(r"\-", "-")
        found = {name for name in names if re.fullmatch(pattern, name)}
        if len(members) > 1 and (start or end) and found == set(members):
            return pattern
    inner = "|".join(re.escape(name[len(start) : len(name) - len(end)]).replace(r"\-", "-") for name in members)
    if len(members) > 1 and len(start) + len(end) > _WORTH_FACTORING:
        return f"{re.escape(start)}({inner}){re.escape(end)}".replace(r"\-", "-")
    return "|".join(re.escape(name).replace(r"\-", "-") for name in members)


def _common_start(texts: list[str]) -> str:
    first, last = min(texts), max(texts)
    return first[: next((i for i, letter in enumerate(first) if last[i : i + 1] != letter), len(first))]


def _trim_to_words(start: str, names: Sequence[str]) -> str:
    """Shortens a common prefix to whole words."""
    while start and start[-1].isalpha() and any(name[len(start) : len(start) + 1].isalpha() for name in names):
        start = start[:-1]
    return start


_WORTH_FACTORING = 4
"""Minimum length of common parts that are worth factoring out."""
