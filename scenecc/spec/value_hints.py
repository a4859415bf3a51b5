"""Hints for values of a wrong kind."""

from __future__ import annotations

import re
from math import pi
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.messages import cut, keyboard_hint, nearest
from scenecc.spec.hints import FORM_SYNONYMS, LENGTH_HINTS, MISSING_KEY_HINTS, SYNTAX_HINTS
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from scenecc.diagnostics.diagnostic import Path

    TextSlip = tuple[re.Pattern[str], str | Callable[[re.Match[str]], str]]


MAPPING_OF_NAMES: Final = "a mapping of names"
"""Expected kind of a mapping whose keys are names, for example of entities. Other mappings have fixed keys."""


def kind_hint(expected: str, path: Path, found: Any) -> str | None:
    """Returns a hint for a value of a wrong kind, or None. `expected` is the kind in the message."""
    if is_mapping(found):
        return _mapping_hint(expected, path, found)
    if is_sequence(found):
        return _list_hint(expected, path, found)
    if isinstance(found, str):
        return _text_hint(expected, path, found)
    return _scalar_hint(expected, path, found) if path else None


def _scalar_hint(expected: str, path: Path, found: Any) -> str | None:
    """Returns a hint for a number or a boolean."""
    key, owner = str(path[-1]), path[-2] if len(path) > 1 else None
    if "repeat" in {key, owner}:
        return SYNTAX_HINTS["repeat"]
    if expected == "a mapping" and owner in {"drives", "joints", "links"}:
        return f'name them first: `{owner}: {{".*": {{{key}: …}}}}`'
    if found is True and key in {"settled", "no_overlap"}:
        return f"write `{key}: {{}}`, or its keys in the braces"
    if key == "gravity" and found is False:
        return "for no gravity write `gravity: [0, 0, 0]`"
    # A number in place of a list is a list of length 1.
    return None if isinstance(found, bool) else LENGTH_HINTS.get((key, 1))


def _mapping_hint(expected: str, path: Path, found: Mapping[str, Any]) -> str | None:
    if path[-1:] == ("inertia",):
        return MISSING_KEY_HINTS["inertia"]
    if path[-1:] in {("limits",), ("limits_deg",)}:
        return f"write `{path[-1]}: [low, high]`"
    if path[-1:] == ("com",):
        return "write `com: [x, y, z]`; the axes of an inertia are the `com` of `inertial`"
    if "xyz" in found and "axis" in path[-1:]:
        return "write its three numbers: `axis: [0, 0, 1]`"
    if expected == "a list" and FORM_KEYS.isdisjoint(found):
        return "write it in brackets, `[{…}]`, or begin each item with `- `"
    return _form_hint(expected, found)


def _list_hint(expected: str, path: Path, found: Sequence[Any]) -> str | None:
    if expected == MAPPING_OF_NAMES:
        return _names_hint(path, found)
    if expected == "a mapping":
        return "remove the `-` before each item: this is a mapping, `key: value`"
    if expected == "one of x, y, z" and sorted(found, key=str) == [0, 0, 1]:
        return f"write `axis: {'xyz'[list(found).index(1)]}`"
    if "friction" in str(path[-1:]) and expected == "a number":
        return "write only the first: PhysX has no torsional and no rolling friction"
    if expected == "a number":
        return "write one number; one for each scene is `{per_scene: […]}`"
    return None


def _names_hint(path: Path, found: Sequence[Any]) -> str:
    """Returns a hint for a list in place of a mapping of names."""
    first = found[0] if found else None
    name = first.get("name") if is_mapping(first) else None
    if path and isinstance(name, str):
        return f"the name is the key: `{path[-1]}: {{{cut(name)}: {{…}}}}`"
    return "remove the `-` before each item: this is a mapping, `NAME: …`"


def _form_hint(expected: str, found: Mapping[str, Any]) -> str | None:
    """Returns a hint with the form that an unknown mapping probably means."""
    near = next((near for key in found if (near := nearest(key, FORM_KEYS))), None)
    if near is not None:
        return f"did you mean `{near}`?"
    other = next((FORM_SYNONYMS[key] for key in found if key in FORM_SYNONYMS), None)
    if other is not None:
        return f"did you mean `{{{other}}}`?"
    if expected in {"a number", "a whole number", "true or false"} or expected.startswith("["):
        return "a value that differs from scene to scene is a form: `{uniform: [low, high]}`, `{choice: [a, b]}`"
    return None


def _text_hint(expected: str, path: Path, text: str) -> str | None:
    if len(text) > _MAX_LENGTH:
        return None
    if hint := keyboard_hint(text):
        return hint
    is_list = expected == "a list" or expected.startswith("[")
    if (is_list or expected in {"a number", "a whole number"}) and (hint := _number_hint(text, is_list=is_list)):
        return hint
    if expected == "true or false":
        is_condition = path[-1:] in {("if",), ("that",)}
        return _expression(text) if is_condition else "YAML 1.2 has only `true` and `false`, without quotes"
    return _hint_of(text, _SLIPS) or _place_hint(path, text)


def _number_hint(text: str, *, is_list: bool) -> str | None:
    """Returns a hint for a string in place of numbers."""
    return _hint_of(text, _LIST_SLIPS if is_list else _NUMBER_SLIPS)


def _hint_of(text: str, slips: tuple[TextSlip, ...]) -> str | None:
    found = ((hint, match) for pattern, hint in slips if (match := pattern.fullmatch(text)))
    return next((hint if isinstance(hint, str) else hint(match) for hint, match in found), None)


def _place_hint(path: Path, text: str) -> str | None:
    """Returns a hint for a string by its path."""
    shown = cut(text)
    lists = {"shapes", "collisions", "visuals"}
    if not lists.isdisjoint(map(str, path[-2:])):
        return f"a shape is a mapping: `[{{type: {shown}, …}}]`"
    if len(path) > 1 and path[-2] == "holds":
        return f'write `- that: "{shown if shown.startswith("${") else f"${{{shown}}}"}"`'
    if len(path) == 2 and path[0] == "entities":
        return f"to use another scene file write `{{use: {shown}}}`"
    hints = {
        "place": f"write `place: {{on: {shown}}}`",
        "next_to": f"write `next_to: {{of: {shown}, side: right}}`",
        "mimic": f"write `mimic: {{joint: {shown}}}`",
        "repair": f"repairs are a list: `repair: [{shown}]`",
        "include": SYNTAX_HINTS["include"],
        "repeat": SYNTAX_HINTS["repeat"],
    }
    return hints.get(str(path[-1])) if path else None


_MAX_LENGTH: Final = 200
"""Longest string that gets a hint [characters]."""

_UNITS: Final = {"kg": 1, "g": 1e-3, "m": 1, "cm": 1e-2, "mm": 1e-3, "s": 1, "ms": 1e-3, "rad": 1, "deg": pi / 180}
"""Unit after a number → factor to SI."""

_SI: Final = "masses are in kg, lengths in m, times in s, angles in rad"


def _expression(text: str) -> str:
    return f'an expression is written `"${{{cut(text)}}}"`'


def _list(text: str) -> str:
    return f"write commas and brackets: [{', '.join(text.replace(',', ' ').split())}]"


_SLIPS: tuple[TextSlip, ...] = (
    # Expressions in the syntax of other tools.
    (
        re.compile(r"\$([A-Za-z_]\w*)|\{\{ *([^{}]*[^{} ]) *\}\}|\$\(([^()]+)\)"),
        lambda found: _expression(next(filter(None, found.groups()))),
    ),
    (
        re.compile(r"([A-Za-z_]\w*) ?= ?([^=]+)"),
        lambda found: f"write a colon instead of `=`: `{cut(found[1])}: {cut(found[2])}`",
    ),
)
"""Pattern of a string → hint, for any expected kind."""

_FORM_SLIP: TextSlip = (
    re.compile(rf"({'|'.join(sorted(FORM_KEYS))})\(\[?([^()\[\]]*)\]?\)"),
    lambda found: f"write a form: `{{{found[1]}: [{found[2]}]}}`",
)

_NUMERIC_SLIPS: tuple[TextSlip, ...] = (
    (re.compile(r"\s*[-+.\d][-+.\deE]*(?:[ ,]+[-+.\d][-+.\deE]*)+\s*"), lambda found: _list(found[0])),
    (
        re.compile(rf"([-+]?\d{{1,12}}(?:\.\d{{1,12}})?) ?({'|'.join(_UNITS)})"),
        lambda found: f"write {float(found[1]) * _UNITS[found[2]]:.12g}: {_SI}",
    ),
    (re.compile(r"[-+]?\d+[eE][-+]?\d+"), "remove the quotes; PyYAML takes `1e-5` for text, and `1.0e-5` for a number"),
    (re.compile(r"\s*[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?\s*"), "remove the quotes"),
    (re.compile(r"[-+]?[\d.]{1,24} ?[A-Za-z°%\"'][\w/^*.³² ]{0,24}"), f"write only the number: {_SI}"),
    (re.compile(r".*random.*"), "write a form: `{uniform: [low, high]}`, `{choice: [a, b]}`"),
    (re.compile(r"None"), "remove the key, or write a number"),
    (re.compile(r"([-+]?)inf(inity)?", re.IGNORECASE), lambda found: f"write {found[1]}.inf, without quotes"),
)

_LIST_SLIPS: tuple[TextSlip, ...] = (
    _FORM_SLIP,
    (
        re.compile(r"(?:[\w.]+)?\(+\[?([-+.\deE, ]+)\]?,?\)+"),
        lambda found: f"write a list in brackets: [{found[1].strip(', ')}]",
    ),
    *_NUMERIC_SLIPS,
    *_SLIPS,
)
"""Pattern of a string → hint, where a list of numbers is expected."""

_NUMBER_SLIPS: tuple[TextSlip, ...] = (
    _FORM_SLIP,
    (
        re.compile(r"[-+]?\d+,\d+"),
        lambda found: f"write a decimal point instead of the comma: {found[0].replace(',', '.')}",
    ),
    *_NUMERIC_SLIPS,
    *_SLIPS,
    # Arithmetic, a name or a function call.
    (
        re.compile(r"[-+]?[\w.() ]+(?:[-+*/%]+[\w.() ]+)+|[A-Za-z_]\w*(?:\([\w.+*/ -]+\))?"),
        lambda found: _expression(found[0]),
    ),
)
"""Pattern of a string → hint, where a number is expected."""
