"""Repetition: the product of named lists."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Any

from scenecc.diagnostics.messages import show

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
        told: list[str] = []
        for name, axis in zip(reversed(self.names), reversed(self.axes), strict=True):
            number, index = divmod(number, len(axis))
            value = axis[index]
            told.append(f"{name}={value if type(value) is int else show(value, _SHOWN)}")
        return ", ".join(reversed(told))
