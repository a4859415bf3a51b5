"""Recipes as plain JSON data: writer, reader, and inference of value shapes."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, get_args

from scenecc.plan.consistency import PlanFormatError
from scenecc.plan.schema import type_name
from scenecc.variation import nodes
from scenecc.variation.conversions import CONVERSIONS
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import Template
from scenecc.variation.nodes import NODES, SIGNATURES, Key, Node, Section, shaped_fields
from scenecc.variation.operations import MAX_INT_BITS, ExpressionError

if TYPE_CHECKING:
    from collections.abc import Callable, Container, Mapping, Sequence

    from scenecc.diagnostics.diagnostic import Path as Keys

    Shapes = Mapping[str, "Shape"]

Shape = tuple[int, ...] | None
"""None: unknown before evaluation. Contains -1: not numeric, or of unequal shapes."""

NO_NUMBERS: Final = (-1,)


class RecipeShapeError(Exception):
    """A part of a recipe has the wrong shape."""


def infer_shape(item: Any, draws: Shapes) -> Shape:
    """The shape of a recipe item, without the scene axis. `draws`: shapes of the shared draws.

    Raises:
        RecipeShapeError: the shapes of its parts do not match, so it cannot be evaluated.
    """
    if isinstance(item, NODES):
        return _NODE_SHAPES[type(item)](item, draws)
    if isinstance(item, tuple):
        return _list_shape(len(item), _infer_common_shape(item, draws))  # pyright: ignore[reportUnknownArgumentType]
    return () if type(item) in {int, float, bool} else NO_NUMBERS


def _infer_common_shape(items: Sequence[Any], draws: Shapes) -> Shape:
    """The common shape of all items."""
    return _merge_shapes({infer_shape(one, draws) for one in items})


def _merge_shapes(shapes: set[Shape]) -> Shape:
    known = shapes - {None}
    if len(known) > 1:
        return NO_NUMBERS
    return None if None in shapes else next(iter(known), ())


def _list_shape(count: int, shape: Shape) -> Shape:
    return None if shape is None else NO_NUMBERS if -1 in shape else (count, *shape)


def _stack_shape(node: nodes.Stacked, draws: Shapes) -> Shape:
    # One call per item: otherwise the time doubles with each level of nested stacks.
    shapes = {infer_shape(one, draws) for one in node.items}
    if len(shapes - {None}) > 1:
        raise RecipeShapeError("the items of a stack differ in shape")
    return _list_shape(len(node.items), _merge_shapes(shapes))


def _draw_shape(node: nodes.Drawn, draws: Shapes) -> Shape:
    for bound in node.operands:
        if infer_shape(bound, draws) not in (None, (), node.shape):
            raise RecipeShapeError("a bound of a draw has another shape than the draw")
    return node.shape


def _clamp_shape(node: nodes.AffineClamp, draws: Shapes) -> Shape:
    for bound in (node.low, node.high, node.factor, node.offset):
        if infer_shape(bound, draws) not in (None, ()):
            raise RecipeShapeError("what holds or moves a number is not one number")
    gives = infer_shape(node.of, draws)
    if gives is not None and (len(gives) != (node.index >= 0) or -1 in gives or node.index >= max(gives, default=0)):
        raise RecipeShapeError("there is no such number to be held")
    return ()


def _signature_shape(node: Node, draws: Shapes) -> Shape:
    for name, shape in shaped_fields(node):
        if infer_shape(getattr(node, name), draws) not in (None, shape):
            count = " by ".join(map(str, shape)) + " numbers" if shape else "one number"
            raise RecipeShapeError(f"`{name}` is not {count}")
    return SIGNATURES[type(node)][1]


_NODE_SHAPES: Final[dict[type[Any], Callable[[Any, Shapes], Shape]]] = {
    **dict.fromkeys(SIGNATURES, _signature_shape),
    nodes.Const: lambda node, draws: infer_shape(node.data, draws),
    nodes.Rows: lambda node, draws: _infer_common_shape(node.items, draws),
    nodes.Cycled: lambda node, draws: _infer_common_shape(node.items, draws),
    nodes.Chosen: lambda node, draws: _infer_common_shape(node.items, draws),
    nodes.Shuffled: lambda node, draws: infer_shape((*node.items, *node.rest), draws),
    nodes.Drawn: _draw_shape,
    nodes.RandomRotated: lambda _node, _draws: (4,),
    nodes.Stacked: _stack_shape,
    nodes.Computed: lambda node, _: node.shape,
    nodes.Converted: lambda node, _: CONVERSIONS[node.to].shape,
    nodes.Shared: lambda node, draws: draws[node.name],
    nodes.Placed: lambda _node, _draws: (7,),
    nodes.Radians: lambda node, draws: infer_shape(node.degrees, draws),
    nodes.AffineClamp: _clamp_shape,
}

_DRAWN = frozenset(("kind", "operands"))
"""Fields of a draw that its distribution writes."""


def recipe_to_data(node: Node) -> dict[str, Any]:
    """A node as JSON data. Omits None and default values."""
    if isinstance(node, nodes.Drawn):
        return {"type": type_name(nodes.Drawn), "kind": node.kind, **_operands(node), **_node_fields(node)}
    return {"type": type_name(type(node)), **_node_fields(node)}


def _operands(node: nodes.Drawn) -> dict[str, Any]:
    """The operands of a draw, under the names that its distribution defines."""
    drawn = node.distribution
    named = {name: _item_to_data(item) for name, item in zip(drawn.members, node.operands, strict=False)}
    edges = _item_to_data(node.operands[len(drawn.members) :])
    return {**named, str(drawn.companion): edges} if edges else named


def _node_fields(node: Any) -> dict[str, Any]:
    given = [(item, getattr(node, item.name)) for item in fields(node) if item.compare and item.name not in _DRAWN]
    return {
        item.name: _item_to_data(value)
        for item, value in given
        if value is not None and (item.default is MISSING or not _is_identical(value, item.default))
    }


def _is_identical(value: Any, default: Any) -> bool:
    """Whether values are equal bit by bit: -0.0 differs from 0.0."""
    return type(value) is type(default) and repr(value) == repr(default)


def _item_to_data(item: Any) -> Any:
    if isinstance(item, NODES):
        return recipe_to_data(item)
    if isinstance(item, Key):
        return _node_fields(item)
    if isinstance(item, Template):
        return template_to_data(item)
    if isinstance(item, tuple | list):
        several: list[Any] = list(item)  # pyright: ignore[reportUnknownArgumentType]
        return [_item_to_data(one) for one in several]
    if isinstance(item, float) and not math.isfinite(item):
        raise ValueError("a number of a recipe is not finite, and not JSON compliant")
    return item


def template_to_data(template: Template) -> dict[str, Any]:
    """An expression as JSON data."""
    constants = {name: _item_to_data(value) for name, value in template.constants}
    return {"text": template.text, **({"constants": constants} if constants else {})}


MAX_RECIPE_DEPTH = 100
"""Maximum nesting of nodes and lists. Evaluation recurses as deep."""

_MAX_COMPONENTS = 4096

_MAX_WORD = 10_000

_NODE_TYPES = {type_name(cls): cls for cls in NODES}

_SECTIONS: Final[tuple[str, ...]] = get_args(Section)


def read_recipe(data: Any, draws: Mapping[str, Shape], path: Keys) -> tuple[Node, Shape]:
    """Reads a node from JSON data. Returns it with the shape of its value in a scene.

    Args:
        data: plain data.
        draws: shapes of the shared draws that it may read.
        path: keys to the data in the plan.

    Raises:
        PlanFormatError: the data are not a recipe.
    """
    node = RecipeReader(draws).node(data, path, 0)
    try:
        return node, infer_shape(node, draws)
    except RecipeShapeError:
        raise PlanFormatError(path) from None


class RecipeReader:
    """Reads nodes and expressions, field by field, by their type hints. Raises `PlanFormatError`.

    `draws`: names of the shared draws that may be read. Methods take the data, its path in the plan, and the number of
    enclosing nodes and lists.
    """

    def __init__(self, draws: Container[str]) -> None:
        self._draws = draws
        self._readers: dict[str, Callable[[Any, Keys, int], Any]] = {
            "Any": self._item,
            "tuple[Any, ...]": self._items,
            "Key": lambda data, path, depth: self._read_object(Key, data, path, depth),
            "Template": self.template,
            "tuple[tuple[str, str], ...]": self._items,
            "ChosenUnits": self._items,
        }
        """Readers by type hint. Other fields hold plain values, which `_NODE_RULES` check."""

    def node(self, data: Any, path: Keys, depth: int) -> Node:
        """Reads a node."""
        if data.__class__ is not dict or not isinstance(data.get("type"), str) or data["type"] not in _NODE_TYPES:
            raise PlanFormatError((*path, "type"))
        cls: type[Any] = _NODE_TYPES[data["type"]]
        given = {key: item for key, item in data.items() if key != "type"}
        made: Any = (
            self._read_draw(given, path, depth) if cls is nodes.Drawn else self._read_object(cls, given, path, depth)
        )
        names = made.draws_by_name.values() if cls is nodes.Computed else [made.name] if cls is nodes.Shared else ()
        if not all(name in self._draws for name in names):
            raise PlanFormatError(path)
        return made

    def template(self, data: Any, path: Keys, depth: int) -> Template:
        """Reads an expression with its constants."""
        if data.__class__ is not dict or not data.keys() <= {"text", "constants"}:
            raise PlanFormatError(path)
        text, constants = data.get("text"), data.get("constants", {})
        if not isinstance(text, str) or constants.__class__ is not dict:
            raise PlanFormatError(path)
        made = {
            # An integer of an expression may have more than 64 bits.
            name: one if one.__class__ is int and abs(one) < 2**MAX_INT_BITS else self._item(one, (*path, name), depth)
            for name, one in constants.items()
        }
        try:
            return Template(text, made)
        except ExpressionError:
            raise PlanFormatError((*path, "text")) from None

    def _read_draw(self, data: dict[str, Any], path: Keys, depth: int) -> nodes.Drawn:
        """Reads a draw, whose operands have the names that its distribution defines."""
        kind = data.get("kind")
        if not isinstance(kind, str) or kind not in DISTRIBUTIONS or "operands" in data:
            raise PlanFormatError((*path, "kind"))
        drawn = DISTRIBUTIONS[kind]
        rest = {key: item for key, item in data.items() if key not in {*drawn.members, drawn.companion}}
        missing = next((name for name in drawn.members if name not in data), None)
        edges = () if drawn.companion not in data else self._items(data[drawn.companion], path, depth)
        if missing is not None or len(edges) not in {0, 2}:
            raise PlanFormatError((*path, missing or str(drawn.companion)))
        operands = [self._item(data[name], (*path, name), depth) for name in drawn.members]
        return self._read_object(nodes.Drawn, rest, path, depth, operands=(*operands, *edges))

    def _read_object(self, cls: type[Any], data: Any, path: Keys, depth: int, **given: Any) -> Any:
        if data.__class__ is not dict:
            raise PlanFormatError(path)
        values = given
        for item in fields(cls):
            if not item.compare:
                continue  # where a node is written
            if item.name in data:
                read = self._readers.get(str(item.type), _read_plain)
                values[item.name] = read(data[item.name], (*path, item.name), depth)
            elif item.name not in given and item.default is MISSING:
                if not str(item.type).endswith("| None"):
                    raise PlanFormatError((*path, item.name))
                values[item.name] = None
        unknown = [key for key in data if key not in values]
        if unknown:
            raise PlanFormatError((*path, unknown[0]))
        for name, value in values.items():
            if name in _FIELD_RULES and not _FIELD_RULES[name](value):
                raise PlanFormatError((*path, name))
        made = cls(**values)
        if cls in _NODE_RULES and not _NODE_RULES[cls](made):
            raise PlanFormatError(path)
        return made

    def _item(self, data: Any, path: Keys, depth: int) -> Any:
        """Reads a plain value or a node."""
        if depth >= MAX_RECIPE_DEPTH:
            raise PlanFormatError(path)
        if data.__class__ is dict:
            return self.node(data, path, depth + 1)
        return self._items(data, path, depth + 1) if data.__class__ is list else _read_scalar(data, path)

    def _items(self, data: Any, path: Keys, depth: int) -> tuple[Any, ...]:
        if data.__class__ is not list:
            raise PlanFormatError(path)
        return tuple([self._item(one, (*path, index), depth + 1) for index, one in enumerate(data)])


def _read_scalar(data: Any, path: Keys) -> Any:
    fits = math.isfinite(data) if data.__class__ is float else data.__class__ is not int or -(2**63) <= data < 2**63
    if data is None or not fits:
        raise PlanFormatError(path)
    return data


def _read_plain(data: Any, _path: Keys, _depth: int) -> Any:
    return tuple(data) if data.__class__ is list else data


def _is_integer(item: Any, low: int, high: int) -> bool:
    return item.__class__ is int and low <= item <= high


def _are_pairs(items: Any) -> bool:
    return all(pair.__class__ is tuple and len(pair) == 2 and {*map(type, pair)} == {str} for pair in items)


def _are_chosen_units(item: Any) -> bool:
    if item.__class__ is not tuple or len(item) != 3 or item[2].__class__ is not tuple:
        return False
    lane, word, column = item
    return (
        _is_integer(lane, 0, 1)
        and _is_integer(word, 0, _MAX_WORD)
        and all(u.__class__ is float and -1 <= u < 1 for u in column)
    )


_FIELD_RULES: Final[dict[str, Callable[[Any], bool]]] = {
    "name": lambda item: item.__class__ is str,
    "path": lambda item: item.__class__ is str,
    "section": lambda item: item in _SECTIONS,
    "to": lambda item: item.__class__ is str and item in CONVERSIONS,
    "word": lambda item: _is_integer(item, 0, _MAX_WORD),
    "index": lambda item: _is_integer(item, -1, _MAX_COMPONENTS - 1),
    "reads": _are_pairs,
    "chosen": lambda item: all(map(_are_chosen_units, item)),
    "shape": lambda item: (
        item is None
        or (item.__class__ is tuple and len(item) <= 1 and all(_is_integer(n, 1, _MAX_COMPONENTS) for n in item))
    ),
    "weights": lambda item: (
        item is None
        or (item.__class__ is tuple and {*map(type, item)} <= {int, float} and all(0 <= w < math.inf for w in item))
    ),
    "scene_idxs": lambda item: (
        item.__class__ is tuple
        and all(_is_integer(n, 0, 2**31 - 1) for n in item)
        and all(a < b for a, b in pairwise(item))
    ),
}
"""Rule for a field of a node or a key, by name."""

_NODE_RULES: Final[dict[type, Callable[[Any], bool]]] = {
    nodes.Rows: lambda node: 0 < len(node.items) == len(node.scene_idxs),
    nodes.Cycled: lambda node: bool(node.items),
    nodes.Stacked: lambda node: bool(node.items),
    nodes.Chosen: lambda node: (
        bool(node.items)
        and (node.weights is None or (len(node.weights) == len(node.items) and 0 < sum(node.weights) < math.inf))
    ),
    nodes.Shuffled: lambda node: (
        bool(node.items) and not any(isinstance(item, (*NODES, tuple)) for item in (*node.items, *node.rest))
    ),
}
"""Rule across the fields of a node."""
