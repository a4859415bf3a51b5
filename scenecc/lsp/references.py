"""The names in a scene file: which keys and scalars are names, of what, and where they are in the text."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from scenecc.expand.overrides import OVERRIDE_SECTIONS
from scenecc.spec.base import NameKind
from scenecc.spec.keys import place_at
from scenecc.spec.references import SHARED_NAMESPACE
from scenecc.variation.expression import OBSERVATIONS

if TYPE_CHECKING:
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.lsp.analysis import Leaf, SceneText
    from scenecc.lsp.language import Siblings
    from scenecc.lsp.workspace import WorkspaceView

Kind = NameKind | Literal["variable"]
"""Kinds of named objects; a variable is a parameter, draw or loop variable."""

SECTIONS_OF: Final[dict[Kind, tuple[str, ...]]] = {
    "entity": SHARED_NAMESPACE,
    "frame": ("frames",),
    "material": ("materials",),
    "group": ("collision_groups",),
    "variable": ("params", "draws"),
}
"""The sections that define names of a kind."""


def path_in_language(view: WorkspaceView, file: Path, path: KeyPath, siblings: Siblings) -> tuple[KeyPath, Siblings]:
    """Returns the path by which the language describes a node; for an override, the path in the prefab.

    Args:
        view: the files.
        file: the file of the node.
        path: path of the node.
        siblings: keys of the mappings of the file.
    """
    inside = overridden_path(path)
    if inside is None:
        return path, siblings
    start = len(path) - len(inside)
    prefab, inside = _nested_member(view, prefab_texts(view, file, path, siblings), inside)

    def merged(below: KeyPath) -> dict[str, str | None]:
        written = (keys for text in prefab if (keys := text.scalars(below)))
        return {**next(written, dict[str, str | None]()), **siblings(path[: start + len(below)])}

    return inside, merged


def _nested_member(
    view: WorkspaceView, texts: tuple[SceneText, ...], path: KeyPath, depth: int = 0
) -> tuple[tuple[SceneText, ...], KeyPath]:
    """Returns the files of the prefab that has an overridden object, and the path in them.

    Args:
        view: the files.
        texts: files of the outer prefab.
        path: path in it, with the names of instances before that of the object.
        depth: number of prefabs around it.
    """
    head, slash, rest = str(path[1]).partition("/")
    used = next((one for text in texts if (one := text.scalar((path[0], head, "use")))), None) if slash else None
    file = None if used is None or depth > DEEPEST else view.find_file(texts[0].path, used)
    return (
        (texts, path)
        if file is None
        else _nested_member(view, view.module(file), (path[0], rest, *path[2:]), depth + 1)
    )


DEEPEST: Final = 32
"""Maximum depth of nested prefabs."""


def prefab_texts(view: WorkspaceView, file: Path, path: KeyPath, siblings: Siblings) -> tuple[SceneText, ...]:
    """Returns the files of the prefab whose instance contains a node."""
    use = siblings(path[:2]).get("use")
    found = None if not use else view.find_file(file, use)
    return () if found is None else view.module(found)


def value_kind(path: KeyPath, siblings: Siblings) -> Kind | None:
    """Returns the kind of name that a scalar at a path in the language is; None if it is not a name."""
    place = place_at(path, siblings)
    while place.names is None and place.item is not None:
        place = place.item
    return place.names


def key_kind(path: KeyPath, siblings: Siblings) -> Kind | None:
    """Returns the kind of name that the keys of a mapping are; None if they are not names."""
    key = place_at(path, siblings).key
    return None if key is None else key.names


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


def mentions(view: WorkspaceView, text: SceneText, leaf: Leaf) -> Iterator[Mention]:
    """Yields the names in a leaf of a text."""
    if "${" in leaf.text:
        for start, end in _expressions(leaf.text):
            yield from _in_expression(leaf, start, end)
        return
    if leaf.at == "value":
        kind = value_kind(*path_in_language(view, text.path, leaf.path, text.scalars))
    else:
        parent = path_in_language(view, text.path, leaf.path[:-1], text.scalars)
        kind = key_kind(*parent) or defined_kind(leaf.path)
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
            kind: Kind = "joint" if argument == "joint" else "entity"
            yield Mention(kind, match[0][1:-1], match.start() + 1, match.end() - 1)


def observed_entity(text: str, at: int) -> str | None:
    """Returns the first name in the call around a position of an expression."""
    calls = (call for call in _OBSERVATION.finditer(text) if call.start() <= at <= call.end())
    name = next((_TEXT.search(call[2]) for call in calls), None)
    return None if name is None else name[0][1:-1]


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
