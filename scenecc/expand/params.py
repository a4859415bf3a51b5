"""Parameters: what a file can be given from outside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, show, suggest
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.param_types import KINDS, RANGED, ParamType, kind_of, out_of_range
from scenecc.spec.plain import is_mapping, is_sequence

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.expand.modules import Part
    from scenecc.expand.patterns import Compiler, Pattern
    from scenecc.expand.run import Run

_KEYS = frozenset(("type", "default", "min", "max", "options", "description"))


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter.

    Attributes:
        name: of it.
        kind: its type, one of `KINDS`; None where that of the default's value will tell it.
        default: as written; None where it must be given.
        pattern: of a default that holds expressions.
        low, high: as written; a number, or one for each component of a vector.
        options: of a choice.
        description: for people.
        part: the document in which it is written.
        path: of it there.
        default_path: of its default.
    """

    name: str
    kind: str | None
    default: Any
    pattern: Pattern | None
    low: Any
    high: Any
    options: tuple[Any, ...]
    description: str
    part: Part
    path: Path
    default_path: Path

    def takes(self) -> ParamType | None:
        """What it takes; None where it has no type."""
        if self.kind is None:
            return None
        components = len(self.default) if self.kind == "vector" and is_sequence(self.default) else None
        return ParamType(self.name, self.kind, self.low, self.high, self.options, components)


def read_param(name: str, node: Any, part: Part, compiler: Compiler, run: Run) -> Param | None:
    """One entry of `params`; None where it was reported.

    Args:
        name: of it.
        node: as written, in the long or the short form.
        part: the document in which it is written.
        compiler: of its default.
        run: takes what is wrong.
    """
    path = ("params", name)
    if not is_mapping(node):
        node = {"default": node}
        at = path
    else:
        at = (*path, "default")
    known = {key: value for key, value in node.items() if not key.startswith(NOTE_PREFIX)}
    if not known.keys() <= _KEYS:
        key = next(key for key in known if key not in _KEYS)
        run.report("SC214", f"a parameter has no `{cut(key)}`", (*path, key), at="key", hint=suggest(key, _KEYS))
        return None
    default = known.get("default")
    pattern = None if default is None else compiler.pattern(default, at)
    kind = known["type"] if "type" in known else None if pattern is not None else kind_of(default)
    if not (isinstance(kind, str) and kind in KINDS) and (kind is not None or pattern is None):
        hint = suggest(kind, KINDS) if isinstance(kind, str) else f"give it a `type`: {', '.join(KINDS)}"
        what = f"there is no type {show(kind)}" if kind is not None else f"the type of `{cut(name)}` is not told"
        run.report("SC214", what, (*path, "type") if kind is not None else path, hint=hint)
        return None
    options, description = known.get("options", ()), known.get("description", "")
    if not is_sequence(options) or not isinstance(description, str):
        key, what = ("options", "a list") if not is_sequence(options) else ("description", "a text")
        run.report("SC214", f"`{key}` must be {what}, not {show(known[key])}", (*path, key))
        return None
    param = Param(
        name, kind, default, pattern, known.get("min"), known.get("max"), tuple(options), description, part, path, at
    )
    return param if _is_sound(param, run) else None


def _is_sound(param: Param, run: Run) -> bool:
    """Whether `min`, `max` and `options` go with the type; reported where not."""
    wrong: tuple[str, str] | None = None
    for key, bound in (("min", param.low), ("max", param.high)):
        if bound is None:
            continue
        if param.kind not in RANGED:
            wrong = key, f"a {param.kind or 'parameter without a `type`'} has no `{key}`"
        elif not KINDS["number"][0](bound) and not (param.kind == "vector" and KINDS["vector"][0](bound)):
            wrong = key, f"`{key}` must be a number, not {show(bound)}"
        elif is_sequence(bound) and is_sequence(param.default) and len(bound) != len(param.default):
            wrong = key, f"`{key}` must have {len(param.default)} components, not {len(bound)}"
    if wrong is None and param.low is not None and param.high is not None:
        beyond = out_of_range(param.high, param.low, None) if not is_sequence(param.low) else None
        if beyond is not None:
            wrong = "max", "`max` is below `min`"
    if (param.kind == "choice") is not bool(param.options):
        what = "a choice needs `options`" if param.kind == "choice" else f"a {param.kind} has no `options`"
        wrong = "options", what
    if wrong is not None:
        key, message = wrong
        run.report("SC214", message, (*param.path, key))
    return wrong is None
