"""Names that no two things of a kind share."""

from __future__ import annotations


class Names:
    """Names of one kind."""

    def __init__(self, *taken: str) -> None:
        self._taken = set(taken)

    def new(self, wish: str) -> str:
        """The name that is wished for, or with a number where it is taken."""
        name, count = wish, 1
        while name in self._taken:
            count += 1
            name = f"{wish}_{count}"
        self._taken.add(name)
        return name
