"""The names in a scene file: which keys and scalars are names, of what, and where they are in the text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from scenecc.expand.overrides import OVERRIDE_SECTIONS
from scenecc.spec.references import SHARED_NAMESPACE
from scenecc.variation.expression import OBSERVATIONS
from scenecc.variation.forms import FORM_KEYS

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import At
    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.lsp.analysis import Leaf

Kind = Literal["object", "material", "group", "frame", "inside", "variable", "argument", "link", "joint", "scene file",
               "file"]  # fmt: skip
"""Kinds of named objects: an entity, frame or camera, or a link of one; a material, a collision group, a frame with a
region; an object inside an instance; a parameter, draw or loop variable; a prefab parameter; a link or joint of the
entity itself; a scene file; any other file."""

SECTIONS_OF: Final[dict[Kind, tuple[str, ...]]] = {
    "object": SHARED_NAMESPACE,
    "frame": ("frames",),
    "material": ("materials",),
    "group": ("collision_groups",),
    "variable": ("params", "draws"),
}
"""The sections that define names of a kind."""

_VALUES: Final[dict[str, Kind]] = {
    **dict.fromkeys(("relative_to", "on", "inside", "above", "facing", "mount", "parent", "child"), "object"),
    "material": "material",
    "collision_group": "group",
    "region": "frame",
    "use": "scene file",
    "include": "scene file",
    **dict.fromkeys(("urdf", "mjcf", "srdf", "file", "px", "nx", "py", "ny", "pz", "nz", "map", "texture"), "file"),
    "to": "link",
}
"""Key → kind of its value."""

_VALUES_IN: Final[dict[tuple[str, str], Kind]] = {
    ("collision_groups", "ignore"): "group",
    ("attach", "ignore"): "link",
    ("expect", "except"): "object",
    ("mimic", "joint"): "joint",
}
"""Kind of the value of keys that are names only below another key."""

_KEYS: Final[dict[str, Kind]] = {
    "near": "object",
    "override": "inside",
    "with": "argument",
    "links": "link",
    **dict.fromkeys(("joints", "drives", "qpos", "qvel", "qf"), "joint"),
}
"""Key → kind of the keys of its mapping."""


def named_kind(path: KeyPath, at: At) -> Kind | None:
    """Returns the kind of a scalar or key; None if it is not a name. `path`: path of the node or entry."""
    keys = plain_keys(path)
    section, last = keys[:1], keys[-1:]
    if at == "key":
        return _KEYS.get(keys[-2]) if len(keys) > 1 and section[0] not in {"params", "draws"} else None
    if not last or (section[0] in {"params", "draws", "materials"} and last[0] == "material"):
        return None
    for (where, key), kind in _VALUES_IN.items():
        if last[0] == key and where in keys:
            return kind
    return "file" if last[0].endswith("_texture") else _VALUES.get(last[0])


def plain_keys(path: KeyPath) -> tuple[str, ...]:
    """Returns the keys of a path without those of forms, whose content replaces the value."""
    return tuple(step for step in path if isinstance(step, str) and step not in FORM_KEYS)


def defined_kind(path: KeyPath) -> Kind | None:
    """Returns the kind of name that the key of an entry defines."""
    if path[-2:-1] == ("repeat",):
        return "variable"
    section = path[0] if len(path) == 2 else None
    return next((kind for kind, sections in SECTIONS_OF.items() if section in sections), None)


class Mention(NamedTuple):
    """A name in a text.

    Attributes:
        kind: kind of the named object.
        text: the name.
        start, end: its range in the leaf's value [characters].
    """

    kind: Kind
    text: str
    start: int
    end: int


_WORD: Final = re.compile(r"'[^']*'|\"[^\"]*\"|[A-Za-z_][A-Za-z0-9_]*")

_OBSERVATION: Final = re.compile(rf"\b({'|'.join(OBSERVATIONS)})\(([^()]*)\)")

_TEXT: Final = re.compile(r"'([^']*)'|\"([^\"]*)\"")


def mentions(leaf: Leaf) -> Iterator[Mention]:
    """Yields the names in a leaf."""
    if "${" in leaf.text:
        for start, end in _expressions(leaf.text):
            yield from _in_expression(leaf, start, end)
        return
    kind = named_kind(leaf.path, leaf.at)
    if kind is None and leaf.at == "key":
        kind = defined_kind(leaf.path)
    if kind is not None:
        yield Mention(kind, leaf.text, 0, len(leaf.text))


def _in_expression(leaf: Leaf, start: int, end: int) -> Iterator[Mention]:
    for match in _WORD.finditer(leaf.text, start, end):
        if match[0][0] not in {"'", '"'}:
            yield Mention("variable", match[0], match.start(), match.end())
    if leaf.path[:1] != ("expect",):
        return
    for call in _OBSERVATION.finditer(leaf.text, start, end):
        quoted = _TEXT.finditer(leaf.text, call.start(2), call.end(2))
        for argument, match in zip(OBSERVATIONS[call[1]], quoted, strict=False):
            kind: Kind = "joint" if argument == "joint" else "object"
            yield Mention(kind, match[0][1:-1], match.start() + 1, match.end() - 1)


def _expressions(text: str) -> Iterator[tuple[int, int]]:
    """Yields the ranges inside `${…}`; an unclosed one extends to the end."""
    at = text.find("${")
    while at >= 0:
        end = text.find("}", at)
        end = len(text) if end < 0 else end
        if text[max(at - 1, 0) : at] != "$":
            yield at + 2, end
        at = text.find("${", end)


_LONGEST_WORD: Final = 200


def open_expression(typed: str) -> str | None:
    """Returns the incomplete word at the end of typed text inside `${`; None outside of it."""
    at = typed.rfind("${")
    if at < 0 or "}" in typed[at:]:
        return None
    found = re.search(r"[A-Za-z_0-9]*$", typed[-_LONGEST_WORD:])
    return found[0] if found else ""


def overridden_path(path: KeyPath) -> KeyPath | None:
    """Returns the path of an overridden node in its prefab's file; None for other nodes."""
    if path[:1] != ("entities",) or path[2:3] != ("override",) or len(path) < 4:
        return None
    section, slash, name = str(path[3]).partition("/")
    start = (section, name) if slash and section in OVERRIDE_SECTIONS else ("entities", str(path[3]))
    # Overrides address list items by index, as keys of a mapping.
    return (*start, *(int(step) if str(step).isdecimal() else step for step in path[4:]))
