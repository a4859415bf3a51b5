"""Varying values of the plan: small trees of plain data, evaluated over many scenes at once.

An *item* is a plain value (number, boolean, string, or tuple of these) or a node. Alternatives for one value have the
same shape. Shapes omit the leading scene axis.

A node that may have no value in some scene has an `origin`: where it is written. It is no part of the node's meaning,
and None in a recipe that was read from JSON.
"""

from __future__ import annotations

import math
from dataclasses import field, fields
from typing import TYPE_CHECKING, Any, Literal, get_args

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.distributions import DISTRIBUTIONS, Distribution

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.variation.chosen import ChosenUnits
    from scenecc.variation.forms import Template

Section = Literal["entities", "draws", "frames", "materials", "constraints", "lights", "cameras", "environment"]


@frozen
class Key:
    """Identifies a draw. The seed and this key determine the words of each scene.

    `path` is the field's, such as `pose.p` or `shapes[0].half_size`. It does not depend on how the field is written
    (`pose: [x, y, z]` is `pose.p`). A nested form appends its position (`mass.choice[1]`). `chosen`: numbers that
    replace random ones.
    """

    section: Section
    name: str
    path: str
    chosen: ChosenUnits = ()


@frozen
class Const:
    """The same in every scene."""

    data: Any


@frozen
class Rows:
    """One item for each of some scenes, by ascending scene index. Evaluated only in those scenes."""

    scene_idxs: tuple[int, ...]
    items: tuple[Any, ...]


@frozen
class Cycled:
    """By scene index modulo the number of items."""

    items: tuple[Any, ...]


@frozen
class Chosen:
    """One of the items, drawn. `word`: number of the component, if several share the field's key."""

    items: tuple[Any, ...]
    weights: tuple[float, ...] | None
    key: Key
    word: int = 0

    @property
    def possible(self) -> list[int]:
        """Indices of the items that can be drawn, which have a weight above 0."""
        return [number for number in range(len(self.items)) if self.weights is None or self.weights[number] > 0]


@frozen
class Shuffled:
    """Plain values in a drawn order. Word `word` + j decides the position of item j.

    Attributes:
        items: numbers, booleans or strings.
        key: the field's.
        word: of the first item.
        rest: values that stay after them.
    """

    items: tuple[Any, ...]
    key: Key
    word: int = 0
    rest: tuple[Any, ...] = ()


@frozen
class Drawn:
    """Numbers drawn independently, one word per component.

    Attributes:
        kind: of the distribution.
        operands: its items, of shape `shape` or scalars.
        shape: () or (n,).
        key: the field's.
        word: of the first component; j for component j of a `Stacked` vector.
    """

    kind: str
    operands: tuple[Any, ...]
    shape: tuple[int, ...]
    key: Key
    word: int = 0
    origin: Origin | None = field(default=None, compare=False, repr=False)

    @property
    def distribution(self) -> Distribution:
        """The distribution that draws the numbers."""
        return DISTRIBUTIONS[self.kind]


@frozen
class RandomRotated:
    """A quaternion (4,) drawn uniformly over all rotations."""

    key: Key


@frozen
class Stacked:
    """Items of one shape, stacked: a vector (n,) of scalars, a matrix of vectors."""

    items: tuple[Any, ...]


@frozen
class Computed:
    """The value of an expression in each scene.

    Attributes:
        template: reads draws, `scene` and `num_scenes`.
        shape: () for a number, boolean or string, (n,) for a list of n numbers; None for any value.
        reads: (name in the expression, name of the shared draw) if they differ. Any other name is that of a draw.
    """

    template: Template
    shape: tuple[int, ...] | None
    reads: tuple[tuple[str, str], ...] = ()
    origin: Origin | None = field(default=None, compare=False, repr=False)

    @property
    def draws_by_name(self) -> dict[str, str]:
        """The shared draws that it reads, by name in the expression."""
        reads = dict(self.reads)
        return {name: reads.get(name, name) for name in sorted(self.template.names - BUILTIN_NAMES)}


@frozen
class Converted:
    """A field's row, converted from the value of an expression.

    Attributes:
        of: an item.
        to: a name in `CONVERSIONS`.
    """

    of: Any
    to: str


@frozen
class Shared:
    """A shared draw, by name."""

    name: str


@frozen
class Placed:
    """The pose (7,) of a placement, by name."""

    name: str


@frozen
class Posed:
    """A pose (7,) of a position item (3,) and a rotation item (4,)."""

    p: Any
    q: Any


@frozen
class Normalized:
    """A quaternion as written: unchanged within 1e-5 of unit length, normalised within 1e-3, otherwise invalid."""

    q: Any
    origin: Origin | None = field(default=None, compare=False, repr=False)


@frozen
class FromRpy:
    """The quaternion (4,) of rotations about the fixed axes x, y, z (3,) [rad]."""

    angles: Any


@frozen
class FromAxisAngle:
    """The quaternion (4,) of a rotation about an axis (3,) by an angle () [rad]."""

    axis: Any
    angle: Any
    origin: Origin | None = field(default=None, compare=False, repr=False)


@frozen
class FromMatrix:
    """The pose (7,) of a rigid motion (4, 4)."""

    matrix: Any
    origin: Origin | None = field(default=None, compare=False, repr=False)


@frozen
class Looking:
    """The quaternion (4,) that looks from `p` (3,) to `target` (3,): x forward, z as far up as possible."""

    target: Any
    p: Any
    origin: Origin | None = field(default=None, compare=False, repr=False)


@frozen
class Pointing:
    """The shortest rotation (4,) that turns +x to a direction (3,)."""

    direction: Any
    origin: Origin | None = field(default=None, compare=False, repr=False)


@frozen
class Radians:
    """Converts one or several angles from degrees."""

    degrees: Any


@frozen
class AffineClamp:
    """One number, scaled, shifted and clamped: factor · number + offset, between `low` and `high`.

    Attributes:
        of: a number, or a list of numbers.
        index: in the list; -1: `of` is a number.
        low, high: items; `low` has priority if they cross.
        factor, offset: items.
    """

    of: Any
    index: int
    low: Any
    high: Any
    factor: Any = 1.0
    offset: Any = 0.0


@frozen
class Composed:
    """The pose (7,) `inner`, given in the frame of `outer` (7,), transformed to the parent frame of `outer`."""

    outer: Any
    inner: Any


Node = (
    Const
    | Rows
    | Cycled
    | Chosen
    | Shuffled
    | Drawn
    | RandomRotated
    | Stacked
    | Computed
    | Converted
    | Shared
    | Placed
    | Posed
    | Normalized
    | FromRpy
    | FromAxisAngle
    | FromMatrix
    | Looking
    | Pointing
    | Radians
    | AffineClamp
    | Composed
)
NODES: tuple[type[Any], ...] = get_args(Node)
"""The types of `Node`."""

NODE_TYPES = frozenset(NODES)
"""The same as a set."""


BUILTIN_NAMES = frozenset(("scene", "num_scenes"))
"""Names that every expression can read and that are not draws."""

_WITH_PARTS = NODE_TYPES | {tuple}
NODE_FIELDS = {kind: tuple(one.name for one in fields(kind) if one.compare) for kind in NODES}
"""The names of each node's fields, without the origin."""

Shapes = tuple[tuple[int, ...], ...]

SIGNATURES: dict[type[Any], tuple[Shapes, tuple[int, ...]]] = {
    Posed: (((3,), (4,)), (7,)),
    Normalized: (((4,),), (4,)),
    FromRpy: (((3,),), (4,)),
    FromAxisAngle: (((3,), ()), (4,)),
    FromMatrix: (((4, 4),), (7,)),
    Looking: (((3,), (3,)), (4,)),
    Pointing: (((3,),), (4,)),
    Composed: (((7,), (7,)), (7,)),
}
"""Nodes that compute a pose (7,) or a quaternion (4,) → shapes of their fields and of the result."""


def shaped_fields(node: Node) -> list[tuple[str, tuple[int, ...]]]:
    """The fields of a node with a signature, and their shapes."""
    return list(zip(NODE_FIELDS[type(node)], SIGNATURES[type(node)][0], strict=True))


def placements_read_by(node: Node) -> list[str]:
    """The placements that a node reads directly."""
    found: dict[str, None] = {}
    draws_read_by(node, found)
    return list(found)


def draws_read_by(node: Node, placements: dict[str, None] | None = None) -> list[str]:
    """The shared draws that a node reads directly, in any scene. `placements`: receives the names of placements."""
    found: dict[str, None] = {}
    todo: list[Any] = [node]
    while todo:
        item = todo.pop()
        kind = item.__class__
        if kind is Shared:
            found[item.name] = None
        elif kind is Placed and placements is not None:
            placements[item.name] = None
        elif kind is Computed:
            found.update(dict.fromkeys(item.draws_by_name.values()))
        elif kind is tuple:
            todo += [part for part in item if part.__class__ in _WITH_PARTS]
        elif kind in NODE_FIELDS:
            parts = [getattr(item, name) for name in NODE_FIELDS[kind]]
            todo += [part for part in parts if part.__class__ in _WITH_PARTS]
    return list(found)


def holds_infinity(node: Node, draws: Mapping[str, Node]) -> bool:
    """Whether a node, or a shared draw that it reads, contains infinity."""
    seen: set[str] = set()
    todo: list[Any] = [node]
    while todo:
        item = todo.pop()
        if item.__class__ is float and math.isinf(item):
            return True
        if item.__class__ in {tuple, list}:
            todo += item
        elif item.__class__ is Computed:
            todo += [value for _, value in item.template.constants]
        elif item.__class__ in NODE_FIELDS:
            todo += [getattr(item, name) for name in NODE_FIELDS[item.__class__]]
        if item.__class__ in {Computed, Shared}:
            names = [name for name in draws_read_by(item) if name not in seen]
            seen.update(names)
            todo += [draws[name] for name in names]
    return False


def evaluation_order(name: str, draws: Mapping[str, Node], is_made: Callable[[str], bool]) -> list[str]:
    """A shared draw and its missing dependencies, each after those that it reads.

    Args:
        name: of the draw.
        draws: the shared draws by name.
        is_made: whether a draw already exists.
    """
    ordered: dict[str, None] = {}
    opened: set[str] = set()
    todo = [name]
    while todo:
        last = todo[-1]
        if last not in opened:
            opened.add(last)
            todo += [other for other in draws_read_by(draws[last]) if other not in opened and not is_made(other)]
        else:
            todo.pop()
            ordered[last] = None
    return list(ordered)
