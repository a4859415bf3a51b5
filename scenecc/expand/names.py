"""What the names in the expressions of a document stand for."""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

from scenecc.diagnostics.words import cut, suggest
from scenecc.values.expression import RESERVED
from scenecc.values.failure import ExpressionError

if TYPE_CHECKING:
    from scenecc.diagnostics import Path
    from scenecc.expand.run import Run
    from scenecc.values.template import Template

Meaning = Literal["parameter", "loop variable", "draw", "later draw", "later parameter", "constant"]
"""`later` ones may be read elsewhere, but not in the draw or default at hand."""

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
        if meaning is None or meaning.startswith("later"):
            good = False
            run.fail(_unknown(name, meaning, names, template), path, "SC201")
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


def _unknown(name: str, meaning: Meaning | None, names: Names, template: Template) -> ExpressionError:
    if meaning is not None:
        what = meaning.removeprefix("later ")
        hint = f"a {what} may read those above it"
        return ExpressionError(f"the {what} `{cut(name)}` is defined further down", *template.place(name), hint)
    known = [known for known, meaning in names.items() if not meaning.startswith("later") and known not in BUILTIN]
    hint = suggest(name, (*known, *BUILTIN))
    return ExpressionError(f"unknown name `{cut(name)}`", *template.place(name), hint)


def _varying(name: str, structure: str, template: Template) -> ExpressionError:
    what = "the scene's index" if name == "scene" else f"the draw `{cut(name)}`"
    hint = "only values may: a parameter can decide here, or `variants` with `pick`"
    return ExpressionError(
        f"{structure} cannot read {what}: it is the same in every scene", *template.place(name), hint
    )
