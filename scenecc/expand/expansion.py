"""The result of expansion and its construction: plain data of one scene file, and the origin of each part."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from itertools import product
from typing import TYPE_CHECKING, Any, NoReturn

from scenecc.diagnostics.diagnostic import At, Location, Origin, Path, RelatedPlace, chain_of
from scenecc.diagnostics.frozen import frozen
from scenecc.diagnostics.messages import cut, show
from scenecc.spec.references import NameScopes, qualified_name

if TYPE_CHECKING:
    from scenecc.diagnostics import Sink
    from scenecc.expand.documents import SceneDocument
    from scenecc.variation.operations import ExpressionError


@frozen
class ItemSpan:
    """The items of an expanded list that one written item stands for, up to the start of the next.

    Attributes:
        start: index of the first.
        index: of the written item.
        loop: that repeats it; None: it is one.
        number: of the copy that is the first.
    """

    start: int
    index: int
    loop: Loop | None
    number: int = 0


ListKey = tuple["Path", tuple[int, ...]]
"""A list as written below a node, and in which items of the lists with repeated ones around it, as they are built."""


@frozen
class SourceMark:
    """The place of a node as written, and its copy. Cheap to make: `origin` is computed when something is reported.

    Attributes:
        file, path, parent: as `Origin` has them.
        copies: the loops around, with the number of the copy in each.
    """

    file: str | None
    path: Path
    parent: Origin | None = None
    copies: tuple[tuple[Loop, int], ...] = ()

    @property
    def copy(self) -> str:
        """Which copy it is: "i=1, j=-1". A loop that makes one copy tells nothing."""
        return ", ".join([loop.text(number) for loop, number in self.copies if loop.count > 1])

    @property
    def origin(self) -> Origin:
        """The origin as written."""
        return Origin(self.file, self.path, self.copy, self.parent)


@frozen
class TraceRecord:
    """Where a named node of the expanded data (`entities.leg_0`) was written.

    Attributes:
        mark: of the node.
        lists: the items of each list with repeated ones; None where there is none.
        by_scene: path as written below the node → scenes, for each `per_scene` list that was turned into a mapping.
        overrides: path below the node, in the expanded data → where the override is written that gives what stands
            there.
    """

    mark: SourceMark
    lists: Mapping[ListKey, tuple[ItemSpan, ...]] | None = None
    by_scene: Mapping[Path, tuple[int, ...]] | None = None
    overrides: Mapping[Path, OverridePlace] | None = None

    def trace(self, path: Path) -> Origin:
        """The origin as written of what stands at a path below the node."""
        if self.overrides:
            given = [(end, place) for end in range(len(path) + 1) if (place := self.overrides.get(path[:end]))]
            if given:
                end, place = max(given, key=lambda one: one[1].order)
                return place.record.trace((*place.path, *path[end:]))
        written: list[str | int] = []
        around: list[int] = []
        mark = self.mark
        copies = [mark.copy] if mark.copy else []
        for step in path:
            items = self.lists.get((tuple(written), tuple(around))) if self.lists and isinstance(step, int) else None
            if items and isinstance(step, int):
                item = items[bisect_right(items, step, key=_start) - 1]
                written.append(item.index)
                around.append(step)
                if item.loop is not None and item.loop.count > 1:
                    copies.append(item.loop.text(item.number + step - item.start))
            elif self.by_scene and (scenes := self.by_scene.get(tuple(written))) is not None:
                # Its `default` is its first item.
                written.append(0 if step == "default" else scenes.index(int(step)))
            else:
                written.append(step)
        return Origin(mark.file, (*mark.path, *written), ", ".join(copies), mark.parent)


@frozen
class OverridePlace:
    """Where an override is written that gives a value.

    Attributes:
        record: of the override.
        path: of the value in it.
        order: of several overrides of one object the last is in force.
    """

    record: TraceRecord
    path: Path
    order: int


_OVERRIDES_SHOWN = 3


def _start(items: ItemSpan) -> int:
    return items.start


@dataclass(frozen=True, slots=True)
class Expansion:
    """One scene file that uses no other, as plain data.

    Attributes:
        data: what `scenecc.spec.parse.parse(..., expanded=True)` takes: no `params`, `include`, `repeat`, `if`, `use`;
            where a draw or `scene` is read there is a `scenecc.variation.forms.Template`. `num_scenes` and `seed` in
            it are those that override the file's, where these are given.
        names: what names in it mean.
        selections: entity, frame, camera, constraint or light → scene indices, ascending, where an instance narrows
            them; `scene_idxs` is then left out of the data.
        documents: by the name that origins have.
        params: values that the parameters of the top document were given, as plain data.
        defaults: of its other parameters, as written; None where there is none.
    """

    data: dict[str, Any]
    names: NameScopes
    selections: Mapping[str, tuple[int, ...]]
    documents: Mapping[str | None, SceneDocument]
    records: Mapping[tuple[str, str], TraceRecord]
    params: Mapping[str, Any]
    defaults: Mapping[str, Any]

    def trace(self, origin: Origin) -> Origin:
        """An origin in the expanded data as it was written: file, path, copy, and the uses that led there."""
        path = origin.path
        record = self.records.get((str(path[0]), str(path[1]))) if len(path) > 1 else None
        return origin if record is None else record.trace(path[2:])

    def overridden(self, origin: Origin) -> tuple[Origin, ...]:
        """The keys that overrides give the node of an origin, where an override is not what the origin leads to."""
        path = origin.path
        record = self.records.get((str(path[0]), str(path[1]))) if len(path) > 1 else None
        overrides = record.overrides or {} if record else {}
        if any(path[2 : 2 + len(given)] == given for given in overrides):
            return ()
        keys = dict.fromkeys(place.record.trace(place.path[:1]) for place in overrides.values())
        return tuple(keys)[:_OVERRIDES_SHOWN]

    def reference(self, uri: str, origin: Origin) -> tuple[str, SceneDocument]:
        """A path as the document that wrote it means it, for `scenecc.source.paths.resolve_path`.

        Args:
            uri: as in the expanded data.
            origin: of the value, in the expanded data.

        Returns:
            The path or uri, and the document whose folder a path is relative to.
        """
        document = self.documents[self.trace(origin).file]
        return document.reference(uri), document


_MAX_VALUE_CHARACTERS = 24
"""How long the value of a variable may be in the name of a copy [characters]."""


class Loop:
    """The product of lists with the names of the variables that run through them, the last varying fastest."""

    __slots__ = ("axes", "count", "names")

    def __init__(self, axes: Mapping[str, Sequence[Any]]) -> None:
        self.names = tuple(axes)
        self.axes = tuple(axes.values())
        self.count = math.prod(map(len, self.axes))

    def __iter__(self) -> Iterator[tuple[Any, ...]]:
        # Of a product that is empty the other lists may be as long as they like.
        return product(*self.axes) if self.count else iter(())

    def text(self, number: int) -> str:
        """The loop variables of a copy: "i=1, j=-1"."""
        told: list[str] = []
        for name, axis in zip(reversed(self.names), reversed(self.axes), strict=True):
            number, index = divmod(number, len(axis))
            value = axis[index]
            told.append(f"{name}={value if type(value) is int else show(value, _MAX_VALUE_CHARACTERS)}")
        return ", ".join(reversed(told))


_MAX_COUNT_SHOWN = 10**18

_VALUES_PER_OBJECT = 8
"""How many values of an argument count as an object: each is looked through in every use."""


class BudgetExhausted(Exception):
    """A limit was reached and reported: nothing more is expanded."""


class ObjectBudget:
    """How many of something may still be made.

    Args:
        code: of the report when there are more.
        what: they are.
        name: of the limit.
        most: the limit.
    """

    def __init__(self, code: str, what: str, name: str, most: int) -> None:
        self._code, self._what, self._name = code, what, name
        self._most = self._left = most

    def take(self, count: int, frame: ExpansionFrame, path: Path) -> None:
        """Takes so many away.

        Raises:
            BudgetExhausted: there are not so many; that is reported.
        """
        self._left -= count
        if self._left < 0:
            self._exhaust(frame.sink, frame.origin(path))

    def take_for(self, values: int, place: Origin | Location, sink: Sink) -> None:
        """Takes as many away as so many values of an argument count for.

        Raises:
            BudgetExhausted: there are not so many; that is reported.
        """
        self._left -= values // _VALUES_PER_OBJECT
        if self._left < 0:
            self._exhaust(sink, place)

    @property
    def most_values(self) -> int:
        """How many values an argument may still hold, and one more object."""
        return (self._left + 1) * _VALUES_PER_OBJECT

    def _exhaust(self, sink: Sink, place: Origin | Location) -> NoReturn:
        needed = self._most - self._left
        shown = f"at least {needed}" if needed <= _MAX_COUNT_SHOWN else "more than 10¹⁸"
        hint = f"raise it with --limit {self._name}=N or limits={{'{self._name}': N}}"
        message = f"{shown} {self._what} are more than the limit of {self._most}"
        sink.report(self._code, message, place, hint=hint)
        raise BudgetExhausted


@dataclass(slots=True, eq=False)
class ExpansionFrame:
    """One document as it is expanded in one place: for one use of it, and for one copy of what is repeated in it.

    Attributes:
        file: the document's name.
        parent: what brought it in; None for the top document.
        values: name → value of parameters, loop variables and the like. Changes from copy to copy.
        failed: names without a value, which was reported.
        objects: how many may still be made.
        sink: takes the diagnostics.
        copies: the loops around, with the number of the copy in each.
        lists: of the lists with repeated items met so far, what their items stand for.
        around: the items of such lists that are being made, the outermost first.
        measure: finds meshes of the document, where patterns are made of it.
    """

    file: str | None
    parent: Origin | None
    values: dict[str, Any]
    objects: ObjectBudget
    sink: Sink
    failed: AbstractSet[str] = frozenset()
    copies: list[tuple[Loop, int]] = field(default_factory=list[tuple["Loop", int]])
    lists: dict[ListKey, tuple[ItemSpan, ...]] = field(default_factory=dict["ListKey", tuple[ItemSpan, ...]])
    around: list[int] = field(default_factory=list[int])
    measure: MeasureMesh | None = None

    def mark(self, path: Path) -> SourceMark:
        """The place of a node of the document, in the copy at hand."""
        return SourceMark(self.file, path, self.parent, tuple(self.copies))

    def origin(self, path: Path) -> Origin:
        """The same, for a report."""
        return self.mark(path).origin

    def each_copy(self, loop: Loop) -> Iterator[int]:
        """The number of each copy that a loop makes, while the frame has its values."""
        for number, members in enumerate(loop):
            self.values.update(zip(loop.names, members, strict=True))
            self.copies.append((loop, number))
            yield number
            self.copies.pop()
        for name in loop.names:
            self.values.pop(name, None)

    def report(
        self,
        code: str,
        message: str,
        path: Path,
        *,
        at: At = "value",
        hint: str | None = None,
        related: Iterable[RelatedPlace] = (),
    ) -> None:
        """Reports something about a node of the document."""
        self.sink.report(code, message, self.origin(path), at=at, hint=hint, related=related)

    def fail(self, error: ExpressionError, path: Path, code: str = "SC202") -> None:
        """Reports an expression, at its place within the scalar at `path`."""
        self.sink.report(code, error.message, self.origin(path), hint=error.hint, span=(error.start, error.end))


MeasureMesh = Callable[[str, Origin], list[list[float]] | None]
"""The bounds `[[x, y, z], [x, y, z]]` of a mesh that a document names (path as written, where); None where that was
reported."""

MeshMeasurer = Callable[["SceneDocument", str, Origin], list[list[float]] | None]
"""The same of any document."""

_SECTIONS = (
    "physics", "environment", "materials", "collision_groups", "draws", "frames", "entities", "constraints", "lights",
    "cameras", "expect",
)  # fmt: skip


def scoped_name(scope: str, name: str) -> str:
    """The full name of a material, group or draw of a scope."""
    return f"{scope}/{name}" if scope else name


class ExpansionWriter:
    """Collects what is expanded, section by section.

    Attributes:
        sections: of the expanded data.
        names: as `Expansion` has them.
        selections: likewise.
        removed: section (`use` for an instance) and full name of what an override removes → where that is written.
    """

    def __init__(self, top: str | None, sink: Sink) -> None:
        self.sections: dict[str, dict[str, Any]] = {name: {} for name in _SECTIONS}
        self.names = NameScopes()
        self.selections: dict[str, tuple[int, ...]] = {}
        self.removed: dict[tuple[str, str], Origin] = {}
        self._records: dict[tuple[str, str], TraceRecord] = {}
        self._top = top
        self._sink = sink

    def add(
        self,
        section: str,
        name: str,
        node: Any,
        mark: SourceMark,
        lists: Mapping[ListKey, tuple[ItemSpan, ...]] | None = None,
        by_scene: Mapping[Path, tuple[int, ...]] | None = None,
        overrides: Mapping[Path, OverridePlace] | None = None,
    ) -> bool:
        """Writes a named node; False, reported, where there is one of the name.

        Args:
            section: of the data.
            name: the full one.
            node: plain data.
            mark: where it is written.
            lists: its lists that hold repeated items.
            by_scene: as `TraceRecord` has it.
            overrides: likewise.
        """
        entries = self.sections[section]
        if name in entries:
            self._report_twice(section, name, mark.origin)
            return False
        entries[name] = node
        if lists or overrides or mark.copies or mark.parent or mark.file != self._top or mark.path != (section, name):
            self._records[section, name] = TraceRecord(mark, lists or None, by_scene, overrides or None)
        return True

    def counts(self) -> dict[str, int]:
        """How many nodes each section has."""
        return {section: len(entries) for section, entries in self.sections.items()}

    def remove(self, start: Mapping[str, int], place: Origin) -> None:
        """Takes out what came after `start`, as `counts` gave it: an instance that is removed at a place."""
        for section, entries in self.sections.items():
            for name in list(entries)[start[section] :]:
                del entries[name]
                self.selections.pop(qualified_name(section, name), None)
                self.removed.setdefault((section, name), place)

    def _report_twice(self, section: str, name: str, second: Origin) -> None:
        """At the uses that brought the two in, where those are not the same."""
        first = self.origin(section, name)
        first, second = _outermost_use(first, second), _outermost_use(second, first)
        uses = [origin.path[-1:] == ("use",) for origin in (first, second)]
        related: list[RelatedPlace] = [("the first of this name", first, "value" if uses[0] else "key")]
        message = f"the name `{cut(name)}` is used twice in the {section}"
        hint = None
        if any(uses):
            hint = "give one of them another `prefix`" if all(uses) else 'give the instance a `prefix` other than ""'
        self._sink.report("SC221", message, second, at="value" if uses[1] else "key", hint=hint, related=related)

    def origin(self, section: str, name: str) -> Origin:
        """Where a named node was written."""
        record = self._records.get((section, name))
        return Origin(self._top, (section, name)) if record is None else record.mark.origin

    def trace(self, section: str, name: str, path: Path) -> Origin:
        """Where something was written that stands at a path below a named node."""
        record = self._records.get((section, name))
        return Origin(self._top, (section, name, *path)) if record is None else record.trace(path)

    def expansion(
        self,
        head: dict[str, Any],
        documents: Mapping[str | None, SceneDocument],
        params: Mapping[str, Any],
        defaults: Mapping[str, Any],
    ) -> Expansion:
        """All of it. `head`: the keys that stand before the sections; the others as of `Expansion`."""
        data = {**head, **{name: entries for name, entries in self.sections.items() if entries}}
        return Expansion(data, self.names, self.selections, documents, self._records, params, defaults)


def _outermost_use(origin: Origin, other: Origin) -> Origin:
    """The outermost use that brought one of two in, and not the other; itself where there is none."""
    shared = list(chain_of(other))
    uses = [place for place in chain_of(origin) if place not in shared and place.path[-1:] == ("use",)]
    return uses[-1] if uses else origin
