"""Expressions from strangers: each is refused at once, or gives something small."""

from __future__ import annotations

import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.values.failure import ExpressionError
from scenecc.values.operations import HEAVIEST, fits
from scenecc.values.template import Template

HOSTILE = {
    "attribute": "().__class__.__bases__[0].__subclasses__()",
    "attribute of a string": "'{0.__class__}'.format(1)",
    "dunder name": "__import__('os').system('true')",
    "builtin": "open('/etc/passwd')",
    "eval": "eval('1')",
    "getattr": "getattr(1, 'real')",
    "builtins": "__builtins__",
    "type": "type(1)",
    "power tower": "10 ** 10 ** 10",
    "powers of powers": "((2 ** 200) ** 200) ** 200",
    "float power": "1e300 ** 1e300",
    "huge exponent": "3 ** 99999999999999999999",
    "product": "*".join(["(2 ** 200)"] * 80),
    "long text": "'a' * 10 ** 9",
    "long text the other way": "10 ** 9 * 'a'",
    "long list": "[0] * 10 ** 9",
    "nested lists": "[[[0] * 100] * 100] * 100",
    "doubling": "+".join(["'" + "a" * 90 + "'"] * 9) + "+ 'a' * 9999",
    "empty text repeated": "len('' * 10 ** 18) / 0",
    "empty list repeated": "len([] * 10 ** 18) / 0",
    "rounding to digits": "round(7, -10 ** 9)",
    "giant literal": "9" * 999,
    "giant literal beyond the length": "9" * 100_000,
    "giant float": "1" + "0" * 500 + ".0",
    "minus signs": "-" * 990 + "1",
    "nots": "not " * 240 + "1",
    "sum chain": "+".join(["1"] * 490),
    "power chain": "**".join(["1"] * 330),
    "index chain": "point" + "[0]" * 300,
    "brackets": "(" * 400 + "1" + ")" * 400,
    "lists in lists": "[" * 450 + "]" * 450,
    "unclosed brackets": "[" * 900,
    "beyond the length": "1 + " * 100_000 + "1",
    "an endless text": "'" + "a" * 1_000_000,
    "backslashes": "'" + "\\\\" * 400_000,
    "lambda": "(lambda: 1)()",
    "walrus": "(a := 1)",
    "comprehension": "[x for x in point]",
    "generator": "sum(x for x in point)",
    "starred": "[*point]",
    "starred argument": "max(*point)",
    "keyword argument": "round(1, ndigits=2)",
    "formatted string": "f'{1}'",
    "formatting": "'%999999999d' % 1",
    "bytes": "b'a'",
    "raw string": "r'a'",
    "triple quotes": "'''a'''",
    "complex": "1j",
    "ellipsis": "...",
    "dict": "{1: 2}",
    "set": "{1, 2}",
    "slice": "point[::2]",
    "await": "await x",
    "yield": "(yield 1)",
    "semicolon": "1; 2",
    "assignment": "i = 1",
    "two expressions": "1)+(1",
    "newline in a string": "'a\nb'",
    "escape by name": r"'\N{BULLET}'",
    "escape by code": r"'\x41'",
    "unknown escape": r"'\d'",
    "null": "1 \0",
    "byte order mark": "\ufeff1",
    "fullwidth name": "ｍin(1, 2)",
    "letter like a name": "ℯ",
    "greek": "π",
    "non-breaking space": "1\u00a0+ 1",
    "form feed": "1 \f+ 1",
    "arabic digits": "١ + 1",
    "superscript": "2²",
    "lone surrogate": "'\ud800' + 1",
    "reversed text": "1 \u202e+ 1",
    "number against a word": "1if 1else 2",
    "identity": "1 is 1",
    "call of a call": "sin(1)(2)",
    "call of a string": "'sin'(1)",
    "matrix product": "1 @ 2",
    "shift": "1 << 10 ** 9",
    "inversion": "~1",
    "print": "print(1)",
    "recursion": "${${i}}",
    "comment": "1 # }",
}


@pytest.mark.parametrize("expression", HOSTILE.values(), ids=HOSTILE.keys())
def test_hostile_expressions_are_refused_at_once(expression: str) -> None:
    begun = time.process_time()
    with pytest.raises(ExpressionError) as caught:
        Template.parse("${" + expression + "}").evaluate({"i": 1, "point": [1, 2]})
    assert time.process_time() - begun < 1
    error = caught.value
    assert 0 <= error.start <= error.end <= len(expression) + 3
    assert len(error.message) < 200


@pytest.mark.parametrize(
    "expression",
    ["1 ** 10 ** 60", "(-1) ** (10 ** 60 + 1)", "0 ** 10 ** 60", "2 ** -(2 ** 250)", "0 if 0 else " * 80 + "1"],
)
def test_a_large_power_of_what_stays_small_has_its_value(expression: str) -> None:
    assert Template.parse("${" + expression + "}").evaluate({}) in {1, -1, 0}


def test_many_expressions_in_one_scalar_are_bounded() -> None:
    with pytest.raises(ExpressionError, match="at most 1000 expressions"):
        Template.parse("${i}" * 1001)
    long = "x" * 9000
    with pytest.raises(ExpressionError, match="more than 100000 characters"):
        Template.parse("${s}" * 12).evaluate({"s": long})
    # What is not an expression may be as long as it likes.
    assert len(Template.parse("y" * 1_000_000 + "${i}").evaluate({"i": 1})) == 1_000_001


TOKENS = st.sampled_from(
    (
        *"0129.,()[]+-*/%<>:{}is",
        *(
            "2.5",
            "1e9",
            "//",
            "**",
            "==",
            "<=",
            "and",
            "or",
            "not",
            "if",
            "else",
            "'ab'",
            "''",
            "min(",
            "len(",
            "round(",
        ),
    )
)


@given(st.lists(TOKENS, max_size=40).map(" ".join))
def test_whatever_is_written_is_answered(expression: str) -> None:
    names: dict[str, Any] = {"i": 7, "s": [1, [2], "text"]}
    try:
        found = Template.parse("${" + expression + "}").evaluate(names)
    except ExpressionError:
        return
    assert fits(found, 2 * HEAVIEST + len(expression))


@given(st.text(max_size=60).flatmap(lambda text: st.sampled_from([text, "${" + text + "}"])))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        Template.parse(text).evaluate({})
    except ExpressionError as error:
        assert 0 <= error.start <= error.end <= len(text)  # noqa: PT017 - its place is what is tested
