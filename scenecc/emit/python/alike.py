"""Statements about many links or joints: what is the same of several is written once, in a loop."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from scenecc.emit.python.layout import Source, list_of, string

Item = TypeVar("Item")
Unit = Callable[[Source], None]
"""Writes statements about one thing; what it writes tells whether others have the same."""


@dataclass(frozen=True, slots=True)
class Among(Generic[Item]):
    """How links or joints are found in a script.

    Attributes:
        variable: what statements call one of them: `body`.
        all: an expression for all of them.
        named: what finds one by its name: `articulation.find_link_by_name`.
        name: of a thing.
        count: of all of them.
        suffix: what leads from what is found to what is meant.
    """

    variable: str
    all: str
    named: str
    name: Callable[[Item], str]
    count: int
    suffix: str = ""


def write_alike(source: Source, things: Sequence[tuple[Item, Sequence[Unit]]], among: Among[Item]) -> None:
    """Writes the units of every thing. `things`: those of which something is said, with what."""
    shared: dict[str, tuple[list[Item], Unit]] = {}
    for thing, units in things:
        for unit in units:
            inner = Source(depth=source.depth + 1)
            unit(inner)
            shared.setdefault(inner.text, ([], unit))[0].append(thing)
    blocks: dict[tuple[str, ...], list[Unit]] = {}
    for sharing, unit in shared.values():
        blocks.setdefault(tuple(map(among.name, sharing)), []).append(unit)
    for names, units in blocks.items():
        _write_block(source, names, units, among)


def _write_block(source: Source, names: tuple[str, ...], units: list[Unit], among: Among[Item]) -> None:
    variable = among.variable
    if len(names) == 1:
        source.line(f"{variable} = {among.named}({string(names[0])}){among.suffix}")
        for unit in units:
            unit(source)
        return
    if len(names) == among.count:
        with source.block(f"for {variable} in {among.all}:"):
            for unit in units:
                unit(source)
        return
    source.statement(list_of([string(name) for name in names]), assign=f"{variable}_names")
    with source.block(f"for {variable}_name in {variable}_names:"):
        source.line(f"{variable} = {among.named}({variable}_name){among.suffix}")
        for unit in units:
            unit(source)
