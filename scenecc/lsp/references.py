"""What the keys and scalars of a scene file name: which are names, of what, and where in a text each stands."""

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
"""Of what is named: an entity, frame or camera, or a link of one; a material, a collision group, a frame with a region;
what is inside an instance; a parameter, draw or loop variable; a parameter of a prefab; a link or a joint of the entity
itself; a scene file; any other file."""

SECTIONS_OF: Final[dict[Kind, tuple[str, ...]]] = {
    "object": SHARED_NAMESPACE,
    "frame": ("frames",),
    "material": ("materials",),
    "group": ("collision_groups",),
    "variable": ("params", "draws"),
}
"""The sections that give names of a kind."""

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
"""Key → what its value names."""

_VALUES_IN: Final[dict[tuple[str, str], Kind]] = {
    ("collision_groups", "ignore"): "group",
    ("attach", "ignore"): "link",
    ("expect", "except"): "object",
    ("mimic", "joint"): "joint",
}
"""The same for keys that name something below another key alone."""

_KEYS: Final[dict[str, Kind]] = {
    "near": "object",
    "override": "inside",
    "with": "argument",
    "links": "link",
    **dict.fromkeys(("joints", "drives", "qpos", "qvel", "qf"), "joint"),
}
"""Key → what the keys of its mapping name."""


def named_kind(path: KeyPath, at: At) -> Kind | None:
    """What a scalar, or a key, names; None where it names nothing. `path`: of the node, or of the entry."""
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
    """The keys of a path without those of forms: what they pick from stands in the place of the value."""
    return tuple(step for step in path if isinstance(step, str) and step not in FORM_KEYS)


def defined_kind(path: KeyPath) -> Kind | None:
    """What the key of an entry gives a name to."""
    if path[-2:-1] == ("repeat",):
        return "variable"
    section = path[0] if len(path) == 2 else None
    return next((kind for kind, sections in SECTIONS_OF.items() if section in sections), None)


class Mention(NamedTuple):
    """A name in a text.

    Attributes:
        kind: of what it names.
        text: the name.
        start, end: where it is in the leaf's value [characters].
    """

    kind: Kind
    text: str
    start: int
    end: int


_WORD: Final = re.compile(r"'[^']*'|\"[^\"]*\"|[A-Za-z_][A-Za-z0-9_]*")

_OBSERVATION: Final = re.compile(rf"\b({'|'.join(OBSERVATIONS)})\(([^()]*)\)")

_TEXT: Final = re.compile(r"'([^']*)'|\"([^\"]*)\"")


def mentions(leaf: Leaf) -> Iterator[Mention]:
    """The names in a leaf."""
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
    """Where the insides of `${…}` are; of one that is not closed, up to the end."""
    at = text.find("${")
    while at >= 0:
        end = text.find("}", at)
        end = len(text) if end < 0 else end
        if text[max(at - 1, 0) : at] != "$":
            yield at + 2, end
        at = text.find("${", end)


_LONGEST_WORD: Final = 200


def open_expression(typed: str) -> str | None:
    """The part of a word that is typed last inside of `${`; None outside of one."""
    at = typed.rfind("${")
    if at < 0 or "}" in typed[at:]:
        return None
    found = re.search(r"[A-Za-z_0-9]*$", typed[-_LONGEST_WORD:])
    return found[0] if found else ""


def overridden_path(path: KeyPath) -> KeyPath | None:
    """The path in the file of a prefab of what is inside an override; None of anything else."""
    if path[:1] != ("entities",) or path[2:3] != ("override",) or len(path) < 4:
        return None
    section, slash, name = str(path[3]).partition("/")
    start = (section, name) if slash and section in OVERRIDE_SECTIONS else ("entities", str(path[3]))
    # Items of lists are overridden by index, as keys of a mapping.
    return (*start, *(int(step) if str(step).isdecimal() else step for step in path[4:]))
