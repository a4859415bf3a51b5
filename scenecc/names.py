"""Valid and unique names."""

from __future__ import annotations

import re


def valid_name(wish: str) -> str:
    """Returns the nearest name that a scene file takes: invalid characters become `_`."""
    name = re.sub(r"[^A-Za-z0-9_.-]+", "_", wish)
    return name if re.match(r"[A-Za-z_]", name) and not name.startswith("x-") else f"_{name}"


class UniqueNames:
    """Makes unique names of one kind.

    Args:
        taken: names already in use.
        separator: between a used name and the appended number.
    """

    def __init__(self, *taken: str, separator: str = "_") -> None:
        self._taken = set(taken)
        self._separator = separator
        self._counts: dict[str, int] = {}

    def new(self, wish: str) -> str:
        """Returns the requested name, with a number appended if it is in use."""
        name, count = wish, self._counts.get(wish, 1)
        while name in self._taken:
            count += 1
            name = f"{wish}{self._separator}{count}"
        self._counts[wish] = count
        self._taken.add(name)
        return name
