"""Hover texts: the meaning of a key, the object of a name, a parameter."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.diagnostics.messages import cut
from scenecc.lsp.completion import describe_param
from scenecc.lsp.language import describe_key
from scenecc.lsp.names import Definition, definition_of, mention_at
from scenecc.lsp.references import overridden_path, path_in_language

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.lsp.analysis import Leaf, SceneText
    from scenecc.lsp.references import Mention
    from scenecc.lsp.worker import EntityFacts
    from scenecc.lsp.workspace import WorkspaceView


class HoverText(NamedTuple):
    """A hover text, and the entity whose facts an engine can add.

    Attributes:
        text: Markdown.
        line, start, end: range of the hovered item: 0-based, in characters.
        entities: entities whose size and mass are added: the one that is named, or those of an instance or repetition.
    """

    text: str
    line: int
    start: int
    end: int | None
    entities: tuple[str, ...] = ()


def hover_at(view: WorkspaceView, path: Path, line: int, column: int) -> HoverText | None:
    """Returns the hover text at a 0-based position."""
    text = view.text(path)
    leaf = None if text is None else text.leaf_at(line, column)
    if text is None or leaf is None:
        return None
    found = mention_at(view, path, line, column)
    told = None if found is None else _describe_name(view, *found)
    if told is None:
        told = _describe_key(view, text, leaf.path), ()
    return None if not told[0] else HoverText(told[0], leaf.line, leaf.start, leaf.end, told[1])


def _describe_key(view: WorkspaceView, text: SceneText, path: KeyPath) -> str | None:
    """Returns the meaning of the innermost key of a path."""
    while path and not isinstance(path[-1], str):
        path = path[:-1]
    return describe_key(*path_in_language(view, text.path, path, text.scalars))


def _describe_name(
    view: WorkspaceView, text: SceneText, leaf: Leaf, mention: Mention
) -> tuple[str, tuple[str, ...]] | None:
    """Returns the Markdown, and the entities that are named."""
    defined = definition_of(view, text, leaf, mention)
    if defined is None:
        return None
    name = mention.text
    where = "" if defined.file == text.path else f" — {defined.file.name}"
    if mention.kind.endswith("file"):
        other = view.text(defined.file) if mention.kind == "scene file" else None
        described = None if other is None else other.scalar(("description",))
        head = f"`{_escape_markdown(name)}` — {_escape_markdown(str(defined.file))}"
        return f"{head}\n\n{_escape_markdown(described or '')}".rstrip(), ()
    section = str(defined.path[0]) if defined.path else "joint" if mention.kind == "joint" else "link"
    if defined.path[:1] == ("params",):
        other = view.text(defined.file)
        return f"parameter `{name}`{where}: " + _escape_markdown(describe_param(other, name) if other else ""), ()
    if defined.path[-2:-1] == ("repeat",):
        return f"loop variable `{name}`", ()
    head = f"{_SINGULAR.get(section, section)} `{_escape_markdown(name)}`{where}"
    full = name if overridden_path(leaf.path) is None else f"{leaf.path[1]}/{name}"
    return head, _entities(view, text, defined, full) if defined.path[:1] in {(), ("entities",)} else ()


_SINGULAR = {
    "entities": "entity",
    "frames": "frame",
    "cameras": "camera",
    "materials": "material",
    "collision_groups": "collision group",
    "draws": "draw",
}


def _entities(view: WorkspaceView, text: SceneText, defined: Definition, name: str) -> tuple[str, ...]:
    """Returns the entities of the whole scene that a name means: one, those of an instance, or copies."""
    every = {each: one for each, one in view.objects(text.path).items() if one.section == "entities"}
    if name in every:
        return (name,)
    key = defined.file, defined.path
    inside = (
        each
        for each, one in every.items()
        if each.startswith(f"{name}/") or (one.place is not None and (one.place.file, one.place.path) == key)
    )
    links = (name[:end] for end in range(len(name) - 1, 0, -1) if name[end] == "/" and name[:end] in every)
    return tuple(inside) or tuple(islice(links, 1))


MOST_TOLD: Final = 8
"""Maximum number of entities in a hover text."""


def with_facts(told: HoverText, facts: Sequence[EntityFacts | None]) -> str:
    """Returns the Markdown with the facts of the first entities from `scenecc inspect`."""
    if len(told.entities) == 1:
        (one,) = facts
        listed = () if one is None else (f"- {_fact(label, words)}" for label, words in one.facts)
        return told.text if one is None else f"{told.text} ({one.kind})\n\n" + "\n".join(listed)
    lines = [
        f"- `{_escape_markdown(name)}`" + ("" if one is None else f" ({one.kind}): {_size_and_mass(one)}")
        for name, one in zip(told.entities, facts, strict=False)
    ]
    left = len(told.entities) - len(lines)
    return "\n".join([f"{told.text}\n", *lines, *([f"- and {left} more"] if left else [])])


def _size_and_mass(one: EntityFacts) -> str:
    return ", ".join(_fact(label, words) for label, words in one.facts if label in {"mass", "size"})


def _fact(label: str, words: str) -> str:
    return f"{_escape_markdown(label)} {_escape_markdown(words)}".replace("  ", " ")


def _escape_markdown(text: str) -> str:
    """Escapes a scene's text, so that an editor does not interpret it as a link, image or markup."""
    return "".join(f"\\{one}" if one in "<>[]()!*`#" else one for one in cut(text, 500))
