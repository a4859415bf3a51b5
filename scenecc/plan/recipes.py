"""Recipes as plain data: the shape of their values, the writer, and the reader, whose input may be hostile."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, get_args

from scenecc.plan.json_values import JsonProblem, describe_json, is_list, is_object
from scenecc.plan.schema import type_name
from scenecc.variation import nodes
from scenecc.variation.conversions import CONVERSIONS
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import Template
from scenecc.variation.nodes import NODES, SIGNATURES, Key, Node, Section, shaped_fields
from scenecc.variation.operations import MAX_INT_BITS, ExpressionError

if TYPE_CHECKING:
    from collections.abc import Callable, Container, Mapping, Sequence

    Shapes = Mapping[str, "Shape"]

Shape = tuple[int, ...] | None
"""None: unknown before evaluation; with -1 in it: no numbers, or not of one shape."""

NO_NUMBERS: Final = (-1,)


class RecipeShapeError(Exception):
    """A part of a recipe is not of the shape that the rest needs."""


def infer_shape(item: Any, draws: Shapes) -> Shape:
    """The shape of an item of a recipe, without the axis of the scenes. `draws`: those of the shared draws.

    Raises:
        RecipeShapeError: it could not be evaluated, by the shapes of its parts.
    """
    if isinstance(item, NODES):
        return _NODE_SHAPES[type(item)](item, draws)
    if isinstance(item, tuple):
        return _list_shape(len(item), _common_shape(item, draws))  # pyright: ignore[reportUnknownArgumentType]
    return () if type(item) in {int, float, bool} else NO_NUMBERS


def _common_shape(items: Sequence[Any], draws: Shapes) -> Shape:
    """The shape that all have."""
    return _merge_shapes({infer_shape(one, draws) for one in items})


def _merge_shapes(shapes: set[Shape]) -> Shape:
    known = shapes - {None}
    if len(known) > 1:
        return NO_NUMBERS
    return None if None in shapes else next(iter(known), ())


def _list_shape(count: int, shape: Shape) -> Shape:
    return None if shape is None else NO_NUMBERS if -1 in shape else (count, *shape)


def _stack_shape(node: nodes.Stacked, draws: Shapes) -> Shape:
    # Asked once for each item: a stack of stacks would otherwise take twice as long for each that it is deep.
    shapes = {infer_shape(one, draws) for one in node.items}
    if len(shapes - {None}) > 1:
        raise RecipeShapeError("the items of a stack differ in shape")
    return _list_shape(len(node.items), _merge_shapes(shapes))


def _draw_shape(node: nodes.Drawn, draws: Shapes) -> Shape:
    for bound in node.operands:
        if infer_shape(bound, draws) not in (None, (), node.shape):
            raise RecipeShapeError("a bound of a draw has another shape than the draw")
    return node.shape


def _clamped(node: nodes.AffineClamp, draws: Shapes) -> Shape:
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
    nodes.Rows: lambda node, draws: _common_shape(node.items, draws),
    nodes.Cycled: lambda node, draws: _common_shape(node.items, draws),
    nodes.Chosen: lambda node, draws: _common_shape(node.items, draws),
    nodes.Shuffled: lambda node, draws: infer_shape((*node.items, *node.rest), draws),
    nodes.Drawn: _draw_shape,
    nodes.RandomRotated: lambda _node, _draws: (4,),
    nodes.Stacked: _stack_shape,
    nodes.Computed: lambda node, _: node.shape,
    nodes.Converted: lambda node, _: CONVERSIONS[node.to].shape,
    nodes.Shared: lambda node, draws: draws[node.name],
    nodes.Placed: lambda _node, _draws: (7,),
    nodes.Radians: lambda node, draws: infer_shape(node.degrees, draws),
    nodes.AffineClamp: _clamped,
}

_DRAWN = frozenset(("kind", "operands"))
"""Fields of a draw that are written by its distribution."""


def recipe_to_data(node: Node) -> dict[str, Any]:
    """A node as JSON has it. What is None, or the default of its field, is left out."""
    if isinstance(node, nodes.Drawn):
        return {"type": type_name(nodes.Drawn), "kind": node.kind, **_operands(node), **_node_fields(node)}
    return {"type": type_name(type(node)), **_node_fields(node)}


def _operands(node: nodes.Drawn) -> dict[str, Any]:
    """The operands of a draw, by the names that its distribution gives them."""
    drawn = node.distribution
    named = {name: _item_to_data(item) for name, item in zip(drawn.members, node.operands, strict=False)}
    edges = _item_to_data(node.operands[len(drawn.members) :])
    return {**named, str(drawn.companion): edges} if edges else named


def _node_fields(node: Any) -> dict[str, Any]:
    given = [(item, getattr(node, item.name)) for item in fields(node) if item.name not in _DRAWN]
    return {
        item.name: _item_to_data(value)
        for item, value in given
        if value is not None and (item.default is MISSING or not _is_identical(value, item.default))
    }


def _is_identical(value: Any, default: Any) -> bool:
    """To the bit: 0 and -0.0 are equal to 0.0, and others."""
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
    return item


def template_to_data(template: Template) -> dict[str, Any]:
    """An expression as JSON has it."""
    constants = {name: _item_to_data(value) for name, value in template.constants}
    return {"text": template.text, **({"constants": constants} if constants else {})}


MAX_RECIPE_DEPTH = 100
"""How deeply nodes and lists may be nested; evaluating them goes as deep."""

_MAX_COMPONENTS = 4096

_MAX_WORD = 10_000

_MAX_STRING_LENGTH = 100_000

_NODE_TYPES = {type_name(cls): cls for cls in NODES}

_NULLABLE = {"weights", "shape"}


class _RecipeError(Exception):
    """What is wrong, and the keys that lead there, innermost first."""

    def __init__(self, code: str, message: str, *keys: str | int) -> None:
        super().__init__(message)
        self.code = code
        self.keys: list[str | int] = [*keys]


def read_recipe(data: object, draws: Mapping[str, Shape], shape: Shape = None) -> tuple[Node, Shape] | JsonProblem:
    """A node and the shape of what it gives in a scene, or what is wrong below `data`.

    Args:
        data: plain data of JSON.
        draws: the shapes of the shared draws that it may read.
        shape: what it is to give; None: anything.
    """
    try:
        node = _RecipeReader(draws).node(data, 0)
        gives = infer_shape(node, draws)
    except _RecipeError as wrong:
        return JsonProblem(wrong.code, str(wrong), tuple(reversed(wrong.keys)))
    except RecipeShapeError as error:
        return JsonProblem("SC706", str(error))
    if shape is None or gives is None or gives == shape:
        return node, gives
    return JsonProblem("SC706", f"this gives {_describe_shape(gives)}, and {_describe_shape(shape)} are wanted")


def read_template(data: object) -> Template | JsonProblem:
    """An expression with its constants, or what is wrong below `data`."""
    try:
        return _RecipeReader(()).template(data, 0)
    except _RecipeError as wrong:
        return JsonProblem(wrong.code, str(wrong), tuple(reversed(wrong.keys)))


def _describe_shape(shape: tuple[int, ...]) -> str:
    return "no numbers" if -1 in shape else " by ".join(map(str, shape or (1,))) + " numbers"


class _RecipeReader:
    """Reads one recipe."""

    def __init__(self, draws: Container[str]) -> None:
        self._draws = draws

    def node(self, data: object, depth: int) -> Node:
        """A node, whose names of shared draws are all known. `depth`: of nodes and lists around it."""
        if not is_object(data):
            raise _RecipeError("SC705", f"a node is an object, not {describe_json(data)}")
        name = data.get("type")
        cls = _NODE_TYPES.get(name) if isinstance(name, str) else None
        if cls is None:
            raise _RecipeError("SC705", f"{describe_json(name)} is no type of node", "type")
        given = {key: item for key, item in data.items() if key != "type"}
        made: Any = self._drawn(given, depth) if cls is nodes.Drawn else self._made(cls, given, depth)
        _check_counts(made)
        if isinstance(made, nodes.Shared):
            self._known(made.name, "name")
        if isinstance(made, nodes.Computed):
            for name in made.draws_by_name.values():
                self._known(name, "template")
        return made

    def _drawn(self, data: dict[str, Any], depth: int) -> nodes.Drawn:
        """A draw, whose operands have the names that its distribution gives them."""
        kind = data.get("kind")
        if "kind" not in data:
            raise _RecipeError("SC704", "the key `kind` is missing")
        drawn = DISTRIBUTIONS.get(kind) if isinstance(kind, str) else None
        if drawn is None:
            raise _RecipeError("SC705", f"{describe_json(kind)} is no kind of draw", "kind")
        rest = {key: item for key, item in data.items() if key not in {*drawn.members, drawn.companion, "operands"}}
        if "operands" in data:
            raise _RecipeError("SC703", "unknown key 'operands'", "operands")
        operands: list[Any] = []
        for name in drawn.members:
            if name not in data:
                raise _RecipeError("SC704", f"the key `{name}` is missing")
            operands.append(self._at(name, _RecipeReader.item, data[name], depth))
        if drawn.companion in data:
            operands += self._at(drawn.companion, _RecipeReader.pair, data[drawn.companion], depth)
        return self._made(nodes.Drawn, rest, depth, operands=tuple(operands))

    def _made(self, cls: type[Any], data: dict[str, Any], depth: int, **made: Any) -> Any:
        known = {item.name: item for item in fields(cls) if item.name not in made}
        for key in data:
            if key not in known:
                raise _RecipeError("SC703", f"unknown key {describe_json(key)}", key[:80])
        read: dict[str, Any] = {}
        for name, item in known.items():
            if name in data:
                read[name] = self._field(name, data[name], depth)
            elif name in _NULLABLE:
                read[name] = None
            elif item.default is MISSING:
                raise _RecipeError("SC704", f"the key `{name}` is missing")
        return cls(**made, **read)

    def _field(self, name: str, data: object, depth: int) -> Any:
        return self._at(name, _FIELD_READERS.get(name, _RecipeReader.item), data, depth)

    def _at(self, key: str | int, read: Callable[[_RecipeReader, object, int], Any], data: object, depth: int) -> Any:
        try:
            return read(self, data, depth)
        except _RecipeError as wrong:
            wrong.keys.append(key)
            raise

    def item(self, data: object, depth: int) -> Any:
        """A plain value or a node."""
        if depth >= MAX_RECIPE_DEPTH:
            raise _RecipeError("SC712", "the recipe is nested too deeply")
        if is_object(data):
            return self.node(data, depth + 1)
        if is_list(data):
            return self.items(data, depth + 1)
        return _read_scalar(data)

    def items(self, data: object, depth: int) -> tuple[Any, ...]:
        if not is_list(data):
            raise _RecipeError("SC705", f"a list is wanted here, not {describe_json(data)}")
        return tuple(self._at(index, _RecipeReader.item, one, depth + 1) for index, one in enumerate(data))

    def pair(self, data: object, depth: int) -> tuple[Any, ...]:
        items = self.items(data, depth)
        if len(items) != 2:
            raise _RecipeError("SC706", f"a list of 2 is wanted here, not of {len(items)}")
        return items

    def reads(self, data: object, depth: int) -> tuple[tuple[str, str], ...]:
        pairs = self.items(data, depth)
        if not all(isinstance(p, tuple) and len(p) == 2 and all(isinstance(n, str) for n in p) for p in pairs):  # pyright: ignore[reportUnknownVariableType,reportUnknownArgumentType]
            raise _RecipeError("SC705", "pairs of names are wanted here")
        return pairs

    def key(self, data: object, depth: int) -> Key:
        if not is_object(data):
            raise _RecipeError("SC705", f"an object is wanted here, not {describe_json(data)}")
        made: Key = self._made(Key, data, depth)
        if made.section not in _SECTIONS:
            raise _RecipeError("SC705", f"{describe_json(made.section)} is no section", "section")
        return made

    def template(self, data: object, depth: int) -> Template:
        """An expression with the constants that it reads."""
        if not is_object(data) or not data.keys() <= {"text", "constants"} or not isinstance(data.get("text"), str):
            raise _RecipeError("SC705", "a template is an object with a `text`, and `constants` where it has any")
        constants: object = data.get("constants", {})
        if not is_object(constants):
            raise _RecipeError("SC705", f"an object is wanted here, not {describe_json(constants)}", "constants")
        try:
            return Template(data["text"], {name: self._constant(x, depth) for name, x in constants.items()})
        except ExpressionError as error:
            raise _RecipeError("SC705", f"the expression cannot be read: {error.message}", "text") from error

    def _constant(self, data: object, depth: int) -> Any:
        # Integers are of any size in an expression, up to its own limit.
        if type(data) is int and abs(data) < 2**MAX_INT_BITS:
            return data
        return self.item(data, depth)

    def _known(self, name: str, key: str) -> None:
        if name not in self._draws:
            raise _RecipeError("SC708", f"there is no shared draw {describe_json(name)} before this", key)


def _check_counts(node: Any) -> None:
    if isinstance(node, nodes.Rows | nodes.Cycled | nodes.Chosen | nodes.Shuffled | nodes.Stacked) and not node.items:
        raise _RecipeError("SC706", "one item at least is wanted here", "items")
    if isinstance(node, nodes.Chosen) and node.weights is not None:
        if len(node.weights) != len(node.items):
            raise _RecipeError("SC706", f"{len(node.items)} weights are wanted here", "weights")
        if not 0 < sum(node.weights) < math.inf:
            raise _RecipeError("SC707", "the weights add up to no positive number", "weights")
    if isinstance(node, nodes.Shuffled) and any(
        isinstance(item, (*NODES, tuple)) for item in (*node.items, *node.rest)
    ):
        raise _RecipeError("SC705", "plain values are wanted here", "items")
    if isinstance(node, nodes.Rows) and len(node.scene_idxs) != len(node.items):
        raise _RecipeError("SC706", f"{len(node.scene_idxs)} items are wanted here", "items")


def _read_scalar(data: object) -> Any:
    if isinstance(data, float) and not math.isfinite(data):
        raise _RecipeError("SC707", f"{describe_json(data)} is outside the range: it must be finite")
    if type(data) is int and not -(2**63) <= data < 2**63:
        raise _RecipeError("SC707", f"{describe_json(data)} is too large")
    if isinstance(data, str) and len(data) > _MAX_STRING_LENGTH:
        raise _RecipeError("SC712", f"this string has {len(data)} characters")
    if data is None:
        raise _RecipeError("SC705", "a value is wanted here, not null")
    return data


def _read_text(_: _RecipeReader, data: object, __: int) -> str:
    if not isinstance(data, str) or len(data) > _MAX_STRING_LENGTH:
        raise _RecipeError("SC705", f"a string is wanted here, not {describe_json(data)}")
    return data


_SECTIONS: Final[tuple[str, ...]] = get_args(Section)


def _integer_reader(low: int, high: int) -> Callable[[_RecipeReader, object, int], int]:
    def read(_: _RecipeReader, data: object, __: int) -> int:
        if type(data) is not int or not low <= data <= high:
            raise _RecipeError("SC707", f"{describe_json(data)} is outside the range: it must be {low} to {high}")
        return data

    return read


def _read_shape(_: _RecipeReader, data: object, __: int) -> tuple[int, ...]:
    if not is_list(data) or len(data) > 1 or any(type(n) is not int or not 0 < n <= _MAX_COMPONENTS for n in data):
        raise _RecipeError("SC705", f"a shape is [] or [n], n from 1 to {_MAX_COMPONENTS}")
    return tuple(data)


def _read_weights(_: _RecipeReader, data: object, __: int) -> tuple[float, ...]:
    if not is_list(data) or any(type(w) not in {int, float} or not 0 <= w < math.inf for w in data):
        raise _RecipeError("SC705", "weights are numbers, none of them negative")
    return tuple(data)


def _read_scene_idxs(_: _RecipeReader, data: object, __: int) -> tuple[int, ...]:
    if not is_list(data) or any(type(n) is not int or not 0 <= n < 2**31 for n in data):
        raise _RecipeError("SC705", "a list of scene indices is wanted here")
    if any(a >= b for a, b in pairwise(data)):
        raise _RecipeError("SC709", "scene indices ascend, without repetition")
    return tuple(data)


def _read_conversion(_reader: _RecipeReader, data: object, _depth: int) -> str:
    if not isinstance(data, str) or data not in CONVERSIONS:
        raise _RecipeError("SC705", f"{describe_json(data)} is no conversion")
    return data


_FIELD_READERS: Final[dict[str, Callable[[_RecipeReader, object, int], Any]]] = {
    "items": _RecipeReader.items,
    "rest": _RecipeReader.items,
    "reads": _RecipeReader.reads,
    "key": _RecipeReader.key,
    "template": _RecipeReader.template,
    "name": _read_text,
    "path": _read_text,
    "section": _read_text,
    "kind": _read_text,
    "to": _read_conversion,
    "word": _integer_reader(0, _MAX_WORD),
    "index": _integer_reader(-1, _MAX_COMPONENTS - 1),
    "shape": _read_shape,
    "weights": _read_weights,
    "scene_idxs": _read_scene_idxs,
}
"""Fields by name; those that are not here hold an item."""
