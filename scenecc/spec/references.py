"""How a document refers to its parts: qualified names, `scene_idxs`, and patterns of names.

Patterns are matched by an automaton of our own, in time that grows with the length of the name alone. Python's
matcher backtracks, which takes hours for some pairs of pattern and name.
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from itertools import pairwise
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.spec.params import ParamType


NAME_SECTIONS = (
    "params", "draws", "materials", "collision_groups", "frames", "entities", "constraints", "lights", "cameras"
)  # fmt: skip
"""Sections whose keys are names."""

SHARED_NAMESPACE = ("frames", "entities", "cameras")
"""Sections whose names are one namespace."""


def qualified_name(section: str, name: str) -> str:
    """What a named node is known as among those of all sections: by its name, or with its section before it.

    Args:
        section: `frames`, `entities`, `cameras`, `constraints` or `lights`.
        name: the full one. No name has a colon.
    """
    return name if section in SHARED_NAMESPACE else f"{section}:{name}"


WORLD = "world"


@dataclass(frozen=True, slots=True)
class NameScopes:
    """How names are looked up; of a file without instances as they are written.

    Entities, frames, cameras, constraints and lights have their full names. An instance is also a frame; what is
    inside of it has the instance as its *scope*, and names written inside mean what is inside. So, with
    `S = scopes.get(owner, "")` for the node in which a name is written:

    - `relative_to: NAME`, and likewise what something is mounted on or ties together, is
      `prefixes.get(S, "") + NAME`; `world` and no `relative_to` are the frame `anchors[S]` (the world where S is "");
    - a material `NAME` is `S/NAME` (`NAME` where S is ""), and `/NAME` is `NAME` of the whole expansion;
    - a collision group and a draw read in a template are likewise `S/NAME`.

    Of a material, group or draw `A/B/NAME` the scope is `A/B`, except for the draws in `given`.

    What an `override` gives names what its own file sees: `/NAME` is the full name of an entity or a frame.

    Attributes:
        scopes: entity, frame, camera, constraint or light, as `qualified_name` has it → scope, for those inside an
            instance.
        prefixes: scope → what stands before the names of its entities and frames.
        anchors: scope → the frame in which it stands.
        given: draws that stand for what a `with` says → the scope in which the `with` is written.
        used_materials: materials that are not to be reported as never used: a `with` names them, they are inside an
            instance, or they may be named under other parameters.
        wanted: draws that stand for parameters → what the parameter takes.
        worlds: node whose `world` an `override` says, as in `scopes` → the scope whose world is meant.
        overridden: scopes inside of which an `override` changes something, so that a draw may be left unread.
    """

    scopes: dict[str, str] = field(default_factory=dict[str, str])
    prefixes: dict[str, str] = field(default_factory=dict[str, str])
    anchors: dict[str, str] = field(default_factory=dict[str, str])
    given: dict[str, str] = field(default_factory=dict[str, str])
    used_materials: set[str] = field(default_factory=set[str])
    wanted: dict[str, ParamType] = field(default_factory=dict[str, "ParamType"])
    worlds: dict[str, str] = field(default_factory=dict[str, str])
    overridden: set[str] = field(default_factory=set[str])

    def parent(self, name: str, relative_to: str | None) -> str | None:
        """What an entity or a frame stands relative to; None: the world.

        Args:
            name: of the entity or frame.
            relative_to: as written in its pose.
        """
        scope = self.scopes.get(name, "")
        if relative_to == WORLD:
            scope = self.worlds.get(name, scope)
        if relative_to in (None, WORLD):
            return self.anchors.get(scope) if scope else None
        return self.full_name(relative_to, scope)

    def full_name(self, written: str, scope: str) -> str:
        """The full name of an entity or frame, or with a link behind it, that is named in a scope."""
        return written[1:] if written.startswith("/") else self.prefixes.get(scope, "") + written

    def seen_by(self, name: str, names: Iterable[str]) -> Iterator[str]:
        """The entities and frames that something may stand relative to, as it would write them."""
        scope = self.scopes.get(name, "")
        prefix = self.prefixes.get(scope, "")
        return (
            other[len(prefix) :]
            for other in names
            if other != name and self.scopes.get(other, "") == scope and other.startswith(prefix)
        )


_SLICE = re.compile(r"^\s*(-?[0-9]{0,9})\s*:\s*(-?[0-9]{0,9})\s*(?::\s*(-?[0-9]{0,9})\s*)?$")


def resolve_scene_idxs(
    given: str | list[int | str] | None, num_scenes: int, origin: Origin, sink: Sink
) -> tuple[int, ...] | None:
    """Scene indices, ascending; None where the selection was reported.

    Args:
        given: as written; None selects every scene.
        num_scenes: how many there are.
        origin: of the `scene_idxs` key's value.
        sink: takes the diagnostics.
    """
    if given is None:
        return tuple(range(num_scenes))
    first: dict[int, Origin] = {}
    failed = False
    # Of more items than scenes one repeats another or is wrong: what follows tells no more.
    for i, item in enumerate([given] if isinstance(given, str) else given[: num_scenes + 1]):
        place = origin if isinstance(given, str) else origin.child(i)
        indices = _item_indices(item, num_scenes, place, sink)
        if indices is None:
            failed = True
            continue
        for index in indices:
            if index in first:
                failed = True
                before = first[index]
                message = f"scene {index} is selected twice"
                sink.report("SC308", message, place, related=[("selected here already", before, "value")])
                break
            first[index] = place
    if not first and not failed:
        sink.report("SC309", "this selects no scene", origin, hint="leave it out to select every scene")
    return None if failed or not first else tuple(sorted(first))


def count_scene_idxs(given: str | list[int | str] | None, num_scenes: int) -> int:
    """How many scenes `resolve_scene_idxs` would select, at most; wrong items, which it reports, may count."""
    if given is None:
        return num_scenes
    items = [given] if isinstance(given, str) else given[:num_scenes]
    return min(num_scenes, sum(1 if isinstance(item, int) else _slice_length(item, num_scenes) for item in items))


def _slice_length(text: str, num_scenes: int) -> int:
    match = _SLICE.match(text)
    if match is None:
        return 0
    start, stop, step = (int(part) if part else None for part in match.groups())
    return 0 if step == 0 else len(range(num_scenes)[start:stop:step])


def _item_indices(item: int | str, num_scenes: int, place: Origin, sink: Sink) -> range | None:
    if isinstance(item, int):
        if 0 <= item < num_scenes:
            return range(item, item + 1)
        _report_out_of_range(item, num_scenes, place, sink)
        return None
    match = _SLICE.match(item)
    if match is None or match[3] in {"0", "-0"} or (match[3] and int(match[3]) == 0):
        sink.report(
            "SC310", f"{item[:60]!r} is not a slice", place, hint='write a number, "start:stop" or "start:stop:step"'
        )
        return None
    start, stop, step = (int(part) if part else None for part in match.groups())
    for bound in (start, stop):
        # Python's slices clip; here a bound beyond the scenes is a mistake (stop may be one past the last).
        if bound is not None and not -num_scenes <= bound <= num_scenes:
            _report_out_of_range(bound, num_scenes, place, sink)
            return None
    indices = range(num_scenes)[start:stop:step]
    if not indices:
        sink.report("SC309", f"{item[:60]!r} selects none of the {num_scenes} scenes", place)
        return None
    return indices


def _report_out_of_range(index: int, num_scenes: int, place: Origin, sink: Sink) -> None:
    scenes = "the only scene is 0" if num_scenes == 1 else f"scenes are 0 to {num_scenes - 1}"
    sink.report(
        "SC307",
        f"there is no scene {index}: {scenes}",
        place,
        hint="raise `num_scenes`",
    )


MAX_PATTERN_LENGTH = 200
"""Characters of a pattern."""

MAX_STATES = 2000
"""States of an automaton: a counted repetition has as many as it counts."""

_PARSER: Any = import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")

_REPEATS = frozenset(("MAX_REPEAT", "MIN_REPEAT", "POSSESSIVE_REPEAT"))

_UNSUPPORTED_OPS = {
    "GROUPREF": "a back-reference",
    "GROUPREF_EXISTS": "a back-reference",
    "ASSERT": "a look-around",
    "ASSERT_NOT": "a look-around",
    "ATOMIC_GROUP": "an atomic group",
    "POSSESSIVE_REPEAT": "a possessive repetition",
}

_CATEGORIES = {
    "CATEGORY_DIGIT": r"\d",
    "CATEGORY_NOT_DIGIT": r"\D",
    "CATEGORY_SPACE": r"\s",
    "CATEGORY_NOT_SPACE": r"\S",
    "CATEGORY_WORD": r"\w",
    "CATEGORY_NOT_WORD": r"\W",
}

_ANCHORS: dict[str, Callable[[str, str], bool]] = {
    "AT_BEGINNING": lambda before, _after: not before,
    "AT_BEGINNING_STRING": lambda before, _after: not before,
    "AT_END": lambda _before, after: not after,
    "AT_END_STRING": lambda _before, after: not after,
    "AT_BOUNDARY": lambda before, after: _is_word(before) is not _is_word(after),
    "AT_NON_BOUNDARY": lambda before, after: _is_word(before) is _is_word(after),
}
"""What must be so between the letters before and after a place, "" at the ends of a name."""


class PatternError(Exception):
    """A pattern that is not taken; its text says why."""


class NamePattern:
    """A pattern that was read.

    Attributes:
        text: as written.
    """

    def __init__(self, text: str) -> None:
        """Reads a pattern.

        Raises:
            PatternError: it is no regular expression, or one that is not taken here.
        """
        self.text = text
        if len(text) > MAX_PATTERN_LENGTH:
            raise PatternError(f"a pattern of {len(text)} characters is longer than {MAX_PATTERN_LENGTH}")
        try:
            tree = _PARSER.parse(text)
        except (re.error, OverflowError, RecursionError) as error:
            raise PatternError(f"invalid regular expression: {error}") from error
        if tree.state.flags & ~re.UNICODE.value:
            raise PatternError("a pattern must not have flags")
        self._tests: list[Any] = []
        self._moves: list[tuple[int, ...]] = []
        self._last = self._state(None)
        self._first = self._sequence(tree, self._last, repeated=False)

    def matches(self, name: str) -> bool:
        """Whether it matches the whole of a name."""
        following = [self._first]
        for before, letter in pairwise(("", *name)):
            here = self._reached(following, before, letter)
            following = [self._moves[state][0] for state in here if _accepts(self._tests[state], letter)]
            if not following:
                return False
        return self._last in self._reached(following, name[-1:], "")

    def _reached(self, states: list[int], before: str, after: str) -> set[int]:
        """States with all that is reached from them without a letter, between two letters of a name."""
        found: set[int] = set()
        todo = states.copy()
        while todo:
            state = todo.pop()
            if state not in found:
                found.add(state)
                test = self._tests[state]
                if test is None or (test[0] == "AT" and _ANCHORS[test[1]](before, after)):
                    todo += self._moves[state]
        return found

    def _state(self, test: Any, *moves: int) -> int:
        """A new state: None tests nothing and leads on without a letter, as an edge does where it is one."""
        if len(self._tests) >= MAX_STATES:
            raise PatternError("this pattern repeats too much")
        self._tests.append(test)
        self._moves.append(moves)
        return len(self._tests) - 1

    def _sequence(self, items: Any, after: int, *, repeated: bool) -> int:
        for operation, argument in reversed(list(items)):
            after = self._one(str(operation), argument, after, repeated=repeated)
        return after

    def _one(self, operation: str, argument: Any, after: int, *, repeated: bool) -> int:
        if operation in _UNSUPPORTED_OPS:
            raise PatternError(f"{_UNSUPPORTED_OPS[operation]} is not supported in a pattern of names")
        if operation in _REPEATS:
            least, most, inner = argument
            if (least, most) == (0, 1):
                # What may be left out is not repeated.
                return self._state(None, self._sequence(inner, after, repeated=repeated), after)
            if repeated:
                raise PatternError("a repetition inside a repetition is not supported in a pattern of names")
            return self._repeat(least, most, inner, after)
        if operation == "BRANCH":
            return self._state(None, *(self._sequence(branch, after, repeated=repeated) for branch in argument[1]))
        if operation == "SUBPATTERN":
            _, added, removed, inner = argument
            if added or removed:
                raise PatternError("a pattern must not have flags")
            return self._sequence(inner, after, repeated=repeated)
        if operation == "AT":
            return self._state((operation, str(argument)), after)
        return self._state((operation, argument), after)

    def _repeat(self, least: Any, most: Any, inner: Any, after: int) -> int:
        low, high = int(least), None if str(most) == "MAXREPEAT" else int(most)
        if high is None:
            around = self._state(None)
            self._moves[around] = (self._sequence(inner, around, repeated=True), after)
            start = around
        else:
            start = after
            for _ in range(high - low):
                start = self._state(None, self._sequence(inner, start, repeated=True), after)
        for _ in range(low):
            start = self._sequence(inner, start, repeated=True)
        return start


def _accepts(test: Any, letter: str) -> bool:
    if test is None:
        return False
    operation, argument = test
    match operation:
        case "AT":
            return False
        case "LITERAL":
            return ord(letter) == argument
        case "NOT_LITERAL":
            return ord(letter) != argument
        case "ANY":
            return letter != "\n"
        case _:
            negated = bool(argument) and str(argument[0][0]) == "NEGATE"
            return any(_matches_set_item(item, letter) for item in argument[negated:]) is not negated


def _is_word(letter: str) -> bool:
    return letter.isalnum() or letter == "_"


def _matches_set_item(item: Any, letter: str) -> bool:
    kind, argument = str(item[0]), item[1]
    if kind == "LITERAL":
        return ord(letter) == argument
    if kind == "RANGE":
        return argument[0] <= ord(letter) <= argument[1]
    return re.match(_CATEGORIES[str(argument)], letter) is not None


@lru_cache(maxsize=256)
def compile_name_pattern(text: str) -> NamePattern:
    """A pattern, read once.

    Raises:
        PatternError: it is not taken.
    """
    return NamePattern(text)
