"""Whether a varying value fits its parameter, as far as its form tells: every alternative and every bound."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import show
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.features import VARIATION_FORMS
from scenecc.spec.param_types import KINDS, ParamType, is_number
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.values.forms import DRAWN
from scenecc.values.template import Template

if TYPE_CHECKING:
    from scenecc.spec.param_types import Misfit

_WHOLE = frozenset(("number", "integer", "vector"))
"""Types of parameters that what `integers` draws is of."""

_NUMBERS = frozenset(("number", "vector", "color"))
"""Types of parameters that what the other forms draw is of which draw numbers."""


def form_of(value: Any) -> str | None:
    """The key of a form of variation; None of anything else."""
    if not is_mapping(value):
        return None
    return next((key for key in value if key in VARIATION_FORMS), None)


def varying_misfit(value: Any, wanted: ParamType) -> Misfit | None:
    """What is wrong with a value that varies; None where nothing is, as far as can be told without expressions."""
    if isinstance(value, Template):
        return None
    form = form_of(value)
    if form is None:
        return _parts_misfit(value, wanted) if _has_varying_parts(value) else wanted.misfit(value)
    if form in DRAWN:
        return _drawn_misfit(form, value, wanted)
    return next((wrong for item in _items(value[form]) if (wrong := varying_misfit(item, wanted))), None)


def _has_varying_parts(value: Any) -> bool:
    return is_sequence(value) and any(isinstance(part, Template) or form_of(part) for part in value)


def _parts_misfit(value: Any, wanted: ParamType) -> Misfit | None:
    """Of a list some of whose components vary."""
    numbers = _numbers(wanted)
    if numbers is None:
        return None if wanted.kind == "list" else ("SC211", f"must be {KINDS[wanted.kind][1]}, not a list")
    return _length_misfit(value, wanted) or _components_misfit(value, numbers)


def _numbers(wanted: ParamType) -> ParamType | None:
    """A colour as the vector that it is; None of what is no vector."""
    if wanted.kind == "color":
        return replace(wanted, kind="vector", low=0, high=1)
    return wanted if wanted.kind == "vector" else None


def _length_misfit(value: Any, wanted: ParamType) -> Misfit | None:
    if wanted.kind == "color" and len(value) not in {3, 4}:
        return "SC211", f"must have 3 or 4 components, not {len(value)}"
    if wanted.components not in {None, len(value)}:
        return "SC211", f"must have {wanted.components} components, not {len(value)}"
    return None


def _components_misfit(value: Any, vector: ParamType) -> Misfit | None:
    for index, part in enumerate(value):
        low, high = (_component(bound, index) for bound in (vector.low, vector.high))
        wrong = varying_misfit(part, replace(vector, kind="number", low=low, high=high))
        if wrong is not None:
            code, words = wrong
            return code, f"has a wrong component {index}: it {words}"
    return None


def _component(bound: Any, index: int) -> Any:
    if not is_sequence(bound):
        return bound
    return bound[index] if index < len(bound) else None


def _drawn_misfit(form: str, value: dict[str, Any], wanted: ParamType) -> Misfit | None:
    """Of a form that draws numbers: whether it is the type's, its bounds are, and they lie in the range."""
    if wanted.kind not in (_WHOLE if form == "integers" else _NUMBERS):
        return "SC211", f"must be {KINDS[wanted.kind][1]}, which `{form}` does not draw"
    bounds, clip = value[form], value.get("clip", ())
    if not is_sequence(bounds):
        return None
    limits = _numbers(wanted) or replace(wanted, kind="number")
    if limits.kind == "vector" and all(map(is_number, bounds)):
        return "SC211", f"must be {KINDS[wanted.kind][1]}: a bound of `{form}` must be a list of numbers"
    if form != "normal":
        return _first_bound_misfit(bounds, limits, wanted)
    wrong = _first_bound_misfit(bounds, replace(limits, low=None, high=None), wanted)
    if wrong is None and "clip" not in value and limits.ranged:
        return "SC212", "must stay in a range, which a normal draw leaves: it needs `clip`"
    return wrong or _first_bound_misfit(clip if is_sequence(clip) else (), limits, wanted)


def _first_bound_misfit(bounds: Any, limits: ParamType, wanted: ParamType) -> Misfit | None:
    return next((wrong for bound in bounds if (wrong := _bound_misfit(bound, limits, wanted))), None)


def _bound_misfit(bound: Any, limits: ParamType, wanted: ParamType) -> Misfit | None:
    """Of a bound: a number; of a vector a list of one for each component, too. `limits`: `wanted` as numbers."""
    if isinstance(bound, Template):
        return None
    if limits.kind == "number":
        return varying_misfit(bound, limits)
    form = form_of(bound)
    if form is not None:
        return _first_bound_misfit(_items(bound[form]), limits, wanted)
    if is_sequence(bound):
        return _length_misfit(bound, wanted) or _components_misfit(bound, limits)
    if not is_number(bound):
        return "SC211", f"must be drawn between lists of numbers, not {show(bound)}"
    # It stands for every component.
    count = max((len(limit) for limit in (limits.low, limits.high) if is_sequence(limit)), default=1)
    return limits.outside([bound] * count, [bound] * count)


def _items(given: Any) -> list[Any]:
    """What a form holds."""
    if is_mapping(given):
        return [item for key, item in given.items() if not key.startswith(NOTE_PREFIX)]
    return list(given) if is_sequence(given) else []
