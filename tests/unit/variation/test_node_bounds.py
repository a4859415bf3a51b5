"""The bounds of values: exact for plain forms, those of the samples for expressions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from scenecc.variation.bounds import UNKNOWN, ValueBounds, union_bounds
from scenecc.variation.evaluation import Batch
from scenecc.variation.forms import Template
from scenecc.variation.node_bounds import BoundsAnalysis
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
from scenecc.variation.operations import ExpressionError, Function
from scenecc.variation.samples import SAMPLE_COUNT, SampleBatch, sample_of

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


def find_bounds(node: Node, draws: dict[str, Node], *, num_scenes: int = 40) -> ValueBounds:
    return BoundsAnalysis(draws, num_scenes).bounds(node)


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
        (Radians(Cycled((0, 180))), (0.0, math.pi)),
        (Cycled((0, Cycled((1, 2)))), (0, 1, 2)),
        (Stacked((Chosen((1, 2), None, key("a")), 5)), ((1, 5), (2, 5))),
    ],
)
def test_alternatives_that_are_few_are_all_known(node: Node, expected: tuple[Any, ...]) -> None:
    found = of(node)
    assert found.exact
    assert found.alternatives is not None
    assert sorted(map(repr, found.alternatives)) == sorted(map(repr, expected))


@pytest.mark.parametrize(
    ("node", "expected"),
    [
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
        (expression("scene + (0 if even else 10)"), tuple(i + 10 * (i % 2) for i in range(40))),
    ],
)
def test_values_that_depend_on_each_other_are_those_of_the_samples(node: Node, expected: tuple[Any, ...]) -> None:
    found = of(node)
    assert not found.exact
    assert sorted(map(repr, found.alternatives or ())) == sorted(map(repr, expected))


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
        (Drawn("uniform", (Shared("c"), Shared("double")), (), key("p")), 1, 8, False),
        (RandomRotated(key("q")), (-1.0,) * 4, (1.0,) * 4, True),
        (Stacked((Drawn("uniform", (0, 1), (), key("p")), Shared("c"), 5)), (0, 1, 5), (1, 4, 5), True),
        (Chosen((5, Shared("u")), None, key("p")), 0, 5, True),
        (Posed(Shared("v3"), IDENTITY), (0, 0, 0, *IDENTITY), (1, 1, 1, *IDENTITY), True),
        (
            Composed((1, 2, 3, *IDENTITY), Posed(Shared("v3"), IDENTITY)),
            (1, 2, 3, *IDENTITY),
            (2, 3, 4, *IDENTITY),
            True,
        ),
        (Radians(Drawn("uniform", (0, 180), (), key("p"))), 0.0, math.pi, True),
    ],
)
def test_bounds_of_plain_forms(node: Node, low: Any, high: Any, exact: bool) -> None:
    draws = {**DRAWS, "v3": Drawn("uniform", (0, 1), (3,), key("p"))}
    found = find_bounds(node, draws)
    assert (found.low, found.high, found.exact) == (low, high, exact)


@pytest.mark.parametrize("text", ["u - 0.5*u", "u * u - u + 1", "sqrt(u)", "n if n > 0 else 1", "sin(u)", "big // 10"])
def test_bounds_of_an_expression_are_those_of_256_draws(text: str) -> None:
    node = expression(text)
    found = of(node, num_scenes=40)
    rows = [
        Batch(np.array([scene]), seed, 40, DRAWS, {}).evaluate(node).tolist()[0]
        for scene, seed in (sample_of(number, range(40)) for number in range(SAMPLE_COUNT))
    ]
    assert (found.low, found.high, found.exact) == (min(rows), max(rows), False)


def test_texts_are_known_where_they_are_few() -> None:
    found = of(expression("'a.obj' if u < 0.5 else 'b.obj'"))
    assert sorted(found.alternatives or ()) == ["a.obj", "b.obj"]
    assert not found.exact
    assert of(expression("'a.obj' if u < 2 else 'b.obj'")).alternatives == ("a.obj",)
    assert of(Computed(Template.parse("${u}.obj"), ())).alternatives is None


def test_what_has_no_value_in_a_sample_is_unknown() -> None:
    assert of(expression("1 / (c - 2)")) == UNKNOWN


@pytest.mark.parametrize(("count", "last"), [(1, (0, 255)), (40, (15, 6)), (256, (255, 0)), (1000, (996, 0))])
def test_samples_are_fixed_scenes_and_seeds(count: int, last: tuple[int, int]) -> None:
    batch = SampleBatch(tuple(range(count)), count, DRAWS, None)
    assert sample_of(SAMPLE_COUNT - 1, range(count)) == last
    seeds = batch.seed if isinstance(batch.seed, tuple) else (batch.seed,) * SAMPLE_COUNT
    assert [*zip(batch.scenes.tolist(), seeds, strict=True)] == [
        sample_of(i, range(count)) for i in range(SAMPLE_COUNT)
    ]


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
def test_samples_are_within_the_bounds(node: Node) -> None:
    draws = {**DRAWS, "p": Drawn("uniform", ((-1, -1, 0), (1, 1, 2)), (3,), key("p"))}
    analysis = BoundsAnalysis(draws, 300)
    found, rows = analysis.bounds(node), analysis.samples.evaluate(node)
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


def test_one_expression_is_sampled_once_for_each_of_its_readers() -> None:
    template = Template.parse("${a * 2}")
    draws: dict[str, Node] = {"x/a": Drawn("uniform", (1, 2), (), key("x")), "y/a": Chosen((1, 3), None, key("y"))}
    samples = BoundsAnalysis(draws, 1).samples
    found = [samples.evaluate(Computed(template, (), (("a", name),))) for name in ("x/a", "y/a", "x/a")]
    assert 2 <= found[0].min() < found[0].max() <= 4
    assert set(found[1].tolist()) == {2, 6}
    assert found[2] is found[0]


def test_a_function_of_expressions_is_one_row(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ROWS, "dist", Function(lambda arguments, _: math.dist([0, 0], arguments), most=2, fewest=2))
    assert Template("${dist(3, 4)}").evaluate({}) == 5
    draws: dict[str, Node] = {"u": Drawn("uniform", (-3.0, 2.0), (), key("u"))}
    assert (
        4 <= find_bounds(expression("dist(u, 4)"), draws).low <= find_bounds(expression("dist(u, 4)"), draws).high <= 5
    )
    with pytest.raises(ExpressionError, match="`dist` takes 2 arguments, not 1"):
        Template("${dist(3)}")
