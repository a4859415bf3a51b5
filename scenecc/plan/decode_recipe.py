"""Recipes from the plain data of a plan's JSON, which may come from a stranger: types, counts, names and shapes."""

from __future__ import annotations

import math
from dataclasses import MISSING, fields
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, get_args

from scenecc.plan.decode_numbers import Fault, is_list, is_object, shown
from scenecc.plan.fields import type_name
from scenecc.plan.recipe_shape import MisshapenError, shape_of
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.errors import ExpressionError
from scenecc.variation.nodes import NODES, Chosen, Computed, Cycled, Drawn, Key, Node, Rows, Section, Shared, Stacked
from scenecc.variation.operations import MAX_INT_BITS
from scenecc.variation.template import Template

if TYPE_CHECKING:
    from collections.abc import Callable, Container, Mapping

    from scenecc.plan.recipe_shape import Shape

DEEPEST = 100
"""How deeply nodes and lists may be nested; evaluating them goes as deep."""

_MOST_COMPONENTS = 4096
_LAST_WORD = 10_000
_LONGEST = 100_000
_BY_TYPE = {type_name(cls): cls for cls in NODES}
_NULLABLE = {"weights", "shape"}
_BUILT_IN = {"scene", "num_scenes"}


class _WrongError(Exception):
    """What is wrong, and the keys that lead there, innermost first."""

    def __init__(self, code: str, message: str, *keys: str | int) -> None:
        super().__init__(message)
        self.code = code
        self.keys: list[str | int] = [*keys]


def read_recipe(data: object, draws: Mapping[str, Shape], shape: Shape = None) -> tuple[Node, Shape] | Fault:
    """A node and the shape of what it gives in a scene, or what is wrong below `data`.

    Args:
        data: plain data of JSON.
        draws: the shapes of the shared draws that it may read.
        shape: what it is to give; None: anything.
    """
    try:
        node = _Reader(draws).node(data, 0)
        gives = shape_of(node, draws)
    except _WrongError as wrong:
        return Fault(wrong.code, str(wrong), tuple(reversed(wrong.keys)))
    except MisshapenError as error:
        return Fault("SC706", str(error))
    if shape is None or gives is None or gives == shape:
        return node, gives
    return Fault("SC706", f"this gives {_words(gives)}, and {_words(shape)} are wanted")


def _words(shape: tuple[int, ...]) -> str:
    return "no numbers" if -1 in shape else " by ".join(map(str, shape or (1,))) + " numbers"


class _Reader:
    """Reads one recipe."""

    def __init__(self, draws: Container[str]) -> None:
        self._draws = draws

    def node(self, data: object, depth: int) -> Node:
        """A node, whose names of shared draws are all known. `depth`: of nodes and lists around it."""
        if not is_object(data):
            raise _WrongError("SC705", f"a node is an object, not {shown(data)}")
        name = data.get("type")
        cls = _BY_TYPE.get(name) if isinstance(name, str) else None
        if cls is None:
            raise _WrongError("SC705", f"{shown(name)} is no type of node", "type")
        given = {key: item for key, item in data.items() if key != "type"}
        made: Any = self._drawn(given, depth) if cls is Drawn else self._made(cls, given, depth)
        _check_counts(made)
        if isinstance(made, Shared):
            self._known(made.name, "name")
        if isinstance(made, Computed):
            reads = dict(made.reads)
            for name in made.template.names - _BUILT_IN:
                self._known(reads.get(name, name), "template")
        return made

    def _drawn(self, data: dict[str, Any], depth: int) -> Drawn:
        """A draw, whose operands have the names that its distribution gives them."""
        kind = data.get("kind")
        if "kind" not in data:
            raise _WrongError("SC704", "the key `kind` is missing")
        drawn = DISTRIBUTIONS.get(kind) if isinstance(kind, str) else None
        if drawn is None:
            raise _WrongError("SC705", f"{shown(kind)} is no kind of draw", "kind")
        rest = {key: item for key, item in data.items() if key not in {*drawn.members, drawn.companion, "operands"}}
        if "operands" in data:
            raise _WrongError("SC703", "unknown key 'operands'", "operands")
        operands: list[Any] = []
        for name in drawn.members:
            if name not in data:
                raise _WrongError("SC704", f"the key `{name}` is missing")
            operands.append(self._at(name, _Reader.item, data[name], depth))
        if drawn.companion in data:
            operands += self._at(drawn.companion, _Reader.pair, data[drawn.companion], depth)
        return self._made(Drawn, rest, depth, operands=tuple(operands))

    def _made(self, cls: type[Any], data: dict[str, Any], depth: int, **made: Any) -> Any:
        known = {item.name: item for item in fields(cls) if item.name not in made}
        for key in data:
            if key not in known:
                raise _WrongError("SC703", f"unknown key {shown(key)}", key[:80])
        read: dict[str, Any] = {}
        for name, item in known.items():
            if name in data:
                read[name] = self._field(name, data[name], depth)
            elif name in _NULLABLE:
                read[name] = None
            elif item.default is MISSING:
                raise _WrongError("SC704", f"the key `{name}` is missing")
        return cls(**made, **read)

    def _field(self, name: str, data: object, depth: int) -> Any:
        return self._at(name, _FIELDS.get(name, _Reader.item), data, depth)

    def _at(self, key: str | int, read: Callable[[_Reader, object, int], Any], data: object, depth: int) -> Any:
        try:
            return read(self, data, depth)
        except _WrongError as wrong:
            wrong.keys.append(key)
            raise

    def item(self, data: object, depth: int) -> Any:
        """A plain value or a node."""
        if depth >= DEEPEST:
            raise _WrongError("SC712", "the recipe is nested too deeply")
        if is_object(data):
            return self.node(data, depth + 1)
        if is_list(data):
            return self.items(data, depth + 1)
        return _plain(data)

    def items(self, data: object, depth: int) -> tuple[Any, ...]:
        if not is_list(data):
            raise _WrongError("SC705", f"a list is wanted here, not {shown(data)}")
        return tuple(self._at(index, _Reader.item, one, depth + 1) for index, one in enumerate(data))

    def pair(self, data: object, depth: int) -> tuple[Any, ...]:
        items = self.items(data, depth)
        if len(items) != 2:
            raise _WrongError("SC706", f"a list of 2 is wanted here, not of {len(items)}")
        return items

    def reads(self, data: object, depth: int) -> tuple[tuple[str, str], ...]:
        pairs = self.items(data, depth)
        if not all(isinstance(p, tuple) and len(p) == 2 and all(isinstance(n, str) for n in p) for p in pairs):  # pyright: ignore[reportUnknownVariableType,reportUnknownArgumentType]
            raise _WrongError("SC705", "pairs of names are wanted here")
        return pairs

    def key(self, data: object, depth: int) -> Key:
        if not is_object(data):
            raise _WrongError("SC705", f"an object is wanted here, not {shown(data)}")
        made: Key = self._made(Key, data, depth)
        if made.section not in _SECTIONS:
            raise _WrongError("SC705", f"{shown(made.section)} is no section", "section")
        return made

    def template(self, data: object, depth: int) -> Template:
        """An expression with the constants that it reads."""
        if not is_object(data) or not data.keys() <= {"text", "constants"} or not isinstance(data.get("text"), str):
            raise _WrongError("SC705", "a template is an object with a `text`, and `constants` where it has any")
        constants: object = data.get("constants", {})
        if not is_object(constants):
            raise _WrongError("SC705", f"an object is wanted here, not {shown(constants)}", "constants")
        try:
            return Template(data["text"], {name: self._constant(x, depth) for name, x in constants.items()})
        except ExpressionError as error:
            raise _WrongError("SC705", f"the expression cannot be read: {error.message}", "text") from error

    def _constant(self, data: object, depth: int) -> Any:
        # Integers are of any size in an expression, up to its own limit.
        if type(data) is int and abs(data) < 2**MAX_INT_BITS:
            return data
        return self.item(data, depth)

    def _known(self, name: str, key: str) -> None:
        if name not in self._draws:
            raise _WrongError("SC708", f"there is no shared draw {shown(name)} before this", key)


def _check_counts(node: Any) -> None:
    if isinstance(node, Rows | Cycled | Chosen | Stacked) and not node.items:
        raise _WrongError("SC706", "one item at least is wanted here", "items")
    if isinstance(node, Chosen) and node.weights is not None:
        if len(node.weights) != len(node.items):
            raise _WrongError("SC706", f"{len(node.items)} weights are wanted here", "weights")
        if not 0 < sum(node.weights) < math.inf:
            raise _WrongError("SC707", "the weights add up to no positive number", "weights")
    if isinstance(node, Rows) and len(node.scene_idxs) != len(node.items):
        raise _WrongError("SC706", f"{len(node.scene_idxs)} items are wanted here", "items")


def _plain(data: object) -> Any:
    if isinstance(data, float) and not math.isfinite(data):
        raise _WrongError("SC707", f"{shown(data)} is outside the range: it must be finite")
    if type(data) is int and not -(2**63) <= data < 2**63:
        raise _WrongError("SC707", f"{shown(data)} is too large")
    if isinstance(data, str) and len(data) > _LONGEST:
        raise _WrongError("SC712", f"this string has {len(data)} characters")
    if data is None:
        raise _WrongError("SC705", "a value is wanted here, not null")
    return data


def _text(_: _Reader, data: object, __: int) -> str:
    if not isinstance(data, str) or len(data) > _LONGEST:
        raise _WrongError("SC705", f"a string is wanted here, not {shown(data)}")
    return data


_SECTIONS: Final[tuple[str, ...]] = get_args(Section)


def _word(_: _Reader, data: object, __: int) -> int:
    if type(data) is not int or not 0 <= data <= _LAST_WORD:
        raise _WrongError("SC707", f"{shown(data)} is outside the range: it must be 0 to {_LAST_WORD}")
    return data


def _index(_: _Reader, data: object, __: int) -> int:
    if type(data) is not int or not -1 <= data < _MOST_COMPONENTS:
        raise _WrongError("SC707", f"{shown(data)} is outside the range: it must be -1 to {_MOST_COMPONENTS - 1}")
    return data


def _shape(_: _Reader, data: object, __: int) -> tuple[int, ...]:
    if not is_list(data) or len(data) > 1 or any(type(n) is not int or not 0 < n <= _MOST_COMPONENTS for n in data):
        raise _WrongError("SC705", f"a shape is [] or [n], n from 1 to {_MOST_COMPONENTS}")
    return tuple(data)


def _weights(_: _Reader, data: object, __: int) -> tuple[float, ...]:
    if not is_list(data) or any(type(w) not in {int, float} or not 0 <= w < math.inf for w in data):
        raise _WrongError("SC705", "weights are numbers, none of them negative")
    return tuple(data)


def _scene_idxs(_: _Reader, data: object, __: int) -> tuple[int, ...]:
    if not is_list(data) or any(type(n) is not int or not 0 <= n < 2**31 for n in data):
        raise _WrongError("SC705", "a list of scene indices is wanted here")
    if any(a >= b for a, b in pairwise(data)):
        raise _WrongError("SC709", "scene indices ascend, without repetition")
    return tuple(data)


_FIELDS: Final[dict[str, Callable[[_Reader, object, int], Any]]] = {
    "items": _Reader.items,
    "reads": _Reader.reads,
    "key": _Reader.key,
    "template": _Reader.template,
    "name": _text,
    "path": _text,
    "section": _text,
    "kind": _text,
    "word": _word,
    "index": _index,
    "shape": _shape,
    "weights": _weights,
    "scene_idxs": _scene_idxs,
}
"""Fields by name; those that are not here hold an item."""
