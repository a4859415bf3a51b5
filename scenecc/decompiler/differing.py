"""Two live scenes as they were read: what differs, object by object."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from itertools import zip_longest

import numpy as np

from scenecc.decompiler.facts import Facts, Numbers, Plain


def differences(
    a: Facts, b: Facts, *, without: Collection[str] = (), tolerance: Callable[[Facts], float] = lambda _: 0.0
) -> list[str]:
    """One line a difference, with the path of the object, the property and both values; empty if all is equal.

    Numbers are compared by their bits, but for the sign of a zero. Objects are compared in their order; an object that
    one side has in addition is told once.

    Args:
        a: a scene, an entity or anything in it.
        b: what it should equal.
        without: properties that are not compared, by `PROPERTY` or `KIND.PROPERTY`; `name` is one.
        tolerance: how far apart two numbers of an object may be that are equal.
    """
    return list(_differing(_label(a), a, b, frozenset(without), tolerance))


def _differing(
    where: str, a: Facts, b: Facts, without: frozenset[str], tolerance: Callable[[Facts], float]
) -> Iterator[str]:
    if a.kind != b.kind:
        yield f"{where}: {a.kind} against {b.kind}"
        return
    if a.name != b.name and not _skipped(a.kind, "name", without):
        yield f"{where}.name: {a.name!r} against {b.name!r}"
    left, right = dict(a.values), dict(b.values)
    for name in dict.fromkeys((*left, *right)):
        if _skipped(a.kind, name, without):
            continue
        if name not in left or name not in right:
            yield f"{where}.{name}: only in the {'second' if name not in left else 'first'}"
        elif left[name] != right[name] and not _is_near(left[name], right[name], tolerance(a)):
            yield f"{where}.{name}: {_told(left[name], right[name])}"
    yield from _parts(where, a.parts, b.parts, without, tolerance)


def _parts(
    where: str,
    a: tuple[Facts, ...],
    b: tuple[Facts, ...],
    without: frozenset[str],
    tolerance: Callable[[Facts], float],
) -> Iterator[str]:
    by_kind: dict[str, tuple[list[Facts], list[Facts]]] = {}
    for side, parts in enumerate((a, b)):
        for part in parts:
            by_kind.setdefault(_sort(part), ([], []))[side].append(part)
    for left, right in by_kind.values():
        for number, (x, y) in enumerate(_paired(left, right)):
            if x is None or y is None:
                extra = x or y
                assert extra is not None
                yield f"{where}/{_label(extra, number)}: only in the {'first' if y is None else 'second'}"
            else:
                yield from _differing(f"{where}/{_label(x, number)}", x, y, without, tolerance)


def _is_near(a: Plain, b: Plain, tolerance: float) -> bool:
    if not tolerance or not isinstance(a, Numbers) or not isinstance(b, Numbers) or a.shape != b.shape:
        return False
    return "f" in a.dtype and bool((np.abs(a.array().astype(np.float64) - b.array()) <= tolerance).all())


def _sort(part: Facts) -> str:
    """Shapes of all types are one list, since their order counts; so are entities; components are one list, too."""
    return part.kind if part.kind in {"entity", "articulation", "joint", "material", "part"} else "ordered"


def _paired(left: list[Facts], right: list[Facts]) -> Iterator[tuple[Facts | None, Facts | None]]:
    """By their places; where one side has more, by the names that both have, so that the rest is told alone."""
    sides = [part.name for part in left], [part.name for part in right]
    shared = set(sides[0]) & set(sides[1])
    if len(left) == len(right) or not shared or any(len(set(side)) < len(side) for side in sides):
        yield from zip_longest(left, right)
        return
    yield from zip([x for x in left if x.name in shared], [y for y in right if y.name in shared], strict=True)
    yield from ((x, None) for x in left if x.name not in shared)
    yield from ((None, y) for y in right if y.name not in shared)


def _skipped(kind: str, name: str, without: frozenset[str]) -> bool:
    return name in without or f"{kind}.{name}" in without


def _label(facts: Facts, number: int = 0) -> str:
    return f"{facts.kind}({facts.name})" if facts.name else f"{facts.kind}[{number}]"


def _told(a: Plain, b: Plain) -> str:
    if isinstance(a, Numbers) and isinstance(b, Numbers) and a.shape == b.shape and a.array().size > 16:
        x, y = a.array(), b.array()
        unequal = (x != y) & ~(np.isnan(x) & np.isnan(y))
        if unequal.any():
            first = tuple(int(axis[0]) for axis in unequal.nonzero())
            return f"{int(unequal.sum())} of {x.size} numbers, first at {list(first)}: {x[first]} against {y[first]}"
    return f"{_shown(a)} against {_shown(b)}"


def _shown(value: Plain) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(_shown(item) for item in value) + "]"
    return str(value) if isinstance(value, Numbers) else repr(value)
