"""Default classes of an MJCF: what an element has that does not say it itself.

An element's class is the one that it names, else the one that the nearest body around it sets as `childclass`, else the
global one. A class has what the classes around it have and it does not say itself. ManiSkill's loader lays all these
over one another instead; where that gives something else, the difference is told.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from scenecc.diagnostics.messages import cut, suggest_name
from scenecc.robots.mjcf.attributes import Attributes

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from scenecc.robots.mjcf.report import Report
    from scenecc.robots.xml import Element

Given = dict[str, "Element"]
"""Attribute → the element that gives it."""

_GLOBAL = "main"

IGNORED_CLASS = "motor"
"""Geoms and bodies whose class begins so are not built, by ManiSkill's loader."""


@dataclass(frozen=True, slots=True)
class _Class:
    """What one class says itself. `parent`: name of the class around it."""

    parent: str | None
    tags: dict[str, Given] = field(default_factory=dict[str, Given])


@dataclass(frozen=True, slots=True)
class Scope:
    """The classes that bodies around an element set, outermost first."""

    names: tuple[str, ...] = ()


@dataclass(slots=True)
class Classes:
    """The default classes of a file."""

    report: Report
    _classes: dict[str, _Class] = field(default_factory=lambda: {_GLOBAL: _Class(None)})
    _chains: dict[tuple[str, str, bool], Given] = field(default_factory=dict[tuple[str, str, bool], Given])

    def known(self, name: str, element: Element, attribute: str) -> bool:
        """Whether there is a class of some name; if not, it is reported at the attribute that names it."""
        if name in self._classes:
            return True
        hint = suggest_name(name, (known for known in self._classes if known != _GLOBAL), self.report.findings.sink)
        self.report.error("SC482", f"there is no default class `{cut(name)}`", element.at(attribute), hint)
        return False

    def attributes(self, element: Element, scope: Scope, read: frozenset[str]) -> Attributes:
        """What an element has, its class's values with it.

        Args:
            element: of any kind.
            scope: where it stands.
            read: the names that are heeded; others are told as left out, wherever they stand.
        """
        named = element.attributes.get("class")
        names = scope.names
        if named is not None and self.known(named, element, "class"):
            names = (*names, named)
        given = self._chain(names[-1] if names else _GLOBAL, element.tag)
        own = dict.fromkeys(element.attributes, element)
        self.report.unread_attributes(element, read | {"class"})
        if len(names) > 1:
            self._compare(element, {**given, **own}, names, read)
        return Attributes(element, {**given, **own}, self.report)

    def inherited(self, tag: str, element: Element, scope: Scope) -> Attributes:
        """What an element of some kind would have that says nothing itself, in the body `element`."""
        return Attributes(element, self._chain(scope.names[-1] if scope.names else _GLOBAL, tag), self.report)

    def _compare(
        self, element: Element, given: Mapping[str, Element], names: Iterable[str], read: frozenset[str]
    ) -> None:
        """Tells where laying all classes over one another would give something else."""
        laid: Given = {}
        for name in (_GLOBAL, *names):
            laid.update(
                self._chain(name, element.tag, whole=False) if name != _GLOBAL else self._own(name, element.tag)
            )
        laid.update(dict.fromkeys(element.attributes, element))
        for name in sorted(read):
            mine, theirs = given.get(name), laid.get(name)
            if (mine and mine.attributes[name]) != (theirs and theirs.attributes[name]):
                self.report.differs(
                    "class",
                    f"`{name}` is what the element's own class has; ManiSkill's loader takes that of the classes "
                    "around it, too",
                    element.location,
                )
                return

    def _own(self, name: str, tag: str) -> Given:
        return self._classes[name].tags.get(tag, {})

    def _chain(self, name: str, tag: str, *, whole: bool = True) -> Given:
        """What a class says of a kind of element, with what it has from the classes around it.

        `whole`: with the global one, too.
        """
        key = (name, tag, whole)
        chain = self._chains.get(key)
        if chain is None:
            parent = self._classes[name].parent
            above = self._chain(parent, tag, whole=whole) if parent and (whole or parent != _GLOBAL) else {}
            chain = self._chains[key] = {**above, **self._own(name, tag)}
        return chain

    def read(self, sections: Iterable[Element], read: Mapping[str, frozenset[str]]) -> None:
        """Reads the sections `default`. `read`: the kinds of elements that are heeded, and which attributes."""
        for section in sections:
            self._section(section, None, read)

    def _section(self, section: Element, parent: str | None, read: Mapping[str, frozenset[str]]) -> None:
        name = section.attributes.get("class", _GLOBAL if parent is None else "")
        if not name:
            self.report.error("SC481", "a default class inside another has a name, in `class`", section.location)
            return
        if parent is None and name != _GLOBAL:
            # The outermost class is the global one whatever its name, as it was before MuJoCo 3.
            self._classes.setdefault(name, _Class(_GLOBAL))
        elif parent is not None:
            if name in self._classes:
                self.report.error("SC486", f"the default class `{cut(name)}` is defined twice", section.at("class"))
                return
            self._classes[name] = _Class(parent)
        if parent is None and "class" in section.attributes:
            self._named_global(section)
        target = self._classes[_GLOBAL if parent is None else name]
        for child in section.children:
            if child.tag == "default":
                self._section(child, name, read)
            elif child.tag in read:
                self.report.unread_attributes(child, read[child.tag])
                target.tags.setdefault(child.tag, {}).update(dict.fromkeys(child.attributes, child))

    def _named_global(self, section: Element) -> None:
        if any(child.tag != "default" for child in section.children):
            self.report.differs(
                "global class",
                "the outermost default class holds for all elements, its name notwithstanding; ManiSkill's loader "
                "takes it for those only that name it",
                section.location,
            )
