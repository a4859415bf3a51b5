"""What expressions give, and what they refuse: wrong and hostile text."""

from __future__ import annotations

import copy
import math
import pickle
import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plugins.nightly import assert_took

from scenecc.variation.expression import RESERVED_NAMES
from scenecc.variation.forms import Template
from scenecc.variation.operations import FUNCTIONS, MAX_SIZE, ExpressionError, fits

NAMES: dict[str, Any] = {"i": 3, "size": 1.5, "flag": True, "word": "leg", "point": [1, 2.5, -3], "pair": (4, 5)}


def value(expression: str, **names: Any) -> Any:
    return Template.parse("${" + expression + "}").evaluate({**NAMES, **names})


def refused(text: str, **names: Any) -> ExpressionError:
    with pytest.raises(ExpressionError) as caught:
        Template.parse(text).evaluate({**NAMES, **names})
    return caught.value


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("1", 1),
        ("1.5e-3", 0.0015),
        (".5", 0.5),
        ("i * (size - 0.5) / 2", 1.5),
        ("-i ** 2", -9),
        ("2 ** -1", 0.5),
        ("7 // 2", 3),
        ("-7 // 2", -4),
        ("-7 % 3", 2),
        ("7.5 // 2", 3.0),
        ("6 / 3", 2.0),
        ("'a' + 'b'", "ab"),
        ('"it\'s"', "it's"),
        (r"'a\\b\n'", "a\\b\n"),
        ("'ab' * 2", "abab"),
        ("2 * [1]", [1, 1]),
        ("[1, [2, 'x']]", [1, [2, "x"]]),
        ("[]", []),
        ("point[0] + point[-1]", -2),
        ("pair[1]", 5),
        ("pair + [1]", [4, 5, 1]),
        ("word[1]", "e"),
        ("1 < 2 < 3", True),
        ("1 < 2 > 5", False),
        ("word == 'leg' and i != 4", True),
        ("'a' < 'b'", True),
        ("pair == [4, 5]", True),
        ("not flag", False),
        ("i and 0", 0),
        ("0 or size", 1.5),
        ("true", True),
        ("False", False),
        ("'even' if i % 2 == 0 else 'odd'", "odd"),
        ("1 if i else 2", 1),
        ("1 if flag else 1 / 0", 1),
        ("flag or 1 / 0", True),
        ("pi", math.pi),
        ("min(3, 1.0, 2)", 1.0),
        ("max(point)", 2.5),
        ("abs(-i)", 3),
        ("+i - -i", 6),
        ("sqrt(2)", math.sqrt(2)),
        ("atan2(1, -1)", math.atan2(1, -1)),
        ("hypot(3, -4)", 5.0),
        ("hypot(2, 3, 6)", 7.0),
        ("smoothstep(1, 3, 0)", 0.0),
        ("smoothstep(1, 3, 1.5)", 0.15625),
        ("smoothstep(3, 1, 1.5)", 0.84375),
        ("smoothstep(1, 3, 9)", 1.0),
        ("smoothstep(2, 2, 2)", 1.0),
        ("smoothstep(2, 2, 1)", 0.0),
        ("smoothstep(-1.7e308, 1.7e308, 0)", 0.5),
        ("smoothstep(0, 5e-324, 0)", 0.0),
        ("smoothstep(5e-324, 0, 0)", 1.0),
        ("sin(i) + cos(i) + tan(i)", math.sin(3) + math.cos(3) + math.tan(3)),
        ("degrees(radians(90))", math.degrees(math.radians(90))),
        ("[floor(1.5), ceil(1.5), floor(-0.5)]", [1, 2, -1]),
        ("[round(0.5), round(1.5), round(2.675, 2), round(17, -1)]", [0, 2, 2.67, 20]),
        ("len(point) + len(word)", 6),
        (" \n i \t", 3),
        ("(1)", 1),
    ],
)
def test_an_expression_gives_what_python_gives(expression: str, expected: Any) -> None:
    found = value(expression)
    assert found == expected
    assert type(found) is type(expected)


def test_a_scalar_that_is_one_expression_keeps_its_type_and_a_longer_one_is_text() -> None:
    assert Template.parse("${i}").evaluate(NAMES) == 3
    assert Template.parse("${i} ").evaluate(NAMES) == "3 "
    assert Template.parse("leg_${i}_${size}").evaluate(NAMES) == "leg_3_1.5"
    assert Template.parse("${flag}${word}").evaluate(NAMES) == "trueleg"
    assert Template.parse("${'}'}").evaluate({}) == "}"
    assert refused("at ${point}").message == "a list cannot be part of a longer string"


@pytest.mark.parametrize(
    ("text", "expected"),
    [("$${i}", "${i}"), ("a$${${i}", "a${3"), ("$i $", "$i $"), ("$$${i}", "$${i}"), ("$${", "${")],
)
def test_a_doubled_dollar_is_a_literal_one(text: str, expected: str) -> None:
    assert Template.parse(text).evaluate(NAMES) == expected


def test_binding_leaves_what_has_no_value_yet() -> None:
    template = Template.parse("${i * u + scene}")
    assert template.names == {"i", "u", "scene"}
    bound = template.bind({"i": 2, "unread": 1})
    assert isinstance(bound, Template)
    assert bound.names == {"u", "scene"}
    assert bound.constants == (("i", 2),)
    assert bound.bind({"u": 0.5}).bind({"scene": 1}) == 2.0
    assert bound.bind({"i": 100}) is bound
    assert bound.place("u") == (6, 7)
    assert Template.parse("${1 + 1}").bind({}) == 2


def test_templates_are_equal_by_text_and_constants_to_the_bit() -> None:
    template = Template.parse("${a + b}")
    assert template.bind({"a": 1}) == Template("${a + b}", {"a": 1})
    assert hash(template.bind({"a": 1})) == hash(Template("${a + b}", {"a": 1}))
    for other in (1.0, True, 2):
        assert template.bind({"a": 1}) != Template("${a + b}", {"a": other})
    assert template.bind({"a": 0.0}) != template.bind({"a": -0.0})
    assert Template("${a[0]}", {"a": ((1, 2), "x")}) == Template("${a[0]}", {"a": [[1, 2], "x"]})
    with pytest.raises(AttributeError, match="read-only"):
        template.text = ""
    bound = template.bind({"a": 1})
    assert pickle.loads(pickle.dumps(bound)) == copy.deepcopy(bound) == bound


@pytest.mark.parametrize(
    ("text", "marked", "message"),
    [
        ("a ${1 + lenght}", "lenght", "unknown name `lenght`"),
        ("${'é' + nme}", "nme", "unknown name `nme`"),
        ("${i / (i - 3)}", "i / (i - 3)", "division by zero"),
        ("${1 + 5 % 0}", "5 % 0", "division by zero"),
        ("${sqrt(-1)}", "sqrt(-1)", "`sqrt` is not defined for -1"),
        ("${(-8) ** (1 / 3)}", "(-8) ** (1 / 3)", "a negative number cannot have a fractional exponent"),
        ("${0 ** -1}", "0 ** -1", "0 cannot have a negative exponent"),
        ("${word + 1}", "word + 1", "`+` does not take a string and a number"),
        ("${flag + 1}", "flag + 1", "`+` does not take a boolean and a number"),
        ("${-flag}", "-flag", "`-` does not take a boolean"),
        ("${word % 2}", "word % 2", "`%` does not take a string and a number"),
        ("${point * 1.5}", "point * 1.5", "`*` does not take a list and a number"),
        ("${word < 1}", "word < 1", "`<` does not take a string and a number"),
        ("${word == 1}", "word == 1", "`==` does not take a string and a number"),
        ("${point[3]}", "point[3]", "index 3 is out of range: the list has 3 items"),
        ("${point[1.0]}", "point[1.0]", "an index is an integer, not 1.0"),
        ("${i[0]}", "i[0]", "a number has no items"),
        ("${1 if word else 2}", "word", "a condition is a boolean or a number, not a string"),
        ("${not point}", "point", "a condition is a boolean or a number, not a list"),
        ("${sin(word)}", "sin(word)", "`sin` takes numbers, not a string"),
        ("${len(1)}", "len(1)", "`len` takes a list or a string, not a number"),
        ("${max([])}", "max([])", "`max` needs at least one number"),
        ("${min(word)}", "min(word)", "`min` takes numbers or one list of numbers, not a string"),
        ("${round(1, 99)}", "round(1, 99)", "`round` takes -30 to 30 digits"),
        ("${1e308 * 10}", "1e308 * 10", "the result is not a finite number"),
        ("${floor(1e300)}", "floor(1e300)", "the integer has more than 256 bits"),
        ("${1e999}", "1e999", "the result is not a finite number"),
        ("${sin(1, 2)}", "sin(1, 2)", "`sin` takes 1 argument, not 2"),
        ("${min()}", "min()", "`min` takes at least 1 argument, not 0"),
        ("${round()}", "round()", "`round` takes 1 to 2 arguments, not 0"),
        ("${sine(1)}", "sine", "unknown function `sine`"),
        ("${max}", "max", "`max` is a function: write `max(…)`"),
        ("${1, 2}", "1, 2", "a list is written in brackets: [a, b]"),
        ("${1 +}", "}", "invalid expression"),
        ("${ }", "${ }", "the expression is empty"),
        ("a ${i", "${", "`${` is never closed"),
        ("${(i}", "(", "this bracket is never closed"),
        ("${i)}", ")", "`)` has no opening bracket"),
        ("${[i)}", ")", "`)` has no opening bracket"),
        ("${'a}", "'", "this string cannot be read"),
        ("${i = 3}", "=", "a comparison is written `==`"),
        ("${point.x}", ".", "attributes are not allowed in an expression"),
        ("${point[1:2]}", ":", "neither slices nor `:=` are allowed in an expression"),
        ("${point[1, 2]}", "1, 2", "a list is written in brackets: [a, b]"),
        ("${None}", "None", "`None` is not allowed in an expression"),
        ("${i in point}", "in", "`in` is not allowed in an expression"),
        ("${i & 1}", "&", "`&` is not allowed in an expression"),
        ("${012}", "012", "a number is written without leading zeros"),
        ("${0x10}", "x10", "invalid number"),
        ("${1_000}", "_000", "invalid number"),
        ("${2pi}", "pi", "invalid number"),
        ("${1.2.3}", ".3", "invalid number"),
        ("${'a' 'b'}", "'b'", "two strings side by side"),
        ("${f'a'}", "'a'", "strings cannot have a prefix"),
        ("${i # note}", "#", "comments are not allowed in an expression"),
    ],
)
def test_what_has_no_value_is_an_error_at_its_place(text: str, marked: str, message: str) -> None:
    error = refused(text)
    assert error.message == message
    found = text[error.start : error.end]
    assert found == marked or (marked == "}" and error.start == text.index("}"))


def test_an_expression_without_its_end_says_how_to_end_it() -> None:
    assert refused("a ${i").hint == "close it with `}`; write `$${` for the characters themselves"


def test_errors_suggest_near_names() -> None:
    assert refused("${sizze}").hint == "did you mean `size`?"
    assert refused("${floow(1)}").hint == "did you mean `floor`?"


def test_every_function_is_reserved_and_python_does_not_read_more() -> None:
    assert FUNCTIONS.keys() <= RESERVED_NAMES
    assert {"pi", "true", "scene", "num_scenes", "and"} <= RESERVED_NAMES


LITERALS = st.one_of(st.integers(-50, 50), st.floats(-1e3, 1e3).map(lambda x: round(x, 6))).map(
    lambda number: f"({number!r})" if number < 0 else repr(number)
)
ARITHMETIC = st.recursive(
    LITERALS,
    lambda parts: st.one_of(
        st.tuples(parts, st.sampled_from(["+", "-", "*", "/", "//", "%"]), parts).map(lambda p: f"({' '.join(p)})"),
        st.tuples(parts, st.sampled_from(["<", "<=", "=="]), parts, parts, parts).map(
            lambda p: f"({p[3]} if {p[0]} {p[1]} {p[2]} else {p[4]})"
        ),
        st.tuples(parts, st.integers(-3, 5)).map(lambda p: f"({p[0]} ** {p[1]})"),
        parts.map(lambda part: f"abs({part})"),
        st.tuples(parts, parts).map(lambda p: f"max({p[0]}, {p[1]})"),
    ),
    max_leaves=12,
)


@given(ARITHMETIC)
def test_arithmetic_is_pythons_to_the_bit(expression: str) -> None:
    try:
        expected = eval(expression)  # of numbers that this test wrote
    except ZeroDivisionError:
        assert refused("${" + expression + "}").message in {"division by zero", "0 cannot have a negative exponent"}
        return
    except OverflowError:
        assert "finite" in refused("${" + expression + "}").message
        return
    if isinstance(expected, int) and expected.bit_length() > 256:
        return
    assert repr(value(expression)) == repr(expected)


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
    assert_took(time.process_time() - begun, most=1)
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
    assert fits(found, 2 * MAX_SIZE + len(expression))


@given(st.text(max_size=60).flatmap(lambda text: st.sampled_from([text, "${" + text + "}"])))
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        Template.parse(text).evaluate({})
    except ExpressionError as error:
        assert 0 <= error.start <= error.end <= len(text)  # noqa: PT017 - its place is what is tested


@pytest.mark.parametrize("text", ["${'" + "a" * 1001, "${'" + "a" * 2000 + "'}"])
def test_a_text_that_goes_on_beyond_the_length_is_told_to_be_too_long(text: str) -> None:
    with pytest.raises(ExpressionError, match="an expression has at most 1000 characters"):
        Template.parse(text)
