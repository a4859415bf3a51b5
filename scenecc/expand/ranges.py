"""What a varying value may be, as far as its form tells: every alternative and every bound."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from scenecc.expand.kinds import is_number, is_vector, out_of_range
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.values.template import Template

Misfit = tuple[str, str]
"""A code, and what is wrong in words."""

_LISTED = ("cycle", "choice")
_BOUNDED = ("uniform", "integers", "log_uniform")


def alternatives(value: Any) -> Iterator[Any]:
    """The plain values that a varying one may be, where its form lists them; forms that draw numbers list none."""
    if isinstance(value, Template):
        return
    form = form_of(value)
    if form is None:
        yield value
        return
    items = value[form]
    if form in _LISTED or (form == "per_scene" and is_sequence(items)):
        for item in items if is_sequence(items) else ():
            yield from alternatives(item)
    elif form == "per_scene" and is_mapping(items):
        for item in items.values():
            yield from alternatives(item)


def form_of(value: Any) -> str | None:
    """The key of a form of variation; None of anything else."""
    if not is_mapping(value):
        return None
    return next((key for key in value if key in VARIATION_FORMS), None)


def first_misfit(value: Any, misfit: Callable[[Any], Misfit | None]) -> Misfit | None:
    """What is wrong with the first alternative that is wrong. A list of which a part varies is left out."""
    for item in alternatives(value):
        if not (is_sequence(item) and any(isinstance(part, Template) or form_of(part) for part in item)):
            wrong = misfit(item)
            if wrong is not None:
                return wrong
    return None


def bounds_outside(value: Any, low: Any, high: Any) -> Misfit | None:
    """What is wrong with the bounds of forms that draw numbers, where they leave a range."""
    if low is None and high is None:
        return None
    form = form_of(value)
    if form is None:
        return None
    given = value[form]
    if form in _BOUNDED:
        return _outside(given, low, high)
    if form == "normal":
        if "clip" in value:
            return _outside(value["clip"], low, high)
        return "SC212", "must stay in a range, which a normal draw leaves: it needs `clip`"
    inner = given.values() if is_mapping(given) else given if is_sequence(given) else ()
    return next((wrong for item in inner if (wrong := bounds_outside(item, low, high))), None)


def _outside(ends: Any, low: Any, high: Any) -> Misfit | None:
    for end in ends if is_sequence(ends) else ():
        if is_number(end) or is_vector(end):
            wrong = out_of_range(end, low, high)
            if wrong is not None:
                return "SC212", wrong
    return None
