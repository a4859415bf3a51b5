"""What a name in a text means: where it is defined, through includes, prefabs and robots' files."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from scenecc.diagnostics.diagnostic import Location, locate_span
from scenecc.expand.overrides import OVERRIDE_SECTIONS
from scenecc.lsp.references import SECTIONS_OF, Mention, defined_kind, mentions
from scenecc.spec.references import WORLD

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from scenecc.diagnostics.diagnostic import Path as KeyPath
    from scenecc.lsp.analysis import Leaf, SceneText
    from scenecc.lsp.worker import SourcePlace
    from scenecc.lsp.workspace import WorkspaceView
    from scenecc.source.document import Span


class Definition(NamedTuple):
    """Where something is defined that is named.

    Attributes:
        file: of it.
        span: of its key, or of its line.
        path: of it, in a scene file; empty otherwise.
        start, end: the part of the mention that is its name [characters of the leaf's value].
        is_copy: whether that name is made from what is written, by repetition, an expression or a prefix.
    """

    file: Path
    span: Span
    path: KeyPath
    start: int
    end: int
    is_copy: bool = False

    @property
    def key(self) -> tuple[Path, int, int]:
        """The same for all that mention one thing."""
        return self.file, self.span[0], self.span[1]


_TOP: Final[Span] = (0, 0, 0)
"""Of a file as a whole."""

_DEEPEST: Final = 32
"""Prefabs inside one another that are followed."""


def mention_at(view: WorkspaceView, path: Path, line: int, column: int) -> tuple[SceneText, Leaf, Mention] | None:
    """The name at a 0-based place."""
    text = view.text(path)
    leaf = None if text is None else text.leaf_at(line, column)
    if text is None or leaf is None:
        return None
    place = leaf_location(text, leaf)
    for mention in mentions(leaf):
        part = locate_span(place, (mention.start, mention.end))
        if (part.column or 1) - 1 <= column <= (part.end_column or 1) - 1:
            return text, leaf, mention
    return None


def leaf_location(text: SceneText, leaf: Leaf) -> Location:
    """The place of a leaf as diagnostics have it."""
    line = text.line(leaf.line)
    end = len(line.rstrip()) if leaf.end is None else leaf.end
    return Location(str(text.path), leaf.line + 1, leaf.start + 1, end + 1, line)


def mention_location(text: SceneText, leaf: Leaf, start: int, end: int) -> Location:
    """The place of a part of a leaf's value."""
    return locate_span(leaf_location(text, leaf), (start, end))


def definition_of(view: WorkspaceView, text: SceneText, leaf: Leaf, mention: Mention) -> Definition | None:
    """Where the thing is defined that a name in a text means; None where nothing is found."""
    return _Resolver(view, text).definition(leaf, mention)


class _Resolver:
    """Looks names up as one file means them."""

    def __init__(self, view: WorkspaceView, text: SceneText, depth: int = 0) -> None:
        self._view = view
        self._text = text
        self._depth = depth

    def definition(self, leaf: Leaf, mention: Mention) -> Definition | None:
        """As `definition_of`."""
        if leaf.at == "key" and mention.kind == defined_kind(leaf.path):
            return Definition(self._text.path, leaf[:3], leaf.path, 0, len(leaf.text))
        found: Definition | None = None
        match mention.kind:
            case "object":
                found = self.object(mention.text)
            case "frame" | "material" | "group":
                found = self.in_sections(mention.text, SECTIONS_OF[mention.kind])
            case "variable":
                found = self._variable(leaf.path, mention.text)
            case "argument":
                found = self._argument(leaf.path, mention.text)
            case "inside":
                found = self._inside(leaf.path, mention.text)
            case "link":
                found = self._link(leaf.path, mention.text)
            case "file" | "scene file":
                file = self._view.find_file(self._text.path, mention.text)
                found = None if file is None else Definition(file, _TOP, (), 0, len(mention.text))
            case "joint":
                pass
        if found is None:
            return None
        return found._replace(start=mention.start + found.start, end=mention.start + found.end)

    def object(self, name: str) -> Definition | None:
        """An entity, a frame or a camera, or a link of an entity: the longest name that there is."""
        if name == WORLD:
            return None
        known = self._view.objects(self._text.path)
        for end in _ends(name):
            here = self.in_sections(name[:end], SECTIONS_OF["object"])
            one = known.get(name[:end])
            if here is None and (one is None or one.place is None):
                continue
            if end == len(name):
                return here or self._at_place(one.place if one else None, name)
            link = None if one is None else one.links.get(name[end + 1 :])
            if link is not None:
                return self._at_place(link, name, start=end + 1)
            return here and self._find_in_instance(here.path, name, end)
        return None

    def _find_in_instance(self, path: KeyPath, name: str, end: int) -> Definition | None:
        """What is inside an instance, of a scene that has no plan yet. `end`: of the instance's name."""
        if "prefix" in self._text.scalars(path):
            return None
        inner = self._prefab(path)
        found = None if inner is None else inner.object(name[end + 1 :])
        return found and found._replace(start=found.start + end + 1, end=found.end + end + 1)

    def _prefab(self, path: KeyPath) -> _Resolver | None:
        """Looks names up in the prefab of an instance."""
        use = self._text.scalar((*path, "use"))
        file = None if use is None or self._depth > _DEEPEST else self._view.find_file(self._text.path, use)
        text = None if file is None else self._view.text(file)
        return None if text is None else _Resolver(self._view, text, self._depth + 1)

    def in_sections(self, name: str, sections: tuple[str, ...]) -> Definition | None:
        """An entry of one of some sections, here or in what is included."""
        for text in self._view.namespace(self._text.path):
            for section in sections:
                span = text.key_span((section, name))
                if span is not None:
                    return Definition(text.path, span, (section, name), 0, len(name))
        return None

    def _variable(self, path: KeyPath, name: str) -> Definition | None:
        """A loop variable around, or else a draw or parameter."""
        for end in range(len(path), 0, -1):
            loop = (*path[:end], "repeat", name)
            span = self._text.key_span(loop)
            if span is not None:
                return Definition(self._text.path, span, loop, 0, len(name))
        return self.in_sections(name, SECTIONS_OF["variable"])

    def _argument(self, path: KeyPath, name: str) -> Definition | None:
        prefab = self._prefab(path[:-2])
        return None if prefab is None else prefab.in_sections(name, ("params",))

    def _inside(self, path: KeyPath, name: str) -> Definition | None:
        """What an override names."""
        prefab = self._prefab(path[:-2])
        if prefab is None:
            return None
        section, slash, rest = name.partition("/")
        if slash and section in OVERRIDE_SECTIONS:
            found = prefab.in_sections(rest, (section,))
            return found and found._replace(start=len(section) + 1, end=len(name))
        return prefab.object(name)

    def _link(self, path: KeyPath, name: str) -> Definition | None:
        one = self._view.objects(self._text.path).get(str(path[1])) if path[:1] == ("entities",) else None
        return None if one is None else self._at_place(one.links.get(name), name)

    def _at_place(self, place: SourcePlace | None, name: str, start: int = 0) -> Definition | None:
        """`start`: of the part of the name that is asked for."""
        if place is None:
            return None
        start = max(start, name.rfind("/") + 1) if place.path else start
        if not place.path:
            return Definition(place.file, (place.line, place.start, place.end), (), start, len(name))
        text = self._view.text(place.file)
        span = None if text is None else text.key_span(place.path)
        if span is None:
            return None
        is_copy = place.is_copy or place.path[-1] != name[start:]
        return Definition(place.file, span, place.path, start, len(name), is_copy)


def _ends(name: str) -> Iterator[int]:
    """Where a name ends, or one of those that it begins with."""
    end = len(name)
    while end > 0:
        yield end
        end = name.rfind("/", 0, end)


class Use(NamedTuple):
    """A mention of something, and what it leads to."""

    text: SceneText
    leaf: Leaf
    definition: Definition

    @property
    def is_definition(self) -> bool:
        """Whether it is the key that gives the name."""
        return self.leaf.at == "key" and self.leaf.path == self.definition.path


def uses_of(view: WorkspaceView, wanted: Definition) -> Iterator[Use]:
    """Every mention of what is defined at a place, in all scene files around, its own key first."""
    for text in sorted(view.scene_files(wanted.file), key=lambda one: one.path != wanted.file):
        yield from uses_in(view, text, wanted)


def uses_in(view: WorkspaceView, text: SceneText, wanted: Definition) -> Iterator[Use]:
    """The same in one file."""
    name = str(wanted.path[-1]) if wanted.path else ""
    for leaf in text.leaves:
        # A copy's name begins like what it is a copy of.
        for mention in mentions(leaf) if not name or name in leaf.text else ():
            found = definition_of(view, text, leaf, mention)
            if found is not None and found.key == wanted.key:
                yield Use(text, leaf, found)
