"""Patterns: nodes as written, which are analysed once and instantiated many times.

A pattern makes a node with the values at hand; only the containers above a filled-in scalar are made anew, the rest
is the same object in every copy. A node without anything to fill in has no pattern.
"""

from __future__ import annotations

import keyword
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, Protocol

from scenecc.diagnostics.messages import cut, show, suggest
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
from scenecc.variation.expression import RESERVED_NAMES, Expression
from scenecc.variation.forms import Template
from scenecc.variation.operations import SEQUENCES, ExpressionError, kind_name

if TYPE_CHECKING:
    from scenecc.diagnostics.diagnostic import Path


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
class MeshBoundsPattern:
    """A scalar that reads bounds of meshes, as the document `measure` belongs to names them."""

    scalar: ScalarPattern
    measure: MeasureMesh

    def make(self, frame: ExpansionFrame) -> Any:
        """As of the scalar; a mesh without bounds is reported."""
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
class RepeatedItem:
    """An item of a list that stands for none, one or several.

    Attributes:
        node: without what says how often it is there.
        pattern: of it.
        axes: what repeats it.
        counted: for how many objects each copy counts.
        condition: its `if`, and where that stands; None where it is always there.
        numbered: whether its copies have the number behind their name.
    """

    node: Any
    pattern: Pattern | None
    axes: RepeatAxes | None = None
    counted: int = 1
    condition: tuple[Any, Pattern | None, Path] | None = None
    numbered: bool = False

    def make(self, frame: ExpansionFrame, number: int = 0) -> Any:
        """One copy."""
        made = self.node if self.pattern is None else self.pattern.make(frame)
        return {**made, "name": f"{made['name']}_{number}"} if self.numbered else made

    def is_there(self, frame: ExpansionFrame) -> bool:
        """Whether the copy at hand is built; an `if` that is neither true nor false is reported."""
        if self.condition is None:
            return True
        node, pattern, path = self.condition
        return check_condition(node if pattern is None else pattern.make(frame), path, frame)


@dataclass(frozen=True, slots=True)
class RepeatedPattern:
    """A list some of whose items are repeated, or there on a condition.

    Attributes:
        items: as written.
        path: of the list as written.
        below: the same, from the named node on.
    """

    items: tuple[RepeatedItem, ...]
    path: Path
    below: Path

    def make(self, frame: ExpansionFrame) -> Any:
        """The list, longer or shorter; `frame.lists` says what its items stand for."""
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
    """A `repeat` as written: name → list, or {count}."""

    axes: Mapping[str, tuple[Any, Pattern | None]]
    path: Path

    def loop(self, frame: ExpansionFrame) -> Loop | None:
        """The product; None where a list was reported. An empty one that no expression made so is noted."""
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
        good = check_template_names(template, self.names, path, self.frame, structure=self.structure)
        if not (good and self._may_observe(template, path)):
            return UnreadablePattern(text)
        scalar = ScalarPattern(template, path)
        if not template.meshes:
            return scalar
        assert self.frame.measure is not None
        return MeshBoundsPattern(scalar, self.frame.measure)

    def _may_observe(self, template: Template, path: Path) -> bool:
        """Whether a text reads what a simulation shows only where it is judged; otherwise that is reported."""
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
        # A shape's name is its own; a link has one as an entity has its key.
        name = made.get("name") if axes is not None and "if" in keys else None
        numbered = isinstance(name, str) and "${" not in name
        kept = pattern if pattern.patterns else None
        return RepeatedItem(made, kept, axes, count_node_objects(made), condition, numbered)


_WITH_PATTERNS = frozenset((str, dict, list))

_COPY_KEYS: dict[str | int, frozenset[str]] = {
    **dict.fromkeys(SHAPE_LISTS, frozenset(("repeat",))),
    LINK_LIST: frozenset(("repeat", "if")),
}
"""Keys of lists whose items say how often they are there, and the keys that say it."""


def check_condition(value: Any, path: Path, frame: ExpansionFrame) -> bool:
    """Whether an `if` holds; False, reported, where it is neither true nor false."""
    if type(value) is bool:
        return value
    refuse_structure(value, path, "if", "SC223", f"`if` must be true or false, not {show(value)}", frame)
    return False


def refuse_structure(
    value: Any, path: Path, key: str, code: str, message: str, frame: ExpansionFrame, hint: str | None = None
) -> None:
    """Reports a value that cannot decide about structure; nothing more is said of one that was reported."""
    if has_varying(value):
        frame.report("SC203", f"`{key}` cannot read a value that differs from scene to scene", path)
    elif not isinstance(value, FailedValue):
        frame.report(code, message, path, hint=hint)


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


def check_template_names(
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
    reads = [(name, structure) for name in sorted(template.names - template.meshes.keys())]
    reads += [(name, "the path of a mesh") for mesh in template.meshes.values() for name in mesh.places]
    for name, decides in reads:
        meaning = names.get(name)
        if meaning is None or meaning in _BARRED:
            good = False
            frame.fail(_unknown_name(name, names, template, decides), path, "SC201")
        elif decides is not None and meaning == "draw":
            good = False
            frame.fail(_varying_name(name, decides, template), path, "SC203")
    return good


def check_new_name(name: str, what: str, names: NameMeanings, path: Path, frame: ExpansionFrame) -> bool:
    """Whether a parameter, draw or loop variable may have a name; reported where not."""
    if name in RESERVED_NAMES or keyword.iskeyword(name):
        message = f"`{cut(name)}` is a reserved word of expressions and cannot name a {what}"
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
    hint = "only values may: read a parameter here, or use `variants` with `pick`"
    message = f"{structure} is the same in every scene, so it cannot read {what}"
    return ExpressionError(message, *template.place(name), hint)
