"""The values of nodes in many scenes at once, as arrays with one row a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from scenecc.geometry import rotation_arrays
from scenecc.variation import generator, nodes
from scenecc.variation.distributions import WIDEST_INTEGERS
from scenecc.variation.nodes import NODES, Key, Node, evaluation_order, shaped_fields
from scenecc.variation.operations import (
    LISTS,
    SEQUENCES,
    DrawError,
    ExpressionError,
    as_lists,
    expression_cost,
    kind_name,
    result_cost,
    shape_mismatch,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from scenecc.variation.operations import OperationCounter

    Floats = NDArray[np.float64]


def value_array(data: Any) -> NDArray[Any]:
    """One value: float64, int64 or bool of its own shape, or an object of shape () for anything else."""
    whole = row_array([data])
    return whole[0] if whole.ndim > 1 else whole.reshape(())


def row_array(items: Sequence[Any]) -> NDArray[Any]:
    """Several values, one a row; objects where they are not all numbers, or all booleans, of one shape."""
    if not any(map(_has_text, items)) and len({type(item) is bool for item in items}) <= 1:
        try:
            whole = np.array(items)
        except ValueError:
            # Rows of several lengths.
            return object_array(items)
        # Integers of 64 bits without a sign would lose their highest.
        if whole.dtype.kind in "bif":
            return to_value_dtype(whole)
    return object_array(items)


def typed_row_array(items: Sequence[Any]) -> NDArray[Any]:
    """As `row_array`, but objects where integers stand beside floats.

    A text tells 1 from 1.0, and what a scene has must not depend on what others have.
    """
    return row_array(items) if len(_kinds(items)) <= 1 else object_array(items)


def _kinds(items: Sequence[Any]) -> set[type]:
    kinds = set(map(type, items))
    if kinds.isdisjoint(LISTS):
        return kinds
    return {kind for item in items for kind in (_kinds(item) if type(item) in LISTS else {type(item)})}


def object_array(items: Sequence[Any]) -> NDArray[Any]:
    """Several values of any kind, one a row; lists where they were tuples."""
    whole = np.empty(len(items), dtype=object)
    for index, item in enumerate(items):
        whole[index] = as_lists(item)
    return whole


def to_value_dtype(array: NDArray[Any]) -> NDArray[Any]:
    """An array in one of the kinds that values have: float64, int64, bool or object."""
    if array.dtype.kind == "f":
        return array.astype(np.float64, copy=False)
    if array.dtype.kind in "iu":
        return array.astype(np.int64, copy=False)
    return array if array.dtype.kind == "b" else array.astype(object, copy=False)


def distinct_rows(rows: NDArray[Any]) -> NDArray[np.intp]:
    """Where the different rows (B, …) stand first, in order: to the bit, so that 0.0 is not -0.0."""
    if rows.dtype == object or len(rows) < 2 or not rows[0].size:
        return np.arange(len(rows))
    flat = np.ascontiguousarray(rows).reshape(len(rows), -1)
    _, first = np.unique(flat.view(np.dtype((np.void, flat.dtype.itemsize * flat.shape[1]))), return_index=True)
    return np.sort(first)


def merge_rows(size: int, parts: Sequence[tuple[NDArray[np.intp], NDArray[Any]]]) -> NDArray[Any]:
    """One array of `size` rows from parts, each with the rows where it belongs.

    Integers stay integers beside floats: which parts there are is the batch's, and a text tells 1 from 1.0.
    """
    shapes = {part.shape[1:] for _, part in parts}
    kinds = {part.dtype.kind for _, part in parts}
    if len(shapes) == 1 and len(kinds) == 1:
        whole = np.empty((size, *shapes.pop()), dtype=parts[0][1].dtype)
        for rows, part in parts:
            whole[rows] = part
        return whole
    whole = np.empty(size, dtype=object)
    for rows, part in parts:
        for row, value in zip(rows.tolist(), part.tolist(), strict=True):
            whole[row] = value
    return whole


def to_field_rows(rows: NDArray[Any]) -> NDArray[Any]:
    """Rows (B, …) as a field takes them, to which integers and floats are numbers alike; others as they are."""
    return row_array(rows.tolist()) if rows.dtype == object else rows


def _has_text(item: Any) -> bool:
    """Whether it is a text or a list with one: numpy would make all as wide as the longest."""
    return type(item) is str or (type(item) in LISTS and str in set(map(type, item)))


class Batch:
    """Some of the parallel scenes, for which nodes are evaluated.

    What a node gives in a scene follows from the seed, the node and the scene's index, whichever other scenes are in
    the batch. The shared draws are evaluated when they are first read, and kept.

    Args:
        scenes: indices of the scenes (B,), at least one, in any order.
        seed: of every draw, or one for each of the scenes.
        num_scenes: what `num_scenes` gives in an expression.
        draws: the shared draws by name; one may read those before it.
        given: values (N, …) that take the place of draws, row i being scene i's.
        work: counts what is computed; None: nothing does.
    """

    def __init__(
        self,
        scenes: NDArray[np.int64],
        seed: int | tuple[int, ...],
        num_scenes: int,
        draws: Mapping[str, Node],
        given: Mapping[str, NDArray[Any]],
        work: OperationCounter | None = None,
    ) -> None:
        self.scenes = np.asarray(scenes, dtype=np.int64)
        self.seed = seed
        self.num_scenes = num_scenes
        self.draws = draws
        self.given = given
        self.work = work
        self._shared: dict[str, NDArray[Any]] = {}
        self._failed: dict[str, DrawError] = {}
        self._whole: tuple[Batch, NDArray[np.intp]] | None = None

    def evaluate(self, node: Node) -> NDArray[Any]:
        """The node's values (B, …): float64, int64 or bool, or objects where they are texts, lists or mixed.

        The array may be read-only.

        Raises:
            DrawError: the node, or what it reads, has no value in one of the scenes.
        """
        return EVALUATORS[type(node)](self, node)

    def item(self, item: Any) -> NDArray[Any]:
        """As `evaluate`, of a plain value too."""
        if isinstance(item, NODES):
            return self.evaluate(item)
        value = value_array(item)
        return np.broadcast_to(value, (len(self.scenes), *value.shape))

    def shared(self, name: str) -> NDArray[Any]:
        """The values of a shared draw (B, …).

        Raises:
            DrawError: it has none in one of the scenes.
        """
        if not self._is_made(name):
            for other in evaluation_order(name, self.draws, self._is_made):
                self._make(other)
        if name in self._failed:
            error = self._failed[name]
            raise DrawError(error.message, error.scene, error.node, error.expression)
        return self._shared[name]

    def kept(self, name: str) -> NDArray[Any] | None:
        """The values of a shared draw, if they are there without evaluating anything."""
        found = self._shared.get(name)
        if found is not None:
            return found
        if name in self.given:
            found = to_value_dtype(self.given[name][self.scenes])
        elif self._whole is not None:
            whole, rows = self._whole
            values = whole.kept(name)
            found = None if values is None else values[rows]
        if found is not None:
            self._shared[name] = found
        return found

    def _is_made(self, name: str) -> bool:
        return name in self._failed or self.kept(name) is not None

    def _make(self, name: str) -> None:
        try:
            self._shared[name] = self.evaluate(self.draws[name])
        except DrawError as error:
            # What reads it need not do so in that scene.
            self._failed[name] = error

    def only(self, rows: NDArray[np.intp]) -> Batch:
        """Some rows of the batch as one of their own."""
        chosen: list[int] = rows.tolist()
        seed = self.seed if isinstance(self.seed, int) else tuple(self.seed[row] for row in chosen)
        part = Batch(self.scenes[rows], seed, self.num_scenes, self.draws, self.given, self.work)
        part._whole = (self, rows)
        return part

    def selected(self, items: Sequence[Any], index: NDArray[np.int64]) -> NDArray[Any]:
        """Of several items the one with the index (B,) in each scene; the others are not evaluated there."""
        if not any(isinstance(item, NODES) for item in items):
            return row_array(items)[index]
        parts: list[tuple[NDArray[np.intp], NDArray[Any]]] = []
        for number in np.unique(index).tolist():
            rows = np.flatnonzero(index == number)
            parts.append((rows, self.only(rows).item(items[number])))
        return merge_rows(len(self.scenes), parts)


class CombinationBatch(Batch):
    """As `Batch`, but nothing is drawn.

    Args:
        scenes: the scene's index of each row (B,).
        num_scenes: what `num_scenes` gives in an expression.
        draws: the shared draws by name.
        given: values (N, …) that take the place of draws.
        assigned: for every draw, by its key and word, the number (B,) of what it gives: of an item, or from the
            lowest integer on.
        work: counts what is computed; None: nothing does.
    """

    def __init__(
        self,
        scenes: NDArray[np.int64],
        num_scenes: int,
        draws: Mapping[str, Node],
        given: Mapping[str, NDArray[Any]],
        assigned: Mapping[tuple[Key, int], NDArray[np.int64]],
        work: OperationCounter | None = None,
    ) -> None:
        super().__init__(scenes, 0, num_scenes, draws, given, work)
        self.assigned = assigned

    def evaluate(self, node: Node) -> NDArray[Any]:
        """As of a batch."""
        match node:
            case nodes.Chosen():
                return self.selected(node.items, self.assigned[node.key, node.word])
            case nodes.Drawn():
                return node.operands[0] + self.assigned[node.key, node.word]
            case _:
                return super().evaluate(node)

    def only(self, rows: NDArray[np.intp]) -> CombinationBatch:
        """As of a batch."""
        assigned = {draw: numbers[rows] for draw, numbers in self.assigned.items()}
        part = CombinationBatch(self.scenes[rows], self.num_scenes, self.draws, self.given, assigned, self.work)
        part._whole = (self, rows)
        return part

    def row(self, number: int) -> CombinationBatch:
        """One row as a batch of its own."""
        return self.only(np.array([number]))


def _rows(batch: Batch, node: nodes.Rows) -> NDArray[Any]:
    known = np.array(node.scene_idxs, dtype=np.int64)
    index = np.minimum(np.searchsorted(known, batch.scenes), max(len(known) - 1, 0))
    missing = np.flatnonzero(known[index] != batch.scenes) if known.size else np.arange(len(batch.scenes))
    if missing.size:
        raise DrawError("nothing is given for this scene", int(batch.scenes[missing[0]]), node)
    return batch.selected(node.items, index)


def _stacked(batch: Batch, node: nodes.Stacked) -> NDArray[Any]:
    parts = [batch.item(item) for item in node.items]
    if any(part.dtype == object for part in parts):
        parts = [part.astype(object) for part in parts]
    return np.stack(parts, axis=1)


NOT_WHOLE = "a bound is no integer"

TOO_MANY = f"the bounds hold more than {WIDEST_INTEGERS} integers"


def bound_mismatch(node: nodes.Drawn) -> str:
    """What is said of a bound of another kind or size than what is drawn."""
    return f"a bound is not a number or a list of {node.shape[0]} numbers" if node.shape else "a bound is not a number"


def _choice_index(batch: Batch, node: nodes.Chosen) -> NDArray[np.int64]:
    """The index of the item that is chosen (B,)."""
    u = _units(batch, node, node.word, 1)[:, 0]
    return generator.choice(u, len(node.items), node.weights)


def _drawn(batch: Batch, node: nodes.Drawn) -> NDArray[Any]:
    """Numbers (B, *shape)."""
    operands = draw_bounds(batch, node)

    def units(lane: int) -> Floats:
        return _units(batch, node, node.word, operands[0].shape[1], lane)

    values = node.distribution.sample(units, operands)
    return values if node.shape else values[:, 0]


def draw_bounds(batch: Batch, node: nodes.Drawn) -> list[Floats]:
    """The operands of a draw, each (B, n).

    Raises:
        DrawError: they are none in one of the scenes.
    """
    count = node.shape[0] if node.shape else 1
    found = [_bound(batch, node, item, count) for item in node.operands]
    for condition in node.distribution.holding(len(found)):
        greater, less = (
            np.float64(condition.limit) if number is None else found[number]
            for number in (condition.greater, condition.less)
        )
        wrong = np.asarray(less >= greater if condition.strict else less > greater)
        _refuse(batch, node, wrong, condition.message)
    if node.distribution.whole:
        low, high = found
        _refuse(batch, node, (low != np.floor(low)) | (high != np.floor(high)), NOT_WHOLE)
        wide = (np.abs(low) > WIDEST_INTEGERS) | (np.abs(high) > WIDEST_INTEGERS)
        _refuse(batch, node, wide, f"a bound is beyond {WIDEST_INTEGERS}")
        _refuse(batch, node, high - low >= WIDEST_INTEGERS, TOO_MANY)
    return found


def _units(
    batch: Batch, node: nodes.Chosen | nodes.Drawn | nodes.RandomRotated, first: int, count: int, lane: int = 0
) -> Floats:
    return generator.units(generator.words(batch.seed, node.key, batch.scenes, first, count, lane))


def _bound(batch: Batch, node: nodes.Drawn, item: Any, count: int) -> NDArray[np.float64]:
    """A bound (B, count), the same for every component where it is one number."""
    values = to_field_rows(batch.item(item))
    shapes = {(len(batch.scenes),), (len(batch.scenes), count)} if node.shape else {(len(batch.scenes),)}
    if values.dtype.kind not in "if" or values.shape not in shapes:
        raise DrawError(bound_mismatch(node), int(batch.scenes[0]), node)
    bound = values.astype(np.float64, copy=False)
    bound = bound[:, None] if bound.ndim == 1 else bound
    # A range of half the largest number is no range that anything in a scene has.
    _refuse(batch, node, ~(np.abs(bound) < 1e300), "a bound is beyond 1e300")
    return np.broadcast_to(bound, (len(batch.scenes), count))


_INT64 = 2**63


def _computed(batch: Batch, node: nodes.Computed) -> NDArray[Any]:
    """What the expression gives in each scene (B, *shape)."""
    template, draws = node.template, node.draws_by_name
    names = sorted(template.names - {"num_scenes"})
    # As Python's own numbers and lists.
    inputs = [(batch.scenes if name == "scene" else batch.shared(draws[name])).tolist() for name in names]
    environment: dict[str, Any] = {"num_scenes": batch.num_scenes, **dict(template.constants)}
    run = template.run
    results: list[Any] = []
    work = batch.work
    if work is not None:
        work.take(expression_cost(template.text, len(batch.scenes) if inputs else 1), node)
    try:
        # What reads no draw is the same in every scene.
        for values in zip(*inputs, strict=True) if inputs else [()]:
            environment.update(zip(names, values, strict=True))
            result = run(environment)
            results.append(result)
            if work is not None and result.__class__ in SEQUENCES:
                work.take(result_cost(result), node)
    except ExpressionError as error:
        scene = int(batch.scenes[len(results)])
        raise DrawError(error.message, scene, node, error) from error
    column = _result_rows(batch, node, results)
    return column if inputs else np.broadcast_to(column, (len(batch.scenes), *column.shape[1:]))


def _result_rows(batch: Batch, node: nodes.Computed, results: list[Any]) -> NDArray[Any]:
    if node.shape is None:
        return typed_row_array(results)
    if node.shape == ():
        for row, result in enumerate(results):
            if type(result) in {list, tuple, dict}:
                raise _row_error(batch, node, row, f"it gives {kind_name(result)} where one value is wanted")
            if type(result) is int and not -_INT64 <= result < _INT64:
                raise _row_error(batch, node, row, "it gives an integer of more than 64 bits")
        return row_array(results)
    for row, result in enumerate(results):
        wrong = shape_mismatch(result, node.shape, node.template.text)
        if wrong is not None:
            raise _row_error(batch, node, row, wrong)
    return np.array(results, dtype=np.float64).reshape(len(results), *node.shape)


def _row_error(batch: Batch, node: nodes.Computed, row: int, message: str) -> DrawError:
    return DrawError(message, int(batch.scenes[row]), node)


_UNTOUCHED, _NORMALISED = 1e-5, 1e-3
"""How far from 1 a quaternion's length may be: to be passed on as it is, and to be used at all."""

_RIGID = 1e-3
"""How far a matrix may be from a rigid motion."""


def _normalized(batch: Batch, node: nodes.Normalized) -> Floats:
    """Quaternions (B, 4)."""
    (q,) = _parts(batch, node)
    length = rotation_arrays.hypot(q)
    off = np.abs(length - 1)
    wrong = ~(off <= _NORMALISED)
    _refuse(batch, node, wrong, f"the quaternion's length is {length[wrong.argmax()]:.6g}, not 1")
    return np.where((off <= _UNTOUCHED)[:, None], q, rotation_arrays.normalized(q))


def _from_axis_angle(batch: Batch, node: nodes.FromAxisAngle) -> Floats:
    """Quaternions (B, 4)."""
    axis, angle = _parts(batch, node)
    _refuse(batch, node, (axis == 0).all(axis=1), "an axis of length 0 has no direction")
    return rotation_arrays.from_axis_angle(axis, angle)


def _from_matrix(batch: Batch, node: nodes.FromMatrix) -> Floats:
    """Poses (B, 7)."""
    (matrix,) = _parts(batch, node)
    off = rotation_arrays.rigidity(matrix)
    wrong = ~(off <= _RIGID)
    _refuse(batch, node, wrong, f"the matrix is no rigid motion: it is off by {off[wrong.argmax()]:.3g}")
    return np.concatenate((matrix[:, :3, 3], rotation_arrays.from_matrix(matrix[:, :3, :3])), axis=1)


def _looking(batch: Batch, node: nodes.Looking) -> Floats:
    """Quaternions (B, 4)."""
    target, p = _parts(batch, node)
    q, known = rotation_arrays.looking(target - p)
    _refuse(batch, node, ~known, "`look_at` is where the pose itself is, or straight above or below it")
    return q


def _pointing(batch: Batch, node: nodes.Pointing) -> Floats:
    """Quaternions (B, 4)."""
    (direction,) = _parts(batch, node)
    _refuse(batch, node, (direction == 0).all(axis=1), "a direction of length 0 points nowhere")
    return rotation_arrays.shortest_from_x(direction)


def _parts(batch: Batch, node: Node) -> list[Floats]:
    """The values (B, …) of the fields of a node that has a signature."""
    return [_numbers(batch, node, getattr(node, name), shape) for name, shape in shaped_fields(node)]


def _numbers(batch: Batch, node: Node, item: Any, shape: tuple[int, ...] | None = None) -> Floats:
    """An item's values (B, *shape) as float64; of any shape where none is given."""
    values = to_field_rows(batch.item(item))
    shape = values.shape[1:] if shape is None else shape
    if values.dtype.kind not in "if" or values.shape[1:] != shape:
        wanted = " by ".join(str(size) for size in shape) + " numbers" if shape else "a number"
        raise DrawError(f"this is not {wanted}", int(batch.scenes[0]), node)
    return values.astype(np.float64, copy=False)


def _refuse(batch: Batch, node: Node, wrong: NDArray[np.bool_], message: str) -> None:
    """Raises a DrawError for the first scene in which something (B,) or (B, n) is wrong."""
    if wrong.any():
        raise DrawError(message, int(batch.scenes[np.argwhere(wrong)[0, 0]]), node)


def _affine_clamp(batch: Batch, node: nodes.AffineClamp) -> NDArray[Any]:
    """The numbers (B,) of a node.

    Raises:
        DrawError: what it is made of are no numbers, or too few.
    """
    rows = batch.item(node.of)
    is_single = node.index < 0
    if rows.dtype.kind not in "fi" or rows.ndim != (1 if is_single else 2):
        wanted = "a number" if is_single else "a list of numbers"
        raise DrawError(f"this is not {wanted}", int(batch.scenes[0]), node)
    if not is_single:
        if node.index >= rows.shape[1]:
            raise DrawError(f"this has {rows.shape[1]} numbers only", int(batch.scenes[0]), node)
        rows = rows[:, node.index]
    moved = batch.item(node.factor) * rows + batch.item(node.offset)
    return np.maximum(np.minimum(moved.astype(np.float64), batch.item(node.high)), batch.item(node.low))


EVALUATORS: dict[type[Any], Callable[[Batch, Any], NDArray[Any]]] = {
    nodes.Const: lambda batch, node: batch.item(node.data),
    nodes.Rows: _rows,
    nodes.Cycled: lambda batch, node: batch.selected(node.items, batch.scenes % len(node.items)),
    nodes.Chosen: lambda batch, node: batch.selected(node.items, _choice_index(batch, node)),
    nodes.Drawn: _drawn,
    nodes.RandomRotated: lambda batch, node: generator.rotation(_units(batch, node, 0, 3)),
    nodes.Stacked: _stacked,
    nodes.Computed: _computed,
    nodes.Shared: lambda batch, node: batch.shared(node.name),
    nodes.Posed: lambda batch, node: np.concatenate(_parts(batch, node), axis=1),
    nodes.Normalized: _normalized,
    nodes.FromRpy: lambda batch, node: rotation_arrays.from_rpy(*_parts(batch, node)),
    nodes.FromAxisAngle: _from_axis_angle,
    nodes.FromMatrix: _from_matrix,
    nodes.Looking: _looking,
    nodes.Pointing: _pointing,
    # As `math.radians` has them.
    nodes.Radians: lambda batch, node: _numbers(batch, node, node.degrees) * (math.pi / 180.0),
    nodes.AffineClamp: _affine_clamp,
    nodes.Composed: lambda batch, node: rotation_arrays.compose(*_parts(batch, node)),
}
