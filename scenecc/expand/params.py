"""Parameters: declarations, checks of varying values, and unused ones."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import Origin
from scenecc.diagnostics.messages import cut, listed, show
from scenecc.expand.documents import iterate_texts
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import EXPRESSION_START, is_mapping, is_sequence
from scenecc.spec.params import (
    PARAM_KINDS,
    RANGED_KINDS,
    ParamType,
    describe_range_error,
    infer_param_kind,
    is_finite_number,
)
from scenecc.variation.distributions import DISTRIBUTIONS
from scenecc.variation.forms import FORM_KEYS, ONCE, Template
from scenecc.variation.operations import ExpressionError

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Path
    from scenecc.expand.expansion import ExpansionFrame
    from scenecc.expand.modules import ModulePart
    from scenecc.expand.patterns import Pattern, PatternCompiler
    from scenecc.source import Document
    from scenecc.spec.params import ParamIssue


_PARAM_KEYS = ("type", "default", "min", "max", "options", "description")


@dataclass(frozen=True, slots=True)
class Param:
    """The declaration of a parameter.

    Attributes:
        name: its name.
        kind: its type, one of `PARAM_KINDS`; None if it follows from the evaluated default.
        default: the unevaluated default; None if a value is required.
        pattern: pattern of a default with expressions.
        low, high: `min` and `max`: a number, or one per component of a vector.
        options: options of a choice.
        description: its description.
        part: its document.
        path: its path in the document.
        default_path: path of the default.
    """

    name: str
    kind: str | None
    default: Any
    pattern: Pattern | None
    low: Any
    high: Any
    options: tuple[Any, ...]
    description: str
    part: ModulePart
    path: Path
    default_path: Path

    def takes(self) -> ParamType | None:
        """Returns the parameter's type; None if it is unknown."""
        if self.kind is None:
            return None
        components = len(self.default) if self.kind == "vector" and is_sequence(self.default) else None
        return ParamType(self.name, self.kind, self.low, self.high, self.options, components)


def read_param(
    name: str, node: Any, part: ModulePart, compiler: PatternCompiler, frame: ExpansionFrame
) -> Param | None:
    """Reads an entry of `params`, a mapping or only the default. Returns None after a reported error."""
    path = ("params", name)
    if not is_mapping(node):
        node = {"default": node}
        at = path
    else:
        at = (*path, "default")
    known = {key: value for key, value in node.items() if not key.startswith(NOTE_PREFIX)}
    if unknown := next((key for key in known if key not in _PARAM_KEYS), None):
        hint = _unknown_word_hint(unknown, _PARAM_KEYS)
        frame.report("SC214", f"a parameter has no `{cut(unknown)}`", (*path, unknown), at="key", hint=hint)
        return None
    default = known.get("default")
    pattern = None if default is None else compiler.pattern(default, at)
    kind = known["type"] if "type" in known else None if pattern is not None else infer_param_kind(default)
    if not (isinstance(kind, str) and kind in PARAM_KINDS) and (kind is not None or pattern is None):
        words = "write `type: number`, or another type"
        hint = _unknown_word_hint(kind, tuple(PARAM_KINDS)) if isinstance(kind, str) else words
        what = f"there is no type {show(kind)}" if kind is not None else f"the type of `{cut(name)}` is missing"
        frame.report("SC214", what, (*path, "type") if kind is not None else path, hint=hint)
        return None
    options, description = known.get("options", ()), known.get("description", "")
    if not is_sequence(options) or not isinstance(description, str):
        key, what = ("options", "a list") if not is_sequence(options) else ("description", "a text")
        frame.report("SC214", f"`{key}` must be {what}, not {show(known[key])}", (*path, key))
        return None
    param = Param(
        name, kind, default, pattern, known.get("min"), known.get("max"), tuple(options), description, part, path, at
    )
    return param if _is_sound(param, frame) else None


def _unknown_word_hint(word: str, known: tuple[str, ...]) -> str | None:
    """Returns a hint for an unknown key or type of a parameter."""
    from scenecc.spec.key_hints import suggest_key  # noqa: PLC0415 - for errors
    from scenecc.spec.value_hints import choice_hint  # noqa: PLC0415 - for errors

    near = suggest_key(word, known)
    return choice_hint(word, known) or (f"did you mean `{near}`?" if near else listed(known, word))


def _is_sound(param: Param, frame: ExpansionFrame) -> bool:
    """Whether `min`, `max` and `options` fit the type. If not, it is reported."""
    wrong: tuple[str, str] | None = None
    for key, bound in (("min", param.low), ("max", param.high)):
        if bound is None:
            continue
        if param.kind not in RANGED_KINDS:
            wrong = key, f"a {param.kind or 'parameter without a `type`'} has no `{key}`"
        elif not PARAM_KINDS["number"][0](bound) and not (param.kind == "vector" and PARAM_KINDS["vector"][0](bound)):
            wrong = key, f"`{key}` must be a number, not {show(bound)}"
        elif is_sequence(bound) and is_sequence(param.default) and len(bound) != len(param.default):
            wrong = key, f"`{key}` must have {len(param.default)} components, not {len(bound)}"
    if wrong is None and param.low is not None and param.high is not None:
        shared = is_sequence(param.low) and not is_sequence(param.high)
        high = [param.high] * len(param.low) if shared else param.high
        if describe_range_error(high, param.low, None) is not None:
            wrong = "max", "`max` is below `min`"
    if (param.kind == "choice") is not bool(param.options):
        what = "a choice needs `options`" if param.kind == "choice" else f"a {param.kind} has no `options`"
        wrong = "options", what
    if wrong is not None:
        key, message = wrong
        frame.report("SC214", message, (*param.path, key))
    return wrong is None


_INTEGER_KINDS = frozenset(("number", "integer", "vector"))
"""Parameter types that `integers` can draw."""

_NUMBER_KINDS = frozenset(("number", "vector", "color"))
"""Parameter types that the other distributions can draw."""


def form_key(value: Any) -> str | None:
    """Returns the key of a form of variation; None if the value is not a form."""
    if not is_mapping(value):
        return None
    return next((key for key in value if key in FORM_KEYS), None)


def varying_misfit(value: Any, wanted: ParamType) -> ParamIssue | None:
    """Checks a varying value against a type without evaluating expressions. Returns the first error or None."""
    if isinstance(value, Template):
        return None
    form = form_key(value)
    if form is None:
        return _check_parts(value, wanted) if _has_varying_parts(value) else wanted.misfit(value)
    if form in DISTRIBUTIONS:
        return _check_distribution(form, value, wanted)
    return next((wrong for item in _form_items(form, value[form]) if (wrong := varying_misfit(item, wanted))), None)


def _has_varying_parts(value: Any) -> bool:
    return is_sequence(value) and any(isinstance(part, Template) or form_key(part) for part in value)


def _check_parts(value: Any, wanted: ParamType) -> ParamIssue | None:
    """Checks a list with varying components."""
    numbers = _convert_to_vector(wanted)
    if numbers is None:
        return None if wanted.kind == "list" else ("SC211", f"must be {PARAM_KINDS[wanted.kind][1]}, not a list")
    return _check_length(value, wanted) or _check_components(value, numbers)


def _convert_to_vector(wanted: ParamType) -> ParamType | None:
    """Returns a colour or vector type as a vector type; None for other types."""
    if wanted.kind == "color":
        return replace(wanted, kind="vector", low=0, high=1)
    return wanted if wanted.kind == "vector" else None


def _check_length(value: Any, wanted: ParamType) -> ParamIssue | None:
    if wanted.kind == "color" and len(value) not in {3, 4}:
        return "SC211", f"must have 3 or 4 components, not {len(value)}"
    if wanted.components not in {None, len(value)}:
        return "SC211", f"must have {wanted.components} components, not {len(value)}"
    return None


def _check_components(value: Any, vector: ParamType) -> ParamIssue | None:
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


def _check_distribution(form: str, value: dict[str, Any], wanted: ParamType) -> ParamIssue | None:
    """Checks a distribution: that the type allows it, and that its bounds fit the type and range."""
    drawn = DISTRIBUTIONS[form]
    if wanted.kind not in (_INTEGER_KINDS if drawn.whole else _NUMBER_KINDS):
        return "SC211", f"must be {PARAM_KINDS[wanted.kind][1]}, which `{form}` does not draw"
    bounds = value[form]
    if not is_sequence(bounds):
        return None
    limits = _convert_to_vector(wanted) or replace(wanted, kind="number")
    beside: Any = value.get(str(drawn.companion))
    edges = beside if is_sequence(beside) else ()
    if limits.kind == "vector" and all(map(is_finite_number, (*bounds, *edges))):
        return "SC211", f"must be {PARAM_KINDS[wanted.kind][1]}: a bound of `{form}` must be a list of numbers"
    if drawn.companion is None:
        return _check_bounds(bounds, limits, wanted)
    wrong = _check_bounds(bounds, replace(limits, low=None, high=None), wanted)
    if wrong is None and drawn.companion not in value and limits.ranged:
        return "SC212", f"must stay in its range, but a {form} draw is unbounded: it needs `{drawn.companion}`"
    return wrong or _check_bounds(edges, limits, wanted)


def _check_bounds(bounds: Any, limits: ParamType, wanted: ParamType) -> ParamIssue | None:
    return next((wrong for bound in bounds if (wrong := _check_bound(bound, limits, wanted))), None)


def _check_bound(bound: Any, limits: ParamType, wanted: ParamType) -> ParamIssue | None:
    """Checks a bound: a number, or a list of components for a vector. `limits` is `wanted` as numbers."""
    if isinstance(bound, Template):
        return None
    if limits.kind == "number":
        return varying_misfit(bound, limits)
    form = form_key(bound)
    if form is not None:
        return _check_bounds(_form_items(form, bound[form]), limits, wanted)
    if is_sequence(bound):
        return _check_length(bound, wanted) or _check_components(bound, limits)
    if not is_finite_number(bound):
        return "SC211", f"must be drawn between lists of numbers, not {show(bound)}"
    # A number applies to every component.
    count = max((len(limit) for limit in (limits.low, limits.high) if is_sequence(limit)), default=1)
    return limits.outside([bound] * count, [bound] * count)


def _form_items(form: str, given: Any) -> list[Any]:
    """Returns the values in a form."""
    if form == ONCE:
        return [given]
    if is_mapping(given):
        return [item for key, item in given.items() if not key.startswith(NOTE_PREFIX)]
    return list(given) if is_sequence(given) else []


_UNUSED = {"params": ("SC322", "parameter"), "draws": ("SC319", "draw")}


def report_unread_names(documents: Sequence[Document], lowered: Collection[str], sink: Sink) -> None:
    """Warns about each parameter and shared draw that no expression reads.

    Args:
        documents: the top document and its includes, which share its parameters.
        lowered: draws that remain after expansion; lowering reports these.
        sink: receives the warnings.
    """
    declared = [
        (section, name, document.name)
        for document in documents
        for section in _UNUSED
        if is_mapping(entries := document.data.get(section))
        for name in entries
        if not name.startswith(NOTE_PREFIX) and (section != "draws" or name not in lowered)
    ]
    if not declared:
        return
    read: set[str] = set()
    for document in documents:
        for text in iterate_texts(document.data):
            if EXPRESSION_START in text:
                read.update(_read_names(text))
    for section, name, file in declared:
        if name not in read:
            code, what = _UNUSED[section]
            sink.report(code, f"the {what} `{cut(name)}` is never read", Origin(file, (section, name)), at="key")


def _read_names(text: str) -> set[str]:
    """Returns the names that the expressions in a string read; empty if it is not a valid expression."""
    try:
        template = Template.parse(text)
    except ExpressionError:
        return set()
    return {*template.names, *(name for path in template.meshes.values() for name in path.places)}
