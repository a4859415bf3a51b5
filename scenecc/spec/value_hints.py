"""Hints for values of a wrong kind."""

from __future__ import annotations

import json
import re
import unicodedata
from math import isfinite, pi
from typing import TYPE_CHECKING, Any, Final

from scenecc.diagnostics.messages import cut, keyboard_hint, nearest
from scenecc.spec.hints import (
    FORM_SYNONYMS,
    LENGTH_HINTS,
    MISSING_KEY_HINTS,
    VALUE_HINTS,
)
from scenecc.spec.key_hints import entry_at, flow, gravity, numbers, synonym
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.spec.notations import BYTE, LONGEST_NAME, SI, THOUSANDS, color_of, is_named_otherwise, unit_hint
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from scenecc.diagnostics.diagnostic import Path

    TextSlip = tuple[str, str, str]

MAPPING_OF_NAMES: Final = "a mapping of names"
"""Expected kind of a mapping whose keys are names, for example of entities. Other mappings have fixed keys."""


def choice_hint(found: str, choices: Sequence[str], path: Path = ()) -> str | None:
    """Returns a hint with the one of some words that was probably meant; None if there is none. `path`: of the word."""
    word = found.lower()
    if hint := next((hint for beside, hint in VALUE_HINTS.get(word, ()) if beside in choices), None):
        return hint
    near = synonym(word, choices)
    if near is None and word in {"-x", "-y", "-z"} and not _SHAPE_LISTS.isdisjoint(path[-3:-2]):
        return f"write `{word[1]}`; a `pose` turns the shape"
    vector = f"write `{_NORMALS[word]}`" if word[:1] == "-" and word in _NORMALS else kind_hint("a list", (), found)
    if near is None and "z" in choices and vector:
        return vector
    if near is None and "z" in choices and word in _TURNS:
        return f"write `{'r' if 'rx' in choices else ''}{_TURNS[word]}`"
    if near is None and "z" in choices and "rx" not in choices:
        return None  # letters do not resemble each other
    near = near or nearest(found, choices)
    return near and f"did you mean `{near}`?"


_SHAPE_LISTS: Final = frozenset(("shapes", "collisions", "visuals"))
_TURNS: Final = {"up": "z", "vertical": "z", "yaw": "z", "roll": "x", "pitch": "y", "forward": "x"}


def kind_hint(expected: str, path: Path, found: Any) -> str | None:
    """Returns a hint for a value of a wrong kind, or None. `expected` is the kind in the message."""
    if is_mapping(found):
        return _mapping_hint(expected, path, found)
    if is_sequence(found):
        return _list_hint(expected, path, found)
    if isinstance(found, str):
        return _text_hint(expected, path, found)
    return _scalar_hint(expected, path, found) if path else None


def _scalar_hint(expected: str, path: Path, found: Any) -> str | None:  # noqa: PLR0911 - a case each
    """Returns a hint for a number or a boolean."""
    key, owner = str(path[-1]), path[-2] if len(path) > 1 else None
    if "repeat" in {key, owner}:
        count = flow(found if isinstance(found, int) and found is not True else 4)
        is_index = owner == "repeat" and key not in {"count", "n", "times"}
        return f"write `{key}: {{count: {count}}}`" if is_index else f"write `repeat: {{i: {{count: {count}}}}}`"
    if expected == "true or false":
        return _switch_hint(key, found)
    if expected == "a mapping" and (plain := _PARTS.get(str(owner))):
        if key in plain:
            return f'name them first: `{owner}: {{".*": {{{key}: {flow(found)}}}}}`'
        if owner == "joints":
            return f"write its position at the articulation: `qpos: {{{key}: {flow(found)}}}`"
        return f"write `{key}: {{{plain[0]}: {flow(found)}}}`"
    if found is True and key in {"settled", "no_overlap"}:
        return f"write `{key}: {{}}`, or its keys in the braces"
    if key == "gravity" and (vector := gravity(found)):
        return f"write `gravity: {vector}`"
    return None if isinstance(found, bool) else _number_hint(expected, path, found)


_PARTS: Final = {
    "drives": ("stiffness", "damping", "force_limit", "target", "velocity_target"),
    "joints": ("friction", "friction_force", "armature", "max_velocity"),
    "links": ("mass", "linear_damping", "angular_damping"),
}
"""Mapping of names of a robot → its keys that take a number."""


def _number_hint(expected: str, path: Path, found: float) -> str | None:
    """Returns a hint for a number in place of something else."""
    key, one = str(path[-1]), flow(found)
    if key.endswith("color") and isinstance(found, int) and found > BYTE:
        # Six digits are a colour without its `#`; YAML reads `0xff0000` as a number of more.
        digits = str(found) if len(str(found)) == _HEX_DIGITS else f"{found:06x}"
        return f'write `{key}: "#{digits}"`'
    meant = {
        **dict.fromkeys(("scene_idxs", "qpos", "qvel"), f"[{one}]"),
        "limits": flow([0, found] if path[:1] == ("constraints",) else [-abs(found), abs(found)]),
        "limits_deg": flow([-abs(found), abs(found)]),
        "height": f"[{one}, {one}]",
        **(dict.fromkeys(path[-1:], f"[0, {one}]") if path[-2:-1] == ("near",) else {}),
        **(dict.fromkeys("xyz", f"[{one}, {one}]") if path[-2:-1] == ("limits",) else {}),
        "half_size": flow([found] * 3),
        "physical": f"{{static_friction: {one}, dynamic_friction: {one}}}",
        **dict.fromkeys(("color", "base_color", "ambient_light"), flow([found] * 3)),
    }
    if expected == "a whole number":
        return f"write {entry_at(path, round(found))}" if isfinite(found) else None
    if key in meant:
        return f"write `{key}: {meant[key]}`"
    is_list = expected == "a list" or expected.startswith("[")
    return f"write its numbers in brackets: `{key}: [x, y, z]`" if is_list and key in _VECTORS else None


_HEX_DIGITS: Final = 6

_VECTORS: Final = frozenset(("pose", "p", "com", "linear_velocity", "angular_velocity", "position", "direction"))


def _switch_hint(key: str, found: Any) -> str | None:
    """Returns a hint for a value in place of true or false."""
    if key == "gravity" and found != 0 and (vector := gravity(found)):
        return f"write `gravity: true`; the vector is `physics: {{gravity: {vector}}}`"
    word = str(found).strip().lower()
    if word in _ON | _OFF:
        return f"write `{key}: {'true' if word in _ON else 'false'}`, without quotes"
    return "write `true` or `false`, without quotes"


_ON: Final = frozenset(("true", "yes", "on", "y", "1"))
_OFF: Final = frozenset(("false", "no", "off", "n", "0"))


def _mapping_hint(expected: str, path: Path, found: Mapping[str, Any]) -> str | None:  # noqa: PLR0911 - a case each
    if path[-1:] == ("inertia",):
        return MISSING_KEY_HINTS["inertia"]
    if path[-1:] in {("limits",), ("limits_deg",)}:
        ends = [*numbers(found.get("lower", found.get("min"))), *numbers(found.get("upper", found.get("max")))]
        return f"write `{path[-1]}: {flow(ends) if len(ends) == 2 else '[low, high]'}`"
    if expected == "a text" and path and len(found) == 1 and isinstance(only := next(iter(found.values())), str):
        return f"write `{path[-1]}: {flow(only)}`"
    if path[-1:] == ("com",):
        return "write `com: [x, y, z]`; the axes of an inertia are the `com` of `inertial`"
    if "xyz" in found and "axis" in path[-1:]:
        return f"write `axis: {flow(found['xyz'])}`"
    if {"x", "y", "z"} <= found.keys() and path:
        return f"write `{path[-1]}: {flow([found[one] for one in 'xyz'])}`"
    axes = next((axes for axes in _AXES if found and found.keys() <= {*axes}), None)
    if axes and path and path[-1] != "limits" and (expected == "a list" or expected.startswith("[")):
        return f"write `{path[-1]}: {flow([found.get(axis, 0) for axis in axes])}`"
    if expected == "a list" and FORM_KEYS.isdisjoint(found) and path:
        return f"write it in brackets, `{path[-1]}: [{flow(found)}]`, or begin each item with `- `"
    return _form_hint(expected, found)


_AXES: Final = (("x", "y", "z"), ("roll", "pitch", "yaw"))
"""Names of the parts of a vector in other tools."""


def _list_hint(expected: str, path: Path, found: Sequence[Any]) -> str | None:  # noqa: PLR0911 - a case each
    if expected == MAPPING_OF_NAMES:
        return _names_hint(path, found)
    if expected == "a mapping" and path[:-1] == ("frames",) and len(numbers(found)) == 3:
        return f"write `{path[-1]}: {{pose: {flow(found)}}}`"
    if expected == "a mapping":
        return _keys_hint(path, numbers(found)) or "remove the `-` before each item: this is a mapping, `key: value`"
    if expected == "true or false" and path[-1:] == ("gravity",):
        return _switch_hint("gravity", found)
    if expected == "one of x, y, z" and sorted(found, key=str) == [0, 0, 1]:
        return f"write `axis: {'xyz'[list(found).index(1)]}`"
    if "friction" in str(path[-1:]) and expected == "a number" and found:
        return f"write {entry_at(path, found[0])}: PhysX has no torsional and no rolling friction"
    if expected == "a number" and path and isinstance(path[-1], str):
        if len({*numbers(found)}) == 1:
            return f"write `{path[-1]}: {flow(found[0])}`"
        if len(numbers(found)) == 2:
            return f"write one number; a drawn one is `{path[-1]}: {{uniform: {flow(sorted(numbers(found)))}}}`"
        return f"write one number; one for each scene is `{path[-1]}: {{per_scene: {flow(found)}}}`"
    if expected == "a text" and len(found) == 1:
        return f"write {entry_at(path, flow(found[0]))}"
    return None


def _keys_hint(path: Path, found: list[float]) -> str | None:
    """Returns a hint for numbers in a list in place of a mapping of keys."""
    if path[-1:] == ("axis_angle",) and len(found) == 4:
        angle = "angle_deg" if abs(found[3]) > 2 * pi else "angle"
        return f"write `axis_angle: {{axis: {flow(found[:3])}, {angle}: {flow(found[3])}}}`"
    if path[-1:] == ("intrinsic",) and len(found) == 4:
        keys = ", ".join(f"{key}: {flow(one)}" for key, one in zip(("fx", "fy", "cx", "cy"), found, strict=True))
        return f"write `intrinsic: {{{keys}}}` [px]"
    return None


def _names_hint(path: Path, found: Sequence[Any]) -> str:
    """Returns a hint for a list in place of a mapping of names."""
    names = [one.get("name") for one in found if is_mapping(one)]
    if path and names and isinstance(names[0], str):
        is_whole = len(names) == len(found) and all(isinstance(name, str) for name in names)
        bodies = [{key: value for key, value in one.items() if key != "name"} for one in found if is_mapping(one)]
        body = flow(dict(zip(names, bodies, strict=True))) if is_whole else "…"
        return f"the name is the key: `{path[-1]}: {f'{{{cut(names[0])}: {{…}}}}' if body == '…' else body}`"
    if path and found and all(is_mapping(one) and len(one) == 1 and is_mapping(*one.values()) for one in found):
        merged = flow({key: one for each in found for key, one in each.items()})
        if merged != "…":
            return f"remove the `-` before each item: `{path[-1]}: {merged}`"
    return "remove the `-` before each item: this is a mapping, `NAME: …`"


def _form_hint(expected: str, found: Mapping[str, Any]) -> str | None:
    """Returns a hint with the form that an unknown mapping probably means."""
    for key, value in found.items():
        near = nearest(key, FORM_KEYS)
        form = FORM_SYNONYMS.get(key, near)
        if near and form == near and not is_sequence(value):
            return f"did you mean `{near}`?"
        if form is None:
            continue
        low, high = found.get("min", found.get("low")), found.get("max", found.get("high"))
        if is_sequence(value):
            form = f"{form.partition(':')[0]}: {flow(value)}"
        elif low is not None and high is not None:
            form = f"uniform: {flow([low, high])}"
        return f"did you mean `{{{form}}}`?"
    if expected in {"a number", "a whole number", "true or false"} or expected.startswith("["):
        return "a value that differs from scene to scene is a form: `{uniform: [low, high]}`, `{choice: [a, b]}`"
    return None


def _text_hint(expected: str, path: Path, text: str) -> str | None:  # noqa: PLR0911 - a case each
    if len(text) > _MAX_LENGTH:
        return None
    if hint := keyboard_hint(text):
        return hint
    is_list = expected == "a list" or expected.startswith("[")
    if is_list or expected in {"a number", "a whole number"}:
        is_first_color = path[-1:] == (0,) and str(path[-2]).endswith("color") and not text.strip().isdecimal()
        if is_first_color and (color := color_of(_commas(text))):
            return f"write `{path[-2]}: {flow(color)}`"
        if _MIXED.fullmatch(text):
            return "write a comma and a blank between all numbers, and points for decimals"
        parts = numbers(text.replace(";", " "))
        if not is_list and len(parts) > 1 and isinstance(path[-1], int):
            return f"write commas: `{flow(parts)[1:-1]}`"
        if hint := unit_hint(path, text) or _slip_hint(path, text, _LIST_SLIPS if is_list else _NUMBER_SLIPS):
            return hint
    if expected == "true or false":
        if path[-1:] in {("if",), ("that",)} and text.lower() not in _ON | _OFF:
            quoted = f'"${{{cut(text)}}}"'
            return f"an expression is written {entry_at(path, quoted)}"
        return _switch_hint(str(path[-1]) if path else "", text)
    hint = _slip_hint(path, text, _TEXT_SLIPS) or _place_hint(path, text)
    if hint is None and path and path[-1] in _NAME_LISTS and _WORDS.fullmatch(text):
        words = ", ".join(text) if path[-1] == "locked_axes" and {*text} <= {*"xyz"} else _commas(text)
        return f"write it in brackets: {entry_at(path, f'[{words}]')}"
    return hint


_WORDS: Final = re.compile(r"[A-Za-z_][\w./-]*(?:[ ,]+[A-Za-z_][\w./-]*)*")

_NAME_LISTS: Final = frozenset(("ignore", "except", "locked_axes", "include", "repair"))
"""Keys of lists of names."""

_NORMALS: Final = {
    **dict.fromkeys(("x", "+x", "forward"), "[1, 0, 0]"),
    **dict.fromkeys(("y", "+y", "left"), "[0, 1, 0]"),
    **dict.fromkeys(("z", "+z", "up"), "[0, 0, 1]"),
    "-x": "[-1, 0, 0]",
    "-y": "[0, -1, 0]",
    "-z": "[0, 0, -1]",
    "down": "[0, 0, -1]",
}
"""Word for a direction → its vector."""


def _place_hint(path: Path, text: str) -> str | None:  # noqa: PLR0911 - a case each
    """Returns a hint for a string by its path."""
    last = str(path[-1]) if path else ""
    shown = cut(text)
    lists = {"shapes", "collisions", "visuals"}
    if not lists.isdisjoint(map(str, path[-2:])):
        return f"a shape is a mapping: `[{{type: {shown}, …}}]`"
    if path[-2:-1] == ("repeat",) and (times := _RANGE.fullmatch(text)):
        return f"write `{last}: {{count: {times[1] or times[2]}}}`"
    condition = "that: " + json.dumps(shown if shown.startswith("${") else f"${{{shown}}}", ensure_ascii=False)
    if len(path) > 1 and path[-2] == "holds":
        return f"write `- {condition}`"
    if len(path) == 2 and path[0] == "entities":
        robot = {"urdf": "urdf", "xml": "mjcf", "mjcf": "mjcf"}.get(text.rpartition(".")[2].lower())
        if robot:
            return f"write `{last}: {{{robot}: {shown}}}`"
        return f"to use another scene file write `{{use: {shown}}}`"
    if (path[-2:-1] == ("materials",) or path[-1:] == ("visual",)) and (color := color_of(text)):
        named = f'{{base_color: "{color}"}}' if isinstance(color, str) else f"{{base_color: {flow(color)}}}"
        return f"write `{last}: {named if last == 'visual' else f'{{visual: {named}}}'}`"
    hints = {
        "joint": f"write `joint: {{type: {shown}}}`",
        "near": f"write `near: {{{shown}: [0, 0.1]}}`",
        "at": "write `at: [0, 0]`" if text in {"center", "centre", "middle"} else None,
        **dict.fromkeys(("normal", "direction"), f"write `{last}: {_NORMALS[text]}`" if text in _NORMALS else None),
        "look_at": f"write a point: `look_at: [x, y, z]`; `relative_to: {shown}` makes it one of that frame",
        "lights": "write `environment: {ambient_light: [0.3, 0.3, 0.3]}`" if text == "ambient" else None,
        "place": f"write `place: {{on: {shown}}}`",
        "next_to": f"write `next_to: {{of: {shown}, side: right}}`",
        "mimic": f"write `mimic: {{joint: {shown}}}`",
        "repair": f"repairs are a list: `repair: [{shown}]`",
        "include": f"write `include: [{shown}]`",
        "repeat": "for 4 copies write `{i: {count: 4}}`",
        "holds": f"write `holds: [{{{condition}}}]`",
    }
    return hints.get(last)


def length_hint(path: Path, found: Any) -> str | None:  # noqa: PLR0911 - a case each
    """Returns a hint for a list of a wrong length."""
    if not path or not is_sequence(found):
        return None
    key, parts = path[-1], numbers(found)
    split = [numbers(one.replace(";", " ")) if isinstance(one, str) else [one] for one in found]
    if any(len(one) > 1 for one in split):
        return f"write commas: {entry_at(path, [part for one in split for part in one])}"
    if key == "half_size" and len(parts) == 1:
        return f"write `half_size: {flow(parts * 3)}`"
    if key == "pose" and len(parts) == 7:
        return f"write `pose: {{p: {flow(parts[:3])}, q: {flow(parts[3:])}}}`; `q` has w first"
    if key == "pose" and len(parts) == 6:
        angles = "rpy_deg" if max(map(abs, parts[3:])) > 2 * pi else "rpy"
        return f"write `pose: {{p: {flow(parts[:3])}, {angles}: {flow(parts[3:])}}}`"
    if key == "region" and len(parts) == 2:
        return f"write two corners: `region: {flow([[-one / 2 for one in parts], [one / 2 for one in parts]])}`"
    if key == "region" and len(parts) == 4:
        return f"write two corners: `region: {flow([parts[:2], parts[2:]])}`"
    return LENGTH_HINTS.get((str(key), len(found)))


def name_hint(found: str) -> str:
    """Returns a name that resembles a text that is not one, for the start of a hint; "" if there is none."""
    if variable := re.fullmatch(r"([\w.-]*)(?:\{(\w+)\}|\$(\w+))([\w.-]*)", found):
        before, one, other, after = variable.groups()
        return f'write `"{before}${{{one or other}}}{after}"`: '
    plain = unicodedata.normalize("NFKD", found[:LONGEST_NAME]).encode("ascii", "ignore").decode()
    name = re.sub(r"[^A-Za-z0-9_.-]+", "_", plain or "_").strip("_")
    name = re.sub(r"[.-]", "_", name) if name == found else name
    name = name if name[:1].isalpha() else f"_{name}"
    return f"write `{name}`: " if re.fullmatch(r"[A-Za-z_][\w.-]*", name) and len(name) > 1 else ""


def color_hint(path: Path, found: Any) -> str:
    """Returns a hint for what is not a colour."""
    entry = color_of(found)
    if entry is None:
        return 'write three or four numbers in 0..1, or `"#rrggbb"`'
    text = entry if isinstance(entry, str) else flow(entry)
    quoted = f'"{text}"' if isinstance(entry, str) else text
    if is_named_otherwise(found, entry):
        return f"did you mean {entry_at(path, quoted)}? Known names are those of CSS"
    return f"write {entry_at(path, quoted)}"


_MAX_LENGTH: Final = 200
"""Longest string that gets a hint [characters]."""

_MIXED: Final = re.compile(r"(?=[^,]*\d,\d)(?=.*\d +[-+.\d])[-+.,\deE ]+")
"""Numbers separated by commas and by blanks alone, of which either may be part of a number: `1,2 3`."""

_RANGE: Final = re.compile(r"range\((\d+)\)|(?:\d+ *\.\. *|0 *: *)(\d+)")


def _commas(text: str) -> str:
    return ", ".join(re.sub("[,;]", " ", text).split())


_MODULES: Final = re.compile(r"\b(?:np|numpy|math)\.(?=(?:pi|sqrt|sin|cos|tan|radians|degrees|floor|ceil|hypot)\b)")
"""Python's modules before functions that expressions have without them."""


def _slip_hint(path: Path, text: str, slips: Iterable[TextSlip]) -> str | None:
    """Returns the hint of the first slip that a text is."""
    text = _MODULES.sub("", text)
    for pattern, value, words in slips:
        if found := re.fullmatch(pattern, text):
            made = found.expand(value)
            entry = entry_at(path, re.sub(r"\[(.*)\]", lambda items: f"[{_commas(items[1])}]", made))
            before, at, after = words.partition("@")
            return f"{found.expand(before)}{entry if at else ''}{found.expand(after)}"
    return None


_FORM_SLIP: Final = (
    rf"({'|'.join(sorted(FORM_KEYS))})(?:\(| *\[| +)\[?([^()\[\]]*)\]?\)?",
    r"{\1: [\2]}",
    "write a form: @",
)

_TEXT_SLIPS: Final[tuple[TextSlip, ...]] = (
    # Expressions in the syntax of other tools.
    (
        r"\$([A-Za-z_]\w*)|\{ *([A-Za-z_]\w*) *\}|\{\{ *([^{}]*[^{} ]) *\}\}|\$\(([^()]+)\)",
        r'"${\1\2\3\4}"',
        "an expression is written @",
    ),
    (r"([A-Za-z_]\w*) ?= ?([^=]+)", "", r"write a colon instead of `=`: `\1: \2`"),
)
"""Pattern of a text, the value that it means, and a hint with `@` for its entry; for any expected kind."""

_NUMERIC_SLIPS: Final[tuple[TextSlip, ...]] = (
    (r"\s*\[([-+.\deE, ]*)\]\s*", r"[\1]", "write @, without quotes"),
    (r"\s*[-+.\d][-+.\deE]*(?:[ ,;]+[-+.\d][-+.\deE]*)+\s*", r"[\g<0>]", "write commas and brackets: @"),
    (r"([-+]?\d+)[eE](-\d+)", r"\1.0e\2", "write @, without quotes; PyYAML takes `1e-5` for text"),
    (r"([-+]?\d+)[eE]\+?(\d+)", r"\1.0e+\2", "write @, without quotes; PyYAML takes `1e5` for text"),
    (r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*", r"\1", "write @, without quotes"),
    (r"([-+]?\d[\d.]{0,23}) ?[A-Za-z°%\"'][\w/^*.³² ]{0,24}", r"\1", f"write only the number, @: {SI}"),
    (r".*random.*", "", "write a form: `{uniform: [low, high]}`, `{choice: [a, b]}`"),
    (r"(?i:None|null|nil|nan)", "", "remove the key to get its default"),
    (r"(?i:([-+]?)inf(?:inity)?)", r"\1.inf", "write @, without quotes"),
)

_LIST_SLIPS: Final[tuple[TextSlip, ...]] = (
    _FORM_SLIP,
    (r"(?:[\w.]+)?\(+\[?([-+.\deE, ]+)\]?,?\)+", r"[\1]", "write a list in brackets: @"),
    *_NUMERIC_SLIPS,
    *_TEXT_SLIPS,
)
"""As `_TEXT_SLIPS`, where a list of numbers is expected."""

_NUMBER_SLIPS: Final[tuple[TextSlip, ...]] = (
    _FORM_SLIP,
    (THOUSANDS, r"\1\2", "write @, or a decimal point instead of the comma"),
    (r"([-+]?\d+),(\d+)", r"\1.\2", "write @, with a decimal point"),
    (r"(-?[\d.]+?) ?(?:to|\.\.+|…) ?(-?[\d.]+)", r"{uniform: [\1, \2]}", "write a form: @"),
    (r"(\d[\d.]*) ?[-–] ?(\d[\d.]*)", r"{uniform: [\1, \2]}", 'write a form: @; arithmetic is `"${a - b}"`'),
    *_NUMERIC_SLIPS,
    *_TEXT_SLIPS,
    (r"[A-Za-z_]\w*", r'"${\g<0>}"', "write a number; a parameter is read by @"),
    # Arithmetic, or a function call.
    (
        r"[-+]?[\w.() ]+(?:[-+*/%]+[\w.() ]+)+|[A-Za-z_]\w*(?:\([\w.+*/ -]+\))?",
        r'"${\g<0>}"',
        "an expression is written @",
    ),
)
"""As `_TEXT_SLIPS`, where a number is expected."""
