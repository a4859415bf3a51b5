"""Reads expressions, per-scene lists and distributions from plain data into `scenecc.variation.forms`.

The bounds of a distribution are checked against the range of the value that it replaces.
"""

from __future__ import annotations

import math
import re
from contextlib import suppress
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import PydanticCustomError

from scenecc.diagnostics.messages import cut, show
from scenecc.geometry.rotations import AXES
from scenecc.spec.base import NOTE_PREFIX, VALUE_NAME, ErrorCollector, custom_error
from scenecc.spec.nodes import EXPANDED, any_varying, is_mapping, is_sequence, is_varying
from scenecc.spec.values import MAX_DRAW_COMPONENTS, Domain
from scenecc.variation import forms
from scenecc.variation.conversions import to_rgba
from scenecc.variation.distributions import DISTRIBUTIONS, WIDEST_INTEGERS, Distribution, OperandRule
from scenecc.variation.forms import FORM_KEYS, Template
from scenecc.variation.operations import ExpressionError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenecc.diagnostics.diagnostic import PathKey

    Loc = tuple[PathKey, ...]
    Validate = Callable[[Any], Any]


def read_fixed_expression(node: Any) -> Template:
    """Returns the template of an expression in an unexpanded document.

    Raises:
        PydanticCustomError: the node is a form, an expanded template or an invalid expression.
    """
    if is_mapping(node):
        form = next(key for key in node if key in FORM_KEYS)
        raise custom_error("SC116", f"{VALUE_NAME} cannot differ from scene to scene: `{form}` is not allowed here")
    if isinstance(node, Template):
        raise custom_error(
            "SC116",
            f"{VALUE_NAME} reads {quote_names(node)} and would differ from scene to scene, which is not allowed",
        )
    return parse_template(node)


def parse_template(text: str) -> Template:
    """Parses the template of a string in an unexpanded document.

    Raises:
        PydanticCustomError: invalid expression.
    """
    try:
        return Template.parse(text)
    except ExpressionError as problem:
        raise custom_error("SC118", problem.message, hint=problem.hint, span=(problem.start, problem.end)) from None


def quote_names(template: Template) -> str:
    """Returns the names that a template reads, quoted for a message."""
    return " and ".join(f"`{name}`" for name in sorted(template.names))


def read_distribution(
    reader: FormReader, key: str, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc
) -> Any:
    """Reads a form that draws numbers, the mapping `node` with `key`. Returns None after an error."""
    at = (*loc, key)
    if not domain.of_numbers:
        hint = "use `per_scene`, `cycle` or `choice` for other values"
        return reader.mistake("SC116", f"`{key}` draws only numbers", node, at, hint)
    drawn = DISTRIBUTIONS[key]
    if domain.whole and not drawn.whole:
        hint = f"write `integers: {show(node[key])}`" if key == "uniform" else "write `integers: [low, high]`"
        return reader.mistake("SC116", f"`{key}` does not draw integers", node, at, hint)
    names = f"[{', '.join(drawn.operands)}]"
    operands = _operands(reader, node[key], [domain.of_role(role) for role in drawn.roles], plain, at, names)
    edges = _edges(reader, drawn, node, domain, plain, loc, told=operands is None)
    if operands is None:
        return None
    if drawn.whole:
        operands = tuple(_convert_to_integers(reader, bound, (*at, i)) for i, bound in enumerate(operands))
    for condition in drawn.holding(len(operands)):
        if condition.greater is None or condition.less is None:
            number = (condition.less if condition.greater is None else condition.greater) or 0
            # The domains of other roles already limit their operands.
            if drawn.roles[number] == "value":
                _check_limit(reader, operands[number], condition, (*at, number))
    if not _check_equal_lengths(reader, (*operands, *edges), drawn.listed, at):
        return None
    for condition in drawn.holding(len(operands)):
        if condition.less is not None and condition.greater is not None:
            ends = (drawn.operands[condition.less], drawn.operands[condition.greater])
            low, high = operands[condition.less], operands[condition.greater]
            _check_order(reader, low, high, domain, at, whole=drawn.whole, names=ends)
    return forms.DrawForm(key, (*operands, *edges))


def _edges(
    reader: FormReader,
    drawn: Distribution,
    node: dict[str, Any],
    domain: Domain,
    plain: Validate,
    loc: Loc,
    *,
    told: bool,
) -> tuple[Any, ...]:
    """Returns the bounds in the form's companion key; empty if it is missing or invalid."""
    if drawn.companion is None:
        return ()
    if drawn.companion in node:
        place = (*loc, drawn.companion)
        edges = _operands(reader, node[drawn.companion], [domain, domain], plain, place, "[low, high]") or ()
        if edges and _check_equal_lengths(reader, edges, "both bounds", place):
            _check_order(reader, edges[0], edges[1], domain, place)
        return edges
    if told:
        return ()
    hint = f"add `{drawn.companion}: [low, high]`"
    if drawn.needs_companion:
        reader.mistake("SC102", f"`{drawn.key}` needs `{drawn.companion}`", node, loc, hint)
    elif domain.bounded:
        message = f"`{drawn.key}` without `{drawn.companion}` can leave the range of {VALUE_NAME}"
        reader.mistake("SC120", message, node, loc, hint)
    return ()


def _operands(
    reader: FormReader, node: Any, domains: list[Domain], plain: Validate, loc: Loc, names: str
) -> tuple[Any, ...] | None:
    if not is_sequence(node):
        from scenecc.spec.key_hints import flow

        values = [*node.values()] if is_mapping(node) else []
        is_whole = len(values) == len(domains) and all(map(_is_number, values))
        hint = f"write `{loc[-1]}: {flow(values) if is_whole else names}`"
        return reader.mistake("SC103", f"{VALUE_NAME} must be {names}", node, loc, hint)
    count, first = len(domains), domains[0]
    if len(node) != count:
        return reader.mistake("SC106", f"{VALUE_NAME} must have {count} values, {names}, not {len(node)}", node, loc)
    if _have_wrong_length(node, first):
        needed = first.least if first.least == first.most else f"{first.least} to {first.most}"
        return reader.mistake(
            "SC106", f"a bound of {VALUE_NAME} must have {needed} values, not {len(node[0])}", node, loc
        )
    return tuple(_read_bound(reader, node[i], domains[i], plain, (*loc, i)) for i in range(count))


def _have_wrong_length(bounds: Any, domain: Domain) -> bool:
    """Whether all bounds are lists of the same, wrong length, which is reported once."""
    lengths = {len(bound) if is_sequence(bound) else None for bound in bounds}
    length = lengths.pop()
    return not lengths and length is not None and domain.item is not None and not domain.least <= length <= domain.most


def _read_bound(reader: FormReader, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
    """Reads a bound: a number or a list of components. A number applies to all components of a vector."""
    if _is_plain_vector(node, domain):
        with suppress(ValidationError):  # reported by component below
            return tuple(domain.validate_numbers(node))
    if reader.varies(node, domain):
        return reader.leaf(node, domain, plain, loc)
    if isinstance(node, str) and domain.number is None:
        # A colour or an axis. It stays a string, because a colour without alpha takes it from the field.
        return reader.plain(node, plain, loc)
    if isinstance(node, str) or is_mapping(node) or (is_sequence(node) and domain.item is None):
        found = f", not the string {show(node)}" if isinstance(node, str) else ""
        from scenecc.spec.value_hints import kind_hint

        hint = kind_hint("a number", tuple(loc), node)
        return reader.mistake("SC103", f"{VALUE_NAME} must be a number{found}", node, loc, hint)
    if is_sequence(node):
        return reader.vector(node, domain, loc)
    number = reader.plain(node, domain.scalar.validate_number, loc)
    # For a list of any length, the number is broadcast once the length is known.
    as_it_is = domain.number is not None or number is None or not domain.least
    return number if as_it_is else (number,) * domain.least


def _is_plain_vector(node: Any, domain: Domain) -> bool:
    item = domain.item
    return (
        node.__class__ is list
        and item is not None
        and item.number is not None
        and _NUMBER_TYPES.issuperset(map(type, node))
    )


_NUMBER_TYPES = frozenset((float, int))


def _bound_components(bound: Any) -> tuple[Any, ...]:
    if isinstance(bound, forms.Vector):
        return bound.items
    if isinstance(bound, str):
        return AXES[bound] if bound in AXES else to_rgba(bound)
    return tuple(bound) if is_sequence(bound) else (bound,)


def _is_number(part: Any) -> bool:
    return isinstance(part, int | float)


def _convert_to_integers(reader: FormReader, bound: Any, loc: Loc) -> Any:
    """Returns a bound with its numbers converted to integers."""

    def whole(part: Any) -> Any:
        """Converts a number to an integer, or reports it. Anything else is returned unchanged."""
        if not _is_number(part):
            return part
        if not float(part).is_integer():
            reader.mistake("SC104", f"{VALUE_NAME} must be an integer, not {show(part)}", part, loc)
        elif abs(part) > WIDEST_INTEGERS:
            reader.mistake(
                "SC104", f"{VALUE_NAME} must be at most {WIDEST_INTEGERS} (2⁵³) in size, not {show(part)}", part, loc
            )
        else:
            return int(part)
        return part

    parts = tuple(map(whole, _bound_components(bound)))
    if isinstance(bound, str):
        return bound
    if not is_sequence(bound) and not isinstance(bound, forms.Vector):
        return parts[0]
    return parts if is_sequence(bound) else forms.Vector(parts)


def _check_limit(reader: FormReader, bound: Any, condition: OperandRule, loc: Loc) -> None:
    """Reports an operand that violates the limit of a condition."""
    above = condition.greater is not None
    words = ("at least", "greater than") if above else ("at most", "less than")
    numbers = [part for part in _bound_components(bound) if _is_number(part)]
    margins = [(part - condition.limit) * (1 if above else -1) for part in numbers]
    if any(margin < 0 or (condition.strict and margin == 0) for margin in margins):
        wanted = f"{words[condition.strict]} {condition.limit:g}{condition.because}"
        reader.mistake("SC104", f"{VALUE_NAME} must be {wanted}", bound, loc)


def _pair_components(low: Any, high: Any) -> Iterator[tuple[Any, Any]]:
    """Yields the components of two bounds in pairs."""
    lows, highs = _bound_components(low), _bound_components(high)
    if len(lows) == 1 or len(highs) == 1:
        count = max(len(lows), len(highs))
        lows, highs = lows * (count // len(lows)), highs * (count // len(highs))
    # Only a colour may be shorter than the other: its alpha is 1.
    yield from zip_longest(lows, highs, fillvalue=1.0)


def _check_equal_lengths(reader: FormReader, bounds: tuple[Any, ...], what: str, loc: Loc) -> bool:
    """Whether all bounds that are lists have equal lengths. If not, it is reported."""
    lengths = [
        len(_bound_components(bound)) for bound in bounds if is_sequence(bound) or isinstance(bound, forms.Vector)
    ]
    if len(set(lengths)) <= 1:
        return True
    listed = " and ".join(map(str, dict.fromkeys(lengths)))
    reader.mistake("SC106", f"{what} must have equally many values, not {listed}", bounds, loc)
    return False


_OPERAND_WORDS = {"low": "the lower bound", "mode": "the mode", "high": "the upper bound"}


def _check_order(
    reader: FormReader,
    low: Any,
    high: Any,
    domain: Domain,
    loc: Loc,
    *,
    whole: bool = False,
    names: tuple[str, str] = ("low", "high"),
) -> None:
    for a, b in _pair_components(low, high):
        if not (_is_number(a) and _is_number(b)):
            continue
        if whole and WIDEST_INTEGERS <= b - a <= 2 * WIDEST_INTEGERS:
            reader.mistake("SC104", f"{VALUE_NAME} must be among fewer than {WIDEST_INTEGERS} (2⁵³) integers", low, loc)
            return
        if a > b:
            first, second = (_OPERAND_WORDS[name] for name in names)
            ends = [(min(one), max(one)) for one in _pair_components(low, high) if all(map(_is_number, one))]
            is_vector = is_sequence(low) and is_sequence(high) and len(ends) == len(low)
            swapped = [list(one) for one in zip(*ends, strict=True)] if is_vector else [b, a]
            hint = f"write `{loc[-1]}: {swapped}`" if is_vector or (a, b) == (low, high) else None
            reader.mistake("SC119", f"{first} {show(a)} is above {second} {show(b)}", low, loc, hint)
            return
        if domain.nonzero and a <= 0 <= b:
            hint = "for both signs write `choice: [{uniform: [-2, -1]}, {uniform: [1, 2]}]`"
            reader.mistake("SC120", f"{VALUE_NAME} cannot be 0, which lies between the bounds", low, loc, hint)
            return


COMPANIONS = {"choice": "weights", **{key: one.companion for key, one in DISTRIBUTIONS.items() if one.companion}}
"""Form → the key that is allowed beside it."""

DEFAULT = "default"

_POSE_KEYS = frozenset(("p", "q", "rpy", "rpy_deg", "axis_angle", "look_at", "anchor", "relative_to"))

_INDEX = re.compile(r"0|[1-9][0-9]{0,17}")


class FormReader:
    """Reads the forms and expressions of one value.

    Args:
        mistakes: collects errors.
        refused: hint if forms are not allowed here, only expressions; None if forms are allowed.
    """

    _in_once = False

    def __init__(self, mistakes: ErrorCollector, refused: str | None = None) -> None:
        self._mistakes = mistakes
        self._refused = refused

    def mistake(self, code: str, message: str, found: Any, loc: Loc, hint: str | None = None) -> None:
        """Adds an error."""
        self._mistakes.add(custom_error(code, message, hint=hint), found, *loc)

    def leaf(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
        """Reads a value that may vary. `plain` validates it if it does not. Returns None after an error."""
        if is_varying(node):
            return self._form(node, domain, plain, loc) if is_mapping(node) else self._template(node, loc)
        if is_sequence(node) and domain.item is not None and any_varying(node):
            return self.vector(node, domain, loc)
        return self.plain(node, plain, loc)

    def plain(self, node: Any, plain: Validate, loc: Loc) -> Any:
        """Reads a value that does not vary. Returns None after an error."""
        try:
            return plain(node)
        except ValidationError as problem:
            self._mistakes.take(problem, *loc)
            return None

    def _template(self, node: Any, loc: Loc) -> Template | None:
        if isinstance(node, Template):
            return node
        try:
            return parse_template(node)
        except PydanticCustomError as mistake:
            self._mistakes.add(mistake, node, *loc)
            return None

    def varies(self, node: Any, domain: Domain) -> bool:
        """Returns whether a value or one of its components is an expression or a form."""
        if domain.item is None:
            return is_varying(node)
        return any_varying(node)

    def vector(self, node: Any, domain: Domain, loc: Loc) -> Any:
        """Reads a list of numbers, each of which may vary."""
        item = domain.item
        assert item is not None
        if not domain.least <= len(node) <= domain.most:
            self._mistakes.add(wrong_length_error(domain, len(node)), node, *loc)
            return None
        parts = self.components(node, item, loc)
        return forms.Vector(parts) if any(self.varies(part, item) for part in node) else parts

    def components(self, node: Any, item: Domain, loc: Loc) -> tuple[Any, ...]:
        """Reads the components of a list, each of which may vary."""
        return tuple(self.leaf(part, item, self._component(item, loc, i), (*loc, i)) for i, part in enumerate(node))

    def _component(self, item: Domain, loc: Loc, i: int) -> Validate:
        """Returns the validator of a component that does not vary: a number or a list of components."""
        if item.number is not None:
            return item.validate_number

        def row(node: Any) -> Any:
            if not is_sequence(node):
                self._mistakes.add(custom_error("SC103", f"{VALUE_NAME} must be a list of numbers"), node, *loc, i)
                return None
            return self.vector(node, item, (*loc, i))

        return row

    def _form(self, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc) -> Any:
        key, *others = (key for key in node if key in FORM_KEYS)
        if self._refused is not None and key != forms.ONCE:
            return self.mistake("SC116", f"`{key}` is not allowed here", node, (*loc, key), self._refused)
        for other in others:
            message = f"`{key}` and `{other}` are mutually exclusive: write one form"
            self._mistakes.add(custom_error("SC111", message, at="key"), node, *loc, other)
        for other in node:
            if other not in FORM_KEYS and other != COMPANIONS.get(key) and not other.startswith(NOTE_PREFIX):
                self._mistakes.add(_make_key_error(other, key), node, *loc, other)
        if others:
            return None
        if key == forms.ONCE:
            return self._once(node[key], domain, plain, (*loc, key))
        if key in DISTRIBUTIONS and not self._is_expression(node[key]):
            return read_distribution(self, key, node, domain, plain, loc)
        return self._read_list_form(key, node, domain, plain, loc)

    def _once(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
        """Reads the value in `once`. In an expanded document a plain value is returned unchanged."""
        if self._in_once:
            return self.mistake("SC117", "`once` has no effect inside `once`", node, loc, "remove the inner one")
        self._in_once = True
        found = self.leaf(node, domain, plain, loc)
        self._in_once = False
        if isinstance(found, forms.Varying):
            return forms.Once(found)
        if not (found is None or EXPANDED.get()):
            message = "`once` takes a form or an expression, and this value is the same at every reset"
            self.mistake("SC117", message, node, loc, "remove `once`")
        return found

    def _read_list_form(self, key: str, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc) -> Any:
        """Reads a form with listed values, or any form whose list is an expression."""
        given, at = node[key], (*loc, key)
        if self._is_expression(given):
            return self._list(given, at)
        if key == "per_scene":
            return self._per_scene(given, domain, plain, at)
        if key == "shuffle":
            return self._shuffle(given, domain, plain, at)
        items = self._items(given, domain, plain, at)
        if key == "cycle":
            return forms.Cycle(items)
        return forms.Choice(items, self._weights(node, len(items), loc))

    def _shuffle(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
        if not is_sequence(node):
            self._mistakes.add(custom_error("SC103", f"{VALUE_NAME} must be a list of values"), node, *loc)
            return None
        if not 0 < len(node) <= MAX_DRAW_COMPONENTS:
            message = f"{VALUE_NAME} must have 1 to {MAX_DRAW_COMPONENTS} values, not {len(node)}"
            self._mistakes.add(custom_error("SC106", message), node, *loc)
            return None
        if any_varying(node):
            for i, item in enumerate(node):
                if is_varying(item):
                    self._list(item, (*loc, i))
                elif any_varying([item]):
                    self.mistake("SC116", f"{VALUE_NAME} must contain only numbers", item, (*loc, i))
            # The order is drawn after the expressions are evaluated.
            return forms.Shuffle((node[0],))
        # A draw may shuffle strings or booleans, although other forms cannot hold lists of them.
        kinds = set(map(type, node))
        if domain.most == MAX_DRAW_COMPONENTS and kinds in ({str}, {bool}):
            items = tuple(self.plain(item, plain, (*loc, i)) for i, item in enumerate(node))
        else:
            items = tuple(self.plain(node, plain, loc) or ())
        return forms.Shuffle(items)

    def _is_expression(self, node: Any) -> bool:
        return is_varying(node) and not is_mapping(node)

    def _list(self, node: Any, loc: Loc) -> Any:
        """Reads an expression in place of a form's list or weight. Its value is checked after evaluation."""
        if EXPANDED.get() or is_mapping(node):
            return self.mistake("SC116", f"{VALUE_NAME} cannot differ from scene to scene", node, loc)
        return self._template(node, loc)

    def _items(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> tuple[Any, ...]:
        if not is_sequence(node):
            self._mistakes.add(custom_error("SC103", f"{VALUE_NAME} must be a list of values"), node, *loc)
            return ()
        if not node:
            self._mistakes.add(custom_error("SC106", f"{VALUE_NAME} must have at least 1 value, not 0"), node, *loc)
        return tuple(self.leaf(item, domain, plain, (*loc, i)) for i, item in enumerate(node))

    def _per_scene(self, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
        if not is_mapping(node):
            return forms.PerScene(self._items(node, domain, plain, loc))
        items: list[tuple[int, Any]] = []
        default: Any = forms.MISSING
        for key, item in node.items():
            if key.startswith(NOTE_PREFIX):
                continue
            value = self.leaf(item, domain, plain, (*loc, key))
            if key == DEFAULT:
                default = value
            elif _INDEX.fullmatch(key):
                items.append((int(key), value))
            else:
                message = f"`{cut(key)}` is not a scene index"
                hint = "a scene's index (0, 1, …) or `default`"
                self._mistakes.add(custom_error("SC117", message, at="key", hint=hint), item, *loc, key)
        if not node:
            self._mistakes.add(custom_error("SC106", f"{VALUE_NAME} must have at least 1 value, not 0"), node, *loc)
        return forms.SceneMap(tuple(items), default)

    def _weights(self, node: dict[str, Any], count: int, loc: Loc) -> Any:
        if "weights" not in node:
            return None
        weights, at = node["weights"], (*loc, "weights")
        if is_varying(weights):
            return self._list(weights, at)
        if not is_sequence(weights):
            self._mistakes.add(custom_error("SC103", f"{VALUE_NAME} must be a list of numbers"), weights, *at)
            return None
        found = [self._weight(weight, (*at, i)) for i, weight in enumerate(weights)]
        if len(weights) != count:
            self._mistakes.add(
                custom_error("SC106", f"{VALUE_NAME} must have {count} values, one for each choice"), weights, *at
            )
        elif found == [0.0] * count:
            self._mistakes.add(custom_error("SC104", f"{VALUE_NAME} must not all be 0"), weights, *at)
        return tuple(found)

    def _weight(self, node: Any, loc: Loc) -> Any:
        if is_varying(node):
            return self._list(node, loc)
        if isinstance(node, bool) or not isinstance(node, int | float):
            self._mistakes.add(custom_error("SC103", f"{VALUE_NAME} must be a number, not {show(node)}"), node, *loc)
            return None
        if not (math.isfinite(node) and node >= 0):
            message = f"{VALUE_NAME} must be finite and at least 0, not {show(node)}"
            self._mistakes.add(custom_error("SC104", message), node, *loc)
        return float(node)


def wrong_length_error(domain: Domain, count: int) -> PydanticCustomError:
    """Returns the error for a list of wrong length."""
    most = str(domain.most) if domain.least == domain.most else f"{domain.least} to {domain.most}"
    return custom_error("SC106", f"{VALUE_NAME} must have {most} values, not {count}")


def _make_key_error(other: str, key: str) -> PydanticCustomError:
    """Returns the error for a key that is not allowed beside a form."""
    owners = [f"`{form}`" for form, companion in COMPANIONS.items() if other == companion]
    if owners:
        return custom_error("SC117", f"`{other}` is allowed only beside {' or '.join(owners)}", at="key")
    hint = f"a pose that has more than a position is a mapping: `p: {{{key}: …}}`" if other in _POSE_KEYS else None
    return custom_error("SC117", f"`{cut(other)}` is not allowed beside `{key}`", at="key", hint=hint)
