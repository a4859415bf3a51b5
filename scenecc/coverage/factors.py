"""The factors of a file: what it draws from few alternatives, and under which conditions."""

from __future__ import annotations

import re
from dataclasses import replace
from math import gcd
from typing import TYPE_CHECKING, Final

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from scenecc.variation.chosen import DrawSource

Level = tuple[int, int]
"""A factor and one of its alternatives, by number."""

Needs = dict[int, frozenset[int]]
"""Factor → the alternatives that it may have."""


@frozen
class Factor:
    """Something with few alternatives.

    Attributes:
        source: where it is drawn.
        needs: the alternatives of other factors with which it is drawn at all: those of the enclosing forms.
        scenes: the scenes that have it; None: all.
    """

    source: DrawSource
    needs: tuple[tuple[int, frozenset[int]], ...] = ()
    scenes: frozenset[int] | None = None

    @property
    def count(self) -> int:
        """Number of alternatives."""
        return len(self.source.values)

    @property
    def is_cycle(self) -> bool:
        """Whether the scene's index selects its alternative."""
        return not self.source.units

    def is_in(self, scene: int) -> bool:
        """Returns whether a scene has it, if the factors that it needs allow it."""
        return self.scenes is None or scene in self.scenes

    def fixed(self, scene: int) -> int | None:
        """Returns the alternative that the scene's index selects; None: it can be chosen."""
        return scene % self.count if self.is_cycle else None


def named_sources(sources: Iterable[DrawSource]) -> list[DrawSource]:
    """Returns sources in which component 0 of a vector is named as such if other components are drawn too."""
    found = list(sources)
    several = {one.key for one in found if one.word > 0}
    return [replace(one, is_vector=one.is_vector or one.key in several) for one in found]


def factors_of(sources: Sequence[DrawSource], num_scenes: int, picks: Mapping[str, str]) -> list[Factor]:
    """Returns the factors among the sources, each with its conditions."""
    choices = [one for one in sources if one.kind == "choice"]
    return [
        Factor(
            one,
            tuple(conditions(one, choices, picks)),
            None if len(one.scenes) == num_scenes else frozenset(one.scenes),
        )
        for one in choices
    ]


_INSIDE: Final = re.compile(r"(?:^|\.)(choice|cycle|variants)\[(\d+)\]")
"""A step into a form of which a scene has one item."""


def conditions(
    source: DrawSource, choices: Sequence[DrawSource], picks: Mapping[str, str]
) -> Iterator[tuple[int, frozenset[int]]]:
    """Yields the factors that a source needs, and their alternatives in which it is drawn.

    `picks`: entity → the shared draw that selects its variant.
    """
    by_place = {(one.section, one.name, one.path, one.word): number for number, one in enumerate(choices)}
    for step in _INSIDE.finditer(source.path):
        above = source.path[: step.start()] if step[1] != "variants" else "pick"
        places = [(source.section, source.name, above, word) for word in (source.word, 0)]
        if step[1] == "variants" and source.name in picks:
            places.append(("draws", picks[source.name], "", 0))
        number = next((by_place[place] for place in places if place in by_place), None)
        if number is None or choices[number] is source:
            continue
        wanted = int(step[2])
        values: tuple[object, ...] = choices[number].items if step[1] != "variants" else choices[number].values
        allowed = frozenset(j for j, value in enumerate(values) if value == wanted)
        if allowed:
            yield number, allowed


def closure(level: Level, factors: Sequence[Factor]) -> Needs | None:
    """Returns what an alternative needs, itself included; None: it can never occur."""
    found: Needs = {}
    todo: list[tuple[int, frozenset[int]]] = [(level[0], frozenset((level[1],)))]
    while todo:
        factor, allowed = todo.pop()
        both = found.get(factor, allowed) & allowed
        if not both:
            return None
        if factor not in found:
            todo += factors[factor].needs
        found[factor] = both
    return found


def joined(first: Needs, second: Needs) -> Needs | None:
    """Returns what two alternatives need together; None: they exclude each other."""
    found = dict(first)
    for factor, allowed in second.items():
        both = found.get(factor, allowed) & allowed
        if not both:
            return None
        found[factor] = both
    return found


def cycles_meet(needs: Needs, factors: Sequence[Factor]) -> bool:
    """Returns whether some scene index gives all the alternatives of `cycle` in these needs."""
    fixed = [(factors[f].count, allowed) for f, allowed in needs.items() if factors[f].is_cycle]
    for number, (first, some) in enumerate(fixed):
        for second, others in fixed[:number]:
            common = gcd(first, second)
            if {one % common for one in some}.isdisjoint(one % common for one in others):
                return False
    return True
