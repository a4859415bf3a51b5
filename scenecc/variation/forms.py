"""What a scene file can have in place of a value: forms of variation, and templates with expressions.

Items, bounds and components are plain values, forms or templates.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from enum import Enum
from functools import lru_cache
from typing import Any, Final

from scenecc.diagnostics.frozen import frozen
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.expression import MESH_BOUNDS, Closure, Expression, find_end, parse_expression
from scenecc.variation.operations import ExpressionError, as_lists, scalar_text


class Missing(Enum):
    """The type of `MISSING`."""

    MISSING = "missing"


MISSING: Final = Missing.MISSING
"""No default."""


@frozen
class PerScene:
    """`per_scene: [a, b]`: one value for each scene of the entity, by ascending index."""

    items: tuple[Any, ...]


@frozen
class SceneMap:
    """`per_scene: {0: a, 3: b, default: c}`: (scene index, value), in written order, each index once."""

    items: tuple[tuple[int, Any], ...]
    default: Any = MISSING


@frozen
class Cycle:
    """`cycle: [a, b]`: by scene index modulo the length."""

    items: tuple[Any, ...]


@frozen
class Choice:
    """`choice: [a, b], weights: [1, 2]`: one of them, drawn; equally likely without weights."""

    items: tuple[Any, ...]
    weights: tuple[float, ...] | None = None


@frozen
class Once:
    """`once: FORM`: the value of the form when the scenes are built. A reset keeps it."""

    form: Any


@frozen
class Shuffle:
    """`shuffle: [a, b, c]`: its plain values in a random order, as one list."""

    items: tuple[Any, ...]


@frozen
class DrawForm:
    """Numbers drawn from a distribution, such as `uniform: [low, high]`.

    Attributes:
        kind: the form's key, one of `DISTRIBUTIONS`.
        operands: the numbers of its list, then those of the companion key if present.
    """

    kind: str
    operands: tuple[Any, ...]


@frozen
class RandomRotation:
    """`q: uniform`: drawn uniformly over all rotations."""


@frozen
class Vector:
    """A list with varying components."""

    items: tuple[Any, ...]


LIST_FORMS: Final[dict[str, type[Any]]] = {"per_scene": PerScene, "cycle": Cycle, "choice": Choice, "shuffle": Shuffle}
"""Keys of the forms that list the values, from which each scene gets one, or all in its own order. (`per_scene`
may also be a map: `SceneMap`.)
"""

ONCE: Final = "once"

FORM_KEYS: Final = frozenset((*LIST_FORMS, *DISTRIBUTIONS, ONCE))
"""Keys of the mappings that give a different value in each scene, without companion keys."""

SELECTORS: Final = frozenset((PerScene, SceneMap, Cycle, Choice, Once))
"""The forms that select one of several items of any type. `Once` has one item."""


def alternatives(selector: Any) -> list[tuple[tuple[str | int, ...], Any]]:
    """The items of a selector, each with the steps that lead to it."""
    if isinstance(selector, SceneMap):
        found: list[tuple[tuple[str | int, ...], Any]] = [(("per_scene", str(at)), one) for at, one in selector.items]
        return found if selector.default is MISSING else [*found, (("per_scene", "default"), selector.default)]
    if isinstance(selector, Once):
        return [((ONCE,), selector.form)]
    name = next(name for name, kind in LIST_FORMS.items() if isinstance(selector, kind))
    return [((name, i), one) for i, one in enumerate(selector.items)]


def alternative_values(given: Any) -> Iterator[Any]:
    """All possible values behind nested selectors; the value itself if it is not a selector."""
    if given.__class__ not in SELECTORS:
        yield given
        return
    for _, one in alternatives(given):
        yield from alternative_values(one)


Form = PerScene | SceneMap | Cycle | Choice | Shuffle | Once | DrawForm | RandomRotation | Vector


class Template:
    """A scalar with expressions. Some of its names may already have values. Immutable.

    Attributes:
        text: the scalar's, as written.
        constants: names with values, sorted; lists are never tuples, as in JSON.
        names: names without values, including `scene` and `num_scenes`, but not quantities of a simulation.
        scope: of its names; None: that of the object.

    Two templates are equal if their texts, scopes and constants are, by type and bit by bit.
    """

    __slots__ = ("_parsed", "constants", "names", "scope", "text")

    _parsed: _Parsed
    text: str
    constants: tuple[tuple[str, Any], ...]
    names: frozenset[str]
    scope: str | None

    def __init__(self, text: str, constants: Mapping[str, Any] | None = None, scope: str | None = None) -> None:
        parsed = _parse(text)
        bound = {name: as_lists(value) for name, value in (constants or {}).items() if name in parsed.names}
        put = object.__setattr__
        put(self, "text", text)
        put(self, "scope", scope)
        put(self, "constants", tuple(sorted(bound.items(), key=lambda pair: pair[0])))
        put(self, "names", parsed.names - bound.keys())
        put(self, "_parsed", parsed)

    @staticmethod
    def parse(text: str) -> Template:
        """Parses the template of a scalar's text. Results are cached.

        Raises:
            ExpressionError: an expression in it is invalid.
        """
        return _template(text)

    def bind(self, environment: Mapping[str, Any]) -> Any:
        """Sets the names that the environment has. Returns the value if no name is left, otherwise a template.

        Raises:
            ExpressionError: it has no value.
        """
        if self.names <= environment.keys() and not self.observations:
            return self.evaluate(environment)
        if self.names.isdisjoint(environment):
            return self
        return Template(self.text, {**environment, **dict(self.constants)}, self.scope)

    def within(self, scope: str | None, text: str | None = None) -> Template:
        """The same template with another scope. `text`: a replacement that reads the same names."""
        return Template(self.text if text is None else text, dict(self.constants), scope)

    def evaluate(self, environment: Mapping[str, Any]) -> Any:
        """The value: of its own type if the scalar is a single expression, otherwise a string.

        Raises:
            ExpressionError: it has no value, or a name is unknown.
        """
        if self.constants:
            environment = {**environment, **dict(self.constants)}
        return self.run(environment)

    @property
    def run(self) -> Closure:
        """Evaluates an environment that includes the constants. Faster for many values of one template."""
        parts = self._parsed.parts
        if len(parts) == 1 and isinstance(parts[0], Expression):
            return parts[0].run
        return lambda environment: _fill_template(parts, environment)

    @property
    def meshes(self) -> Mapping[str, Expression]:
        """The mesh paths of its `bounds(PATH)` calls, by the name of the call."""
        return self._parsed.meshes

    @property
    def observations(self) -> Mapping[str, tuple[str, ...]]:
        """The quantities of a simulation that it reads: name of each call → function and arguments."""
        return self._parsed.observations

    def place(self, name: str) -> tuple[int, int]:
        """The first position of a name: (start, end) in the text."""
        for part in (*self._parsed.parts, *self.meshes.values()):
            if isinstance(part, Expression) and name in part.places:
                return part.places[name]
        raise KeyError(name)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a Template is read-only: {name!r} cannot be set", name=name, obj=self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Template):
            return NotImplemented
        return (self.text, self.scope) == (other.text, other.scope) and repr(self.constants) == repr(other.constants)

    def __hash__(self) -> int:
        return hash((self.text, repr(self.constants)))

    def __repr__(self) -> str:
        return f"Template({self.text!r}, {dict(self.constants)!r})" if self.constants else f"Template({self.text!r})"

    def __reduce__(self) -> tuple[type[Template], tuple[str, dict[str, Any], str | None]]:
        return Template, (self.text, dict(self.constants), self.scope)


Varying = Form | Template

MAX_EXPRESSIONS = 1000
"""Most `${…}` in one scalar."""

MAX_FILLED_CHARACTERS = 100_000
"""Longest text of one scalar after evaluation, in characters."""


@frozen
class _Parsed:
    """The literal texts and expressions of a scalar, in order, with their names; fields as in `Template`."""

    parts: tuple[str | Expression, ...]
    names: frozenset[str]
    meshes: Mapping[str, Expression]
    observations: Mapping[str, tuple[str, ...]]


@lru_cache(maxsize=4096)
def _template(text: str) -> Template:
    return Template(text)


@lru_cache(maxsize=4096)
def _parse(text: str) -> _Parsed:
    parts: list[str | Expression] = []
    literal, at, count = "", 0, 0
    while (found := text.find("${", at)) != -1:
        if found > at and text[found - 1] == "$":
            literal += text[at : found - 1] + "${"
            at = found + 2
            continue
        literal += text[at:found]
        end = find_end(text, found + 2)
        if count == MAX_EXPRESSIONS:
            raise ExpressionError(f"one scalar holds at most {MAX_EXPRESSIONS} expressions", found, end + 1)
        if literal:
            parts.append(literal)
        parts.append(parse_expression(text, found + 2, end))
        literal, at, count = "", end + 1, count + 1
    literal += text[at:]
    if literal:
        parts.append(literal)
    read = [part for part in parts if isinstance(part, Expression)]
    names = frozenset[str]().union(*(part.places for part in read))
    calls = {name: call for part in read for name, call in part.calls.items()}
    meshes = {name: call.arguments[0] for name, call in calls.items() if call.function == MESH_BOUNDS}
    observations = {
        name: (call.function, *(argument.run({}) for argument in call.arguments))
        for name, call in calls.items()
        if call.function != MESH_BOUNDS
    }
    return _Parsed(tuple(parts), names - observations.keys(), meshes, observations)


def _fill_template(parts: tuple[str | Expression, ...], environment: Mapping[str, Any]) -> str:
    texts: list[str] = []
    filled = 0
    for part in parts:
        if isinstance(part, str):
            texts.append(part)
            continue
        text = scalar_text(part.run(environment), part.span(part.tree))
        filled += len(text)
        if filled > MAX_FILLED_CHARACTERS:
            span = part.span(part.tree)
            raise ExpressionError(f"the expressions come to more than {MAX_FILLED_CHARACTERS} characters", *span)
        texts.append(text)
    return "".join(texts)
