"""Writes a scene document as YAML: keys in a standard order, short values on one line, short numbers.

The text reads back to the same document; a float32 number reads back to the same float32.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from math import copysign, isinf, isnan
from typing import TYPE_CHECKING, Any, Final, TypeGuard, cast

import numpy as np

from scenecc.source.events import SCENE_KEYED_FIELD, resolve_scalar

if TYPE_CHECKING:
    from scenecc.source.edits import Style

WIDTH: Final = 100
"""Maximum line length. Only a text or name longer than a line exceeds it."""

KEY_ORDER: Final[tuple[str, ...]] = tuple(
    re.findall(
        r"\w+",
        """
    scenecc name description repeat if type use prefix with urdf mjcf variants pick
    num_scenes seed starts params draws include physics environment ambient_light map
    materials collision_groups frames entities constraints lights cameras expect
    settled no_overlap holds after that because seconds within within_deg deeper_than except
    body_type scene_idxs hidden mount parent child pose fix_root_link
    p q rpy rpy_deg axis_angle look_at matrix anchor relative_to
    joint file size half_size radius half_length inner_radius outer_radius axis normal offset texture_repeat heights
    scale decomposition decomposition_params sdf position direction pose_in_parent pose_in_child origin
    mass com inertia inertial density material color collision_group collision_bits
    static_friction dynamic_friction restitution physical visual
    root shapes collisions visuals
    qpos qvel beyond_limits linear_velocity angular_velocity
    links joints drives
    """,
    )
)
"""Order of keys in a mapping; other keys follow in document order, and then `children`."""

NAMED: Final = frozenset(
    re.findall(
        r"\w+",
        """
    params draws materials collision_groups frames entities constraints lights cameras with override attach
    repeat qpos qvel links joints drives per_scene
    """,
    )
)
"""Keys of mappings by name, which keep their order."""

_RANK: Final = {name: number for number, name in enumerate(KEY_ORDER)}

_SECTIONS: Final = frozenset(("entities", "lights", "cameras", "constraints", "materials", "frames", "params", "draws"))
"""Top-level mappings that are never on one line."""

_MAX_FLOW_DEPTH: Final = 3
"""Maximum nesting of brackets on one line."""

_SHORT: Final = 2
"""Maximum lines of an entry without blank lines around it."""

_INTEGER_DIGITS: Final = 15
"""Integers up to this many digits are exact as floats."""

_LARGEST: Final = float(np.finfo(np.float32).max)

_MAX_FILLED_LINES: Final = 3
"""Maximum lines of a mapping in brackets; lists of numbers have no limit."""

_LINE: Final = r"[\x21-\x7e](?:[\x20-\x7e]*[\x21-\x7e])?"

_LITERAL: Final = re.compile(rf"{_LINE}(?:\n+{_LINE})*\n?").fullmatch
"""Matches texts of several lines that a block scalar can hold."""

_PLAIN_KEY: Final = re.compile(r"[A-Za-z_.][A-Za-z0-9_./*+|()-]*").fullmatch

_TEXT: Final = r"[A-Za-z0-9_./](?:[A-Za-z0-9_./+*()=$@^~%s;'-]|:(?=[A-Za-z0-9_/])| (?=[A-Za-z0-9_./(+]))*"

_PLAIN_INSIDE: Final = re.compile(_TEXT % "").fullmatch

_PLAIN_OUTSIDE: Final = re.compile(_TEXT % ",").fullmatch
"""Match texts that need no quotes, inside and outside of brackets."""

_ESCAPED: Final = re.compile("[\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")

Comments = Mapping[tuple[str | int, ...], str]
"""Path of keys and indices from the root → comment above that entry; `()`: above the document."""


def scene_text(document: Mapping[str, Any], *, comments: Comments | None = None) -> str:
    """Returns a scene document as YAML with 100 columns, which `scenecc.source` reads back to the same data.

    Args:
        document: as `load_scene` takes it: mappings, lists, tuples, texts, numbers and booleans. Keys are written in a
            standard order; named items keep their order.
        comments: comments above entries, by path of keys and indices; `()` is the head of the file. An entry with a
            comment inside is written on separate lines.

    Raises:
        TypeError: a value has another type.
    """
    writer = _Writer(comments or {})
    lines = list(writer.comment((), ""))
    blank = False
    for name, value in _order_entries(document, ""):
        entry = list(writer.entry(name, value, (name,), 0))
        # Blank lines separate sections with several lines.
        long = name in _SECTIONS or len(entry) > _SHORT
        if (long or blank) and any(not line.startswith("#") for line in lines):
            lines.append("")
        blank = long
        lines += entry
    return "\n".join(lines) + "\n"


def value_text(
    value: Any, path: tuple[str | int, ...], column: int, style: Style, *, step: int = 2
) -> str | Sequence[str]:
    """Returns a value for a place in a document, as one text, or as lines indented to a column.

    Args:
        value: as in the document of `scene_text`.
        path: path of the place.
        column: column of the lines.
        style: how it is written. Lists of single values are always in brackets.
        step: number of blanks by which nested mappings are indented.

    Raises:
        TypeError: a value has another type.
    """
    if style == "json":
        return _ESCAPED.sub(_escape, json.dumps(value, ensure_ascii=False))
    if style == "flow" or _is_scalar(value) or not value:
        return _flow(value, path, inside=style == "flow")
    inline = _flow(value, path, inside=False)
    numbers = not _is_mapping(value) and all(map(_is_scalar, value))
    if numbers or (style == "any" and column + len(inline) <= WIDTH and _depth(value) <= _MAX_FLOW_DEPTH):
        return inline
    return list(_Writer({}, step).block(value, path, column))


def key_text(name: str, path: tuple[str | int, ...]) -> str:
    """Returns a key as YAML. `path`: its path, which ends with the key."""
    by_scene = len(path) > 1 and path[-2] == SCENE_KEYED_FIELD
    if (by_scene and name.isdecimal() and name.isascii()) or (_PLAIN_KEY(name) and resolve_scalar(name) == name):
        return name
    return _quoted(name)


class _Writer:
    def __init__(self, comments: Comments, step: int = 2) -> None:
        self._comments = comments
        self._step = step
        self._within = {path[:end] for path in comments for end in range(len(path))}

    def comment(self, path: tuple[str | int, ...], indent: str) -> Iterator[str]:
        for line in self._comments.get(path, "").splitlines():
            yield f"{indent}# {line}".rstrip()

    def entry(self, name: str, value: Any, path: tuple[str | int, ...], column: int) -> Iterator[str]:
        """Yields the lines of `name: value`, indented to a column."""
        indent = " " * column
        yield from self.comment(path, indent)
        head = f"{indent}{key_text(name, path)}:"
        section = len(path) == 1 and name in _SECTIONS and bool(value)
        if isinstance(value, str) and "\n" in value and _LITERAL(value):
            yield f"{head} {'|' if value.endswith(chr(10)) else '|-'}"
            yield from (f"{indent}  {line}".rstrip() for line in value.splitlines())
        elif _is_scalar(value) or not value or (not section and self._fits(value, path, len(head) + 1)):
            yield f"{head} {_flow(value, path, inside=False)}"
        elif not section and (lines := self._fill_lines(f"{head} ", value, path, column)):
            yield from lines
        else:
            yield head
            yield from self.block(value, path, column + self._step)

    def block(self, value: Any, path: tuple[str | int, ...], column: int) -> Iterator[str]:
        """Yields the entries of a mapping or the items of a list, each on separate lines."""
        if not _is_mapping(value):
            for index, inner in enumerate(value):
                yield from self._item(inner, (*path, index), column)
            return
        before = 0
        for name, inner in _order_entries(value, path[-1]):
            lines = list(self.entry(name, inner, (*path, name), column))
            if path == ("entities",) and before and max(before, len(lines)) > _SHORT:
                yield ""
            before = len(lines)
            yield from lines

    def _item(self, value: Any, path: tuple[str | int, ...], column: int) -> Iterator[str]:
        head = f"{' ' * column}- "
        yield from self.comment(path, " " * column)
        if _is_scalar(value) or not value or self._fits(value, path, column + 2):
            yield head + _flow(value, path, inside=False)
        elif lines := self._fill_lines(head, value, path, column + 2):
            yield from lines
        else:
            lines = list(self.block(value, path, column + 2))
            above = next(number for number, line in enumerate(lines) if not line.lstrip().startswith("#"))
            yield from (line[2:] for line in lines[:above])
            yield head + lines[above][column + 2 :]
            yield from lines[above + 1 :]

    def _fill_lines(self, head: str, value: Any, path: tuple[str | int, ...], column: int) -> list[str]:
        """Returns a bracketed value over several lines; empty if it would be hard to read."""
        numbers = not _is_mapping(value) and all(map(_is_scalar, value))
        block = path[:-1] == ("entities",) and "use" not in value
        if path in self._within or _depth(value) > _MAX_FLOW_DEPTH or block:
            return []
        lines = list(_fill(head, value, path, column + 2))
        short = len(lines) <= _MAX_FILLED_LINES and all(len(line) <= WIDTH for line in lines)
        return lines if numbers or (short and _is_mapping(value)) else []

    def _fits(self, value: Any, path: tuple[str | int, ...], column: int) -> bool:
        if path in self._within or _depth(value) > _MAX_FLOW_DEPTH:
            return False
        return column + len(_flow(value, path, inside=False)) <= WIDTH


def _fill(head: str, value: Any, path: tuple[str | int, ...], column: int) -> Iterator[str]:
    opening, closing = "{}" if _is_mapping(value) else "[]"
    pieces = _flow_items(value, path)
    line = head + opening
    for number, piece in enumerate(pieces):
        end = closing if number == len(pieces) - 1 else ","
        blank = "" if line.endswith(opening) and not number else " "
        if number and len(line) + len(blank) + len(piece) + len(end) > WIDTH:
            yield line
            line, blank = " " * column, ""
        line += f"{blank}{piece}{end}"
    yield line


def _order_entries(value: Mapping[str, Any], owner: str | int) -> list[tuple[str, Any]]:
    """Returns the entries of a mapping in output order."""
    entries = list(value.items())
    if owner in NAMED:
        return entries
    return sorted(entries, key=lambda entry: (entry[0] == "children", _RANK.get(entry[0], len(_RANK))))


def _is_mapping(value: object) -> TypeGuard[Mapping[str, Any]]:
    return isinstance(value, Mapping)


def _is_scalar(value: Any) -> bool:
    return isinstance(value, str | int | float)


def _depth(value: Any) -> int:
    if _is_scalar(value):
        return 0
    return 1 + max(map(_depth, value.values() if _is_mapping(value) else value), default=0)


def _flow(value: Any, path: tuple[str | int, ...], *, inside: bool) -> str:
    """Returns a value on one line. `inside`: of brackets, where more texts need quotes."""
    if isinstance(value, str):
        return _text(value, inside=inside)
    if _is_scalar(value):
        return number_text(value)
    opening, closing = "{}" if _is_mapping(value) else "[]"
    return f"{opening}{', '.join(_flow_items(value, path))}{closing}"


def _flow_items(value: Any, path: tuple[str | int, ...]) -> list[str]:
    if _is_mapping(value):
        entries = [(name, inner, (*path, name)) for name, inner in _order_entries(value, path[-1] if path else "")]
        return [f"{key_text(name, here)}: {_flow(inner, here, inside=True)}" for name, inner, here in entries]
    items = cast("Sequence[Any]", value)
    if not isinstance(items, list | tuple):
        raise TypeError(f"a scene document cannot hold a {type(items).__name__}, at {path}")
    return [_flow(inner, (*path, index), inside=True) for index, inner in enumerate(items)]


def number_text(value: Any) -> str:
    """Returns a number or boolean as YAML, with the fewest digits that read back to it.

    For a float32, the fewest digits that round to the same float32: 0.1 for 0.10000000149011612.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    number = float(value)
    if isnan(number):
        return ".nan"
    if isinf(number):
        return ".inf" if number > 0 else "-.inf"
    with np.errstate(over="ignore"):
        single = np.float32(number)
    decimal = Decimal(str(single) if float(single) == number else repr(number))
    if abs(decimal) > _LARGEST:  # the shortest form of the largest float32 exceeds it
        decimal = Decimal(repr(number))
    if number == 0:
        return "0" if copysign(1, number) > 0 else "-0.0"
    # NumPy's and Python's formats differ between versions.
    decimal = decimal.normalize()
    plain, exponent = f"{decimal:f}", decimal.adjusted()
    # With a dot and a sign, since readers of YAML 1.1, such as PyYAML, take `1e-5` for text.
    factor = f"{decimal.scaleb(-exponent):f}"
    scientific = f"{factor}{'' if '.' in factor else '.0'}e{exponent:+d}"
    # From 2**53 on, an integer with the same digits may be a different number.
    short = len(scientific) < len(plain) or exponent >= _INTEGER_DIGITS
    return scientific if not -4 < exponent < 6 and short else plain


def _text(text: str, *, inside: bool) -> str:
    plain = (_PLAIN_INSIDE if inside else _PLAIN_OUTSIDE)(text)
    return text if plain and _is_plain_text(text) else _quoted(text)


def _is_plain_text(text: str) -> bool:
    try:
        return resolve_scalar(text) == text
    except OverflowError:
        return False


def _quoted(text: str) -> str:
    return _ESCAPED.sub(_escape, json.dumps(text, ensure_ascii=False))


def _escape(match: re.Match[str]) -> str:
    return f"\\u{ord(match[0]):04x}"
