"""Numbers chosen for draws in place of random ones, and what lowering records about the draws of a file."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from scenecc.diagnostics.frozen import frozen

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.variation.nodes import Node

ChosenUnits = tuple[tuple[int, int, tuple[float, ...]], ...]
"""(lane, word, u of each scene), which replace those of the generator. A negative u is drawn."""

SceneUnits = list[tuple[int, int, float]]
"""(lane, word, u) of one scene."""


@frozen
class DrawSource:
    """Something that a file draws, or selects by the scene's index.

    Attributes:
        section, name, path: of its key.
        word: number of the component, if it is one of a vector.
        kind: a choice of few values, a range, or something else, such as a rotation.
        values: its alternatives as plain data; empty for other kinds.
        units: for each alternative the u that gives it; empty if the scene's index selects it.
        distribution: of a range.
        words: number of words, from `word` on.
        scenes: the scenes that have it.
        origin: where it is written.
        is_vector: whether it is a component of a vector.
        items: numbers of the alternatives in a `choice` or `cycle`.
    """

    section: str
    name: str
    path: str
    word: int
    kind: Literal["choice", "range", "other"]
    values: tuple[Any, ...]
    units: tuple[float, ...]
    distribution: str
    words: int
    scenes: tuple[int, ...]
    origin: Origin
    is_vector: bool = False
    items: tuple[int, ...] = ()

    @property
    def label(self) -> str:
        """The name in output: that of a shared draw, or OBJECT.FIELD as in `scenecc draws`."""
        above = "" if self.section in {"entities", "draws"} else f"{self.section}/"
        at = f"[{self.word}]" if self.is_vector else ""
        name = self.name if self.section != "environment" else ""
        return f"{above}{name}".rstrip("/") + (f".{self.path}" if self.path else "") + at

    @property
    def key(self) -> str:
        """The key as text, for a file of starts."""
        return key_text(self.section, self.name, self.path)


def key_text(section: str, name: str, path: str) -> str:
    """Returns a key as text: the end of the array that `docs/reference/draws.md` hashes."""
    return json.dumps([section, name, path], ensure_ascii=False)


class DrawFailure(NamedTuple):
    """A value that does not exist or is out of range in some scenes."""

    scenes: tuple[int, ...]
    node: Node | None = None


@dataclass(slots=True)
class DrawRecord:
    """What lowering is given and records about draws.

    Attributes:
        chosen: key as text → numbers that replace random ones.
        sources: what the file draws, by key and component.
        failures: the scenes in which a value does not exist or is out of range, and its node.
        draws: the shared draws.
        num_scenes: number of scenes.
        picks: entity → the shared draw that its `pick` reads, if it is nothing else.
    """

    chosen: Mapping[str, ChosenUnits] = field(default_factory=dict[str, ChosenUnits])
    sources: dict[tuple[str, int], DrawSource] = field(default_factory=dict[tuple[str, int], DrawSource])
    failures: list[DrawFailure] = field(default_factory=list["DrawFailure"])
    draws: Mapping[str, Node] = field(default_factory=dict[str, "Node"])
    num_scenes: int = 0
    picks: dict[str, str] = field(default_factory=dict[str, str])


def chosen_units(rows: Iterable[tuple[int, Mapping[str, SceneUnits]]], num_scenes: int) -> dict[str, ChosenUnits]:
    """Returns key → chosen numbers of all scenes, from (scene, key → numbers) of each scene."""
    columns: dict[str, dict[tuple[int, int], list[float]]] = {}
    for scene, keys in rows:
        for key, units in keys.items():
            for lane, word, u in units:
                column = columns.setdefault(key, {}).setdefault((lane, word), [-1.0] * num_scenes)
                column[scene] = u
    return {
        key: tuple((lane, word, tuple(column)) for (lane, word), column in sorted(words.items()))
        for key, words in columns.items()
    }
