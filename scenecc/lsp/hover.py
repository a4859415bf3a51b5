"""Hover texts: the meaning of a key, the object of a name, a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from scenecc.diagnostics.messages import cut
from scenecc.lsp.completion import describe_param
from scenecc.lsp.language import describe_key
from scenecc.lsp.names import Definition, definition_of, mention_at
from scenecc.lsp.references import path_in_language

if TYPE_CHECKING:
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
        entity: entity whose size and mass are added, if any.
    """

    text: str
    line: int
    start: int
    end: int | None
    entity: str | None = None


def hover_at(view: WorkspaceView, path: Path, line: int, column: int) -> HoverText | None:
    """Returns the hover text at a 0-based position."""
    text = view.text(path)
    leaf = None if text is None else text.leaf_at(line, column)
    if text is None or leaf is None:
        return None
    found = mention_at(view, path, line, column)
    told = None if found is None else _describe_name(view, *found)
    if told is None:
        told = _describe_key(view, text, leaf.path), None
    return None if not told[0] else HoverText(told[0], leaf.line, leaf.start, leaf.end, told[1])


def _describe_key(view: WorkspaceView, text: SceneText, path: KeyPath) -> str | None:
    """Returns the meaning of the innermost key of a path."""
    while path and not isinstance(path[-1], str):
        path = path[:-1]
    return describe_key(*path_in_language(view, text.path, path, text.scalars))


def _describe_name(view: WorkspaceView, text: SceneText, leaf: Leaf, mention: Mention) -> tuple[str, str | None] | None:
    """Returns the Markdown, and the named entity."""
    defined = definition_of(view, text, leaf, mention)
    if defined is None:
        return None
    name = mention.text
    where = "" if defined.file == text.path else f" — {defined.file.name}"
    if mention.kind.endswith("file"):
        other = view.text(defined.file) if mention.kind == "scene file" else None
        described = None if other is None else other.scalar(("description",))
        head = f"`{_escape_markdown(name)}` — {_escape_markdown(str(defined.file))}"
        return f"{head}\n\n{_escape_markdown(described or '')}".rstrip(), None
    section = str(defined.path[0]) if defined.path else "link"
    if defined.path[:1] == ("params",):
        other = view.text(defined.file)
        return f"parameter `{name}`{where}: " + _escape_markdown(describe_param(other, name) if other else ""), None
    if defined.path[-2:-1] == ("repeat",):
        return f"loop variable `{name}`", None
    entity = _entity(view, text, defined, name)
    return f"{_SINGULAR.get(section, section)} `{_escape_markdown(name)}`{where}", entity


_SINGULAR = {
    "entities": "entity",
    "frames": "frame",
    "cameras": "camera",
    "materials": "material",
    "collision_groups": "collision group",
    "draws": "draw",
}


def _entity(view: WorkspaceView, text: SceneText, defined: Definition, name: str) -> str | None:
    """Returns the entity in the whole scene that a name means."""
    objects = view.objects(text.path)
    while name and name not in objects:
        name = name.rpartition("/")[0]
    return name if name and objects[name].section == "entities" and defined.path[:1] in {(), ("entities",)} else None


def with_facts(told: HoverText, facts: EntityFacts) -> str:
    """Returns the Markdown with the facts of the entity from `scenecc inspect`."""
    listed = (
        f"- {_escape_markdown(label)} {_escape_markdown(words)}".replace("  ", " ") for label, words in facts.facts
    )
    return f"{told.text} ({facts.kind})\n\n" + "\n".join(listed)


def _escape_markdown(text: str) -> str:
    """Escapes a scene's text, so that an editor does not interpret it as a link, image or markup."""
    return "".join(f"\\{one}" if one in "<>[]()!*`#" else one for one in cut(text, 500))
