"""References within a document: qualified names, `scene_idxs` and name patterns.

Python's regular expressions backtrack, which takes hours for some patterns. So the worst case of a pattern is computed
before it is used.
"""

from __future__ import annotations

import math
import re
import sys
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from scenecc.diagnostics import Sink
    from scenecc.diagnostics.diagnostic import Origin
    from scenecc.spec.params import ParamType


NAME_SECTIONS = (
    "params", "draws", "materials", "collision_groups", "frames", "entities", "constraints", "lights", "cameras"
)  # fmt: skip
"""Sections whose keys are names."""

SHARED_NAMESPACE = ("frames", "entities", "cameras")
"""Sections that share one namespace."""


def qualified_name(section: str, name: str) -> str:
    """Returns a name that is unique in the document: `NAME` in the shared namespace, else `SECTION:NAME`.

    Args:
        section: `frames`, `entities`, `cameras`, `constraints` or `lights`.
        name: full name. It never contains a colon.
    """
    return name if section in SHARED_NAMESPACE else f"{section}:{name}"


WORLD = "world"


@dataclass(frozen=True, slots=True)
class NameScopes:
    """Resolves names in an expanded document.

    Entities, frames, cameras, constraints and lights have full names. An instance is also a frame, and the *scope* of
    the objects inside it. Names in an object refer to its scope. For an object `owner` with
    `S = scopes.get(owner, "")`:

    - `NAME` in `relative_to`, in `mount` or in a constraint is `prefixes.get(S, "") + NAME`; `world` and a missing
      `relative_to` are the frame `anchors[S]`, or the world if S is "";
    - a material `NAME` is `S/NAME`, or `NAME` if S is ""; a material `/NAME` is always `NAME`;
    - a collision group `NAME`, and a draw `NAME` in a template, are `S/NAME`, or `NAME` if S is "".

    A material, group or draw `A/B/NAME` has the scope `A/B`, except the draws in `given`.

    Names in an `override` refer to the overriding file: there `/NAME` is the full name of an entity or frame.

    Attributes:
        scopes: qualified name of an entity, frame, camera, constraint or light inside an instance → its scope.
        prefixes: scope → prefix of the names of its entities and frames.
        anchors: scope → its frame.
        given: draw that holds an argument of a `with` → scope of the `with`.
        used_materials: materials that are never reported as unused: arguments, materials of an instance, and those
            that other parameters may use.
        wanted: draw that holds a parameter → type of the parameter.
        worlds: qualified name of a node with `world` in an `override` → scope of that `world`.
        overridden: scopes with an `override` inside, where draws may be unread.
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
        """Returns the full name of the frame that the pose of `name` is relative to; None for the world."""
        scope = self.scopes.get(name, "")
        if relative_to == WORLD:
            scope = self.worlds.get(name, scope)
        if relative_to in (None, WORLD):
            return self.anchors.get(scope) if scope else None
        return self.full_name(relative_to, scope)

    def full_name(self, written: str, scope: str) -> str:
        """Returns the full name of an entity, frame or link that is named in a scope."""
        return written[1:] if written.startswith("/") else self.prefixes.get(scope, "") + written

    def seen_by(self, name: str, names: Iterable[str]) -> Iterator[str]:
        """Yields the names that a node may use in `relative_to`, within its scope."""
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
    """Returns the selected scene indices, ascending, or None after an error. `given=None` selects every scene."""
    if given is None:
        return tuple(range(num_scenes))
    first: dict[int, Origin] = {}
    failed = False
    # More items than scenes must contain an error, so the rest need not be read.
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
                sink.report("SC308", message, place, related=[("already selected here", before, "value")])
                break
            first[index] = place
    if not first and not failed:
        sink.report("SC309", "this selects no scene", origin, hint="remove it to select every scene")
    return None if failed or not first else tuple(sorted(first))


def count_scene_idxs(given: str | list[int | str] | None, num_scenes: int) -> int:
    """Returns an upper bound of the number of scenes that `resolve_scene_idxs` selects. Invalid items may count."""
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
        hint = 'write a number, "start:stop" or "start:stop:step"'
        if item.strip().lower() in {"all", "*", "any", "every"}:
            hint = 'remove `scene_idxs`, or write ":": every scene is the default'
        sink.report("SC310", f"{item[:60]!r} is not a slice", place, hint=hint)
        return None
    start, stop, step = (int(part) if part else None for part in match.groups())
    for bound in (start, stop):
        # Unlike in Python, a bound out of range is an error; the stop may be one past the last scene.
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
        hint=f"write `num_scenes: {index + 1}`, or another index" if index >= 0 else "count from 0",
    )


MAX_PATTERN_LENGTH = 200
"""Longest pattern [characters]."""

MAX_STEPS = 100_000_000
"""Most steps of a pattern on a name of 64 characters."""

_PARSER: Any = import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")

_REPEATS = frozenset(("MAX_REPEAT", "MIN_REPEAT"))

_UNSUPPORTED_OPS = {
    "GROUPREF": "a back-reference",
    "GROUPREF_EXISTS": "a back-reference",
    "ASSERT": "a look-around",
    "ASSERT_NOT": "a look-around",
    "ATOMIC_GROUP": "an atomic group",
    "POSSESSIVE_REPEAT": "a possessive repetition",
}


class PatternError(Exception):
    """A pattern is not supported. The message gives the reason."""


@dataclass(frozen=True, slots=True)
class _Choices:
    """The choices of a backtracking matcher.

    Attributes:
        loops: number of unbounded repetitions.
        ways: number of combinations of all other choices.
        width: most characters that are compared in one combination.
    """

    loops: int = 0
    ways: int = 1
    width: int = 0


class NamePattern:
    """A regular expression that matches whole names."""

    def __init__(self, text: str) -> None:
        """Compiles a pattern.

        Raises:
            PatternError: the pattern is invalid or not supported.
        """
        if len(text) > MAX_PATTERN_LENGTH:
            raise PatternError(f"a pattern of {len(text)} characters is longer than {MAX_PATTERN_LENGTH}")
        try:
            tree = _PARSER.parse(text)
            self._expression = re.compile(text)
        except (re.error, OverflowError, RecursionError) as error:
            raise PatternError(f"invalid regular expression: {error}") from error
        if tree.state.flags & ~re.UNICODE.value:
            raise PatternError("a pattern must not have flags")
        self._choices = _choices_of_all(tree)
        if self.steps(64) > MAX_STEPS:
            raise PatternError("this pattern has too many repetitions and alternatives")

    def steps(self, length: int) -> int:
        """Returns an upper bound of the matcher's steps on a name of `length` characters."""
        found = self._choices
        return math.comb(length + found.loops, found.loops) * found.ways * (1 + found.width)

    def matches(self, name: str) -> bool:
        """Returns whether the pattern matches the whole name."""
        return self._expression.fullmatch(name) is not None


def _choices_of_all(items: Any) -> _Choices:
    """Returns the choices of a sequence of items."""
    found = [_choices(str(operation), argument) for operation, argument in items]
    ways = math.prod(one.ways for one in found)
    return _Choices(sum(one.loops for one in found), ways, sum(one.width for one in found))


def _choices(operation: str, argument: Any) -> _Choices:
    """Returns the choices of one item of a pattern, or raises PatternError."""
    if operation in _UNSUPPORTED_OPS:
        raise PatternError(f"{_UNSUPPORTED_OPS[operation]} is not supported in a pattern of names")
    if operation == "BRANCH":
        found = [_choices_of_all(branch) for branch in argument[1]]
        loops, width = max(one.loops for one in found), max(one.width for one in found)
        return _Choices(loops, sum(one.ways for one in found), width)
    if operation == "SUBPATTERN":
        _, added, removed, inner = argument
        if added or removed:
            raise PatternError("a pattern must not have flags")
        return _choices_of_all(inner)
    if operation not in _REPEATS:
        return _Choices(width=operation != "AT")
    low, high, inner = argument
    one = _choices_of_all(inner)
    if str(high) != "MAXREPEAT" and (high == 1 or not one.loops):
        return _Choices(one.loops, (high - low + 1) * one.ways ** min(high, MAX_PATTERN_LENGTH), one.width * high)
    if one.loops or one.ways > 1:
        raise PatternError("a repetition or a choice inside a repetition is not supported in a pattern of names")
    return _Choices(1, 1, one.width)


@lru_cache(maxsize=256)
def compile_name_pattern(text: str) -> NamePattern:
    """Compiles a pattern, with a cache.

    Raises:
        PatternError: the pattern is invalid or not supported.
    """
    return NamePattern(text)
