"""Completion: the keys, words, names, files and variables that may be typed at a position."""

from __future__ import annotations

import os
import re
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.assets.images import IMAGE_SUFFIXES
from scenecc.assets.meshes import MESH_SUFFIXES
from scenecc.expand.documents import PREFAB_FOLDER, SHIPPED_PREFIX, shipped_names
from scenecc.expand.overrides import OVERRIDE_SECTIONS, REMOVE
from scenecc.lsp.analysis import MAX_CHARACTERS, SceneText
from scenecc.lsp.cursor import cursor_at
from scenecc.lsp.language import is_mapping_key, keys_at, values_at
from scenecc.lsp.references import (
    SECTIONS_OF,
    Kind,
    key_kind,
    open_expression,
    overridden_path,
    path_in_language,
    prefab_texts,
    value_kind,
)
from scenecc.lsp.robot_parts import RobotParts, parts_of_file, parts_of_tree
from scenecc.spec.references import WORLD
from scenecc.variation.expression import OBSERVATIONS
from scenecc.variation.forms import LIST_FORMS
from scenecc.variation.operations import FUNCTIONS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.lsp.language import Siblings
    from scenecc.lsp.workspace import WorkspaceView


class Offer(NamedTuple):
    """A completion.

    Attributes:
        text: replaces the text from column `start` [characters].
        kind: `key`, `word`, `name`, `link`, `file`, `folder`, `variable` or `function`.
        start: the column.
        description: description for users.
        label: label, if it differs from the text.
    """

    text: str
    kind: str
    start: int
    description: str = ""
    label: str = ""


_NO_PARTS: Final = RobotParts([], [])

_ENTITY_DEPTH: Final = 2
"""Length of the path of an entity."""

_MOST_FILES: Final = 500
"""Maximum number of names read from one folder."""

SUFFIXES: Final[dict[Kind, tuple[str, ...]]] = {
    "scene file": (".yaml", ".yml"),
    "URDF file": (".urdf", ".xacro"),
    "MJCF file": (".xml", ".mjcf"),
    "SRDF file": (".srdf",),
    "mesh file": tuple(MESH_SUFFIXES),
    "image file": tuple(IMAGE_SUFFIXES),
    "starts file": (".json",),
}
"""Kind of file → its suffixes."""

_CALL: Final = re.compile(rf"\b({'|'.join(OBSERVATIONS)})\(((?:\s*(?:'[^']*'|\"[^\"]*\")\s*,)*)\s*['\"]([^'\"]*)$")
"""A call in an expression, up to the incomplete name that is an argument."""

_TEXT: Final = re.compile(r"['\"]([^'\"]*)['\"]")

_LONGEST_NAME: Final = 200
"""Longer names are not offered."""


def completions(view: WorkspaceView, path: Path, line: int, column: int) -> list[Offer]:
    """Returns the completions at a 0-based position; empty for a text that is too long."""
    text = view.text(path)
    if text is None or len(text.text) > MAX_CHARACTERS:
        return []
    return _Completer(view, text, line, column).offers()


class _Completer:
    def __init__(self, view: WorkspaceView, text: SceneText, line: int, column: int) -> None:
        self._view = view
        self._text = text
        self._cursor = cursor_at(text.lines, line, column)
        self._before = text.line(line)[:column]
        self._whole = text
        if not text.tree.is_whole:
            # Usually the line being typed is the one that is invalid YAML.
            kept = [*text.lines]
            kept[line : line + 1] = [""]
            self._whole = SceneText(text.path, "\n".join(kept))

    def offers(self) -> list[Offer]:
        """Returns all completions; those that begin with the typed text come first."""
        word = open_expression(self._cursor.typed)
        if word is not None:
            offers, typed = [*(self._observed() or self._variables(len(self._before) - len(word)))], word
        else:
            offers, typed = [*self._values(), *self._keys()], self._cursor.typed
        return sorted(offers, key=lambda one: not (one.label or one.text).startswith(typed))

    def _siblings(self, path: KeyPath) -> Mapping[str, str | None]:
        """Returns the keys of a mapping; keys before the position come from the text as typed."""
        return {**self._whole.scalars(path), **self._cursor.seen.get(path, {})}

    def _in_language(self, path: KeyPath) -> tuple[KeyPath, Siblings]:
        return path_in_language(self._view, self._text.path, path, self._siblings)

    def _keys(self) -> Iterator[Offer]:
        cursor = self._cursor
        if not cursor.keys:
            return
        place, siblings = self._in_language(cursor.path)
        kind = key_kind(place, siblings)
        if kind is not None:
            for offer in self._names(kind, (*cursor.path, ""), cursor.start):
                yield offer._replace(text=f"{offer.text}: ", label=offer.text)
        present = self._siblings(cursor.path)
        for word in keys_at(place, siblings):
            if word.text in present:
                continue
            below = is_mapping_key((*place, word.text), siblings)
            in_block = self._before[: cursor.start].strip(" -") == ""
            after = ":" if below and in_block else ": "
            yield Offer(word.text + after, "key", cursor.start, word.description, word.text)

    def _values(self) -> Iterator[Offer]:
        cursor = self._cursor
        if not cursor.values:
            return
        gap = " " if self._before.endswith(":") and not cursor.typed else ""
        place, siblings = self._in_language(cursor.path)
        kind, words = value_kind(place, siblings), values_at(place, siblings)
        offers: Iterable[Offer] = (Offer(word.text, "word", cursor.start, word.description) for word in words)
        if kind is not None:
            offers = (*self._names(kind, cursor.path, cursor.start), *offers)
        if kind is None and (form := _form_path(cursor.path)) is not None:
            # An alternative in a form is a value of the key that has the form.
            words = values_at(*self._in_language(form))
            offers = (*(Offer(word.text, "word", cursor.start, word.description) for word in words), *offers)
        inside = overridden_path(cursor.path)
        if inside is not None and len(inside) == _ENTITY_DEPTH:
            offers = (Offer(REMOVE, "word", cursor.start, "leaves it out"), *offers)
        if cursor.path[-2:-1] == ("with",):
            offers = (*self._argument_values(cursor.path, cursor.start), *offers)
        for offer in offers:
            yield offer._replace(text=gap + offer.text, label=offer.label or offer.text)

    def _names(self, kind: Kind, path: KeyPath, start: int) -> Iterator[Offer]:
        match kind:
            case "entity":
                yield from self._objects(start, with_world=path[-1] in {"relative_to", "parent", "child"})
            case "argument":
                yield from self._arguments(path, start)
            case "member":
                yield from self._members(path, start)
            case "link" | "joint":
                parts = self._robot(path) if path[:1] == ("entities",) else _NO_PARTS
                yield from (Offer(name, "link", start) for name in (parts.links if kind == "link" else parts.joints))
            case "material" | "group" | "frame" | "variable":
                yield from (Offer(name, "name", start, what) for name, what in self._list_names(SECTIONS_OF[kind]))
            case _:
                yield from self._files(kind, path, start)

    def _list_names(self, sections: tuple[str, ...]) -> Iterator[tuple[str, str]]:
        """Yields the names of sections, in this file and in included ones, with their source."""
        texts = (self._whole, *(one for one in self._view.namespace(self._text.path) if one.path != self._text.path))
        for text in texts:
            for section in sections:
                where = section if text is self._whole else f"{section}, {text.path.name}"
                yield from ((name, where) for name in text.names(section) if len(name) <= _LONGEST_NAME)

    def _objects(self, start: int, *, with_world: bool) -> Iterator[Offer]:
        known = self._view.objects(self._text.path)
        found = {name: Offer(name, "name", start, what) for name, what in self._list_names(SECTIONS_OF["entity"])}
        for name, one in known.items():
            found.setdefault(name, Offer(name, "name", start, one.section))
        found.pop(str(self._cursor.path[1]) if len(self._cursor.path) > 1 else "", None)
        if with_world:
            found.setdefault(WORLD, Offer(WORLD, "word", start, "the world"))
        yield from found.values()
        typed = self._cursor.typed
        for name in found:
            if typed.startswith(f"{name}/"):
                links = self._parts(("entities", name)).links
                yield from (Offer(f"{name}/{link}", "link", start, f"link of {name}") for link in links)

    def _robot(self, path: KeyPath) -> RobotParts:
        """Returns the links and joints of the articulation, or of its part, in which a name is typed."""
        inside = overridden_path(path)
        if inside is not None:
            written = (self._written_parts(text, inside[:_ENTITY_DEPTH]) for text in self._prefab(path))
            return next((found for found in written if found.links), _NO_PARTS)
        parts = [at for at, step in enumerate(path[:-2]) if step == "attach" and path[at + 2] != "to"]
        return self._parts(path[: parts[-1] + 2] if parts else path[:_ENTITY_DEPTH])

    def _parts(self, path: KeyPath) -> RobotParts:
        """Returns the links and joints of an articulation: those built last, or else those in its file or tree."""
        known = self._view.objects(self._text.path).get(str(path[-1])) if len(path) == _ENTITY_DEPTH else None
        if known is not None and known.links:
            return RobotParts([*known.links], [*known.joints])
        return self._written_parts(self._whole, path, self._siblings(path))

    def _written_parts(
        self, text: SceneText, path: KeyPath, typed: Mapping[str, str | None] | None = None
    ) -> RobotParts:
        """`typed`: keys of the articulation that may not be in the text."""
        keys = {**text.scalars(path), **(typed or {})}
        named = next((file for key in ("urdf", "mjcf") if (file := keys.get(key))), None)
        file = None if named is None else self._view.find_file(text.path, named)
        robot = None if file is None else self._view.text(file)
        if robot is not None:
            return parts_of_file(robot.text)
        tree = text.node((*path, "root"))
        return _NO_PARTS if tree is None else parts_of_tree(tree)

    def _files(self, kind: Kind, path: KeyPath, start: int) -> Iterator[Offer]:
        typed = self._cursor.typed
        folder, slash, _ = typed.rpartition("/")
        if kind == "scene file" and not slash:
            for name in shipped_names() if path[-1] == "use" else ():
                prefab = self._view.text(PREFAB_FOLDER / f"{name}.yaml")
                described = None if prefab is None else prefab.scalar(("description",))
                yield Offer(SHIPPED_PREFIX + name, "file", start, (described or "").partition("\n")[0])
        for name, is_folder in self._list_folder(folder):
            shown = f"{folder}/{name}" if slash else name
            if is_folder:
                yield Offer(f"{shown}/", "folder", start)
            elif name.lower().endswith(SUFFIXES[kind]) and (kind != "scene file" or self._is_part(folder, name)):
                yield Offer(shown, "file", start)

    def _list_folder(self, folder: str) -> list[tuple[str, bool]]:
        """Returns the names in a folder that the scene may read, each with whether it is a folder."""
        if "://" in folder or folder.startswith(("/", "~")) or "\0" in folder:
            return []
        base = (self._text.path.parent / folder).resolve()
        root = self._view.scope(self._text.path).root
        if root is None or not base.is_relative_to(root.resolve()):
            return []
        try:
            with os.scandir(base) as entries:
                found = [(one.name, one.is_dir()) for one in islice(entries, _MOST_FILES)]
        except OSError:
            return []
        return sorted(one for one in found if not one[0].startswith("."))

    def _is_part(self, folder: str, name: str) -> bool:
        """Returns whether a file is another scene."""
        file = (self._text.path.parent / folder).resolve() / name
        return file != self._text.path and self._view.is_scene(file)

    def _prefab(self, path: KeyPath) -> tuple[SceneText, ...]:
        return prefab_texts(self._view, self._text.path, path, self._siblings)

    def _arguments(self, path: KeyPath, start: int) -> Iterator[Offer]:
        present = self._siblings(path[:-1])
        for text in self._prefab(path):
            for name in text.names("params"):
                if name not in present:
                    yield Offer(name, "variable", start, describe_param(text, name))

    def _argument_values(self, path: KeyPath, start: int) -> Iterator[Offer]:
        """Yields the words that a prefab parameter accepts."""
        for text in self._prefab(path):
            param = ("params", path[-1])
            words = text.texts((*param, "options"))
            if text.scalar((*param, "type")) == "boolean" or text.scalar(param) in {"true", "false"}:
                words = ["true", "false"]
            yield from (Offer(word, "word", start) for word in words)

    def _members(self, path: KeyPath, start: int) -> Iterator[Offer]:
        present = self._siblings(path[:-1])
        for text in self._prefab(path):
            for section in ("entities", *OVERRIDE_SECTIONS):
                names = text.names(section)
                full = names if section == "entities" else [f"{section}/{name}" for name in names]
                yield from (Offer(name, "name", start, section) for name in full if name not in present)

    def _observed(self) -> list[Offer]:
        """Returns the names that may be typed in quotes, as an argument of a function of `expect`."""
        call = _CALL.search(self._cursor.typed) if self._cursor.path[:1] == ("expect",) else None
        if call is None:
            return []
        given, start = _TEXT.findall(call[2]), len(self._before) - len(call[3])
        arguments = OBSERVATIONS[call[1]]
        if len(given) < len(arguments) and arguments[len(given)] == "joint":
            return [Offer(name, "link", start) for name in self._parts(("entities", given[0])).joints]
        return [*self._objects(start, with_world=False)]

    def _variables(self, start: int) -> Iterator[Offer]:
        """Yields what an expression may read."""
        path = self._cursor.path
        for end in range(len(path), 0, -1):
            loops = {
                **self._whole.scalars((*path[:end], "repeat")),
                **self._cursor.seen.get((*path[:end], "repeat"), {}),
            }
            yield from (Offer(name, "variable", start, "loop variable") for name in loops)
        for text in (self._whole, *self._view.namespace(self._text.path)[1:]):
            yield from (Offer(name, "variable", start, describe_param(text, name)) for name in text.names("params"))
            yield from (Offer(name, "variable", start, "draw") for name in text.names("draws"))
        yield Offer("scene", "variable", start, "index of the scene")
        yield Offer("num_scenes", "variable", start, "number of parallel scenes")
        observed = OBSERVATIONS if path[:1] == ("expect",) else ()
        yield from (Offer(f"{name}(", "function", start, label=name) for name in (*observed, *FUNCTIONS))


def _form_path(path: KeyPath) -> KeyPath | None:
    """Returns the path of the form of which a path is an alternative."""
    at = next((at for at in (len(path) - 2, len(path) - 1) if at >= 0 and path[at] in LIST_FORMS), None)
    return None if at is None else path[:at]


def describe_param(text: SceneText, name: str) -> str:
    """Returns a parameter's type, default and description."""
    given = text.scalars(("params", name))
    if not given:
        return f"default {text.scalar(('params', name)) or '[…]'}"
    shown = [given.get("type"), f"default {given['default'] or '[…]'}" if "default" in given else "required"]
    head = ", ".join(part for part in shown if part)
    described = given.get("description")
    return f"{head}: {described}" if described else head
