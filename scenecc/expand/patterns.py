"""Patterns: parsed nodes that are analysed once and instantiated many times.

An instance copies only the containers above a substituted scalar; all other objects are shared between copies.
A node without expressions has no pattern.
"""

from __future__ import annotations

import keyword
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, Protocol

from scenecc.diagnostics.messages import cut, show
from scenecc.expand.documents import (
    LINK_LIST,
    SHAPE_LISTS,
    FailedValue,
    count_added_objects,
    count_node_objects,
    has_failed,
    has_varying,
)
from scenecc.expand.expansion import ExpansionFrame, ItemSpan, Loop, MeasureMesh
from scenecc.expand.modules import EXPECT
from scenecc.spec.base import NOTE_PREFIX
from scenecc.spec.nodes import is_mapping, is_sequence
from scenecc.variation.expression import RESERVED_NAMES, Expression, suggest_variable
from scenecc.variation.forms import Template
from scenecc.variation.operations import SEQUENCES, ExpressionError, kind_name

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path


class Pattern(Protocol):
    """Instantiates a node."""

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns the node with the values of a frame. Failed expressions are reported."""
        ...


@dataclass(frozen=True, slots=True)
class ScalarPattern:
    """A scalar with expressions. Names that differ between scenes stay in the template."""

    template: Template
    path: Path

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns the value, or a template with its constants bound."""
        if frame.failed and not frame.failed.isdisjoint(self.template.names):
            return FailedValue(self.template.text)
        try:
            value = self.template.bind(frame.values)
        except ExpressionError as error:
            frame.fail(error, self.path)
            return FailedValue(self.template.text)
        if value.__class__ in SEQUENCES:
            # A short expression may return a long text or list, a different one in each copy.
            frame.objects.take(count_added_objects(value), frame, self.path)
        return value


@dataclass(frozen=True, slots=True)
class MeshBoundsPattern:
    """A scalar that calls `bounds`. `measure` resolves mesh paths relative to the scalar's document."""

    scalar: ScalarPattern
    measure: MeasureMesh

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns the scalar's value. A mesh without bounds is reported."""
        template, path = self.scalar.template, self.scalar.path
        found: dict[str, Any] = {}
        for name, mesh in template.meshes.items():
            if not frame.failed.isdisjoint(mesh.places):
                return FailedValue(template.text)
            if not mesh.places.keys() <= frame.values.keys():
                message = "the path of `bounds` cannot read a value that differs from scene to scene"
                hint = "`anchor: bottom` in the pose of an entity fits each scene's own mesh"
                frame.report("SC203", message, path, hint=hint)
                return FailedValue(template.text)
            try:
                found[name] = self._bounds(mesh, frame)
            except ExpressionError as error:
                frame.fail(error, path)
            if found.get(name) is None:
                return FailedValue(template.text)
        bound = replace(self.scalar, template=Template(template.text, found))
        return bound.make(frame)

    def _bounds(self, mesh: Expression, frame: ExpansionFrame) -> Any:
        uri = mesh.run(frame.values)
        if not isinstance(uri, str):
            raise ExpressionError(f"`bounds` takes the path of a mesh, not {kind_name(uri)}", *mesh.span(mesh.tree))
        return self.measure(uri, frame.origin(self.scalar.path))


@dataclass(frozen=True, slots=True)
class UnreadablePattern:
    """A scalar with a reported error."""

    text: str

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns a FailedValue."""
        del frame
        return FailedValue(self.text)


@dataclass(frozen=True, slots=True)
class ContainerPattern:
    """A mapping or list. `patterns` are pairs of a key or index and that item's pattern."""

    node: dict[str, Any] | list[Any]
    patterns: tuple[tuple[Any, Pattern], ...]

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns a copy of the container with its items instantiated."""
        made: Any = self.node.copy()
        for at, pattern in self.patterns:
            made[at] = pattern.make(frame)
        return made


@dataclass(frozen=True, slots=True)
class RepeatedItem:
    """A list item that expands to zero or more items.

    Attributes:
        node: the item without `repeat` and `if`.
        pattern: its pattern.
        axes: its `repeat`.
        counted: objects that each copy counts as.
        condition: node, pattern and path of its `if`; None if it has none.
        numbered: whether the copy's number is appended to its name.
    """

    node: Any
    pattern: Pattern | None
    axes: RepeatAxes | None = None
    counted: int = 1
    condition: tuple[Any, Pattern | None, Path] | None = None
    numbered: bool = False

    def make(self, frame: ExpansionFrame, number: int = 0) -> Any:
        """Returns one copy."""
        made = self.node if self.pattern is None else self.pattern.make(frame)
        return {**made, "name": f"{made['name']}_{number}"} if self.numbered else made

    def is_there(self, frame: ExpansionFrame) -> bool:
        """Whether the current copy is built. An `if` that is not a boolean is reported."""
        if self.condition is None:
            return True
        node, pattern, path = self.condition
        return check_condition(node if pattern is None else pattern.make(frame), path, frame)


@dataclass(frozen=True, slots=True)
class RepeatedPattern:
    """A list with repeated or conditional items.

    Attributes:
        items: the items in the source.
        path: path of the list in the source.
        below: the same path, relative to the named node.
    """

    items: tuple[RepeatedItem, ...]
    path: Path
    below: Path

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns the expanded list and records the source of its items in `frame.lists`."""
        made: list[Any] = []
        starts: list[ItemSpan] = []
        for index, item in enumerate(self.items):
            loop = None if item.axes is None else item.axes.loop(frame)
            if item.axes is None:
                if item.is_there(frame):
                    starts.append(ItemSpan(len(made), index, None))
                    self._add(made, item, frame)
            elif loop is not None and loop.count:
                frame.objects.take(loop.count * item.counted - 1, frame, item.axes.path)
                starts.append(ItemSpan(len(made), index, loop))
                if item.pattern is None and item.condition is None and not item.numbered:
                    made += [item.node] * loop.count
                    continue
                for number in frame.each_copy(loop):
                    if item.is_there(frame):
                        if item.condition is not None:
                            starts.append(ItemSpan(len(made), index, loop, number))
                        self._add(made, item, frame, number)
        frame.lists[self.below, tuple(frame.around)] = tuple(starts)
        return made

    @staticmethod
    def _add(made: list[Any], item: RepeatedItem, frame: ExpansionFrame, number: int = 0) -> None:
        frame.around.append(len(made))
        made.append(item.make(frame, number))
        frame.around.pop()


@dataclass(frozen=True, slots=True)
class RepeatAxes:
    """A `repeat`: loop variable → list or {count}."""

    axes: Mapping[str, tuple[Any, Pattern | None]]
    path: Path

    def loop(self, frame: ExpansionFrame) -> Loop | None:
        """Returns the loop, or None if a list has a reported error. A constant empty list gets a diagnostic."""
        lists: dict[str, Sequence[Any]] = {}
        for name, (node, pattern) in self.axes.items():
            path = (*self.path, name)
            made = node if pattern is None else pattern.make(frame)
            if pattern is not None and has_varying(made):
                frame.report("SC203", "`repeat` cannot read a value that differs from scene to scene", path)
                continue
            found = _axis_values(made, path, frame)
            if found is not None:
                lists[name] = found
                if not found and pattern is None:
                    frame.report("SC222", "this is empty, so nothing is built", path)
        return Loop(lists) if len(lists) == len(self.axes) else None


def _axis_values(made: Any, path: Path, frame: ExpansionFrame) -> Sequence[Any] | None:
    """Returns the values of a loop variable, or reports them and returns None."""
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
"""`len()` of a longer range overflows; far above any limit."""


@dataclass(frozen=True, slots=True)
class PatternCompiler:
    """Compiles nodes of one document to patterns.

    Attributes:
        names: the names that expressions may read.
        frame: reports errors that do not depend on the document's use.
        structure: what the nodes determine, as named in messages, if it must be the same in every scene.
        depth: length of the named node's path.
    """

    names: NameMeanings
    frame: ExpansionFrame
    structure: str | None = None
    depth: int = 2

    def pattern(self, node: Any, path: Path) -> Pattern | None:
        """Returns the pattern of a node; None if it has no expressions."""
        if isinstance(node, str):
            return self.scalar(node, path) if "${" in node else None
        if is_mapping(node):
            return self.entries(node, path)
        return self._sequence(node, path) if isinstance(node, list) else None

    def scalar(self, text: str, path: Path) -> Pattern:
        """Returns the pattern of a string with expressions."""
        try:
            template = Template.parse(text)
        except ExpressionError as error:
            self.frame.fail(error, path, "SC118")
            return UnreadablePattern(text)
        good = check_template_names(template, self.names, path, self.frame, structure=self.structure)
        if not (good and self._may_observe(template, path)):
            return UnreadablePattern(text)
        scalar = ScalarPattern(template, path)
        if not template.meshes:
            return scalar
        assert self.frame.measure is not None
        return MeshBoundsPattern(scalar, self.frame.measure)

    def _may_observe(self, template: Template, path: Path) -> bool:
        """Whether simulation results are read only in `that` of an expectation. Other uses are reported."""
        if not template.observations or (path[:2] == (EXPECT, "holds") and path[3:] == ("that",)):
            return True
        for name, (function, *_) in template.observations.items():
            message = f"`{function}(…)` is allowed only in `that`, under `expect`"
            hint = "it is a simulation result; scenes are built before the simulation"
            self.frame.fail(ExpressionError(message, *template.place(name), hint), path, "SC205")
        return False

    def entries(
        self, node: dict[str, Any], path: Path, without: frozenset[str] = frozenset()
    ) -> ContainerPattern | None:
        """Returns the pattern of a mapping without some of its keys."""
        read = (pair for pair in node.items() if pair[0] not in without and not pair[0].startswith(NOTE_PREFIX))
        patterns = self._patterns(read, path)
        kept = node if without.isdisjoint(node) else {key: node[key] for key in node if key not in without}
        return ContainerPattern(kept, patterns) if patterns or kept is not node else None

    def _patterns(self, items: Iterable[tuple[Any, Any]], path: Path) -> tuple[tuple[Any, Pattern], ...]:
        """Returns the keys or indices of the items that have a pattern, with the patterns."""
        return tuple(
            (at, pattern)
            for at, item in items
            if type(item) in _WITH_PATTERNS and (pattern := self.pattern(item, (*path, at))) is not None
        )

    def axes(self, node: Any, path: Path) -> tuple[RepeatAxes, PatternCompiler]:
        """Returns the axes of a `repeat`, and a compiler for the repeated node."""
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
        keys = _COPY_KEYS.get(path[-1])
        if keys is not None and any(type(item) is dict and not keys.isdisjoint(item) for item in node):
            items = tuple(self._item(item, (*path, index), keys) for index, item in enumerate(node))
            return RepeatedPattern(items, path, path[self.depth :])
        written: list[Any] = node
        patterns = self._patterns(enumerate(written), path)
        return ContainerPattern(node, patterns) if patterns else None

    def _item(self, item: Any, path: Path, keys: frozenset[str]) -> RepeatedItem:
        if not is_mapping(item) or keys.isdisjoint(item):
            return RepeatedItem(item, self.pattern(item, path))
        axes, inner = None, self
        if "repeat" in item:
            axes, inner = self.axes(item["repeat"], (*path, "repeat"))
        condition = None
        if "if" in item and "if" in keys:
            place = (*path, "if")
            fixed = replace(inner, structure="`if`")
            condition = item["if"], fixed.pattern(item["if"], place), place
        pattern = inner.entries(item, path, keys)
        assert pattern is not None
        made = pattern.node
        assert is_mapping(made)
        # A link's name must be unique, so its copies are numbered. Shape names need not be unique.
        name = made.get("name") if axes is not None and "if" in keys else None
        numbered = isinstance(name, str) and "${" not in name
        kept = pattern if pattern.patterns else None
        return RepeatedItem(made, kept, axes, count_node_objects(made), condition, numbered)


_WITH_PATTERNS = frozenset((str, dict, list))

_COPY_KEYS: dict[str | int, frozenset[str]] = {
    **dict.fromkeys(SHAPE_LISTS, frozenset(("repeat",))),
    LINK_LIST: frozenset(("repeat", "if")),
}
"""Keys of lists whose items may be repeated or conditional → the keys that control it."""


def check_condition(value: Any, path: Path, frame: ExpansionFrame) -> bool:
    """Returns whether an `if` holds. A value that is not a boolean is reported and counts as False."""
    if type(value) is bool:
        return value
    refuse_structure(value, path, "if", "SC223", f"`if` must be true or false, not {show(value)}", frame)
    return False


def refuse_structure(
    value: Any, path: Path, key: str, code: str, message: str, frame: ExpansionFrame, hint: str | None = None
) -> None:
    """Reports a value that cannot determine structure, unless it has a reported error."""
    if has_varying(value):
        frame.report("SC203", f"`{key}` cannot read a value that differs from scene to scene", path)
    elif not isinstance(value, FailedValue):
        frame.report(code, message, path, hint=hint)


class LoopInvariant:
    """Caches a pattern that reads no variable of a loop, for the copies of that loop."""

    __slots__ = ("_made", "_pattern")

    def __init__(self, pattern: Pattern) -> None:
        self._pattern = pattern
        self._made: Any = None

    def make(self, frame: ExpansionFrame) -> Any:
        """Returns the cached node. A node with errors is not cached, so every copy reports them."""
        if self._made is not None:
            return self._made
        made = self._pattern.make(frame)
        if not has_failed(made):
            self._made = made
        return made


def hoist_invariants(pattern: Pattern, variables: Collection[str]) -> Pattern:
    """Returns the pattern with its loop-invariant parts cached. The result is valid for one loop only.

    Args:
        pattern: pattern of the repeated node.
        variables: the loop's variables. All other values are constant within the loop.
    """
    match pattern:
        case ScalarPattern(template):
            return LoopInvariant(pattern) if template.names.isdisjoint(variables) else pattern
        case ContainerPattern(node, patterns):
            inner = tuple((at, hoist_invariants(item, variables)) for at, item in patterns)
            made = ContainerPattern(node, inner)
            return LoopInvariant(made) if all(isinstance(item, LoopInvariant) for _, item in inner) else made
        case _:
            # A list with repeated items records their sources in each copy, so it cannot be cached.
            return pattern


NameMeaning = Literal[
    "parameter", "loop variable", "draw", "later draw", "later parameter", "later loop variable", "itself", "constant"
]
"""The `later` names and `itself` cannot be read in the current draw, default or loop."""

NameMeanings = Mapping[str, NameMeaning]
"""The names that an expression may read."""

PARAM_DEFAULT = "a default"
"""`structure` of a parameter's default."""

BUILTIN_MEANINGS: dict[str, NameMeaning] = {"num_scenes": "constant", "scene": "draw"}

_BARRED = frozenset(("later draw", "later parameter", "later loop variable", "itself"))


def check_template_names(
    template: Template, names: NameMeanings, path: Path, frame: ExpansionFrame, *, structure: str | None = None
) -> bool:
    """Returns whether a template reads only names that it may read. Others are reported.

    Args:
        template: the template.
        names: the names in scope.
        path: path of its scalar.
        frame: frame of its document.
        structure: what it determines, as named in messages ("`repeat`"), if it must be the same in every scene.
    """
    good = True
    reads = [(name, structure) for name in sorted(template.names - template.meshes.keys())]
    reads += [(name, "the path of a mesh") for mesh in template.meshes.values() for name in mesh.places]
    for name, decides in reads:
        meaning = names.get(name)
        if meaning is None or meaning in _BARRED:
            good = False
            frame.fail(_make_unknown_error(name, names, template, decides), path, "SC201")
        elif decides is not None and meaning == "draw":
            good = False
            frame.fail(_make_varying_error(name, decides, template), path, "SC203")
    return good


def check_new_name(name: str, what: str, names: NameMeanings, path: Path, frame: ExpansionFrame) -> bool:
    """Returns whether a parameter, draw or loop variable may have a name. If not, it is reported."""
    if name in RESERVED_NAMES or keyword.iskeyword(name):
        message = f"`{cut(name)}` is a reserved word of expressions and cannot name a {what}"
    elif name in names:
        message = f"`{cut(name)}` is the name of a {names[name].removeprefix('later ')} already"
    else:
        return True
    frame.report("SC204", message, path, at="key", hint="choose another name")
    return False


def _make_unknown_error(name: str, names: NameMeanings, template: Template, structure: str | None) -> ExpressionError:
    shown, place = f"`{cut(name)}`", template.place(name)
    match names.get(name):
        case None:
            refused = _BARRED if structure is None else _BARRED | {"draw"}
            known = [
                known for known, meaning in names.items() if meaning not in refused and known not in BUILTIN_MEANINGS
            ]
            builtin = [known for known, meaning in BUILTIN_MEANINGS.items() if meaning not in refused]
            return ExpressionError(f"unknown name {shown}", *place, suggest_variable(name, (*known, *builtin)))
        case "itself":
            return ExpressionError(f"{shown} reads itself", *place, "it may read those above it")
        case "later loop variable":
            hint = "lists of one `repeat` cannot depend on one another; `if` can exclude combinations"
            return ExpressionError(f"{shown} is a loop variable of the same `repeat`", *place, hint)
        case meaning:
            what = (meaning or "").removeprefix("later ")
            hint = f"a {what} may read those above it"
            return ExpressionError(f"the {what} {shown} is defined further down", *place, hint)


def _make_varying_error(name: str, structure: str, template: Template) -> ExpressionError:
    if structure == PARAM_DEFAULT and name != "scene":
        hint = "a draw may read parameters: declare this one under `draws`"
        return ExpressionError(f"`{cut(name)}` is a draw: a parameter cannot read it", *template.place(name), hint)
    what = "the scene's index" if name == "scene" else f"the draw `{cut(name)}`"
    hint = "only values may: read a parameter here, or use `variants` with `pick`"
    message = f"{structure} is the same in every scene, so it cannot read {what}"
    return ExpressionError(message, *template.place(name), hint)
