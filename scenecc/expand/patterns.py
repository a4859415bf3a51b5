"""Nodes as written, looked through once for what there is to fill in, and then made again and again.

A pattern makes a node with the values at hand; only the containers above a filled-in scalar are made anew, the rest
is the same object in every copy. A node without anything to fill in has no pattern.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

from scenecc.diagnostics.messages import show
from scenecc.expand.contents import SHAPE_LISTS, beyond, is_varying, weight
from scenecc.expand.expansion import Items
from scenecc.expand.loops import Loop
from scenecc.expand.names import Meaning, Names, check_free, check_names
from scenecc.expand.run import Failed
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.plain import is_mapping, is_sequence
from scenecc.values.failure import ExpressionError
from scenecc.values.operations import SEQUENCES
from scenecc.values.template import Template

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from scenecc.diagnostics import Path
    from scenecc.expand.run import Run


class Pattern(Protocol):
    """Makes a node."""

    def make(self, run: Run) -> Any:
        """The node with the values of a run; what has no value is reported."""
        ...


@dataclass(frozen=True, slots=True)
class Scalar:
    """A scalar with expressions. What it reads that differs from scene to scene stays to be read."""

    template: Template
    path: Path

    def make(self, run: Run) -> Any:
        """The value, or the template with its constants."""
        if run.failed and not run.failed.isdisjoint(self.template.names):
            return Failed(self.template.text)
        try:
            value = self.template.bind(run.values)
        except ExpressionError as error:
            run.fail(error, self.path)
            return Failed(self.template.text)
        if value.__class__ in SEQUENCES:
            # A short expression may give a long text or list, and another one in every copy.
            run.objects.take(beyond(value), run, self.path)
        return value


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A scalar that was reported."""

    text: str

    def make(self, run: Run) -> Any:
        """Nothing of use."""
        del run
        return Failed(self.text)


@dataclass(frozen=True, slots=True)
class Entries:
    """A mapping."""

    node: dict[str, Any]
    patterns: tuple[tuple[str, Pattern], ...]

    def make(self, run: Run) -> Any:
        """The mapping."""
        made = self.node.copy()
        for key, pattern in self.patterns:
            made[key] = pattern.make(run)
        return made


@dataclass(frozen=True, slots=True)
class Sequenced:
    """A list."""

    node: list[Any]
    patterns: tuple[tuple[int, Pattern], ...]

    def make(self, run: Run) -> Any:
        """The list."""
        made = self.node.copy()
        for index, pattern in self.patterns:
            made[index] = pattern.make(run)
        return made


@dataclass(frozen=True, slots=True)
class Repeated:
    """A list some of whose items are repeated.

    Attributes:
        items: the item without its `repeat`, its pattern, what repeats it, and for how many objects each copy counts.
        path: of the list as written.
        below: the same, from the named node on.
    """

    items: tuple[tuple[Any, Pattern | None, Axes | None, int], ...]
    path: Path
    below: Path

    def make(self, run: Run) -> Any:
        """The list, longer or shorter; `run.lists` says what its items stand for."""
        made: list[Any] = []
        starts: list[Items] = []
        for index, (node, pattern, axes, counted) in enumerate(self.items):
            if axes is None:
                starts.append(Items(len(made), index, None))
                made.append(node if pattern is None else pattern.make(run))
                continue
            loop = axes.loop(run)
            if loop is None or not loop.count:
                continue
            run.objects.take(loop.count * counted - 1, run, axes.path)
            starts.append(Items(len(made), index, loop))
            made += [node] * loop.count if pattern is None else _copies(pattern, loop, run)
        run.lists[self.below] = tuple(starts)
        return made


def _copies(pattern: Pattern, loop: Loop, run: Run) -> list[Any]:
    """What a pattern makes for each member of a product."""
    made: list[Any] = []
    values, names = run.values, loop.names
    for number, members in enumerate(loop):
        values.update(zip(names, members, strict=True))
        run.copies.append((loop, number))
        made.append(pattern.make(run))
        run.copies.pop()
    for name in names:
        values.pop(name, None)
    return made


@dataclass(frozen=True, slots=True)
class Axes:
    """A `repeat` as written: name → list, or {count}."""

    axes: Mapping[str, tuple[Any, Pattern | None]]
    path: Path

    def loop(self, run: Run) -> Loop | None:
        """The product; None where a list was reported. An empty one that no expression made so is noted."""
        lists: dict[str, Sequence[Any]] = {}
        for name, (node, pattern) in self.axes.items():
            path = (*self.path, name)
            made = node if pattern is None else pattern.make(run)
            if pattern is not None and is_varying(made):
                run.report("SC203", "`repeat` cannot read what differs from scene to scene", path)
                continue
            found = _axis(made, path, run)
            if found is not None:
                lists[name] = found
                if not found and pattern is None:
                    run.report("SC222", "this is empty, so nothing is built", path)
        return Loop(lists) if len(lists) == len(self.axes) else None


def _axis(made: Any, path: Path, run: Run) -> Sequence[Any] | None:
    """The values of a loop variable; None where that was reported."""
    if is_sequence(made):
        return made
    if is_mapping(made) and "count" in made:
        count = made["count"]
        if type(count) is float and count.is_integer():
            count = int(count)
        if type(count) is int and count >= 0:
            return range(min(count, _LONGEST))
        wrong = f"`count` must be a whole number, 0 or more, not {show(count)}"
        path = (*path, "count")
    else:
        wrong = f"a loop variable takes a list or {{count: n}}, not {show(made)}"
        count = made
    if not isinstance(count, Failed):
        run.report("SC220", wrong, path)
    return None


_LONGEST = 10**18
"""The longest range that has a length in Python, nearly: far more than any limit."""


@dataclass(frozen=True, slots=True)
class Compiler:
    """Looks through nodes of one document.

    Attributes:
        names: what expressions may read.
        run: takes what is wrong, whatever the use of the document.
        structure: what the nodes decide about, where that may not differ from scene to scene.
        depth: how long the path of the named node is.
    """

    names: Names
    run: Run
    structure: str | None = None
    depth: int = 2

    def pattern(self, node: Any, path: Path) -> Pattern | None:
        """The pattern of a node; None where there is nothing to fill in."""
        if isinstance(node, str):
            return self.scalar(node, path) if "${" in node else None
        if is_mapping(node):
            return self.entries(node, path)
        return self._sequence(node, path) if isinstance(node, list) else None

    def scalar(self, text: str, path: Path) -> Pattern:
        """The pattern of a text."""
        try:
            template = Template.parse(text)
        except ExpressionError as error:
            self.run.fail(error, path, "SC118")
            return Unreadable(text)
        good = check_names(template, self.names, path, self.run, structure=self.structure)
        return Scalar(template, path) if good else Unreadable(text)

    def entries(self, node: dict[str, Any], path: Path, without: frozenset[str] = frozenset()) -> Entries | None:
        """The pattern of a mapping, some of whose keys are left out."""
        patterns: list[tuple[str, Pattern]] = []
        for key, item in node.items():
            if type(item) in _HOLD_MORE and key not in without and not key.startswith(NOTE_PREFIX):
                pattern = self.pattern(item, (*path, key))
                if pattern is not None:
                    patterns.append((key, pattern))
        kept = node if without.isdisjoint(node) else {key: node[key] for key in node if key not in without}
        return Entries(kept, tuple(patterns)) if patterns or kept is not node else None

    def axes(self, node: Any, path: Path) -> tuple[Axes, Compiler]:
        """The pattern of a `repeat`, and the compiler of what it repeats."""
        written: dict[str, Any] = node if is_mapping(node) else {}
        own: dict[str, Meaning] = {name: "later loop variable" for name in written if name not in self.names}
        outer = Compiler({**self.names, **own}, self.run, "`repeat`", self.depth)
        axes: dict[str, tuple[Any, Pattern | None]] = {}
        names = dict(self.names)
        for name, item in written.items():
            if name.startswith(NOTE_PREFIX) or not check_free(name, "loop variable", names, (*path, name), self.run):
                continue
            axes[name] = item, outer.pattern(item, (*path, name))
            names[name] = "loop variable"
        return Axes(axes, path), Compiler(names, self.run, self.structure, self.depth)

    def _sequence(self, node: Any, path: Path) -> Pattern | None:
        if path[-1] in SHAPE_LISTS and any(type(item) is dict and "repeat" in item for item in node):
            items = tuple(self._item(item, (*path, index)) for index, item in enumerate(node))
            return Repeated(items, path, path[self.depth :])
        patterns: list[tuple[int, Pattern]] = []
        for index, item in enumerate(node):
            if type(item) in _HOLD_MORE:
                pattern = self.pattern(item, (*path, index))
                if pattern is not None:
                    patterns.append((index, pattern))
        return Sequenced(node, tuple(patterns)) if patterns else None

    def _item(self, item: Any, path: Path) -> tuple[Any, Pattern | None, Axes | None, int]:
        if not is_mapping(item) or "repeat" not in item:
            return item, self.pattern(item, path), None, 1
        axes, inner = self.axes(item["repeat"], (*path, "repeat"))
        pattern = inner.entries(item, path, _REPEAT)
        assert pattern is not None
        return pattern.node, pattern if pattern.patterns else None, axes, weight(pattern.node)


_HOLD_MORE = frozenset((str, dict, list))
_REPEAT = frozenset(("repeat",))
