"""Modules: a scene file merged with its includes into one namespace."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from scenecc.diagnostics.diagnostic import At, Location, Origin, Path
from scenecc.diagnostics.messages import cut
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.spec.parse import parse
from scenecc.spec.references import NAME_SECTIONS

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.expand.documents import Load, SceneDocument

SETTING_SECTIONS = ("physics", "environment")
MERGED_SECTIONS = (*NAME_SECTIONS, *SETTING_SECTIONS)
"""Sections that are merged from included files."""

EXPECT = "expect"
"""The section that is not merged: a module may have one per document."""

TOP_LEVEL_KEYS = ("name", "description", "num_scenes", "seed", "starts")
"""Keys that an included file cannot have."""


@dataclass(frozen=True, slots=True)
class ModulePart:
    """One document of a module.

    Attributes:
        document: the document.
        via: file and path of each `include` item that leads to it from the module's main file.
    """

    document: SceneDocument
    via: tuple[tuple[str | None, Path], ...] = ()

    def parent(self, use: Origin | None) -> Origin | None:
        """Returns the parent of its nodes' origins, if `use` uses the module."""
        for file, path in self.via:
            use = Origin(file, path, "", use)
        return use


@dataclass(frozen=True, slots=True)
class SectionEntry:
    """One entry of a section."""

    node: Any
    part: ModulePart
    path: Path

    def origin(self, use: Origin | None) -> Origin:
        """Returns its origin, if `use` uses the module."""
        return Origin(self.part.document.name, self.path, "", self.part.parent(use))


@dataclass(frozen=True, slots=True)
class Module:
    """A file with its includes.

    Attributes:
        main: the file itself.
        parts: the included documents in the order of merging, then the file itself.
        sections: entries by section and name.
        good: whether merging reported no error.
    """

    main: ModulePart
    parts: tuple[ModulePart, ...]
    sections: dict[str, dict[str, SectionEntry]] = field(default_factory=dict[str, dict[str, SectionEntry]])
    good: bool = True

    def section(self, name: str) -> dict[str, SectionEntry]:
        """Returns the entries of a section; empty if no document has it."""
        return self.sections.get(name, {})


class ModuleLibrary:
    """The documents and modules of one compilation. Each is read once.

    Attributes:
        documents: the documents read so far, by name.
    """

    def __init__(self, load: Load, deepest: int, sink: Sink) -> None:
        self.documents: dict[str | None, SceneDocument] = {}
        self.deepest = deepest
        self._load = load
        self._sink = sink
        self._sound: dict[str, bool] = {}
        self._modules: dict[str, Module] = {}
        self._named: dict[tuple[str, str], SceneDocument | None] = {}

    def add(self, document: SceneDocument) -> None:
        """Adds a document that is already validated."""
        self.documents[document.name] = document
        self._sound[document.identity] = True

    def locate(self, origin: Origin, at: At) -> Location:
        """Returns the location of a source origin: a `scenecc.diagnostics.diagnostic.Locator` for all documents."""
        document = self.documents.get(origin.file)
        return Location(origin.file) if document is None else document.document.locate(origin, at)

    def find(self, reference: str, owner: SceneDocument, place: Origin) -> SceneDocument | None:
        """Returns a referenced document, or None if it cannot be read or has errors, which are reported."""
        key = (reference, owner.identity)
        if key in self._named:
            return self._named[key]
        document = self._load(reference, owner, place)
        if document is not None and document.identity not in self._sound:
            self.documents.setdefault(document.name, document)
            parsed = parse(document.document.data, Origin(document.name, (), "", place), self._sink)
            self._sound[document.identity] = parsed is not None
        found = document if document is not None and self._sound[document.identity] else None
        self._named[key] = found
        return found

    def module(self, document: SceneDocument, use: Origin | None) -> Module:
        """Returns a document merged with its includes. `use` is the origin of its first use."""
        if document.identity not in self._modules:
            self._modules[document.identity] = _ModuleMerger(self, use, self._sink).module(document)
        return self._modules[document.identity]

    def is_too_deep(self, chain: list[str], place: Origin) -> bool:
        """Returns whether a chain of documents exceeds the depth limit, which is reported."""
        if len(chain) <= self.deepest:
            return False
        hint = "use fewer levels, or raise the limit with --limit depth=N or limits={'depth': N}"
        message = f"more than {self.deepest} files use one another in a chain: {chain_text(chain)}"
        self._sink.report("SC602", message, place, hint=hint)
        return True


def chain_text(chain: list[str]) -> str:
    """Formats a chain of document names, relative to the first one's folder. A long chain is shortened."""
    folder = posixpath.dirname(chain[0])
    names = [name.removeprefix(folder + "/") if folder else name for name in chain]
    names = [name if len(name) <= _MAX_NAME_CHARACTERS else "…" + name[-_MAX_NAME_CHARACTERS:] for name in names]
    return " → ".join(names if len(names) <= 12 else [*names[:6], "…", *names[-5:]])


_MAX_NAME_CHARACTERS = 60
"""Longest document name in a chain [characters]."""


class _ModuleMerger:
    """Merges a document with its includes."""

    def __init__(self, library: ModuleLibrary, use: Origin | None, sink: Sink) -> None:
        self._library = library
        self._use = use
        self._sink = sink
        self._parts: list[ModulePart] = []
        self._reached: set[str] = set()
        self._good = True

    def module(self, document: SceneDocument) -> Module:
        """Returns the merged module. Included documents come before those that include them."""
        main = ModulePart(document)
        self._add(main, [document])
        sections: dict[str, dict[str, SectionEntry]] = {}
        for part in self._parts:
            for section in MERGED_SECTIONS:
                node = part.document.document.data.get(section)
                if is_mapping(node):
                    self._join(sections.setdefault(section, {}), section, node, part)
        return Module(main, tuple(self._parts), sections, self._good)

    def _add(self, part: ModulePart, chain: list[SceneDocument]) -> None:
        """Adds a document after its includes. `chain` holds the documents that lead to it, and itself."""
        document = part.document
        self._reached.add(document.identity)
        items = document.document.data.get("include", [])
        for index, reference in enumerate(items if is_sequence(items) else [items]):
            path = ("include", index) if is_sequence(items) else ("include",)
            place = Origin(document.name, path, "", part.parent(self._use))
            if "${" in reference:
                self._report(
                    "SC203",
                    "`include` cannot contain an expression, because included files may declare parameters",
                    place,
                )
                continue
            found = self._library.find(reference, document, place)
            if found is None:
                self._good = False
                continue
            if any(found.identity == above.identity for above in chain):
                names = [above.shown for above in (*chain, found)]
                self._report("SC232", f"circular includes: {chain_text(names)}", place)
                continue
            inner = ModulePart(found, (*part.via, (document.name, path)))
            if found.identity in self._reached:
                continue
            if self._library.is_too_deep([above.shown for above in (*chain, found)], place):
                self._good = False
                continue
            self._check_keys(inner)
            self._add(inner, [*chain, found])
        self._parts.append(part)

    def _check_keys(self, part: ModulePart) -> None:
        for key in TOP_LEVEL_KEYS:
            if key in part.document.document.data:
                place = Origin(part.document.name, (key,), "", part.parent(self._use))
                self._report("SC230", f"an included file cannot have `{key}`", place, at="key")

    def _join(self, entries: dict[str, SectionEntry], section: str, node: dict[str, Any], part: ModulePart) -> None:
        for name, item in node.items():
            if name.startswith(NOTE_PREFIX):
                continue
            entry = SectionEntry(item, part, (section, name))
            first = entries.setdefault(name, entry)
            if first is not entry:
                what = "setting" if section in SETTING_SECTIONS else "name"
                message = f"the {what} `{cut(name)}` is already defined in another file"
                self._good = False
                self._sink.report(
                    "SC231",
                    message,
                    entry.origin(self._use),
                    at="key",
                    related=[("the first", first.origin(self._use), "key")],
                )

    def _report(self, code: str, message: str, place: Origin, **options: Any) -> None:
        self._good = False
        self._sink.report(code, message, place, **options)
