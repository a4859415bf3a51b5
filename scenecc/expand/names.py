"""What the names in the expressions of a document stand for."""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.messages import cut, suggest
from scenecc.values.expression import RESERVED
from scenecc.values.failure import ExpressionError

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.expand.run import Run
    from scenecc.values.template import Template

Meaning = Literal[
    "parameter", "loop variable", "draw", "later draw", "later parameter", "later loop variable", "itself", "constant"
]
"""`later` ones, and `itself`, may be read elsewhere, but not in the draw, default or loop at hand."""

DEFAULT = "a default"
"""What a parameter's default decides about."""

_BARRED = frozenset(("later draw", "later parameter", "later loop variable", "itself"))

BUILTIN: dict[str, Meaning] = {"num_scenes": "constant", "scene": "draw"}

Names = Mapping[str, Meaning]
"""The names that an expression may read."""


def check_names(template: Template, names: Names, path: Path, run: Run, *, structure: str | None = None) -> bool:
    """Whether a template reads only names that mean something where it stands; what does not is reported.

    Args:
        template: at hand.
        names: that mean something.
        path: of its scalar.
        run: whose document it is in.
        structure: what it decides about, where that may not differ from scene to scene: "`repeat`".
    """
    good = True
    for name in sorted(template.names):
        meaning = names.get(name)
        if meaning is None or meaning in _BARRED:
            good = False
            run.fail(_unknown(name, names, template, structure), path, "SC201")
        elif structure is not None and meaning == "draw":
            good = False
            run.fail(_varying(name, structure, template), path, "SC203")
    return good


def check_free(name: str, what: str, names: Names, path: Path, run: Run) -> bool:
    """Whether a parameter, draw or loop variable may have a name; reported where not."""
    if name in RESERVED or keyword.iskeyword(name):
        message = f"`{cut(name)}` means something in expressions, so no {what} is called that"
    elif name in names:
        message = f"`{cut(name)}` is the name of a {names[name].removeprefix('later ')} already"
    else:
        return True
    run.report("SC204", message, path, at="key", hint="choose another name")
    return False


def _unknown(name: str, names: Names, template: Template, structure: str | None) -> ExpressionError:
    shown, place = f"`{cut(name)}`", template.place(name)
    match names.get(name):
        case None:
            refused = _BARRED if structure is None else _BARRED | {"draw"}
            known = [known for known, meaning in names.items() if meaning not in refused and known not in BUILTIN]
            builtin = [known for known, meaning in BUILTIN.items() if meaning not in refused]
            return ExpressionError(f"unknown name {shown}", *place, suggest(name, (*known, *builtin)))
        case "itself":
            return ExpressionError(f"{shown} reads itself", *place, "it may read those above it")
        case "later loop variable":
            hint = "its lists are the same whatever the others give; `if` can leave members of the product out"
            return ExpressionError(f"{shown} is a loop variable of the same `repeat`", *place, hint)
        case meaning:
            what = (meaning or "").removeprefix("later ")
            hint = f"a {what} may read those above it"
            return ExpressionError(f"the {what} {shown} is defined further down", *place, hint)


def _varying(name: str, structure: str, template: Template) -> ExpressionError:
    if structure == DEFAULT and name != "scene":
        hint = "a draw may read parameters: declare this one under `draws`"
        return ExpressionError(f"`{cut(name)}` is a draw: a parameter cannot read it", *template.place(name), hint)
    what = "the scene's index" if name == "scene" else f"the draw `{cut(name)}`"
    hint = "only values may: a parameter can decide here, or `variants` with `pick`"
    message = f"{structure} is the same in every scene, so it cannot read {what}"
    return ExpressionError(message, *template.place(name), hint)
