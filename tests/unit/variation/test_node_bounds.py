"""What a value can be, without drawing: exact where that is known, and never less than what is drawn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from scenecc.variation.bounds import UNKNOWN, ValueBounds, union_bounds
from scenecc.variation.evaluation import Batch
from scenecc.variation.forms import Template
from scenecc.variation.node_bounds import BoundsAnalysis, bounds_and_faults, find_bounds
from scenecc.variation.nodes import (
    Chosen,
    Composed,
    Computed,
    Const,
    Cycled,
    Drawn,
    FromAxisAngle,
    FromRpy,
    Key,
    Looking,
    Node,
    Pointing,
    Posed,
    Radians,
    RandomRotated,
    Rows,
    Shared,
    Stacked,
)
from scenecc.variation.operations import FUNCTIONS as ROWS
from scenecc.variation.operations import DrawError, ExpressionError, Function

INF = math.inf
IDENTITY = (1.0, 0.0, 0.0, 0.0)


def key(path: str) -> Key:
    return Key("entities", "cube", path)


def expression(text: str, shape: tuple[int, ...] | None = (), **reads: str) -> Computed:
    return Computed(Template.parse("${" + text + "}"), shape, tuple(reads.items()))


DRAWS: dict[str, Node] = {
    "u": Drawn("uniform", (0, 1), (), Key("draws", "u", "")),
    "v": Drawn("uniform", ((1, -2), (2, 2)), (2,), Key("draws", "v", "")),
    "n": Drawn("normal", (0, 1), (), Key("draws", "n", "")),
    "c": Chosen((1, 2, 4), None, Key("draws", "c", "")),
    "die": Drawn("integers", (1, 6), (), Key("draws", "die", "")),
    "big": Drawn("integers", (1, 1000), (), Key("draws", "big", "")),
    "word": Chosen(("a", "b"), None, Key("draws", "word", "")),
    "even": Cycled((True, False)),
    "double": expression("c * 2"),
    "far": expression("u * 2 + 3"),
}


def of(node: Node, **kwargs: Any) -> ValueBounds:
    return find_bounds(node, DRAWS, **kwargs)


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        (Const(2.5), (2.5,)),
        (Const((1, 2)), ((1, 2),)),
        (Const("a.obj"), ("a.obj",)),
        (Rows((0, 1, 5), (3, 4, 3)), (3, 4)),
        (Cycled((True, 1, 1.0)), (True, 1, 1.0)),
        (Chosen(("a", "b", "c"), (1, 0, 1), key("file")), ("a", "c")),
        (Chosen((1, Cycled((2, 3))), None, key("mass")), (1, 2, 3)),
        (Drawn("uniform", (2, 2), (), key("mass")), (2,)),
        (Drawn("integers", (1, 4), (), key("mass")), (1, 2, 3, 4)),
        (Shared("double"), (2, 4, 8)),
        (expression("[c, c, c * c]", (3,)), ((1.0, 1.0, 1.0), (2.0, 2.0, 4.0), (4.0, 4.0, 16.0))),
        (Stacked((Shared("c"), Shared("c"), 0.5)), ((1.0, 1.0, 0.5), (2.0, 2.0, 0.5), (4.0, 4.0, 0.5))),
        (Stacked((Cycled((1, 2)), Cycled((3, 4)))), ((1, 3), (2, 4))),
        (expression("c - d", d="double"), (-1, -2, -4)),
        (
            Computed(Template.parse("${word}_${c}.obj"), ()),
            ("a_1.obj", "b_1.obj", "a_2.obj", "b_2.obj", "a_4.obj", "b_4.obj"),
        ),
        (expression("1 if die > 4 else 0"), (0, 1)),
        (expression("[10, 20, 30][die - 1] if die <= 3 else 0"), (10, 20, 30, 0)),
        (Radians(Cycled((0, 180))), (0.0, math.pi)),
        (Cycled((0, Cycled((1, 2)))), (0, 1, 2)),
    ],
)
def test_alternatives_that_are_few_are_all_known(node: Node, expected: tuple[Any, ...]) -> None:
    found = of(node)
    assert found.exact
    assert found.alternatives is not None
    assert sorted(map(repr, found.alternatives)) == sorted(map(repr, expected))


@pytest.mark.parametrize(
    ("node", "low", "high", "exact"),
    [
        (Drawn("uniform", ((0, 1), 2), (2,), key("p")), (0, 1), (2, 2), True),
        (Drawn("log_uniform", (0.1, 2), (), key("p")), 0.1, 2, True),
        (Drawn("integers", (0, 100), (), key("p")), 0, 100, True),
        (Drawn("integers", ((0, 0), (1, 2)), (2,), key("p")), (0, 0), (1, 2), True),
        (Drawn("normal", (0, 1), (), key("p")), -INF, INF, True),
        (Drawn("normal", ((5, 1), (0, 1)), (2,), key("p")), (5, -INF), (5, INF), True),
        (Drawn("normal", (0, 1, 0.5, 2), (), key("p")), 0.5, 2, True),
        (Drawn("normal", (9, 0, 0.5, 2), (), key("p")), 2, 2, True),
        (Drawn("uniform", (Shared("c"), Shared("double")), (), key("p")), 1, 8, True),
        (Drawn("uniform", (expression("u - 1"), 3), (), key("p")), -1, 3, True),
        (RandomRotated(key("q")), (-1.0,) * 4, (1.0,) * 4, True),
        (Stacked((Shared("u"), Shared("c"), 5)), (0, 1, 5), (1, 4, 5), True),
        (Chosen((5, Shared("u")), None, key("p")), 0, 5, True),
        (Posed(Shared("v3"), IDENTITY), (0, 0, 0, *IDENTITY), (1, 1, 1, *IDENTITY), True),
        (
            Composed((1, 2, 3, *IDENTITY), Posed(Shared("v3"), IDENTITY)),
            (1, 2, 3, *IDENTITY),
            (2, 3, 4, *IDENTITY),
            True,
        ),
        (FromRpy(Stacked((0, 0, Shared("u")))), (-1.0,) * 4, (1.0,) * 4, False),
        (Radians(Drawn("uniform", (0, 180), (), key("p"))), 0.0, math.pi, True),
        (expression("u"), 0, 1, True),
        (expression("-2 * u + 3"), 1, 3, True),
        (expression("far"), 3, 5, True),
        (expression("u + u"), 0, 2, False),
        (expression("u - n"), -INF, INF, False),
        (expression("u * c"), 0, 4, False),
        (expression("1 / (1 + u)"), 0.5, 1, True),
        (expression("1 / u"), -INF, INF, False),
        (expression("big // 10"), 0, 100, False),
        (expression("big % 7"), 0, 6, False),
        (expression("-big % 7"), 0, 6, False),
        (expression("big % -7"), -6, 0, False),
        (expression("scene % 2"), 0, 1, False),
        (expression("(big - 500) // 7"), -72, 71, False),
        (expression("u % 0.5"), 0, 0.5, False),
        (expression("(u - 0.5) * (u - 0.5)"), 0, 0.25, True),
        (expression("sqrt(1 - u * u)"), 0, 1, False),
        (expression("n * n"), 0, INF, True),
        (expression("n + 1 if n > 0 else 1"), 1, INF, False),
        (expression("n if 0 <= n and n <= 3 else 0"), 0, 3, False),
        (expression("n if 0 <= n <= 3 else 0"), 0, 3, False),
        (expression("0 if n < 0 or n > 3 else n"), 0, 3, False),
        (expression("n if not (n < 0) else -n"), 0, INF, False),
        (expression("sqrt(n - 2) if n - 2 >= 0 else 0"), 0, INF, False),
        (expression("1 / (big - 7) if big > 7 else 2"), 1 / 993, 2, False),
        (expression("v[1] if v[1] > 0 else 1"), 5e-324, 2, False),
        (expression("(u - 0.5) ** 2"), 0, 0.25, False),
        (expression("u ** 0.5"), 0, 1, False),
        (expression("2 ** u"), 1, 2, False),
        (expression("abs(u - 0.25)"), 0, 0.75, False),
        (expression("sqrt(u - 0.5)"), 0, math.sqrt(0.5), False),
        (expression("min(u, 0.25)"), 0, 0.25, False),
        (expression("max([u, 0.25, c])"), 1, 4, False),
        (expression("floor(u * 10)"), 0, 10, False),
        (expression("sin(u)"), 0, math.sin(1), False),
        (expression("cos(4 * u)"), -1, 1, False),
        (expression("tan(u)"), 0, math.tan(1), False),
        (expression("tan(u - 1)"), math.tan(-1), 0, False),
        (expression("tan(2 * u)"), -INF, INF, False),
        (expression("tan(1 / (u + 1e-9))"), -INF, INF, False),
        (expression("tan(n)"), -INF, INF, False),
        (expression("+far"), 3, 5, True),
        (expression("round(u * 3)"), 0, 3, False),
        (expression("round(u, 1)"), -0.1, 1.1, False),
        (expression("atan2(u, 1)"), -math.pi, math.pi, False),
        (expression("hypot(3 * u, 4)"), 4.0, 5.0, False),
        (expression("hypot(u - 2, 0, 0)"), 1.0, 2.0, False),
        (expression("smoothstep(0, 2, u)"), 0.0, 0.5 * (1 + 1e-15), False),
        (expression("smoothstep(2, 0, u)"), 0.5 * (1 - 1e-15), 1.0, False),
        (expression("smoothstep(u, 2, 1)"), 0.0, 1.0, False),
        (expression("degrees(u)"), 0, math.degrees(1), False),
        (expression("v[1] + v[0]"), -1, 4, False),
        (expression("[u, 1]", (2,)), (0, 1), (1, 1), True),
        (expression("([u] + [c])[1] + u"), 1, 5, False),
        (expression("u if u < 2 else -100"), 0, 1, True),
        (expression("c + u if c > 1 else 3"), 2, 5, False),
        (expression("u if u < 0.5 else 7"), 0, 7, False),
        (expression("5 if u > n else c + 0.5"), 1.5, 5, False),
        (expression("u and 3"), 0, 3, False),
        (expression("scene"), 0, INF, False),
        (expression("num_scenes"), 1, INF, False),
    ],
)
def test_bounds(node: Node, low: Any, high: Any, exact: bool) -> None:
    draws = {**DRAWS, "v3": Drawn("uniform", (0, 1), (3,), key("p"))}
    found = find_bounds(node, draws)
    assert (found.low, found.high, found.exact) == (low, high, exact)


def test_texts_that_depend_on_a_continuous_draw_are_known() -> None:
    found = of(expression("'a.obj' if u < 0.5 else 'b.obj'"))
    assert found.alternatives == ("a.obj", "b.obj")
    assert not found.exact
    assert of(expression("'a.obj' if u < 2 else 'b.obj'")).alternatives == ("a.obj",)
    assert of(Computed(Template.parse("${u}.obj"), ())) == UNKNOWN


def test_what_is_known_of_the_scenes_counts() -> None:
    assert of(expression("scene"), num_scenes=4).alternatives == (0, 1, 2, 3)
    assert of(expression("scene / num_scenes"), num_scenes=1000).high == 0.999
    assert of(expression("scene + (0 if even else 10)"), num_scenes=4).alternatives == (0, 11, 2, 13)
    found = of(expression("u + c"), given={"u": np.array([5.0, 6.0, 7.0])})
    assert (found.low, found.high) == (6.0, 11.0)


def test_many_combinations_are_bounded_instead() -> None:
    found = of(expression("die + big"))
    assert found.alternatives is None
    assert (found.low, found.high) == (2, 1006)
    many = of(expression("x + c", x="rows"), given={"rows": np.arange(1000)})
    assert (many.low, many.high, many.alternatives) == (1, 1003, None)
    assert len(of(Rows(tuple(range(500)), tuple(range(500)))).alternatives or ()) == 500


def test_64_combinations_and_16_draws_are_looked_at_and_no_more() -> None:
    assert of(expression("scene"), num_scenes=64).alternatives == tuple(range(64))
    assert of(expression("scene"), num_scenes=65).alternatives is None
    chain: dict[str, Node] = {"d1": DRAWS["c"]} | {f"d{i}": expression(f"d{i - 1} + 1") for i in range(2, 18)}
    assert find_bounds(expression("d16 - d16"), chain).alternatives == (0,)
    assert find_bounds(expression("d17 - d17"), chain).alternatives != (0,)


def test_an_alternative_that_has_no_value_leaves_the_others() -> None:
    assert set(of(expression("1 / (c - 2)")).alternatives or ()) == {-1.0, 0.5}


def test_numbers_are_row_by_row() -> None:
    assert ValueBounds.of([(1, 2), (3, 4)]).numbers() == (1, 2, 3, 4)
    assert ValueBounds(None, (0, 1), (2, 3), exact=True).numbers() == (0, 1, 2, 3)
    assert ValueBounds.of(["a"]).numbers() == ()
    assert UNKNOWN.numbers() == ()
    assert ValueBounds.of_rows(np.array([[1.5, 2.0], [1.5, 2.0]])) == ValueBounds(
        ((1.5, 2.0),), (1.5, 2.0), (1.5, 2.0), exact=True
    )


def test_unions_widen() -> None:
    assert union_bounds([ValueBounds.of([1]), ValueBounds.of([2])]) == ValueBounds.of([1, 2])
    assert union_bounds([ValueBounds.of([1]), ValueBounds(None, 3, 4, exact=False)]) == ValueBounds(
        None, 1, 4, exact=False
    )
    assert union_bounds([ValueBounds.of([1]), ValueBounds.of(["a"])]).numbers() == (1,)
    assert union_bounds([ValueBounds.of([(1, 2)]), ValueBounds(None, 3, 4, exact=True)]) == UNKNOWN
    assert union_bounds([ValueBounds.of([1]), UNKNOWN]) == UNKNOWN


NAMES = st.sampled_from(["u", "n", "c", "die", "big", "double", "far", "v[0]", "v[1]", "scene", "num_scenes"])
FUNCTIONS = st.sampled_from(["abs", "floor", "ceil", "round", "sqrt", "sin", "cos", "tan", "radians"])
PARTS = st.recursive(
    st.one_of(NAMES, st.sampled_from(["0", "1", "2", "-3", "0.5", "pi", "(-0.25)"])),
    lambda parts: st.one_of(
        st.tuples(parts, st.sampled_from(["+", "-", "*", "/", "//", "%"]), parts).map(lambda p: f"({' '.join(p)})"),
        st.tuples(parts, st.sampled_from(["2", "3", "0.5", "-1", "0"])).map(lambda p: f"({p[0]} ** {p[1]})"),
        st.tuples(parts, st.sampled_from(["<", ">=", "==", "!="]), parts, parts, parts).map(
            lambda p: f"({p[3]} if {p[0]} {p[1]} {p[2]} else {p[4]})"
        ),
        st.tuples(parts, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), parts).map(
            lambda p: f"(1 / {p[0]} + {p[2]} if {p[0]} {p[1]} {p[2]} else {p[0]} * {p[0]} - sqrt({p[2]}))"
        ),
        st.tuples(NAMES, NAMES, st.sampled_from(["and", "or"]), st.sampled_from(["0", "1", "2.5"])).map(
            lambda p: f"({p[0]} - {p[1]} if {p[0]} > {p[3]} {p[2]} {p[1]} <= {p[0]} else {p[1]} / {p[0]})"
        ),
        st.tuples(parts, st.sampled_from(["and", "or"]), parts).map(lambda p: f"({' '.join(p)})"),
        st.tuples(FUNCTIONS, parts).map(lambda p: f"{p[0]}({p[1]})"),
        st.tuples(parts, parts, parts).map(lambda p: f"[{p[0]}, {p[1]}][0 if {p[2]} else 1]"),
        st.tuples(parts, parts).map(lambda p: f"min({p[0]}, {p[1]})"),
    ),
    max_leaves=10,
).filter(lambda text: len(text) < 1000)


@given(PARTS, st.integers(0, 1000), st.sampled_from([None, 40]))
def test_what_is_drawn_is_never_outside_the_support(text: str, seed: int, num_scenes: int | None) -> None:
    node = expression(text)
    found = find_bounds(node, DRAWS, num_scenes=num_scenes)
    for scene in range(0, 40, 3):
        try:
            value = Batch(np.array([scene]), seed, 40, DRAWS, {}).evaluate(node).tolist()[0]
        except DrawError:
            continue
        if found.alternatives is not None:
            assert value in found.alternatives
        elif found.low is not None:
            assert found.low <= value <= found.high


BEYOND = ("finite", "bits", "64")


def failure(node: Node, scene: int, seed: int) -> str | None:
    """Why a node has no value in a scene; None where it has one."""
    try:
        Batch(np.array([scene]), seed, 40, DRAWS, {}).evaluate(node)
    except DrawError as error:
        return error.message
    return None


@given(PARTS, st.integers(0, 1000))
def test_what_has_no_value_is_foretold(text: str, seed: int) -> None:
    node = expression(text)
    _, faults = bounds_and_faults(BoundsAnalysis(DRAWS, {}, 40), node)
    for scene in range(0, 40, 3):
        message = failure(node, scene, seed)
        if message is None:
            assert not any(fault.certain for fault in faults)
        elif not any(word in message for word in BEYOND):
            # Of numbers that grow too large nothing is said.
            assert faults


@pytest.mark.parametrize(
    ("text", "message", "certain"),
    [
        ("1 / u", "division by zero", False),
        ("1 + 1 / (big - 7)", "division by zero", False),
        ("1 % (u * 0)", "division by zero", True),
        ("sqrt(u - 0.5)", "a negative number has no square root", False),
        ("sqrt(u - 2)", "a negative number has no square root", True),
        ("u if u > n else sqrt(u - 2)", "a negative number has no square root", False),
        ("u ** -1", "0 cannot have a negative exponent", False),
        ("n ** 0.5", "a negative number cannot have a fractional exponent", False),
        ("[u, n][die - 1]", "an index is out of range: the list has 2 items", False),
        ("'a' + c", "`+` does not take a string and a number", True),
    ],
)
def test_why_there_may_be_no_value(text: str, message: str, certain: bool) -> None:
    _, faults = bounds_and_faults(BoundsAnalysis(DRAWS, {}, None), expression(text))
    assert [(fault.message, fault.certain) for fault in faults] == [(message, certain)]


@pytest.mark.parametrize(
    "text",
    [
        "1 / u if u != 0 else 1",
        "1 / n if n > 0 else 1",
        "1 / n if n else 1",
        "n == 0 or 1 / n > 2",
        "big / (big % 7) if big % 7 else 0",
        "sqrt(n) if n >= 0 else sqrt(-n)",
        "1 / (1 + u)",
        "sqrt(1 - u * u)",
    ],
)
def test_what_a_condition_keeps_away_is_no_fault(text: str) -> None:
    assert bounds_and_faults(BoundsAnalysis(DRAWS, {}, None), expression(text))[1] == []


@pytest.mark.parametrize(
    "node",
    [
        Posed(Shared("p"), FromRpy(Stacked((0, Shared("u"), 1)))),
        Composed(Posed(Shared("p"), RandomRotated(key("q"))), Posed(Stacked((Shared("u"), 2, -1)), IDENTITY)),
        Composed((1, 2, 3, *IDENTITY), Posed(Shared("p"), FromAxisAngle((1, 1, 0), Shared("u")))),
        Posed((0, 0, 0), Looking(Stacked((5, Shared("u"), 0)), Shared("p"))),
        Drawn("normal", (Shared("u"), 2, -1, expression("u + 1")), (), key("n")),
        Posed((0, 0, 0), Pointing(Stacked((-1, Shared("u"), 2)))),
        Stacked((Chosen((0.5, Shared("u")), None, key("x")), Cycled((1, 2)))),
    ],
    ids=["posed", "composed", "shifted", "looking", "normal", "pointing", "stacked"],
)
def test_drawn_rows_are_within_the_bounds(node: Node) -> None:
    draws = {**DRAWS, "p": Drawn("uniform", ((-1, -1, 0), (1, 1, 2)), (3,), key("p"))}
    found = find_bounds(node, draws)
    rows = Batch(np.arange(300), 5, 300, draws, {}).evaluate(node)
    assert (rows >= np.array(found.low) - 1e-12).all()
    assert (rows <= np.array(found.high) + 1e-12).all()


@pytest.mark.parametrize("kind", ["uniform", "log_uniform", "integers", "normal"])
@pytest.mark.parametrize(
    ("low", "high", "shape"),
    [
        (1.0, 2.0, ()),
        (1, 2.5, ()),
        (-0.0, 0.0, ()),
        (1.5, 1.5, (3,)),
        (1.0, 2.0, (3,)),
        ((0.5, 1.0, 2.0), (0.5, 1.0, 2.5), (3,)),
        ((0.5, 1.0), 4.0, (2,)),
        ((1.0, 2.0), (3.0, 4.0), (3,)),
        ((1.0, 2.0), (3.0, 4.0), ()),
        ((1.0, True), (3.0, 4.0), (2,)),
    ],
)
def test_plain_bounds_are_bounds_like_any_other(kind: Any, low: Any, high: Any, shape: tuple[int, ...]) -> None:
    plain = Drawn(kind, (low, high), shape, key("a"))
    wrapped = Drawn(kind, (Const(low), Const(high)), shape, key("a"))
    assert repr(of(plain)) == repr(of(wrapped))


def test_one_expression_is_looked_into_once_for_each_of_its_readers() -> None:
    template = Template.parse("${a * 2}")
    draws: dict[str, Node] = {"x/a": Drawn("uniform", (1, 2), (), key("x")), "y/a": Chosen((1, 3), None, key("y"))}
    reader = BoundsAnalysis(draws, {}, None)
    found = [reader.bounds(Computed(template, (), (("a", name),))) for name in ("x/a", "y/a", "x/a")]
    assert (found[0].low, found[0].high) == (2, 4)
    assert found[1].alternatives == (2, 6)
    assert found[2] is found[0]


def test_a_function_of_expressions_is_one_row(monkeypatch: pytest.MonkeyPatch) -> None:
    made_up = Function(
        lambda arguments, _: math.dist([0, 0], arguments),
        lambda a, b: (0.0, math.hypot(max(map(abs, a)), max(map(abs, b)))),
        most=2,
        fewest=2,
    )
    monkeypatch.setitem(ROWS, "dist", made_up)
    assert Template("${dist(3, 4)}").evaluate({}) == 5
    draws = {"u": Drawn("uniform", (-3.0, 2.0), (), key("u"))}
    found = find_bounds(expression("dist(u, 4)"), draws)
    assert (found.low, found.high) == (0.0, 5.0)
    with pytest.raises(ExpressionError, match="`dist` takes 2 arguments, not 1"):
        Template("${dist(3)}")
