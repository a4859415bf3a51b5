"""Records what the fields of a file draw: choices with their alternatives, and ranges."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import accumulate
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.diagnostic import Origin
from scenecc.plan.scene import placing_draw_name
from scenecc.variation.chosen import DrawRecord, DrawSource
from scenecc.variation.nodes import NODES, Chosen, Cycled, Drawn, Key, Shuffled

if TYPE_CHECKING:
    from scenecc.lower.forms import FieldPlace
    from scenecc.lower.sampling import SamplingContext
    from scenecc.plan.placement import Placement

MOST_ALTERNATIVES: Final = 64
"""Most integers that are alternatives. More are a range."""


def add_sources(
    record: DrawRecord,
    node: Any,
    key: tuple[str, str, str],
    scenes: tuple[int, ...],
    place: FieldPlace,
    written: tuple[Any, ...] = (),
) -> None:
    """Records what a node draws itself, without the forms inside it.

    Args:
        record: receives it.
        node: a `Chosen`, `Cycled`, `Drawn`, `Shuffled` or `RandomRotated`.
        key: section, name and path.
        scenes: the scenes of the object.
        place: of the form.
        written: items of a choice, as written.
    """
    common: dict[str, Any] = {"scenes": scenes, "origin": place.origin}
    if isinstance(node, Chosen):
        possible = node.possible
        if len(possible) > 1:
            values, units = tuple(_shown(node.items[j], written[j], j) for j in possible), _middles(node, possible)
            source = DrawSource(*key, node.word, "choice", values, units, "choice", 1, **common)
            _add(record, replace(source, is_vector=node.word > 0, items=tuple(possible)))
    elif isinstance(node, Cycled):
        values = tuple(_shown(item, written[j], j) for j, item in enumerate(node.items))
        if len(values) > 1:
            items = tuple(range(len(values)))
            _add(record, DrawSource(*key, place.word, "choice", values, (), "cycle", 1, **common, items=items))
    elif isinstance(node, Drawn):
        for component in range(node.shape[0] if node.shape else 1):
            source = _component(node, component, key, common)
            if source is not None:
                _add(record, source)
    else:
        word, words = (node.word, len(node.items)) if isinstance(node, Shuffled) else (0, 3)
        _add(record, DrawSource(*key, word, "other", (), (), "", words, **common))


def add_placing(sampling: SamplingContext, placement: Placement) -> None:
    """Records the point and the height that a placement draws. A shared draw holds the key of chosen ones."""
    record, origin = sampling.record, placement.origin or Origin(None)
    assert record is not None
    words = {"place.region": 2 if placement.at is None and placement.next_to is None else 0}
    words["place.height"] = 1 if placement.height is not None else 0
    for path, count in words.items():
        if count:
            name = placement.name
            source = DrawSource(
                "entities", name, path, 0, "other", (), (), "", count, placement.scene_idxs, origin.child(path[6:])
            )
            _add(record, source)
            if chosen := record.chosen.get(source.key):
                node = Drawn("uniform", (0.0, 1.0), (count,), Key("entities", name, path, chosen))
                sampling.add(placing_draw_name(name, path), node, frozenset())
                sampling.random.add(placing_draw_name(name, path))


def _add(record: DrawRecord, source: DrawSource) -> None:
    record.sources.setdefault((source.key, source.word), source)


def _component(node: Drawn, component: int, key: tuple[str, str, str], common: dict[str, Any]) -> DrawSource | None:
    """Returns what a component draws; None if its ends are equal."""
    word = node.word + component
    is_vector = bool(node.shape) or node.word > 0
    ends: list[Any] = [item[component] if isinstance(item, tuple) else item for item in node.operands[:2]]
    if node.kind in {"uniform", "log_uniform", "integers"} and type(ends[0]) in {int, float} and ends[0] == ends[1]:
        return None
    if node.distribution.whole and all(type(end) in {int, float} and math.isfinite(end) for end in ends):
        low, high = map(int, ends)
        count = high - low + 1
        if 1 < count <= MOST_ALTERNATIVES:
            units = tuple((j + 0.5) / count for j in range(count))
            return DrawSource(
                *key, word, "choice", tuple(range(low, high + 1)), units, "integers", 1, **common, is_vector=is_vector
            )
    return DrawSource(*key, word, "range", (), (), node.kind, 1, **common, is_vector=is_vector)


def _middles(node: Chosen, possible: list[int]) -> tuple[float, ...]:
    """Returns for each item that can be drawn the middle of the numbers that draw it."""
    weights = [1.0] * len(node.items) if node.weights is None else [float(weight) for weight in node.weights]
    reached = [0.0, *accumulate(weights)]
    return tuple((reached[j] + reached[j + 1]) / 2 / reached[-1] for j in possible)


def _shown(item: Any, written: Any, number: int) -> Any:
    """Returns an alternative as plain data: a text as written, its value, or its number if it is a form itself."""
    if isinstance(written, str):
        return written
    return f"item {number}" if _has_node(item) else item


def _has_node(item: Any) -> bool:
    return isinstance(item, NODES) or (isinstance(item, tuple) and any(map(_has_node, item)))  # pyright: ignore[reportUnknownArgumentType]
