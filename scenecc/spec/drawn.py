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

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from scenecc.diagnostics import PathKey
    from scenecc.spec.forms import FormReader

    Loc = tuple[PathKey, ...]
    Validate = Callable[[Any], Any]

_WIDEST = 2**53
"""Integers up to here are drawn: those that are exact as numbers with a fraction."""


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
    if domain.whole and key != "integers":
        hint = f"write `integers: {show(node[key])}`" if key == "uniform" else "`integers: [low, high]` does"
        return reader.mistake("SC116", f"`{key}` draws no whole numbers", node, at, hint)
    if key == "normal":
        return _normal(reader, node, domain, plain, loc)
    pair = _pair(reader, node[key], domain, domain, plain, at, "[low, high]")
    if pair is None:
        return None
    low, high = pair
    if key == "integers":
        low, high = (_whole(reader, bound, (*at, i)) for i, bound in enumerate(pair))
    elif key == "log_uniform":
        for i, bound in enumerate(pair):
            _positive(reader, bound, (*at, i))
    _ordered(reader, low, high, domain, at, whole=key == "integers")
    return forms.DISTRIBUTIONS[key](low, high)


def _normal(reader: FormReader, node: dict[str, Any], domain: Domain, plain: Validate, loc: Loc) -> Any:
    at = (*loc, "normal")
    pair = _pair(reader, node["normal"], domain.means, domain.deviations, plain, at, "[mean, std]")
    clip = None
    if "clip" in node:
        clip = _pair(reader, node["clip"], domain, domain, plain, (*loc, "clip"), "[low, high]")
        if clip is not None:
            _ordered(reader, *clip, domain, (*loc, "clip"))
    elif domain.bounded and pair is not None:
        hint = "add `clip: [low, high]`"
        reader.mistake("SC120", f"`normal` without `clip` can leave the range of {THIS}", node, loc, hint)
    if pair is None or not _as_many(reader, (*pair, *(clip or ())), "mean, std and clip", at):
        return None
    return forms.Normal(*pair, clip)


def _pair(
    reader: FormReader, node: Any, first: Domain, second: Domain, plain: Validate, loc: Loc, names: str
) -> tuple[Any, Any] | None:
    if not is_sequence(node):
        return reader.mistake("SC103", f"{THIS} must be {names}", node, loc)
    if len(node) != 2:
        return reader.mistake("SC106", f"{THIS} must have 2 values, {names}, not {len(node)}", node, loc)
    if _are_misfits(node, first):
        needed = first.least if first.least == first.most else f"{first.least} to {first.most}"
        return reader.mistake("SC106", f"a bound of {THIS} must have {needed} values, not {len(node[0])}", node, loc)
    return _bound(reader, node[0], first, plain, (*loc, 0)), _bound(reader, node[1], second, plain, (*loc, 1))


def _are_misfits(bounds: Any, domain: Domain) -> bool:
    """Whether both are lists of one length that the value does not have: one mistake."""
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
        elif abs(part) > _WIDEST:
            reader.mistake("SC104", f"{THIS} must be at most {_WIDEST} (2⁵³) in size, not {show(part)}", part, loc)
        else:
            return int(part)
        return part

    parts = tuple(map(whole, _numbers(bound)))
    if isinstance(bound, str):
        return bound
    if not is_sequence(bound) and not isinstance(bound, forms.Vector):
        return parts[0]
    return parts if is_sequence(bound) else forms.Vector(parts)


def _positive(reader: FormReader, bound: Any, loc: Loc) -> None:
    if any(_is_number(part) and part <= 0 for part in _numbers(bound)):
        reader.mistake("SC104", f"{THIS} must be greater than 0 for its logarithm to be drawn", bound, loc)


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
    if not _as_many(reader, (low, high), "both bounds", loc):
        return
    for a, b in _facing(low, high):
        if not (_is_number(a) and _is_number(b)):
            continue
        if whole and _WIDEST <= b - a <= 2 * _WIDEST:
            reader.mistake("SC104", f"{THIS} must be among fewer than {_WIDEST} (2⁵³) integers", low, loc)
            return
        if a > b:
            reader.mistake("SC119", f"the lower bound {show(a)} is above the upper bound {show(b)}", low, loc)
            return
        if domain.nonzero and a <= 0 <= b:
            hint = "for both signs write `choice: [{uniform: [-2, -1]}, {uniform: [1, 2]}]`"
            reader.mistake("SC120", f"{THIS} cannot be 0, which lies between the bounds", low, loc, hint)
            return
