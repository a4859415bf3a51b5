"""What was probably meant by a value of a wrong kind."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.messages import cut, nearest
from scenecc.spec.hints import FORM_WORDS, LENGTH_HINTS, WRITTEN_AS
from scenecc.spec.plain import is_mapping
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from scenecc.diagnostics import Path


def kind_hint(expected: str, path: Path, found: Any) -> str | None:
    """A hint; None where nothing is known.

    Args:
        expected: what a user may write there, as the message has it.
        path: of the value in the document.
        found: the value.
    """
    if is_mapping(found):
        return _form_hint(expected, found)
    if path[-1:] == ("repeat",) or (path[-2:-1] == ("repeat",) and isinstance(found, int)):
        return WRITTEN_AS["repeat"]
    if found.__class__ in {int, float} and path:
        # A number alone is meant as a list of one.
        return LENGTH_HINTS.get((str(path[-1]), 1))
    return _text_hint(expected, path, found) if isinstance(found, str) else None


def _text_hint(expected: str, path: Path, text: str) -> str | None:
    if expected in {"a number", "a whole number"} and _reads_as_number(text):
        return "take the quotes off"
    if expected == "true or false":
        is_condition = path[-1:] == ("if",)
        expression = f"an expression is written `${{{cut(text)}}}`"
        return expression if is_condition else "YAML 1.2 has only `true` and `false`, without quotes"
    if len(text) <= _LONGEST and (other := _OTHER_EXPRESSION.fullmatch(text)):
        return f'an expression is written `"${{{cut(next(filter(None, other.groups())))}}}"`'
    if len(path) == 2 and path[0] == "entities":
        return f"another scene file is used by `{{use: {cut(text)}}}`"
    return WRITTEN_AS["include"] if path == ("include",) else None


_LONGEST = 200
_OTHER_EXPRESSION = re.compile(r"\$([A-Za-z_]\w*)|\{\{ *([^{}]*[^{} ]) *\}\}|\$\(([^()]+)\)")
"""How other languages write expressions."""


def _form_hint(expected: str, found: Mapping[str, Any]) -> str | None:
    """What form of variation an unknown mapping was probably meant to be."""
    near = next((near for key in found if (near := nearest(key, FORM_KEYS))), None)
    if near is not None:
        return f"did you mean `{near}`?"
    other = next((FORM_WORDS[key] for key in found if key in FORM_WORDS), None)
    if other is not None:
        return f"did you mean `{{{other}}}`?"
    if expected in {"a number", "a whole number", "true or false"} or expected.startswith("["):
        return f"what differs from scene to scene is one of the forms {', '.join(sorted(FORM_KEYS))}"
    return None


def _reads_as_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    # Python reads 1_000, YAML does not.
    return "_" not in text
