"""Patterns of names: what they match, what is refused, and that no pair of pattern and name takes long."""

from __future__ import annotations

import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.nightly import assert_took

from scenecc.spec.references import MAX_PATTERN_LENGTH, NamePattern, PatternError, compile_name_pattern

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
        ("(a+)+", "repetition inside"),
        ("(a{1,50}){2}", "repetition inside"),
        ("(?=a)a", "look-around"),
        ("(?<!b)a", "look-around"),
        (r"(a)\1", "back-reference"),
        ("(?P<n>a)(?(n)b|c)", "back-reference"),
        ("(?i)a", "flags"),
        ("(?i:a)", "flags"),
        ("a" * (MAX_PATTERN_LENGTH + 1), "201 characters"),
        ("(a", "invalid regular expression"),
        ("a{3000}", "too much"),
    ],
)
def test_what_is_not_taken_is_refused_and_says_why(pattern: str, why: str) -> None:
    with pytest.raises(PatternError, match=why):
        compile_name_pattern(pattern)


@pytest.mark.parametrize("pattern", [".*" * 99 + "b", "a*" * 100, ".{1900}", "(a|a|a)" * 28, "(a?)*"])
def test_no_pattern_takes_long(pattern: str) -> None:
    try:
        mine = NamePattern(pattern)
    except PatternError:
        return
    since = time.perf_counter()
    mine.matches("a" * 256 + "!")
    assert_took(time.perf_counter() - since, most=1)
