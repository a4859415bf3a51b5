"""Loops over scenes: the statements of a block, run in each scene that an object is in."""

from __future__ import annotations

from contextlib import contextmanager
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from scenecc.emit.python.columns import Columns
from scenecc.emit.python.layout import Source, list_of

if TYPE_CHECKING:
    from collections.abc import Generator

    from scenecc.emit.python.names import Names


@contextmanager
def in_scenes(
    source: Source, title: str, name: str, scene_idxs: tuple[int, ...], num_scenes: int, names: Names
) -> Generator[tuple[Source, Columns]]:
    """Statements of one object: what is written to the source that this gives is run in each of its scenes as `scene`.

    Nothing is written where that is nothing.

    Args:
        source: of the body of `build_scenes`.
        title: a comment ahead of them.
        name: what lists of its values are named after; they are by row, as the columns write them.
        scene_idxs: the scenes that it is in.
        num_scenes: how many there are.
        names: of the script.
    """
    columns = Columns(name, np.arange(len(scene_idxs)), names)
    looped = len(scene_idxs) > 1
    inner = Source(depth=source.depth + looped)
    yield inner, columns
    if inner.is_empty:
        return
    source.gap()
    source.comment(title)
    scenes = selected(source, columns, scene_idxs, num_scenes)
    columns.write(source)
    if looped:
        with source.block(over_scenes(scenes, columns)):
            source.append(inner)
        return
    if num_scenes > 1:
        source.line(f"scene = {scenes}")
    source.append(inner)


def over_scenes(scenes: str, columns: Columns) -> str:
    """The head of a loop, with the row `i` where something reads it."""
    return f"for i, scene in enumerate({scenes}):" if columns.reads("i") else f"for scene in {scenes}:"


def selected(source: Source, columns: Columns, scene_idxs: tuple[int, ...], num_scenes: int) -> str:
    """An expression for the scenes of a block, or for its one scene."""
    if len(scene_idxs) == 1:
        return f"scenes[{scene_idxs[0]}]"
    if len(scene_idxs) == num_scenes:
        return "scenes"
    steps = {b - a for a, b in pairwise(scene_idxs)}
    if len(steps) == 1:
        step = steps.pop()
        first, last = scene_idxs[0], scene_idxs[-1]
        return f"scenes[{first}:{last + 1}]" if step == 1 else f"scenes[{first}:{last + 1}:{step}]"
    variable = columns.names.take(f"{columns.ident}_scenes")
    source.statement(list_of([str(index) for index in scene_idxs]), assign=variable)
    return f"[scenes[k] for k in {variable}]"
