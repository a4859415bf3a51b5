"""Patterns: nodes as written, which are analysed once and instantiated many times.

A pattern makes a node with the values at hand; only the containers above a filled-in scalar are made anew, the rest
is the same object in every copy. A node without anything to fill in has no pattern.
"""

from __future__ import annotations

import keyword
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Protocol

from scenecc.diagnostics.messages import cut, show, suggest
from scenecc.expand.documents import (
    SHAPE_LISTS,
    FailedValue,
    count_added_objects,
    count_objects,
    has_failed,
    is_varying,
)
from scenecc.expand.expansion import ItemSpan, Loop
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.variation.expression import RESERVED_NAMES
from scenecc.variation.forms import Template
from scenecc.variation.operations import SEQUENCES, ExpressionError

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Sequence

    from scenecc.diagnostics.diagnostic import Path
    from scenecc.expand.expansion import ExpansionFrame


class Pattern(Protocol):
    """Makes a node."""

    def make(self, frame: ExpansionFrame) -> Any:
        """The node with the values of a frame; what has no value is reported."""
        ...


@dataclass(frozen=True, slots=True)
class ScalarPattern:
    """A scalar with expressions. What it reads that differs from scene to scene stays to be read."""

    template: Template
    path: Path

    def make(self, frame: ExpansionFrame) -> Any:
        """The value, or the template with its constants."""
        if frame.failed and not frame.failed.isdisjoint(self.template.names):
            return FailedValue(self.template.text)
        try:
            value = self.template.bind(frame.values)
        except ExpressionError as error:
            frame.fail(error, self.path)
            return FailedValue(self.template.text)
        if value.__class__ in SEQUENCES:
            # A short expression may give a long text or list, and another one in every copy.
            frame.objects.take(count_added_objects(value), frame, self.path)
        return value


@dataclass(frozen=True, slots=True)
class UnreadablePattern:
    """A scalar that was reported."""

    text: str

    def make(self, frame: ExpansionFrame) -> Any:
        """Nothing of use."""
        del frame
        return FailedValue(self.text)


@dataclass(frozen=True, slots=True)
class ContainerPattern:
    """A mapping or a list. `patterns`: of its items, by key or index."""

    node: dict[str, Any] | list[Any]
    patterns: tuple[tuple[Any, Pattern], ...]

    def make(self, frame: ExpansionFrame) -> Any:
        """The mapping or list."""
        made: Any = self.node.copy()
        for at, pattern in self.patterns:
            made[at] = pattern.make(frame)
        return made


@dataclass(frozen=True, slots=True)
class RepeatedPattern:
    """A list some of whose items are repeated.

    Attributes:
        items: the item without its `repeat`, its pattern, what repeats it, and for how many objects each copy counts.
        path: of the list as written.
        below: the same, from the named node on.
    """

    items: tuple[tuple[Any, Pattern | None, RepeatAxes | None, int], ...]
    path: Path
    below: Path

    def make(self, frame: ExpansionFrame) -> Any:
        """The list, longer or shorter; `frame.lists` says what its items stand for."""
        made: list[Any] = []
        starts: list[ItemSpan] = []
        for index, (node, pattern, axes, counted) in enumerate(self.items):
            if axes is None:
                starts.append(ItemSpan(len(made), index, None))
                made.append(node if pattern is None else pattern.make(frame))
                continue
            loop = axes.loop(frame)
            if loop is None or not loop.count:
                continue
            frame.objects.take(loop.count * counted - 1, frame, axes.path)
            starts.append(ItemSpan(len(made), index, loop))
            if pattern is None:
                made += [node] * loop.count
            else:
                made += [pattern.make(frame) for _ in frame.each_copy(loop)]
        frame.lists[self.below] = tuple(starts)
        return made


@dataclass(frozen=True, slots=True)
class RepeatAxes:
    """A `repeat` as written: name → list, or {count}."""

    axes: Mapping[str, tuple[Any, Pattern | None]]
    path: Path

    def loop(self, frame: ExpansionFrame) -> Loop | None:
        """The product; None where a list was reported. An empty one that no expression made so is noted."""
        lists: dict[str, Sequence[Any]] = {}
        for name, (node, pattern) in self.axes.items():
            path = (*self.path, name)
            made = node if pattern is None else pattern.make(frame)
            if pattern is not None and is_varying(made):
                frame.report("SC203", "`repeat` cannot read a value that differs from scene to scene", path)
                continue
            found = _axis_values(made, path, frame)
            if found is not None:
                lists[name] = found
                if not found and pattern is None:
                    frame.report("SC222", "this is empty, so nothing is built", path)
        return Loop(lists) if len(lists) == len(self.axes) else None


def _axis_values(made: Any, path: Path, frame: ExpansionFrame) -> Sequence[Any] | None:
    """The values of a loop variable; None where that was reported."""
    if is_sequence(made):
        return made
    if is_mapping(made) and "count" in made:
        count = made["count"]
        if type(count) is float and count.is_integer():
            count = int(count)
        if type(count) is int and count >= 0:
            return range(min(count, _MAX_RANGE))
        wrong = f"`count` must be a whole number, 0 or more, not {show(count)}"
        path = (*path, "count")
    else:
        wrong = f"a loop variable takes a list or {{count: n}}, not {show(made)}"
        count = made
    if not isinstance(count, FailedValue):
        frame.report("SC220", wrong, path)
    return None


_MAX_RANGE = 10**18
"""The longest range that has a length in Python, nearly: far more than any limit."""


@dataclass(frozen=True, slots=True)
class PatternCompiler:
    """Looks through nodes of one document.

    Attributes:
        names: what expressions may read.
        frame: takes what is wrong, whatever the use of the document.
        structure: what the nodes decide about, where that may not differ from scene to scene.
        depth: how long the path of the named node is.
    """

    names: NameMeanings
    frame: ExpansionFrame
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
            self.frame.fail(error, path, "SC118")
            return UnreadablePattern(text)
        good = check_names(template, self.names, path, self.frame, structure=self.structure)
        return ScalarPattern(template, path) if good else UnreadablePattern(text)

    def entries(
        self, node: dict[str, Any], path: Path, without: frozenset[str] = frozenset()
    ) -> ContainerPattern | None:
        """The pattern of a mapping, some of whose keys are left out."""
        read = (pair for pair in node.items() if pair[0] not in without and not pair[0].startswith(NOTE_PREFIX))
        patterns = self._patterns(read, path)
        kept = node if without.isdisjoint(node) else {key: node[key] for key in node if key not in without}
        return ContainerPattern(kept, patterns) if patterns or kept is not node else None

    def _patterns(self, items: Iterable[tuple[Any, Any]], path: Path) -> tuple[tuple[Any, Pattern], ...]:
        """The patterns of items, by key or index, that have one."""
        return tuple(
            (at, pattern)
            for at, item in items
            if type(item) in _WITH_PATTERNS and (pattern := self.pattern(item, (*path, at))) is not None
        )

    def axes(self, node: Any, path: Path) -> tuple[RepeatAxes, PatternCompiler]:
        """The pattern of a `repeat`, and the compiler of what it repeats."""
        written: dict[str, Any] = node if is_mapping(node) else {}
        own: dict[str, NameMeaning] = {name: "later loop variable" for name in written if name not in self.names}
        outer = PatternCompiler({**self.names, **own}, self.frame, "`repeat`", self.depth)
        axes: dict[str, tuple[Any, Pattern | None]] = {}
        names = dict(self.names)
        for name, item in written.items():
            if name.startswith(NOTE_PREFIX) or not check_new_name(
                name, "loop variable", names, (*path, name), self.frame
            ):
                continue
            axes[name] = item, outer.pattern(item, (*path, name))
            names[name] = "loop variable"
        return RepeatAxes(axes, path), PatternCompiler(names, self.frame, self.structure, self.depth)

    def _sequence(self, node: Any, path: Path) -> Pattern | None:
        if path[-1] in SHAPE_LISTS and any(type(item) is dict and "repeat" in item for item in node):
            items = tuple(self._item(item, (*path, index)) for index, item in enumerate(node))
            return RepeatedPattern(items, path, path[self.depth :])
        written: list[Any] = node
        patterns = self._patterns(enumerate(written), path)
        return ContainerPattern(node, patterns) if patterns else None

    def _item(self, item: Any, path: Path) -> tuple[Any, Pattern | None, RepeatAxes | None, int]:
        if not is_mapping(item) or "repeat" not in item:
            return item, self.pattern(item, path), None, 1
        axes, inner = self.axes(item["repeat"], (*path, "repeat"))
        pattern = inner.entries(item, path, _REPEAT_KEY)
        assert pattern is not None
        return pattern.node, pattern if pattern.patterns else None, axes, count_objects(pattern.node)


_WITH_PATTERNS = frozenset((str, dict, list))

_REPEAT_KEY = frozenset(("repeat",))


class LoopInvariant:
    """A pattern that reads none of a loop's variables, within that loop."""

    __slots__ = ("_made", "_pattern")

    def __init__(self, pattern: Pattern) -> None:
        self._pattern = pattern
        self._made: Any = None

    def make(self, frame: ExpansionFrame) -> Any:
        """The result of an earlier call. A faulty node is made again, so that each copy is reported."""
        if self._made is not None:
            return self._made
        made = self._pattern.make(frame)
        if not has_failed(made):
            self._made = made
        return made


def hoist_invariants(pattern: Pattern, variables: Collection[str]) -> Pattern:
    """The same pattern, for the copies of one loop alone.

    Args:
        pattern: of what is repeated.
        variables: of the loop; all other values stay as they are in it.
    """
    match pattern:
        case ScalarPattern(template):
            return LoopInvariant(pattern) if template.names.isdisjoint(variables) else pattern
        case ContainerPattern(node, patterns):
            inner = tuple((at, hoist_invariants(item, variables)) for at, item in patterns)
            made = ContainerPattern(node, inner)
            return LoopInvariant(made) if all(isinstance(item, LoopInvariant) for _, item in inner) else made
        case _:
            # Of a list with repeated items each copy notes what they stand for.
            return pattern


NameMeaning = Literal[
    "parameter", "loop variable", "draw", "later draw", "later parameter", "later loop variable", "itself", "constant"
]
"""`later` ones, and `itself`, may be read elsewhere, but not in the draw, default or loop at hand."""

NameMeanings = Mapping[str, NameMeaning]
"""The names that an expression may read."""

PARAM_DEFAULT = "a default"
"""What a parameter's default decides about."""

BUILTIN_MEANINGS: dict[str, NameMeaning] = {"num_scenes": "constant", "scene": "draw"}

_BARRED = frozenset(("later draw", "later parameter", "later loop variable", "itself"))


def check_names(
    template: Template, names: NameMeanings, path: Path, frame: ExpansionFrame, *, structure: str | None = None
) -> bool:
    """Whether a template reads only names that mean something where it stands; what does not is reported.

    Args:
        template: at hand.
        names: that mean something.
        path: of its scalar.
        frame: whose document it is in.
        structure: what it decides about, where that may not differ from scene to scene: "`repeat`".
    """
    good = True
    for name in sorted(template.names):
        meaning = names.get(name)
        if meaning is None or meaning in _BARRED:
            good = False
            frame.fail(_unknown_name(name, names, template, structure), path, "SC201")
        elif structure is not None and meaning == "draw":
            good = False
            frame.fail(_varying_name(name, structure, template), path, "SC203")
    return good


def check_new_name(name: str, what: str, names: NameMeanings, path: Path, frame: ExpansionFrame) -> bool:
    """Whether a parameter, draw or loop variable may have a name; reported where not."""
    if name in RESERVED_NAMES or keyword.iskeyword(name):
        message = f"`{cut(name)}` is a word of expressions and cannot name a {what}"
    elif name in names:
        message = f"`{cut(name)}` is the name of a {names[name].removeprefix('later ')} already"
    else:
        return True
    frame.report("SC204", message, path, at="key", hint="choose another name")
    return False


def _unknown_name(name: str, names: NameMeanings, template: Template, structure: str | None) -> ExpressionError:
    shown, place = f"`{cut(name)}`", template.place(name)
    match names.get(name):
        case None:
            refused = _BARRED if structure is None else _BARRED | {"draw"}
            known = [
                known for known, meaning in names.items() if meaning not in refused and known not in BUILTIN_MEANINGS
            ]
            builtin = [known for known, meaning in BUILTIN_MEANINGS.items() if meaning not in refused]
            return ExpressionError(f"unknown name {shown}", *place, suggest(name, (*known, *builtin)))
        case "itself":
            return ExpressionError(f"{shown} reads itself", *place, "it may read those above it")
        case "later loop variable":
            hint = "lists of one `repeat` cannot depend on one another; `if` can exclude combinations"
            return ExpressionError(f"{shown} is a loop variable of the same `repeat`", *place, hint)
        case meaning:
            what = (meaning or "").removeprefix("later ")
            hint = f"a {what} may read those above it"
            return ExpressionError(f"the {what} {shown} is defined further down", *place, hint)


def _varying_name(name: str, structure: str, template: Template) -> ExpressionError:
    if structure == PARAM_DEFAULT and name != "scene":
        hint = "a draw may read parameters: declare this one under `draws`"
        return ExpressionError(f"`{cut(name)}` is a draw: a parameter cannot read it", *template.place(name), hint)
    what = "the scene's index" if name == "scene" else f"the draw `{cut(name)}`"
    hint = "only values may: a parameter can decide here, or `variants` with `pick`"
    message = f"{structure} is the same in every scene, so it cannot read {what}"
    return ExpressionError(message, *template.place(name), hint)
