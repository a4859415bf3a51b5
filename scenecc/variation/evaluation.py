"""Evaluates nodes in many scenes at once, as arrays with one row per scene."""

from __future__ import annotations

import cmath
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import accumulate, repeat
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from scenecc.diagnostics.messages import cut, show
from scenecc.geometry import rotation_arrays
from scenecc.geometry.rotations import EXACT_UNIT_TOLERANCE, RIGID_TOLERANCE, UNIT_TOLERANCE
from scenecc.variation import nodes
from scenecc.variation.conversions import CONVERSIONS
from scenecc.variation.distributions import WIDEST_INTEGERS
from scenecc.variation.nodes import NODES, Key, Node, evaluation_order, shaped_fields
from scenecc.variation.operations import (
    LISTS,
    NUMBERS,
    SEQUENCES,
    ComputeLimitError,
    DrawError,
    ExpressionError,
    OperationCounter,
    as_lists,
    expression_cost,
    has_shape,
    kind_name,
    result_cost,
    shape_mismatch,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from scenecc.geometry.rotation_arrays import Floats


_BLOCK = 4
"""Words per value of the counter."""


def philox_key(seed: int, key: Key) -> tuple[int, int]:
    """The two 64-bit words of the generator's key: the first 16 bytes of the SHA-256 of
    `[seed,"section","name","path"]`.
    """
    text = json.dumps([seed, key.section, key.name, key.path], ensure_ascii=True, separators=(",", ":"))
    digest = hashlib.sha256(text.encode("ascii")).digest()
    return int.from_bytes(digest[:8], "little"), int.from_bytes(digest[8:16], "little")


def words(
    seed: int | tuple[int, ...],
    key: Key,
    scenes: NDArray[np.int64],
    first: int,
    count: int,
    lane: int = 0,
    tries: NDArray[np.int64] | None = None,
) -> NDArray[np.uint64]:
    """The raw words `first` to `first + count` of a field in some scenes, (B, count).

    Args:
        seed: any integer, or one per scene.
        key: the field's.
        scenes: indices of the scenes (B,), in any order.
        first: the first word; component j of a vector has word j.
        count: number of words.
        lane: 0, or 1 for the second word if a component needs two.
        tries: number of the placement try, one per scene; None: 0.
    """
    if scenes.size == 0:
        return np.empty((0, count), dtype=np.uint64)
    first_block, last_block = first // _BLOCK, (first + count - 1) // _BLOCK
    start = first - first_block * _BLOCK
    if not isinstance(seed, int) or tries is not None:
        blocks_of = range(first_block, last_block + 1)
        return _many_seeds(seed, key, scenes, blocks_of, lane, tries)[:, start : start + count]
    lowest = int(scenes.min())
    rows = int(scenes.max()) - lowest + 1
    key_words = np.array(philox_key(seed, key), dtype=np.uint64)
    blocks: list[NDArray[np.uint64]] = []
    for block in range(first_block, last_block + 1):
        # The generator increments the counter before the first words: scene i has the counter (i + 1, block, lane, 0).
        counter = np.array((lowest, block, lane, 0), dtype=np.uint64)
        stream = np.random.Philox(key=key_words, counter=counter).random_raw(rows * _BLOCK)
        blocks.append(np.asarray(stream, dtype=np.uint64).reshape(rows, _BLOCK))
    joined = blocks[0] if len(blocks) == 1 else np.concatenate(blocks, axis=1)
    joined = joined[:, start : start + count]
    return joined if rows == len(scenes) and (np.diff(scenes) == 1).all() else joined[scenes - lowest]


def _many_seeds(
    seed: int | tuple[int, ...],
    key: Key,
    scenes: NDArray[np.int64],
    blocks: Sequence[int],
    lane: int,
    tries: NDArray[np.int64] | None,
) -> NDArray[np.uint64]:
    """The words of some blocks (B, 4 · blocks), if seeds or tries differ between scenes."""
    if isinstance(seed, int):
        keys = np.broadcast_to(np.array(philox_key(seed, key), dtype=np.uint64), (len(scenes), 2))
    else:
        key_of = {one: philox_key(one, key) for one in set(seed)}
        keys = np.array([key_of[one] for one in seed], dtype=np.uint64)
    counters = np.zeros((len(scenes), 4), dtype=np.uint64)
    counters[:, 0], counters[:, 2] = scenes + 1, lane
    if tries is not None:
        counters[:, 3] = tries
    found: list[NDArray[np.uint64]] = []
    for block in blocks:
        counters[:, 1] = block
        found.append(philox_block(keys, counters))
    return np.concatenate(found, axis=1)


def units(raw: NDArray[np.uint64]) -> NDArray[np.float64]:
    """Converts words to numbers in [0, 1), from their upper 53 bits."""
    return (raw >> np.uint64(11)).astype(np.float64) * 2.0**-53


def rotation(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """Uniform rotations as quaternions (B, 4), from numbers (B, 3): K. Shoemake, "Uniform random rotations" (1992)."""
    a, b = np.sqrt(1.0 - u[:, 0]), np.sqrt(u[:, 0])
    s, t = _unit_complex(2.0 * math.pi * u[:, 1]), _unit_complex(2.0 * math.pi * u[:, 2])
    return np.stack((b * t.real, a * s.imag, a * s.real, b * t.imag), axis=1)


def _unit_complex(angles: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Cosine and sine of each angle, as real and imaginary part, from the C library in one call."""
    return np.fromiter(map(cmath.rect, repeat(1.0), angles.tolist()), dtype=np.complex128, count=angles.size)


def choice(u: NDArray[np.float64], count: int, weights: Sequence[float] | None) -> NDArray[np.int64]:
    """Draws indices below `count` in proportion to their weights."""
    if weights is None:
        return np.minimum(np.floor(u * count).astype(np.int64), count - 1)
    reached = np.array(list(accumulate(float(weight) for weight in weights)), dtype=np.float64)
    # An index without weight is never drawn; rounding must not carry a draw past the last index with a weight.
    last = max(index for index, weight in enumerate(weights) if weight > 0)
    found = cast("NDArray[np.intp]", np.searchsorted(reached, u * reached[-1], side="right"))
    return np.minimum(found, last).astype(np.int64)


_ROUNDS = 10

_MULTIPLIERS = (np.uint64(0xD2E7470EE14C6C93), np.uint64(0xCA5A826395121157))

_WEYL = (np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBB67AE8584CAA73B))

_LOW, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)


def philox_block(keys: NDArray[np.uint64], counters: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The words (B, 4) of each key (B, 2) and counter (B, 4). Does not increment the counter."""
    a, b, c, d = (counters[:, i].copy() for i in range(4))
    k0, k1 = keys[:, 0].copy(), keys[:, 1].copy()
    with np.errstate(over="ignore"):
        for _ in range(_ROUNDS):
            high0, low0 = _product(_MULTIPLIERS[0], a)
            high1, low1 = _product(_MULTIPLIERS[1], c)
            a, b, c, d = high1 ^ b ^ k0, low1, high0 ^ d ^ k1, low0
            k0, k1 = k0 + _WEYL[0], k1 + _WEYL[1]
    return np.stack([a, b, c, d], axis=1)


def _product(x: np.uint64, y: NDArray[np.uint64]) -> tuple[NDArray[np.uint64], NDArray[np.uint64]]:
    """The upper and the lower 64 bits of a product."""
    x0, x1, y0, y1 = x & _LOW, x >> _HALF, y & _LOW, y >> _HALF
    low = x0 * y0
    middle = x1 * y0 + (low >> _HALF)
    other = x0 * y1 + (middle & _LOW)
    return x1 * y1 + (middle >> _HALF) + (other >> _HALF), x * y


def value_array(data: Any) -> NDArray[Any]:
    """One value: float64, int64 or bool of its shape, or an object of shape () for anything else."""
    whole = row_array([data])
    return whole[0] if whole.ndim > 1 else whole.reshape(())


def row_array(items: Sequence[Any]) -> NDArray[Any]:
    """Several values, one per row; objects unless all are numbers, or all booleans, of one shape."""
    if not any(map(_has_text, items)) and len({type(item) is bool for item in items}) <= 1:
        try:
            whole = np.array(items)
        except ValueError:
            # Rows of unequal length.
            return object_array(items)
        # Unsigned 64-bit integers would lose their highest bit.
        if whole.dtype.kind in "bif":
            return to_value_dtype(whole)
    return object_array(items)


def _kinds(items: Sequence[Any]) -> set[type]:
    kinds = set(map(type, items))
    if kinds.isdisjoint(LISTS):
        return kinds
    return {kind for item in items for kind in (_kinds(item) if type(item) in LISTS else {type(item)})}


def object_array(items: Sequence[Any]) -> NDArray[Any]:
    """Several values of any kind, one per row; tuples become lists."""
    whole = np.empty(len(items), dtype=object)
    for index, item in enumerate(items):
        whole[index] = as_lists(item)
    return whole


def to_value_dtype(array: NDArray[Any]) -> NDArray[Any]:
    """Converts an array to a dtype that values have: float64, int64, bool or object."""
    if array.dtype.kind == "f":
        return array.astype(np.float64, copy=False)
    if array.dtype.kind in "iu":
        return array.astype(np.int64, copy=False)
    return array if array.dtype.kind == "b" else array.astype(object, copy=False)


def distinct_rows(rows: NDArray[Any]) -> NDArray[np.intp]:
    """Indices of the first occurrence of each distinct row (B, …), in order. Compares bits: 0.0 differs from -0.0."""
    if rows.dtype == object or len(rows) < 2 or not rows[0].size:
        return np.arange(len(rows))
    flat = np.ascontiguousarray(rows).reshape(len(rows), -1)
    _, first = np.unique(flat.view(np.dtype((np.void, flat.dtype.itemsize * flat.shape[1]))), return_index=True)
    return np.sort(first)


def merge_rows(size: int, parts: Sequence[tuple[NDArray[np.intp], NDArray[Any]]]) -> NDArray[Any]:
    """Merges parts into one array of `size` rows. Each part has the indices of its rows.

    Integers stay integers beside floats: a scene's value must not depend on the batch, and text shows 1 and 1.0
    differently.
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
    """Converts rows (B, …) for a field, which treats integers and floats alike; other rows are unchanged."""
    return row_array(rows.tolist()) if rows.dtype == object else rows


def _has_text(item: Any) -> bool:
    """Whether an item is or contains a text. NumPy would pad all texts to the longest."""
    return type(item) is str or (type(item) in LISTS and str in set(map(type, item)))


class Batch:
    """A selection of the parallel scenes, in which nodes are evaluated.

    A node's value in a scene depends only on the seed, the node and the scene index, not on the other scenes in the
    batch.
    Shared draws are evaluated on first access and cached.

    Args:
        scenes: indices of the scenes (B,), at least one, in any order.
        seed: of every draw, or one per scene.
        num_scenes: value of `num_scenes` in expressions.
        draws: the shared draws by name; each may read earlier ones.
        given: values (N, …) that replace draws, row i for scene i.
        work: counts operations; None: no counting.

    Attributes:
        tries: number of the placement try (B,); None: 0.
        placed: poses (N, 7) of placements, row i for scene i.
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
        self.tries: NDArray[np.int64] | None = None
        self.placed: Mapping[str, Floats] = {}
        self._shared: dict[str, NDArray[Any]] = {}
        self._failed: dict[str, DrawError] = {}
        self._whole: tuple[Batch, NDArray[np.intp]] | None = None

    def evaluate(self, node: Node) -> NDArray[Any]:
        """The node's values (B, …): float64, int64 or bool, or objects for texts, lists or mixed values.

        The array may be read-only.

        Raises:
            DrawError: the node, or a node that it reads, has no value in one of the scenes.
        """
        return EVALUATORS[type(node)](self, node)

    def item(self, item: Any) -> NDArray[Any]:
        """Same as `evaluate`, also for a plain value."""
        if isinstance(item, NODES):
            return self.evaluate(item)
        value = value_array(item)
        return np.broadcast_to(value, (len(self.scenes), *value.shape))

    def shared(self, name: str) -> NDArray[Any]:
        """The values of a shared draw (B, …).

        Raises:
            DrawError: it has no value in one of the scenes.
        """
        if not self._is_made(name):
            for other in evaluation_order(name, self.draws, self._is_made):
                self._make(other)
        if name in self._failed:
            error = self._failed[name]
            # A new error, since each raise adds to a traceback; of the same type, which decides how it is reported.
            raise type(error)(error.message, error.scene, error.node, error.expression, error.seed)
        return self._shared[name]

    def kept(self, name: str) -> NDArray[Any] | None:
        """The cached values of a shared draw, or None."""
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
            # Its readers may not need it in that scene.
            self._failed[name] = error

    def error(self, message: str, row: int, node: Node, expression: ExpressionError | None = None) -> DrawError:
        """The error of a node without a value in a row of the batch."""
        seed = self.seed if isinstance(self.seed, int) else self.seed[row]
        return DrawError(message, int(self.scenes[row]), node, expression, seed)

    def only(self, rows: NDArray[np.intp]) -> Batch:
        """A batch of some of the rows."""
        chosen: list[int] = rows.tolist()
        seed = self.seed if isinstance(self.seed, int) else tuple(self.seed[row] for row in chosen)
        part = Batch(self.scenes[rows], seed, self.num_scenes, self.draws, self.given, self.work)
        part.placed = self.placed
        part._whole = (self, rows)
        return part

    def tried(self, rows: NDArray[np.intp], tries: NDArray[np.int64]) -> RetryBatch:
        """A batch of some of the rows, each in a placement try. Rows may repeat."""
        return RetryBatch(self.only(rows), tries)

    def selected(self, items: Sequence[Any], index: NDArray[np.int64]) -> NDArray[Any]:
        """For each scene, the item at its index (B,). An item is evaluated only in the scenes that use it."""
        if not any(isinstance(item, NODES) for item in items):
            return row_array(items)[index]
        parts: list[tuple[NDArray[np.intp], NDArray[Any]]] = []
        for number in np.unique(index).tolist():
            rows = np.flatnonzero(index == number)
            parts.append((rows, self.only(rows).item(items[number])))
        return merge_rows(len(self.scenes), parts)


class RetryBatch(Batch):
    """A batch in which each row is a separate try. Shared draws do not depend on the try.

    Args:
        scenes: the scenes of the rows, possibly repeated.
        tries: try number of each row (B,).
    """

    def __init__(self, scenes: Batch, tries: NDArray[np.int64]) -> None:
        super().__init__(scenes.scenes, scenes.seed, scenes.num_scenes, scenes.draws, scenes.given, scenes.work)
        self.tries, self.placed = tries, scenes.placed
        self._untried = scenes

    def shared(self, name: str) -> NDArray[Any]:
        """The values of a shared draw (B, …), the same in every try."""
        return self._untried.shared(name)

    def only(self, rows: NDArray[np.intp]) -> RetryBatch:
        """A batch of some of the rows."""
        assert self.tries is not None
        return RetryBatch(self._untried.only(rows), self.tries[rows])


def rows_with_value(name: str, batch: Batch) -> Iterator[tuple[int, Any]]:
    """The scenes in which a shared draw has a value, and its plain rows there. Nothing reads it in the others.

    Raises:
        ComputeLimitError: the draws exceed the limit of operations.
    """
    try:
        yield from zip(batch.scenes.tolist(), batch.shared(name).tolist(), strict=True)
    except ComputeLimitError:
        raise
    except DrawError:
        scenes = np.arange(len(batch.scenes))
        for half in np.array_split(scenes, 2) if len(scenes) > 1 else ():
            yield from rows_with_value(name, batch.only(half))


def _scene_index(batch: Batch, node: nodes.Rows) -> NDArray[np.intp]:
    """The index of the item of each scene (B,)."""
    known = np.array(node.scene_idxs, dtype=np.int64)
    index = np.minimum(np.searchsorted(known, batch.scenes), max(len(known) - 1, 0))
    missing = np.flatnonzero(known[index] != batch.scenes) if known.size else np.arange(len(batch.scenes))
    if missing.size:
        raise batch.error("no value is given for this scene", int(missing[0]), node)
    return index


def _evaluate_stacked(batch: Batch, node: nodes.Stacked) -> NDArray[Any]:
    parts = [batch.item(item) for item in node.items]
    for item, part in zip(node.items, parts, strict=True):
        if part.dtype.kind in "bO":
            _refuse_other_kinds(batch, item, part)
    if any(part.dtype == object for part in parts):
        parts = [part.astype(object) for part in parts]
    return np.stack(parts, axis=1)


def _refuse_other_kinds(batch: Batch, item: Any, part: NDArray[Any]) -> None:
    """Refuses a boolean or a text that an expression for one number gives: numpy would take true as 1."""
    given: list[Any] = part.tolist()
    first = {one.__class__: row for row, one in reversed(list(enumerate(given)))}
    for row in first.values():
        one, source, only = given[row], item, batch.only(np.array([row]))
        while source.__class__ in SELECTIONS:
            source = source.items[SELECTIONS[source.__class__](only, source).item()]
        if one.__class__ not in NUMBERS and isinstance(source, nodes.Computed) and source.shape == ():
            raise batch.error(f"this expression gives {cut(show(one))}, but a number is needed", row, source)


def _bound_mismatch(node: nodes.Drawn) -> str:
    """Message for a bound whose kind or size does not match the drawn value."""
    return f"a bound is not a number or a list of {node.shape[0]} numbers" if node.shape else "a bound is not a number"


def _choice_index(batch: Batch, node: nodes.Chosen) -> NDArray[np.int64]:
    """The index of the chosen item (B,)."""
    u = _units(batch, node, node.word, 1)[:, 0]
    return choice(u, len(node.items), node.weights)


def _evaluate_shuffled(batch: Batch, node: nodes.Shuffled) -> NDArray[Any]:
    """The items in ascending order of their words (B, n), then the rest."""
    count = len(node.items)
    places = np.argsort(_units(batch, node, node.word, count), axis=1, kind="stable")
    items = row_array([(*node.items, *node.rest)])
    if items.ndim > 1:
        rows = np.repeat(items, len(places), axis=0)
        rows[:, :count] = items[0, places]
        return rows
    return object_array([[*(node.items[place] for place in row), *node.rest] for row in places.tolist()])


def _evaluate_drawn(batch: Batch, node: nodes.Drawn) -> NDArray[Any]:
    """Drawn numbers (B, *shape)."""
    operands = _draw_operands(batch, node)

    def units(lane: int) -> Floats:
        return _units(batch, node, node.word, operands[0].shape[1], lane)

    values = node.distribution.sample(units, operands)
    return values if node.shape else values[:, 0]


def _draw_operands(batch: Batch, node: nodes.Drawn) -> list[Floats]:
    """The operands of a draw, each (B, n). Raises a DrawError if they are invalid in one of the scenes."""
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
        _refuse(batch, node, (low != np.floor(low)) | (high != np.floor(high)), "a bound is not an integer")
        wide = (np.abs(low) > WIDEST_INTEGERS) | (np.abs(high) > WIDEST_INTEGERS)
        _refuse(batch, node, wide, f"a bound is beyond {WIDEST_INTEGERS}")
        _refuse(batch, node, high - low >= WIDEST_INTEGERS, f"the bounds contain more than {WIDEST_INTEGERS} integers")
    return found


def _units(
    batch: Batch,
    node: nodes.Chosen | nodes.Shuffled | nodes.Drawn | nodes.RandomRotated,
    first: int,
    count: int,
    lane: int = 0,
) -> Floats:
    return key_units(batch, node.key, first, count, lane, every_try=isinstance(node, nodes.Chosen))


def key_units(batch: Batch, key: Key, first: int, count: int, lane: int = 0, *, every_try: bool = False) -> Floats:
    """Numbers in [0, 1) of a key (B, count): chosen ones, otherwise random.

    Chosen numbers are for the first try of a placement, or for `every_try`.
    """
    found = units(words(batch.seed, key, batch.scenes, first, count, lane, batch.tries))
    for in_lane, word, column in key.chosen:
        if in_lane == lane and first <= word < first + count:
            given = np.array((*column, -1.0))[np.minimum(batch.scenes, len(column))]
            taken = given >= 0 if batch.tries is None or every_try else (given >= 0) & (batch.tries == 0)
            found[:, word - first] = np.where(taken, given, found[:, word - first])
    return found


def _bound(batch: Batch, node: nodes.Drawn, item: Any, count: int) -> NDArray[np.float64]:
    """A bound (B, count). A single number is repeated for every component."""
    values = to_field_rows(batch.item(item))
    shapes = {(len(batch.scenes),), (len(batch.scenes), count)} if node.shape else {(len(batch.scenes),)}
    if values.dtype.kind not in "if" or values.shape not in shapes:
        fits = [has_shape(one, ()) or has_shape(one, (count,) if node.shape else ()) for one in values.tolist()]
        raise batch.error(_bound_mismatch(node), 0 if all(fits) else fits.index(False), node)
    bound = values.astype(np.float64, copy=False)
    bound = bound[:, None] if bound.ndim == 1 else bound
    # No quantity of a scene needs a range of half the largest number.
    _refuse(batch, node, ~(np.abs(bound) < 1e300), "a bound is beyond 1e300")
    return np.broadcast_to(bound, (len(batch.scenes), count))


_INT64 = 2**63


def _evaluate_computed(batch: Batch, node: nodes.Computed) -> NDArray[Any]:
    """The value of an expression in each scene (B, *shape)."""
    template, draws = node.template, node.draws_by_name
    names = sorted(template.names - {"num_scenes"})
    # Converted to Python numbers and lists.
    inputs = [(batch.scenes if name == "scene" else batch.shared(draws[name])).tolist() for name in names]
    environment: dict[str, Any] = {"num_scenes": batch.num_scenes, **dict(template.constants)}
    run = template.run
    results: list[Any] = []
    work = batch.work
    if work is not None:
        work.take(expression_cost(template.text, len(batch.scenes) if inputs else 1), node)
    try:
        # Without inputs, it is the same in every scene.
        for values in zip(*inputs, strict=True) if inputs else [()]:
            environment.update(zip(names, values, strict=True))
            result = run(environment)
            results.append(result)
            if work is not None and result.__class__ in SEQUENCES:
                work.take(result_cost(result), node)
    except ExpressionError as error:
        raise batch.error(error.message, len(results), node, error) from error
    column = _result_rows(batch, node, results)
    return column if inputs else np.broadcast_to(column, (len(batch.scenes), *column.shape[1:]))


def _result_rows(batch: Batch, node: nodes.Computed, results: list[Any]) -> NDArray[Any]:
    if node.shape is None:
        # Text shows 1 and 1.0 differently, and a scene's value must not depend on other scenes.
        return row_array(results) if len(_kinds(results)) <= 1 else object_array(results)
    if node.shape == ():
        for row, result in enumerate(results):
            if type(result) in {list, tuple, dict}:
                raise batch.error(f"it gives {kind_name(result)} where one value is needed", row, node)
            if type(result) is int and not -_INT64 <= result < _INT64:
                raise batch.error("it gives an integer of more than 64 bits", row, node)
        return row_array(results)
    for row, result in enumerate(results):
        wrong = shape_mismatch(result, node.shape, node.template.text)
        if wrong is not None:
            raise batch.error(wrong, row, node)
    return np.array(results, dtype=np.float64).reshape(len(results), *node.shape)


def _evaluate_converted(batch: Batch, node: nodes.Converted) -> NDArray[Any]:
    """Rows (B, …) in the format of the field."""
    convert, shape = CONVERSIONS[node.to]
    rows = batch.item(node.of).tolist()
    made = [convert(row) for row in rows]
    if None in made:
        row = made.index(None)
        raise batch.error(f"it gives {show(rows[row])}, which is not valid here", row, node.of)
    return np.array(made, dtype=np.float64 if shape else np.bool_).reshape(len(made), *shape)


def _evaluate_normalized(batch: Batch, node: nodes.Normalized) -> Floats:
    """Quaternions (B, 4)."""
    (q,) = _parts(batch, node)
    length = rotation_arrays.hypot(q)
    off = np.abs(length - 1)
    wrong = ~(off <= UNIT_TOLERANCE)
    _refuse(batch, node, wrong, f"the quaternion's length is {length[wrong.argmax()]:.6g}, not 1")
    return np.where((off <= EXACT_UNIT_TOLERANCE)[:, None], q, rotation_arrays.normalized(q))


def _evaluate_from_axis_angle(batch: Batch, node: nodes.FromAxisAngle) -> Floats:
    """Quaternions (B, 4)."""
    axis, angle = _parts(batch, node)
    _refuse(batch, node, (axis == 0).all(axis=1), "an axis of length 0 has no direction")
    return rotation_arrays.from_axis_angle(axis, angle)


def _evaluate_from_matrix(batch: Batch, node: nodes.FromMatrix) -> Floats:
    """Poses (B, 7)."""
    (matrix,) = _parts(batch, node)
    off = rotation_arrays.rigidity(matrix)
    wrong = ~(off <= RIGID_TOLERANCE)
    _refuse(batch, node, wrong, f"the matrix is not rigid: it is off by {off[wrong.argmax()]:.3g}")
    return np.concatenate((matrix[:, :3, 3], rotation_arrays.from_matrix(matrix[:, :3, :3])), axis=1)


def _evaluate_looking(batch: Batch, node: nodes.Looking) -> Floats:
    """Quaternions (B, 4)."""
    target, p = _parts(batch, node)
    q, known = rotation_arrays.looking(target - p)
    _refuse(batch, node, ~known, "`look_at` is where the pose itself is, or straight above or below it")
    return q


def _evaluate_pointing(batch: Batch, node: nodes.Pointing) -> Floats:
    """Quaternions (B, 4)."""
    (direction,) = _parts(batch, node)
    _refuse(batch, node, (direction == 0).all(axis=1), "a direction of length 0 points nowhere")
    return rotation_arrays.shortest_from_x(direction)


def _parts(batch: Batch, node: Node) -> list[Floats]:
    """The values (B, …) of the fields of a node with a signature."""
    return [_numbers(batch, node, getattr(node, name), shape) for name, shape in shaped_fields(node)]


def _numbers(batch: Batch, node: Node, item: Any, shape: tuple[int, ...] | None = None) -> Floats:
    """An item's values (B, *shape) as float64; any shape if None."""
    values = to_field_rows(batch.item(item))
    shape = values.shape[1:] if shape is None else shape
    if values.dtype.kind not in "if" or values.shape[1:] != shape:
        wanted = " by ".join(str(size) for size in shape) + " numbers" if shape else "a number"
        raise batch.error(f"this is not {wanted}", 0, node)
    return values.astype(np.float64, copy=False)


def _refuse(batch: Batch, node: Node, wrong: NDArray[np.bool_], message: str) -> None:
    """Raises a DrawError for the first scene in which something (B,) or (B, n) is wrong."""
    if wrong.any():
        raise batch.error(message, int(np.argwhere(wrong)[0, 0]), node)


def _evaluate_affine_clamp(batch: Batch, node: nodes.AffineClamp) -> NDArray[Any]:
    """The numbers (B,) of a node. Raises a DrawError if its parts are not numbers, or too few."""
    rows = batch.item(node.of)
    is_single = node.index < 0
    if rows.dtype.kind not in "fi" or rows.ndim != (1 if is_single else 2):
        wanted = "a number" if is_single else "a list of numbers"
        raise batch.error(f"this is not {wanted}", 0, node)
    if not is_single:
        if node.index >= rows.shape[1]:
            raise batch.error(f"this has only {rows.shape[1]} numbers", 0, node)
        rows = rows[:, node.index]
    moved = batch.item(node.factor) * rows + batch.item(node.offset)
    return np.maximum(np.minimum(moved.astype(np.float64), batch.item(node.high)), batch.item(node.low))


def _evaluate_placed(batch: Batch, node: nodes.Placed) -> Floats:
    """Poses (B, 7)."""
    if node.name not in batch.placed:
        raise batch.error(f"`{node.name}` is not placed yet", 0, node)
    return batch.placed[node.name][batch.scenes]


SELECTIONS: dict[type[Any], Callable[[Batch, Any], NDArray[Any]]] = {
    nodes.Rows: _scene_index,
    nodes.Cycled: lambda batch, node: batch.scenes % len(node.items),
    nodes.Chosen: _choice_index,
}
"""The index (B,) of the item that each kind of selecting node has in each scene."""


def _evaluate_selected(batch: Batch, node: Any) -> NDArray[Any]:
    return batch.selected(node.items, SELECTIONS[type(node)](batch, node))


EVALUATORS: dict[type[Any], Callable[[Batch, Any], NDArray[Any]]] = {
    **dict.fromkeys(SELECTIONS, _evaluate_selected),
    nodes.Const: lambda batch, node: batch.item(node.data),
    nodes.Shuffled: _evaluate_shuffled,
    nodes.Drawn: _evaluate_drawn,
    nodes.RandomRotated: lambda batch, node: rotation(_units(batch, node, 0, 3)),
    nodes.Stacked: _evaluate_stacked,
    nodes.Computed: _evaluate_computed,
    nodes.Converted: _evaluate_converted,
    nodes.Shared: lambda batch, node: batch.shared(node.name),
    nodes.Posed: lambda batch, node: np.concatenate(_parts(batch, node), axis=1),
    nodes.Normalized: _evaluate_normalized,
    nodes.FromRpy: lambda batch, node: rotation_arrays.from_rpy(*_parts(batch, node)),
    nodes.FromAxisAngle: _evaluate_from_axis_angle,
    nodes.FromMatrix: _evaluate_from_matrix,
    nodes.Looking: _evaluate_looking,
    nodes.Pointing: _evaluate_pointing,
    # Same rounding as `math.radians`.
    nodes.Radians: lambda batch, node: _numbers(batch, node, node.degrees) * (math.pi / 180.0),
    nodes.AffineClamp: _evaluate_affine_clamp,
    nodes.Placed: _evaluate_placed,
    nodes.Composed: lambda batch, node: rotation_arrays.compose(*_parts(batch, node)),
}
