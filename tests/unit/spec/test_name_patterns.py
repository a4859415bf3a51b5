"""Patterns of names: what they match, what is refused, and that no pair of pattern and name takes many steps."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.spec.references import _PARSER, MAX_PATTERN_LENGTH, NamePattern, PatternError, compile_name_pattern

PATTERNS = [
    "panda_joint.*", "panda_.*finger", "a|bc|d[0-9]+", "(left|right)_(arm|leg)_[1-7]", "[^a-c]x?", r"\w+\d{2,3}",
    "a{0,3}b", r"j\.x", "^a$", "^(a|bc)$", "", r"(left_\w+)?x*", r"a\b.*", r"\Ba", "a+?b", ".", r"\S*[\d_-]",
    r"\D\W?\s*", "(?:a|b)c", "(?P<side>l|r)_a",
]  # fmt: skip
NAMES = [
    "panda_joint1", "panda_leftfinger", "a", "bc", "d12", "left_leg_3", "dx", "d", "abc12", "aab", "b", "aaaab", "j.x",
    "jqx", "", "left_x", "a-b", "a b", "ac", "l_a", "é",
]  # fmt: skip


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_pattern_matches_what_the_regular_expression_matches_whole(pattern: str) -> None:
    mine = NamePattern(pattern)
    assert [mine.matches(name) for name in NAMES] == [bool(re.fullmatch(pattern, name)) for name in NAMES]


@given(
    st.lists(st.sampled_from(["a", "b", ".", "[ab]", "(a|bb)", "a?", "b*", "[^a]+", "(ab)?", "a{1,2}"]), max_size=6),
    st.text("abc", max_size=8),
)
def test_any_pattern_of_these_parts_matches_likewise(parts: list[str], name: str) -> None:
    pattern = "".join(parts)
    assert NamePattern(pattern).matches(name) == bool(re.fullmatch(pattern, name))


@pytest.mark.parametrize(
    ("pattern", "why"),
    [
        ("(a+)+", "inside a repetition"),
        ("(a|bb)*", "choice inside"),
        ("(?=a)a", "look-around"),
        ("(?<!b)a", "look-around"),
        (r"(a)\1", "back-reference"),
        ("(?P<n>a)(?(n)b|c)", "back-reference"),
        ("(?i)a", "flags"),
        ("(?i:a)", "flags"),
        ("a" * (MAX_PATTERN_LENGTH + 1), "201 characters"),
        ("(a", "invalid regular expression"),
        (".*a.*b.*c.*d.*e.*f", "too many repetitions"),
    ],
)
def test_what_is_not_taken_is_refused_and_says_why(pattern: str, why: str) -> None:
    with pytest.raises(PatternError, match=why):
        compile_name_pattern(pattern)


class Backtracking:
    """A matcher that tries everything, and counts the letters that it compares."""

    def __init__(self, name: str) -> None:
        self.name, self.compared = name, 0

    def ends(self, items: Any, at: int) -> Iterator[int]:
        if not items:
            yield at
            return
        for end in self.ends_of_one(str(items[0][0]), items[0][1], at):
            yield from self.ends(items[1:], end)

    def ends_of_one(self, operation: str, argument: Any, at: int) -> Iterator[int]:
        if operation == "BRANCH":
            for branch in argument[1]:
                yield from self.ends(list(branch), at)
        elif operation == "SUBPATTERN":
            yield from self.ends(list(argument[3]), at)
        elif operation == "MAX_REPEAT":
            low, high, inner = argument
            yield from self.repeated(low, high, inner, at)
        else:
            self.compared += 1
            if self.name[at : at + 1] == "a" and (operation, argument) in {("ANY", None), ("LITERAL", ord("a"))}:
                yield at + 1

    def repeated(self, low: int, high: int, inner: Any, at: int) -> Iterator[int]:
        if high:
            for end in self.ends(list(inner), at):
                if end > at:
                    yield from self.repeated(max(low - 1, 0), int(high) - 1, inner, end)
        if not low:
            yield at


def compared(pattern: str, name: str) -> int:
    matcher = Backtracking(name)
    for _ in matcher.ends(list(_PARSER.parse(pattern)), 0):
        pass
    return matcher.compared


@given(
    st.lists(
        st.sampled_from(["a", ".", "(a|aa)", "a?", "a*", ".+", "(aa)*", "(a|a)?", "a{1,3}", "(aa){2}"]), max_size=6
    ),
    st.integers(0, 9),
)
def test_a_pattern_is_matched_in_as_many_steps_as_are_counted(parts: list[str], length: int) -> None:
    pattern = "".join(parts)
    assert compared(pattern, "a" * length) <= NamePattern(pattern).steps(length) * max(len(parts), 1)


@pytest.mark.parametrize(
    ("pattern", "short", "letters"),
    [
        ("(a|a)*b", "(a|a)*b", 12),
        ("(a?a)*b", "(a?a)*b", 18),
        ("(a+)+b", "(a+)+b", 12),
        ("a?" * 50 + "b", "a?" * 12 + "b", 12),
        (".*" * 99 + "b", ".*" * 6 + "b", 12),
        ("(a|a|a)" * 28, "(a|a|a)" * 9, 9),
    ],
)
def test_a_pattern_that_would_take_long_is_refused(pattern: str, short: str, letters: int) -> None:
    # Each further letter, or each further part of the pattern, multiplies this.
    assert compared(short, "a" * letters) > 2**12
    with pytest.raises(PatternError):
        NamePattern(pattern)


def test_what_people_write_takes_few_steps() -> None:
    for pattern in PATTERNS:
        assert NamePattern(pattern).steps(64) < 100_000, pattern
    assert NamePattern(".*_(left|right)_.*_joint_.*").steps(64) < 2_000_000
