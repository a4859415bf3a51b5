"""Patterns of names: regular expressions that match whole names, in time that grows with the name's length alone.

Python reads a pattern, and an automaton of ours matches: its own matcher goes back and tries again, which a pattern and
a name made for each other turn into hours.
"""

from __future__ import annotations

import re
import sys
from functools import lru_cache
from importlib import import_module
from itertools import pairwise
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

LONGEST = 200
"""Characters of a pattern."""

MOST_STATES = 2000
"""States of an automaton: a counted repetition has as many as it counts."""

_PARSER: Any = import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")
_REPEATS = frozenset(("MAX_REPEAT", "MIN_REPEAT", "POSSESSIVE_REPEAT"))
_REFUSED = {
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
_EDGES: dict[str, Callable[[str, str], bool]] = {
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
        if len(text) > LONGEST:
            raise PatternError(f"a pattern of {len(text)} characters is longer than {LONGEST}")
        try:
            tree = _PARSER.parse(text)
        except (re.error, OverflowError, RecursionError) as error:
            raise PatternError(f"this is no regular expression: {error}") from error
        if tree.state.flags & ~re.UNICODE.value:
            raise PatternError("a pattern takes no flags")
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
                if test is None or (test[0] == "AT" and _EDGES[test[1]](before, after)):
                    todo += self._moves[state]
        return found

    def _state(self, test: Any, *moves: int) -> int:
        """A new state: None tests nothing and leads on without a letter, as an edge does where it is one."""
        if len(self._tests) >= MOST_STATES:
            raise PatternError("this repeats too much for a pattern of names")
        self._tests.append(test)
        self._moves.append(moves)
        return len(self._tests) - 1

    def _sequence(self, items: Any, after: int, *, repeated: bool) -> int:
        for operation, argument in reversed(list(items)):
            after = self._one(str(operation), argument, after, repeated=repeated)
        return after

    def _one(self, operation: str, argument: Any, after: int, *, repeated: bool) -> int:
        if operation in _REFUSED:
            raise PatternError(f"{_REFUSED[operation]} is not taken in a pattern of names")
        if operation in _REPEATS:
            least, most, inner = argument
            if (least, most) == (0, 1):
                # What may be left out is not repeated.
                return self._state(None, self._sequence(inner, after, repeated=repeated), after)
            if repeated:
                raise PatternError("a repetition inside a repetition is not taken in a pattern of names")
            return self._repeat(least, most, inner, after)
        if operation == "BRANCH":
            return self._state(None, *(self._sequence(branch, after, repeated=repeated) for branch in argument[1]))
        if operation == "SUBPATTERN":
            _, added, removed, inner = argument
            if added or removed:
                raise PatternError("a pattern takes no flags")
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
            return any(_in(item, letter) for item in argument[negated:]) is not negated


def _is_word(letter: str) -> bool:
    return letter.isalnum() or letter == "_"


def _in(item: Any, letter: str) -> bool:
    kind, argument = str(item[0]), item[1]
    if kind == "LITERAL":
        return ord(letter) == argument
    if kind == "RANGE":
        return argument[0] <= ord(letter) <= argument[1]
    return re.match(_CATEGORIES[str(argument)], letter) is not None


@lru_cache(maxsize=256)
def name_pattern(text: str) -> NamePattern:
    """A pattern, read once.

    Raises:
        PatternError: it is not taken.
    """
    return NamePattern(text)
