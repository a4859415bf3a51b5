"""The forms that draw numbers: their bounds, held to the range of the value that they stand for."""

from __future__ import annotations

from contextlib import suppress
from itertools import zip_longest
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from scenecc.diagnostics.messages import show
from scenecc.spec.domain import Domain
from scenecc.spec.mistakes import THIS
from scenecc.spec.param_types import rgba
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.spec.pose import AXES
from scenecc.variation import forms
from scenecc.variation.distributions import DISTRIBUTIONS, WIDEST_INTEGERS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenecc.diagnostics import PathKey
    from scenecc.spec.forms import FormReader
    from scenecc.variation.distributions import Distribution

    Loc = tuple[PathKey, ...]
    Validate = Callable[[Any], Any]


def read_drawn(reader: FormReader, key: str, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc) -> Any:
    """One of the forms that draw numbers; None where that was a mistake.

    Args:
        reader: of the value.
        key: the form's.
        node: the mapping with the form.
        domain: the numbers that the value may consist of.
        plain: validates the value where it does not vary.
        loc: of the mapping in the value that is validated.
    """
    at = (*loc, key)
    if not domain.of_numbers:
        hint = "of other values `per_scene`, `cycle` and `choice` take one"
        return reader.mistake("SC116", f"`{key}` draws numbers, and nothing else", node, at, hint)
    drawn = DISTRIBUTIONS[key]
    if domain.whole and not drawn.whole:
        hint = f"write `integers: {show(node[key])}`" if key == "uniform" else "`integers: [low, high]` does"
        return reader.mistake("SC116", f"`{key}` draws no whole numbers", node, at, hint)
    of_role = {"value": domain, "mean": domain.means, "deviation": domain.deviations}
    names = f"[{', '.join(drawn.operands)}]"
    operands = _operands(reader, node[key], [of_role[role] for role in drawn.roles], plain, at, names)
    edges = _edges(reader, drawn, node, domain, plain, loc, told=operands is None)
    if operands is None:
        return None
    if drawn.whole:
        operands = tuple(_whole(reader, bound, (*at, i)) for i, bound in enumerate(operands))
    for condition in drawn.holding(len(operands)):
        if condition.strict and condition.less is None:
            _positive(reader, operands[condition.greater], condition.because, (*at, condition.greater))
    if not _as_many(reader, (*operands, *edges), drawn.listed, at):
        return None
    for condition in drawn.holding(len(operands)):
        if condition.less is not None:
            _ordered(reader, operands[condition.less], operands[condition.greater], domain, at, whole=drawn.whole)
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
    """The edges of the key beside the form; none where it is left out, or wrong. `told`: the form is wrong itself."""
    if drawn.companion is None:
        return ()
    if drawn.companion in node:
        place = (*loc, drawn.companion)
        edges = _operands(reader, node[drawn.companion], [domain, domain], plain, place, "[low, high]") or ()
        if edges and _as_many(reader, edges, "both bounds", place):
            _ordered(reader, edges[0], edges[1], domain, place)
        return edges
    if domain.bounded and not told:
        message = f"`{drawn.key}` without `{drawn.companion}` can leave the range of {THIS}"
        reader.mistake("SC120", message, node, loc, f"add `{drawn.companion}: [low, high]`")
    return ()


def _operands(
    reader: FormReader, node: Any, domains: list[Domain], plain: Validate, loc: Loc, names: str
) -> tuple[Any, ...] | None:
    if not is_sequence(node):
        return reader.mistake("SC103", f"{THIS} must be {names}", node, loc)
    count, first = len(domains), domains[0]
    if len(node) != count:
        return reader.mistake("SC106", f"{THIS} must have {count} values, {names}, not {len(node)}", node, loc)
    if _are_misfits(node, first):
        needed = first.least if first.least == first.most else f"{first.least} to {first.most}"
        return reader.mistake("SC106", f"a bound of {THIS} must have {needed} values, not {len(node[0])}", node, loc)
    return tuple(_bound(reader, node[i], domains[i], plain, (*loc, i)) for i in range(count))


def _are_misfits(bounds: Any, domain: Domain) -> bool:
    """Whether all are lists of one length that the value does not have: one mistake."""
    lengths = {len(bound) if is_sequence(bound) else None for bound in bounds}
    length = lengths.pop()
    return not lengths and length is not None and domain.item is not None and not domain.least <= length <= domain.most


def _bound(reader: FormReader, node: Any, domain: Domain, plain: Validate, loc: Loc) -> Any:
    """A bound: a number, or a list of one for each component. A number stands for all components of a vector."""
    if _is_plain_vector(node, domain):
        with suppress(ValidationError):  # which is told of each component below
            return tuple(domain.validate_numbers(node))
    if reader.varies(node, domain):
        return reader.leaf(node, domain, plain, loc)
    if isinstance(node, str) and domain.number is None:
        # A colour or an axis. It stays as it is written, since a colour may leave its alpha to the field.
        return reader.plain(node, plain, loc)
    if isinstance(node, str) or is_mapping(node) or (is_sequence(node) and domain.item is None):
        found = f", not the text {show(node)}" if isinstance(node, str) else ""
        return reader.mistake("SC103", f"{THIS} must be a number{found}", node, loc)
    if is_sequence(node):
        return reader.vector(node, domain, loc)
    number = reader.plain(node, domain.scalar.validate_number, loc)
    # Of a list of any length it is broadcast once that is known.
    as_it_is = domain.number is not None or number is None or not domain.least
    return number if as_it_is else (number,) * domain.least


def _is_plain_vector(node: Any, domain: Domain) -> bool:
    item = domain.item
    return (
        node.__class__ is list and item is not None and item.number is not None and _NUMBERS.issuperset(map(type, node))
    )


_NUMBERS = frozenset((float, int))


def _numbers(bound: Any) -> tuple[Any, ...]:
    if isinstance(bound, forms.Vector):
        return bound.items
    if isinstance(bound, str):
        return AXES[bound] if bound in AXES else rgba(bound)
    return tuple(bound) if is_sequence(bound) else (bound,)


def _is_number(part: Any) -> bool:
    return isinstance(part, int | float)


def _whole(reader: FormReader, bound: Any, loc: Loc) -> Any:
    """The same bound with integers for its numbers."""

    def whole(part: Any) -> Any:
        """One number as an integer; as it was, reported, where it is none, and what is no number untouched."""
        if not _is_number(part):
            return part
        if not float(part).is_integer():
            reader.mistake("SC104", f"{THIS} must be whole, not {show(part)}", part, loc)
        elif abs(part) > WIDEST_INTEGERS:
            reader.mistake(
                "SC104", f"{THIS} must be at most {WIDEST_INTEGERS} (2⁵³) in size, not {show(part)}", part, loc
            )
        else:
            return int(part)
        return part

    parts = tuple(map(whole, _numbers(bound)))
    if isinstance(bound, str):
        return bound
    if not is_sequence(bound) and not isinstance(bound, forms.Vector):
        return parts[0]
    return parts if is_sequence(bound) else forms.Vector(parts)


def _positive(reader: FormReader, bound: Any, because: str, loc: Loc) -> None:
    if any(_is_number(part) and part <= 0 for part in _numbers(bound)):
        reader.mistake("SC104", f"{THIS} must be greater than 0{because}", bound, loc)


def _facing(low: Any, high: Any) -> Iterator[tuple[Any, Any]]:
    """The components of two bounds, side by side."""
    lows, highs = _numbers(low), _numbers(high)
    if len(lows) == 1 or len(highs) == 1:
        count = max(len(lows), len(highs))
        lows, highs = lows * (count // len(lows)), highs * (count // len(highs))
    # Only a colour may be shorter than the other: its alpha is 1.
    yield from zip_longest(lows, highs, fillvalue=1.0)


def _as_many(reader: FormReader, bounds: tuple[Any, ...], what: str, loc: Loc) -> bool:
    """Whether those of the bounds that are lists are of one length; otherwise that is a mistake."""
    lengths = [len(_numbers(bound)) for bound in bounds if is_sequence(bound) or isinstance(bound, forms.Vector)]
    if len(set(lengths)) <= 1:
        return True
    listed = " and ".join(map(str, dict.fromkeys(lengths)))
    reader.mistake("SC106", f"{what} must have as many values, not {listed}", bounds, loc)
    return False


def _ordered(reader: FormReader, low: Any, high: Any, domain: Domain, loc: Loc, *, whole: bool = False) -> None:
    for a, b in _facing(low, high):
        if not (_is_number(a) and _is_number(b)):
            continue
        if whole and WIDEST_INTEGERS <= b - a <= 2 * WIDEST_INTEGERS:
            reader.mistake("SC104", f"{THIS} must be among fewer than {WIDEST_INTEGERS} (2⁵³) integers", low, loc)
            return
        if a > b:
            reader.mistake("SC119", f"the lower bound {show(a)} is above the upper bound {show(b)}", low, loc)
            return
        if domain.nonzero and a <= 0 <= b:
            hint = "for both signs write `choice: [{uniform: [-2, -1]}, {uniform: [1, 2]}]`"
            reader.mistake("SC120", f"{THIS} cannot be 0, which lies between the bounds", low, loc, hint)
            return
