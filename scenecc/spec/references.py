"""How a document refers to its parts: qualified names, `scene_idxs`, and patterns of names.

Python's matcher of patterns backtracks, which takes hours for some pairs of pattern and name. So a pattern's choices
are counted before it is matched.
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
                sink.report("SC308", message, place, related=[("already selected here", before, "value")])
                break
            first[index] = place
    if not first and not failed:
        sink.report("SC309", "this selects no scene", origin, hint="remove it to select every scene")
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

MAX_STEPS = 100_000_000
"""Steps that a pattern may take with a name of 64 letters, at most."""

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
    """A pattern that is not supported; its text says why."""


@dataclass(frozen=True, slots=True)
class _Choices:
    """What a backtracking matcher may try.

    Attributes:
        loops: repetitions without an upper bound.
        ways: in which everything else can be chosen.
        width: letters that are compared for one choice, at most.
    """

    loops: int = 0
    ways: int = 1
    width: int = 0


class NamePattern:
    """A regular expression that matches whole names."""

    def __init__(self, text: str) -> None:
        """Reads a pattern.

        Raises:
            PatternError: it is not a regular expression, or not a supported one.
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
        """How many steps Python's matcher, which backtracks, takes at most with a name of so many letters."""
        found = self._choices
        return math.comb(length + found.loops, found.loops) * found.ways * (1 + found.width)

    def matches(self, name: str) -> bool:
        """Whether it matches the whole of a name."""
        return self._expression.fullmatch(name) is not None


def _choices_of_all(items: Any) -> _Choices:
    """The choices of a sequence: of each item, there are those of all others."""
    found = [_choices(str(operation), argument) for operation, argument in items]
    ways = math.prod(one.ways for one in found)
    return _Choices(sum(one.loops for one in found), ways, sum(one.width for one in found))


def _choices(operation: str, argument: Any) -> _Choices:
    """The choices of one item of a pattern. Raises PatternError."""
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
    """A pattern, read once.

    Raises:
        PatternError: it is not supported.
    """
    return NamePattern(text)
