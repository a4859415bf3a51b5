"""Repetition: the product of named lists."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from scenecc.diagnostics.words import show

_SHOWN = 24
"""How long the value of a variable may be in the name of a copy [characters]."""


class Loop:
    """The product of lists with the names of the variables that run through them, the last varying fastest."""

    __slots__ = ("axes", "count", "names")

    def __init__(self, axes: Mapping[str, Sequence[Any]]) -> None:
        self.names = tuple(axes)
        self.axes = tuple(axes.values())
        self.count = math.prod(map(len, self.axes))

    def __iter__(self) -> Iterator[tuple[Any, ...]]:
        # Of a product that is empty the other lists may be as long as they like.
        return product(*self.axes) if self.count else iter(())

    def text(self, number: int) -> str:
        """What tells a copy from the others: "i=1, j=-1"."""
        values: list[Any] = []
        for axis in reversed(self.axes):
            number, index = divmod(number, len(axis))
            values.append(axis[index])
        pairs = zip(self.names, reversed(values), strict=True)
        return ", ".join(f"{name}={show(value, _SHOWN)}" for name, value in pairs)
