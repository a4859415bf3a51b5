"""The data that expansion writes, and what it remembers about it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenecc.diagnostics import Origin
from scenecc.diagnostics.messages import cut
from scenecc.expand.expansion import Expansion, Items, Mark, Record

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from scenecc.diagnostics import Path, Sink
    from scenecc.diagnostics.diagnostic import RelatedPlace
    from scenecc.expand.documents import SceneDocument
    from scenecc.spec.param_types import ParamType

_SECTIONS = (
    "physics", "environment", "materials", "collision_groups", "draws", "frames", "entities", "constraints", "lights",
    "cameras",
)  # fmt: skip


def scoped(scope: str, name: str) -> str:
    """The full name of a material, group or draw of a scope."""
    return f"{scope}/{name}" if scope else name


class Output:
    """What is written.

    Attributes:
        sections: of the expanded data.
        scopes, prefixes, anchors, given, wanted, selections, used_materials: as `Expansion` has them.
    """

    def __init__(self, top: str | None, sink: Sink) -> None:
        self.sections: dict[str, dict[str, Any]] = {name: {} for name in _SECTIONS}
        self.scopes: dict[str, str] = {}
        self.prefixes: dict[str, str] = {}
        self.anchors: dict[str, str] = {}
        self.given: dict[str, str] = {}
        self.wanted: dict[str, ParamType] = {}
        self.selections: dict[str, tuple[int, ...]] = {}
        self.used_materials: set[str] = set()
        self._records: dict[tuple[str, str], Record] = {}
        self._top = top
        self._sink = sink

    def add(
        self,
        section: str,
        name: str,
        node: Any,
        mark: Mark,
        lists: Mapping[Path, tuple[Items, ...]] | None = None,
        by_scene: Mapping[Path, tuple[int, ...]] | None = None,
    ) -> bool:
        """Writes a named node; False, reported, where there is one of the name.

        Args:
            section: of the data.
            name: the full one.
            node: plain data.
            mark: where it is written.
            lists: its lists that hold repeated items.
            by_scene: as `Record` has it.
        """
        entries = self.sections[section]
        if name in entries:
            self._report_twice(section, name, mark.origin)
            return False
        entries[name] = node
        if lists or mark.copies or mark.parent or mark.file != self._top or mark.path != (section, name):
            self._records[section, name] = Record(mark, lists or None, by_scene)
        return True

    def _report_twice(self, section: str, name: str, second: Origin) -> None:
        """At the uses that brought the two in, where those are not the same."""
        first, second = (_brought(one, other) for one, other in _both_ways(self.origin(section, name), second))
        uses = [origin.path[-1:] == ("use",) for origin in (first, second)]
        related: list[RelatedPlace] = [("the first of this name", first, "value" if uses[0] else "key")]
        message = f"the name `{cut(name)}` comes twice among the {section}"
        hint = None
        if any(uses):
            hint = "give one of them another `prefix`" if all(uses) else 'give the instance a `prefix` other than ""'
        self._sink.report("SC221", message, second, at="value" if uses[1] else "key", hint=hint, related=related)

    def origin(self, section: str, name: str) -> Origin:
        """Where a named node was written."""
        record = self._records.get((section, name))
        return Origin(self._top, (section, name)) if record is None else record.mark.origin

    def expansion(self, head: dict[str, Any], documents: Mapping[str | None, SceneDocument]) -> Expansion:
        """All of it. `head`: the keys that stand before the sections."""
        return Expansion(
            data={**head, **{name: entries for name, entries in self.sections.items() if entries}},
            scopes=self.scopes,
            prefixes=self.prefixes,
            anchors=self.anchors,
            given=self.given,
            wanted=self.wanted,
            selections=self.selections,
            used_materials=frozenset(self.used_materials),
            documents=documents,
            records=self._records,
        )


def _both_ways(a: Origin, b: Origin) -> tuple[tuple[Origin, Origin], tuple[Origin, Origin]]:
    return (a, b), (b, a)


def _brought(origin: Origin, other: Origin) -> Origin:
    """The outermost use that brought one of two in, and not the other; itself where there is none."""
    shared = list(_chain(other))
    uses = [place for place in _chain(origin) if place not in shared and place.path[-1:] == ("use",)]
    return uses[-1] if uses else origin


def _chain(origin: Origin | None) -> Iterator[Origin]:
    while origin is not None:
        yield origin
        origin = origin.parent
