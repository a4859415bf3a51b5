"""Values of a plan as expressions, and the loops over scenes, links and joints that read them.

A value that is the same in all scenes is written in place. One that differs becomes a list with an item per scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.emit.python.source import Group, SourceNode, SourceWriter, call, list_of, string

if TYPE_CHECKING:
    from collections.abc import Generator, Hashable

    from numpy.typing import NDArray

    from scenecc.emit.python.source import Identifiers
    from scenecc.plan import ArticulationStructure, BodyStructure, Entity, Value


IDENTITY_ROW = np.array([0, 0, 0, 1, 0, 0, 0], dtype=np.float64)


def number_literal(item: float) -> str:
    """The shortest literal of the same float64 (a whole number of a few digits without its point), integer or flag.

    Infinity, which limits may be, has none.
    """
    if isinstance(item, float) and math.isinf(item):
        return f'float("{item}")'
    if isinstance(item, float) and item.is_integer() and abs(item) < 1e6 and str(item) != "-0.0":
        return str(int(item))
    return repr(item).replace("e+", "e")


def numbers_literal(row: NDArray[Any]) -> SourceNode:
    """A number, or a list of them to any depth."""
    return _nested_literal(row.tolist())


def pose_call(row: NDArray[np.float64]) -> SourceNode:
    """A `sapien.Pose`; SAPIEN's own rotation is left out."""
    rotation = () if row[3:].tobytes() == IDENTITY_ROW[3:].tobytes() else (numbers_literal(row[3:]),)
    return call("sapien.Pose", numbers_literal(row[:3]), *rotation)


def frame_expression(value: Value | None, name: str, columns: SceneValues) -> SourceNode:
    """A pose of a joint or constraint; SAPIEN's identity where the plan says none."""
    return call("sapien.Pose") if value is None else columns.value(value, name, pose_call)


def present_fields(holder: object, names: tuple[str, ...]) -> list[str]:
    """The names of the fields that the plan gives."""
    return [name for name in names if getattr(holder, name) is not None]


def write_properties(
    source: SourceWriter, holder: object, names: tuple[str, ...], columns: SceneValues, variable: str
) -> None:
    """Sets those of some properties that a part of the plan gives. `variable`: what of SAPIEN has them."""
    for name in present_fields(holder, names):
        write_property(source, holder, name, columns, variable)


def write_property(source: SourceWriter, holder: object, name: str, columns: SceneValues, variable: str) -> None:
    """One of them, which is given."""
    # Of an armature one number a degree of freedom.
    literal = _list_literal if name == "armature" else numbers_literal
    node = columns.value(getattr(holder, name), name, literal)
    if name == "locked_motion_axes":
        source.statement(call(f"{variable}.set_{name}", node))
    else:
        source.statement(node, assign=f"{variable}.{name}")


def _list_literal(row: NDArray[Any]) -> SourceNode:
    return list_of([numbers_literal(row)])


def _nested_literal(item: float | list[Any]) -> SourceNode:
    if not isinstance(item, list):
        return number_literal(item)
    return list_of([_nested_literal(one) for one in item])


def structure_variants(entity: Entity) -> list[tuple[int, BodyStructure | ArticulationStructure, NDArray[np.intp]]]:
    """The structures that some scene has: index, structure, and the entity's rows that have it."""
    pick = np.broadcast_to(0 if entity.pick is None else entity.pick.data, len(entity.scene_idxs))
    found = ((index, structure, np.flatnonzero(pick == index)) for index, structure in enumerate(entity.structures))
    return [(index, structure, rows) for index, structure, rows in found if len(rows)]


@dataclass(slots=True)
class SceneValues:
    """Expressions for one entity in the scenes of one block.

    Attributes:
        ident: what names of lists start with.
        rows: the entity's rows (not scene indices) that the block builds.
        names: where names of lists come from.
        copies: how many entities in one these rows are of, one after the other.
    """

    ident: str
    rows: NDArray[np.intp]
    names: Identifiers
    copies: int = 1
    _lists: dict[Group, str] = field(default_factory=dict[Group, str])
    _seen: set[str] = field(default_factory=set[str])
    _indices: set[str] = field(default_factory=set[str])
    _rendered: bool = False

    def value(self, value: Value, name: str, write: Callable[[Any], SourceNode] = numbers_literal) -> SourceNode:
        """A quantity of the plan; `write` makes an expression of one row."""
        return self.of_block(value.data[self.rows] if value.varies else value.data, name, write)

    def of_block(
        self, data: NDArray[Any], name: str, write: Callable[[Any], SourceNode] = numbers_literal
    ) -> SourceNode:
        """As `value`, of one row for each of the block, or one in all."""
        return self._chosen([row.tobytes() for row in data], name, lambda row: write(data[row]))

    def words(self, items: Sequence[str], name: str) -> SourceNode:
        """Strings, one a row of the block."""
        return self._chosen(items, name, lambda row: string(items[row]))

    def _chosen(self, keys: Sequence[Hashable], name: str, write: Callable[[int], SourceNode]) -> SourceNode:
        """What rows have in place where all agree, or else from a list by scene, by copy, or by both."""
        if len(set(keys)) == 1:
            return write(0)
        scenes = len(keys) // self.copies
        starts = range(0, len(keys), scenes)
        by_copy = [keys[start : start + scenes] for start in starts]
        if all(len(set(copy)) == 1 for copy in by_copy):
            return self._list(name, [write(start) for start in starts], "[k]")
        if all(copy == by_copy[0] for copy in by_copy):
            return self._list(name, [write(row) for row in range(scenes)], "[i]")
        rows = [list_of([write(start + row) for row in range(scenes)]) for start in starts]
        return self._list(name, rows, "[k][i]")

    def of_rows(self, value: Value) -> NDArray[Any]:
        """The plan's data, one row for each of the block."""
        return value.data[self.rows] if value.varies else np.repeat(value.data, len(self.rows), axis=0)

    @contextmanager
    def rendered(self) -> Generator[None]:
        """Lists that are made inside are needed only where there is a renderer."""
        self._rendered = True
        yield
        self._rendered = False

    def reads(self, index: str) -> bool:
        """Whether any quantity is by scene, `i`, or by copy, `k`."""
        return any(index in at for at in self._indices)

    def write(self, source: SourceWriter) -> None:
        """Assigns the lists, ahead of the loop over scenes."""
        for items, name in self._lists.items():
            if name not in self._seen:
                source.statement(items, assign=name)
        if self._seen:
            with source.block("if render:"):
                for items, name in self._lists.items():
                    if name in self._seen:
                        source.statement(items, assign=name)

    def _list(self, name: str, items: Sequence[SourceNode], at: str) -> str:
        self._indices.add(at)
        items_node = list_of(items)
        # What collides and what is seen mostly have the same sizes: one list serves both.
        variable = self._lists.get(items_node)
        if variable is None:
            variable = self._lists[items_node] = self.names.take(f"{self.ident}_{name}")
            if self._rendered:
                self._seen.add(variable)
        elif not self._rendered:
            self._seen.discard(variable)
        return variable + at


@contextmanager
def scene_block(
    source: SourceWriter, title: str, name: str, scene_idxs: tuple[int, ...], num_scenes: int, names: Identifiers
) -> Generator[tuple[SourceWriter, SceneValues]]:
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
    columns = SceneValues(name, np.arange(len(scene_idxs)), names)
    inner = SourceWriter(depth=source.depth + (len(scene_idxs) > 1))
    yield inner, columns
    if inner.is_empty:
        return
    source.gap()
    source.comment(title)
    append_in_scenes(source, inner, columns, scene_idxs, num_scenes)


def append_in_scenes(
    source: SourceWriter, inner: SourceWriter, columns: SceneValues, scene_idxs: tuple[int, ...], num_scenes: int
) -> None:
    """Appends statements that are run in each of some scenes as `scene`, after the lists that they read."""
    scenes = scene_selection(source, columns, scene_idxs, num_scenes)
    columns.write(source)
    if len(scene_idxs) > 1:
        with source.block(scene_loop_header(scenes, columns)):
            source.append(inner)
        return
    if num_scenes > 1:
        source.line(f"scene = {scenes}")
    source.append(inner)


def scene_loop_header(scenes: str, columns: SceneValues) -> str:
    """The head of a loop, with the row `i` where something reads it."""
    return f"for i, scene in enumerate({scenes}):" if columns.reads("i") else f"for scene in {scenes}:"


def scene_selection(source: SourceWriter, columns: SceneValues, scene_idxs: tuple[int, ...], num_scenes: int) -> str:
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


StatementWriter = Callable[[SourceWriter], None]
"""Writes statements about one thing; what it writes tells whether others have the same."""


@dataclass(frozen=True, slots=True)
class NameLookup:
    """How links or joints are found in a script.

    Attributes:
        variable: what statements call one of them: `body`.
        all: an expression for all of them.
        named: what finds one by its name: `articulation.find_link_by_name`.
        count: of all of them.
        suffix: what leads from what is found to what is meant.
    """

    variable: str
    all: str
    named: str
    count: int
    suffix: str = ""


def write_shared_statements(
    source: SourceWriter, things: Sequence[tuple[str, Sequence[StatementWriter]]], among: NameLookup
) -> None:
    """Writes the units of every thing. `things`: names of those of which something is said, with what."""
    shared: dict[str, tuple[list[str], StatementWriter]] = {}
    for name, units in things:
        for unit in units:
            inner = SourceWriter(depth=source.depth + 1)
            unit(inner)
            shared.setdefault(inner.text, ([], unit))[0].append(name)
    blocks: dict[tuple[str, ...], list[StatementWriter]] = {}
    for sharing, unit in shared.values():
        blocks.setdefault(tuple(sharing), []).append(unit)
    for names, units in blocks.items():
        _write_shared_block(source, names, units, among)


def _write_shared_block(
    source: SourceWriter, names: tuple[str, ...], units: list[StatementWriter], among: NameLookup
) -> None:
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
