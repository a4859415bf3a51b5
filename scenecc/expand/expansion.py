"""The result of expansion: plain data of one scene file, with the origin of each part."""

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
    """The items of an expanded list that come from one item of the source. They end at the next span's start.

    Attributes:
        start: index of the first expanded item.
        index: index of the source item.
        loop: the loop that repeats it; None if it is not repeated.
        number: copy number of the first expanded item.
    """

    start: int
    index: int
    loop: Loop | None
    number: int = 0


ListKey = tuple["Path", tuple[int, ...]]
"""Source path of a list below its node, and the expanded indices in the enclosing lists with repeated items."""


@frozen
class SourceMark:
    """The source place of a node, and its copy. Cheap to create: `origin` is computed only for a report.

    Attributes:
        file, path, parent: as in `Origin`.
        copies: the enclosing loops, with the copy number in each.
    """

    file: str | None
    path: Path
    parent: Origin | None = None
    copies: tuple[tuple[Loop, int], ...] = ()

    @property
    def copy(self) -> str:
        """The loop variables of the copy: "i=1, j=-1". Loops with a single copy are left out."""
        return ", ".join([loop.text(number) for loop, number in self.copies if loop.count > 1])

    @property
    def origin(self) -> Origin:
        """The origin in the source."""
        return Origin(self.file, self.path, self.copy, self.parent)


@frozen
class TraceRecord:
    """Source of a named node of the expanded data (`entities.leg_0`).

    Attributes:
        mark: place of the node.
        lists: the spans of each list with repeated items; None if it has no such list.
        by_scene: source path below the node → scenes, for each `per_scene` list that was turned into a mapping.
        overrides: path below the node, in the expanded data → place of the override that sets its value.
    """

    mark: SourceMark
    lists: Mapping[ListKey, tuple[ItemSpan, ...]] | None = None
    by_scene: Mapping[Path, tuple[int, ...]] | None = None
    overrides: Mapping[Path, OverridePlace] | None = None

    def trace(self, path: Path) -> Origin:
        """Returns the source origin of the value at a path below the node."""
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
                # `default` was made from the first item.
                written.append(0 if step == "default" else scenes.index(int(step)))
            else:
                written.append(step)
        return Origin(mark.file, (*mark.path, *written), ", ".join(copies), mark.parent)


@frozen
class OverridePlace:
    """The place of a value in an override.

    Attributes:
        record: source of the override.
        path: path of the value in the override.
        order: number of the override; the highest wins.
    """

    record: TraceRecord
    path: Path
    order: int


_OVERRIDES_SHOWN = 3


def _start(items: ItemSpan) -> int:
    return items.start


@dataclass(frozen=True, slots=True)
class Expansion:
    """One self-contained scene file, as plain data.

    Attributes:
        data: input of `scenecc.spec.parse.parse(..., expanded=True)`, without `params`, `include`, `repeat`, `if` and
            `use`. An expression that reads a draw or `scene` is a `scenecc.variation.forms.Template`. `num_scenes`
            and `seed` include the caller's overrides.
        names: resolves names in the data.
        selections: entity, frame, camera, constraint or light → scene indices, ascending, if an instance narrows
            them. Its `scene_idxs` is then left out of the data.
        documents: documents by their name in origins.
        records: section and name → source of the node.
        params: given values of the top document's parameters, as plain data.
        defaults: defaults of its other parameters, unevaluated; None without a default.
    """

    data: dict[str, Any]
    names: NameScopes
    selections: Mapping[str, tuple[int, ...]]
    documents: Mapping[str | None, SceneDocument]
    records: Mapping[tuple[str, str], TraceRecord]
    params: Mapping[str, Any]
    defaults: Mapping[str, Any]

    def trace(self, origin: Origin) -> Origin:
        """Maps an origin in the expanded data to its source: file, path, copy and the chain of uses."""
        path = origin.path
        record = self.records.get((str(path[0]), str(path[1]))) if len(path) > 1 else None
        return origin if record is None else record.trace(path[2:])

    def overridden(self, origin: Origin) -> tuple[Origin, ...]:
        """Returns the override keys that change an origin's node; empty if the origin itself is in an override."""
        path = origin.path
        record = self.records.get((str(path[0]), str(path[1]))) if len(path) > 1 else None
        overrides = record.overrides or {} if record else {}
        if any(path[2 : 2 + len(given)] == given for given in overrides):
            return ()
        keys = dict.fromkeys(place.record.trace(place.path[:1]) for place in overrides.values())
        return tuple(keys)[:_OVERRIDES_SHOWN]

    def reference(self, uri: str, origin: Origin) -> tuple[str, SceneDocument]:
        """Returns the path or URI for `scenecc.source.paths.resolve_path`, and the document that a path is relative to.

        `origin` is that of the value in the expanded data.
        """
        document = self.documents[self.trace(origin).file]
        return document.reference(uri), document


_MAX_VALUE_CHARACTERS = 24
"""Longest value of a variable in the name of a copy [characters]."""


class Loop:
    """The product of named lists. The last loop variable varies fastest."""

    __slots__ = ("axes", "count", "names")

    def __init__(self, axes: Mapping[str, Sequence[Any]]) -> None:
        self.names = tuple(axes)
        self.axes = tuple(axes.values())
        self.count = math.prod(map(len, self.axes))

    def __iter__(self) -> Iterator[tuple[Any, ...]]:
        # `product` would first copy the other lists, which may be huge, although the result is empty.
        return product(*self.axes) if self.count else iter(())

    def text(self, number: int) -> str:
        """Returns the loop variables of a copy as text: "i=1, j=-1"."""
        told: list[str] = []
        for name, axis in zip(reversed(self.names), reversed(self.axes), strict=True):
            number, index = divmod(number, len(axis))
            value = axis[index]
            told.append(f"{name}={value if type(value) is int else show(value, _MAX_VALUE_CHARACTERS)}")
        return ", ".join(reversed(told))


_MAX_COUNT_SHOWN = 10**18

_VALUES_PER_OBJECT = 8
"""Number of argument values that count as one object, since every use walks through all of them."""


class BudgetExhausted(Exception):
    """A limit was exceeded and reported. Expansion stops."""


class ObjectBudget:
    """Counts created objects against a limit.

    Args:
        code: diagnostic code when the limit is exceeded.
        what: what is counted, as named in the message.
        name: name of the limit.
        most: the limit.
    """

    def __init__(self, code: str, what: str, name: str, most: int) -> None:
        self._code, self._what, self._name = code, what, name
        self._most = self._left = most

    def take(self, count: int, frame: ExpansionFrame, path: Path) -> None:
        """Spends `count` objects.

        Raises:
            BudgetExhausted: fewer are left. The error is reported first.
        """
        self._left -= count
        if self._left < 0:
            self._exhaust(frame.sink, frame.origin(path))

    def take_for(self, values: int, place: Origin | Location, sink: Sink) -> None:
        """Spends the objects that a number of argument values counts as.

        Raises:
            BudgetExhausted: fewer are left. The error is reported first.
        """
        self._left -= values // _VALUES_PER_OBJECT
        if self._left < 0:
            self._exhaust(sink, place)

    @property
    def most_values(self) -> int:
        """Number of argument values that certainly exceeds the budget: one object more than is left."""
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
    """Evaluation state of a document, for one use of it and the current copy of a repeated node.

    Attributes:
        file: the document's name.
        parent: origin of the `use` or `include`; None for the top document.
        values: values of parameters, loop variables and draws, by name. They change with each copy.
        failed: names whose value has a reported error.
        objects: budget of objects.
        sink: receives diagnostics.
        copies: the enclosing loops, with the copy number in each.
        lists: spans of the lists with repeated items so far.
        around: indices of the enclosing items of these lists, outermost first.
        measure: measures meshes of the document. Needed only to compile patterns.
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
        """Returns the place of a node of the document, in the current copy."""
        return SourceMark(self.file, path, self.parent, tuple(self.copies))

    def origin(self, path: Path) -> Origin:
        """Returns the origin of a node of the document, in the current copy."""
        return self.mark(path).origin

    def each_copy(self, loop: Loop) -> Iterator[int]:
        """Yields the number of each copy of a loop, with the loop variables set."""
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
        """Reports a diagnostic at a node of the document."""
        self.sink.report(code, message, self.origin(path), at=at, hint=hint, related=related)

    def fail(self, error: ExpressionError, path: Path, code: str = "SC202") -> None:
        """Reports an expression error at its span within the scalar at `path`."""
        self.sink.report(code, error.message, self.origin(path), hint=error.hint, span=(error.start, error.end))


MeasureMesh = Callable[[str, Origin], list[list[float]] | None]
"""Takes a mesh path and its origin. Returns the bounds `[[x, y, z], [x, y, z]]`, or None after an error."""

MeshMeasurer = Callable[["SceneDocument", str, Origin], list[list[float]] | None]
"""A `MeasureMesh` that also takes the document."""

_SECTIONS = (
    "physics", "environment", "materials", "collision_groups", "draws", "frames", "entities", "constraints", "lights",
    "cameras", "expect",
)  # fmt: skip


def scoped_name(scope: str, name: str) -> str:
    """Returns the full name of a material, group or draw in a scope."""
    return f"{scope}/{name}" if scope else name


class ExpansionWriter:
    """Collects expanded nodes by section.

    Attributes:
        sections: sections of the expanded data.
        names: see `Expansion`.
        selections: see `Expansion`.
        removed: section (`use` for an instance) and full name of a removed object → origin of the override.
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
        """Adds a node by its full name, with the contents of its `TraceRecord`. Returns False for a duplicate, which is
        reported.
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
        """Returns the number of nodes in each section."""
        return {section: len(entries) for section, entries in self.sections.items()}

    def remove(self, start: Mapping[str, int], place: Origin) -> None:
        """Removes the nodes of an instance: all that were added since `start`, a result of `counts`."""
        for section, entries in self.sections.items():
            for name in list(entries)[start[section] :]:
                del entries[name]
                self.selections.pop(qualified_name(section, name), None)
                self.removed.setdefault((section, name), place)

    def _report_twice(self, section: str, name: str, second: Origin) -> None:
        """Reports a duplicate name, at the two `use` keys if they differ."""
        first = self.origin(section, name)
        first, second = _find_outermost_use(first, second), _find_outermost_use(second, first)
        uses = [origin.path[-1:] == ("use",) for origin in (first, second)]
        related: list[RelatedPlace] = [("the first of this name", first, "value" if uses[0] else "key")]
        message = f"the name `{cut(name)}` is used twice in the {section}"
        hint = None
        if any(uses):
            hint = "give one of them another `prefix`" if all(uses) else 'give the instance a `prefix` other than ""'
        self._sink.report("SC221", message, second, at="value" if uses[1] else "key", hint=hint, related=related)

    def origin(self, section: str, name: str) -> Origin:
        """Returns the origin of a named node."""
        record = self._records.get((section, name))
        return Origin(self._top, (section, name)) if record is None else record.mark.origin

    def trace(self, section: str, name: str, path: Path) -> Origin:
        """Returns the origin of the value at a path below a named node."""
        record = self._records.get((section, name))
        return Origin(self._top, (section, name, *path)) if record is None else record.trace(path)

    def expansion(
        self,
        head: dict[str, Any],
        documents: Mapping[str | None, SceneDocument],
        params: Mapping[str, Any],
        defaults: Mapping[str, Any],
    ) -> Expansion:
        """Returns the expansion. `head` holds the keys before the sections; the rest is as in `Expansion`."""
        data = {**head, **{name: entries for name, entries in self.sections.items() if entries}}
        return Expansion(data, self.names, self.selections, documents, self._records, params, defaults)


def _find_outermost_use(origin: Origin, other: Origin) -> Origin:
    """Returns the outermost `use` of an origin that the other does not share, or the origin itself."""
    shared = list(chain_of(other))
    uses = [place for place in chain_of(origin) if place not in shared and place.path[-1:] == ("use",)]
    return uses[-1] if uses else origin
